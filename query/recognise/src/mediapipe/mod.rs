//! Finds palms, and the joints of hands, by two networks of MediaPipe's, which a user has as ONNX
//! files.
//!
//! "MediaPipe Hands: On-device Real-time Hand Tracking" (F. Zhang et al., 2020) describes them, and
//! so do the graphs `palm_detection_cpu` and `hand_landmark_cpu` of the project, whose numbers are
//! taken over here. Both look at squares and answer in shares of them; where these lie in a picture
//! is for others to choose. The crate `rten` runs them: what it computes may differ in its last
//! digits from one processor to another.

mod anchors;
mod files;
mod hand;
mod network;
mod palm;
#[cfg(test)]
pub(crate) mod tests_support;

pub use files::{HandNetworks, HandNetworksError};
pub(crate) use hand::{HAND_SIDE, Hand};
pub use network::NetworkFault;
pub(crate) use palm::{PALM_SIDE, Palm};
