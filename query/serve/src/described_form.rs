//! What the forms of pictures look like, for the description of the interface: `body` reads them.

use std::borrow::Cow;

use utoipa::openapi::RefOr;
use utoipa::openapi::schema::Schema;
use utoipa::{PartialSchema, ToSchema};

/// A picture, and what is known of its hand or what a robot shall do.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "it is the description of what is read part by part")]
pub(super) struct PictureForm {
    /// The picture, as a file of PNG, JPEG, WebP, GIF, BMP or PNM.
    #[schema(value_type = String, content_media_type = "application/octet-stream")]
    picture: Vec<u8>,
    /// A picture of the same size that is white where the hand is.
    #[schema(value_type = String, required = false, content_media_type = "application/octet-stream")]
    mask: Option<Vec<u8>>,
    /// A depth picture of the same size, for `depth_range`.
    #[schema(value_type = String, required = false, content_media_type = "application/octet-stream")]
    depth: Option<Vec<u8>>,
    /// Where a tracker has the hand's joints.
    #[schema(value_type = LandmarkPart, required = false)]
    landmarks: Option<LandmarkPart>,
    /// The object to be grasped, as TOML.
    #[schema(value_type = String, required = false)]
    object: Option<String>,
    /// Where the camera stands, as TOML.
    #[schema(value_type = String, required = false)]
    camera: Option<String>,
    /// The robot hand, as TOML, for `robot=described`.
    #[schema(value_type = String, required = false)]
    robot: Option<String>,
    /// The arm, as TOML, for `arm=described`.
    #[schema(value_type = String, required = false)]
    arm: Option<String>,
}

/// The hand's 21 joints, in MediaPipe's order.
#[derive(Debug, ToSchema)]
#[schema(as = Landmarks)]
#[expect(dead_code, reason = "it is the description of what is read as landmarks")]
struct LandmarkPart {
    /// What places are counted in.
    #[schema(inline)]
    unit: Unit,
    /// Right and down.
    #[schema(min_items = 21, max_items = 21)]
    landmarks: Vec<[f64; 2]>,
}

#[derive(Debug, ToSchema)]
#[schema(rename_all = "lowercase")]
#[expect(dead_code, reason = "it is the description of what is read as landmarks")]
enum Unit {
    Pixel,
    Share,
}

/// The same where a robot shall do something: what it grasps and where the camera stands are
/// needed.
#[derive(Debug)]
pub(super) struct StrategyForm;

impl PartialSchema for StrategyForm {
    fn schema() -> RefOr<Schema> {
        let mut schema = PictureForm::schema();
        if let RefOr::T(Schema::Object(form)) = &mut schema {
            form.description = Some("A picture of a hand, and what a robot shall do.".into());
            form.required.extend(["object", "camera"].map(str::to_owned));
        }
        schema
    }
}

impl ToSchema for StrategyForm {
    fn name() -> Cow<'static, str> {
        "StrategyForm".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        PictureForm::schemas(schemas);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::input;
    use axum::body::Bytes;
    use axum::http::HeaderValue;

    #[test]
    fn the_parts_that_are_described_are_those_that_are_read() {
        let RefOr::T(Schema::Object(form)) = PictureForm::schema() else { panic!("no object") };
        let kind = HeaderValue::from_static("multipart/form-data; boundary=x");
        let read = |names: &[&str]| {
            let parts = names
                .iter()
                .map(|name| format!("--x\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n\r\n"));
            let body = parts.chain(["--x--".to_owned()]).collect::<String>();
            input(Some(&kind), Bytes::from(body)).map(drop).map_err(|problem| format!("{problem:?}"))
        };
        let names: Vec<&str> = form.properties.keys().map(String::as_str).collect();
        assert_eq!(read(&names), Ok(()));
        assert_eq!(form.required, ["picture"]);
        // And no other is: the message names them all.
        let refused = read(&["other"]).unwrap_err();
        let (_, known) = refused.split_once("its parts are ").unwrap();
        assert_eq!(known.matches(", ").count() + 2, names.len(), "{known}");
        assert!(names.iter().all(|name| known.contains(name)), "{known}");
    }
}
