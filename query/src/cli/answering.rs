//! What becomes of a recognition: its record, after the frames before it, with the robot's
//! strategy.

use grasp_answer::record::{Record, SingleRecord};
use grasp_recognise::sequence::Filter;
use grasp_recognise::{Recogniser, Recognition};
use grasp_robot::Setting;

/// What pictures are recognised by, and what their records hold.
pub(super) struct Answering<'a> {
    pub(super) recogniser: Recogniser<'a>,
    /// Whose strategy a record has, if any.
    pub(super) robot: Option<Setting>,
    /// Whether a record says how long each step took.
    pub(super) timings: bool,
}

impl Answering<'_> {
    /// The record of what was found. Where there is a filter, it is of all frames so far, `found`
    /// becomes what they say together, and what this frame says alone stands beside it.
    pub(super) fn record(
        &self,
        name: &str,
        frame: Option<u64>,
        found: &mut Recognition,
        filter: Option<&mut Filter>,
    ) -> Record {
        let single = filter.map(|filter| {
            let single = SingleRecord::new(found);
            self.recogniser.follow(found, filter);
            single
        });
        let index = self.recogniser.index();
        match Record::answer(name.to_owned(), frame, found, index, self.timings) {
            Ok(mut record) => {
                if let Record::Answer(answer) = &mut record {
                    answer.single = single;
                    if let Some(setting) = &self.robot {
                        answer.imitate(found, setting);
                    }
                }
                record
            }
            Err(error) => Record::failed(name.to_owned(), frame, "index", error.to_string()),
        }
    }
}
