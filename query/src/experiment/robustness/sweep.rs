//! The trials of a sweep, and what each grasp tolerates by them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use grasp_robot::RobotHand;
use grasp_robot::simulation::{Offset, Outcome, Plan, SCENES, Scene};

use super::table::{Row, Table};

/// What simulates, as windows name it.
pub const ENGINE: &str = "rapier3d 0.36.1";

/// What is swept.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The objects.
    pub scenes: Vec<&'static Scene>,
    /// Positions go from minus to plus this, in millimetres.
    pub reach_mm: u32,
    /// The step, in millimetres.
    pub step_mm: u32,
    /// Yaws go from minus to plus this, in degrees.
    pub yaw_deg: u32,
    /// The step, in degrees.
    pub yaw_step_deg: u32,
}

/// Where a trial stands in the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    scene: usize,
    x_mm: i32,
    y_mm: i32,
    yaw_deg: i32,
}

/// What a grasp tolerates on an object. JSON keys are an interface: they may be added to, never
/// renamed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tolerance {
    /// The object.
    pub object: String,
    /// The robot's grasp.
    pub grasp: String,
    /// What simulated it.
    pub engine: &'static str,
    /// Cells of the position grid, and how many were successes.
    pub cells: usize,
    /// Successes among them.
    pub successes: usize,
    /// Every cell within +- this of the middle was a success, in millimetres; null where not even
    /// the middle was.
    pub position_mm: Option<i32>,
    /// Every yaw within +- this was a success, in degrees; null where not even 0 was.
    pub yaw_deg: Option<i32>,
    /// Whether the object looks the same from every side, so that any yaw should do.
    pub is_round: bool,
}

/// The figures.
#[derive(Clone, Debug, Serialize)]
pub struct Robustness {
    /// The robot hand.
    pub robot: String,
    /// What each grasp tolerates.
    pub tolerances: Vec<Tolerance>,
    #[serde(skip)]
    pub(super) rows: Vec<Row>,
}

