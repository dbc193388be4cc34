//! What else there is before a camera: the person's other hand, and things that stand and lie about
//! on a table, many of them like the one that is held.
//!
//! None of it is of the hand that is asked about: in masks it is background.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::scene::{CameraScene, FIRST_OBJECT, FIRST_OF_COMPANY, PosedHand};
use super::shading::smoothed;
use super::surface_mesh::SurfaceMesh;
use super::things::solid::Lathe;
use super::wrist::Wrist;
use crate::mesh::Mesh;
use crate::random::{between, normal, unit};

type V = Vector3<f32>;

/// Numbers of the parts.
pub(super) const SECOND_HAND: u8 = FIRST_OF_COMPANY;
pub(super) const SECOND_ARM: u8 = FIRST_OF_COMPANY + 1;
/// The first of those that are made of a material, the table's, and the first of a thing's that is
/// made of the same as the one that is held, of a thing's that is not.
pub(super) const FIRST_MATERIAL: u8 = FIRST_OF_COMPANY + 2;
const SAME: u8 = FIRST_MATERIAL;
const OTHER: u8 = FIRST_MATERIAL + 3;
const TABLE: u8 = FIRST_MATERIAL + 5;

/// How often things stand and lie about, and how often on a table that is seen.
const RESTING: f64 = 0.35;
const ON_TABLE: f64 = 0.6;
/// How often the second hand holds something.
const HOLDING: f64 = 0.6;
/// The most things that are like the one that is held, and that are not.
const LIKE: f64 = 6.0;
const UNLIKE: f64 = 4.0;
/// How often one like it is made of the same.
const ALIKE: f64 = 0.6;
/// How far from each other two arms of a person point at most, by the cosine of the angle.
const ARMS: f32 = -0.35;
/// A side of the cells that bodies must not share, in metres, and how far from each other points
/// are that are looked at.
const CELL: f32 = 0.01;
/// Cells a side of the cube around the hand's frame in which they are told apart.
const CELLS: i32 = 104;
/// How far a body is moved out until it is free, by how much each time.
const FARTHEST: f32 = 0.4;
const STEP: f32 = 0.012;
/// Half a side of the table in metres, and in how many squares it lies.
const TABLE_HALF: f32 = 0.45;
const TABLE_SQUARES: u32 = 12;
/// How much of a table is one step of its material's pattern.
const TABLE_SCALE: f32 = 0.4;

/// What is about a hand while it is put together.
pub(super) struct Company<'a> {
    scene: &'a CameraScene,
    taken: Cells,
    out: SurfaceMesh,
}

impl<'a> Company<'a> {
    /// Whatever there is about a scene's hand: often nothing.
    pub(super) fn random(
        scene: &'a CameraScene,
        second: Option<&PosedHand>,
        rng: &mut ChaCha8Rng,
    ) -> SurfaceMesh {
        let is_resting = unit(rng) < RESTING;
        if second.is_none() && !is_resting {
            return SurfaceMesh::default();
        }
        let mut company = Self { scene, taken: Cells::new(), out: SurfaceMesh::default() };
        scene.own.points(CELL).for_each(|p| company.taken.insert(&p));
        if let Some(second) = second {
            company.second_hand(second, rng);
        }
        if is_resting {
            company.resting(rng);
        }
        company.out
    }

    /// The other hand of the same person, near what the first one holds.
    fn second_hand(&mut self, hand: &PosedHand, rng: &mut ChaCha8Rng) {
        let wrist = Wrist::random(rng);
        let mut body = hand.with_arm(self.scene.arm_width(), &wrist, [SECOND_HAND, SECOND_ARM]);
        if unit(rng) < HOLDING {
            for (part, mesh) in hand.things(rng).iter().enumerate() {
                body.add(mesh, OTHER + part as u8 % 3);
            }
        }
        let mut holds_at: V = hand.holds_at().cast();
        body.mirror();
        holds_at.y = -holds_at.y;
        let turn = (0..20)
            .map(|_| any_turn(rng))
            .find(|turn| (turn * -V::x()).dot(&-V::x()) > ARMS)
            .unwrap_or_else(UnitQuaternion::identity);
        body.place(&Isometry3::from_parts(Translation3::from(turn * -holds_at), turn));
        let direction = any_turn(rng) * V::x();
        self.settle(body, self.middle(), direction, 0.06 * unit(rng) as f32);
    }

