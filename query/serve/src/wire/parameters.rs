//! The options of a request: query parameters, named as the options of the command line are.

use std::ops::{RangeBounds as _, RangeInclusive};

use super::parameter_error::ParameterError;
use grasp_index::{Effort, SearchOptions, VoteOptions};
use serde::{Deserialize, Serialize};
use utoipa::openapi::Required;
use utoipa::openapi::path::{Parameter, ParameterIn};
use utoipa::{IntoParams, ToSchema};

use grasp_recognise::segment::depth::DepthRange;
use grasp_recognise::segment::{Finder, SegmentParams};
use grasp_recognise::{Accept, HandChoice, RecogniseOptions, ranges};

/// How many neighbours of one hand or query a request may ask for: fewer than elsewhere, because an
/// answer that names more has megabytes.
const NEIGHBOURS: RangeInclusive<usize> = 1..=1000;

/// Options of a picture's request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PictureParameters {
    /// What the record's `file` shall say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// What the record's `frame` shall say.
    #[param(maximum = 18_446_744_073_709_551_615u64)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// Which hand the picture shows; without it, both are tried.
    #[param(inline)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandChoice>,
    /// Try this many turns of the picture, evenly over the circle, 1 to 360.
    #[param(minimum = 1, maximum = 360)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolls: Option<usize>,
    /// Look at a camera picture in eight more variants, mirrored, turned, in other light and
    /// enlarged.
    #[serde(skip_serializing_if = "is_false")]
    pub thorough: bool,
    /// How many neighbours vote, 1 to 1000; without it, what the index was calibrated with.
    #[param(minimum = 1, maximum = 1000)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k: Option<usize>,
    /// Width of the vote's kernel as a distance between descriptors.
    #[param(exclusive_minimum = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// Width of the vote's kernel as a multiple of the index's measured sigma.
    #[param(exclusive_minimum = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_scale: Option<f64>,
    /// Take sigma from Equation 5 as it is printed.
    #[serde(skip_serializing_if = "is_false")]
    pub literal_sigma: bool,
    /// Average Euler angles, as Equation 4 is printed.
    #[serde(skip_serializing_if = "is_false")]
    pub euler_mean: bool,
    /// Whether a hand may be unknown: `calibrated`, by the limits of the index, or `always` a
    /// class; without it, calibrated.
    #[param(inline)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accept: Option<AcceptChoice>,
    /// A hand is unknown where its nearest entry lies farther than this.
    #[param(exclusive_minimum = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown_at: Option<f64>,
    /// Find this share of the true 10 nearest, above 0, at most 1; without it, 0.95.
    #[param(exclusive_minimum = 0, maximum = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recall: Option<f64>,
    /// Find a neighbour at most 1 + eps times as far as the true nearest.
    #[param(minimum = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps: Option<f64>,
    /// Find such a neighbour, as `eps` asks for, for this share of all queries; without it, 0.95.
    #[param(exclusive_minimum = 0, maximum = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub success: Option<f64>,
    /// Look into this many buckets of each table.
    #[param(minimum = 1, maximum = 4_294_967_295u32)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<u32>,
    /// Compare with every entry.
    #[serde(skip_serializing_if = "is_false")]
    pub exact: bool,
    /// What finds the hand in a camera picture; without it, scene.
    #[param(inline)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<SegmentBy>,
    /// The picture is segmented already: a hand on black.
    #[serde(skip_serializing_if = "is_false")]
    pub segmented: bool,
    /// NEAR..FAR: what of the depth picture is hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_range: Option<String>,
    /// Plan the same grasp for this robot hand: allegro, barrett, franka-hand,
    /// parallel-gripper, robotiq-2f-85, or `described` by the form's part `robot`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Say by which joint angles this arm carries the hand: franka-panda, kuka-kr6-r700, ur5e, or
    /// `described` by the form's part `arm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// Add how long each step took.
    #[serde(skip_serializing_if = "is_false")]
    pub timings: bool,
    /// Add mask, hand image and descriptor, to draw how the answer came about.
    #[serde(skip_serializing_if = "is_false")]
    pub explained: bool,
}

/// The same for a request that is about a robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StrategyParameters;

impl IntoParams for StrategyParameters {
    fn into_params(parameter_in: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let mut parameters = PictureParameters::into_params(parameter_in);
        for robot in parameters.iter_mut().filter(|parameter| parameter.name == "robot") {
            robot.required = Required::True;
        }
        parameters
    }
}

/// What finds the hand in a camera picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum SegmentBy {
    /// A network that was trained on scenes.
    Scene,
    /// The colour of skin.
    Skin,
}

/// Whether a hand may be unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum AcceptChoice {
    /// Every hand has a class.
    Always,
    /// By the limits that the index was calibrated with.
    Calibrated,
}

