//! The paper's Figures 7 and 8 over one's own pictures, as SVG.

use super::super::svg::{Anchor, Axes, Axis, COLOURS, FAINT, GREY, Svg, WIDTH};
use super::figures::{Class, KindResult, Paper, SetResult};

/// Above the panels: title, the line below it, and a legend.
const HEAD: f64 = 88.0;
/// Height of a matrix's cell, and its width where there are few classes.
const CELL: f64 = 40.0;
/// Room for the names of the classes, left of the first matrix.
const NAMES: f64 = 146.0;
/// Between two matrices.
const GAP: f64 = 34.0;
/// Above a matrix: the kind of pictures, what set it is, and the figures.
const MATRIX_HEAD: f64 = 88.0;
/// Below it: the numbers of the answers.
const MATRIX_FOOT: f64 = 62.0;
/// A row of the orientation's panels.
const ROW: f64 = 330.0;
/// Where its panels begin and end, left and right.
const PANELS: [[f64; 2]; 2] = [[64.0, 560.0], [660.0, 1056.0]];

/// The three matrices of each kind of pictures. The darker a cell, the larger its share of its row.
pub(super) fn confusion(paper: &Paper) -> String {
    let rows = paper.classes.len() as f64;
    let row = MATRIX_HEAD + rows * CELL + MATRIX_FOOT;
    let mut svg = Svg::new(
        HEAD - 22.0 + row * paper.kinds.len() as f64,
        "Which grasp was taken for which",
        "in % of the pictures of each labelled grasp; columns: Cutkosky's numbers, or none where no hand was found; in brackets: 95 % confidence",
    );
    // Columns narrow where there are more classes than the paper's six.
    let columns = rows + 1.0;
    let cell = CELL.min((WIDTH - NAMES - 2.0 * GAP - 24.0) / 3.0 / columns);
    for (at, kind) in paper.kinds.iter().enumerate() {
        let top = HEAD - 22.0 + row * at as f64;
        svg.heading([20.0, top + 22.0], &format!("{} pictures", kind.kind));
        let matrix_top = top + MATRIX_HEAD;
        for (n, class) in paper.classes.iter().enumerate() {
            let y = matrix_top + (n as f64 + 0.5) * CELL + 4.0;
            let name = format!("{} {}", class.grasp, class.cutkosky);
            svg.text([NAMES - 8.0, y], Anchor::End, "#222", &name);
        }
        for (n, set) in kind.sets.iter().enumerate() {
            let left = NAMES + n as f64 * (columns * cell + GAP);
            matrix(&mut svg, set, &paper.classes, [left, matrix_top], cell);
        }
    }
    svg.finish()
}

fn matrix(svg: &mut Svg, set: &SetResult, classes: &[Class], [left, top]: [f64; 2], cell: f64) {
    svg.heading([left, top - 42.0], &format!("{}: {}", set.set, set.what));
    let ours = if set.n == 0 {
        "no picture".to_owned()
    } else {
        let [low, high] = set.top1_interval.map(|bound| 100.0 * bound);
        format!("{:.0} % of {} ({low:.0} to {high:.0})", 100.0 * set.top1, set.n)
    };
    svg.text([left, top - 25.0], Anchor::Start, COLOURS[0], &ours);
    let mut theirs = format!("the paper: {:.0} % of its {}", 100.0 * set.paper.top1.top1(), set.paper.top1.n);
    if let Some(human) = set.paper.human_top1 {
        theirs += &format!(", its person {:.0} %", 100.0 * human.top1());
    }
    svg.text([left, top - 9.0], Anchor::Start, GREY, &theirs);
    for (y, counts) in set.confusion.counts.iter().enumerate() {
        let n: usize = counts.iter().sum();
        for (x, count) in counts.iter().enumerate() {
            let share = *count as f64 / n.max(1) as f64;
            let corner = [left + x as f64 * cell, top + y as f64 * CELL];
            draw_cell(svg, corner, cell, share, n > 0);
        }
    }
    let bottom = top + classes.len() as f64 * CELL;
    let columns = classes.iter().map(|class| class.cutkosky.to_string()).chain(["none".to_owned()]);
    for (n, name) in columns.enumerate() {
        svg.text([left + (n as f64 + 0.5) * cell, bottom + 17.0], Anchor::Middle, FAINT, &name);
    }
    let middle = left + (classes.len() + 1) as f64 * cell / 2.0;
    svg.text([middle, bottom + 34.0], Anchor::Middle, FAINT, "answered");
}

/// White at 0, the first colour at 1; a row without pictures stays grey.
fn draw_cell(svg: &mut Svg, [x, y]: [f64; 2], width: f64, share: f64, known: bool) {
    // From white to #0072b2, the first of the colours.
    let mixed = [0.0, 114.0, 178.0].map(|full: f64| (255.0 + share * (full - 255.0)).round());
    let fill = match known {
        true => format!("rgb({},{},{})", mixed[0], mixed[1], mixed[2]),
        false => "#f2f2f2".to_owned(),
    };
    svg.element(format_args!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{CELL}\" fill=\"{fill}\" stroke=\"#d8d8d8\"/>"
    ));
    let percent = (100.0 * share).round();
    if known && percent > 0.0 {
        let ink = if share > 0.5 { "white" } else { "#222" };
        svg.text([x + width / 2.0, y + CELL / 2.0 + 4.0], Anchor::Middle, ink, &format!("{percent:.0}"));
    }
}

