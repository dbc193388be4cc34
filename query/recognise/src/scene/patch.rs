//! Patches of a mask.

/// A patch of cells, in shares of the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patch {
    pub(super) centre: [f64; 2],
    /// The share of the square's area.
    pub(super) area: f64,
}

/// The largest patch of cells that are set, of a square with `side` a side; `None` where none is.
pub(super) fn largest_patch(cells: &[bool], side: usize) -> Option<Patch> {
    let mut seen = vec![false; cells.len()];
    let mut best: Option<Patch> = None;
    let mut stack = Vec::new();
    for start in 0..cells.len() {
        stack.push(start);
        let (mut sum, mut count) = ([0usize; 2], 0usize);
        while let Some(at) = stack.pop() {
            if seen[at] || !cells[at] {
                continue;
            }
            seen[at] = true;
            let (x, y) = (at % side, at / side);
            sum = [sum[0] + x, sum[1] + y];
            count += 1;
            let beside = [(x > 0, at.wrapping_sub(1)), (x + 1 < side, at + 1)];
            let above = [(y > 0, at.wrapping_sub(side)), (y + 1 < side, at + side)];
            stack.extend(
                beside.into_iter().chain(above).filter(|(is_inside, _)| *is_inside).map(|(_, to)| to),
            );
        }
        let area = count as f64 / cells.len() as f64;
        if count > 0 && best.is_none_or(|patch| area > patch.area) {
            let centre = sum.map(|sum| (sum as f64 / count as f64 + 0.5) / side as f64);
            best = Some(Patch { centre, area });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_patch_is_found_with_its_middle() {
        let side = 8;
        let mut cells = vec![false; side * side];
        for at in [0, 1, 8 * 4 + 4, 8 * 4 + 5, 8 * 5 + 4, 8 * 5 + 5, 8 * 7 + 7] {
            cells[at] = true;
        }
        let patch = largest_patch(&cells, side).unwrap();
        assert_eq!(patch, Patch { centre: [5.0 / 8.0, 5.0 / 8.0], area: 4.0 / 64.0 });
        assert_eq!(largest_patch(&[false; 4], 2), None);
    }
}
