//! The work that can come within a time, and the queue that it can make.
//!
//! A task that falls due every P, and up to J late, comes at most ⌊(x + J) / P⌋ + 1 times in any x. A server that
//! takes one thing after the other and never rests while there is work has, at any instant, at most max over x of Σ
//! work(x) − x to do: the *backlog*; and is busy at a stretch no longer than the first x at which Σ work(x) ≤ x.
//! (Network calculus; Le Boudec and Thiran, 2001.)

/// The rate at which something comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Curve {
    /// The time between two, on average at least, in nanoseconds.
    pub(super) period_ns: u64,
    /// The possible lateness of each, in nanoseconds.
    pub(super) jitter_ns: u64,
}

/// A source of work, and the work of each time, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) curve: Curve,
    pub(super) work_ns: u64,
}

/// A queue at its longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Queue {
    /// Most work that there is to do at an instant, in nanoseconds.
    pub(super) backlog_ns: u64,
    /// Longest time without a rest, in nanoseconds.
    pub(super) busy_ns: u64,
}

impl Curve {
    /// Once every so often, never late.
    pub(super) const fn every(period_ns: u64) -> Self {
        Self { period_ns, jitter_ns: 0 }
    }

    /// The same, later by up to so much.
    pub(super) const fn late_by(self, ns: u64) -> Self {
        Self { jitter_ns: self.jitter_ns.saturating_add(ns), ..self }
    }

    /// The most times that it comes in a time, both its ends included.
    pub(super) const fn count(&self, within_ns: u64) -> u64 {
        within_ns.saturating_add(self.jitter_ns) / self.period_ns + 1
    }
}

/// Instants that are examined before a queue is taken to be endless.
const MOST_STEPS: usize = 1024;

/// The longest queue that these can make; `None` if there may be no end to it.
pub(super) fn queue(sources: &[Source]) -> Option<Queue> {
    let load: f64 = sources.iter().map(|s| s.work_ns as f64 / s.curve.period_ns as f64).sum();
    if load > 1.0 {
        return None;
    }
    let mut x = 0;
    let mut backlog_ns = 0;
    for _ in 0..MOST_STEPS {
        let work = demand(sources, x);
        backlog_ns = backlog_ns.max(work.saturating_sub(x));
        match next_ns(sources, x) {
            Some(next) if work > next => x = next,
            _ => return Some(Queue { backlog_ns, busy_ns: work }),
        }
    }
    None
}

/// The most work that there is at an instant, in nanoseconds, if the server has not rested for `ns` before it or longer; 0 if
/// it never works for so long. `None` if there may be no end to it.
pub(super) fn backlog_after(sources: &[Source], ns: u64) -> Option<u64> {
    let busy_ns = queue(sources)?.busy_ns;
    let mut x = ns;
    let mut backlog_ns = 0;
    for _ in 0..MOST_STEPS {
        if x > busy_ns {
            return Some(backlog_ns);
        }
        backlog_ns = backlog_ns.max(demand(sources, x).saturating_sub(x));
        let Some(next) = next_ns(sources, x) else { return Some(backlog_ns) };
        x = next;
    }
    None
}

/// The work that comes within a time, both its ends included.
fn demand(sources: &[Source], within_ns: u64) -> u64 {
    let each = sources.iter().map(|s| s.curve.count(within_ns).saturating_mul(s.work_ns));
    each.fold(0, u64::saturating_add)
}

/// The next time in which one more can come.
fn next_ns(sources: &[Source], x: u64) -> Option<u64> {
    let working = sources.iter().filter(|source| source.work_ns > 0);
    working
        .map(|s| s.curve.count(x).saturating_mul(s.curve.period_ns).saturating_sub(s.curve.jitter_ns))
        .min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(period_ns: u64, jitter_ns: u64, work_ns: u64) -> Source {
        Source { curve: Curve { period_ns, jitter_ns }, work_ns }
    }

    #[test]
    fn one_after_the_other_makes_no_queue() {
        assert_eq!(queue(&[source(10, 0, 7)]), Some(Queue { backlog_ns: 7, busy_ns: 7 }));
        assert_eq!(queue(&[source(10, 0, 7), source(100, 0, 5)]).unwrap().backlog_ns, 12);
        assert_eq!(queue(&[]), Some(Queue { backlog_ns: 0, busy_ns: 0 }));
        assert_eq!(queue(&[source(10, 0, 0)]), Some(Queue { backlog_ns: 0, busy_ns: 0 }));
    }

    #[test]
    fn what_is_late_meets_what_is_not() {
        // The first may be 25 late: then the second and the third come at once, and the fourth 5 later.
        let late = queue(&[source(10, 25, 7)]).unwrap();
        assert_eq!(late.backlog_ns, 3 * 7 + 7 - 5);
    }

    #[test]
    fn what_came_long_ago_is_done() {
        let sources = [source(100, 0, 30), source(40, 0, 5)];
        // At once 35; 30 later 5, if it has worked since then; it never works for 40.
        assert_eq!([0, 30, 36].map(|ns| backlog_after(&sources, ns)), [Some(35), Some(5), Some(0)]);
        assert_eq!(backlog_after(&[source(10, 0, 11)], 0), None);
    }

    #[test]
    fn too_much_work_has_no_end() {
        assert_eq!(queue(&[source(10, 0, 7), source(10, 0, 4)]), None);
    }
}
