//! The descriptors against their definitions, pixel by pixel.

use super::*;
use crate::hand_image::HandImage;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Hand images of any shape, some pixels missing.
fn hands() -> impl Strategy<Value = HandImage> {
    (8..24usize, 8..24usize)
        .prop_flat_map(|(w, h)| {
            let grey = prop::collection::vec(any::<u8>(), w * h);
            let mask = prop::collection::vec(prop::sample::select(vec![0u8, 1, 1, 1]), w * h);
            (Just((w, h)), grey, mask)
        })
        .prop_filter_map("no hand", |((w, h), grey, mask)| HandImage::from_mask(w, h, &grey, &mask).ok())
}

/// The gradient of Equation 1 at a pixel: magnitude and orientation in `[0, pi)`.
fn gradient(hand: &HandImage, x: usize, y: usize) -> (f64, f64) {
    let at = |x: i64, y: i64| {
        let inside = x >= 0 && y >= 0 && x < hand.width() as i64 && y < hand.height() as i64;
        if inside { f64::from(hand.pixels()[y as usize * hand.width() + x as usize]) } else { 0.0 }
    };
    let (x, y) = (x as i64, y as i64);
    let down = at(x, y + 1) - at(x, y - 1);
    let right = at(x + 1, y) - at(x - 1, y);
    let angle = libm::atan2(right, down).rem_euclid(PI);
    (libm::hypot(down, right), if angle >= PI { 0.0 } else { angle })
}

/// How much of a pixel falls into a cell or bin that is `apart` cells or bins away.
fn share(apart: f64) -> f64 {
    (1.0 - apart.abs()).max(0.0)
}

fn naive(hand: &HandImage, params: &DescriptorParams) -> Vec<f64> {
    let bins = params.bins as usize;
    let mut descriptor = Vec::new();
    for level in 1..=params.levels {
        let cells = 1usize << (params.levels - level);
        let mut histograms = vec![0.0; cells * cells * bins];
        for (x, y) in (0..hand.height()).flat_map(|y| (0..hand.width()).map(move |x| (x, y))) {
            let (magnitude, angle) = gradient(hand, x, y);
            let position = angle / PI * bins as f64;
            for (at, value) in histograms.iter_mut().enumerate() {
                let (cell, bin) = (at / bins, at % bins);
                let (row, column) = (cell / cells, cell % cells);
                *value += match params.kind {
                    DescriptorKind::Paper => {
                        // A border between bins belongs to the upper one; the angle's last digits
                        // must not decide.
                        let is_bin = (position + 1e-9).floor() as usize % bins == bin;
                        let is_cell = y * cells / hand.height() == row && x * cells / hand.width() == column;
                        f64::from(u8::from(magnitude > 0.0 && is_bin && is_cell))
                    }
                    DescriptorKind::Default => {
                        let around = (position - bin as f64).abs();
                        let middle = |pixel: usize, length: usize| {
                            let middle = (pixel as f64 + 0.5) * cells as f64 / length as f64 - 0.5;
                            middle.clamp(0.0, cells as f64 - 1.0)
                        };
                        magnitude
                            * share(around.min(bins as f64 - around))
                            * share(middle(y, hand.height()) - row as f64)
                            * share(middle(x, hand.width()) - column as f64)
                    }
                    DescriptorKind::Raw { .. } | DescriptorKind::Learned { .. } => 0.0,
                };
            }
        }
        let group = if params.kind == DescriptorKind::Paper { bins } else { histograms.len() };
        for group in histograms.chunks_mut(group) {
            let sum: f64 = group.iter().sum();
            group.iter_mut().filter(|_| sum > 0.0).for_each(|value| *value /= sum);
        }
        descriptor.extend(histograms);
    }
    if params.kind == DescriptorKind::Default {
        descriptor.iter_mut().for_each(|value| *value = value.sqrt());
    }
    descriptor
}

proptest! {
    #[test]
    fn both_kinds_follow_their_definitions(hand in hands(), is_paper in any::<bool>(), bins in 3..9u32, levels in 1..5u32) {
        let kind = if is_paper { DescriptorKind::Paper } else { DescriptorKind::Default };
        let params = DescriptorParams { kind, bins, levels, sampling: Sampling::Native, tone: Tone::AsIs };
        let fast = described(&params, &hand);
        let naive = naive(&hand, &params);
        prop_assert_eq!(fast.len(), params.dim());
        prop_assert_eq!(naive.len(), params.dim());
        for (at, (fast, naive)) in fast.iter().zip(&naive).enumerate() {
            prop_assert!((f64::from(*fast) - naive).abs() < 3e-3, "value {} is {} and should be {}", at, fast, naive);
        }
    }

    #[test]
    fn a_describer_that_is_used_again_says_the_same(first in hands(), second in hands()) {
        for params in DescriptorParams::NAMES.iter().filter_map(|name| DescriptorParams::by_name(name)) {
            let mut describer = Describer::new(&params).unwrap();
            describer.describe(&first);
            prop_assert_eq!(describer.describe(&second), described(&params, &second));
        }
    }

    #[test]
    fn every_parameter_in_range_gives_finite_values(
        hand in hands(), bins in 0..40u32, levels in 0..7u32, side in 0..100u16, contrast in -1.0..2.0f32
    ) {
        for sampling in [Sampling::Native, Sampling::KeepAspect { side }, Sampling::Upright { side }] {
            let tone = Tone::Normalised { contrast };
            let params = DescriptorParams { bins, levels, sampling, tone, ..DescriptorParams::default() };
            let descriptor = match params.describe(&hand) {
                Ok(descriptor) => descriptor,
                Err(error) => {
                    prop_assert_eq!(params.validate(), Err(error));
                    continue;
                }
            };
            prop_assert!((2..=32).contains(&bins) && (1..=6).contains(&levels) && (0.0..=1.0).contains(&contrast));
            prop_assert_eq!(descriptor.len(), params.dim());
            prop_assert!(descriptor.iter().all(|value| value.is_finite() && *value >= 0.0));
        }
    }
}

