//! What neighbours, looks and opinions say together, against Equation 3 and the mean of looks as
//! one would write them down.

use grasp_index::{
    Calibration, ClassInfo, DescriptorParams, Index, IndexParams, IndexWriter, Look, Neighbour,
    NetworkEstimate, NewEntry, Vote, VoteOptions, turned_orientation,
};
use nalgebra::{UnitQuaternion, Vector3};

/// The classes that networks are trained on.
const CUTKOSKY: [u8; 6] = [1, 2, 4, 9, 10, 12];
/// How far, in degrees, the entries `6..12` are turned beside the entries `0..6`.
const TURN_DEG: f64 = 30.0;

fn orientation() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.4))
}

/// Entry n is of class n % 6.
fn index(cutkosky: [u8; 6]) -> Index {
    let class = |cutkosky| ClassInfo { name: format!("class {cutkosky}"), cutkosky };
    let params = IndexParams {
        descriptor: DescriptorParams::raw(4),
        classes: cutkosky.map(class).into(),
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        calibration: Calibration { sigma_scale: 0.6, floor: 0.05, power: 1.7, ..Calibration::default() },
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..12u16 {
        let turn_deg = if n < 6 { 0.0 } else { TURN_DEG };
        let entry = NewEntry {
            class: n % 6,
            orientation: turned_orientation(turn_deg, &orientation()),
            descriptor: (0..4).map(|at| f32::from(n * 7 % 5 + at * n % 3)).collect(),
            ..NewEntry::default()
        };
        writer.push(entry).expect("the entry fits");
    }
    Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("the index opens")
}

fn near(id: u32, distance: f32) -> Neighbour {
    Neighbour { id, distance }
}

fn look(neighbours: &[Neighbour]) -> Look<'_> {
    Look { neighbours, opinion: None, turn_deg: 0.0 }
}

/// The sums of Equation 3's weights by class.
fn weights(neighbours: &[Neighbour], sigma: f64) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for near in neighbours {
        sums[near.id as usize % 6] += libm::exp(-(f64::from(near.distance) / sigma).powi(2) / 2.0);
    }
    sums
}

fn normalised(values: [f64; 6]) -> [f64; 6] {
    let sum: f64 = values.iter().sum();
    values.map(|value| value / sum)
}

/// The calibration's formula.
fn calibrated(shares: [f64; 6]) -> [f64; 6] {
    normalised(shares.map(|share| libm::pow(share + 0.05, 1.7)))
}

/// Shares and probabilities, by class number.
fn of_classes(vote: &Vote) -> ([f64; 6], [f64; 6]) {
    assert!(vote.classes.is_sorted_by(|a, b| a.probability >= b.probability), "{vote:?}");
    let of = |class| vote.classes.iter().find(|score| score.class == class).expect("every class is there");
    let each = |class: usize| of(class as u16);
    (std::array::from_fn(|class| each(class).share), std::array::from_fn(|class| each(class).probability))
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} is not {expected:?}");
}

const NEAR: [Neighbour; 4] = [
    Neighbour { id: 0, distance: 0.9 },
    Neighbour { id: 1, distance: 1.3 },
    Neighbour { id: 6, distance: 1.4 },
    Neighbour { id: 3, distance: 2.0 },
];

#[test]
fn each_width_weighs_by_itself_and_only_the_calibrated_one_is_calibrated() {
    let index = index(CUTKOSKY);
    let measured = index.catalogue().sigma;
    assert!(measured.mean_distance > 0.0 && measured.literal > 0.0);
    let default = VoteOptions::default();
    let widths = [
        (VoteOptions { sigma: Some(0.7), ..default }, 0.7),
        (VoteOptions { sigma_scale: Some(0.5), ..default }, 0.5 * measured.mean_distance),
        (VoteOptions { literal_sigma: true, ..default }, measured.literal),
        // The width in units of distance comes before all, the factor before the formula.
        (VoteOptions { sigma: Some(0.7), sigma_scale: Some(9.0), literal_sigma: true, ..default }, 0.7),
        (
            VoteOptions { sigma_scale: Some(0.5), literal_sigma: true, ..default },
            0.5 * measured.mean_distance,
        ),
        (default, 0.6 * measured.mean_distance),
    ];
    for (options, sigma) in widths {
        let vote = index.vote(&NEAR, &options);
        let sums = weights(&NEAR, sigma);
        let (shares, probabilities) = of_classes(&vote);
        assert_near(&shares, &normalised(sums));
        let of_default = options == default;
        assert_near(&probabilities, &if of_default { calibrated(shares) } else { shares });
        assert_near(&[vote.kernel_mass], &[sums.iter().sum()]);
        assert_eq!(vote.stages, None);
    }
}

#[test]
fn neighbours_that_are_none_have_no_vote() {
    let index = index(CUTKOSKY);
    let none = [near(12, 0.1), near(u32::MAX, 0.1), near(2, f32::INFINITY), near(2, f32::NAN)];
    let options = VoteOptions::default();
    assert_eq!(index.vote(&[&none[..], &NEAR].concat(), &options), index.vote(&NEAR, &options));
    let (shares, probabilities) = of_classes(&index.vote(&none, &options));
    assert_near(&shares, &[1.0 / 6.0; 6]);
    assert_near(&probabilities, &[1.0 / 6.0; 6]);
}

