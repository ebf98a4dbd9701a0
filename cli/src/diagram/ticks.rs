//! A world with its brains, tick by tick: in this thread, on a server of its own that programs attach to, or from a recording.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;
use baudbot_experiment::served::Served;
use baudbot_recording::{RecordedRun, Replay, Watched};
use baudbot_run::in_process::InProcess;
use baudbot_sim::chip::{News, Scope};
use baudbot_sim::{Scenario, World};

use super::meaning::Listeners;
use super::pins;
use super::record::Recorded;
use crate::assignment::Assigned;
use crate::error::Refused;
use crate::trace::unseen;

/// Does a tick, adds the new events of a robot and what was said on its cables, and returns the time until which they
/// are known, in nanoseconds; nothing if the run is over.
pub(super) type Tick<'a> = Box<dyn FnMut(&mut Recorded) -> anyhow::Result<Option<u64>> + 'a>;

/// The view of the pins of the robot's chip, if it has one.
#[derive(Clone, Copy, Debug)]
pub(super) enum View {
    /// The signals of the chip; pulses with a period below this, in nanoseconds, are summed up.
    Signals(u64),
    /// The view has each edge.
    Edges,
}

/// The ticks of a run, with the events of the robot in this place, until `stop` is set.
pub(super) fn ticks<'a>(
    scenario: Scenario,
    assigned: &Assigned,
    (place, view): (usize, View),
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    if !assigned.programs.is_empty() || !assigned.at_ports.is_empty() {
        let mut world = World::new(Arc::new(scenario));
        let mut look = Look::new(&mut world, place, view);
        let run = Served::start(world, assigned.clone(), move |world, _| look.at(world));
        let mut run = run.map_err(from_run)?;
        return Ok(Box::new(move |recorded| match run.next(stop).map_err(from_run)? {
            None => Ok(None),
            Some(seen) => Ok(Some(seen?.put(recorded))),
        }));
    }
    let mut pair = InProcess::with_assignments(scenario, &assigned.brains)
        .map_err(|error| Refused::error(error.to_string()))?;
    let mut look = Look::new(&mut pair.world, place, view);
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
    (place, view): (usize, View),
    stop: &'a AtomicBool,
) -> anyhow::Result<Tick<'a>> {
    let (mut replay, mut world) =
        Replay::start_watching(recorded, Watched { pins: vec![place], ..Watched::default() })?;
    let mut look = Look::new(&mut world, place, view);
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

/// The reader of a robot's events.
struct Look {
    place: usize,
    /// The number of events that have been seen.
    seen: u64,
    listeners: Listeners,
    /// None: each edge is wanted.
    scope: Option<Scope>,
    /// The number of edges that have been seen, if each is wanted.
    edges: u64,
}

struct Seen {
    fresh: Recorded,
    time_ns: u64,
}

impl Look {
    fn new(world: &mut World, place: usize, view: View) -> Self {
        world.keep_edges(place, true);
        let scope = match view {
            View::Signals(finest_ns) => pins::scope(&world.scenario().robots[place], finest_ns),
            View::Edges => None,
        };
        Self { place, seen: 0, listeners: Listeners::new(world, place), scope, edges: 0 }
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
                "a tick had more events than a robot's timeline can store: {gone} events were dropped"
            ));
        }
        let mut fresh = Recorded { events: fresh.copied().collect(), said, ..Recorded::default() };
        self.pins(world, &mut fresh)?;
        Ok(Seen { fresh, time_ns: world.time().as_ns() })
    }

    /// The news of the pins.
    fn pins(&mut self, world: &World, fresh: &mut Recorded) -> anyhow::Result<()> {
        let Some(board) = world.robot(self.place).board() else { return Ok(()) };
        let lost = match (&mut self.scope, board.edges()) {
            (Some(scope), _) => {
                let News { lost, shown } = scope.look(board, world.time().as_ns());
                fresh.shown = shown;
                lost
            }
            (None, Some(edges)) => {
                let (lost, seen) = edges.since(unseen(self.edges, edges.total()));
                self.edges = edges.total();
                fresh.edges.extend(seen.copied());
                lost
            }
            (None, None) => 0,
        };
        match lost {
            0 => Ok(()),
            _ => Err(anyhow!(
                "a tick had more edges on the pins than can be stored: {lost} edges were dropped; a smaller step_ms avoids that"
            )),
        }
    }
}

impl Seen {
    /// Adds it to what is known, and returns the time until which it is known.
    fn put(self, recorded: &mut Recorded) -> u64 {
        recorded.events.extend(self.fresh.events);
        recorded.said.extend(self.fresh.said);
        recorded.shown.extend(self.fresh.shown);
        recorded.edges.extend(self.fresh.edges);
        self.time_ns
    }
}