    /// Things that stand and lie on what is below the hand.
    fn resting(&mut self, rng: &mut ChaCha8Rng) {
        let scene = self.scene;
        let up: V = scene.world_from_hand.inverse_transform_vector(&Vector3::z()).cast();
        let lowest = |vertices: &[V]| vertices.iter().map(|v| up.dot(v)).fold(f32::MAX, f32::min);
        let own = &scene.own.vertices;
        let floor = lowest(&own[..scene.hand_vertices]).min(lowest(&own[scene.things_from..]));
        // An arm does not come out of a table.
        if lowest(own) < floor - 0.03 {
            return;
        }
        let floor = floor - if unit(rng) < 0.5 { 0.001 } else { 0.05 * unit(rng) as f32 };
        let middle = self.middle();
        let ground = middle - up * (up.dot(&middle) - floor);
        if unit(rng) < ON_TABLE {
            self.out.append(&table(&ground, &up, rng));
        }
        let like = scene.own.from(scene.things_from);
        let count = if like.triangles.is_empty() { 0.0 } else { LIKE * unit(rng) };
        for _ in 0..count as u32 {
            let mut body = like.clone();
            let first = if unit(rng) < ALIKE { SAME } else { OTHER };
            body.triangles.iter_mut().for_each(|(_, part)| *part = first + (*part - FIRST_OBJECT) % 3);
            self.rest(body, (&ground, &up), rng);
        }
        for _ in 0..(UNLIKE * unit(rng)) as u32 {
            let mut body = SurfaceMesh::default();
            body.add(&smoothed(&any_body(rng)), OTHER + (2.0 * unit(rng)) as u8);
            self.rest(body, (&ground, &up), rng);
        }
    }

    /// Puts a body down somewhere near the hand.
    fn rest(&mut self, mut body: SurfaceMesh, (ground, up): (&V, &V), rng: &mut ChaCha8Rng) {
        let tipped = match unit(rng) {
            x if x < 0.5 => UnitQuaternion::identity(),
            x if x < 0.85 => UnitQuaternion::from_axis_angle(&level(up, rng), std::f32::consts::FRAC_PI_2),
            _ => any_turn(rng),
        };
        let yaw = std::f32::consts::TAU * unit(rng) as f32;
        let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(*up), yaw) * tipped;
        let middle = middle(&body.vertices);
        body.place(&Isometry3::from_parts(Translation3::from(turn * -middle), turn));
        let lowest = body.vertices.iter().map(|v| up.dot(v)).fold(f32::MAX, f32::min);
        let at = ground - up * lowest;
        let direction = level(up, rng);
        self.settle(body, at, *direction, 0.15 * (unit(rng) * unit(rng)) as f32);
    }

    /// Adds a body at the first place from `from` along a direction where it meets nothing; not at
    /// all where there is none near enough.
    fn settle(&mut self, mut body: SurfaceMesh, from: V, direction: V, nearest: f32) {
        let points: Vec<V> = body.points(CELL).collect();
        let mut far = nearest;
        while far < FARTHEST {
            let to = from + direction * far;
            if !points.iter().any(|p| self.taken.contains(&(p + to))) {
                body.place(&Isometry3::from_parts(Translation3::from(to), UnitQuaternion::identity()));
                points.iter().for_each(|p| self.taken.insert(&(p + to)));
                self.out.append(&body);
                return;
            }
            far += STEP;
        }
    }

    /// The middle of what the hand holds, or of the hand.
    fn middle(&self) -> V {
        let CameraScene { own, things_from, hand_vertices, .. } = self.scene;
        match own.vertices.get(*things_from..) {
            Some(things) if !things.is_empty() => middle(things),
            _ => middle(&own.vertices[..*hand_vertices]),
        }
    }
}

/// In which cells something is; what is far out of the picture is in none.
struct Cells(Vec<bool>);

impl Cells {
    fn new() -> Self {
        Self(vec![false; CELLS.pow(3) as usize])
    }

    fn insert(&mut self, p: &V) {
        if let Some(at) = Self::at(p) {
            self.0[at] = true;
        }
    }

    fn contains(&self, p: &V) -> bool {
        Self::at(p).is_some_and(|at| self.0[at])
    }

