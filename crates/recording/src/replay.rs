//! Replay: a world that repeats a recorded run, and is compared with the recording.

use std::fmt;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::cable::Cable;
use baudbot_sim::model::PortUse;
use baudbot_sim::{Input, SimTime, World};

use crate::error::RecordingError;
use crate::recorded_run::RecordedRun;
use crate::{PROGRAM_VERSION, change, digest, writer};

/// Does a recording again, in a world that is given to it: that stands at the beginning of a tick, its sensors read, as the
/// one did that was recorded.
#[derive(Clone, Debug)]
pub struct Replay {
    recorded: Arc<RecordedRun>,
    /// The tick that is looked for, and a world a little before it, so that steps back from there are short.
    goal: u64,
    near: Option<World>,
    difference: Option<Difference>,
    watched: Watched,
}

/// The record of robots that is kept while a run is replayed.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    /// The robots of whose chips' pins the edges are [kept](World::keep_edges).
    pub pins: Vec<usize>,
    /// The robots of whose cables the last bytes are [kept](World::keep_tape).
    pub cables: Vec<usize>,
    /// The number of bytes.
    pub bytes: usize,
    /// Whether it is [kept](World::keep_starts) how robots are when a tick begins.
    pub starts: bool,
}

/// The place at which a replay differs from the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The first tick that differs.
    pub tick: u64,
    /// The instant at which that is.
    pub time: SimTime,
    /// The first field that differs, or what else does.
    pub what: String,
    /// The version of the program that recorded, if it is another.
    pub program: Option<String>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {} ({} s): {}", self.tick, self.time.as_seconds(), self.what)?;
        match &self.program {
            Some(program) => write!(f, " (recorded by baudbot {program}, this is {PROGRAM_VERSION})"),
            None => Ok(()),
        }
    }
}

type Result<T> = std::result::Result<T, RecordingError>;

impl Replay {
    /// A replay, and its world at the recording's first tick.
    ///
    /// # Errors
    /// If the first state cannot be used.
    pub fn start(recorded: Arc<RecordedRun>) -> Result<(Self, World)> {
        Self::start_watching(recorded, Watched::default())
    }

