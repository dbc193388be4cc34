//! What a request carries: a picture, alone or as a form with a mask or a depth picture beside it.

use axum::body::Bytes;
use axum::http::{HeaderValue, StatusCode};

use super::form::{Form, FormError, Part};
use super::problem::Problem;
use super::shown::shown;
use crate::wire::DESCRIBED;
use grasp_recognise::MaskSource;
use grasp_recognise::picture;
use grasp_recognise::segment::Mask;
use grasp_recognise::segment::depth::DepthRange;
use grasp_robot::{Arm, Camera, Object, RobotError, RobotHand, Setting};

/// The parts of a request, still encoded.
#[derive(Clone, Debug, Default)]
pub(super) struct Input {
    pub(super) picture: Bytes,
    mask: Option<Bytes>,
    depth: Option<Bytes>,
    landmarks: Option<Bytes>,
    robot: Option<Bytes>,
    object: Option<Bytes>,
    camera: Option<Bytes>,
    arm: Option<Bytes>,
}

/// A picture as the body itself, or a form of the parts `picture`, `mask`, `depth` or `landmarks`,
/// and `object`, `camera`, `robot` and `arm`.
pub(super) fn input(content_type: Option<&HeaderValue>, body: Bytes) -> Result<Input, Problem> {
    let content_type = content_type.and_then(|kind| kind.to_str().ok()).unwrap_or_default().trim_start();
    if !content_type.to_ascii_lowercase().starts_with("multipart/form-data") {
        return Ok(Input { picture: body, ..Input::default() });
    }
    let unreadable = |error: FormError| Problem::bad_request(error.to_string());
    let mut form = Form::new(content_type, body).map_err(unreadable)?;
    let mut input = Input::default();
    let mut has_picture = false;
    while let Some(Part { name, content }) = form.next_part().map_err(unreadable)? {
        let is_first = match name.as_str() {
            "picture" => {
                !std::mem::replace(&mut has_picture, true) && {
                    input.picture = content;
                    true
                }
            }
            "mask" => input.mask.replace(content).is_none(),
            "depth" => input.depth.replace(content).is_none(),
            "landmarks" => input.landmarks.replace(content).is_none(),
            "robot" => input.robot.replace(content).is_none(),
            "object" => input.object.replace(content).is_none(),
            "camera" => input.camera.replace(content).is_none(),
            "arm" => input.arm.replace(content).is_none(),
            other => {
                return Err(Problem::bad_request(format!(
                    "the form has a part {}: its parts are picture, mask, depth, landmarks, object, camera, robot and arm",
                    shown(other)
                )));
            }
        };
        if !is_first {
            return Err(Problem::bad_request(format!("the form has more than one {name}")));
        }
    }
    if !has_picture {
        return Err(Problem::bad_request("the form has no part `picture`"));
    }
    Ok(input)
}

