//! The places that the palm network's answers are about.

/// Its grids, each with its cells a side and the answers of a cell: one answer at a stride of 8
/// pixels of 192, three at one of 16, and each of them at two sizes, which make no difference.
const GRIDS: [(usize, usize); 2] = [(24, 2), (12, 6)];

/// How many there are.
pub(super) const COUNT: usize = 24 * 24 * 2 + 12 * 12 * 6;

/// The middles of the cells that the answers are about, in their order, in shares of the square.
pub(super) fn middles() -> impl Iterator<Item = [f64; 2]> {
    GRIDS.into_iter().flat_map(|(side, answers)| {
        (0..side * side * answers).map(move |at| {
            let cell = at / answers;
            [cell % side, cell / side].map(|v| (v as f64 + 0.5) / side as f64)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_answer_has_a_cell() {
        let all: Vec<[f64; 2]> = middles().collect();
        assert_eq!(all.len(), COUNT);
        assert_eq!(all[..3], [[0.5 / 24.0, 0.5 / 24.0], [0.5 / 24.0, 0.5 / 24.0], [1.5 / 24.0, 0.5 / 24.0]]);
        assert_eq!(all[2 * 24], [0.5 / 24.0, 1.5 / 24.0]);
        assert_eq!(all[1152], [0.5 / 12.0, 0.5 / 12.0]);
        assert_eq!(all[COUNT - 1], [11.5 / 12.0, 11.5 / 12.0]);
    }
}
