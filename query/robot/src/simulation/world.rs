//! Table, object and hand in the physics engine, with the settings that hold at the scale of a
//! hand.

use nalgebra::Isometry3;
use rapier3d::prelude::*;

use super::barrett::{self, DISTAL, FINGERS, INNER, KNUCKLE, LIMITS, PALM, Part, Solid};
use super::drive::Drive;
use crate::{Object, Shape};

/// The time step, in seconds.
pub(super) const DT: f32 = 0.002;
/// Friction of a table, and of rubber finger pads; of two that touch the lesser counts.
const TABLE_FRICTION: f32 = 0.4;
const FINGER_FRICTION: f32 = 1.0;
/// What holds the palm in place: N/m, N s/m, N.
const BASE: [f32; 3] = [4e4, 800.0, 400.0];
/// What holds an inner joint at its target: N m/rad, N m s/rad, N m. The distal joint has half of
/// each.
const JOINT: [f32; 3] = [150.0, 1.0, 6.0];
/// How fast an object that rolls by itself comes to rest, in 1/s: the engine's cylinders roll
/// without any resistance.
const ROLLING: f32 = 5.0;
/// Sides of the prism that stands for a cylinder: it is 0.1 % thinner than that across its faces.
const SIDES: u32 = 64;
/// The rotor's inertia as the joint feels it, in kg m^2.
const ARMATURE: f32 = 0.001;

/// The state of a trial.
pub(super) struct World {
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    islands: IslandManager,
    broad: BroadPhaseBvh,
    narrow: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    joints: MultibodyJointSet,
    soft: SoftBodySet,
    ccd: CCDSolver,
    pub(super) hand: Hand,
    object: RigidBodyHandle,
    object_collider: ColliderHandle,
}

/// The hand's parts in the engine.
pub(super) struct Hand {
    palm: RigidBodyHandle,
    /// Of each finger, inner and distal.
    links: [[RigidBodyHandle; 2]; FINGERS],
    joints: [[MultibodyJointHandle; 2]; FINGERS],
    base: MultibodyJointHandle,
    /// The joints' angles where the engine says 0.
    open: [[f32; 2]; FINGERS],
    pub(super) drives: [Drive; FINGERS],
    /// Where the palm started, in the world.
    start: Pose,
    spread: f32,
}

/// How the hand begins.
#[derive(Clone, Debug)]
pub(super) struct Begin {
    /// The palm.
    pub(super) palm: Isometry3<f64>,
    /// In radians.
    pub(super) spread: f32,
    /// Each finger's inner and distal joint.
    pub(super) open: [[f32; 2]; FINGERS],
    /// Where each finger's closing ends, as its inner joint's angle.
    pub(super) end: [f32; FINGERS],
    /// Whether distal links close on where inner ones are stopped.
    pub(super) clutch: bool,
}

/// A point in which hand and object touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// In the object's frame, in metres.
    pub(super) point: Vector,
    /// Of unit length, into the object, in its frame.
    pub(super) normal: Vector,
    /// Along the normal, in newtons.
    pub(super) force: f32,
    /// 0 the palm, then inner and distal link of each finger.
    pub(super) part: usize,
}

impl World {
    /// An object on its table, where it has one, and a hand in its open posture. The table is 2 m
    /// wide and its middle on the world's z axis.
    pub(super) fn new(object: &Object, world_from_object: &Isometry3<f64>, begin: &Begin) -> Self {
        let mut world = Self {
            pipeline: PhysicsPipeline::new(),
            parameters: parameters(),
            islands: IslandManager::new(),
            broad: BroadPhaseBvh::new(),
            narrow: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            joints: MultibodyJointSet::new(),
            soft: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            hand: Hand {
                palm: RigidBodyHandle::invalid(),
                links: [[RigidBodyHandle::invalid(); 2]; FINGERS],
                joints: [[MultibodyJointHandle(Default::default()); 2]; FINGERS],
                base: MultibodyJointHandle(Default::default()),
                open: begin.open,
                drives: [0, 1, 2]
                    .map(|finger: usize| Drive::new(begin.open[finger][0], begin.end[finger], begin.clutch)),
                start: pose(&begin.palm),
                spread: begin.spread,
            },
            object: RigidBodyHandle::invalid(),
            object_collider: ColliderHandle::invalid(),
        };
        if let Some(table) = object.table {
            let slab = ColliderBuilder::cuboid(1.0, 1.0, 0.05)
                .position(Pose::from_translation(Vector::new(0.0, 0.0, table as f32 - 0.05)))
                .friction(TABLE_FRICTION);
            world.colliders.insert(finished(slab));
        }
        world.add_object(object, world_from_object);
        world.add_hand(begin);
        world
    }

