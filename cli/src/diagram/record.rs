//! The part of a run that is shown, and the time that the world runs for it.

use std::collections::VecDeque;

use baudbot_plot::quantity::{count, handy};
use baudbot_sim::SimTime;
use baudbot_sim::chip::{Edge, Shown};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;

use super::cycle::{Cycle, is_anchor};
use super::meaning::Said;
use super::pins::Pins;
use crate::error::Refused;

/// The part of a run that is requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) place: Place,
    /// The length of the window, in nanoseconds.
    pub(super) span_ns: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// From this instant on, in nanoseconds.
    At(u64),
    /// This control cycle, from 1 on, before all others.
    Cycle(u32),
    /// The events around an early cycle.
    Usual,
}

/// The new events of a run.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    pub(super) events: Vec<Event>,
    pub(super) said: Vec<Said>,
    /// The changes on the pins of its chip, each with the place of its signal.
    pub(super) shown: Vec<(usize, Shown)>,
    /// Each new edge there, if it is asked for.
    pub(super) edges: Vec<Edge>,
}

/// The events of a run that may be wanted.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) events: Vec<Event>,
    pub(super) said: Vec<Said>,
    pub(super) pins: Pins,
}

/// A part of a run.
#[derive(Debug, PartialEq)]
pub(super) struct Window {
    pub(super) from_ns: u64,
    pub(super) until_ns: u64,
    /// The cycle that it is about.
    pub(super) cycle: Option<Cycle>,
}

impl Wanted {
    /// Runs a world for as long as needed: `tick` does one tick, adds what is new of the robot, and returns the time
    /// after it, in nanoseconds, or nothing if the run was over before. Gives back all events that may be wanted, in
    /// the order in which they came, the last messages, and the signals of the pins.
    pub(super) fn record(
        &self,
        robot: &RobotSpec,
        step_ns: u64,
        mut tick: impl FnMut(&mut Recorded) -> anyhow::Result<Option<u64>>,
    ) -> anyhow::Result<Kept> {
        let (mut events, mut said, mut fresh) = (Vec::new(), VecDeque::new(), Recorded::default());
        let mut pins = Pins::new(robot);
        let (mut cycles, mut now_ns) = (0, 0);
        let mut until_ns = self.patience(step_ns);
        while now_ns < until_ns && events.len() + pins.count() < MOST_EVENTS {
            let Some(now) = tick(&mut fresh)? else { break };
            now_ns = now;
            said.extend(fresh.said.drain(..).filter(|one| self.may_tell(one)));
            let gone = said.len().saturating_sub(MOST_SAID);
            said.drain(..gone);
            let (from, until) = (self.pins_from(step_ns, now), self.pins_until(step_ns, now));
            let shown = fresh.shown.drain(..);
            // A round of the main loop is known when it is over.
            let is_round = |shown: &Shown| matches!(shown, Shown::Turns(turns) if turns.from_ns < until);
            pins.take(shown.filter(|(_, shown)| now <= until || is_round(shown)), from);
            for event in fresh.events.drain(..) {
                if is_anchor(event.what) {
                    cycles += 1;
                    // The answer comes later, and what is noted after its end comes later still.
                    if Some(cycles) == self.cycle() {
                        until_ns = now.saturating_add(self.span(step_ns)).saturating_add(SLACK_NS);
                    }
                }
                if self.may_show(&event) {
                    events.push(event);
                }
            }
        }
        self.refuse(cycles, now_ns)?;
        Ok(Kept { events, said: said.into(), pins })
    }

    /// The time for which the run goes on at most, in nanoseconds, unless the wanted events come.
    fn patience(&self, step_ns: u64) -> u64 {
        match self.place {
            Place::At(from_ns) => from_ns.saturating_add(self.span(step_ns)).saturating_add(SLACK_NS),
            Place::Cycle(_) | Place::Usual => PATIENCE_NS,
        }
    }

    /// Since when what is on the pins is wanted, as far as it is known now.
    fn pins_from(&self, step_ns: u64, now: u64) -> u64 {
        match self.place {
            Place::At(from_ns) => from_ns,
            Place::Cycle(_) | Place::Usual => now.saturating_sub(self.span(step_ns).saturating_mul(2)),
        }
    }

