//! The work of writing a world.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// A piece of work.
#[derive(Debug)]
pub(super) enum Work {
    /// More of the journal, up to this tick.
    Append(Vec<u8>, u64),
    /// Another journal, up to this tick, and snapshots that may not have been written yet.
    Begin {
        journal: Vec<u8>,
        tick: u64,
        snapshots: Vec<(u64, Vec<u8>)>,
        /// The number of bytes of this journal that are on the disk for good, which is set here.
        on_disk: Arc<AtomicU64>,
    },
    Snapshot(u64, Vec<u8>),
    /// A snapshot is not kept any more.
    Forget(u64),
}

impl Work {
    /// The number of bytes of the work.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Append(bytes, _) | Self::Snapshot(_, bytes) => bytes.len(),
            Self::Begin { journal, snapshots, .. } => {
                journal.len() + snapshots.iter().map(|(_, bytes)| bytes.len()).sum::<usize>()
            }
            Self::Forget(_) => 0,
        }
    }

    /// The number of bytes if they are a whole state, which may be large.
    pub(super) fn whole(&self) -> usize {
        match self {
            Self::Begin { .. } | Self::Snapshot(..) => self.bytes(),
            Self::Append(..) | Self::Forget(_) => 0,
        }
    }
}
