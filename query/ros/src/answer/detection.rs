//! `vision_msgs/Detection2DArray`.

use super::Hand;
use crate::messages::geometry::PoseWithCovariance;
use crate::messages::standard::Header;
use crate::messages::vision::{
    BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesis, ObjectHypothesisWithPose, Point2D, Pose2D,
};

/// The detection of a hand with all classes, most probable first; none where the hand is unknown,
/// or there is no hand.
pub(crate) fn message(header: &Header, hand: Option<&Hand>) -> Detection2DArray {
    let detections = hand.map(|hand| Detection2D {
        header: header.clone(),
        results: results(hand),
        bbox: rectangle(hand),
        id: String::new(),
    });
    Detection2DArray { header: header.clone(), detections: detections.into_iter().collect() }
}

fn results(hand: &Hand) -> Vec<ObjectHypothesisWithPose> {
    let mut pose = PoseWithCovariance { pose: hand.pose(), ..PoseWithCovariance::default() };
    // The spread is that of the whole angle, whose square three axes share.
    let variance = hand.spread_deg.to_radians().powi(2) / 3.0;
    // Of the turns alone: how far away the hand is, is not measured.
    for (axis, row) in pose.covariance.iter_mut().enumerate().skip(3) {
        row[axis] = variance;
    }
    let result = |(name, probability): &(String, f64)| ObjectHypothesisWithPose {
        hypothesis: ObjectHypothesis { class_id: name.clone(), score: *probability },
        pose,
    };
    hand.classes.iter().map(result).collect()
}

fn rectangle(hand: &Hand) -> BoundingBox2D {
    let ([x, y], [size_x, size_y]) = (hand.rectangle.centre, hand.rectangle.size);
    BoundingBox2D { center: Pose2D { position: Point2D { x, y }, theta: 0.0 }, size_x, size_y }
}
