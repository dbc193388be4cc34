//! The arm that carries the hand: joint angles along a strategy's way, or why there are none.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Joints, Kinematics as _, Pose as FlangePose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use serde::{Deserialize, Serialize};

use super::RobotError;
use super::pose::{Pose, rounded};
use super::read::{Source, built_in, described, text};
use super::step::Step;

/// The arms that come with the program.
const BUILT_IN: [(&str, &str); 1] = [("kuka-kr6-r700", include_str!("../../data/arms/kuka-kr6-r700.toml"))];

/// At most so far apart, in metres, are two waypoints of a straight way.
const SPACING: f64 = 0.01;
/// A joint that turns farther than this between two waypoints, in radians, has to turn over: no
/// straight way for the hand.
const LEAP: f64 = 0.5;
/// No arm on a table is longer, in metres.
const LONGEST: f64 = 10.0;

/// An arm of six axes of which the last three meet in a point, and where it stands.
#[derive(Clone, Debug)]
pub struct Arm {
    name: String,
    joints: [String; 6],
    limits: [[f64; 2]; 6],
    geometry: Geometry,
    base_from_world: Isometry3<f64>,
    wrist_from_flange: Isometry3<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(rename = "about")]
    _about: Option<String>,
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
    joints: [String; 6],
    limits: [[f64; 2]; 6],
    geometry: Geometry,
    mount: Mount,
}

/// Lengths in metres, angles in radians (Brandstoetter, Angerer, Hofbaur 2014, Figure 1).
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Geometry {
    a1: f64,
    a2: f64,
    b: f64,
    c1: f64,
    c2: f64,
    c3: f64,
    c4: f64,
    offsets: [f64; 6],
    signs: [i8; 6],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mount {
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

/// What the arm does while the hand approaches and retreats. JSON keys are an interface: they may
/// be added to, never renamed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ArmMotion {
    /// The arm.
    pub arm: String,
    /// Its joints, in the order of the waypoints' angles.
    pub joint_names: [String; 6],
    /// Whether it can carry the hand all the way.
    pub reachable: bool,
    /// The way in joint angles, at most 10 mm apart; none where it is unreachable.
    pub waypoints: Vec<Waypoint>,
    /// Where the way ends, for an arm that cannot go on.
    pub unreachable: Option<Unreachable>,
}

/// A point of the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Waypoint {
    /// `approach` or `retreat`.
    pub step: &'static str,
    /// How far along that step's way, in metres.
    pub distance: f64,
    /// The joints' angles in radians.
    pub joints: [f64; 6],
}

/// Where an arm cannot go on, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Unreachable {
    /// `approach` or `retreat`.
    pub step: &'static str,
    /// How far along that step's way, in metres.
    pub distance: f64,
    /// What keeps it.
    pub why: Hindrance,
}

/// What keeps an arm from a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Hindrance {
    /// The pose is too far away, or too near.
    OutOfReach,
    /// A joint would have to turn beyond its limits.
    JointLimit,
    /// A joint would have to turn over at once, where the wrist is stretched.
    Leap,
}

impl std::fmt::Display for Hindrance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OutOfReach => "it is out of reach",
            Self::JointLimit => "a joint's limit is in the way",
            Self::Leap => "a joint would have to turn over on the way",
        })
    }
}

/// A pose on the way.
struct Station {
    step: &'static str,
    distance: f64,
    flange: FlangePose,
}

impl Arm {
    /// The arm that comes with the program by that name, or that a file ending in `.toml`
    /// describes.
    ///
    /// # Errors
    /// [`RobotError::Read`], [`RobotError::Format`], [`RobotError::UnknownArm`].
    pub fn find(name: &str) -> Result<Self, RobotError> {
        match described(name) {
            Some(path) => Self::parse(name, &text(path)?),
            None => Self::built_in(name),
        }
    }

    /// The names of the arms that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// An arm that this program knows.
    ///
    /// # Errors
    /// [`RobotError::UnknownArm`].
    pub fn built_in(name: &str) -> Result<Self, RobotError> {
        let text = built_in(&BUILT_IN, name)
            .map_err(|known| RobotError::UnknownArm { name: name.to_owned(), known })?;
        Self::parse(name, text)
    }

