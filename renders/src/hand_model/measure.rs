//! The measures of a model, taken from its joints and from the skin around them, and its place in
//! the hand frame.

use nalgebra::{Matrix3, Vector3};

use super::error::HandModelError;
use super::fault::NotAHand;
use super::rig::{Joint, PALM, Rig, Skin, bone};
use crate::hand::{Chain, Digit, FingerMeasures, HandShape, Skeleton, WRIST_CUT};

type V = Vector3<f64>;

/// Lengths that a hand may have in metres, from the wrist to the tip of the middle finger.
const LENGTHS: [f64; 2] = [0.10, 0.30];
/// Lengths and breadths that a bone and its flesh may have, as shares of those of a mean hand of
/// this length.
const SHARES: [f64; 2] = [0.4, 2.5];
/// Skin is measured before a joint as far as this share of the shorter bone beside it.
const AROUND: f64 = 0.3;
/// The thumb and the bent fingertips must lie this far to one side of the back's plane, in hand
/// lengths, summed up.
const SIDED: f64 = 0.08;
/// Joints whose own axes lie within this cosine of the bone are taken to be WebXR's.
const ALIKE: f64 = 0.8;
/// How deep the mean hand's palm lies below the middle metacarpal, as a share of its thickness; and
/// how much wider its skin is around the wrist than the wrist's measures.
const PALM_DEPTH: f64 = 0.85;
const WRIST_SKIN: f64 = 1.13;
/// The pronation, in radians, of a thumb whose joint axes do not show it: as in a relaxed hand.
const PRONATION: f64 = 1.48;

/// Where a model's bones are at rest, in the hand frame.
#[derive(Debug)]
pub(super) struct RestPose {
    /// Of each digit, where its bones begin, and their axes: along the bone, to the thumb's side,
    /// out of the nail.
    pub(super) bones: [[(V, Matrix3<f64>); 3]; 5],
    /// The middle of the wrist, y and z.
    pub(super) wrist: [f64; 2],
    /// How far back the mesh goes: the lowest x.
    pub(super) end: f64,
    /// Whether the model was mirrored.
    pub(super) was_left: bool,
}

impl RestPose {
    /// The first joint of each digit.
    pub(super) fn roots(&self) -> [V; 5] {
        self.bones.map(|digit| digit[0].0)
    }
}

/// Measures a model, and moves it into the hand frame.
pub(super) fn measure(name: &str, mut rig: Rig) -> Result<(HandShape, RestPose, Skin), HandModelError> {
    let was_left = is_left(&rig)?;
    if was_left {
        map(&mut rig, |v| V::new(-v.x, v.y, v.z));
    }
    let turn = into_hand(&rig)?;
    let wrist = rig.wrist;
    map(&mut rig, |v| turn * v);
    let origin = turn * wrist;
    shift(&mut rig, -origin);
    turn_outward(&mut rig.skin);

    let mean = Skeleton::new(&HandShape::mean());
    let shape = shape(name, &rig, &mean)?;
    let skeleton = Skeleton::with_roots(&shape, rig.digits.map(|joints| joints[0].at));
    let bones = Digit::ALL.map(|digit| rest_bones(&rig, &skeleton, digit));
    let palm = |vertex: &&super::rig::Vertex| vertex.bone() == PALM;
    let end = rig.skin.vertices.iter().filter(palm).map(|vertex| vertex.at.x).fold(f64::INFINITY, f64::min);
    if !(-0.5..0.5 * shape.palm_length).contains(&end) {
        return Err(NotAHand::NoPalm.into());
    }
    let [y, z] = wrist_box(&rig.skin).unwrap_or_default().map(|[low, high]| 0.5 * (low + high));
    Ok((shape, RestPose { bones, wrist: [y, z], end, was_left }, rig.skin))
}

/// Applies a linear map to everything.
fn map(rig: &mut Rig, f: impl Fn(V) -> V) {
    rig.wrist = f(rig.wrist);
    for Joint { at, forward, up } in rig.digits.iter_mut().flatten() {
        (*at, *forward, *up) = (f(*at), f(*forward), f(*up));
    }
    for vertex in &mut rig.skin.vertices {
        vertex.at = f(vertex.at);
    }
}

fn shift(rig: &mut Rig, by: V) {
    rig.wrist += by;
    for joint in rig.digits.iter_mut().flatten() {
        joint.at += by;
    }
    for vertex in &mut rig.skin.vertices {
        vertex.at += by;
    }
}

/// From the little finger's knuckle to the index finger's.
fn across(rig: &Rig) -> V {
    rig.digits[Digit::Index as usize][0].at - rig.digits[Digit::Little as usize][0].at
}

/// Axes of a hand that points along `x` and has its thumb at `side`.
fn axes(x: V, side: V) -> Option<Matrix3<f64>> {
    let x = x.try_normalize(1e-6)?;
    let z = x.cross(&side).try_normalize(1e-6)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), z])).filter(|m| m.iter().all(|v| v.is_finite()))
}

