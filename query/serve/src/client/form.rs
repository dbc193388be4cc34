//! What is sent: a picture alone, or a form of a picture and what tells the hand in it or the robot
//! its work.

use axum::body::Bytes;
use xxhash_rust::xxh3::xxh3_128;

/// The parts of a request, encoded as their files are.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// The picture.
    pub picture: Bytes,
    /// A mask of the hand.
    pub mask: Option<Bytes>,
    /// A depth picture.
    pub depth: Option<Bytes>,
    /// A robot hand's description.
    pub robot: Option<Bytes>,
    /// The object's.
    pub object: Option<Bytes>,
    /// The camera's.
    pub camera: Option<Bytes>,
    /// An arm's.
    pub arm: Option<Bytes>,
}

impl Parts {
    /// The content type and the body.
    pub(super) fn encode(&self) -> (String, Bytes) {
        let others = [
            ("mask", &self.mask),
            ("depth", &self.depth),
            ("robot", &self.robot),
            ("object", &self.object),
            ("camera", &self.camera),
            ("arm", &self.arm),
        ];
        let mut others =
            others.into_iter().filter_map(|(name, bytes)| Some((name, bytes.as_ref()?))).peekable();
        if others.peek().is_none() {
            return ("application/octet-stream".into(), self.picture.clone());
        }
        // Of the picture's own bytes: it cannot stand in them by accident.
        let boundary = format!("grasp-{:032x}", xxh3_128(&self.picture));
        let mut body = Vec::new();
        for (name, bytes) in std::iter::once(("picture", &self.picture)).chain(others) {
            let head = format!("--{boundary}\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n");
            body.extend_from_slice(head.as_bytes());
            body.extend_from_slice(bytes);
            body.extend_from_slice(b"\r\n");
        }
        body.extend_from_slice(format!("--{boundary}--\r\n").as_bytes());
        (format!("multipart/form-data; boundary={boundary}"), body.into())
    }
}
