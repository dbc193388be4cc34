//! The search against brute force.

use super::in_flight::{InFlight, exhaustive};
use super::learned::fit::fit;
use super::options::check;
use super::random::tables::{Buckets, Tables};
use super::random::{Entries, Random, RandomHash, RandomHyperplanes};
use super::simd::Simd;
use super::*;
use proptest::prelude::*;

const DIM: usize = 5;

/// Rows on a coarse grid, so that equal distances are frequent.
fn rows() -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec((0..4u8).prop_map(f32::from), DIM..60 * DIM).prop_map(|mut values| {
        values.truncate(values.len() / DIM * DIM);
        values
    })
}

fn brute_force(rows: Rows<'_>, query: &[f32]) -> Vec<Neighbour> {
    let measure = |id: u32| {
        let row = &rows.values[id as usize * DIM..][..DIM];
        let squared: f32 = row.iter().zip(query).map(|(a, b)| (a - b) * (a - b)).sum();
        Neighbour { id, distance: squared.sqrt() }
    };
    let mut all: Vec<Neighbour> = (0..rows.len() as u32).map(measure).collect();
    all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.id.cmp(&b.id)));
    all
}

fn nearest(rows: Rows<'_>, query: &[f32], k: usize) -> Vec<Neighbour> {
    exhaustive(rows.into(), &[], query, k, SearchCost::default()).expect("descriptors are kept").neighbours
}

fn random(rows: Rows<'_>, size: RandomHash, probes: u32, query: &[f32], k: usize) -> Search {
    let (normals, offsets) = random::draw(rows, size.tables, size.planes, 3);
    let hyperplanes = RandomHyperplanes { size, dim: DIM, normals: &normals, offsets: &offsets };
    let tables = Tables::build(rows, size.tables, size.buckets, |row, table| hyperplanes.home(row, table));
    let files = vec![Entries { buckets: tables.as_buckets(), count: rows.len(), first: 0 }];
    let hash = Hash::Random(Random { hyperplanes, files });
    InFlight::new(&hash).search(rows.into(), Simd::best(), query, k, probes)
}

proptest! {
    #[test]
    fn exact_search_is_brute_force(values in rows(), query in prop::array::uniform5(0.0..4.0f32), k in 1..70usize) {
        let rows = Rows { values: &values, dim: DIM };
        let found = exhaustive(rows.into(), &[], &query, k, SearchCost::default()).expect("descriptors are kept");
        let mut expected = brute_force(rows, &query);
        expected.truncate(k);
        prop_assert_eq!(found.neighbours.len(), expected.len());
        for (found, expected) in found.neighbours.iter().zip(&expected) {
            prop_assert!((found.distance - expected.distance).abs() < 1e-5);
        }
        prop_assert!(found.cost.exact && !found.cost.fell_back);
    }

    #[test]
    fn equal_distances_are_ordered_by_id(values in rows(), query in prop::array::uniform5(0..4u8), k in 1..70usize) {
        // On integers distances are exact, so that the order is one of ids wherever they are equal.
        let (rows, query) = (Rows { values: &values, dim: DIM }, query.map(f32::from));
        let mut expected = brute_force(rows, &query);
        expected.truncate(k);
        prop_assert_eq!(nearest(rows, &query, k), expected);
    }

    #[test]
    fn hashed_search_finds_the_nearest_of_its_candidates(
        values in rows(), query in prop::array::uniform5(0..4u8), k in 1..20usize, planes in 1..9u32, tables in 1..6u32, probes in 1..5u32
    ) {
        let (rows, query) = (Rows { values: &values, dim: DIM }, query.map(f32::from));
        let size = RandomHash { planes, tables, buckets: 16 };
        let found = random(rows, size, probes, &query, k);
        let all = brute_force(rows, &query);
        prop_assert_eq!(found.neighbours.len(), k.min(rows.len()));
        // In order, each once, at their true distances.
        let places: Vec<_> = found.neighbours.iter().map(|n| all.iter().position(|a| a == n)).collect();
        prop_assert!(places.iter().all(Option::is_some));
        prop_assert!(places.windows(2).all(|pair| pair[0] < pair[1]));
        if found.cost.fell_back {
            prop_assert!((found.cost.candidates as usize) < k);
            prop_assert_eq!(found.cost.share_of_database, 1.0);
        } else {
            prop_assert_eq!(found.cost.share_of_database, f64::from(found.cost.candidates) / rows.len() as f64);
        }
        // Where these hold too few entries, more are looked into.
        prop_assert!(found.cost.buckets >= tables * probes.min(planes + 1));
    }

    #[test]
    fn a_row_of_the_index_finds_itself(values in rows(), row in any::<prop::sample::Index>(), planes in 1..9u32) {
        let rows = Rows { values: &values, dim: DIM };
        let query = rows.get(row.index(rows.len()) as u32).unwrap_or_default();
        let size = RandomHash { planes, tables: 1, buckets: 64 };
        let found = random(rows, size, 1, query, 1);
        prop_assert_eq!(found.neighbours[0].distance, 0.0);
        prop_assert!(!found.cost.fell_back);
    }

    #[test]
    fn every_row_is_in_one_bucket_of_each_table(values in rows(), planes in 1..9u32) {
        let rows = Rows { values: &values, dim: DIM };
        let size = RandomHash { planes, tables: 3, buckets: 7 };
        let (normals, offsets) = random::draw(rows, size.tables, size.planes, 3);
        let hash = RandomHyperplanes { size, dim: DIM, normals: &normals, offsets: &offsets };
        let tables = Tables::build(rows, size.tables, size.buckets, |row, table| hash.home(row, table));
        for table in 0..3 {
            let mut ids: Vec<u32> = (0..7).flat_map(|b| tables.as_buckets().get(table * 7 + b).to_vec()).collect();
            ids.sort_unstable();
            prop_assert_eq!(ids, (0..rows.len() as u32).collect::<Vec<_>>());
        }
    }

    #[test]
    fn with_all_buckets_a_learned_search_is_brute_force(values in rows(), query in prop::array::uniform5(0..4u8), k in 1..20usize) {
        let (rows, query) = (Rows { values: &values, dim: DIM }, query.map(f32::from));
        let fitted = fit::<()>(rows, true, Simd::best(), &|_| Ok(())).expect("nothing stops it");
        let hash = Hash::Learned(fitted.as_learned());
        let all = brute_force(rows, &query);
        for simd in Simd::available() {
            let found = InFlight::new(&hash).search(rows.into(), simd, &query, k, hash.most_probes());
            prop_assert_eq!(found.neighbours.len(), k.min(rows.len()));
            // Of equally near ones, the codes may prefer any.
            for (found, true_one) in found.neighbours.iter().zip(&all) {
                prop_assert!(all.contains(found), "a distance is not the true one");
                prop_assert_eq!(found.distance, true_one.distance);
            }
        }
    }

    #[test]
    fn every_path_learns_the_same_hash(values in prop::collection::vec(-1.0..1.0f32, 40 * DIM..400 * DIM)) {
        let rows = Rows { values: &values[..values.len() / DIM * DIM], dim: DIM };
        let fitted = |simd| fit::<()>(rows, true, simd, &|_| Ok(())).expect("nothing stops it");
        let expected = fitted(Simd::best());
        for simd in Simd::available() {
            let other = fitted(simd);
            prop_assert_eq!(other.size, expected.size, "{}", simd.name());
            prop_assert_eq!(&other.axes.projection, &expected.axes.projection);
            for (other, expected) in [(&other.groups, &expected.groups), (&other.centres, &expected.centres), (&other.entries, &expected.entries)] {
                prop_assert!(other[..] == expected[..], "{}", simd.name());
            }
            prop_assert_eq!(&other.group_directory, &expected.group_directory);
            prop_assert_eq!(&other.bucket_directory, &expected.bucket_directory);
        }
    }

    #[test]
    fn every_row_is_in_one_learned_bucket(values in rows()) {
        let rows = Rows { values: &values, dim: DIM };
        let fitted = fit::<()>(rows, true, Simd::best(), &|_| Ok(())).expect("nothing stops it");
        let learned = fitted.as_learned();
        let mut ids: Vec<u32> =
            learned.files[0].blocks.iter().flat_map(|block| (0..blocks::LANES).map(move |lane| block.id(lane))).collect();
        ids.sort_unstable();
        ids.truncate(rows.len());
        prop_assert_eq!(ids, (0..rows.len() as u32).collect::<Vec<_>>());
    }

    #[test]
    fn more_probes_find_no_fewer_candidates(values in rows(), query in prop::array::uniform5(0.0..4.0f32)) {
        let rows = Rows { values: &values, dim: DIM };
        let candidates = |probes| {
            let size = RandomHash { planes: 6, tables: 2, buckets: 64 };
            random(rows, size, probes, &query, 1).cost.candidates
        };
        prop_assert!(candidates(1) <= candidates(2) && candidates(2) <= candidates(7));
    }
}