impl Input {
    /// Refuses pictures whose headers state more pixels than `most`, before anything is decoded.
    pub(super) fn check_pixels(&self, most: u64) -> Result<(), Problem> {
        for encoded in [Some(&self.picture), self.mask.as_ref(), self.depth.as_ref()].into_iter().flatten() {
            // What is not a picture is reported in its record.
            let Ok((width, height)) = picture::dimensions(encoded) else { continue };
            if u64::from(width) * u64::from(height) > most {
                return Err(Problem::new(
                    StatusCode::PAYLOAD_TOO_LARGE,
                    "too_large",
                    format!(
                        "the header says {width} x {height} pixels; the service reads at most {most}: shrink the picture first"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Where the hand's mask comes from. Decodes masks and depth pictures, and reads landmarks.
    pub(super) fn source(&self, segmented: bool, range: Option<DepthRange>) -> Result<MaskSource, Problem> {
        let named = [segmented, self.mask.is_some(), self.depth.is_some(), self.landmarks.is_some()];
        if named.into_iter().filter(|is_named| *is_named).count() > 1 {
            return Err(Problem::bad_request(
                "only one of segmented, a mask, a depth picture and landmarks can be given",
            ));
        }
        let unusable = |what: &str, error: picture::DecodeError| {
            Problem::bad_request(format!("cannot use the {what}: {error}"))
        };
        if let (Some(landmarks), None) = (&self.landmarks, range) {
            let landmarks = serde_json::from_slice(landmarks)
                .map_err(|error| Problem::bad_request(format!("cannot use the landmarks: {error}")))?;
            return Ok(MaskSource::Landmarks(landmarks));
        }
        match (&self.mask, &self.depth, range) {
            (Some(mask), _, None) => {
                let (width, height, grey) =
                    picture::decode_grey(mask).map_err(|error| unusable("mask", error))?;
                Ok(MaskSource::Given(Mask::from_grey(width, height, &grey)))
            }
            (_, Some(depth), Some(range)) => {
                let (width, height, depth) =
                    picture::decode_grey16(depth).map_err(|error| unusable("depth picture", error))?;
                Ok(MaskSource::Depth { width, height, depth, range })
            }
            (_, Some(_), None) => Err(Problem::bad_request("a depth picture needs depth_range=NEAR..FAR")),
            (_, _, Some(_)) => {
                Err(Problem::bad_request("depth_range needs a depth picture, the part `depth`"))
            }
            _ if segmented => Ok(MaskSource::Segmented),
            _ => Ok(MaskSource::Camera),
        }
    }

    /// The robot that is asked for by `name`, with the object and the camera of the form, on the
    /// arm of that name.
    pub(super) fn setting(&self, name: Option<&str>, arm: Option<&str>) -> Result<Option<Setting>, Problem> {
        let Some(name) = name else {
            let parts = [&self.robot, &self.object, &self.camera, &self.arm];
            return match arm.is_some() || parts.into_iter().any(Option::is_some) {
                true => Err(Problem::bad_request(
                    "an arm, or a form that describes a robot's work: say robot=NAME as well",
                )),
                false => Ok(None),
            };
        };
        let text = |part: &'static str, bytes: &Option<Bytes>| {
            let bytes = bytes
                .as_ref()
                .ok_or_else(|| Problem::bad_request(format!("the form has no part `{part}`")))?;
            String::from_utf8(bytes.to_vec())
                .map_err(|_| Problem::bad_request(format!("the part `{part}` is no text")))
        };
        if self.robot.is_some() && name != DESCRIBED {
            return Err(Problem::bad_request("the form describes a robot: say robot=described"));
        }
        if self.arm.is_some() && arm != Some(DESCRIBED) {
            return Err(Problem::bad_request("the form describes an arm: say arm=described"));
        }
        let hand = match name {
            DESCRIBED => RobotHand::parse("robot", &text("robot", &self.robot)?),
            // No path: a request names no file of this machine.
            _ => RobotHand::built_in(name),
        };
        let object = Object::parse("object", &text("object", &self.object)?).map_err(refused)?;
        let camera = Camera::parse("camera", &text("camera", &self.camera)?).map_err(refused)?;
        let arm = match arm {
            Some(DESCRIBED) => Some(Arm::parse("arm", &text("arm", &self.arm)?)),
            Some(name) => Some(Arm::built_in(name)),
            None => None,
        };
        let arm = arm.transpose().map_err(refused)?;
        let setting = Setting::new(hand.map_err(refused)?, object, camera).map_err(refused)?;
        Ok(Some(setting.with_arm(arm)))
    }
}

/// What is wrong with what is said of a robot. Where a file would help on a command line, a part of
/// the form does here.
fn refused(error: RobotError) -> Problem {
    let message = match &error {
        RobotError::UnknownHand { name, known } => format!(
            "there is no robot hand {}: use {known}, or describe one in the form's part `robot` and say robot={DESCRIBED}",
            shown(name)
        ),
        RobotError::UnknownArm { name, known } => format!(
            "there is no arm {}: use {known}, or describe one in the form's part `arm` and say arm={DESCRIBED}",
            shown(name)
        ),
        other => other.to_string(),
    };
    Problem::new(StatusCode::BAD_REQUEST, error.kind(), message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_names_no_hand_or_arm_is_told_what_a_request_can_do() {
        let (name, known) = ("nope\n".to_owned(), "one, two".to_owned());
        let hand = refused(RobotError::UnknownHand { name: name.clone(), known: known.clone() });
        let arm = refused(RobotError::UnknownArm { name, known });
        insta::assert_snapshot!(hand.message(), @r"there is no robot hand `nope\n`: use one, two, or describe one in the form's part `robot` and say robot=described");
        insta::assert_snapshot!(arm.message(), @r"there is no arm `nope\n`: use one, two, or describe one in the form's part `arm` and say arm=described");
    }
}