    fn at(p: &V) -> Option<usize> {
        let axis = |v: f32| Some((v / CELL).floor() as i32 + CELLS / 2).filter(|at| (0..CELLS).contains(at));
        Some(((axis(p.x)? * CELLS + axis(p.y)?) * CELLS + axis(p.z)?) as usize)
    }
}

/// Of the box around the points.
fn middle(points: &[V]) -> V {
    let (mut low, mut high) = (V::repeat(f32::MAX), V::repeat(f32::MIN));
    points.iter().for_each(|p| (low, high) = (low.inf(p), high.sup(p)));
    (low + high) * 0.5
}

fn any_turn(rng: &mut ChaCha8Rng) -> UnitQuaternion<f32> {
    let four = nalgebra::Vector4::from_fn(|_, _| normal(rng) as f32);
    UnitQuaternion::new_normalize(nalgebra::Quaternion::from(four))
}

/// A random direction across `up`.
fn level(up: &V, rng: &mut ChaCha8Rng) -> Unit<V> {
    let any = any_turn(rng) * V::x();
    let across = any - up * up.dot(&any);
    Unit::try_new(across, 1e-3).unwrap_or_else(|| Unit::new_normalize(up.cross(&V::new(0.6, 0.64, 0.48))))
}

/// A can, a block, a ball, a lid, a rod, or a rack of boards.
fn any_body(rng: &mut ChaCha8Rng) -> Mesh {
    let mut size = |low: f64, high: f64| low * libm::pow(high / low, unit(rng));
    let (radius, long) = (size(0.008, 0.045), size(0.01, 0.16));
    let sides = [size(0.01, 0.12), size(0.01, 0.12), long];
    let body = match unit(rng) {
        x if x < 0.33 => Lathe::cylinder(radius, long),
        x if x < 0.53 => Lathe::cuboid(sides),
        x if x < 0.7 => Lathe::ball(radius),
        x if x < 0.82 => {
            let top = radius * between(rng, [0.2, 1.3]);
            Lathe::round(vec![[0.0, 0.0], [radius, 0.0], [radius, 0.6 * long], [top, long], [0.0, long]])
        }
        _ => return rack(rng),
    };
    body.mesh(&Isometry3::identity())
}

/// Boards beside each other: of a box, a shelf, a back of a chair.
fn rack(rng: &mut ChaCha8Rng) -> Mesh {
    let mut size = |low: f64, high: f64| low * libm::pow(high / low, unit(rng));
    let board = Lathe::cuboid([size(0.006, 0.05), size(0.004, 0.05), size(0.08, 0.5)]);
    let (apart, count) = (size(0.02, 0.09), size(1.5, 8.0) as u32);
    let mut out = Mesh::default();
    for at in 0..count {
        out.append(&board.mesh(&Isometry3::translation(apart * f64::from(at), 0.0, 0.0)));
    }
    out
}