/// Options of a request for neighbours.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SearchParameters {
    /// How many neighbours to find for each query, 1 to 1000; without it, 10.
    #[param(minimum = 1, maximum = 1000)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k: Option<usize>,
    /// Find this share of the true 10 nearest, above 0, at most 1; without it, 0.95.
    #[param(exclusive_minimum = 0, maximum = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recall: Option<f64>,
    /// Find a neighbour at most 1 + eps times as far as the true nearest.
    #[param(minimum = 0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps: Option<f64>,
    /// Find such a neighbour, as `eps` asks for, for this share of all queries; without it, 0.95.
    #[param(exclusive_minimum = 0, maximum = 1)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub success: Option<f64>,
    /// Look into this many buckets of each table.
    #[param(minimum = 1, maximum = 4_294_967_295u32)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<u32>,
    /// Compare with every entry.
    #[serde(skip_serializing_if = "is_false")]
    pub exact: bool,
    /// Return the candidates of the search, each with the `key` that it was kept by, for clients
    /// that merge the answers of several segments of an index.
    #[serde(skip_serializing_if = "is_false")]
    pub shortlist: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over references")]
fn is_false(value: &bool) -> bool {
    !value
}

impl PictureParameters {
    /// The parameters that mean these options; a service that is sent them recognises as this
    /// program would.
    pub fn from_options(options: &RecogniseOptions) -> Self {
        let vote = options.vote;
        let Efforts { recall, eps, success, probes, exact } = Efforts::from_effort(options.effort);
        let mut parameters = Self {
            recall,
            eps,
            success,
            probes,
            exact,
            hand: Some(options.hand),
            rolls: Some(options.rolls),
            thorough: options.thorough,
            k: options.k,
            sigma: vote.sigma,
            sigma_scale: vote.sigma_scale,
            literal_sigma: vote.literal_sigma,
            euler_mean: vote.euler_mean,
            segment: match options.segment.by {
                Finder::Skin => Some(SegmentBy::Skin),
                // An older service does not know the parameter, and none has networks of its
                // clients'.
                _ => None,
            },
            ..Self::default()
        };
        match options.accept {
            Accept::Always => parameters.accept = Some(AcceptChoice::Always),
            Accept::Calibrated => parameters.accept = Some(AcceptChoice::Calibrated),
            Accept::Within(farthest) => parameters.unknown_at = Some(farthest),
        }
        parameters
    }

    /// The options that these parameters mean, or what is wrong with them.
    ///
    /// # Errors
    /// [`ParameterError`]: its message is for the one who asked.
    pub fn options(&self) -> Result<RecogniseOptions, ParameterError> {
        let defaults = RecogniseOptions::default();
        if self.sigma.is_some() && (self.sigma_scale.is_some() || self.literal_sigma)
            || self.sigma_scale.is_some() && self.literal_sigma
        {
            return Err(ParameterError::OneOf("sigma, sigma_scale and literal_sigma"));
        }
        if self.accept.is_some() && self.unknown_at.is_some() {
            return Err(ParameterError::OneOf("accept and unknown_at"));
        }
        let accept = match (positive("unknown_at", self.unknown_at)?, self.accept) {
            (Some(farthest), _) => Accept::Within(farthest),
            (None, Some(AcceptChoice::Always)) => Accept::Always,
            (None, Some(AcceptChoice::Calibrated)) => Accept::Calibrated,
            (None, None) => defaults.accept,
        };
        Ok(RecogniseOptions {
            accept,
            hand: self.hand.unwrap_or(defaults.hand),
            rolls: count("rolls", self.rolls, &ranges::ROLLS)?.unwrap_or(defaults.rolls),
            thorough: self.thorough,
            k: count("k", self.k, &NEIGHBOURS)?,
            effort: self.efforts().effort()?,
            vote: VoteOptions {
                sigma: positive("sigma", self.sigma)?,
                sigma_scale: positive("sigma_scale", self.sigma_scale)?,
                literal_sigma: self.literal_sigma,
                euler_mean: self.euler_mean,
            },
            segment: SegmentParams { by: self.finder(), ..defaults.segment },
            ..defaults
        })
    }

    fn finder(&self) -> Finder {
        match self.segment {
            None => Finder::default(),
            Some(SegmentBy::Scene) => Finder::Scene,
            Some(SegmentBy::Skin) => Finder::Skin,
        }
    }

    fn efforts(&self) -> Efforts {
        let &Self { recall, eps, success, probes, exact, .. } = self;
        Efforts { recall, eps, success, probes, exact }
    }

