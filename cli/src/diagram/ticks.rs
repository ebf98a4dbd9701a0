//! A world with its brains, tick by tick: in this thread, or on a server of its own that programs attach to.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use baudbot_experiment::in_process::InProcess;
use baudbot_experiment::served::Served;
use baudbot_sim::timeline::Event;
use baudbot_sim::{Scenario, World};

use crate::assignment::Assigned;
use crate::error::Refused;

/// Does a tick, adds the new events of a robot, and says the time until which they are known, in nanoseconds; nothing if the
/// run is over.
pub(super) type Tick<'a> = Box<dyn FnMut(&mut Vec<Event>) -> anyhow::Result<Option<u64>> + 'a>;

/// The ticks of a run, with the events of the robot in this place, until `stop` is set.
pub(super) fn ticks<'a>(
    scenario: Scenario,
    assigned: &Assigned,
    place: usize,
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    let mut look = Look { place, seen: 0 };
    if !assigned.programs.is_empty() {
        let run = Served::start(scenario, assigned.clone(), move |world| look.at(world));
        let mut run = run.map_err(from_run)?;
        return Ok(Box::new(move |events| match run.next(stop).map_err(from_run)? {
            None => Ok(None),
            Some(seen) => seen?.into_events(events),
        }));
    }
    let mut pair = InProcess::with_assignments(scenario, &assigned.brains)
        .map_err(|error| Refused::error(error.to_string()))?;
    Ok(Box::new(move |events| {
        if pair.world.ending().is_some() || stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        pair.tick(|_| {});
        look.at(&pair.world)?.into_events(events)
    }))
}

fn from_run(error: baudbot_experiment::Error) -> anyhow::Error {
    anyhow!("{error}")
}

/// Looks at a robot's events.
struct Look {
    place: usize,
    /// How many of them have been seen.
    seen: u64,
}

struct Seen {
    fresh: Vec<Event>,
    time_ns: u64,
}

impl Look {
    /// The events since the last look.
    fn at(&mut self, world: &World) -> anyhow::Result<Seen> {
        let timeline = world.robot(self.place).timeline();
        let (gone, fresh) = timeline.since(self.seen);
        self.seen = timeline.total();
        match gone {
            0 => Ok(Seen { fresh: fresh.copied().collect(), time_ns: world.time().as_ns() }),
            _ => Err(anyhow!(
                "more happened in a tick than a robot's timeline holds: {gone} events were dropped"
            )),
        }
    }
}

impl Seen {
    fn into_events(self, events: &mut Vec<Event>) -> anyhow::Result<Option<u64>> {
        events.extend(self.fresh);
        Ok(Some(self.time_ns))
    }
}