/// A plate across `up`, seen from above alone.
fn table(ground: &V, up: &V, rng: &mut ChaCha8Rng) -> SurfaceMesh {
    let x = level(up, rng);
    let y = up.cross(&x);
    let side = TABLE_SQUARES + 1;
    let along = |at: u32| (at as f32 / TABLE_SQUARES as f32 * 2.0 - 1.0) * TABLE_HALF;
    let corners = (0..side * side).map(|at| [at % side, at / side].map(along));
    let mut out = SurfaceMesh::default();
    for [right, far] in corners {
        out.vertices.push(ground + *x * right + y * far);
        out.places.push(V::new(right, far, 0.0) * TABLE_SCALE);
    }
    out.normals = vec![*up; out.vertices.len()];
    out.marks.resize(out.vertices.len(), Default::default());
    for square in 0..TABLE_SQUARES * TABLE_SQUARES {
        let a = square / TABLE_SQUARES * side + square % TABLE_SQUARES;
        let (b, c, d) = (a + 1, a + side, a + side + 1);
        out.triangles.extend([([a, b, d], TABLE), ([a, d, c], TABLE)]);
    }
    out
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::camera::Randomised;
    use crate::plan::{Preset, RenderPlan};
    use crate::view::View;

    fn hand(scene: usize) -> PosedHand {
        PosedHand::build(&RenderPlan::preset(Preset::Paper).scenes()[scene]).expect("a scene")
    }

    fn company(second: Option<&PosedHand>, seed: u64) -> CameraScene {
        hand(seed as usize % 6).dressed(true, Randomised::ALL, seed).in_company(second, seed)
    }

    fn has(scene: &CameraScene, is_part: impl Fn(u8) -> bool) -> bool {
        scene.company.triangles.iter().any(|(_, part)| is_part(*part))
    }

    #[test]
    fn the_same_seed_has_the_same_company_and_often_there_is_none() {
        let scenes: Vec<_> = (0..40).map(|seed| company(None, seed)).collect();
        assert_eq!(scenes[3].company.vertices, company(None, 3).company.vertices);
        let alone = scenes.iter().filter(|scene| scene.company.triangles.is_empty()).count();
        assert!((20..38).contains(&alone), "{alone}");
        let count = |first: u8| {
            let is_in = |part| (first..first + 3).contains(&part);
            scenes.iter().filter(|scene| has(scene, is_in)).count()
        };
        assert!(count(SAME) > 1 && count(OTHER) > 1);
        let none = Randomised { company: false, ..Randomised::ALL };
        let second = hand(1);
        let alone = hand(0).dressed(true, none, 1).in_company(Some(&second), 1);
        assert!(alone.company.triangles.is_empty());
    }

    #[test]
    fn a_second_hand_is_near_and_goes_through_neither_hand_nor_thing() {
        let second = hand(5);
        let mut near = 0;
        for seed in 0..12 {
            let scene = company(Some(&second), seed);
            let is_skin = |(_, part): &&([u32; 3], u8)| *part == SECOND_HAND;
            let corners = scene.company.triangles.iter().filter(is_skin).flat_map(|(corners, _)| corners);
            let points: Vec<V> = corners.map(|&v| scene.company.vertices[v as usize]).step_by(40).collect();
            let own: Vec<V> = scene.own.vertices.iter().copied().step_by(7).collect();
            let distances = points.iter().flat_map(|p| own.iter().map(move |q| (p - q).norm()));
            let nearest = distances.fold(f32::MAX, f32::min);
            near += u32::from(nearest < 0.15);
            // Bodies share no cell, but may touch at its sides.
            assert!(nearest > 1e-4, "{nearest} m");
        }
        assert!(near >= 8, "{near} of 12 are near");
    }

    #[test]
    fn tables_are_seen_from_above_below_the_hand_and_what_stands_on_them_stands_above() {
        let mut tables = 0;
        for seed in 0..60 {
            let scene = company(None, seed);
            let up: V = scene.world_from_hand.inverse_transform_vector(&Vector3::z()).cast();
            let heights = |is_part: &dyn Fn(u8) -> bool| -> Vec<f32> {
                let of = scene.company.triangles.iter().filter(|(_, part)| is_part(*part));
                of.flat_map(|(corners, _)| corners.map(|v| up.dot(&scene.company.vertices[v as usize])))
                    .collect()
            };
            let table = heights(&|part| part == TABLE);
            let Some(&height) = table.first() else { continue };
            tables += 1;
            assert!(table.iter().all(|h| (h - height).abs() < 1e-4));
            assert!(heights(&|part| part != TABLE).iter().all(|h| *h > height - 1e-4));
            let own = scene.own.vertices[..scene.hand_vertices].iter().map(|v| up.dot(v));
            assert!(own.fold(f32::MAX, f32::min) > height);
            let normal = |([a, b, c], _): &([u32; 3], u8)| {
                let [a, b, c] = [a, b, c].map(|v| scene.company.vertices[*v as usize]);
                (b - a).cross(&(c - a)).normalize().dot(&up)
            };
            let of_table = scene.company.triangles.iter().filter(|(_, part)| *part == TABLE);
            assert!(of_table.map(normal).all(|along| along > 0.99));
        }
        assert!(tables > 3, "{tables}");
    }

    #[test]
    fn hands_are_not_hidden_by_what_is_about_them() {
        let second = hand(5);
        for seed in 0..24 {
            let view = View::random(&mut ChaCha8Rng::seed_from_u64(seed));
            let alone = hand(seed as usize % 6).dressed(true, Randomised::ALL, seed).layers(&view, 4.0);
            let seen = company(Some(&second), seed).layers(&view, 4.0);
            // The thing may be hidden more than the hand: the sum of both counts.
            assert!(
                seen.hand_area() >= 0.5 * alone.hand_area(),
                "{} of {}",
                seen.hand_area(),
                alone.hand_area()
            );
        }
    }
}