    fn add_object(&mut self, object: &Object, world_from_object: &Isometry3<f64>) {
        let body = RigidBodyBuilder::dynamic()
            .pose(pose(world_from_object))
            .angular_damping(ROLLING)
            .can_sleep(false);
        self.object = self.bodies.insert(body);
        let shape = match object.shape {
            Shape::Cylinder { radius, height } => prism(radius as f32, 0.5 * height as f32),
            Shape::Box { size } => {
                let [x, y, z] = size.map(|length| 0.5 * length as f32);
                ColliderBuilder::cuboid(x, y, z)
            }
            Shape::Sphere { radius } => ColliderBuilder::ball(radius as f32),
        };
        let shape = shape.mass(object.mass as f32).friction(object.friction as f32);
        self.object_collider =
            self.colliders.insert_with_parent(finished(shape), self.object, &mut self.bodies);
    }

    fn add_hand(&mut self, begin: &Begin) {
        let start = self.hand.start;
        let root = self.bodies.insert(RigidBodyBuilder::fixed());
        let palm = self.add_part(start, &PALM);
        self.hand.palm = palm;
        let mut base = GenericJointBuilder::new(JointAxesMask::ANG_AXES).local_frame1(start);
        for axis in [JointAxis::LinX, JointAxis::LinY, JointAxis::LinZ] {
            let [stiffness, damping, most] = BASE;
            base = base
                .motor_model(axis, MotorModel::ForceBased)
                .motor_position(axis, 0.0, stiffness, damping)
                .motor_max_force(axis, most);
        }
        self.hand.base = self.joint(root, palm, base.build());
        for finger in 0..FINGERS {
            let [inner, distal] = begin.open[finger];
            let palm_from_base = barrett::finger_base(finger, begin.spread);
            self.add_solid(palm, &KNUCKLE, palm_from_base);
            let palm_from_inner = palm_from_base * barrett::base_from_inner(inner);
            let inner_from_distal = barrett::inner_from_distal(distal);
            let first = self.add_part(start * palm_from_inner, &INNER);
            let second = self.add_part(start * palm_from_inner * inner_from_distal, &DISTAL);
            self.hand.links[finger] = [first, second];
            self.hand.joints[finger] = [
                self.joint(palm, first, hinge(palm_from_inner, inner, LIMITS[0], 1.0)),
                self.joint(first, second, hinge(inner_from_distal, distal, LIMITS[1], 0.5)),
            ];
        }
        if let Some((hand, _)) = self.joints.get_mut(self.hand.base) {
            hand.set_self_contacts_enabled(false);
            // The palm's three sliding axes come first.
            hand.armature_mut().rows_mut(3, 2 * FINGERS).fill(ARMATURE);
        }
    }

    fn joint(&mut self, a: RigidBodyHandle, b: RigidBodyHandle, joint: GenericJoint) -> MultibodyJointHandle {
        self.joints.insert(a, b, joint, true).expect("every part of the hand is inserted once")
    }

    fn add_part(&mut self, at: Pose, part: &Part) -> RigidBodyHandle {
        let mass = MassProperties::new(part.centre, part.mass, part.inertia);
        let body = RigidBodyBuilder::dynamic().pose(at).additional_mass_properties(mass).can_sleep(false);
        let body = self.bodies.insert(body);
        self.add_solid(body, &part.solid, Pose::IDENTITY);
        body
    }

