//! Brains for baudbot's robots. A brain knows its robot's data sheet and what came over the cable, and no
//! path leads from this crate to the simulator: what works here could work on a real robot.
//!
//! From what a brain is to what it is made of:
//!
//! 1. [`catalogue`] has all brains by name, and makes one from a text such as `wander:turn=0.6`. With the feature `program`
//!    the module `program` is the rest of a program that runs one.
//! 2. Brains that are written out: [`Avoid`], [`Constant`], [`Explore`], [`Navigate`], [`Wander`], and the [`animals`].
//! 3. Brains of many processes: [`process`] says what motor behaviours and cognitive processes are, [`description`] reads
//!    such a brain from TOML with the kinds of a [`registry`], [`composed`] is one at work. By [`senses`] and
//!    [`decision`] it chooses.
//! 4. [`policy`] is a network that has been learnt, from readings to signals.
//! 5. Pieces: [`behavior`] and [`cognition`] have processes; [`odometry`], [`scanner`], [`localization`],
//!    [`mapping`], [`slam`], [`exploration`], [`planning`], [`navigation`], [`coverage`], [`vfh`] and [`potential`] are
//!    what these think with.
//!
//! A brain is a model of parameters, which never change, and a state; [`Brain::step`](baudbot_brain::Brain)
//! has no clock and no input or output, and chance comes from a [`Chance`] named after robot and brain, so
//! that the same turns give the same actions.
//!
//! ```
//! use baudbot_brains::catalogue;
//! # fn check(body: &baudbot_brain::Body) -> Result<(), catalogue::CatalogueError> {
//! let mut brain = catalogue::brain("avoid:forward=0.4", 7, body)?;
//! # Ok(())
//! # }
//! ```

pub mod animals;
pub mod avoid;
pub mod behavior;
pub mod catalogue;
pub mod cognition;
pub mod composed;
pub mod constant;
pub mod coverage;
pub mod decision;
pub mod description;
pub mod estimate;
pub mod exploration;
#[cfg(feature = "program")]
mod given;
pub mod internal;
pub mod localization;
pub mod mapping;
pub mod navigate;
pub mod navigation;
pub mod network;
pub mod odometry;
pub mod parameter;
pub mod planning;
pub mod policy;
pub mod potential;
pub mod process;
#[cfg(feature = "program")]
pub mod program;
pub mod registry;
pub mod scan;
pub mod scanner;
pub mod senses;
pub mod slam;
pub mod vfh;
pub mod wander;

mod awaited;
mod beat;
mod chance;
mod kinds;
mod pace;
mod proximity_sensors;
mod questions;
mod standard;
#[cfg(test)]
mod starting_over;
mod steering;
#[cfg(test)]
mod test_body;
mod throttle;

pub use avoid::Avoid;
pub use chance::Chance;
pub use constant::Constant;
pub use exploration::Explore;
pub use navigate::Navigate;
pub use wander::Wander;