impl Sweep {
    /// All trials, in order.
    fn cells(&self) -> Vec<Cell> {
        let both = |most: u32, step: u32| -> Vec<i32> {
            let (most, step) = (most as i32 / step.max(1) as i32, step as i32);
            (-most..=most).map(|n| n * step).collect()
        };
        let mut cells = Vec::new();
        for scene in self.scenes.iter().filter_map(|scene| SCENES.iter().position(|s| s.name == scene.name)) {
            for y_mm in both(self.reach_mm, self.step_mm) {
                for x_mm in both(self.reach_mm, self.step_mm) {
                    cells.push(Cell { scene, x_mm, y_mm, yaw_deg: 0 });
                }
            }
            for yaw_deg in both(self.yaw_deg, self.yaw_step_deg) {
                cells.push(Cell { scene, x_mm: 0, y_mm: 0, yaw_deg });
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

impl Robustness {
    /// Runs the trials of a sweep in parallel. With a folder, each is written to `robustness.csv`
    /// there as it ends, and those that it holds already are not repeated. `tick` is told how many
    /// trials there are and then of each.
    ///
    /// # Errors
    /// Where the hand cannot be simulated, the table cannot be read or written, or was made with
    /// another hand.
    pub fn run(
        hand: &RobotHand,
        sweep: &Sweep,
        folder: Option<&Path>,
        tick: impl Fn(Progress) + Sync,
    ) -> anyhow::Result<Self> {
        let made_with = format!("{} {:016x} {ENGINE}", hand.name, hand.fingerprint());
        let cells = sweep.cells();
        // Only of the scenes that are asked for: the hand may not have what others need.
        let mut plans = BTreeMap::new();
        for at in cells.iter().map(|cell| cell.scene) {
            if let (Entry::Vacant(place), Some(scene)) = (plans.entry(at), SCENES.get(at)) {
                place.insert(Plan::new(hand, scene.grasp, &scene.object()?, scene.from.turned())?);
            }
        }
        let table = Table::open(folder, made_with.clone())?;
        let missing: Vec<Cell> = cells.iter().copied().filter(|cell| !table.holds(cell.key())).collect();
        tick(Progress::Trials(missing.len()));
        missing.par_iter().try_for_each(|cell| {
            let (Some(plan), Some(scene)) = (plans.get(&cell.scene), SCENES.get(cell.scene)) else {
                return Ok(());
            };
            let outcome = plan.run(cell.offset());
            tick(Progress::Ended);
            table.append(cell.row(scene, &outcome, &made_with))
        })?;
        let rows = table.finish()?;
        let wanted: Vec<Row> =
            rows.into_iter().filter(|row| cells.iter().any(|cell| cell.key() == row.key())).collect();
        let tolerances = sweep.scenes.iter().map(|scene| Tolerance::new(scene, &wanted)).collect();
        Ok(Self { robot: hand.name.clone(), tolerances, rows: wanted })
    }

    /// The table for a person.
    pub fn text(&self) -> String {
        let mut text =
            format!("{:18}{:18}{:>12}{:>12}{:>10}\n", "object", "grasp", "successes", "position", "yaw");
        for row in &self.tolerances {
            let position = row.position_mm.map_or("none".into(), |mm| format!("+-{mm} mm"));
            let yaw = row.yaw_deg.map_or("none".into(), |degrees| format!("+-{degrees}°"));
            let cells = format!("{} / {}", row.successes, row.cells);
            text += &format!("{:18}{:18}{cells:>12}{position:>12}{yaw:>10}\n", row.object, row.grasp);
        }
        text + &format!("position, yaw: every trial within was a success, by {ENGINE} ({})\n", self.robot)
    }
}

/// What a sweep tells while it runs.
#[derive(Clone, Copy, Debug)]
pub enum Progress {
    /// This many trials remain.
    Trials(usize),
    /// One has ended.
    Ended,
}

impl Cell {
    fn offset(&self) -> Offset {
        Offset {
            x: 1e-3 * f64::from(self.x_mm),
            y: 1e-3 * f64::from(self.y_mm),
            yaw: f64::from(self.yaw_deg).to_radians(),
        }
    }

    fn key(&self) -> (&str, i32, i32, i32) {
        let name = SCENES.get(self.scene).map_or("", |scene| scene.name);
        (name, self.x_mm, self.y_mm, self.yaw_deg)
    }

    fn row(&self, scene: &Scene, outcome: &Outcome, made_with: &str) -> Row {
        // Written to a thousandth: enough to compare, and what a reader of the table sees again.
        let rounded = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
        Row {
            object: scene.name.into(),
            grasp: scene.grasp.into(),
            x_mm: self.x_mm,
            y_mm: self.y_mm,
            yaw_deg: self.yaw_deg,
            success: outcome.success,
            lifted: outcome.lifted,
            rise_mm: rounded(outcome.rise_mm),
            slip_mm: rounded(outcome.slip_mm),
            contact_force_n: rounded(outcome.contact_force_n),
            made_with: made_with.into(),
        }
    }
}

impl Tolerance {
    fn new(scene: &Scene, rows: &[Row]) -> Self {
        let own = || rows.iter().filter(|row| row.object == scene.name);
        let grid: Vec<&Row> = own().filter(|row| row.yaw_deg == 0).collect();
        let line: Vec<&Row> = own().filter(|row| row.x_mm == 0 && row.y_mm == 0).collect();
        let off = |row: &Row| row.x_mm.abs().max(row.y_mm.abs());
        Self {
            object: scene.name.into(),
            grasp: scene.grasp.into(),
            engine: ENGINE,
            cells: grid.len(),
            successes: grid.iter().filter(|row| row.success).count(),
            position_mm: window(grid.iter().map(|row| (off(row), row.success))),
            yaw_deg: window(line.iter().map(|row| (row.yaw_deg.abs(), row.success))),
            is_round: scene.is_round,
        }
    }
}

/// The greatest distance within which every trial was a success.
fn window(trials: impl Iterator<Item = (i32, bool)> + Clone) -> Option<i32> {
    let failed = trials.clone().filter(|(_, success)| !success).map(|(off, _)| off).min();
    trials.map(|(off, _)| off).filter(|off| failed.is_none_or(|failed| *off < failed)).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_ends_before_the_nearest_failure() {
        assert_eq!(window([(0, true), (10, true), (20, false), (30, true)].into_iter()), Some(10));
        assert_eq!(window([(0, true), (10, true)].into_iter()), Some(10));
        assert_eq!(window([(0, false), (10, true)].into_iter()), None);
    }

    #[test]
    fn a_small_sweep_resumes_and_gives_the_same_bytes_again() {
        let folder = tempfile::tempdir().unwrap();
        let hand = RobotHand::find("barrett").unwrap();
        let scenes = vec![Scene::named("block").unwrap(), Scene::named("sphere").unwrap()];
        let sweep = Sweep { scenes, reach_mm: 10, step_mm: 10, yaw_deg: 15, yaw_step_deg: 15 };
        let run = || Robustness::run(&hand, &sweep, Some(folder.path()), |_| {}).unwrap();
        let whole = run();
        whole.write(folder.path()).unwrap();
        for tolerance in &whole.tolerances {
            assert_eq!((tolerance.cells, tolerance.successes), (9, 9), "{tolerance:?}");
            assert_eq!((tolerance.position_mm, tolerance.yaw_deg), (Some(10), Some(15)));
        }
        let path = folder.path().join("robustness.csv");
        let bytes = std::fs::read(&path).unwrap();
        // Interrupted in the middle of a line.
        std::fs::write(&path, &bytes[..bytes.len() * 2 / 3]).unwrap();
        run();
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
        // Another hand's rows are not mixed with these.
        let mut other = hand.clone();
        other.max_contact_force = 19.0;
        let error = Robustness::run(&other, &sweep, Some(folder.path()), |_| {}).unwrap_err();
        assert!(error.to_string().contains("another hand"), "{error}");
    }
}
