//! End-to-end tests over the real programs: a module a subject, and one program that holds them
//! all.
//!
//! One program is linked once, and what tests share ([`grasp_tests::small_index`]) is built once.
//! `cargo test -p grasp-tests --test cli serve::` runs one module.
//!
//! All modules run in one process, in several threads: a test changes nothing that belongs to the
//! process (environment, working directory, limits, signals), but starts a program with its own.

mod bad_input;
mod chain;
mod completions;
mod context;
mod default_index;
mod determinism;
mod experiment;
mod explain;
mod grow;
mod hand_model;
mod hostile_pictures;
mod labelled;
mod landmarks;
mod limits;
mod logs;
mod messages;
mod overwrite;
mod page;
mod parquet;
mod progress;
mod quiz;
mod reload;
mod remote;
mod report;
mod robot;
mod search;
mod segments;
mod serve;
mod serve_fuzz;
mod serve_load;
mod serve_refusals;
mod shards;
mod simulate;
mod streams;
mod texts;
mod train;
mod vectors;
mod vote;
mod watch;
