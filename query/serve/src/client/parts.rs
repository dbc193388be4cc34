//! What is sent: a picture alone, or a form of a picture and what tells the hand in it or the robot
//! its work.

use ureq::http::Response;
use ureq::typestate::WithBody;
use ureq::unversioned::multipart::{Form, Part};
use ureq::{Body, Error, RequestBuilder};

/// The parts of a request, encoded as their files are.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// The picture.
    pub picture: Vec<u8>,
    /// A mask of the hand.
    pub mask: Option<Vec<u8>>,
    /// A depth picture.
    pub depth: Option<Vec<u8>>,
    /// Where the hand's joints are, as JSON.
    pub landmarks: Option<Vec<u8>>,
    /// A robot hand's description.
    pub robot: Option<Vec<u8>>,
    /// The object's.
    pub object: Option<Vec<u8>>,
    /// The camera's.
    pub camera: Option<Vec<u8>>,
    /// An arm's.
    pub arm: Option<Vec<u8>>,
}

impl Parts {
    fn others(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        let Self { picture: _, mask, depth, landmarks, robot, object, camera, arm } = self;
        let names = ["mask", "depth", "landmarks", "robot", "object", "camera", "arm"];
        let others = [mask, depth, landmarks, robot, object, camera, arm];
        names.into_iter().zip(others).filter_map(|(name, part)| Some((name, part.as_deref()?)))
    }

    /// The bytes of all parts together.
    pub(super) fn len(&self) -> usize {
        self.picture.len() + self.others().map(|(_, part)| part.len()).sum::<usize>()
    }

    /// Sends them by a request.
    pub(super) fn send(&self, request: RequestBuilder<WithBody>) -> Result<Response<Body>, Error> {
        if self.others().next().is_none() {
            return request.content_type("application/octet-stream").send(&self.picture);
        }
        let form = Form::new().part("picture", Part::bytes(&self.picture));
        request.send(self.others().fold(form, |form, (name, part)| form.part(name, Part::bytes(part))))
    }
}
