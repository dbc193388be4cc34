//! How objects are usually grasped: what is known of the object counts for the grasp (the paper's
//! Section VIII, the integration with object recognition).
//!
//! A table of objects, each with probabilities of grasps; grasps that an object does not name share
//! evenly what is left:
//!
//! ```toml
//! [objects.bottle]
//! large-diameter = 0.7
//! small-diameter = 0.2
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// The least probability of any grasp: a table of habits cannot rule one out.
const FLOOR: f64 = 1e-3;

/// The table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Priors {
    objects: BTreeMap<String, BTreeMap<String, f64>>,
}

/// A table that cannot be used, or an object that it does not know.
#[derive(Debug, thiserror::Error)]
pub enum PriorError {
    /// The file cannot be read.
    #[error("cannot read the prior {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is no such table.
    #[error("the prior {} is not a table of [objects.NAME] with grasp = probability", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Why.
        source: toml::de::Error,
    },
    /// The object is not in the table.
    #[error("the prior has no object `{object}`; it has {known}")]
    UnknownObject {
        /// What was asked for.
        object: String,
        /// What is there.
        known: String,
    },
    /// The object names a grasp that the index has not.
    #[error("the prior's object `{object}` names the grasp `{grasp}`; the index has {known}")]
    UnknownGrasp {
        /// The object.
        object: String,
        /// The grasp.
        grasp: String,
        /// The index's grasps.
        known: String,
    },
    /// A probability that is none, or probabilities that sum to more than 1.
    #[error(
        "the prior's object `{object}`: {fault}: probabilities of 0 to 1 are needed that sum to 1 at most"
    )]
    Probability {
        /// The object.
        object: String,
        /// What is wrong; part of the message, and so no source beside it.
        fault: ProbabilityFault,
    },
}

/// What is wrong with the probabilities of an object's grasps.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProbabilityFault {
    /// One of them is none.
    #[error("{grasp} is {probability}")]
    Range {
        /// The grasp.
        grasp: String,
        /// What is said of it.
        probability: f64,
    },
    /// No grasp is left.
    #[error("each of the index's grasps is 0, which leaves none")]
    Nothing,
    /// Together they are more than certain.
    #[error("its grasps sum to {0}")]
    Sum(f64),
}

impl Priors {
    /// Reads a table.
    ///
    /// # Errors
    /// [`PriorError`], where the file cannot be read or is no table.
    pub fn read(path: &Path) -> Result<Self, PriorError> {
        let text = grasp_bounded::read_text(path)
            .map_err(|source| PriorError::Read { path: path.to_owned(), source })?;
        toml::from_str(&text).map_err(|source| PriorError::Form { path: path.to_owned(), source })
    }

    /// The probability of each of `grasps` for an object; they sum to 1.
    ///
    /// # Errors
    /// [`PriorError`], where the table does not know the object, or what it says of it makes no
    /// sense.
    pub fn probabilities(&self, object: &str, grasps: &[String]) -> Result<Vec<f64>, PriorError> {
        let said = self.objects.get(object).ok_or_else(|| PriorError::UnknownObject {
            object: object.to_owned(),
            known: self.objects.keys().cloned().collect::<Vec<_>>().join(", "),
        })?;
        let wrong = |fault| PriorError::Probability { object: object.to_owned(), fault };
        for (grasp, &probability) in said {
            if !grasps.contains(grasp) {
                let known = grasps.join(", ");
                return Err(PriorError::UnknownGrasp {
                    object: object.to_owned(),
                    grasp: grasp.clone(),
                    known,
                });
            }
            if !(0.0..=1.0).contains(&probability) {
                return Err(wrong(ProbabilityFault::Range { grasp: grasp.clone(), probability }));
            }
        }
        let named: f64 = said.values().sum();
        if named > 1.0 + 1e-9 {
            return Err(wrong(ProbabilityFault::Sum(named)));
        }
        if named == 0.0 && said.len() == grasps.len() {
            return Err(wrong(ProbabilityFault::Nothing));
        }
        let unnamed = grasps.len().saturating_sub(said.len()).max(1) as f64;
        let rest = (1.0 - named).max(0.0) / unnamed;
        let floored: Vec<f64> =
            grasps.iter().map(|grasp| said.get(grasp).copied().unwrap_or(rest).max(FLOOR)).collect();
        let sum: f64 = floored.iter().sum();
        Ok(floored.into_iter().map(|probability| probability / sum).collect())
    }
}

