//! Ways in which people hold things up to a camera.

use std::sync::{Arc, LazyLock};

use super::definition::Grasp;
use super::set::grasps;

static PRESENTED: LazyLock<Vec<Arc<Grasp>>> = LazyLock::new(|| {
    let ways = grasps(include_str!("../../data/presented.toml"));
    ways.expect("data/presented.toml is checked by a test").into_iter().map(Arc::new).collect()
});

/// Other ways of the six grasps, in which things are held up to a camera: at the finger tips. A
/// grasp, known by its name, is there in several of them or in none.
///
/// Without the thing a hand that holds up a can is like one that holds a ball or a lid: these are
/// for pictures in which the thing is seen.
pub fn presented_grasps() -> &'static [Arc<Grasp>] {
    &PRESENTED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::{GraspSet, Placement};

    #[test]
    fn presented_things_are_at_the_finger_tips_and_under_known_names() {
        let known = GraspSet::builtin();
        for way in presented_grasps() {
            let grasp = known.get(&way.name).expect("a grasp of this name");
            assert_eq!(way.cutkosky, grasp.cutkosky);
            assert_eq!(way.object.kind, grasp.object.kind, "{}: what it holds is another thing", way.about);
            assert!(matches!(way.object.placement, Placement::Tips { .. }), "{}", way.about);
        }
        assert!(presented_grasps().len() > 5);
    }
}
