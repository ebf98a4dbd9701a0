//! A thread that only sleeps: the lateness with which it wakes is the machine's, not the server's.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A thread that sleeps for a millisecond at a time.
pub(super) struct Heartbeat {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Duration>,
}

impl Heartbeat {
    pub(super) fn start() -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut latest = Duration::ZERO;
            while !stopped.load(Ordering::Relaxed) {
                let due = Instant::now() + BEAT;
                std::thread::sleep(BEAT);
                latest = latest.max(due.elapsed());
            }
            latest
        });
        Self { stop, thread }
    }

    /// Ends it, and returns the greatest lateness with which it woke. A machine that lets it sleep for longer than a
    /// step lets worlds sleep, too.
    pub(super) fn told(self) -> String {
        self.stop.store(true, Ordering::Relaxed);
        let latest = self.thread.join().expect("it only sleeps");
        format!("a thread that only sleeps woke {:.1} ms late at most meanwhile", latest.as_secs_f64() * 1e3)
    }
}

const BEAT: Duration = Duration::from_millis(1);
