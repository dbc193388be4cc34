//! What is changed: a hand's grey and its mask.

use grasp_index::HandImage;

/// A square grey picture with a mask, values 0 to 1.
#[derive(Clone, Debug)]
pub(in crate::train) struct Picture {
    /// Pixels a side.
    pub(super) side: usize,
    /// Row by row.
    pub(super) grey: Vec<f32>,
    /// The share of a pixel that is hand.
    pub(super) mask: Vec<f32>,
}

impl Picture {
    /// A render: what is 0 lies outside the hand.
    pub(in crate::train) fn new(side: usize, grey: &[u8]) -> Self {
        let mask = grey.iter().map(|&v| f32::from(u8::from(v > 0))).collect();
        Self { side, grey: grey.iter().map(|&v| f32::from(v) / 255.0).collect(), mask }
    }

    /// What is more than half hand, cut out; `None` where too little of it is left.
    pub(in crate::train) fn hand(&self) -> Option<HandImage> {
        let grey: Vec<u8> = self.grey.iter().map(|v| (v * 255.0 + 0.5).clamp(1.0, 255.0) as u8).collect();
        let mask: Vec<u8> = self.mask.iter().map(|v| u8::from(*v > 0.5)).collect();
        HandImage::from_mask(self.side, self.side, &grey, &mask).ok()
    }

    /// How many pixels are hand.
    pub(super) fn area(&self) -> f32 {
        self.mask.iter().sum()
    }

    /// Places and indices of the pixels.
    pub(super) fn pixels(&self) -> impl Iterator<Item = (usize, f32, f32)> + use<> {
        let side = self.side;
        (0..side * side).map(move |at| (at, (at % side) as f32, (at / side) as f32))
    }

    /// How far the hand reaches along a direction, in pixels.
    pub(super) fn reach(&self, [x, y]: [f32; 2]) -> (f32, f32) {
        let inside = self.pixels().filter(|(at, ..)| self.mask[*at] > 0.5);
        inside.fold((f32::MAX, f32::MIN), |(low, high), (_, px, py)| {
            let at = x * px + y * py;
            (low.min(at), high.max(at))
        })
    }

    /// Takes away what `is_hidden`, unless less than `least` of the hand were left.
    pub(super) fn hide(&mut self, least: f32, is_hidden: impl Fn(f32, f32) -> bool) {
        let mut mask = self.mask.clone();
        for (at, x, y) in self.pixels() {
            if is_hidden(x, y) {
                mask[at] = 0.0;
            }
        }
        if mask.iter().sum::<f32>() >= least * self.area() {
            self.mask = mask;
        }
    }
}