    /// The instant until which it is wanted, as far as it is known now.
    fn pins_until(&self, step_ns: u64, now: u64) -> u64 {
        let from = match self.place {
            Place::At(from_ns) => from_ns,
            Place::Cycle(_) | Place::Usual => now,
        };
        // Pulses that go on are reported late.
        from.saturating_add(self.span(step_ns).saturating_mul(2)).saturating_add(step_ns.saturating_mul(2))
    }

    /// The part that is wanted, of a robot with these events.
    pub(super) fn window(&self, robot: &RobotSpec, kept: &Kept, step_ns: u64) -> Window {
        let events = &kept.events[..];
        let span_ns = self.span(step_ns);
        let cycle = self.cycle().and_then(|number| Cycle::find(robot, events, number));
        match (self.place, cycle) {
            (Place::At(from_ns), _) => Window::new(from_ns, span_ns, None),
            (Place::Cycle(_), Some(cycle)) => {
                // A bit more than whole steps, so that their boundaries are seen.
                let more_ns = step_ns / 5;
                let from_ns = boundary(cycle.start, step_ns).saturating_sub(more_ns);
                let end = boundary(cycle.end(events), step_ns).saturating_add(step_ns);
                let end_ns = end.saturating_add(more_ns);
                let span_ns = self.span_ns.unwrap_or_else(|| end_ns.saturating_sub(from_ns));
                Window::new(from_ns, span_ns, Some(cycle))
            }
            (Place::Usual, Some(cycle)) => {
                let from_ns = boundary(cycle.start, step_ns).saturating_sub(step_ns);
                Window::new(from_ns, span_ns, None)
            }
            // No cycle was found: the window begins with the run.
            (Place::Cycle(_) | Place::Usual, None) => Window::new(0, span_ns, None),
        }
    }

    /// The cycle that it goes by.
    fn cycle(&self) -> Option<u32> {
        match self.place {
            Place::At(_) => None,
            Place::Cycle(number) => Some(number),
            Place::Usual => Some(USUAL),
        }
    }

    /// The length of the window, unless it is that of a cycle.
    pub(super) fn span(&self, step_ns: u64) -> u64 {
        self.span_ns.unwrap_or_else(|| step_ns.saturating_mul(3))
    }

    /// Cycles are counted from the start; all else is wanted only if it reaches into the window.
    fn may_show(&self, event: &Event) -> bool {
        match self.place {
            Place::At(from_ns) => event.end.as_ns() >= from_ns,
            Place::Cycle(_) | Place::Usual => true,
        }
    }

    /// A meaning arrives later than its message was sent, but not before.
    fn may_tell(&self, said: &Said) -> bool {
        match self.place {
            Place::At(from_ns) => said.at.as_ns() >= from_ns,
            Place::Cycle(_) | Place::Usual => true,
        }
    }

    fn refuse(&self, cycles: u32, now_ns: u64) -> anyhow::Result<()> {
        let now_s = handy(now_ns as f64 * 1e-9);
        match self.place {
            Place::At(from_ns) if now_ns < from_ns => {
                let at_s = handy(from_ns as f64 * 1e-9);
                Err(Refused::error(format!("--at {at_s}: the run is over after {now_s} s")))
            }
            Place::Cycle(number) if cycles < number => {
                let cycles = count(cycles as usize, "cycle");
                Err(Refused::error(format!("--cycle {number}: the run had {cycles} in {now_s} s")))
            }
            Place::Usual if cycles < USUAL => Err(Refused::error(format!(
                "the run had {} in {now_s} s; --at S shows any part of a run",
                count(cycles as usize, "cycle")
            ))),
            Place::At(_) | Place::Cycle(_) | Place::Usual => Ok(()),
        }
    }
}

impl Window {
    fn new(from_ns: u64, span_ns: u64, cycle: Option<Cycle>) -> Self {
        Self { from_ns, until_ns: from_ns.saturating_add(span_ns.max(1)), cycle }
    }

