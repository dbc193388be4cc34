//! Where the hand's mask comes from.

use grasp_index::{BACKGROUND, HandImage};

use crate::error::{RecogniseError, SourceError};
#[cfg(feature = "landmarks")]
use crate::mediapipe::HandNetworks;
use crate::picture::{self, Picture, WORKING_SIDE};
use crate::scene::{self, Detection, Joints, Landmarks, Scene};
use crate::segment::depth::{DepthRange, mask_from_depth};
use crate::segment::{self, Finder, Mask, Quality, SegmentParams};
use crate::segment::{component, median};
use crate::tracker::Tracker;

/// What tells the hand from the rest.
#[derive(Clone, Debug, Default)]
pub enum MaskSource {
    /// A camera picture: the hand is to be found, as [`SegmentParams::by`] says.
    #[default]
    Camera,
    /// The picture is segmented already: all that is not black is hand.
    Segmented,
    /// A mask made elsewhere, of the picture's size.
    Given(Mask),
    /// A mask made elsewhere, on a picture that is segmented already: both must agree.
    SegmentedAnd(Mask),
    /// A camera picture, and where the hand's joints are in it.
    Landmarks(Landmarks),
    /// A depth picture of the picture's size, and what range of it is hand.
    Depth {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// One value a pixel, in the depth picture's unit; 0 where nothing was seen.
        depth: Vec<u16>,
        /// The values that are hand.
        range: DepthRange,
    },
}

/// A picture and the hand in it.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The picture, shrunk to what recognition works on.
    pub picture: Picture,
    /// The hand, of the picture's size.
    pub mask: Mask,
    /// The hand and its forearm, where the hand was found in a camera picture.
    pub skin: Option<Mask>,
    /// What the scene network says of the picture, where it has found the hand.
    pub scene: Option<Scene>,
    /// What colours say for and against the mask, where the hand was found in a camera picture.
    pub quality: Option<Quality>,
}

impl Prepared {
    /// Finds the hand in an encoded picture ([`picture::FORMATS`]).
    ///
    /// # Errors
    /// [`RecogniseError`]: where the bytes are no picture, the picture shows no hand, or mask and
    /// picture do not fit.
    pub fn decode(bytes: &[u8], source: &MaskSource, params: &SegmentParams) -> Result<Self, RecogniseError> {
        let decoded = picture::decode(bytes)?;
        Self::new(decoded.picture, decoded.is_jpeg, source, params)
    }

    /// The hand image H: cropped around the hand, in shades of grey, black where there is no hand.
    ///
    /// # Errors
    /// Where the hand is too small.
    pub fn hand_image(&self) -> Result<HandImage, RecogniseError> {
        let (width, height) = (self.picture.width(), self.picture.height());
        Ok(HandImage::from_mask(width, height, &self.picture.grey(), self.mask.pixels())?)
    }

    /// Finds the hand in a picture. `is_jpeg`: its flat surfaces may ring.
    ///
    /// # Errors
    /// [`RecogniseError`]: where the picture shows no hand, or mask and picture do not fit.
    pub fn new(
        picture: Picture,
        is_jpeg: bool,
        source: &MaskSource,
        params: &SegmentParams,
    ) -> Result<Self, RecogniseError> {
        let found = match source {
            MaskSource::Camera => return Self::of_camera(picture.shrunk_to(WORKING_SIDE), params),
            MaskSource::Landmarks(landmarks) => return Self::of_landmarks(picture, landmarks, params),
            MaskSource::Segmented => not_black(&picture, is_jpeg),
            MaskSource::SegmentedAnd(mask) => mask_of(&picture, mask)?.and(&not_black(&picture, false)),
            MaskSource::Given(mask) => mask_of(&picture, mask)?.clone(),
            MaskSource::Depth { width, height, depth, range } => {
                let sizes = [[*width, *height], [picture.width(), picture.height()]];
                if sizes[0] != sizes[1] {
                    return Err(SourceError::Depth { depth: sizes[0], picture: sizes[1] }.into());
                }
                let found = mask_from_depth(*width, *height, depth, *range);
                found.ok_or(RecogniseError::Empty(
                    "no region of depths within the range is as large as a hand",
                ))?
            }
        };
        if found.area() == 0 {
            let why = match source {
                MaskSource::Segmented => "the picture is all black, where a hand on black is expected",
                _ => "the mask is empty: values of 128 to 255 are the hand",
            };
            return Err(RecogniseError::Empty(why));
        }
        let picture = picture.shrunk_to(WORKING_SIDE);
        let mask = found.resized(picture.width(), picture.height());
        if mask.area() == 0 {
            let why = "what is marked as hand is too thin: nothing is left of it where the picture is shrunk";
            return Err(RecogniseError::Empty(why));
        }
        Ok(Self { picture, mask, skin: None, scene: None, quality: None })
    }

    /// Finds the hand in the next frame of a video, beginning where `tracker` has it from the frame
    /// before; but for [`Finder::Scene`] as in any picture.
    ///
    /// # Errors
    /// [`RecogniseError::NoHand`].
    pub fn next(
        picture: Picture,
        tracker: &mut Tracker,
        params: &SegmentParams,
    ) -> Result<Self, RecogniseError> {
        if params.by != Finder::Scene {
            return Self::new(picture, true, &MaskSource::Camera, params);
        }
        let picture = picture.shrunk_to(WORKING_SIDE);
        let followed = tracker.follow(&params.networks, &picture);
        let followed = followed.and_then(|found| Self::of_found(picture.clone(), found, params).ok());
        let prepared = match followed {
            Some(prepared) => prepared,
            None => {
                let found = tracker.search(&params.networks, &picture).ok_or(RecogniseError::NoHand)?;
                Self::of_found(picture, found, params)?
            }
        };
        let size = (prepared.picture.width(), prepared.picture.height());
        tracker.keep(prepared.scene.as_ref(), size);
        Ok(prepared)
    }

