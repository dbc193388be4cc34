//! Every path against the plain loops, bit by bit, and those against the definition.

use super::*;
use crate::search::blocks::{self, BlockMut, CodeBits, LANES};
use crate::search::distance;
use crate::search::smallest::Smallest;
use proptest::prelude::*;
use rkyv::util::AlignedVec;

/// Blocks of entries with codes of so many bits, or of centres.
fn block_bytes(axes: usize, vectors: &[(Vec<i8>, f32)], entries: Option<CodeBits>) -> AlignedVec<64> {
    let stride = match entries {
        Some(bits) => blocks::entry_stride(axes, bits),
        None => blocks::centre_stride(axes),
    };
    let mut bytes = AlignedVec::new();
    bytes.resize(vectors.len().div_ceil(LANES) * stride, 0);
    for (block, bytes) in bytes.chunks_exact_mut(stride).enumerate() {
        let mut into = BlockMut::new(bytes, axes, entries.unwrap_or(CodeBits::Eight));
        for lane in 0..LANES {
            match vectors.get(block * LANES + lane) {
                Some((codes, scalar)) => {
                    let id = entries.map(|_| 1000 - (block * LANES + lane) as u32);
                    into.put(lane, codes, *scalar, id);
                }
                None => into.put_nothing(lane),
            }
        }
    }
    bytes
}

/// A number of axes, codes with their scalars, and a query.
type Vectors = (usize, Vec<(Vec<i8>, f32)>, Vec<f32>);

fn vectors() -> impl Strategy<Value = Vectors> {
    (1..40usize).prop_flat_map(|fours| {
        let axes = 4 * fours;
        let vector = (prop::collection::vec(-127..=127i8, axes), -2.0..2.0f32);
        (Just(axes), prop::collection::vec(vector, 1..150), prop::collection::vec(-3.0..3.0f32, axes))
    })
}

proptest! {
    #[test]
    fn every_path_gives_the_same_scores((axes, mut vectors, query) in vectors(), entries in prop_oneof![Just(None), Just(Some(CodeBits::Four)), Just(Some(CodeBits::Eight))], is_of_codes: bool, keep in 1..60usize, factor in 0.0..1e-3f32, base in -2.0..2.0f32) {
        if entries == Some(CodeBits::Four) {
            vectors.iter_mut().flat_map(|(codes, _)| codes).for_each(|code| *code %= 8);
        }
        let bytes = block_bytes(axes, &vectors, entries);
        let run = match entries {
            Some(bits) => Blocks::of_entries(&bytes, axes, bits),
            None => Blocks::of_centres(&bytes, axes),
        };
        let mut quantised = QuantisedQuery::default();
        if is_of_codes {
            quantised.set_codes(&query.iter().map(|value| (40.0 * value) as i8).collect::<Vec<i8>>(), 0.025);
        } else {
            quantised.set(&query);
        }
        let by = |simd: Simd| {
            let mut smallest = Smallest::default();
            smallest.reset(keep);
            smallest.scan(simd, [(base, run)].into_iter(), &quantised, factor);
            smallest.sorted().collect::<Vec<_>>()
        };
        let mut expected: Vec<(f32, u32)> = (0u32..)
            .zip(&vectors)
            .map(|(at, (codes, scalar))| {
                let dot: i64 = codes.iter().zip(&quantised.values).map(|(&c, &v)| i64::from(c) * i64::from(v)).sum();
                (base + (scalar - factor * dot as f32), if entries.is_some() { 1000 - at } else { at })
            })
            .collect();
        expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        expected.truncate(keep);
        for simd in Simd::available() {
            prop_assert_eq!(by(simd), &expected[..], "{}", simd.name());
        }
    }

    #[test]
    fn every_path_finds_the_same_places(scores in prop::collection::vec(prop_oneof![-3.0..3.0f32, Just(1.0), Just(f32::NAN), Just(f32::INFINITY)], 0..20 * LANES), bound in prop_oneof![-3.0..3.0f32, Just(1.0), Just(f32::MAX)]) {
        let scores = &scores[..scores.len() / LANES * LANES];
        let expected: Vec<u32> = (0..).zip(scores).filter_map(|(at, &score)| (score <= bound).then_some(at)).collect();
        for simd in Simd::available() {
            let mut found = vec![7; 5];
            simd.near(scores, bound, &mut found);
            prop_assert_eq!(&found, &expected, "{}", simd.name());
        }
    }

    #[test]
    fn every_path_measures_alike(query in prop::collection::vec(-1.0..1.0f32, 1..200), row in prop::collection::vec(-1.0..1.0f32, 200)) {
        let row = &row[..query.len()];
        for simd in Simd::available() {
            let mut found = Vec::new();
            simd.distances(&query, [row, &query].into_iter(), |at, squared| found.push((at, squared)));
            prop_assert_eq!(found, [(0, distance::squared(&query, row)), (1, 0.0)], "{}", simd.name());
        }
    }

    #[test]
    fn every_path_measures_rows_of_halves_alike(query in prop::collection::vec(-1.0..1.0f32, 1..200), row in prop::collection::vec(-1.0..1.0f32, 200)) {
        let halves: Vec<f16> = row[..query.len()].iter().copied().map(f16::from_f32).collect();
        let expected = distance::squared(&query, &halves.to_f32_vec());
        for simd in Simd::available() {
            let (mut widened, mut found) = (Vec::new(), Vec::new());
            let rows = [&halves[..], &[]].into_iter();
            simd.distances_of_halves(&query, rows, &mut widened, |at, squared| found.push((at, squared)));
            prop_assert_eq!(found, [(0, expected), (1, 0.0)], "{}", simd.name());
        }
    }

    #[test]
    fn every_path_projects_alike(rows in 1..100usize, axes in prop_oneof![1..150usize, (1..12usize).prop_map(|sixteens| LANES * sixteens)], seed: u64) {
        let mut state = seed | 1;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
        };
        let matrix: Vec<f32> = (0..rows * axes).map(|_| draw()).collect();
        let offset: Vec<f32> = (0..axes).map(|_| draw()).collect();
        let vector: Vec<f32> = (0..rows).map(|_| draw()).collect();
        let by = |simd: Simd| {
            let mut out = vec![0.0; axes];
            simd.project(&matrix, &offset, &vector, &mut out);
            out
        };
        let expected: Vec<f32> = (0..axes)
            .map(|axis| (0..rows).fold(0.0, |sum, row| sum + vector[row] * matrix[row * axes + axis]) + offset[axis])
            .collect();
        for simd in Simd::available() {
            prop_assert_eq!(&by(simd), &expected, "{}", simd.name());
        }
    }
}

