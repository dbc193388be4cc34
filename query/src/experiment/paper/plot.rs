//! The paper's Figures 7 and 8 over one's own pictures, as SVG.

use grasp_plot::{Anchor, Axis, COLOURS, Colour, FAINT, GREY, INK, Page, WHITE, WIDTH, draw};

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
/// How broad a bar is, of the room that an angle has.
const BAR: f64 = 1.0 / 4.6;
/// The lines of a matrix, and a cell of which nothing is known.
const LINES: Colour = Colour(0xd8, 0xd8, 0xd8);
const NOTHING: Colour = Colour(0xf2, 0xf2, 0xf2);

/// The three matrices of each kind of pictures. The darker a cell, the larger its share of its row.
pub(super) fn confusion(paper: &Paper) -> String {
    let rows = paper.classes.len() as f64;
    let row = MATRIX_HEAD + rows * CELL + MATRIX_FOOT;
    let height = HEAD - 22.0 + row * paper.kinds.len() as f64;
    let below = "in % of the pictures of each labelled grasp; columns: Cutkosky's numbers, or none where no hand was found or its grasp is unknown; in brackets: 95 % confidence";
    // Columns narrow where there are more classes than the paper's six.
    let columns = rows + 1.0;
    let cell = CELL.min((WIDTH - NAMES - 2.0 * GAP - 24.0) / 3.0 / columns);
    draw(height, "Which grasp was taken for which", below, |page| {
        for (at, kind) in paper.kinds.iter().enumerate() {
            let top = HEAD - 22.0 + row * at as f64;
            page.heading([20.0, top + 18.0], &format!("{} pictures", kind.kind));
            let matrix_top = top + MATRIX_HEAD;
            for (n, class) in paper.classes.iter().enumerate() {
                let at = [NAMES - 8.0, matrix_top + (n as f64 + 0.5) * CELL];
                page.text(at, Anchor::Right, INK, &format!("{} {}", class.grasp, class.cutkosky));
            }
            for (n, set) in kind.sets.iter().enumerate() {
                let left = NAMES + n as f64 * (columns * cell + GAP);
                matrix(page, set, &paper.classes, [left, matrix_top], cell);
            }
        }
    })
}

fn matrix(page: &Page<'_>, set: &SetResult, classes: &[Class], [left, top]: [f64; 2], cell: f64) {
    page.heading([left, top - 46.0], &format!("{}: {}", set.set, set.what));
    let ours = if set.n == 0 {
        "no picture".to_owned()
    } else {
        let [low, high] = set.top1_interval.map(|bound| 100.0 * bound);
        format!("{:.0} % of {} ({low:.0} to {high:.0})", 100.0 * set.top1, set.n)
    };
    page.text([left, top - 29.0], Anchor::Left, COLOURS[0], &ours);
    let mut theirs = format!("the paper: {:.0} % of its {}", 100.0 * set.paper.top1.top1(), set.paper.top1.n);
    if let Some(human) = set.paper.human_top1 {
        theirs += &format!(", its person {:.0} %", 100.0 * human.top1());
    }
    page.text([left, top - 13.0], Anchor::Left, GREY, &theirs);
    let (breadth, height) = ((classes.len() + 1) as f64 * cell, classes.len() as f64 * CELL);
    // Between the cells the ground remains.
    page.rectangle([left - 0.5, top - 0.5], [breadth + 1.0, height + 1.0], LINES);
    for (y, counts) in set.confusion.counts.iter().enumerate() {
        let n: usize = counts.iter().sum();
        for (x, count) in counts.iter().enumerate() {
            let share = *count as f64 / n.max(1) as f64;
            let corner = [left + x as f64 * cell, top + y as f64 * CELL];
            draw_cell(page, corner, cell, share, n > 0);
        }
    }
    let bottom = top + height;
    let columns = classes.iter().map(|class| class.cutkosky.to_string()).chain(["none".to_owned()]);
    for (n, name) in columns.enumerate() {
        page.text([left + (n as f64 + 0.5) * cell, bottom + 13.0], Anchor::Center, FAINT, &name);
    }
    page.text([left + breadth / 2.0, bottom + 30.0], Anchor::Center, FAINT, "answered");
}

/// White at 0, the first colour at 1; a row without pictures stays grey.
fn draw_cell(page: &Page<'_>, [x, y]: [f64; 2], width: f64, share: f64, known: bool) {
    let mixed = |full: u8| (255.0 + share * (f64::from(full) - 255.0)).round() as u8;
    let Colour(red, green, blue) = COLOURS[0];
    let fill = if known { Colour(mixed(red), mixed(green), mixed(blue)) } else { NOTHING };
    page.rectangle([x + 0.5, y + 0.5], [width - 1.0, CELL - 1.0], fill);
    let percent = (100.0 * share).round();
    if known && percent > 0.0 {
        let ink = if share > 0.5 { WHITE } else { INK };
        page.text([x + width / 2.0, y + CELL / 2.0], Anchor::Center, ink, &format!("{percent:.0}"));
    }
}

