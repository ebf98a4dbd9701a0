//! The events of a run, line by line: printed if it fails, and the same each time.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

/// The events. Clones are the same.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace(Arc<Mutex<Lines>>);

#[derive(Debug, Default)]
struct Lines {
    /// The time of all servers before the present one, and when that has begun.
    before: Duration,
    began: Option<Instant>,
    /// Time that the present one has not had, as the clock has jumped.
    jumped: Duration,
    last: VecDeque<String>,
    count: u64,
    fingerprint: u64,
}

/// The most lines that are kept: a server's life has fewer.
const MOST: usize = 2000;

impl Trace {
    /// Another server begins, in a runtime of its own. Time goes on.
    pub(crate) fn begin(&self) {
        let mut lines = self.lines();
        (lines.began, lines.jumped) = (Some(Instant::now()), Duration::ZERO);
    }

    /// Notes that the runtime has ended.
    pub(crate) fn end(&self) {
        let now = self.now();
        let mut lines = self.lines();
        (lines.before, lines.began) = (now, None);
    }

    /// The clock is going to jump.
    pub(crate) fn jump(&self, by: Duration) {
        self.note(format!("time jumps by {:.3} s", by.as_secs_f64()));
        self.lines().jumped += by;
    }

    /// The time that all servers have had so far.
    pub(crate) fn now(&self) -> Duration {
        self.lines().now()
    }

    pub(crate) fn note(&self, text: impl AsRef<str>) {
        let mut lines = self.lines();
        let line = format!("{:10.3} {}", lines.now().as_secs_f64(), text.as_ref());
        // FNV-1a.
        let byte = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        lines.fingerprint = line.bytes().fold(lines.fingerprint ^ 0xcbf2_9ce4_8422_2325, byte);
        lines.count += 1;
        if lines.last.len() == MOST {
            lines.last.pop_front();
        }
        lines.last.push_back(line);
    }

    /// Two runs with the same one have had the same lines.
    pub(crate) fn fingerprint(&self) -> u64 {
        self.lines().fingerprint
    }

    /// The lines, as far as they are kept.
    pub(crate) fn text(&self) -> String {
        let lines = self.lines();
        let left_out = lines.count - lines.last.len() as u64;
        let mut text = if left_out > 0 { format!("… {left_out} lines before\n") } else { String::new() };
        lines.last.iter().for_each(|line| text.extend([line, "\n"]));
        text
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Lines {
    fn now(&self) -> Duration {
        self.before + self.began.map_or(Duration::ZERO, |began| began.elapsed().saturating_sub(self.jumped))
    }
}
