//! The service: one mapped index, many askers, over HTTP.
//!
//! `guard` lets requests in (by [`origin`] and [`wire::Token`]), and `query` checks their
//! parameters; bodies arrive within a `budget` of memory (`arrival`), and only what is whole passes
//! the `gate`, which bounds the work. It is done on a thread that may block (`recognise`,
//! `search`), and `metrics` count it. `current` holds the index and replaces it when another file
//! lies at its path (`unusable` says why one cannot); `request_log` logs what was asked; `listen`
//! holds the connections, `connection` ends those that ask nothing where others wait or take no
//! answer, `page` is what a browser is given. `router` says which path leads where, `openapi` what
//! each takes and answers, and [`Service::run`] puts them together. [`client`] is the other end,
//! and [`wire`] what crosses the line between both.

mod about;
mod arrival;
mod body;
pub mod browser;
mod budget;
pub mod client;
mod connection;
mod current;
mod described_form;
mod descriptors;
mod docs;
mod explained;
pub mod form;
mod gate;
mod guard;
mod identity;
mod linger;
mod listen;
mod metrics;
mod openapi;
pub mod origin;
mod page;
mod problem;
mod query;
mod recognise;
mod refusals;
mod request_log;
mod router;
mod run;
mod search;
mod service;
mod shown;
pub mod small;
mod tags;
mod unusable;
pub mod wire;
mod work;

pub use listen::Listener;
pub use page::LOOK;
pub use problem::Problem;
pub use service::{Ended, Event, Service, Settings};
pub use unusable::{IndexFault, UnusableIndex};