/// Whether thumb and fingertips lie where the back of a right hand would be.
fn is_left(rig: &Rig) -> Result<bool, HandModelError> {
    let middle = rig.digits[Digit::Middle as usize];
    let axes = axes(middle[0].at - rig.wrist, across(rig)).ok_or(NotAHand::NoRestPose)?;
    let length = (middle[3].at - rig.wrist).norm();
    let up = axes.column(2);
    let thumb: f64 = rig.digits[0].iter().map(|joint| (joint.at - rig.wrist).dot(&up)).sum();
    let bent: f64 = rig.digits[1..].iter().map(|joints| (joints[3].at - joints[0].at).dot(&up)).sum();
    let up = (thumb + bent) / length;
    if up.is_nan() || up.abs() < SIDED {
        return Err(NotAHand::Flat.into());
    }
    Ok(up > 0.0)
}

/// The turn into the hand frame: along the middle metacarpal, and about it so that the knuckles lie
/// like a mean hand's.
fn into_hand(rig: &Rig) -> Result<Matrix3<f64>, HandModelError> {
    let mean = Skeleton::new(&HandShape::mean());
    let theirs = axes(rig.digits[Digit::Middle as usize][0].at - rig.wrist, across(rig));
    let ours = axes(V::x(), mean.root(Digit::Index) - mean.root(Digit::Little));
    match (ours, theirs) {
        (Some(ours), Some(theirs)) => Ok(ours * theirs.transpose()),
        _ => Err(NotAHand::OnOneLine.into()),
    }
}

/// Turns all triangles round if they show their inner side.
fn turn_outward(skin: &mut Skin) {
    let count = skin.vertices.len().max(1) as f64;
    let centre = skin.vertices.iter().map(|vertex| vertex.at).sum::<V>() / count;
    let at = |i: u32| skin.vertices[i as usize].at - centre;
    let volume: f64 = skin.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c)))).sum();
    if volume < 0.0 {
        for triangle in &mut skin.triangles {
            triangle.swap(1, 2);
        }
    }
}

fn shape(name: &str, rig: &Rig, mean: &Skeleton) -> Result<HandShape, HandModelError> {
    let typical = mean.shape();
    let palm_length = rig.digits[Digit::Middle as usize][0].at.x;
    let middle = rig.digits[Digit::Middle as usize].map(|joint| joint.at);
    let length = palm_length + middle.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    if !(LENGTHS[0]..=LENGTHS[1]).contains(&length) {
        return Err(NotAHand::Length { metres: length, least: LENGTHS[0], most: LENGTHS[1] }.into());
    }
    if rig.skin.vertices.iter().any(|vertex| vertex.at.norm() > 1.0) {
        return Err(NotAHand::FarPart.into());
    }
    let scale = length / typical.length();
    let checked = |what: &str, value: f64, mean: f64| {
        let share = value / (mean * scale);
        if (SHARES[0]..=SHARES[1]).contains(&share) {
            return Ok(value);
        }
        Err(NotAHand::Measure { what: what.to_owned(), metres: value, share })
    };
    let mut digits = typical.digits;
    for (digit, measures) in Digit::ALL.into_iter().zip(&mut digits) {
        *measures = finger(rig, digit, measures, scale);
        let typical = &typical.digits[digit as usize];
        for (i, (bone, mean)) in measures.bones.iter().zip(typical.bones).enumerate() {
            checked(&format!("{}'s bone {}", digit.name(), i + 1), *bone, mean)?;
        }
    }
    // As wide as a mean hand, for knuckles that are as far apart.
    let span = mean.root(Digit::Index).y - mean.root(Digit::Little).y;
    let palm_breadth = across(rig).y / span * typical.palm_breadth;
    let thick = palm_thickness(&rig.skin, palm_length, palm_breadth);
    let [breadth, thickness] = wrist_box(&rig.skin)
        .map_or([typical.wrist_breadth * scale, typical.wrist_thickness * scale], |sides| {
            sides.map(|[low, high]| (high - low) / WRIST_SKIN)
        });
    let clamped = |value: f64, mean: f64| value.clamp(SHARES[0] * mean * scale, SHARES[1] * mean * scale);
    Ok(HandShape {
        name: name.to_owned(),
        palm_length: checked("palm's length", palm_length, typical.palm_length)?,
        palm_breadth: checked("palm's breadth", palm_breadth, typical.palm_breadth)?,
        palm_thickness: clamped(thick.unwrap_or(typical.palm_thickness * scale), typical.palm_thickness),
        wrist_breadth: clamped(breadth, typical.wrist_breadth),
        wrist_thickness: clamped(thickness, typical.wrist_thickness),
        digits,
    })
}

