//! The whole chain on pictures that are not in the index: another shape of hand, between the views.

mod support;

use grasp_index::{
    DescriptorParams, EPS, Effort, Index, IndexParams, SearchOptions, VoteOptions, mirror_orientation,
    turned_orientation,
};
use nalgebra::{UnitQuaternion, Vector3};

fn index(descriptor: DescriptorParams) -> Index {
    let params = IndexParams { descriptor, ..support::params(4) };
    let bytes = support::writer(params, 30, 8).finish_bytes().expect("the index is built");
    Index::from_bytes(&bytes).expect("the index opens")
}

#[test]
fn another_hand_between_the_views_is_recognised_and_its_orientation_found() {
    let (default, upright, paper) =
        (DescriptorParams::default(), DescriptorParams::upright(), DescriptorParams::paper());
    for (descriptor, least) in [(default, 30), (upright, 30), (paper, 26)] {
        let index = index(descriptor);
        let (mut right, mut turned) = (0, Vec::new());
        for n in 0..40u16 {
            let (class, truth) = (n % 4, support::view(f64::from(n) * 8.7, 20.0 + f64::from(n % 5) * 11.0));
            let hand = support::hand(class, 0.3, &truth);
            let query = index.describe(&hand).expect("pictures are described");
            let found = index.search(&query, &index.search_options()).expect("the query fits");
            let vote = index.vote(&found.neighbours, &VoteOptions::default());
            right += u16::from(vote.classes[0].class == class);
            let answer = turned_orientation(-descriptor.turn_deg(&hand), &vote.orientation.rotation);
            turned.push(answer.angle_to(&truth).to_degrees());
            let sum: f64 = vote.classes.iter().map(|score| score.probability).sum();
            assert!((sum - 1.0).abs() < 1e-9);
        }
        turned.sort_by(f64::total_cmp);
        assert!(right >= least, "{}: {right} of 40", descriptor.name());
        assert!(turned[20] < 15.0, "{}: a median of {} degrees", descriptor.name(), turned[20]);
    }
}

#[test]
fn the_measured_search_keeps_what_it_promises() {
    let index = index(DescriptorParams::default());
    let effort = Effort::Success { eps: EPS, success: 0.95 };
    let point = index.catalogue().measured.enough(effort).expect("some effort is enough");
    assert!(point.success() >= 0.95, "{point:?}");
    assert!(point.share_of_database < 0.5, "{point:?}");
    // Views that it neither holds nor was measured by.
    let mut near_enough = 0;
    for n in 0..200_u16 {
        let turn = f64::from(n);
        let hand = support::hand(n % 4, 0.15, &support::view(turn * 7.3 + 1.0, 18.0 + turn % 47.0));
        let query = index.describe(&hand).expect("pictures are described");
        let nearest = |effort| {
            let found = index.search(&query, &SearchOptions { k: 1, effort }).expect("the query fits");
            f64::from(found.neighbours[0].distance)
        };
        near_enough += u32::from(nearest(effort) <= (1.0 + EPS) * nearest(Effort::Exact));
    }
    assert!(near_enough >= 180, "{near_enough} of 200");
}

#[test]
fn turning_the_picture_turns_the_hand() {
    // A picture turned clockwise shows the hand turned about the optical axis by the same angle.
    let truth = support::view(40.0, 50.0);
    let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7);
    let params = DescriptorParams::default();
    let turned = params.describe(&support::hand(1, 0.0, &truth).rotated(0.7)).unwrap();
    let apart = |other: &UnitQuaternion<f64>| {
        let other = params.describe(&support::hand(1, 0.0, other)).unwrap();
        turned.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    };
    assert!(apart(&(roll * truth)) < 0.5 * apart(&truth));
    assert!(apart(&(roll * truth)) < 0.5 * apart(&(roll.inverse() * truth)));
}

#[test]
fn mirroring_keeps_what_a_left_hands_frame_means() {
    // The wrist-to-knuckle axis and the axis out of the back, as the camera sees them, are flipped
    // left to right.
    let right = support::view(70.0, 25.0);
    let left = mirror_orientation(&right);
    for axis in [Vector3::x(), Vector3::z()] {
        let (seen, flipped) = (right * axis, left * axis);
        assert!((Vector3::new(-seen.x, seen.y, seen.z) - flipped).norm() < 1e-12);
    }
}

/// With the formula as printed, every weight of Equation 3 is all but 1.
#[test]
fn the_literal_sigma_counts_heads_and_the_fitted_one_weighs_them() {
    let index = index(DescriptorParams::default());
    let query = index.descriptor(7).unwrap().to_vec();
    let found = index.search(&query, &SearchOptions { k: 60, effort: Effort::Exact }).unwrap();
    let class = index.labels()[7];
    let alike = found.neighbours.iter().filter(|near| index.labels()[near.id as usize] == class).count();
    let share = |options: &VoteOptions| {
        let vote = index.vote(&found.neighbours, options);
        vote.classes.iter().find(|score| score.class == class).unwrap().probability
    };
    let heads = alike as f64 / 60.0;
    assert!(alike < 60, "the test needs a neighbour of another class");
    let literal = share(&VoteOptions { literal_sigma: true, ..VoteOptions::default() });
    assert!((literal - heads).abs() < 1e-2, "{literal} is not {heads}");
    let narrow =
        share(&VoteOptions { sigma_scale: Some(0.1), literal_sigma: true, ..VoteOptions::default() });
    assert!(narrow > literal, "an explicit width takes precedence: {narrow}, {literal}");
}