    /// The depths that are hand, where any are named.
    pub(crate) fn depth_range(&self) -> Result<Option<DepthRange>, ParameterError> {
        Ok(self.depth_range.as_ref().map(|text| text.parse()).transpose()?)
    }
}

impl SearchParameters {
    fn efforts(&self) -> Efforts {
        let &Self { recall, eps, success, probes, exact, .. } = self;
        Efforts { recall, eps, success, probes, exact }
    }

    /// The parameters that mean these options.
    pub fn from_options(options: &SearchOptions) -> Self {
        let Efforts { recall, eps, success, probes, exact } = Efforts::from_effort(options.effort);
        Self { k: Some(options.k), recall, eps, success, probes, exact, shortlist: false }
    }

    /// The options that these parameters mean, or what is wrong with them.
    pub(crate) fn options(&self) -> Result<SearchOptions, ParameterError> {
        Ok(SearchOptions {
            k: count("k", self.k, &NEIGHBOURS)?.unwrap_or(SearchOptions::default().k),
            effort: self.efforts().effort()?,
        })
    }
}

fn count(
    name: &'static str,
    value: Option<usize>,
    range: &RangeInclusive<usize>,
) -> Result<Option<usize>, ParameterError> {
    match value {
        Some(value) if !range.contains(&value) => {
            Err(ParameterError::Count { name, value, least: *range.start(), most: *range.end() })
        }
        count => Ok(count),
    }
}

fn positive(name: &'static str, value: Option<f64>) -> Result<Option<f64>, ParameterError> {
    match value {
        Some(value) if !ranges::POSITIVE.contains(&value) => Err(ParameterError::Positive { name, value }),
        number => Ok(number),
    }
}

fn share(name: &'static str, value: f64) -> Result<f64, ParameterError> {
    ranges::RECALL.contains(&value).then_some(value).ok_or(ParameterError::Share { name, value })
}

/// What is wanted of the search, as both kinds of requests name it. (They cannot share it as
/// fields: numbers in a query are text, which serde does not hand on to what is flattened into
/// another.)
#[derive(Clone, Copy, Debug, Default)]
struct Efforts {
    recall: Option<f64>,
    eps: Option<f64>,
    success: Option<f64>,
    probes: Option<u32>,
    exact: bool,
}

impl Efforts {
    fn from_effort(effort: Effort) -> Self {
        let none = Self::default();
        match effort {
            Effort::Recall(recall) => Self { recall: Some(recall), ..none },
            Effort::Success { eps, success } => Self { eps: Some(eps), success: Some(success), ..none },
            Effort::Probes(probes) => Self { probes: Some(probes), ..none },
            Effort::Exact => Self { exact: true, ..none },
        }
    }