/// A digit's measures; `typical` ones stand in where there is no skin to measure.
fn finger(rig: &Rig, digit: Digit, typical: &FingerMeasures, scale: f64) -> FingerMeasures {
    let joints = rig.digits[digit as usize].map(|joint| joint.at);
    let lengths: [f64; 3] = std::array::from_fn(|i| (joints[i + 1] - joints[i]).norm());
    // Flesh before a joint, at right angles to the two bones' common direction: behind it may be
    // the thumb's web.
    let radius = |joint: usize| {
        let along = (joints[joint + 1] - joints[joint - 1]).try_normalize(1e-9)?;
        let reach = AROUND * lengths[joint - 1].min(lengths[joint]);
        let mut around: Vec<f64> = rig
            .skin
            .vertices
            .iter()
            .filter(|vertex| (bone(digit, 0)..=bone(digit, 2)).contains(&vertex.bone()))
            .map(|vertex| vertex.at - joints[joint])
            .filter(|from| (0.0..reach).contains(&from.dot(&along)))
            .map(|from| from.cross(&along).norm())
            .collect();
        around.sort_by(f64::total_cmp);
        around.get(around.len() / 2).copied()
    };
    let mean = Skeleton::new(&HandShape::mean()).chain(digit, &[0.0; 5]).radii;
    let breadth = |joint: usize, typical: f64| {
        let fleshy = radius(joint).map_or(typical * scale, |radius| typical * radius / mean[joint]);
        fleshy.clamp(SHARES[0] * typical * scale, SHARES[1] * typical * scale)
    };
    // A bone ends where its flesh does; a file's tip may lie inside.
    let along = (joints[3] - joints[2]).try_normalize(1e-9).unwrap_or_else(V::x);
    let flesh = rig.skin.vertices.iter().filter(|vertex| vertex.bone() == bone(digit, 2));
    let end = flesh.map(|vertex| (vertex.at - joints[2]).dot(&along)).fold(lengths[2], f64::max);
    FingerMeasures {
        bones: [lengths[0], lengths[1], end],
        breadth: breadth(1, typical.breadth),
        tip_breadth: breadth(2, typical.tip_breadth),
    }
}

/// Of a hand whose palm's skin lies as deep below the middle metacarpal as here: objects are laid
/// against it.
fn palm_thickness(skin: &Skin, length: f64, breadth: f64) -> Option<f64> {
    let inside = |v: &V| (0.5..0.95).contains(&(v.x / length)) && v.y.abs() < 0.2 * breadth;
    let palm = skin.vertices.iter().filter(|vertex| vertex.bone() == PALM).map(|vertex| vertex.at);
    bounds(palm.filter(inside).map(|v| v.z)).map(|[low, _]| -low / PALM_DEPTH)
}

/// The skin around the wrist: lowest and highest y, lowest and highest z.
fn wrist_box(skin: &Skin) -> Option<[[f64; 2]; 2]> {
    let near = |v: &V| (-1.5 * WRIST_CUT..0.5 * WRIST_CUT).contains(&v.x);
    let wrist = || skin.vertices.iter().filter(|c| c.bone() == PALM).map(|c| c.at).filter(near);
    Some([bounds(wrist().map(|v| v.y))?, bounds(wrist().map(|v| v.z))?])
}

fn bounds(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    (high > low).then_some([low, high])
}

/// Where a digit's bones begin at rest, and their axes. The axis about which they bend is told by
/// the joints' own axes, where these are WebXR's; otherwise it is that of our skeleton in the same
/// place.
fn rest_bones(rig: &Rig, skeleton: &Skeleton, digit: Digit) -> [(V, Matrix3<f64>); 3] {
    let joints = &rig.digits[digit as usize];
    let along: [V; 3] =
        std::array::from_fn(|i| (joints[i + 1].at - joints[i].at).try_normalize(1e-9).unwrap_or_else(V::x));
    let told = || {
        let mut sum = V::zeros();
        for (joint, along) in joints.iter().zip(&along) {
            if joint.forward.try_normalize(1e-9)?.dot(along) < ALIKE {
                return None;
            }
            sum += joint.up.try_normalize(1e-9)?.cross(along);
        }
        sum.try_normalize(0.5)
    };
    let axis = told().unwrap_or_else(|| bend_axis(&skeleton.along(digit, &along[0], PRONATION)));
    std::array::from_fn(|i| (joints[i].at, bone_axes(&along[i], &axis)))
}

/// The axis about which the bones of a posed digit bend: across them, to the thumb's side.
pub(super) fn bend_axis(chain: &Chain) -> V {
    chain.nail.cross(&(chain.points[3] - chain.points[2])).normalize()
}

/// Axes of a bone, with the nail's side at right angles to the bone and to the axis about which it
/// bends.
pub(super) fn bone_axes(along: &V, axis: &V) -> Matrix3<f64> {
    let nail = along.cross(axis).try_normalize(1e-9).unwrap_or_else(V::z);
    Matrix3::from_columns(&[*along, nail.cross(along), nail])
}
