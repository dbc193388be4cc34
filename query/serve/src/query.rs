//! The options in a request's query, read so that who gets one wrong is told which, and what it may
//! be. What that is stands in the description of the interface, from which the messages are made.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use serde_json::Value;
use utoipa::IntoParams;

use super::problem::Problem;
use super::shown::shown;

/// What is wrong with a query that cannot be read.
#[derive(Debug, thiserror::Error)]
enum QueryError {
    #[error("there is no parameter {}: there are {known}", shown(name))]
    Unknown { name: String, known: String },
    #[error("{0} is given more than once")]
    Repeated(String),
    #[error("{name} is {}: {needed} is needed", shown(value))]
    Value { name: String, value: String, needed: String },
    #[error("the query cannot be read: it is NAME=VALUE&NAME=VALUE")]
    Form,
}

/// The options of a request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Options<T>(pub(super) T);

impl<T: DeserializeOwned + IntoParams, S: Sync> FromRequestParts<S> for Options<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        let read = read(parts.uri.query().unwrap_or_default());
        read.map(Self).map_err(|error| Problem::bad_request(error.to_string()))
    }
}

fn read<T: DeserializeOwned + IntoParams>(query: &str) -> Result<T, QueryError> {
    serde_urlencoded::from_str(query).map_err(|_| reason::<T>(query))
}

fn reason<T: DeserializeOwned + IntoParams>(query: &str) -> QueryError {
    let described: Vec<(String, Value)> = T::into_params(|| None)
        .into_iter()
        .map(|parameter| {
            let schema = serde_json::to_value(&parameter.schema).unwrap_or_default();
            (parameter.name, schema)
        })
        .collect();
    let given: Vec<(String, String)> = serde_urlencoded::from_str(query).unwrap_or_default();
    for (at, (name, value)) in given.iter().enumerate() {
        let Some((_, schema)) = described.iter().find(|(known, _)| known == name) else {
            let known: Vec<&str> = described.iter().map(|(name, _)| name.as_str()).collect();
            return QueryError::Unknown { name: name.clone(), known: known.join(", ") };
        };
        if given.iter().take(at).any(|(earlier, _)| earlier == name) {
            return QueryError::Repeated(name.clone());
        }
        let alone = serde_urlencoded::to_string([(name, value)]).unwrap_or_default();
        if serde_urlencoded::from_str::<T>(&alone).is_err() {
            return QueryError::Value { name: name.clone(), value: value.clone(), needed: values(schema) };
        }
    }
    QueryError::Form
}

/// Which values a schema allows, in words.
pub(super) fn values(schema: &Value) -> String {
    if let Some(named) = enumerated(schema) {
        let named: Vec<String> =
            named.iter().filter_map(Value::as_str).map(|name| format!("`{name}`")).collect();
        return named.join(" or ");
    }
    let is = |name: &str| match &schema["type"] {
        Value::Array(types) => types.iter().any(|of| of == name),
        of => of == name,
    };
    let bound = |name: &str| match &schema[name] {
        // Not as a float: those hold the bounds of 64 bits only about.
        Value::Number(bound) => Some(
            bound
                .as_u64()
                .map_or_else(|| bound.as_f64().unwrap_or_default().to_string(), |bound| bound.to_string()),
        ),
        _ => None,
    };
    let lower = bound("minimum").map(|least| format!("of at least {least}"));
    let lower = bound("exclusiveMinimum").map(|above| format!("above {above}")).or(lower);
    let noun = match () {
        () if is("integer") => "an integer",
        () if is("number") => "a number",
        () if is("boolean") => return "`true` or `false`".into(),
        () => return "a text".into(),
    };
    match (bound("minimum"), lower, bound("maximum")) {
        (Some(least), _, Some(most)) if is("integer") => format!("{noun} from {least} to {most}"),
        (_, Some(lower), Some(most)) => format!("{noun} {lower} and at most {most}"),
        (_, Some(lower), None) => format!("{noun} {lower}"),
        (_, None, Some(most)) => format!("{noun} of at most {most}"),
        (_, None, None) => noun.into(),
    }
}

/// The values of an enumeration, also of one that may be absent.
fn enumerated(schema: &Value) -> Option<&Vec<Value>> {
    let alternatives =
        ["oneOf", "anyOf", "allOf"].into_iter().filter_map(|of| schema[of].as_array()).flatten();
    schema["enum"].as_array().or_else(|| alternatives.into_iter().find_map(enumerated))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::parameters::{PictureParameters, SearchParameters};

    /// [`values`] follows no reference: what it says of one would be wrong.
    #[test]
    fn what_parameters_may_be_stands_where_they_are_described() {
        for described in [PictureParameters::into_params(|| None), SearchParameters::into_params(|| None)] {
            for parameter in described {
                let schema = serde_json::to_string(&parameter.schema).unwrap();
                assert!(!schema.contains("$ref"), "{}: {schema}", parameter.name);
            }
        }
    }

    #[test]
    fn what_is_wrong_is_said_by_name_and_with_what_would_be_right() {
        for (query, says) in [
            ("k=-1", "k is `-1`: an integer from 1 to 1000 is needed"),
            ("rolls=x", "rolls is `x`: an integer from 1 to 360 is needed"),
            ("hand=both", "hand is `both`: `auto` or `left` or `right` is needed"),
            ("accept=no", "accept is `no`: `always` or `calibrated` is needed"),
            ("exact=yes", "exact is `yes`: `true` or `false` is needed"),
            ("sigma=wide", "sigma is `wide`: a number above 0 is needed"),
            ("recall=most", "recall is `most`: a number above 0 and at most 1 is needed"),
            ("segment=landmarks", "segment is `landmarks`: `scene` or `skin` is needed"),
            ("probes=1.5", "probes is `1.5`: an integer from 1 to 4294967295 is needed"),
            ("probes=4294967296", "probes is `4294967296`: an integer from 1 to 4294967295 is needed"),
            ("frame=first", "frame is `first`: an integer from 0 to 18446744073709551615 is needed"),
            ("recall=0.9&hand=left&hand=left", "hand is given more than once"),
        ] {
            assert_eq!(read::<PictureParameters>(query).unwrap_err().to_string(), says);
        }
        let unknown = read::<SearchParameters>("kk=1").unwrap_err().to_string();
        assert!(unknown.starts_with("there is no parameter `kk`: there are k, recall, eps, "), "{unknown}");
        let long = read::<SearchParameters>(&format!("k={}%0a", "7".repeat(500))).unwrap_err().to_string();
        assert!(long.len() < 100, "{long}");
        assert!(
            read::<SearchParameters>("k=%0a%1b").unwrap_err().to_string().starts_with("k is `\\n\\u{1b}`: ")
        );
    }
}