    /// Whether something from an instant to another is in the window.
    pub(super) fn has(&self, start_ns: u64, end_ns: u64) -> bool {
        start_ns < self.until_ns && (end_ns > self.from_ns || start_ns >= self.from_ns)
    }
}

/// The last boundary of steps that is not after an instant.
fn boundary(at: SimTime, step_ns: u64) -> u64 {
    at.as_ns() - at.as_ns() % step_ns.max(1)
}

/// The cycle that is shown if none is asked for: by then all runs as it always will.
const USUAL: u32 = 3;
/// A cycle may be noted so much later than it begins, and answered so late, in nanoseconds.
const SLACK_NS: u64 = 5_000_000_000;
/// So long a cycle is waited for, in nanoseconds.
const PATIENCE_NS: u64 = 3_600_000_000_000;
/// Most events of a diagram.
const MOST_EVENTS: usize = 4_000_000;
/// The number of messages that are kept, which is more than are sent in the time that a run goes on behind its window.
const MOST_SAID: usize = 400_000;

#[cfg(test)]
mod tests {
    use super::super::demo;
    use super::*;

    const STEP_NS: u64 = 10_000_000;

    fn wanted(place: Place) -> Wanted {
        Wanted { place, span_ns: None }
    }

    /// The record of a run of so many cycles of 20 ms, and the instant at which that stopped, in ms.
    fn recorded(wanted: Wanted, cycles: u64) -> (anyhow::Result<Vec<Event>>, u64) {
        let (scenario, events) = demo::wander(0, cycles);
        let mut events = events.into_iter().peekable();
        let mut now_ns = 0;
        let tick = |fresh: &mut Recorded| {
            if events.peek().is_none() {
                return Ok(None);
            }
            now_ns += STEP_NS;
            while let Some(event) = events.next_if(|event| event.end.as_ns() <= now_ns) {
                fresh.events.push(event);
            }
            Ok(Some(now_ns))
        };
        let events = wanted.record(&scenario.robots[0], STEP_NS, tick).map(|recorded| recorded.events);
        (events, now_ns / 1_000_000)
    }

    fn problem(wanted: Wanted, cycles: u64) -> String {
        recorded(wanted, cycles).0.unwrap_err().to_string()
    }

    #[test]
    fn a_run_goes_on_no_longer_than_is_needed() {
        let (events, ms) = recorded(wanted(Place::Cycle(2)), 1000);
        assert!(events.is_ok() && (5000..5200).contains(&ms), "{ms}");
        let (events, ms) = recorded(wanted(Place::At(1_000_000_000)), 1000);
        assert!((6000..6100).contains(&ms), "{ms}");
        assert!(events.unwrap().iter().all(|event| event.end.as_ns() >= 1_000_000_000));
    }

    #[test]
    fn what_a_run_does_not_have_is_refused() {
        assert_eq!(problem(wanted(Place::Cycle(9)), 8), "--cycle 9: the run had 8 cycles in 0.19 s");
        assert_eq!(problem(wanted(Place::At(2_000_000_000)), 8), "--at 2: the run is over after 0.19 s");
        assert_eq!(
            problem(wanted(Place::Usual), 1),
            "the run had 1 cycle in 0.05 s; --at S shows any part of a run"
        );
    }

    #[test]
    fn a_cycle_is_shown_from_the_boundary_before_it_to_one_behind_it() {
        let (scenario, events) = demo::wander(0, 6);
        let robot = &scenario.robots[0];
        let kept = demo::kept(robot, events);
        let window = |place| wanted(place).window(robot, &kept, STEP_NS);
        let cycle = window(Place::Cycle(3));
        let end = cycle.cycle.as_ref().unwrap().end(&kept.events).as_ns();
        assert_eq!((end, cycle.from_ns, cycle.until_ns), (83_000_000, 38_000_000, 92_000_000));
        let usual = window(Place::Usual);
        assert_eq!((usual.from_ns, usual.until_ns, usual.cycle), (30_000_000, 60_000_000, None));
        let at = Wanted { place: Place::At(u64::MAX), span_ns: Some(7) };
        assert_eq!(at.window(robot, &kept, STEP_NS).until_ns, u64::MAX);
    }
}
