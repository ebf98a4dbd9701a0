//! Exercises: a brain is run in a scenario with several seeds, and its run is compared with criteria that are worth
//! points.
//!
//! From the file inwards:
//!
//! 1. An [`Exercise`] is what an exercise file says, checked; `raw` is what may stand in such a file, `read` finds it, `advice` are
//!    words that the file has for typical mistakes.
//! 2. [`Measure`] are the numbers that criteria and advice are about: the figures of merit of an experiment, and those that `watch` takes
//!    from the world at each tick. A brain learns none of them.
//! 3. `run` is one run, in a world of its own on a server on which a program may only drive. A brain that hangs, or fails, ends only
//!    its run. [`grade()`] does all runs of an exercise on threads.
//! 4. A [`Grading`] is what came of it: points, and `findings`, which say in words what went wrong. `text`, `json` and [`junit`]
//!    write it down.

mod advice;
mod deficits;
mod exercise;
mod findings;
mod grading;
mod json;
pub mod junit;
mod measure;
mod points;
mod raw;
mod read;
mod run;
mod runs;
mod text;
mod watch;

pub use advice::Advice;
pub use exercise::{Criterion, Exercise, Limits};
pub use grading::{Grading, Verdict};
pub use json::JSON_FIELDS;
pub use measure::{MEASURES, Measure, MeasureInfo};
pub use points::Awarded;
pub use read::all;
pub use run::{Problem, Run};
pub use runs::{Options, grade};
pub use watch::{Hit, Measures};
