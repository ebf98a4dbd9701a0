//! Runs: a world, and the brain of each of its robots.
//!
//! 1. [`DrivenWorld`] is a world with its brains in one thread: the loop of all runs whose brains are in this process. Its world is a
//!    [`BareWorld`], or one that is recorded and watched (`DirectWorld` of `baudbot-server`).
//! 2. [`assignment`] says which brain drives which robot. [`in_process`] has brains of the catalogue in a driven world, and
//!    [`AttachedBrains`] as gRPC clients like any other.
//! 3. [`programs`] are brains that are programs of their own: started, watched, and ended with all their children.
//! 4. [`simulation`] has programs that know nothing of us: they open serial ports, and run in simulated time.
//! 5. [`learn`] has environments for programs that learn: worlds that are stepped a control cycle at a time.

#[cfg(feature = "brains")]
pub mod assignment;
#[cfg(feature = "brains")]
mod attached;
mod driven_world;
#[cfg(feature = "brains")]
pub mod in_process;
#[cfg(feature = "learn")]
pub mod learn;
mod port_world;
#[cfg(feature = "brains")]
pub mod programs;
#[cfg(feature = "programs")]
pub mod simulation;
#[cfg(feature = "brains")]
mod suggest;

#[cfg(feature = "brains")]
pub use attached::AttachedBrains;
pub use driven_world::{BareWorld, DrivenWorld, Driver, LockstepWorld, Refusal};
pub use port_world::PortWorld;
#[cfg(feature = "brains")]
pub use suggest::UnknownName;
