//! The claim on a cable: one program at a time holds it, on any of the cable's ports.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A port's view of the cable that it may share with other ports.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    /// The number of the port whose program has the cable, or [`NOBODY`].
    holder: Arc<AtomicUsize>,
    port: usize,
}

const NOBODY: usize = usize::MAX;

impl Hold {
    /// A `Hold` of the first port at a cable; `port` is a number that no other port at it has.
    pub(crate) fn new(port: usize) -> Self {
        Self { holder: Arc::new(AtomicUsize::new(NOBODY)), port }
    }

    /// The hold of another port at the same cable.
    pub(crate) fn beside(&self, port: usize) -> Self {
        Self { holder: Arc::clone(&self.holder), port }
    }

    /// A program wants the cable. `false` if that of another port holds it.
    pub(crate) fn take(&self) -> bool {
        let taken = self.holder.compare_exchange(NOBODY, self.port, Ordering::AcqRel, Ordering::Acquire);
        taken.is_ok() || taken == Err(self.port)
    }

    /// Whether the program of another port holds the cable.
    pub(crate) fn is_elsewhere(&self) -> bool {
        ![NOBODY, self.port].contains(&self.holder.load(Ordering::Acquire))
    }

    /// The program of this port is gone, and nothing is left of what it has written.
    pub(crate) fn let_go(&self) {
        let _ = self.holder.compare_exchange(self.port, NOBODY, Ordering::AcqRel, Ordering::Acquire);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_port_at_a_time_has_the_cable() {
        let one = Hold::new(0);
        let other = one.beside(1);
        assert!(one.take() && one.take() && !other.take() && other.is_elsewhere());
        other.let_go();
        assert!(!other.take(), "only who has it lets it go");
        one.let_go();
        assert!(other.take() && one.is_elsewhere() && !other.is_elsewhere());
    }
}
