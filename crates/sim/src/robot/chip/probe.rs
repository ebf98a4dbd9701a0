//! The debugger at a chip, beside its state.

use alloc::sync::Arc;
use core::fmt;

use baudbot_board::{Board, Physics};

use crate::chip::Probe;

/// The socket for a debugger. A clone, or a loaded state, has none.
#[derive(Default)]
pub(super) struct Socket(Option<Arc<dyn Probe>>);

impl Socket {
    pub(super) fn put_on(&mut self, probe: Arc<dyn Probe>) {
        self.0 = Some(probe);
    }

    /// Runs the board until an instant of its own, under the debugger if there is one.
    pub(super) fn run(&self, board: &mut Board, until_ns: u64, physics: &mut impl Physics) {
        match &self.0 {
            Some(probe) => probe.run(board, until_ns, physics),
            None => board.run_until(until_ns, physics),
        }
    }
}

impl Clone for Socket {
    fn clone(&self) -> Self {
        Self(None)
    }
}

impl fmt::Debug for Socket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "a probe" } else { "no probe" })
    }
}
