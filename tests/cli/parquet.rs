//! `export --parquet`: a part, or an index, as a table that other programs read.

use std::collections::HashMap;
use std::fs::{self, File};
use std::path::Path;

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_tests::{Outcome, program, run};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;

const DIM: usize = 340;

fn builder(folder: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-builder").args(arguments).current_dir(folder))
}

fn done(folder: &Path, arguments: &[&str]) -> Outcome {
    let outcome = builder(folder, arguments);
    assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
    outcome
}

/// All rows of a Parquet file: the columns' names and their values, and how many groups of rows
/// there are.
fn rows(path: &Path) -> (Vec<HashMap<String, Field>>, usize) {
    let file = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let rows = file.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns().into_iter().collect());
    (rows.collect(), file.num_row_groups())
}

fn text(field: &Field) -> String {
    match field {
        Field::Str(text) => text.clone(),
        Field::Int(number) => number.to_string(),
        Field::Float(number) => number.to_string(),
        Field::Double(number) => format!("{number:.7}"),
        other => panic!("{other:?}"),
    }
}

fn descriptor(row: &HashMap<String, Field>) -> Vec<f32> {
    let Field::ListInternal(list) = &row["descriptor"] else { panic!("{:?}", row["descriptor"]) };
    let value = |field: &Field| match field {
        Field::Float(value) => *value,
        other => panic!("{other:?}"),
    };
    list.elements().iter().map(value).collect()
}

fn array(path: &Path) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let mut rest = &bytes[..];
    NpyHeader::read(&mut rest, NpyType::F32).unwrap().read_values(&mut rest).unwrap()
}

#[test]
fn a_part_and_an_index_are_tables_of_their_entries() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, &["shard", "--shard", "1/1", "--step", "60", "--hands", "2", "--out", "parts"]);
    done(folder, &["merge", "parts", "--out", "a.idx"]);
    let said = done(folder, &["export", "parts/1-of-1.shard", "--parquet", "part.parquet"]).stdout;
    done(
        folder,
        &["export", "a.idx", "--descriptors", "x.npy", "--labels", "y.csv", "--parquet", "index.parquet"],
    );
    let (part, _) = rows(&folder.join("part.parquet"));
    let (index, _) = rows(&folder.join("index.parquet"));
    assert_eq!(said, format!("part.parquet: {} entries\n", part.len()));
    let descriptors = array(&folder.join("x.npy"));
    let mut labels = csv::Reader::from_path(folder.join("y.csv")).unwrap();
    let names = labels.headers().unwrap().clone();
    let labels: Vec<csv::StringRecord> = labels.records().map(Result::unwrap).collect();
    assert!(labels.len() > 50 && part.len() == labels.len() && index.len() == labels.len());
    for (at, label) in labels.iter().enumerate() {
        let (part, index) = (&part[at], &index[at]);
        assert_eq!(index.len(), names.len() + 1);
        for (name, label) in names.iter().zip(label) {
            assert_eq!(text(&index[name]), label, "{name} of entry {at}");
            // An index rounds what a part holds as it was made.
            match (&part[name], label.parse::<f64>()) {
                (Field::Double(value), Ok(label)) => assert!((value - label).abs() < 1e-4, "{name}"),
                (Field::Float(value), Ok(label)) => {
                    let turn = (f64::from(*value) - label).rem_euclid(360.0);
                    assert!(turn.min(360.0 - turn) < 0.01, "{name}");
                }
                (value, _) => assert_eq!(text(value), label, "{name} of entry {at}"),
            }
        }
        for row in [part, index] {
            assert!(descriptor(row) == descriptors[at * DIM..][..DIM]);
        }
    }
}

#[test]
fn rows_come_in_groups_and_vectors_alone_are_one_column() {
    const ROWS: usize = 70_000;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let values: Vec<f32> = (0..ROWS * 3).map(|at| (at as f32).sin()).collect();
    let mut bytes = NpyHeader { element: NpyType::F32, rows: ROWS as u64, columns: 3, offset: 0 }.to_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    fs::write(folder.join("x.npy"), bytes).unwrap();
    done(folder, &["shard", "--shard", "1/1", "--descriptors", "x.npy", "--out", "parts"]);
    let export = ["export", "parts/1-of-1.shard", "--parquet", "x.parquet"];
    done(folder, &export);
    let (rows, groups) = rows(&folder.join("x.parquet"));
    assert_eq!((rows.len(), groups), (ROWS, 2));
    assert!(rows.iter().all(|row| row.len() == 1));
    assert!(rows.iter().flat_map(descriptor).eq(values));

    // What is damaged is found out before the table is in its place.
    let before = fs::read(folder.join("x.parquet")).unwrap();
    let part = folder.join("parts/1-of-1.shard");
    let mut spoiled = fs::read(&part).unwrap();
    let middle = spoiled.len() / 2;
    spoiled[middle] ^= 1;
    fs::write(&part, &spoiled).unwrap();
    let outcome = builder(folder, &export);
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("1-of-1.shard were not written"), "{}", outcome.stderr);
    assert!(fs::read(folder.join("x.parquet")).unwrap() == before);
    assert_eq!(fs::read_dir(folder).unwrap().count(), 3, "x.npy, parts and x.parquet");

    let outcome = builder(folder, &["export", "parts/1-of-1.shard", "--descriptors", "y.npy"]);
    assert!(outcome.stderr.contains("is a part of an index: --parquet alone"), "{}", outcome.stderr);
    let outcome = builder(folder, &[&export[..3], &["parts/../parts/1-of-1.shard"]].concat());
    assert!(outcome.stderr.contains("is the index itself"), "{}", outcome.stderr);
    assert!(fs::read(&part).unwrap() == spoiled);
}