    /// Reads a description from memory; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Format`].
    pub fn parse(name: &str, text: &str) -> Result<Self, RobotError> {
        let source = Source { name, what: "an arm" };
        let file: File = source.parse(text)?;
        file.geometry.check(source)?;
        for (joint, [low, high]) in file.joints.iter().zip(file.limits) {
            // Within two turns, as the solver asks of angles that it is to keep near.
            let most = 4.0 * PI;
            if !(low < high && low >= -most && high <= most) {
                return Err(source.error(format!(
                    "limits of {joint} = [{low}, {high}]: each must be within two turns, in radians, and the lower one first"
                )));
            }
        }
        let mount = Source { name, what: "an arm with its [mount]" };
        Ok(Self {
            base_from_world: source.pose(file.position, file.quaternion_xyzw)?.inverse(),
            wrist_from_flange: mount.pose(file.mount.position, file.mount.quaternion_xyzw)?.inverse(),
            name: file.name,
            joints: file.joints,
            limits: file.limits,
            geometry: file.geometry,
        })
    }

    /// The joint angles along the approach and the retreat of `steps`, whose grasp has the wrist at
    /// `wrist` in the world: of the ways that keep every joint within its limits and turn none of
    /// them over, the one on which the joints turn least.
    pub fn carry(&self, wrist: &Pose, steps: &[Step]) -> ArmMotion {
        let stations = self.stations(wrist, steps);
        let solver = OPWKinematics::new(self.geometry.parameters());
        let mut best: Option<(f64, Vec<Joints>)> = None;
        let mut farthest = (0, Hindrance::OutOfReach);
        let starts = stations.first().map(|start| solver.inverse(&start.flange)).unwrap_or_default();
        if !starts.is_empty() {
            farthest.1 = Hindrance::JointLimit;
        }
        for start in starts.iter().filter_map(|joints| self.within(joints)) {
            match self.follow(&solver, start, &stations) {
                Ok((turned, way)) => {
                    if best.as_ref().is_none_or(|(least, _)| turned < *least) {
                        best = Some((turned, way));
                    }
                }
                Err(end) if end.0 > farthest.0 => farthest = end,
                Err(_) => {}
            }
        }
        let motion = |waypoints: Vec<Waypoint>, unreachable: Option<Unreachable>| ArmMotion {
            arm: self.name.clone(),
            joint_names: self.joints.clone(),
            reachable: unreachable.is_none(),
            waypoints,
            unreachable,
        };
        match (best, stations.get(farthest.0)) {
            (Some((_, way)), _) => motion(
                stations
                    .iter()
                    .zip(way)
                    .map(|(station, joints)| Waypoint {
                        step: station.step,
                        distance: rounded(station.distance),
                        joints: joints.map(rounded),
                    })
                    .collect(),
                None,
            ),
            (None, station) => {
                let (step, distance) =
                    station.map_or(("approach", 0.0), |station| (station.step, station.distance));
                let distance = rounded(distance);
                motion(Vec::new(), Some(Unreachable { step, distance, why: farthest.1 }))
            }
        }
    }

    /// Where the flange has to be: along the approach, then along the retreat.
    fn stations(&self, wrist: &Pose, steps: &[Step]) -> Vec<Station> {
        let grasp = wrist.isometry();
        let forward = grasp.rotation * Vector3::z();
        let mut stations = Vec::new();
        let mut straight = |step, length: f64, from: Isometry3<f64>, direction: Vector3<f64>| {
            let parts = (length / SPACING).ceil().max(1.0);
            for part in 0..=parts as usize {
                let distance = length * part as f64 / parts;
                let wrist = Translation3::from(direction * distance) * from;
                // Nothing is reached on a way of numbers that are none.
                let flange = pose(&(self.base_from_world * wrist * self.wrist_from_flange));
                stations.extend(flange.map(|flange| Station { step, distance, flange }));
            }
        };
        for step in steps {
            match step {
                Step::Approach { distance, .. } => {
                    let start = Translation3::from(-forward * *distance) * grasp;
                    straight("approach", *distance, start, forward);
                }
                Step::Retreat { distance, direction, .. } => {
                    straight("retreat", *distance, grasp, direction.vector.into());
                }
                Step::Preshape { .. } | Step::Grasp { .. } => {}
            }
        }
        stations
    }

