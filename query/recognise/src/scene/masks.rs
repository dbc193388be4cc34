//! The network's coarse masks on the pixels of a picture.

use super::look::SquareInput;
use super::patch::{Patch, largest_patch};
use super::square::{Map, Square};
use crate::networks::{Heads, MASKS, SceneNetwork};
use crate::picture::Picture;
use crate::segment::Mask;

/// Which of the masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Hand,
    Forearm,
    Object,
}

/// The masks of a square.
#[derive(Clone, Debug)]
pub(super) struct Masks {
    pub(super) square: Square,
    /// From the picture to the square.
    map: Map,
    /// Logits of hand, forearm and object, row by row.
    logits: Vec<f32>,
    /// Which cells are within the picture: beyond its border a hand goes on that is not there.
    is_within: Vec<bool>,
    /// Values a side.
    side: usize,
}

/// How much of an object's area counts for the size of what is looked at, in areas of its hand, and
/// how much of it for its middle: as in the scenes that the network was trained on.
const MOST_OF_OBJECT: f64 = 2.5;
const OBJECT_IN_MIDDLE: f64 = 0.5;
/// The least share of a square that an object has which is looked at by itself.
const LEAST_OBJECT: f64 = 0.004;
/// Log-odds above which a cell is of a part; and above which, where no object is seen by that, a
/// cell may be of one: in a third of the photographs things are seen that faintly.
const SEEN: f32 = 0.0;
const FAINT: f32 = -2.0;

impl Masks {
    /// What a network sees in a square.
    pub(super) fn of_square(network: &SceneNetwork, input: &mut SquareInput<'_>, square: Square) -> Self {
        let heads = input.run_on(network, &square);
        Self::new(input.picture, square, heads)
    }

    /// What a network has seen in a square of a picture.
    pub(super) fn new(picture: &Picture, square: Square, heads: Heads) -> Self {
        let (side, map) = (heads.mask_side, square.to_picture());
        let length = [picture.width(), picture.height()].map(|length| length as f64);
        let cell = |at: usize| [at % side, at / side].map(|v| (v as f64 + 0.5) / side as f64);
        let is_within = (0..side * side).map(|at| {
            let place = map.apply(cell(at));
            place.iter().zip(length).all(|(v, length)| (0.0..length).contains(v))
        });
        let is_within = is_within.collect();
        Self { square, map: square.from_picture(), logits: heads.masks, is_within, side }
    }

    /// The hand's area in pixels of the picture.
    pub(super) fn hand_area(&self) -> f64 {
        self.sum(Part::Hand)[2] * self.square.side * self.square.side
    }

    /// The square around hand and object, its side `sizes` roots of their area, turned as this one;
    /// `None` where there is no hand.
    pub(super) fn fitted(&self, sizes: f64) -> Option<Square> {
        self.around(self.sum(Part::Hand), sizes)
    }

    /// The same around a hand whose mask on the picture is known better.
    pub(super) fn fitted_to(&self, hand: &Mask, sizes: f64) -> Option<Square> {
        let (width, pixel) = (hand.width(), (self.square.side * self.square.side).recip());
        let inside = hand.pixels().iter().enumerate().filter(|(_, inside)| **inside != 0);
        let sum = inside.fold([0.0; 3], |sum, (at, _)| {
            let place = [at % width, at / width].map(|v| v as f64 + 0.5);
            let [x, y] = self.map.apply(place);
            [sum[0] + pixel * x, sum[1] + pixel * y, sum[2] + pixel]
        });
        self.around(sum, sizes)
    }

    /// The square around what is seen of the object, its side `sizes` roots of its area, but at
    /// least `least` pixels; `None` where hardly anything is seen of it.
    pub(super) fn around_object(&self, sizes: f64, least: f64) -> Option<Square> {
        let patch = |least| self.patch(Part::Object, least).filter(|patch| patch.area > LEAST_OBJECT);
        let object = patch(SEEN).or_else(|| patch(FAINT))?;
        let side = (sizes * object.area.sqrt() * self.square.side).max(least);
        Some(Square { centre: self.square.to_picture().apply(object.centre), side, ..self.square })
    }

    fn around(&self, [x, y, hand]: [f64; 3], sizes: f64) -> Option<Square> {
        let [object_x, object_y, object] = self.sum(Part::Object);
        if hand == 0.0 {
            return None;
        }
        let seen = object.min(MOST_OF_OBJECT * hand);
        let share = OBJECT_IN_MIDDLE * seen / object.max(f64::MIN_POSITIVE);
        let area = hand + share * object;
        let centre = [(x + share * object_x) / area, (y + share * object_y) / area];
        let side = sizes * (hand + seen).sqrt() * self.square.side;
        Some(Square { centre: self.square.to_picture().apply(centre), side, ..self.square })
    }

    /// The sums of the places, right and down, of the cells that are of a part, and their number,
    /// each as a share of the square.
    fn sum(&self, part: Part) -> [f64; 3] {
        let cell = 1.0 / self.is_within.len().max(1) as f64;
        let inside = self.cells(part, SEEN).enumerate().filter(|(_, is_part)| *is_part);
        inside.fold([0.0; 3], |sum, (at, _)| {
            let [x, y] = [at % self.side, at / self.side].map(|v| (v as f64 + 0.5) / self.side as f64);
            [sum[0] + cell * x, sum[1] + cell * y, sum[2] + cell]
        })
    }

    /// The largest patch of a part; `None` where none is seen.
    pub(super) fn largest_patch(&self, part: Part) -> Option<Patch> {
        self.patch(part, SEEN)
    }

