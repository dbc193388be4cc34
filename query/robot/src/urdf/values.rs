//! Numbers as TOML.

use toml::Value;

pub(super) fn numbers<const N: usize>(values: [f64; N]) -> Value {
    Value::Array(values.into_iter().map(Value::Float).collect())
}

pub(super) fn way(distance: f64, least: f64) -> Value {
    let keys = [("distance".to_owned(), distance.into()), ("least".to_owned(), least.into())];
    Value::Table(keys.into_iter().collect())
}
