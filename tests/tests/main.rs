//! The whole system: servers, brains and links together. One program, since each has most of the others' code in it.

mod animals;
mod avoid;
mod bad_input;
mod budget;
mod by_hand;
mod coverage;
mod determinism;
mod devices;
mod exploration;
mod figures;
mod goldens;
mod localization;
mod lookahead;
mod metrics;
mod navigation;
mod pace;
mod page;
mod recording;
mod room;
mod services;
mod sweeper;
mod wayfinding;
