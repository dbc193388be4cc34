//! How well trained networks do, without a training.

use std::sync::Arc;

use anyhow::ensure;
use grasp_network::Network;
use grasp_renders::HandModel;
use grasp_terminal::Progress;

use super::check::Check;
use super::course::Course;
use super::figures::Figure;
use super::hand::Hand;
use super::options::{Kind, Optimiser, Options};
use super::scene::Scene;
use super::{DEFAULT_VALIDATE_EVERY, Schedule};

/// What networks are measured by.
#[derive(Clone, Debug)]
pub struct Measured {
    /// What kind of networks they are.
    pub kind: Kind,
    /// Scenes of each kind that are drawn; each is seen twelve times.
    pub scenes: u64,
    /// Whether neighbours are searched among scenes without the recorded poses that a training may
    /// hold out.
    pub hold_out_poses: bool,
    /// The hand that takes the place of drawn ones.
    pub hand_model: Option<Arc<HandModel>>,
}

/// The figures of each of some networks by the same renders, as the curve of a training has them.
///
/// # Errors
/// Where a network is of another kind, a scene cannot be built, or `check` has stopped the work.
pub fn measure(
    measured: &Measured,
    networks: &[Network],
    progress: Progress,
    check: Check<'_>,
) -> anyhow::Result<Vec<Vec<Figure>>> {
    match measured.kind {
        Kind::Hand => measure_on::<Hand>(measured, networks, progress, check),
        Kind::Scene | Kind::Naming | Kind::Thing | Kind::Mask => {
            measure_on::<Scene>(measured, networks, progress, check)
        }
    }
}

fn measure_on<C: Course>(
    measured: &Measured,
    networks: &[Network],
    progress: Progress,
    check: Check<'_>,
) -> anyhow::Result<Vec<Vec<Figure>>> {
    let course = C::new(&options(measured));
    let architecture = course.architecture();
    for network in networks {
        ensure!(
            *network.architecture() == architecture,
            "the network {:016x} is of another kind: say which by --kind",
            network.fingerprint()
        );
    }
    let schedule = Schedule { validation: measured.scenes, ..Schedule::standard(measured.kind) };
    let work = progress.bar(C::validation_scenes(&schedule), "rendering", "scenes");
    let validation = course.validation(&schedule, measured.hand_model.as_ref(), check, &work)?;
    drop(work);
    networks
        .iter()
        .map(|network| {
            check()?;
            Ok(course.measure(&validation, network))
        })
        .collect()
}

/// Those of a training that is never begun.
fn options(measured: &Measured) -> Options {
    Options {
        kind: measured.kind,
        samples: 0,
        seed: 0,
        hold_out_poses: measured.hold_out_poses,
        recorded_percent: 100,
        hands: None,
        validate_every: DEFAULT_VALIDATE_EVERY,
        start: None,
        optimiser: Optimiser::default(),
        peak_rate: None,
        keep_percent: 0,
        left_out: Vec::new(),
    }
}
