//! The completion of a scenario's text: the maps, plans and measurements that it refers to.

mod common;
mod lookups;
mod notes;
mod plans;
mod rectangles;
mod refused_maps;
mod room;
mod text;