    /// The same of cells whose log-odds are above `least`.
    fn patch(&self, part: Part, least: f32) -> Option<Patch> {
        largest_patch(&self.cells(part, least).collect::<Vec<_>>(), self.side)
    }

    /// Which cells of the picture have log-odds of a part above `least`.
    fn cells(&self, part: Part, least: f32) -> impl Iterator<Item = bool> {
        let cells = self.part(part).iter().zip(&self.is_within);
        cells.map(move |(logit, is_within)| *is_within && *logit > least)
    }

    fn part(&self, part: Part) -> &[f32] {
        let cells = self.logits.len() / MASKS;
        let start = part as usize * cells;
        &self.logits[start..start + cells]
    }

    /// The logits of parts at a place of the picture, in pixels; `None` outside the square.
    pub(super) fn at<const PARTS: usize>(
        &self,
        parts: [Part; PARTS],
        place: [f64; 2],
    ) -> Option<[f32; PARTS]> {
        let [u, v] = self.map.apply(place);
        if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
            return None;
        }
        let last = self.side - 1;
        let cell = |share: f64| {
            let exact = (share * self.side as f64 - 0.5).clamp(0.0, last as f64);
            let whole = exact as usize;
            (whole, (exact - whole as f64) as f32)
        };
        let ((x, fx), (y, fy)) = (cell(u), cell(v));
        Some(parts.map(|part| {
            let mask = self.part(part);
            let value = |x: usize, y: usize| mask[y.min(last) * self.side + x.min(last)];
            let row = |y: usize| value(x, y) * (1.0 - fx) + value(x + 1, y) * fx;
            row(y) * (1.0 - fy) + row(y + 1) * fy
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The answer of a network that says nothing but its masks.
    fn heads(masks: Vec<f32>) -> Heads {
        Heads { classes: vec![], mirrored: 0.0, stages: [0.0; 3], rotation: [0.0; 6], masks, mask_side: 32 }
    }

    /// A square that a network takes for hand, all of it.
    fn all_hand(picture: &Picture, square: Square) -> Masks {
        let cells = 32 * 32;
        let masks = (0..MASKS * cells).map(|at| if at < cells { 2.0 } else { -2.0 }).collect();
        Masks::new(picture, square, heads(masks))
    }

    #[test]
    fn beyond_the_border_there_is_no_hand() {
        let picture = Picture::new(40, 80, vec![[9; 3]; 40 * 80]).unwrap();
        // The square reaches 40 pixels beyond the right border, and ends where the picture does.
        let masks = all_hand(&picture, Square { centre: [40.0, 40.0], side: 80.0, turn: 0.0 });
        assert!((masks.hand_area() - 40.0 * 80.0).abs() < 1e-6, "{}", masks.hand_area());
        let patch = masks.largest_patch(Part::Hand).unwrap();
        assert_eq!((patch.centre, patch.area), ([0.25, 0.5], 0.5));
        let fitted = masks.fitted(2.0).unwrap();
        assert!((fitted.centre[0] - 20.0).abs() < 1e-6 && (fitted.centre[1] - 40.0).abs() < 1e-6);
        assert!((fitted.side - 2.0 * (40.0f64 * 80.0).sqrt()).abs() < 1e-6);
        // A square that shows nothing of the picture has nothing in it.
        let beside = all_hand(&picture, Square { centre: [200.0, 40.0], side: 80.0, turn: 0.5 });
        assert!(beside.fitted(2.0).is_none() && beside.largest_patch(Part::Hand).is_none());
    }

    #[test]
    fn an_object_is_looked_at_by_itself_where_enough_is_seen_of_it() {
        let picture = Picture::new(64, 64, vec![[9; 3]; 64 * 64]).unwrap();
        // Eight cells by four in the lower right corner, and a speck elsewhere.
        let with_odds = |wide: usize, odds: f32| {
            let is_object = |at: usize| {
                let (x, y) = (at % 32, at / 32);
                ((20..20 + wide).contains(&x) && (24..28).contains(&y)) || at == 0
            };
            let cells = 32 * 32;
            let masks = (0..MASKS * cells)
                .map(|at| if at / cells == 2 && is_object(at % cells) { odds } else { -3.0 })
                .collect();
            let square = Square { centre: [32.0, 32.0], side: 64.0, turn: 0.0 };
            Masks::new(&picture, square, heads(masks))
        };
        let with = |wide| with_odds(wide, 2.0);
        let square = with(8).around_object(2.0, 10.0).unwrap();
        assert_eq!((square.centre, square.turn), ([48.0, 52.0], 0.0));
        assert!((square.side - 2.0 * (16.0f64 * 8.0).sqrt()).abs() < 1e-9, "{}", square.side);
        assert_eq!(with(8).around_object(2.0, 30.0).unwrap().side, 30.0);
        assert!(with(1).around_object(2.0, 10.0).is_none() && with(0).around_object(2.0, 10.0).is_none());
        assert_eq!(with_odds(8, -1.5).around_object(2.0, 10.0), with(8).around_object(2.0, 10.0));
        assert!(with_odds(8, -2.5).around_object(2.0, 10.0).is_none());
    }

    #[test]
    fn what_a_network_sees_at_the_border_goes_up_to_it() {
        let picture = Picture::new(40, 80, vec![[9; 3]; 40 * 80]).unwrap();
        let masks = all_hand(&picture, Square { centre: [40.0, 40.0], side: 80.0, turn: 0.0 });
        assert_eq!(masks.at([Part::Hand, Part::Forearm], [39.9, 40.0]), Some([2.0, -2.0]));
        assert_eq!(masks.at([Part::Hand], [200.0, 40.0]), None);
    }
}