/// For each kind of pictures: how many lie within an error, and the mean error of each angle.
pub(super) fn orientation(paper: &Paper) -> String {
    let mut svg = Svg::new(
        HEAD + ROW * paper.kinds.len() as f64,
        "How far the answered orientation is from the labelled one",
        "left: the whole angle between the two rotations; right: angle by angle, about the camera's fixed axes x, y, z. The paper \
         does not say what its axes are",
    );
    let mut x = 20.0;
    if let Some(first) = paper.kinds.first() {
        for (set, colour) in first.sets.iter().zip(COLOURS) {
            x = svg.key([x, 68.0], colour, None, &format!("{}: {}", set.set, set.what));
        }
    }
    svg.key([x, 68.0], GREY, Some("5 4"), "the paper's X");
    for (at, kind) in paper.kinds.iter().enumerate() {
        let top = HEAD + ROW * at as f64;
        distribution(&mut svg, kind, top);
        angles(&mut svg, kind, top);
    }
    svg.finish()
}

/// Where a row's panels lie, from the bottom to the top.
fn vertical(top: f64) -> [f64; 2] {
    [top + ROW - 52.0, top + 40.0]
}

fn distribution(svg: &mut Svg, kind: &KindResult, top: f64) {
    let axes = Axes {
        x: Axis::from_zero(180.0, 30.0, "°", PANELS[0]),
        y: Axis::from_zero(100.0, 25.0, " %", vertical(top)),
    };
    axes.draw(
        svg,
        &format!("{} pictures: share within an error", kind.kind),
        "error, and each set's mean and median",
    );
    for (at, (set, colour)) in kind.sets.iter().zip(COLOURS).enumerate() {
        let errors = &set.orientation_errors_deg;
        let (Some(mean), Some(median)) = (set.orientation_error_deg.mean, set.orientation_error_deg.median)
        else {
            continue;
        };
        let mut share = 0.0;
        let mut points = vec![[axes.x.place(0.0), axes.y.place(0.0)]];
        for (n, error) in errors.iter().enumerate() {
            points.push([axes.x.place(*error), axes.y.place(share)]);
            share = 100.0 * (n + 1) as f64 / errors.len() as f64;
            points.push([axes.x.place(*error), axes.y.place(share)]);
        }
        points.push([axes.x.place(180.0), axes.y.place(share)]);
        svg.line(points, colour, None);
        let y = axes.y.place(18.0) + 17.0 * (at as f64 - 1.0);
        let text = format!("{}: mean {mean:.1}°, median {median:.1}° of {}", set.set, errors.len());
        svg.text([axes.x.place(176.0), y], Anchor::End, colour, &text);
    }
}

fn angles(svg: &mut Svg, kind: &KindResult, top: f64) {
    let published = kind.sets.iter().find_map(|set| set.paper.euler_error_deg);
    let known = kind.sets.iter().filter_map(|set| set.euler_error_deg).chain(published).flatten();
    let most = known.fold(0.0, f64::max);
    let step = [5.0, 10.0, 20.0].into_iter().find(|step| most < 6.0 * step).unwrap_or(30.0);
    // Room for a number above the highest bar.
    let high = (most / step + 0.3).ceil() * step;
    let mut axes = Axes {
        x: Axis::from_zero(3.0, 1.0, "", PANELS[1]),
        y: Axis::from_zero(high, step, "°", vertical(top)),
    };
    axes.x.ticks = ["x", "y", "z"].into_iter().zip([0.5, 1.5, 2.5]).map(|(n, at)| (at, n.into())).collect();
    axes.draw(svg, &format!("{} pictures: mean error of each angle", kind.kind), "angle");
    let width = (axes.x.place(1.0) - axes.x.place(0.0)) / 4.6;
    let ours = kind.sets.iter().zip(COLOURS).map(|(set, colour)| (set.euler_error_deg, colour, false));
    for (at, (angles, colour, theirs)) in ours.chain([(published, GREY, true)]).enumerate() {
        for (axis, angle) in angles.into_iter().flatten().enumerate() {
            let middle = axes.x.place(axis as f64 + 0.5) + (at as f64 - 1.5) * width;
            let (foot, y) = (axes.y.place(0.0), axes.y.place(angle));
            let (fill, dashes) = if theirs { ("white", "5 4") } else { (colour, "none") };
            svg.element(format_args!(
                "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{fill}\" stroke=\"{colour}\" \
                 stroke-dasharray=\"{dashes}\"/>",
                middle - width / 2.0 + 1.0,
                width - 2.0,
                foot - y,
            ));
            svg.text([middle, y - 4.0], Anchor::Middle, colour, &format!("{angle:.1}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::svg::tests::assert_inside;
    use super::super::figures::tests::some;
    use super::*;

    #[test]
    fn every_matrix_has_all_its_cells() {
        let svg = confusion(&some());
        assert_inside(&svg);
        // Two kinds, three sets, two classes by two answers and none; and the ground.
        assert_eq!(svg.matches("<rect").count(), 2 * 3 * 2 * 3 + 1);
        assert!(svg.contains("the paper: 61 % of its 36, its person 61 %") && svg.contains("67 % of 3 "));
    }

    #[test]
    fn every_set_has_a_curve_and_every_angle_a_bar() {
        let svg = orientation(&some());
        assert_inside(&svg);
        assert!(svg.contains("X'': mean 10.0°, median 10.0° of 1"));
        assert_eq!(svg.matches("<rect").count(), 2 * 3 * 4 + 1);
    }
}