    /// Finds the hand in a camera picture of a working size.
    pub(crate) fn of_camera(picture: Picture, params: &SegmentParams) -> Result<Self, RecogniseError> {
        match &params.by {
            Finder::Scene => Self::of_scene(picture, params),
            Finder::Skin => Self::of_skin(picture, None, params),
            #[cfg(feature = "landmarks")]
            Finder::Landmarks(networks) => Self::of_networks(picture, networks, params),
        }
    }

    /// Finds the hand whose joints are known.
    fn of_landmarks(
        picture: Picture,
        landmarks: &Landmarks,
        params: &SegmentParams,
    ) -> Result<Self, RecogniseError> {
        let joints = landmarks.of_picture(picture.width(), picture.height());
        let joints = joints.map_err(SourceError::Landmarks)?;
        let joints = joints.shrunk(picture.shrink_factor(WORKING_SIDE));
        let picture = picture.shrunk_to(WORKING_SIDE);
        match &params.by {
            Finder::Skin => Self::of_skin(picture, Some(&joints), params),
            _ => {
                let found = scene::find_at(&params.networks, &picture, &joints);
                Self::of_found(picture, found, params)
            }
        }
    }

    /// Finds the hand by the colour of skin, and by where its joints are if that is known.
    fn of_skin(
        picture: Picture,
        joints: Option<&Joints>,
        params: &SegmentParams,
    ) -> Result<Self, RecogniseError> {
        let cut = match joints {
            None => segment::segment(&picture, params),
            Some(joints) => segment::segment_seen(&picture, params, Some(&|place| joints.hand(place))),
        };
        let found = cut.ok_or(RecogniseError::NoHand)?;
        let (skin, quality) = (Some(found.skin), Some(found.quality));
        Ok(Self { picture, mask: found.hand, skin, scene: None, quality })
    }

    /// Finds the hand by the scene network.
    fn of_scene(picture: Picture, params: &SegmentParams) -> Result<Self, RecogniseError> {
        let found = scene::find(&params.networks, &picture);
        Self::of_found(picture, found.ok_or(RecogniseError::NoHand)?, params)
    }

    /// Finds the hand by MediaPipe's networks; where they find none, or nothing about the joints
    /// looks like one, by the scene network.
    #[cfg(feature = "landmarks")]
    fn of_networks(
        picture: Picture,
        networks: &HandNetworks,
        params: &SegmentParams,
    ) -> Result<Self, RecogniseError> {
        let found = scene::find_by_joints(networks, &params.networks, &picture);
        let found = found.map_err(SourceError::Networks)?;
        let cut = found.and_then(|found| Self::of_found(picture.clone(), found, params).ok());
        cut.map_or_else(|| Self::of_scene(picture, params), Ok)
    }

    /// Cuts out a hand that the scene network has found, by colour and by what that has seen.
    fn of_found(picture: Picture, seen: Detection, params: &SegmentParams) -> Result<Self, RecogniseError> {
        let cut = segment::segment_seen(&picture, params, Some(&|place| seen.skin(place)));
        let cut = cut.ok_or(RecogniseError::NoHand)?;
        let scene = Some(Scene::new(&params.networks, &picture, seen, &cut.hand));
        let (skin, quality) = (Some(cut.skin), Some(cut.quality));
        Ok(Self { picture, mask: cut.hand, skin, scene, quality })
    }
}

/// JPEG rings around the hand: black becomes up to this bright.
const JPEG_FLOOR: u8 = 16;

/// A mask, if it is one of this picture.
fn mask_of<'m>(picture: &Picture, mask: &'m Mask) -> Result<&'m Mask, SourceError> {
    mask.check_size(picture.width(), picture.height()).map_err(SourceError::Mask)?;
    Ok(mask)
}

/// All that is not black. A JPEG is cleaned of its ringing, whose specks would stretch the hand's
/// box.
fn not_black(picture: &Picture, is_jpeg: bool) -> Mask {
    let grey = picture.grey();
    let floor = if is_jpeg { JPEG_FLOOR } else { BACKGROUND };
    let mask = Mask::from_values(picture.width(), picture.height(), &grey, |value| value > floor);
    if !is_jpeg {
        return mask;
    }
    component::without_specks(&median::median3x3(&mask))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_what_was_given_shows_no_hand_is_said_of_it_and_not_of_the_picture() {
        let error = |source: MaskSource| {
            let picture = Picture::new(1200, 40, vec![[90; 3]; 1200 * 40]).unwrap();
            Prepared::new(picture, false, &source, &SegmentParams::default()).unwrap_err().to_string()
        };
        let mask = |test: fn(usize) -> bool| {
            Mask::from_values(1200, 40, &(0..1200 * 40).map(test).collect::<Vec<_>>(), |inside| inside)
        };
        insta::assert_snapshot!(error(MaskSource::Given(mask(|_| false))), @"no hand: the mask is empty: values of 128 to 255 are the hand");
        insta::assert_snapshot!(error(MaskSource::Given(mask(|at| at % 1200 == 600))), @"no hand: what is marked as hand is too thin: nothing is left of it where the picture is shrunk");
        let depth = (0..1200 * 40).map(|at| if at < 100 { 500 } else { 2000 }).collect();
        let range = "400..900".parse().unwrap();
        insta::assert_snapshot!(error(MaskSource::Depth { width: 1200, height: 40, depth, range }), @"no hand: no region of depths within the range is as large as a hand");
    }
}