    fn add_solid(&mut self, body: RigidBodyHandle, solid: &Solid, at: Pose) {
        let Vector { x, y, z } = solid.half - Vector::splat(solid.round);
        let shape = ColliderBuilder::round_cuboid(x, y, z, solid.round)
            .position(at * Pose::from_translation(solid.middle))
            .density(0.0)
            .friction(FINGER_FRICTION);
        self.colliders.insert_with_parent(finished(shape), body, &mut self.bodies);
    }

    /// Moves the palm's goal: a displacement from where it started, in metres in the world.
    pub(super) fn move_palm(&mut self, displacement: Vector) {
        let along = self.hand.start.inverse_transform_vector(displacement);
        let Some(joint) = self.joint_mut(self.hand.base) else { return };
        let [stiffness, damping, _] = BASE;
        for (axis, goal) in
            [(JointAxis::LinX, along.x), (JointAxis::LinY, along.y), (JointAxis::LinZ, along.z)]
        {
            joint.set_motor_position(axis, goal, stiffness, damping);
        }
    }

    /// Closes every finger for one step.
    pub(super) fn close(&mut self) {
        for finger in 0..FINGERS {
            let targets = self.hand.drives[finger].targets();
            let angles = self.angles(finger);
            let torque = |joint: usize, share: f32| share * JOINT[0] * (targets[joint] - angles[joint]);
            self.hand.drives[finger].close([torque(0, 1.0), torque(1, 0.5)], DT);
            let before = targets;
            let targets = self.hand.drives[finger].targets();
            for (joint, share) in [1.0, 0.5].into_iter().enumerate() {
                let goal = targets[joint] - self.hand.open[finger][joint];
                let handle = self.hand.joints[finger][joint];
                // With the target's speed: damping that fights the motion would look like a torque
                // from outside.
                let speed = (targets[joint] - before[joint]) / DT;
                if let Some(joint) = self.joint_mut(handle) {
                    joint.set_motor(JointAxis::AngX, goal, speed, share * JOINT[0], share * JOINT[1]);
                }
            }
        }
    }

    fn joint_mut(&mut self, handle: MultibodyJointHandle) -> Option<&mut GenericJoint> {
        let (hand, link) = self.joints.get_mut(handle)?;
        Some(&mut hand.link_mut(link)?.joint.data)
    }

    /// A finger's inner and distal angle, in radians.
    pub(super) fn angles(&self, finger: usize) -> [f32; 2] {
        [0, 1].map(|joint: usize| {
            let found = self.joints.get(self.hand.joints[finger][joint]);
            let turned = found.and_then(|(hand, link)| Some(hand.link(link)?.joint.coords()[3]));
            self.hand.open[finger][joint] + turned.unwrap_or_default()
        })
    }

