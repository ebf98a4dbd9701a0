//! How fast worlds are, and the path to their brains: the workloads of `baudbot-bench`.
//!
//! 1. [`plan`] reads the floor plans in `crates/bench/geometry`, [`scenario`] makes scenarios of them.
//! 2. [`driver`] steers robots by what they sense, [`rig`] is a world with its drivers in one thread.
//! 3. `in_process` measures those, `learner` many worlds at once; `gallery` runs of the program, `network` measures servers whose brains are in another process.
//! 4. [`catalogue`] has the workloads by name. [`worker`] runs each in a process of its own (`child`) and says what came of
//!    it, an [`outcome`].
//! 5. [`measure`] repeats and takes medians, [`calibration`] is what figures are compared with, [`process`] is what the
//!    operating system says. [`beside`] is another program by turns, [`instructions`] counts what does not depend on the clock.

pub mod beside;
pub mod calibration;
pub mod catalogue;
mod child;
pub mod driver;
mod gallery;
mod in_process;
pub mod instructions;
mod learner;
pub mod measure;
mod network;
pub mod outcome;
pub mod plan;
pub mod process;
pub mod rig;
mod scale;
pub mod scenario;
pub mod worker;

pub use child::{ChildError, Means};
pub use gallery::GalleryError;
pub use in_process::Unfit;
pub use network::NetworkError;
