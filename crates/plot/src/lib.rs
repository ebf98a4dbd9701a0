//! Pictures as SVG and traces, without files, network or terminal: the caller gets a `String`, or says where packets go.
//!
//! 1. [`arena`] draws a scenario from above: its start, the trails of a run, a planned path, a pose search.
//! 2. [`timing`] draws timing diagrams: lanes of bars over one axis of time.
//! 3. [`trace`] writes the same events for Perfetto.
//! 4. [`chart`] draws lines, heat maps, the progress of a tuning, values over time, and places.
//!
//! All of them share the rest: [`palette`] is the one table of colours, which Foxglove's scenes and the viewer follow,
//! [`svg`] writes elements, [`scale`] has axes and ticks, [`text`] fits text into the room that there is,
//! [`quantity`] words numbers, and [`caption`] says what ran.

pub mod arena;
pub mod caption;
pub mod chart;
pub mod palette;
pub mod quantity;
pub mod scale;
pub mod svg;
pub mod text;
pub mod timing;
pub mod trace;