/// For each kind of pictures: how many lie within an error, and the mean error of each angle.
pub(super) fn orientation(paper: &Paper) -> String {
    let title = "How far the answered orientation is from the labelled one";
    let below = "left: the whole angle between the two rotations; right: angle by angle, about the camera's fixed axes x, y, z. The paper \
         does not say what its axes are";
    draw(HEAD + ROW * paper.kinds.len() as f64, title, below, |page| {
        let mut x = 20.0;
        if let Some(first) = paper.kinds.first() {
            for (set, colour) in first.sets.iter().zip(COLOURS) {
                x = page.key([x, 68.0], colour, false, &format!("{}: {}", set.set, set.what));
            }
        }
        page.key([x, 68.0], GREY, true, "the paper's X");
        for (at, kind) in paper.kinds.iter().enumerate() {
            let top = HEAD + ROW * at as f64;
            distribution(page, kind, [top + ROW - 52.0, top + 40.0]);
            angles(page, kind, [top + ROW - 52.0, top + 40.0]);
        }
    })
}

fn distribution(page: &Page<'_>, kind: &KindResult, vertical: [f64; 2]) {
    let title = format!("{} pictures: share within an error", kind.kind);
    let axes = [Axis::from_zero(180.0, 30.0, "°"), Axis::from_zero(100.0, 25.0, " %")];
    let chart = page.chart(PANELS[0], vertical, &title, "error, and each set's mean and median", axes);
    for (at, (set, colour)) in kind.sets.iter().zip(COLOURS).enumerate() {
        let errors = &set.orientation_errors_deg;
        let (Some(mean), Some(median)) = (set.orientation_error_deg.mean, set.orientation_error_deg.median)
        else {
            continue;
        };
        chart.shares(errors, 180.0, colour);
        let text = format!("{}: mean {mean:.1}°, median {median:.1}° of {}", set.set, errors.len());
        chart.text((176.0, 18.0), 21.0 - 17.0 * at as f64, Anchor::Right, colour, &text);
    }
}

fn angles(page: &Page<'_>, kind: &KindResult, vertical: [f64; 2]) {
    let published = kind.sets.iter().find_map(|set| set.paper.euler_error_deg);
    let known = kind.sets.iter().filter_map(|set| set.euler_error_deg).chain(published).flatten();
    let most = known.fold(0.0, f64::max);
    let step = [5.0, 10.0, 20.0].into_iter().find(|step| most < 6.0 * step).unwrap_or(30.0);
    // Room for a number above the highest bar.
    let y = Axis::from_zero((most / step + 0.3).ceil() * step, step, "°");
    let ticks = ["x", "y", "z"].into_iter().zip([0.5, 1.5, 2.5]).map(|(n, at)| (at, n.into())).collect();
    let axes = [Axis { ends: [0.0, 3.0], logarithmic: false, ticks }, y];
    let title = format!("{} pictures: mean error of each angle", kind.kind);
    let chart = page.chart(PANELS[1], vertical, &title, "angle", axes);
    let ours = kind.sets.iter().zip(COLOURS).map(|(set, colour)| (set.euler_error_deg, colour, true));
    for (at, (angles, colour, filled)) in ours.chain([(published, GREY, false)]).enumerate() {
        for (axis, angle) in angles.into_iter().flatten().enumerate() {
            let middle = axis as f64 + 0.5 + (at as f64 - 1.5) * BAR;
            let [from, to] = [middle - 0.48 * BAR, middle + 0.48 * BAR];
            if filled {
                chart.bar([from, to], angle, colour);
            } else {
                chart.dashes(&[(from, 0.0), (from, angle), (to, angle), (to, 0.0)], colour);
            }
            chart.text((middle, angle), 8.0, Anchor::Center, colour, &format!("{angle:.1}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::figures::tests::some;
    use super::*;

    #[test]
    fn every_matrix_has_all_its_cells() {
        let svg = confusion(&some());
        // Two kinds, three sets, their ground and two classes by two answers and none; the page's.
        assert_eq!(svg.matches("<rect").count(), 2 * 3 * (1 + 2 * 3) + 1);
        assert!(svg.contains("the paper: 61 % of its 36, its person 61 %") && svg.contains("67 % of 3 "));
    }

    #[test]
    fn every_set_has_a_curve_and_every_angle_a_bar() {
        let svg = orientation(&some());
        assert!(svg.contains(": mean 10.0°, median 10.0° of 1"));
        assert_eq!(svg.matches("<rect").count(), 2 * 3 * 3 + 1);
    }
}