    /// The effort that is meant. The numbers are checked here, but for `probes`, which depends on
    /// the index.
    fn effort(self) -> Result<Effort, ParameterError> {
        let Self { recall, eps, success, probes, exact } = self;
        let named = [recall.is_some(), eps.is_some(), probes.is_some(), exact];
        if named.into_iter().filter(|is_named| *is_named).count() > 1 {
            return Err(ParameterError::OneOf("recall, eps, probes and exact"));
        }
        match (recall, eps, success, probes) {
            (_, None, Some(_), _) => Err(ParameterError::SuccessWithoutEps),
            (Some(recall), ..) => share("recall", recall).map(Effort::Recall),
            (_, Some(eps), success, _) => {
                if !ranges::EPS.contains(&eps) {
                    return Err(ParameterError::Eps(eps));
                }
                let success = share("success", success.unwrap_or(Effort::DEFAULT_SUCCESS))?;
                Ok(Effort::Success { eps, success })
            }
            (.., Some(probes)) if !ranges::PROBES.contains(&probes) => Err(ParameterError::Probes),
            (.., Some(probes)) => Ok(Effort::Probes(probes)),
            _ if exact => Ok(Effort::Exact),
            _ => Ok(SearchOptions::default().effort),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::de::DeserializeOwned;

    fn efforts() -> impl Strategy<Value = Effort> {
        prop_oneof![
            (1e-6f64..=1.0).prop_map(Effort::Recall),
            (0.0f64..10.0, 1e-6f64..=1.0).prop_map(|(eps, success)| Effort::Success { eps, success }),
            (1u32..).prop_map(Effort::Probes),
            Just(Effort::Exact),
        ]
    }

    proptest! {
        #[test]
        fn options_survive_the_way_over_the_wire(
            effort in efforts(),
            hand in prop_oneof![Just(HandChoice::Auto), Just(HandChoice::Left), Just(HandChoice::Right)],
            rolls in ranges::ROLLS,
            thorough: bool,
            k in proptest::option::of(NEIGHBOURS),
            sigma in proptest::option::of(1e-9f64..1e9),
            euler_mean: bool,
            accept in prop_oneof![Just(Accept::Always), Just(Accept::Calibrated), (1e-9f64..1e9).prop_map(Accept::Within)],
        ) {
            let vote = VoteOptions { sigma, euler_mean, ..VoteOptions::default() };
            let options = RecogniseOptions { hand, rolls, thorough, k, effort, vote, accept, ..RecogniseOptions::default() };
            let sent = serde_urlencoded::to_string(PictureParameters::from_options(&options)).unwrap();
            let found = serde_urlencoded::from_str::<PictureParameters>(&sent).unwrap().options().unwrap();
            prop_assert_eq!(format!("{found:?}"), format!("{options:?}"));
        }

        #[test]
        fn no_query_panics_or_asks_for_too_much(query in ".*") {
            if let Ok(options) =
                serde_urlencoded::from_str::<PictureParameters>(&query).map_err(drop).and_then(|p| p.options().map_err(drop))
            {
                prop_assert!(ranges::ROLLS.contains(&options.rolls) && options.k.is_none_or(|k| NEIGHBOURS.contains(&k)));
            }
        }
    }

    /// What is wrong with such a query, if anything is.
    fn refused<P: DeserializeOwned, O>(
        query: &str,
        options: impl Fn(&P) -> Result<O, ParameterError>,
    ) -> Option<String> {
        let parameters = serde_urlencoded::from_str::<P>(query).map_err(|error| error.to_string());
        parameters.and_then(|parameters| options(&parameters).map_err(|error| error.to_string())).err()
    }

    /// The description is written out; what is refused is what the library's ranges leave out.
    #[test]
    fn the_ranges_that_are_described_are_those_that_are_checked() {
        let of_picture = |query: &str| refused(query, PictureParameters::options);
        let of_search = |query: &str| refused(query, SearchParameters::options);
        let (pictures, searches) =
            (PictureParameters::into_params(|| None), SearchParameters::into_params(|| None));
        let pictures = pictures.iter().map(|of| (of, &of_picture as &dyn Fn(&str) -> Option<String>));
        let searches = searches.iter().map(|of| (of, &of_search as &dyn Fn(&str) -> Option<String>));
        let mut bounds = 0;
        for (parameter, refused) in pictures.chain(searches) {
            let name = &parameter.name;
            let schema = serde_json::to_value(&parameter.schema).unwrap();
            let step = if schema["type"].to_string().contains("integer") { 1.0 } else { 1e-9 };
            let mut check = |bound: &str, is_in: bool, inwards: f64| {
                let Some(at) = schema[bound].as_f64() else { return };
                bounds += 1;
                let query = |value: f64| match name.as_str() {
                    "success" => format!("eps=0&success={value}"),
                    _ => format!("{name}={value}"),
                };
                assert_eq!(refused(&query(at)).is_none(), is_in, "{}: {:?}", query(at), refused(&query(at)));
                let [inside, outside] = [inwards, -inwards].map(|by| query(at + by * step));
                assert_eq!(refused(&inside), None, "{inside}");
                assert!(refused(&outside).is_some(), "{outside}");
            };
            check("minimum", true, 1.0);
            check("exclusiveMinimum", false, 1.0);
            if name != "frame" {
                check("maximum", true, -1.0);
            }
            if matches!(name.as_str(), "rolls" | "k") {
                let said = format!("{} to {}", schema["minimum"], schema["maximum"]);
                assert!(parameter.description.as_ref().unwrap().contains(&said), "{name}");
            }
        }
        assert_eq!(bounds, 24, "all that are described");
        assert!(
            ranges::NEIGHBOURS.contains(NEIGHBOURS.start()) && ranges::NEIGHBOURS.contains(NEIGHBOURS.end())
        );
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        for (query, says) in [
            ("rolls=0", "rolls is 0"),
            ("rolls=361", "1 to 360"),
            ("k=1001", "1 to 1000"),
            ("recall=0", "recall is 0"),
            ("recall=0.9&exact=true", "only one of"),
            ("success=0.9", "success needs eps"),
            ("eps=NaN", "eps is NaN"),
            ("sigma=-1", "sigma is -1"),
            ("sigma=1&sigma_scale=1", "only one of"),
            ("probes=0", "probes is 0"),
        ] {
            let parameters: PictureParameters = serde_urlencoded::from_str(query).unwrap();
            let message = parameters.options().unwrap_err().to_string();
            assert!(message.contains(says), "{query}: {message}");
        }
        for query in ["recal=0.9", "k=-1", "hand=both", "exact=yes", "k=1&k=2"] {
            assert!(serde_urlencoded::from_str::<PictureParameters>(query).is_err(), "{query}");
        }
    }
}