#[test]
fn many_runs_are_scanned_in_parts() {
    // More than are looked at together, in runs of 0 to 6 blocks, after one of many.
    let vectors: Vec<(Vec<i8>, f32)> = (0..21_000u32)
        .map(|at| (vec![(at % 15) as i8 - 7; 4], (at.wrapping_mul(7919) % 10_007) as f32))
        .collect();
    let bytes = block_bytes(4, &vectors, None);
    let all = Blocks::of_centres(&bytes, 4);
    let starts = std::iter::once(0).chain((600..).scan(600, |start, at| {
        *start += at % 7;
        Some(*start)
    }));
    let starts: Vec<u32> = starts.take_while(|&start| start < all.len() as u32).collect();
    let ends = starts[1..].iter().copied().chain([all.len() as u32]);
    let runs = starts.iter().zip(ends).map(|(&start, end)| (start as f32, all.run(start, end)));
    let mut query = QuantisedQuery::default();
    query.set(&[1.0, -0.5, 0.25, 0.75]);
    let sum: i32 = query.values.iter().map(|&value| i32::from(value)).sum();
    let base = |at: u32| starts[starts.partition_point(|&start| start <= at / LANES as u32) - 1] as f32;
    let mut expected: Vec<(f32, u32)> = (0..)
        .zip(&vectors)
        .map(|(at, (codes, scalar))| (base(at) + (scalar - 0.01 * (i32::from(codes[0]) * sum) as f32), at))
        .collect();
    expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for simd in Simd::available() {
        for keep in [1, 40, 3_000, 30_000] {
            let mut smallest = Smallest::default();
            smallest.reset(keep);
            smallest.scan(simd, runs.clone(), &query, 0.01);
            assert!(smallest.sorted().eq(expected.iter().copied().take(keep)), "{} {keep}", simd.name());
        }
    }
}

#[test]
fn the_largest_sums_do_not_overflow() {
    let axes = blocks::MAX_AXES;
    let mut queries = [(); 2].map(|()| QuantisedQuery::default());
    queries[0].set(&vec![1.0; axes]);
    queries[1].set_codes(&vec![127; axes], 1.0);
    for (entries, code) in [(None, 127), (Some(CodeBits::Eight), 127), (Some(CodeBits::Four), 7)] {
        let vectors = [code, -code].map(|code| (vec![code; axes], 0.0));
        let bytes = block_bytes(axes, &vectors, entries);
        let (run, ids) = match entries {
            Some(bits) => (Blocks::of_entries(&bytes, axes, bits), [1000, 999]),
            None => (Blocks::of_centres(&bytes, axes), [0, 1]),
        };
        for query in &queries {
            let largest = f32::from(code) * f32::from(query.values[0]) * axes as f32;
            for simd in Simd::available() {
                let mut smallest = Smallest::default();
                smallest.reset(9);
                smallest.scan(simd, [(0.0, run)].into_iter(), query, 1.0);
                let found: Vec<(f32, u32)> = smallest.sorted().collect();
                assert_eq!(found, [(-largest, ids[0]), (largest, ids[1])], "{} {entries:?}", simd.name());
            }
        }
    }
}

#[test]
fn quantised_values_are_near_and_their_forms_agree() {
    let agree = |query: &QuantisedQuery| {
        assert_eq!((query.values.len(), query.high.len(), query.low.len()), (32, 32, 32));
        let halves = query.high.iter().zip(&query.low);
        for (&value, (&high, &low)) in query.values.iter().zip(halves) {
            assert_eq!(128 * i32::from(high as i8) + i32::from(low as i8), i32::from(value));
            assert!(!query.is_of_codes || low == 0);
        }
    };
    let mut query = QuantisedQuery::default();
    let coordinates: Vec<f32> = (0..30).map(|at| ((at * 7919) % 101) as f32 / 50.0 - 1.0).collect();
    query.set(&coordinates);
    agree(&query);
    for (&value, &coordinate) in query.values.iter().zip(&coordinates) {
        assert!((f32::from(value) * query.step - coordinate).abs() <= 0.6 / f32::from(1i16 << 14));
    }
    let codes: Vec<i8> = (0..30).map(|at| (at * 7919 % 255 - 127) as i8).collect();
    query.set_codes(&codes, 0.5);
    agree(&query);
    for (&value, &code) in query.values.iter().zip(&codes) {
        assert_eq!(f32::from(value) * query.step, 0.5 * f32::from(code));
    }
    // All zeros, and what no finite query holds: no panic, and no NaN among the units.
    for odd in [0.0, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY, f32::NAN] {
        query.set(&[odd; 5]);
        assert!(!query.step.is_nan(), "{odd}");
    }
}
