//! Descriptors as JSON, `{"descriptors": [[...], ...]}`. They are read straight into one array: a
//! tree of values would take sixteen times the memory of the text.

use std::cell::Cell;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use utoipa::ToSchema;

/// What the body of a search looks like.
#[derive(Debug, ToSchema)]
#[schema(as = Queries)]
#[expect(dead_code, reason = "it is the description of what is read value by value")]
pub(super) struct Described {
    /// Rows of as many numbers as the index's dimension, `dim` of `/v1/index`.
    #[schema(example = json!([[0.0, 0.1, 0.2]]))]
    descriptors: Vec<Vec<f32>>,
}

/// Why a body holds no descriptors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum DescriptorError {
    /// It is no JSON.
    #[error(
        "the body is neither an array in NumPy's format nor JSON: it breaks off or is malformed at line {line}, column {column}"
    )]
    Json { line: usize, column: usize },
    /// It is another object.
    #[error("JSON of the form {{\"descriptors\": [[...], ...]}} is needed, and nothing else in it")]
    Form,
    /// A row is no array.
    #[error("descriptors[{0}] is no array of numbers")]
    Row(usize),
    /// A value is no number.
    #[error("descriptors[{0}][{1}] is no number")]
    Value(usize, usize),
    /// A value is beyond what a float of 32 bits holds.
    #[error("descriptors[{0}][{1}] is too large: numbers of at most {max:e} are read", max = f32::MAX)]
    TooLarge(usize, usize),
    /// A row does not fit the index.
    #[error("descriptors[{row}] has {found} values: the index holds descriptors of {dim}")]
    Length { row: usize, found: usize, dim: usize },
}

/// How serde_json says that a number is too large; it has no other sign of that.
const OUT_OF_RANGE: &str = "number out of range";

/// The values of all rows, one after another, each of `dim` values.
pub(super) fn read(body: &[u8], dim: usize) -> Result<Vec<f32>, DescriptorError> {
    let reader = Reader { dim, at: Cell::new(DescriptorError::Form) };
    let mut json = serde_json::Deserializer::from_slice(body);
    let outcome = Object(&reader).deserialize(&mut json);
    match outcome.and_then(|values| json.end().map(|()| values)) {
        Ok(values) => Ok(values),
        Err(error) if error.is_data() => Err(reader.at.get()),
        // serde_json counts it among what is malformed.
        Err(error) if error.to_string().starts_with(OUT_OF_RANGE) => Err(match reader.at.get() {
            DescriptorError::Value(row, column) => DescriptorError::TooLarge(row, column),
            other => other,
        }),
        Err(error) => Err(DescriptorError::Json { line: error.line(), column: error.column() }),
    }
}

/// What is to be read, and what is wrong where it is not there.
struct Reader {
    dim: usize,
    at: Cell<DescriptorError>,
}

impl Reader {
    fn wrong<E: serde::de::Error>(&self, error: DescriptorError) -> E {
        self.at.set(error);
        E::custom("")
    }
}

/// The object.
struct Object<'a>(&'a Reader);
/// Its rows.
struct Rows<'a>(&'a Reader);
/// A row of this number, whose values are added.
struct Row<'a>(&'a Reader, usize, &'a mut Vec<f32>);

impl<'de> DeserializeSeed<'de> for Object<'_> {
    type Value = Vec<f32>;
    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<Vec<f32>, D::Error> {
        json.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Object<'_> {
    type Value = Vec<f32>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<f32>, A::Error> {
        let mut values = None;
        while let Some(key) = map.next_key::<String>()? {
            if key != "descriptors" || values.is_some() {
                return Err(self.0.wrong(DescriptorError::Form));
            }
            values = Some(map.next_value_seed(Rows(self.0))?);
        }
        values.ok_or_else(|| self.0.wrong(DescriptorError::Form))
    }
}

impl<'de> DeserializeSeed<'de> for Rows<'_> {
    type Value = Vec<f32>;
    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<Vec<f32>, D::Error> {
        json.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Rows<'_> {
    type Value = Vec<f32>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Vec<f32>, A::Error> {
        let mut values = Vec::new();
        let mut row = 0;
        loop {
            self.0.at.set(DescriptorError::Row(row));
            if rows.next_element_seed(Row(self.0, row, &mut values))?.is_none() {
                break;
            }
            row += 1;
        }
        self.0.at.set(DescriptorError::Form);
        Ok(values)
    }
}

impl<'de> DeserializeSeed<'de> for Row<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<(), D::Error> {
        json.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Row<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<(), A::Error> {
        let Self(reader, row, values) = self;
        let mut found = 0;
        while found < reader.dim {
            reader.at.set(DescriptorError::Value(row, found));
            let Some(value) = numbers.next_element()? else { break };
            values.push(value);
            found += 1;
        }
        while numbers.next_element::<IgnoredAny>()?.is_some() {
            found += 1;
        }
        match found == reader.dim {
            true => Ok(()),
            false => Err(reader.wrong(DescriptorError::Length { row, found, dim: reader.dim })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_one_array() {
        assert_eq!(read(b" {\"descriptors\": [[1, 2.5], [-1e3, 0]]} ", 2), Ok(vec![1.0, 2.5, -1000.0, 0.0]));
        assert_eq!(read(b"{\"descriptors\": []}", 2), Ok(Vec::new()));
    }

    #[test]
    fn what_is_wrong_is_said_by_place() {
        let length = |row, found| DescriptorError::Length { row, found, dim: 2 };
        for (body, error) in [
            ("", DescriptorError::Json { line: 1, column: 0 }),
            ("{\"descriptors\": [[1, 2]", DescriptorError::Json { line: 1, column: 23 }),
            ("{\"descriptors\": []} x", DescriptorError::Json { line: 1, column: 21 }),
            ("[]", DescriptorError::Form),
            ("7", DescriptorError::Form),
            ("{}", DescriptorError::Form),
            ("{\"descriptor\": []}", DescriptorError::Form),
            ("{\"descriptors\": [], \"k\": 1}", DescriptorError::Form),
            ("{\"descriptors\": [], \"descriptors\": []}", DescriptorError::Form),
            ("{\"descriptors\": 1}", DescriptorError::Form),
            ("{\"descriptors\": [[1, 2], 3]}", DescriptorError::Row(1)),
            ("{\"descriptors\": [[1, 2], [1, \"2\"]]}", DescriptorError::Value(1, 1)),
            ("{\"descriptors\": [[null, 2]]}", DescriptorError::Value(0, 0)),
            ("{\"descriptors\": [[1e39, 2]]}", DescriptorError::TooLarge(0, 0)),
            ("{\"descriptors\": [[1, 2], [1, -1e999]]}", DescriptorError::TooLarge(1, 1)),
            ("{\"descriptors\": [[1, 2], 1e999]}", DescriptorError::Row(1)),
            ("{\"descriptors\": 1e999}", DescriptorError::Form),
            ("{\"descriptors\": [[1]]}", length(0, 1)),
            ("{\"descriptors\": [[1, 2], [1, 2, 3, 4]]}", length(1, 4)),
        ] {
            assert_eq!(read(body.as_bytes(), 2), Err(error), "{body}");
        }
    }
}
