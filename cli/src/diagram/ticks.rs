//! A world with its brains, tick by tick: in this thread, on a server of its own that programs attach to, or from a recording.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use baudbot_experiment::in_process::InProcess;
use baudbot_experiment::served::Served;
use baudbot_recording::{RecordedRun, Replay, Watched};
use baudbot_sim::chip::{News, Scope, Shown};
use baudbot_sim::{Scenario, World};

use super::meaning::Listeners;
use super::pins;
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
    (place, finest_ns): (usize, u64),
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    if !assigned.programs.is_empty() {
        let mut world = World::new(Arc::new(scenario));
        let mut look = Look::new(&mut world, place, finest_ns);
        let run = Served::start(world, assigned.clone(), move |world| look.at(world));
        let mut run = run.map_err(from_run)?;
        return Ok(Box::new(move |recorded| match run.next(stop).map_err(from_run)? {
            None => Ok(None),
            Some(seen) => Ok(Some(seen?.put(recorded))),
        }));
    }
    let mut pair = InProcess::with_assignments(scenario, &assigned.brains)
        .map_err(|error| Refused::error(error.to_string()))?;
    let mut look = Look::new(&mut pair.world, place, finest_ns);
    Ok(Box::new(move |recorded| {
        if pair.world.ending().is_some() || stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        pair.tick(|_| {});
        Ok(Some(look.at(&pair.world)?.put(recorded)))
    }))
}

/// The ticks of a recorded run.
pub(super) fn recorded_ticks<'a>(
    recorded: Arc<RecordedRun>,
    (place, finest_ns): (usize, u64),
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    let (mut replay, mut world) =
        Replay::start_watching(recorded, Watched { pins: vec![place], ..Watched::default() })?;
    let mut look = Look::new(&mut world, place, finest_ns);
    Ok(Box::new(move |recorded| {
        if stop.load(Ordering::Relaxed) || !replay.step(&mut world)? {
            return Ok(None);
        }
        Ok(Some(look.at(&world)?.put(recorded)))
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
    scope: Option<Scope>,
}

struct Seen {
    fresh: Recorded,
    time_ns: u64,
}

impl Look {
    fn new(world: &mut World, place: usize, finest_ns: u64) -> Self {
        world.keep_edges(place, true);
        let scope = pins::scope(&world.scenario().robots[place], finest_ns);
        Self { place, seen: 0, listeners: Listeners::new(world, place), scope }
    }

    /// The events since the last look.
    fn at(&mut self, world: &World) -> anyhow::Result<Seen> {
        let timeline = world.robot(self.place).timeline();
        let (gone, fresh) = timeline.since(self.seen);
        self.seen = timeline.total();
        let mut said = Vec::new();
        self.listeners.look(world, &mut said);
        if gone > 0 {
            return Err(anyhow!(
                "more happened in a tick than a robot's timeline holds: {gone} events were dropped"
            ));
        }
        let fresh = Recorded { events: fresh.copied().collect(), said, shown: self.shown(world)? };
        Ok(Seen { fresh, time_ns: world.time().as_ns() })
    }

    /// What is new on the pins.
    fn shown(&mut self, world: &World) -> anyhow::Result<Vec<(usize, Shown)>> {
        let board = world.robot(self.place).board();
        let (Some(scope), Some(board)) = (&mut self.scope, board) else { return Ok(Vec::new()) };
        let News { lost, shown } = scope.look(board, world.time().as_ns());
        if lost > 0 {
            return Err(anyhow!(
                "more happened on the pins in a tick than is kept: {lost} edges were dropped; a smaller step_ms keeps them"
            ));
        }
        Ok(shown)
    }
}

impl Seen {
    /// Adds it to what is known, and says the time until which it is known.
    fn put(self, recorded: &mut Recorded) -> u64 {
        recorded.events.extend(self.fresh.events);
        recorded.said.extend(self.fresh.said);
        recorded.shown.extend(self.fresh.shown);
        self.time_ns
    }
}