#[test]
fn looks_are_averaged_and_turned_back() {
    let index = index(CUTKOSKY);
    let sigma = 0.6 * index.catalogue().sigma.mean_distance;
    // What the second look finds is turned as its picture was.
    let (first, second) = ([near(0, 0.5), near(2, 1.5)], [near(6, 0.7), near(8, 0.9), near(10, 1.1)]);
    let looks = [look(&first), Look { turn_deg: TURN_DEG, ..look(&second) }];
    let vote = index.vote_of_looks(&looks, &VoteOptions::default());
    let sums = [weights(&first, sigma), weights(&second, sigma)];
    let own = sums.map(normalised);
    let mean = |each: [[f64; 6]; 2]| -> [f64; 6] {
        std::array::from_fn(|class| (each[0][class] + each[1][class]) / 2.0)
    };
    let (shares, probabilities) = of_classes(&vote);
    assert_near(&shares, &mean(own));
    // Looks that agree are surer than their mean.
    let surer = normalised(mean(own.map(calibrated)).map(|probability| libm::pow(probability, 1.5)));
    assert_near(&probabilities, &surer);
    assert_near(&[vote.kernel_mass], &[sums.as_flattened().iter().sum::<f64>() / 2.0]);
    assert!(vote.orientation.rotation.angle_to(&orientation()) < 1e-3, "{:?}", vote.orientation);
    assert!(vote.orientation.spread_deg < 0.1, "{:?}", vote.orientation);
    // With a width of its own, a mean is all that can be said.
    let own_width = VoteOptions { sigma: Some(sigma), ..VoteOptions::default() };
    let (shares, probabilities) = of_classes(&index.vote_of_looks(&looks, &own_width));
    assert_near(&probabilities, &shares);
}

fn opinion(classes: &[f64], stages: [f64; 3], turn_deg: f64) -> NetworkEstimate {
    let rotation = Some(turned_orientation(turn_deg, &orientation()));
    NetworkEstimate { classes: classes.to_vec(), mirrored: 0.0, stages, rotation }
}

#[test]
fn opinions_join_where_the_classes_are_those_of_networks() {
    let opinions = [
        opinion(&[0.05, 0.1, 0.6, 0.15, 0.05, 0.05], [0.2, 0.3, 0.5], 10.0),
        opinion(&[0.2, 0.1, 0.5, 0.1, 0.05, 0.05], [0.6, 0.3, 0.1], TURN_DEG + 10.0),
    ];
    let (first, second) = ([near(0, 0.9), near(1, 1.3), near(2, 1.4)], [near(8, 0.9), near(6, 1.0)]);
    let looks = [
        Look { opinion: Some(&opinions[0]), ..look(&first) },
        Look { opinion: Some(&opinions[1]), turn_deg: TURN_DEG, ..look(&second) },
    ];
    let options = VoteOptions::default();
    let index_of_networks = index(CUTKOSKY);
    let vote = index_of_networks.vote_of_looks(&looks, &options);
    let sigma = 0.6 * index_of_networks.catalogue().sigma.mean_distance;
    let neighbours = [weights(&first, sigma), weights(&second, sigma)].map(normalised).map(calibrated);
    // The square root of the neighbours' geometric mean, and the geometric mean of the opinions.
    let joined = std::array::from_fn(|class| {
        let said = opinions[0].classes[class] * opinions[1].classes[class];
        said.sqrt() * (neighbours[0][class] * neighbours[1][class]).sqrt().sqrt()
    });
    assert_near(&of_classes(&vote).1, &normalised(joined));
    assert_near(&vote.stages.expect("there are opinions"), &[0.4, 0.3, 0.3]);
    assert_eq!(vote.classes[0].class, 2);

    // Turned back, both neighbours of class 2 say one orientation, and both opinions one 10 degrees
    // beside it; together they weigh the same.
    let between = turned_orientation(5.0, &orientation());
    assert!(vote.orientation.rotation.angle_to(&between) < 1e-3, "{:?}", vote.orientation);
    assert!((vote.orientation.spread_deg - 5.0).abs() < 0.1, "{:?}", vote.orientation);

    let silent = looks.map(|look| Look { opinion: None, ..look });
    let own_width = VoteOptions { sigma: Some(1.0), ..options };
    assert_eq!(
        index_of_networks.vote_of_looks(&looks, &own_width),
        index_of_networks.vote_of_looks(&silent, &own_width)
    );
    let index_of_others = index([1, 2, 4, 9, 10, 11]);
    assert_eq!(
        index_of_others.vote_of_looks(&looks, &options),
        index_of_others.vote_of_looks(&silent, &options)
    );
    let of_five = opinion(&[0.2; 5], [0.2, 0.3, 0.5], 0.0);
    let misfit = looks.map(|look| Look { opinion: Some(&of_five), ..look });
    assert_eq!(
        index_of_networks.vote_of_looks(&misfit, &options),
        index_of_networks.vote_of_looks(&silent, &options)
    );
}
