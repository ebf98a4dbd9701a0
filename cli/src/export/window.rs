//! The part of a recording that is wanted.

use baudbot_plot::quantity::handy;
use baudbot_recording::RecordedRun;
use baudbot_sim::SimTime;

use crate::args::{RowArgs, WindowArgs};
use crate::error::Refused;

/// Ticks of a recording, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) from_tick: u64,
    pub(super) to_tick: u64,
    /// The instant at which the first of them begins; nothing before it is wanted. The start of the run, if the
    /// recording's is wanted.
    pub(super) from: SimTime,
}

impl Window {
    pub(super) fn new(recorded: &RecordedRun, args: &WindowArgs) -> anyhow::Result<Self> {
        let (first, last) = (recorded.first_tick(), recorded.last_tick());
        Self::of((first, last), recorded.header().step_ns, args)
    }

    fn of((first, last): (u64, u64), step_ns: u64, args: &WindowArgs) -> anyhow::Result<Self> {
        let at = |tick: u64| handy(tick as f64 * step_ns as f64 * 1e-9);
        let from_ns = args.from_s.map_or(0, ns);
        let from_tick = from_ns.div_ceil(step_ns).max(first);
        let to_tick = args.to_s.map_or(last, |to_s| (ns(to_s) / step_ns).min(last));
        if let (Some(from_s), Some(to_s)) = (args.from_s, args.to_s)
            && from_s > to_s
        {
            return Err(Refused::error(format!("--from-s {from_s} is after --to-s {to_s}; swap them")));
        }
        if from_tick > to_tick {
            let (first, last) = (at(first), at(last));
            return Err(Refused::error(format!(
                "--from-s, --to-s: the recording is from {first} s to {last} s, and no tick of it is between them"
            )));
        }
        let from_ns = if from_tick == first { 0 } else { from_tick * step_ns };
        Ok(Self { from_tick, to_tick, from: SimTime::from_ns(from_ns) })
    }
}

/// The instant at which a tick begins.
pub(super) fn seconds(recorded: &RecordedRun, tick: u64) -> String {
    handy(SimTime::from_ns(tick.saturating_mul(recorded.header().step_ns)).as_seconds())
}

/// Every so many ticks there is a row.
pub(super) fn every(args: &RowArgs, step_ns: u64) -> u64 {
    let of_rate = |hz: f64| (1e9 / hz / step_ns as f64).round().max(1.0) as u64;
    args.every.or_else(|| args.hz.map(of_rate)).unwrap_or(1)
}

/// Arguments are at most a million seconds.
fn ns(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(from_s: Option<f64>, to_s: Option<f64>) -> Result<(u64, u64), String> {
        let window = Window::of((100, 6000), 10_000_000, &WindowArgs { from_s, to_s });
        window.map(|window| (window.from_tick, window.to_tick)).map_err(|error| error.to_string())
    }

    #[test]
    fn a_window_has_the_ticks_between_its_ends() {
        assert_eq!(window(None, None), Ok((100, 6000)));
        assert_eq!(window(Some(0.0), Some(1e6)), Ok((100, 6000)));
        assert_eq!(window(Some(2.3), Some(2.9)), Ok((230, 290)), "no end is lost to rounding");
        assert_eq!(window(Some(2.301), Some(2.899)), Ok((231, 289)));
        assert_eq!(window(Some(60.0), None), Ok((6000, 6000)));
        assert_eq!(window(Some(3.0), Some(2.0)).unwrap_err(), "--from-s 3 is after --to-s 2; swap them");
        for (from_s, to_s) in [(Some(61.0), None), (None, Some(0.5)), (Some(2.301), Some(2.302))] {
            let problem = window(from_s, to_s).unwrap_err();
            assert!(problem.contains("the recording is from 1 s to 60 s"), "{problem}");
        }
    }

    #[test]
    fn rates_are_whole_ticks() {
        let of_rate = |hz: f64| every(&RowArgs { every: None, hz: Some(hz) }, 10_000_000);
        assert_eq!([10.0, 30.0, 100.0, 1e9, 0.1].map(of_rate), [10, 3, 1, 1, 1000]);
        let asked = RowArgs { every: Some(7), hz: None };
        assert_eq!(every(&asked, 1), 7);
    }
}
