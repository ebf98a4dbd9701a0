//! The native part of the Python package `baudbot`.
//!
//! It is glue: worlds are those of `baudbot_run::learn`, runs those of `baudbot_experiment`, and what is a decision is made there. The Python
//! modules in `python/package` are what users call; `_native.pyi` has the types of what is here. While a world is stepped the
//! interpreter is free for other threads.

mod arrow;
mod env;
mod errors;
mod fleet;
mod picture;
mod recording;
mod runs;
mod task;

use pyo3::prelude::*;

/// See `package/baudbot/_native.pyi`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::arrow::{stream_of_columns, stream_of_file};
    #[pymodule_export]
    use super::env::Env;
    #[pymodule_export]
    use super::fleet::Fleet;
    #[pymodule_export]
    use super::picture::pixels;
    #[pymodule_export]
    use super::recording::{compare, replay};
    #[pymodule_export]
    use super::runs::{cost, merge, merge_worst, pack, sweep, tune, worst};
    #[pymodule_export]
    use super::task::{Task, check_reward};
}
