//! Other ways of the six grasps, for pictures in which the thing is seen.

use std::sync::{Arc, LazyLock};

use super::definition::Grasp;
use super::set::grasps;

static PRESENTED: LazyLock<Vec<Arc<Grasp>>> = LazyLock::new(|| {
    let ways = grasps(include_str!("../../data/presented.toml"));
    ways.expect("data/presented.toml is checked by a test").into_iter().map(Arc::new).collect()
});

static ALIKE: LazyLock<Vec<Arc<Grasp>>> = LazyLock::new(|| {
    let ways = grasps(include_str!("../../data/alike.toml"));
    ways.expect("data/alike.toml is checked by a test").into_iter().map(Arc::new).collect()
});

/// Ways in which things are held up to a camera: at the finger tips. A grasp, known by its name, is
/// there in several of them or in none.
///
/// Without the thing a hand that holds up a can is like one that holds a ball or a lid: these are
/// for pictures in which the thing is seen.
pub fn presented_grasps() -> &'static [Arc<Grasp>] {
    &PRESENTED
}

/// Ways in which a hand is posed as in another grasp, so that only the thing identifies it. As
/// [`presented_grasps`].
pub fn alike_grasps() -> &'static [Arc<Grasp>] {
    &ALIKE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::{GraspSet, Placement};

    #[test]
    fn ways_hold_what_the_grasp_of_their_name_holds() {
        let known = GraspSet::builtin();
        for way in presented_grasps().iter().chain(alike_grasps()) {
            let grasp = known.get(&way.name).expect("a grasp of this name");
            assert_eq!(way.cutkosky, grasp.cutkosky);
            assert_eq!(way.object.kind, grasp.object.kind, "{}: what it holds is another thing", way.about);
        }
        assert!(presented_grasps().len() > 5 && alike_grasps().len() > 4);
    }

    #[test]
    fn presented_things_are_at_the_finger_tips() {
        for way in presented_grasps() {
            assert!(matches!(way.object.placement, Placement::Tips { .. }), "{}", way.about);
        }
    }
}
