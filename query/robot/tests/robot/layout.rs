//! What is drawn.

use grasp_robot::{Object, Shape, Step, Strategy};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::{camera, close, hand, isometry, seen};

/// A box, a cylinder or a ball.
fn shapes() -> [(&'static str, Shape); 3] {
    [
        ("shape = 'box'\nsize = [0.16, 0.06, 0.10]", Shape::Box { size: [0.16, 0.06, 0.10] }),
        (
            "shape = 'cylinder'\nradius = 0.035\nheight = 0.16",
            Shape::Cylinder { radius: 0.035, height: 0.16 },
        ),
        ("shape = 'sphere'\nradius = 0.04", Shape::Sphere { radius: 0.04 }),
    ]
}

proptest! {
    /// However object and hand are turned: what is drawn is where the strategy's own numbers say
    /// that it is.
    #[test]
    fn a_drawing_shows_what_the_strategy_says(
        which in 0..3_usize,
        object_turn in prop::array::uniform3(-3.1f64..3.1),
        hand_turn in prop::array::uniform3(-3.1f64..3.1),
        far in -0.1f64..0.1,
    ) {
        let (description, shape) = shapes()[which];
        let [a, b, c] = object_turn;
        let world_from_object = Isometry3::from_parts(
            Vector3::new(0.5, -0.2, 0.6).into(), UnitQuaternion::from_euler_angles(a, b, c));
        let q = world_from_object.rotation.coords;
        let text = format!(
            "{description}\nposition = [0.5, -0.2, 0.6]\nquaternion_xyzw = [{}, {}, {}, {}]", q.x, q.y, q.z, q.w);
        let object = Object::parse("turned.toml", &text).unwrap();
        let [a, b, c] = hand_turn;
        let mut camera = camera();
        let world_from_hand = UnitQuaternion::from_euler_angles(a, b, c);
        // Held beside its middle.
        let grip = world_from_object * Point3::new(far, 0.02, -0.01);
        let wrist = grip - world_from_hand * Vector3::new(0.089, 0.013, -0.059);
        camera.hand = Some(camera.world_from_camera.inverse() * wrist);
        let mut barrett = hand("barrett");
        // Whatever goes between the fingers.
        barrett.grasp.values_mut().for_each(|grasp| grasp.widest = None);
        let strategy =
            Strategy::new(&barrett, &seen("large-diameter", world_from_hand, &camera), &object, &camera).unwrap();
        let layout = &strategy.layout;

        let is_near = |one: &Isometry3<f64>, other: &Isometry3<f64>| {
            (one.translation.vector - other.translation.vector).norm() < 1e-6
                && one.rotation.angle_to(&other.rotation) < 1e-5
        };
        prop_assert!(is_near(&isometry(&layout.object.pose), &world_from_object));
        let palm = isometry(&strategy.palm_in_world);
        prop_assert!(is_near(&(world_from_object * isometry(&strategy.palm)), &palm));
        let Some((from, distance)) = strategy.steps.iter().find_map(|step| match step {
            Step::Approach { from, distance, .. } => Some((from, *distance)),
            _ => None,
        }) else { panic!("no approach") };
        let start = world_from_object * isometry(from) * Isometry3::translation(0.0, 0.0, 0.08);
        prop_assert!(is_near(&isometry(&layout.palm_at_start), &start));
        prop_assert!(((start.translation.vector - palm.translation.vector).norm() - distance).abs() < 1e-6);
        let lifted = isometry(&layout.palm_lifted).translation.vector - palm.translation.vector;
        prop_assert!(close(lifted, Vector3::new(0.0, 0.0, 0.15)));

        for view in &layout.views {
            let [right, up] = [view.right, view.up].map(Vector3::from);
            prop_assert!(right.z.abs() < 1e-6 && right.dot(&up).abs() < 1e-5);
            let flat = |point: Vector3<f64>| [point.dot(&right), point.dot(&up)];
            let far = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            prop_assert!(far(view.approach[0], flat(start.translation.vector)) < 5e-6);
            prop_assert!(far(view.approach[1], flat(palm.translation.vector)) < 5e-6);
            // In every direction of the drawing the outline reaches as far as the shape does, but
            // for a circle's corners.
            for angle in 0..24 {
                let (sin, cos) = f64::from(15 * angle).to_radians().sin_cos();
                let direction = right * cos + up * sin;
                let expected = world_from_object.translation.vector.dot(&direction)
                    + shape.reach(&world_from_object.inverse_transform_vector(&direction));
                let reach = view.object.iter().map(|[x, y]| x * cos + y * sin).fold(f64::MIN, f64::max);
                prop_assert!((expected - reach).abs() < 2.5e-4, "{} {expected} {reach}", view.name);
            }
            for (drawn, points) in view.fingers.iter().zip(&layout.fingers) {
                prop_assert_eq!(drawn.len(), 3);
                prop_assert!(drawn.iter().zip(points).all(|(at, point)| far(*at, flat((*point).into())) < 5e-6));
            }
            prop_assert!(view.palm.len() > 3 && view.palm.iter().all(|at| far(*at, view.approach[1]) < 0.1));
        }
        prop_assert_eq!(layout.fingers.len(), 3);
    }
}
