//! State that outlives the server: worlds, their snapshots and recordings are there again after it was killed.
//!
//! A [`StateFolder`] has a folder for each world, with a [journal](baudbot_recording::journal) and the snapshots. The
//! world's side is the [`Keeper`]: it collects what enters the world, and decides when that has to be in the file.
//! Where a world waits for its brains, that is before any message about the tick, and the world's own thread writes.
//! Elsewhere it is twice a second, and the folder's thread writes ([`threads`]), so that no clock waits for a disk.
//!
//! All goes through a trait, [`Storage`]: the system's disk and clock, or simulated ones, which fail as a seed wants it. A journal is
//! open only as long as it is written to, so that worlds leave files for connections ([`shared`]).
//!
//! If a file cannot be written, the world goes on. Its state is then not kept ([`files`]), which the log and the metrics say,
//! until a new journal can be begun, which is attempted again and again.

mod check;
mod file_names;
mod files;
mod folder;
mod keeper;
mod kept;
mod private;
mod shared;
mod storage;
#[cfg(test)]
mod tests;
mod threads;
mod work;

pub use check::{Checked, RecoverError, Recovered, Soundness};
pub use folder::{StateError, StateFolder};
pub(crate) use keeper::{Keeper, Now};
pub(crate) use kept::Resumed;
pub use kept::{Found, KeptWorld};
pub use storage::{Kind, Listed, Storage, Stored};

/// Version of the layout of the folder. Files have versions of their own.
pub(crate) const LAYOUT: u32 = 1;
