//! Orientations and angles in few bytes: finer than any answer, and half as long as floating-point
//! numbers.

use nalgebra::{Quaternion, UnitQuaternion};

/// What a component of 1 becomes.
const ONE: f64 = i16::MAX as f64;
/// Steps of a degree.
const STEPS: f64 = 100.0;
/// One full turn in steps of a hundredth of a degree: every packed angle is below.
pub(crate) const TURN: u16 = 36_000;

/// A rotation in 8 bytes, x, y, z, w: at most 6e-5 radians (0.0035 degrees) off.
pub(crate) fn pack_rotation(rotation: &UnitQuaternion<f64>) -> [i16; 4] {
    let [x, y, z, w] = rotation.coords.map(|value| (value * ONE).round() as i16).into();
    [x, y, z, w]
}

/// The rotation; `None` where the numbers are none.
pub(crate) fn unpack_rotation(packed: [i16; 4]) -> Option<UnitQuaternion<f64>> {
    let [x, y, z, w] = packed.map(|value| f64::from(value) / ONE);
    let rotation = Quaternion::new(w, x, y, z);
    let is_unit = (rotation.norm() - 1.0).abs() < 1e-3;
    is_unit.then(|| UnitQuaternion::new_normalize(rotation))
}

/// The rotation that [`pack_rotation`] makes the same numbers of again; its length is only nearly
/// 1. `None` as above.
pub(crate) fn unpack_as_packed(packed: [i16; 4]) -> Option<UnitQuaternion<f64>> {
    unpack_rotation(packed)?;
    let [x, y, z, w] = packed.map(|value| f64::from(value) / ONE);
    Some(UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)))
}

/// An angle in hundredths of a degree, modulo a full turn.
pub(crate) fn pack_degrees(degrees: f32) -> u16 {
    let steps = (f64::from(degrees).rem_euclid(360.0) * STEPS).round() as u16;
    steps % TURN
}

/// The angle in degrees: from 0, or from -180 where `signed`, up to a full turn more.
pub(crate) fn unpack_degrees(packed: u16, signed: bool) -> f32 {
    let steps = f64::from(packed);
    let whole = if signed && steps >= f64::from(TURN) / 2.0 { steps - f64::from(TURN) } else { steps };
    (whole / STEPS) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector4;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_rotation_survives(coordinates in prop::array::uniform4(-1.0..1.0f64)) {
            prop_assume!(Vector4::from(coordinates).norm() > 0.01);
            let rotation = UnitQuaternion::new_normalize(Quaternion::from(Vector4::from(coordinates)));
            let unpacked = unpack_rotation(pack_rotation(&rotation)).expect("a rotation");
            prop_assert!(unpacked.angle_to(&rotation) < 6.2e-5, "{}", unpacked.angle_to(&rotation));
            let packed = pack_rotation(&rotation);
            let again = unpack_as_packed(packed).expect("a rotation");
            prop_assert_eq!(pack_rotation(&again), packed);
            // What a writer asks of an orientation.
            prop_assert!((again.norm() - 1.0).abs() < 1e-4);
        }

        #[test]
        fn an_angle_survives(degrees in -180.0..360.0f32) {
            let signed = degrees < 0.0;
            let packed = pack_degrees(degrees);
            prop_assert!(packed < TURN);
            prop_assert_eq!(pack_degrees(unpack_degrees(packed, signed)), packed);
            let off = (unpack_degrees(packed, signed) - degrees).rem_euclid(360.0);
            prop_assert!(off.min(360.0 - off) < 0.00502, "{off}");
        }
    }

    #[test]
    fn ends_of_the_ranges() {
        let turn = UnitQuaternion::identity().into_inner() * -1.0;
        assert_eq!(pack_rotation(&UnitQuaternion::new_unchecked(turn)), [0, 0, 0, -i16::MAX]);
        assert_eq!(unpack_rotation([0; 4]), None);
        assert_eq!(unpack_rotation([i16::MIN; 4]), None);
        assert_eq!([359.999, -0.001, 1e30, f32::MIN].map(|angle| pack_degrees(angle) < TURN), [true; 4]);
        assert_eq!(unpack_degrees(pack_degrees(-90.0), true), -90.0);
        assert_eq!(unpack_degrees(pack_degrees(351.5), false), 351.5);
    }
}