#[test]
fn a_nan_is_farther_than_anything() {
    let values = [f32::NAN, 9.0, 1.0];
    let rows = Rows { values: &values, dim: 1 };
    let ids: Vec<u32> = nearest(rows, &[0.0], 3).iter().map(|n| n.id).collect();
    assert_eq!(ids, [2, 1, 0]);
}

#[test]
fn what_overlapping_buckets_hold_is_looked_at_once() {
    let values: Vec<f32> = (0..2_000 * DIM).map(|at| ((at * 7919) % 1009) as f32).collect();
    let rows = Rows { values: &values, dim: DIM };
    let mut fitted = fit::<()>(rows, true, Simd::best(), &|_| Ok(())).expect("nothing stops it");
    let blocks = fitted.size.entry_blocks;
    let every_second = (0..).map(|bucket| if bucket % 2 == 0 { 0 } else { blocks });
    fitted.bucket_directory.iter_mut().zip(every_second).for_each(|(bound, all)| *bound = all);
    let hash = Hash::Learned(fitted.as_learned());
    let found = InFlight::new(&hash).search(rows.into(), Simd::best(), &[1.0; DIM], 3, hash.most_probes());
    assert!(found.cost.candidates <= blocks * blocks::LANES as u32, "{:?}", found.cost);
}

#[test]
fn buckets_that_make_no_sense_are_empty() {
    let buckets = Buckets { directory: &[2, 1, 900, 1], ids: &[0, 7, u32::MAX] };
    for bucket in [0, 1, 2, 3, u32::MAX] {
        assert!(buckets.get(bucket).is_empty(), "bucket {bucket}");
    }
}

#[test]
fn what_cannot_be_wanted_of_a_search_is_told() {
    let wrong = [
        Effort::Recall(0.0),
        Effort::Recall(1.01),
        Effort::Recall(f64::NAN),
        Effort::Success { eps: -0.1, success: 0.5 },
        Effort::Success { eps: f64::INFINITY, success: 0.5 },
        Effort::Success { eps: 0.05, success: 0.0 },
    ];
    for effort in wrong {
        let error = check(&[0.0], &SearchOptions { k: 1, effort }).expect_err("it cannot be");
        assert!(matches!(error, SearchError::Effort { .. }), "{effort:?}: {error}");
    }
    check(&[0.0], &SearchOptions { k: 1, effort: Effort::Success { eps: 0.0, success: 1.0 } })
        .expect("it can be");
}
