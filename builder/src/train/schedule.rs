//! How renders and steps follow each other.

use std::ops::Range;

use super::options::Kind;

/// Training goes in rounds: while the steps of one are done, the part of the list of renders that
/// comes in after it is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Samples a step.
    pub batch: usize,
    /// Scenes a part.
    pub scenes: u64,
    /// Views of each scene.
    pub views: usize,
    /// Parts that are there before the first step.
    pub parts_at_first: u64,
    /// Parts that the window has room for.
    pub window: usize,
    /// How often a render is shown, on average.
    pub reuse: u64,
    /// One sample in so many is shown mirrored.
    pub mirrored: usize,
    /// Scenes of each kind that a validation is made on.
    pub validation: u64,
}

impl Schedule {
    /// That of the shipped network of a kind. A full window of scenes takes about fifteen
    /// times as much memory as one of hands.
    pub fn standard(kind: Kind) -> Self {
        match kind {
            Kind::Hand => Self::HAND,
            Kind::Scene | Kind::Naming | Kind::Thing | Kind::Mask => {
                Self { scenes: 24, parts_at_first: 8, window: 20, mirrored: 5, ..Self::HAND }
            }
        }
    }

    const HAND: Self = Self {
        batch: 64,
        scenes: 48,
        views: 16,
        parts_at_first: 4,
        window: 40,
        reuse: 3,
        mirrored: 8,
        validation: 48,
    };

    /// The steps in which `samples` samples are shown, in full batches.
    pub fn steps(&self, samples: u64) -> u64 {
        samples / self.batch as u64
    }

    /// Samples that have been shown after `steps` steps.
    pub fn samples(&self, steps: u64) -> u64 {
        steps * self.batch as u64
    }

    /// The round that a step belongs to.
    pub fn round(&self, step: u64) -> u64 {
        step / self.steps_a_round()
    }

    /// The step after a round's last.
    pub fn end(&self, round: u64) -> u64 {
        (round + 1) * self.steps_a_round()
    }

    /// The parts that are in the window during a round.
    pub fn parts(&self, round: u64) -> Range<u64> {
        let end = self.parts_at_first + round;
        end.saturating_sub(self.window as u64)..end
    }

    /// The numbers of a part's scenes.
    pub fn scenes(&self, part: u64) -> Range<u64> {
        part * self.scenes..(part + 1) * self.scenes
    }

    /// Whether a sample of a batch is shown mirrored, at other places among those that are
    /// augmented hard than among the others.
    pub fn is_mirrored(&self, at: usize) -> bool {
        (at * self.mirrored / self.batch.max(1) + at).is_multiple_of(self.mirrored.max(1))
    }

    fn steps_a_round(&self) -> u64 {
        (self.scenes * self.views as u64 * self.reuse / self.batch as u64).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_come_in_one_a_round_and_leave_when_the_window_is_full() {
        let schedule = Schedule::standard(Kind::Hand);
        assert_eq!((schedule.round(35), schedule.round(36), schedule.end(0)), (0, 1, 36));
        assert_eq!((schedule.parts(0), schedule.parts(36), schedule.parts(37)), (0..4, 0..40, 1..41));
        assert_eq!(schedule.scenes(2), 96..144);
        assert_eq!((0..64).filter(|at| schedule.is_mirrored(*at)).count(), 8);
        assert_eq!((schedule.steps(1000), schedule.samples(15)), (15, 960));
    }
}
