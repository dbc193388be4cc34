//! The JSON line of one query for raw neighbours. Its keys are an interface: they may be added to,
//! never renamed.

use grasp_index::{Index, Neighbour, SearchError, Segments, Shortlist};
use serde::Serialize;

/// A query and its neighbours, nearest first.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct QueryRecord<'a> {
    /// The query's place, from 0.
    pub query: usize,
    /// The nearest entries; fewer than were asked for where the index has fewer.
    pub neighbours: Vec<FoundRecord<'a>>,
}

/// A query and the candidates of its search of one segment of an index, nearest first.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ShortlistRecord<'a> {
    /// The query's place, from 0.
    pub query: usize,
    /// Buckets of each table that were looked into; absent, with all that follows but the
    /// neighbours, where every entry was compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probes: Option<u32>,
    /// More probes than that find no more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most_probes: Option<u32>,
    /// How many candidates, those of the least key and number, a search of the whole index
    /// measures; absent where all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep: Option<usize>,
    /// The candidates.
    pub neighbours: Vec<Candidate<'a>>,
}

/// A candidate of a search.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Candidate<'a> {
    /// What it was kept by, the least first.
    pub key: u32,
    /// The entry.
    #[serde(flatten)]
    pub found: FoundRecord<'a>,
}

impl<'a> ShortlistRecord<'a> {
    /// Of the query at place `query`.
    pub fn new(index: &'a Index, query: usize, shortlist: &Shortlist) -> Self {
        let candidate =
            |&(key, near): &(u32, Neighbour)| Candidate { key, found: FoundRecord::new(index, near) };
        Self {
            query,
            probes: Some(shortlist.probes),
            most_probes: Some(shortlist.most_probes),
            keep: shortlist.keep,
            neighbours: shortlist.candidates.iter().map(candidate).collect(),
        }
    }

    /// Of a search that has compared every entry.
    pub fn exact(index: &'a Index, query: usize, neighbours: &[Neighbour]) -> Self {
        let candidate = |&near| Candidate { key: 0, found: FoundRecord::new(index, near) };
        let neighbours = present(neighbours).map(candidate).collect();
        Self { query, probes: None, most_probes: None, keep: None, neighbours }
    }
}

impl<'a> FoundRecord<'a> {
    fn new(index: &'a Index, Neighbour { id, distance }: Neighbour) -> Self {
        let (grasp, file) = names(index, id);
        Self { id, distance, grasp, file }
    }
}

/// An entry that was found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct FoundRecord<'a> {
    /// The entry's number in the index.
    pub id: u32,
    /// The distance between the descriptors.
    pub distance: f32,
    /// Its class, where the index knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<&'a str>,
    /// The file that it was made from, where the index knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

impl<'a> QueryRecord<'a> {
    /// The record of the query at place `query`.
    pub fn new(index: &'a Index, query: usize, neighbours: &[Neighbour]) -> Self {
        Self::named(|id| names(index, id), query, neighbours)
    }

    /// The record of a query whose entries `names` knows the class and the file of.
    pub fn named(
        names: impl Fn(u32) -> (Option<&'a str>, Option<String>),
        query: usize,
        neighbours: &[Neighbour],
    ) -> Self {
        let neighbours = present(neighbours).map(|neighbour| {
            let (grasp, file) = names(neighbour.id);
            FoundRecord { id: neighbour.id, distance: neighbour.distance, grasp, file }
        });
        Self { query, neighbours: neighbours.collect() }
    }
}

/// What is wrong with queries; where it is a value, `place` says which, as the asker counts them.
pub fn with_place(error: &SearchError, place: impl FnOnce(usize) -> String) -> String {
    let message = error.to_string();
    match error {
        &(SearchError::NotFinite { at } | SearchError::Huge { at }) => {
            message.replacen(&format!("value {at} of the query"), &place(at), 1)
        }
        _ => message,
    }
}

/// Without the places that the index had no entry for.
pub fn present(neighbours: &[Neighbour]) -> impl Iterator<Item = &Neighbour> {
    neighbours.iter().filter(|neighbour| neighbour.id != u32::MAX)
}

/// The same of an entry of one of several indexes.
pub fn names_in(segments: &Segments, id: u32) -> (Option<&str>, Option<String>) {
    segments.locate(id).map_or((None, None), |(index, id)| names(index, id))
}

/// An entry's class and file, where the index knows them.
pub fn names(index: &Index, id: u32) -> (Option<&str>, Option<String>) {
    let Ok(entry) = index.entry(id) else {
        return (None, None);
    };
    let class = entry.class.and_then(|class| index.catalogue().classes.get(usize::from(class)));
    (class.map(|class| class.name.as_str()), Some(entry.file).filter(|file| !file.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_cannot_be_searched_for_is_told_by_row_and_column() {
        let told = |error| with_place(&error, |at| format!("descriptors[{}][{}]", at / 10, at % 10));
        let (wrong, huge) = (told(SearchError::NotFinite { at: 123 }), told(SearchError::Huge { at: 7 }));
        assert_eq!(wrong, "descriptors[12][3] is not a finite number");
        assert!(huge.starts_with("descriptors[0][7] is larger than 1e15: "), "{huge}");
        assert_eq!(told(SearchError::NoNeighbours), SearchError::NoNeighbours.to_string());
    }
}
