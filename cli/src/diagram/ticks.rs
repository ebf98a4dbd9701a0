//! A world with its brains, tick by tick: in this thread, or on a server of its own that programs attach to.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use baudbot_experiment::in_process::InProcess;
use baudbot_experiment::served::Served;
use baudbot_sim::{Scenario, World};

use super::meaning::Listeners;
use super::record::Recorded;
use crate::assignment::Assigned;
use crate::error::Refused;

/// Does a tick, adds the new events of a robot and what was said on its cables, and says the time until which they are known, in nanoseconds; nothing if the
/// run is over.
pub(super) type Tick<'a> = Box<dyn FnMut(&mut Recorded) -> anyhow::Result<Option<u64>> + 'a>;

/// The ticks of a run, with the events of the robot in this place, until `stop` is set.
pub(super) fn ticks<'a>(
    scenario: Scenario,
    assigned: &Assigned,
    place: usize,
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    if !assigned.programs.is_empty() {
        let mut world = World::new(Arc::new(scenario));
        let mut look = Look::new(&mut world, place);
        let run = Served::start(world, assigned.clone(), move |world| look.at(world));
        let mut run = run.map_err(from_run)?;
        return Ok(Box::new(move |recorded| match run.next(stop).map_err(from_run)? {
            None => Ok(None),
            Some(seen) => Ok(Some(seen?.put(recorded))),
        }));
    }
    let mut pair = InProcess::with_assignments(scenario, &assigned.brains)
        .map_err(|error| Refused::error(error.to_string()))?;
    let mut look = Look::new(&mut pair.world, place);
    Ok(Box::new(move |recorded| {
        if pair.world.ending().is_some() || stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        pair.tick(|_| {});
        Ok(Some(look.at(&pair.world)?.put(recorded)))
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
    listeners: Listeners,
}

struct Seen {
    fresh: Recorded,
    time_ns: u64,
}

impl Look {
    fn new(world: &mut World, place: usize) -> Self {
        Self { place, seen: 0, listeners: Listeners::new(world, place) }
    }

    /// The events since the last look.
    fn at(&mut self, world: &World) -> anyhow::Result<Seen> {
        let timeline = world.robot(self.place).timeline();
        let (gone, fresh) = timeline.since(self.seen);
        self.seen = timeline.total();
        let mut said = Vec::new();
        self.listeners.look(world, &mut said);
        match gone {
            0 => {
                let fresh = Recorded { events: fresh.copied().collect(), said };
                Ok(Seen { fresh, time_ns: world.time().as_ns() })
            }
            _ => Err(anyhow!(
                "more happened in a tick than a robot's timeline holds: {gone} events were dropped"
            )),
        }
    }
}

impl Seen {
    /// Adds it to what is known, and says the time until which it is known.
    fn put(self, recorded: &mut Recorded) -> u64 {
        recorded.events.extend(self.fresh.events);
        recorded.said.extend(self.fresh.said);
        self.time_ns
    }
}