    /// All stations from the joints of the first one, and how far the joints turn in all; or the
    /// station that was not reached and why.
    fn follow(
        &self,
        solver: &OPWKinematics,
        start: Joints,
        stations: &[Station],
    ) -> Result<(f64, Vec<Joints>), (usize, Hindrance)> {
        let mut way = vec![start];
        let mut turned = 0.0;
        let mut last = start;
        for (at, station) in stations.iter().enumerate().skip(1) {
            let solutions = solver.inverse_continuing(&station.flange, &last);
            if solutions.is_empty() {
                return Err((at, Hindrance::OutOfReach));
            }
            let turn = |joints: &Joints| {
                joints.iter().zip(last).map(|(joint, last)| (joint - last).abs()).fold(0.0, f64::max)
            };
            let next = solutions
                .iter()
                .filter(|joints| self.allows(joints))
                .min_by(|one, other| turn(one).total_cmp(&turn(other)))
                .ok_or((at, Hindrance::JointLimit))?;
            if turn(next) > LEAP {
                // Where the way that goes on is beyond a limit, that is what is in the way.
                let limited = solutions.iter().any(|joints| turn(joints) <= LEAP);
                return Err((at, if limited { Hindrance::JointLimit } else { Hindrance::Leap }));
            }
            turned += next.iter().zip(last).map(|(joint, last)| (joint - last).abs()).sum::<f64>();
            last = *next;
            way.push(last);
        }
        Ok((turned, way))
    }

    /// The same posture with every joint within its limits, as near to their middle as whole turns
    /// allow.
    fn within(&self, joints: &Joints) -> Option<Joints> {
        let mut turned = *joints;
        for (joint, [low, high]) in turned.iter_mut().zip(self.limits) {
            let turns = (((low + high) / 2.0 - *joint) / TAU).round();
            *joint += turns * TAU;
        }
        self.allows(&turned).then_some(turned)
    }

    fn allows(&self, joints: &Joints) -> bool {
        joints.iter().zip(self.limits).all(|(joint, [low, high])| (low..=high).contains(joint))
    }
}

impl Geometry {
    fn check(&self, source: Source<'_>) -> Result<(), RobotError> {
        let lengths = [
            ("a1", self.a1),
            ("a2", self.a2),
            ("b", self.b),
            ("c1", self.c1),
            ("c2", self.c2),
            ("c3", self.c3),
            ("c4", self.c4),
        ];
        for (key, length) in lengths {
            if length.is_nan() || length.abs() > LONGEST {
                return Err(source.error(format!("{key} = {length}: it must be within {LONGEST} m")));
            }
        }
        source.length("c2, the upper arm,", self.c2, LONGEST)?;
        source.length("c3, the lower arm,", self.c3, LONGEST)?;
        if let Some(offset) = self.offsets.iter().find(|offset| offset.is_nan() || offset.abs() > TAU) {
            return Err(
                source.error(format!("offsets hold {offset}: each must be within a turn, in radians"))
            );
        }
        if self.signs.iter().any(|sign| sign.abs() != 1) {
            return Err(source.error(format!("signs = {:?}: each must be 1 or -1", self.signs)));
        }
        Ok(())
    }

    fn parameters(&self) -> Parameters {
        let Self { a1, a2, b, c1, c2, c3, c4, offsets, signs } = *self;
        Parameters { a1, a2, b, c1, c2, c3, c4, offsets, sign_corrections: signs, dof: 6 }
    }
}

/// The same in the solver's types; `None` where a number is not finite.
fn pose(isometry: &Isometry3<f64>) -> Option<FlangePose> {
    let rotation: &UnitQuaternion<f64> = &isometry.rotation;
    let at = isometry.translation.vector;
    let rotation = DQuat::from_xyzw(rotation.i, rotation.j, rotation.k, rotation.w);
    FlangePose::try_from_parts(DVec3::new(at.x, at.y, at.z), rotation).ok()
}