    /// Goes on by one time step.
    pub(super) fn step(&mut self) {
        self.pipeline.step(
            Vector::new(0.0, 0.0, -9.81),
            &self.parameters,
            &mut self.islands,
            &mut self.broad,
            &mut self.narrow,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    /// Pulls the object as an acceleration of the hand would, in m/s^2 in the world.
    pub(super) fn pull_object(&mut self, acceleration: Vector) {
        let object = &mut self.bodies[self.object];
        let force = acceleration * object.mass();
        object.reset_forces(true);
        object.add_force(force, true);
    }

    /// The object in the world.
    pub(super) fn object(&self) -> Pose {
        *self.bodies[self.object].position()
    }

    /// The object in the palm's frame.
    pub(super) fn palm_from_object(&self) -> Pose {
        self.bodies[self.hand.palm].position().inv_mul(&self.object())
    }

    /// The hand's solids where they are: the palm, inner and distal link of each finger, the
    /// knuckles.
    pub(super) fn hand_solids(&self) -> Vec<(Solid, Pose)> {
        let handles = std::iter::once(self.hand.palm).chain(self.hand.links.into_iter().flatten());
        let parts = handles.enumerate().map(|(at, handle)| {
            let part = match at {
                0 => PALM,
                at if at % 2 == 1 => INNER,
                _ => DISTAL,
            };
            (part.solid, *self.bodies[handle].position())
        });
        let palm = *self.bodies[self.hand.palm].position();
        let knuckles =
            (0..FINGERS).map(|finger| (KNUCKLE, palm * barrett::finger_base(finger, self.hand.spread)));
        parts.chain(knuckles).collect()
    }

    /// Where hand and object touch, with the forces of the last step.
    pub(super) fn touches(&self) -> Vec<Touch> {
        let mut touches = Vec::new();
        let object = self.object();
        let parts: Vec<RigidBodyHandle> =
            std::iter::once(self.hand.palm).chain(self.hand.links.into_iter().flatten()).collect();
        for pair in self.narrow.contact_pairs_with(self.object_collider) {
            let object_first = pair.collider1 == self.object_collider;
            let other = if object_first { pair.collider2 } else { pair.collider1 };
            let body = self.colliders.get(other).and_then(Collider::parent);
            let Some(part) = parts.iter().position(|part| Some(*part) == body) else { continue };
            let Some(at) = self.colliders.get(pair.collider1).map(Collider::position) else { continue };
            for manifold in pair.manifolds() {
                // The manifold's normal points out of the first collider.
                let into = if object_first { -manifold.data.normal } else { manifold.data.normal };
                for contact in manifold.contacts() {
                    let force = contact.data.impulse / DT;
                    if force <= 0.0 {
                        continue;
                    }
                    let point = at.transform_point(
                        manifold
                            .subshape_pos1()
                            .map_or(contact.local_p1, |sub| sub.transform_point(contact.local_p1)),
                    );
                    touches.push(Touch {
                        point: object.inverse_transform_point(point),
                        normal: object.inverse_transform_vector(into),
                        force,
                        part,
                    });
                }
            }
        }
        // The engine's order of pairs is its own affair.
        touches.sort_by(|a, b| {
            a.part.cmp(&b.part).then(a.point.z.total_cmp(&b.point.z)).then(a.point.x.total_cmp(&b.point.x))
        });
        touches
    }
}

fn parameters() -> IntegrationParameters {
    // At the defaults a held object sinks in by millimetres, creeps and tilts.
    let softness = SpringCoefficients::new(250.0, 5.0);
    IntegrationParameters {
        dt: DT,
        num_solver_iterations: 4,
        length_unit: 0.1,
        contact_softness: softness,
        static_contact_softness: softness,
        friction_in_bias_pass: true,
        contact_recycling: false,
        ..IntegrationParameters::default()
    }
}

/// A hinge about x at a frame of the parent that is the joint's at `open`; it may turn to 0 and to
/// `most`.
fn hinge(frame: Pose, open: f32, most: f32, share: f32) -> GenericJoint {
    let [stiffness, damping, force] = JOINT.map(|value| share * value);
    GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
        .local_frame1(frame)
        .limits(JointAxis::AngX, [-open, most - open])
        .motor_model(JointAxis::AngX, MotorModel::ForceBased)
        .motor_position(JointAxis::AngX, 0.0, stiffness, damping)
        .motor_max_force(JointAxis::AngX, force)
        .build()
}

fn finished(collider: ColliderBuilder) -> ColliderBuilder {
    collider.friction_combine_rule(CoefficientCombineRule::Min).restitution(0.0)
}

/// The engine's numbers are of single precision.
fn pose(pose: &Isometry3<f64>) -> Pose {
    let t = pose.translation.vector.map(|metres| metres as f32);
    let q = pose.rotation.coords.map(|part| part as f32);
    Pose::from_parts(Vector::new(t.x, t.y, t.z), Rotation::from_xyzw(q.x, q.y, q.z, q.w))
}

/// A cylinder about z as a prism: faces give the solver areas of contact, a curved surface single
/// points, which creep.
fn prism(radius: f32, half: f32) -> ColliderBuilder {
    let corners: Vec<Vector> = (0..SIDES)
        .flat_map(|side| {
            // A face, not an edge, looks along each axis: the cylinder lies on it.
            let (sin, cos) = (std::f32::consts::TAU * (side as f32 + 0.5) / SIDES as f32).sin_cos();
            [-half, half].map(|z| Vector::new(radius * cos, radius * sin, z))
        })
        .collect();
    ColliderBuilder::convex_hull(&corners).expect("a prism of checked sizes is a solid")
}
