//! Every path against the plain loops, bit by bit, and those against the definition.

use super::*;
use crate::search::blocks::{self, BlockMut, CodeBits, LANES, Precision};
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
    fn every_path_gives_the_same_scores((axes, mut vectors, query) in vectors(), entries in prop_oneof![Just(None), Just(Some(CodeBits::Four)), Just(Some(CodeBits::Eight))], coarse: bool, keep in 1..60usize, factor in 0.0..1e-3f32, base in -2.0..2.0f32) {
        if entries == Some(CodeBits::Four) {
            vectors.iter_mut().flat_map(|(codes, _)| codes).for_each(|code| *code %= 8);
        }
        let bytes = block_bytes(axes, &vectors, entries);
        let run = match entries {
            Some(bits) => Blocks::of_entries(&bytes, axes, bits),
            None => Blocks::of_centres(&bytes, axes),
        };
        let mut quantised = QuantisedQuery::default();
        quantised.set(&query, if coarse { Precision::Coarse } else { Precision::Fine });
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
    query.set(&[1.0, -0.5, 0.25, 0.75], Precision::Fine);
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
    let codes = |code: i8| (vec![code; axes], 0.0f32);
    let vectors = [codes(127), codes(-127)];
    let bytes = block_bytes(axes, &vectors, None);
    let mut query = QuantisedQuery::default();
    for precision in [Precision::Fine, Precision::Coarse] {
        query.set(&vec![1.0; axes], precision);
        let largest = 127.0 * f32::from(query.values[0]) * axes as f32;
        for simd in Simd::available() {
            let mut smallest = Smallest::default();
            smallest.reset(9);
            smallest.scan(simd, [(0.0, Blocks::of_centres(&bytes, axes))].into_iter(), &query, 1.0);
            let found: Vec<(f32, u32)> = smallest.sorted().collect();
            assert_eq!(found, [(-largest, 0), (largest, 1)], "{}", simd.name());
        }
    }
}

#[test]
fn quantised_values_are_near_and_their_forms_agree() {
    let coordinates: Vec<f32> = (0..30).map(|at| ((at * 7919) % 101) as f32 / 50.0 - 1.0).collect();
    let mut query = QuantisedQuery::default();
    for (precision, bits) in [(Precision::Fine, 14), (Precision::Coarse, 7)] {
        query.set(&coordinates, precision);
        assert_eq!((query.values.len(), query.high.len(), query.low.len()), (32, 32, 32));
        for (at, &value) in query.values.iter().enumerate() {
            let coordinate = coordinates.get(at).copied().unwrap_or(0.0);
            assert!((f32::from(value) * query.step - coordinate).abs() <= 0.6 / f32::from(1i16 << bits));
            let (high, low) = (query.high[at] as i8, query.low[at] as i8);
            assert_eq!(128 * i32::from(high) + i32::from(low), i32::from(value));
            assert!(precision == Precision::Fine || low == 0);
        }
    }
    // All zeros, and what no finite query holds: no panic, and no NaN among the units.
    for odd in [0.0, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY, f32::NAN] {
        for precision in [Precision::Fine, Precision::Coarse] {
            query.set(&[odd; 5], precision);
            assert!(!query.step.is_nan(), "{odd}");
        }
    }
}