/// A block of hand, shaded, with a black object in front of it.
fn block(width: usize, height: usize, grey: impl Fn(usize, usize) -> u8) -> HandImage {
    let pixels: Vec<u8> = (0..width * height).map(|at| grey(at % width, at / width)).collect();
    HandImage::from_mask(width, height, &pixels, &vec![1; width * height]).expect("a block is a hand")
}

/// The descriptor, by parameters in range.
fn described(params: &DescriptorParams, hand: &HandImage) -> Vec<f32> {
    params.describe(hand).expect("the parameters are in range")
}

fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
}

#[test]
fn the_lengths_are_the_papers() {
    assert_eq!(DescriptorParams::paper().dim(), 84);
    assert_eq!(DescriptorParams::default().dim(), 340);
    assert_eq!(DescriptorParams { levels: 3, ..DescriptorParams::default() }.dim(), 84);
}

#[test]
fn x_is_downward() {
    // Brightness that grows downward alone has orientation 0: the first bin; to the right alone,
    // pi/2: the third.
    let downward = block(32, 32, |_, y| 60 + y as u8 * 4);
    let rightward = block(32, 32, |x, _| 60 + x as u8 * 4);
    let params =
        DescriptorParams { sampling: Sampling::Native, tone: Tone::AsIs, ..DescriptorParams::default() };
    for (hand, bin) in [(downward, 0), (rightward, 2)] {
        let descriptor = described(&params, &hand);
        // Of the four cells in the middle, which do not see the silhouette.
        let inner = params
            .cells(&descriptor)
            .filter(|cell| cell.level == 1 && (1..=2).contains(&cell.row) && (1..=2).contains(&cell.column));
        for cell in inner {
            let strongest = (0..4).max_by(|&a, &b| cell.histogram[a].total_cmp(&cell.histogram[b]));
            assert_eq!(strongest, Some(bin), "{cell:?}");
        }
    }
}

#[test]
fn cells_come_finest_level_first() {
    let params = DescriptorParams::paper();
    let descriptor: Vec<f32> = (0..84).map(|at| at as f32).collect();
    let cells: Vec<Cell<'_>> = params.cells(&descriptor).collect();
    assert_eq!(cells.len(), 16 + 4 + 1);
    assert_eq!((cells[0].level, cells[16].level, cells[20].level), (1, 2, 3));
    assert_eq!((cells[6].row, cells[6].column, cells[6].cells_a_side), (1, 2, 4));
    assert_eq!(cells[17].histogram, [68.0, 69.0, 70.0, 71.0]);
    // What has no pyramid has no cells.
    for none in [DescriptorParams::raw(84), DescriptorParams { levels: 0, ..params }] {
        assert_eq!(none.cells(&descriptor).count(), 0, "{none:?}");
    }
}

#[test]
fn what_a_buffer_has_no_room_for_is_dropped_and_what_is_beyond_is_left_alone() {
    let hand = block(32, 32, |x, y| 60 + x as u8 * 4 + y as u8);
    let params = DescriptorParams::paper();
    let (whole, mut describer) = (described(&params, &hand), Describer::new(&params).unwrap());
    let (mut short, mut long) = ([9.0; 80], [9.0; 90]);
    describer.describe_into(&hand, &mut short);
    describer.describe_into(&hand, &mut long);
    assert_eq!((&short[..], &long[..84], &long[84..]), (&whole[..80], &whole[..], &[9.0; 6][..]));
}

#[test]
fn a_dark_hand_and_a_light_one_give_nearly_the_same() {
    let shade = |x: usize, y: usize| 20.0 + ((x * 5 + y * 3) % 40) as f32;
    let dark = block(40, 30, |x, y| shade(x, y) as u8);
    let light = block(40, 30, |x, y| (shade(x, y) * 3.0 + 40.0) as u8);
    let params = DescriptorParams::default();
    let apart = distance(&described(&params, &dark), &described(&params, &light));
    let as_is = DescriptorParams { tone: Tone::AsIs, ..params };
    assert!(apart < 0.02, "{apart}");
    assert!(apart < 0.2 * distance(&described(&as_is, &dark), &described(&as_is, &light)));
}

