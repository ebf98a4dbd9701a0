//! The use of the processors by this program while it did not come to its end: whether it waits, or has too much to do.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Since when that is measured.
#[derive(Clone, Copy)]
pub(crate) struct Load {
    since: Instant,
    processor: Duration,
}

impl Load {
    /// The load from now on.
    pub(crate) fn begin() -> Self {
        Self { since: Instant::now(), processor: processor() }
    }

    /// The reason for the delay, as a clause for the end of an error.
    pub(crate) fn cause(&self) -> String {
        cause(self.since.elapsed(), processor().saturating_sub(self.processor))
    }
}

/// Something that waits for a disk takes no processor.
fn cause(within: Duration, processor: Duration) -> String {
    if processor < within / 2 {
        return "is a disk slow or full?".to_owned();
    }
    format!(
        "the server was overloaded: {:.1} s of processor time in {:.1} s; the log and the metrics of limits show which clients caused it",
        processor.as_secs_f64(),
        within.as_secs_f64()
    )
}

/// The processor time of all threads so far.
fn processor() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(
        u64::try_from(time.tv_sec).unwrap_or_default(),
        u32::try_from(time.tv_nsec).unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_a_processor_does_not_wait_for_a_disk() {
        let seconds = Duration::from_secs;
        assert_eq!(cause(seconds(10), seconds(1)), "is a disk slow or full?");
        let busy = cause(seconds(10), seconds(12));
        assert!(
            busy.starts_with("the server was overloaded: 12.0 s of processor time in 10.0 s; "),
            "{busy}"
        );
        let load = Load::begin();
        while processor() - load.processor < Duration::from_millis(20) {}
        assert!(load.since.elapsed() >= Duration::from_millis(5));
    }
}
