//! The clock that a server goes by.
//!
//! It is that of the tokio runtime which asks: the system's, or in a test one that is paused. Threads outside of a runtime have
//! the system's, so with a paused clock a server has to be [without threads](crate::Builder::without_threads).
//!
//! Not simulated are the times of day: the end of a token, and the stamps of Turns, which nothing in a world depends on.

use std::time::{Duration, Instant};

/// The present instant.
pub(crate) fn now() -> Instant {
    tokio::time::Instant::now().into_std()
}

/// The time since an instant.
pub(crate) fn since(instant: Instant) -> Duration {
    now().saturating_duration_since(instant)
}