    /// The same in which more is kept of robots, also behind a jump.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn start_watching(recorded: Arc<RecordedRun>, watched: Watched) -> Result<(Self, World)> {
        let mut world = recorded.first_state()?;
        let mut replay = Self { recorded, goal: 0, near: None, difference: None, watched };
        replay.begin(&mut world)?;
        Ok((replay, world))
    }

    /// Keeps edges on the pins of these robots' chips from now on, also behind a jump.
    pub fn watch(&mut self, robots: impl IntoIterator<Item = usize>) {
        self.watched.pins.clear();
        self.watched.pins.extend(robots);
    }

    /// The recording that is replayed.
    pub fn recorded(&self) -> &Arc<RecordedRun> {
        &self.recorded
    }

    /// The first difference that has been found so far.
    pub fn difference(&self) -> Option<&Difference> {
        self.difference.as_ref()
    }

    /// Whether there is no more to replay.
    pub fn is_over(&self, world: &World) -> bool {
        self.is_at_a_gap(world) && self.recorded.next_stretch(world.tick()).is_none()
    }

    /// Whether there is no more to replay, or no more before something that is missing.
    fn is_at_a_gap(&self, world: &World) -> bool {
        world.tick() >= self.recorded.stretch_of(world.tick()).last_tick || world.ending().is_some()
    }

    /// Goes on to the beginning of the next tick, or past what is missing to the next one that is there; does nothing
    /// at the end. Returns whether it has gone on.
    ///
    /// # Errors
    /// If the recording has an input that cannot be read.
    pub fn step(&mut self, world: &mut World) -> Result<bool> {
        if self.is_at_a_gap(world) {
            let Some(next) = self.recorded.next_stretch(world.tick()) else { return Ok(false) };
            *world = self.recorded.state_before(next.first_tick)?;
            self.begin(world)?;
            return Ok(true);
        }
        let recorded = self.recorded.inputs_at(world.tick())?;
        let inputs = recorded.iter().flat_map(|recorded| &recorded.inputs);
        self.check(inputs.clone(), world);
        finish(world, inputs);
        self.begin(world)?;
        if world.tick() + RUN_UP == self.goal {
            self.near = Some(world.clone());
        }
        Ok(true)
    }

    /// Goes to a tick, forwards or backwards; to the nearest there is.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn seek(&mut self, world: &mut World, tick: u64) -> Result<()> {
        self.approach(world, tick)?;
        while world.tick() < self.goal && self.step(world)? {}
        Ok(())
    }

    /// Goes as near to a tick as can be done at once, and not beyond it: what is left is to be done in
    /// [steps](Self::step). Returns whether the world has jumped: it may then be at any time, and know little of the
    /// past.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn approach(&mut self, world: &mut World, tick: u64) -> Result<bool> {
        self.goal = self.recorded.nearest(tick);
        let here = Some(world.tick()).filter(|&at| at <= self.goal);
        let near = self.near.as_ref().filter(|near| near.tick() <= self.goal);
        // Some ticks before it, so that there is something on the timelines.
        let from = self.goal.saturating_sub(RUN_UP).max(self.recorded.stretch_of(self.goal).first_tick);
        let state = self.recorded.nearest_state(from);
        match (here, near) {
            (Some(here), near) if here >= near.map_or(state, World::tick).max(state) => return Ok(false),
            (_, Some(near)) if near.tick() >= state => *world = near.clone(),
            _ => *world = self.recorded.state_before(from)?,
        }
        self.begin(world)?;
        Ok(true)
    }

    /// Makes manual changes, begins the tick, and compares it with the recording.
    fn begin(&mut self, world: &mut World) -> Result<()> {
        world.keep_starts(self.watched.starts);
        for &robot in &self.watched.pins {
            world.keep_edges(robot, true);
        }
        for &robot in &self.watched.cables {
            if !world.keeps_tape(robot) {
                world.keep_tape(robot, self.watched.bytes);
            }
        }
        if world.is_begun() {
            // The changes were made before this state was kept.
            self.compare(world);
            return Ok(());
        }
        let changes =
            self.recorded.inputs_at(world.tick())?.into_iter().flat_map(|recorded| recorded.changes);
        for change in changes.filter_map(|recorded| recorded.change) {
            if let Err(error) = world.intervene(&change::intervention(change)) {
                self.differs(world, format!("a manual change is not possible: {error}"));
            }
        }
        world.begin();
        self.compare(world);
        Ok(())
    }

    fn compare(&mut self, world: &World) {
        if self.difference.is_some() {
            return;
        }
        let tick = world.tick();
        let recorded = Arc::clone(&self.recorded);
        let Some(mark) = recorded.mark_of(tick) else { return };
        if let Some(what) = digest::difference(mark, world) {
            self.differs(world, what);
        } else if mark.tick == tick && mark.state_hash != world.hash() {
            let since = mark.first_tick;
            self.differs(
                world,
                format!(
                    "the state's fingerprint, though no field that is looked at differs (since tick {since})"
                ),
            );
        } else if tick == recorded.stretch_of(tick).last_tick || world.ending().is_none() {
            // All is as it was.
        } else {
            self.differs(
                world,
                format!("the run has ended; in the recording it continues to tick {}", recorded.last_tick()),
            );
        }
    }

    /// Whether inputs are those that were written.
    fn check<'a>(&mut self, inputs: impl Iterator<Item = &'a v1::RecordedInput>, world: &World) {
        for input in inputs {
            if input.checksum != writer::checksum(input.after_ns, &input.data) {
                let robots = &world.scenario().robots;
                let name = robots.get(input.robot as usize).map_or("no robot", |robot| &robot.name);
                self.differs(
                    world,
                    format!("`{name}`: the bytes of its brain differ from the recorded ones"),
                );
            }
        }
    }

    fn differs(&mut self, world: &World, what: String) {
        if self.difference.is_none() {
            let recorder = &self.recorded.header().program_version;
            let program = Some(recorder.clone()).filter(|program| program != PROGRAM_VERSION);
            let (tick, time) = (world.tick(), world.time());
            self.difference = Some(Difference { tick, time, what, program });
        }
    }
}

/// Second half of a tick in which this entered the world.
pub(crate) fn finish<'a>(world: &mut World, inputs: impl IntoIterator<Item = &'a v1::RecordedInput> + Clone) {
    let now = world.time().as_ns();
    let at = |input: &v1::RecordedInput| SimTime::from_ns(now.saturating_add_signed(input.after_ns));
    for input in inputs.clone() {
        if let Some(tick) = input.answers_tick {
            world.answers(input.robot as usize, tick);
        }
    }
    let robots = &world.scenario().clone().robots;
    let is_within = |input: &v1::RecordedInput| {
        robots.get(input.robot as usize).is_some_and(|spec| spec.port_use == PortUse::Simulated)
    };
    for input in inputs.clone() {
        let robot = input.robot as usize;
        if is_within(input) {
            let cable = input.sensor.map_or(Cable::Robot, |sensor| Cable::Sensor(sensor as usize));
            world.write_within(robot, cable, at(input), &input.data);
        } else if let Some(sensor) = input.sensor {
            world.write_port(robot, sensor as usize, at(input), &input.data);
        }
    }
    let written = inputs.into_iter().filter(|input| input.sensor.is_none() && !is_within(input));
    let input = |input: &'a v1::RecordedInput| Input {
        robot: input.robot as usize,
        at: at(input),
        bytes: &input.data,
    };
    world.finish(&written.map(input).collect::<Vec<_>>());
}

/// Ticks before one that is looked for, from which it is simulated.
const RUN_UP: u64 = 128;