/// Weighs calibrated probabilities, found with all classes alike before, by a prior of the same
/// length.
pub fn weigh(probabilities: &[f64], prior: &[f64]) -> Vec<f64> {
    let products: Vec<f64> = probabilities.iter().zip(prior).map(|(p, prior)| p * prior).collect();
    let sum: f64 = products.iter().sum();
    if sum > 0.0 { products.iter().map(|product| product / sum).collect() } else { probabilities.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grasps() -> Vec<String> {
        ["large-diameter", "pinch", "power-sphere"].map(str::to_owned).to_vec()
    }

    fn priors(text: &str) -> Priors {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn what_is_not_named_shares_the_rest() {
        let table = priors("[objects.bottle]\nlarge-diameter = 0.8\n[objects.any]\n");
        let found = table.probabilities("bottle", &grasps()).unwrap();
        for (found, expected) in found.iter().zip([0.8, 0.1, 0.1]) {
            assert!((found - expected).abs() < 1e-12);
        }
        let alike = table.probabilities("any", &grasps()).unwrap();
        assert!(alike.iter().all(|p| (p - 1.0 / 3.0).abs() < 1e-12));
        // Alike before, nothing changes.
        assert_eq!(weigh(&[0.5, 0.25, 0.25], &[0.5, 0.5, 0.5]), [0.5, 0.25, 0.25]);
        let weighed = weigh(&[0.4, 0.6, 0.0], &[0.75, 0.25, 0.0]);
        assert!(weighed.iter().zip([2.0 / 3.0, 1.0 / 3.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn no_grasp_is_ruled_out() {
        let found = priors("[objects.pen]\npinch = 1.0").probabilities("pen", &grasps()).unwrap();
        assert!(found[0] > 0.0 && found[1] > 0.99);
    }

    #[test]
    fn tables_that_make_no_sense_are_told() {
        let told = |text: &str| priors(text).probabilities("cup", &grasps()).unwrap_err().to_string();
        insta::assert_snapshot!(told("[objects.bottle]"), @"the prior has no object `cup`; it has bottle");
        insta::assert_snapshot!(told("[objects.cup]\nhook = 0.5"), @"the prior's object `cup` names the grasp `hook`; the index has large-diameter, pinch, power-sphere");
        insta::assert_snapshot!(told("[objects.cup]\npinch = -0.5"), @"the prior's object `cup`: pinch is -0.5: probabilities of 0 to 1 are needed that sum to 1 at most");
        insta::assert_snapshot!(told("[objects.cup]\npinch = nan"), @"the prior's object `cup`: pinch is NaN: probabilities of 0 to 1 are needed that sum to 1 at most");
        insta::assert_snapshot!(told("[objects.cup]\npinch = 0.5\npower-sphere = 0.6"), @"the prior's object `cup`: its grasps sum to 1.1: probabilities of 0 to 1 are needed that sum to 1 at most");
        insta::assert_snapshot!(told("[objects.cup]\nlarge-diameter = 0.0\npinch = 0.0\npower-sphere = 0.0"), @"the prior's object `cup`: each of the index's grasps is 0, which leaves none: probabilities of 0 to 1 are needed that sum to 1 at most");
        // What is not named has the rest.
        assert!(priors("[objects.cup]\npinch = 0.0").probabilities("cup", &grasps()).is_ok());
        assert!(toml::from_str::<Priors>("[things.cup]\npinch = 1.0").is_err());
    }
}