#[test]
fn the_size_of_the_picture_hardly_matters() {
    let shade = |x: usize, y: usize, size: usize| (80 + 100 * x / size + 40 * y / size) as u8;
    let small = block(60, 40, |x, y| shade(x, y, 60));
    let large = block(600, 400, |x, y| shade(x, y, 600));
    let params = DescriptorParams::default();
    let apart = distance(&described(&params, &small), &described(&params, &large));
    assert!(apart < 0.1, "{apart}");
}

#[test]
fn different_parameters_have_different_fingerprints() {
    let base = DescriptorParams::default();
    let others = [
        DescriptorParams::paper(),
        DescriptorParams::upright(),
        DescriptorParams { bins: 5, ..base },
        DescriptorParams { levels: 3, ..base },
        DescriptorParams { sampling: Sampling::KeepAspect { side: 64 }, ..base },
        DescriptorParams { sampling: Sampling::Native, ..base },
        DescriptorParams { tone: Tone::AsIs, ..base },
        DescriptorParams { tone: Tone::Normalised { contrast: 0.3 }, ..base },
    ];
    let mut fingerprints: Vec<u64> =
        others.iter().chain([&base]).map(DescriptorParams::fingerprint).collect();
    fingerprints.sort_unstable();
    fingerprints.dedup();
    assert_eq!(fingerprints.len(), others.len() + 1);
}

#[test]
fn parameters_out_of_range_are_rejected() {
    let base = DescriptorParams::default();
    let message = |params: DescriptorParams| params.validate().expect_err("out of range").to_string();
    assert!(base.validate().is_ok() && DescriptorParams::paper().validate().is_ok());
    assert!(message(DescriptorParams { bins: 1, ..base }).contains("1 bins"));
    assert!(message(DescriptorParams { levels: 9, ..base }).contains("9 levels"));
    assert!(
        message(DescriptorParams { sampling: Sampling::KeepAspect { side: 3 }, ..base }).contains("3 pixels")
    );
    assert!(
        message(DescriptorParams { tone: Tone::Normalised { contrast: f32::NAN }, ..base }).contains("NaN")
    );
}

#[test]
fn the_ends_of_the_ranges_are_parameters_and_nothing_beyond() {
    let base = DescriptorParams::default();
    let is_sound = |params: DescriptorParams| params.validate().is_ok();
    for n in 0..40 {
        assert_eq!(is_sound(DescriptorParams { bins: n, ..base }), (2..=32).contains(&n), "{n} bins");
        assert_eq!(is_sound(DescriptorParams { levels: n, ..base }), (1..=6).contains(&n), "{n} levels");
    }
    for (side, expected) in [(7, false), (8, true), (1024, true), (1025, false)] {
        for sampling in [Sampling::KeepAspect { side }, Sampling::Upright { side }] {
            assert_eq!(is_sound(DescriptorParams { sampling, ..base }), expected, "{sampling:?}");
        }
    }
    for (contrast, expected) in [(-0.01, false), (0.0, true), (1.0, true), (1.01, false)] {
        let tone = Tone::Normalised { contrast };
        assert_eq!(is_sound(DescriptorParams { tone, ..base }), expected, "{contrast}");
    }
    for (dim, is_vector, is_embedding) in
        [(0, false, false), (1, true, true), (1024, true, true), (1025, true, false), (65_536, true, false)]
    {
        assert_eq!(is_sound(DescriptorParams::raw(dim)), is_vector, "{dim} values");
        let kind = DescriptorKind::Learned { network: 1, dim };
        assert_eq!(is_sound(DescriptorParams { kind, ..base }), is_embedding, "{dim} values of a network");
    }
    assert!(!is_sound(DescriptorParams::raw(65_537)));
}

#[test]
fn names_are_read_back() {
    for name in DescriptorParams::NAMES {
        assert_eq!(DescriptorParams::by_name(name).expect("a name").name(), name);
    }
}

#[test]
fn an_upright_descriptor_hardly_changes_with_the_roll_of_the_camera() {
    // A wedge: long, and thinner at one end.
    let hand = block(64, 80, |x, y| if x.abs_diff(32) * 4 <= y { 40 + (x * 2 + y) as u8 } else { 0 });
    let hand = HandImage::from_segmented(64, 80, hand.pixels(), 0).expect("a wedge is a hand");
    let (upright, level) = (DescriptorParams::upright(), DescriptorParams::default());
    let apart = |params: &DescriptorParams, degrees: f64| {
        distance(&described(params, &hand), &described(params, &hand.rotated(degrees.to_radians())))
    };
    for degrees in [-170.0, -95.0, -30.0, 12.0, 77.0, 140.0] {
        let (turned, as_it_is) = (apart(&upright, degrees), apart(&level, degrees));
        assert!(turned < 0.35 * as_it_is, "{degrees}: {turned} and {as_it_is}");
    }
    let mut describer = Describer::new(&upright).unwrap();
    let turned = hand.rotated(upright.turn_deg(&hand).to_radians());
    assert_eq!(describer.describe_turned(&hand, upright.turn_deg(&hand), &turned), describer.describe(&hand));
}
