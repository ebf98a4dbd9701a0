//! Recordings of worlds: the part that runs on the thread that runs the world, which is small.
//!
//! It collects the inputs of the world and, now and then, a fingerprint, a state and a frame. The recording's own thread
//! ([`thread`]) makes messages of these and writes them. Entries go to that thread in batches, since waking it takes longer
//! than collecting the entries of a tick.

mod file;
mod folder;
mod thread;

use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_recording::{Digests, checksum, header, saved};
use baudbot_sim::model::PortUse;
use baudbot_sim::{Intervention, SimTime, World};
use tokio::sync::oneshot;
use tonic::{Code, Status};

use crate::clock;
use crate::convert;
use crate::log::event;
use crate::message::RecordConfig;
use crate::observers::{Eye, View};
use crate::pace::Pace;
use crate::sessions::Sessions;
pub(crate) use folder::Folder;
use thread::{RecorderThread, Sent};

/// A recording until then, by the wall clock, is not lost if the program is killed; twice as often as promised, since
/// it has to be written yet.
const MARK_EVERY: Duration = Duration::from_millis(400);

/// The interval for a world that runs much faster than the clock, so that little is lost by a full disk.
const MARK_EVERY_TICKS: u64 = 2000;

/// However long a mark takes.
const MARK_AT_LAST: Duration = Duration::from_millis(800);

/// Ticks between two states: a replay that seeks simulates at most so many.
const STATE_EVERY_TICKS: u64 = 6000;

/// Files of one recording.
const MAX_RUNS: u32 = 100_000;

/// Entries that go to the thread at once.
const BATCH: usize = 512;

/// Collisions of a tick that are recorded one by one.
const MAX_COLLISIONS: usize = 100;

/// An entry of a recording.
pub(crate) enum Entry {
    /// The bytes that brains wrote in a tick.
    Inputs(v1::RecordedInputs),
    Mark(v1::RecordedMark),
    State(v1::RecordedState),
    Event(v1::RecordedEvent),
    Frame(Box<v1::WatchResponse>),
    Thinking(v1::RecordedThinking),
}

/// The bytes that a brain wrote to a robot's port.
pub(crate) struct Input {
    pub(crate) robot: usize,
    /// The sensor on whose own cable it went; `None` if it was the robot's.
    pub(crate) sensor: Option<usize>,
    pub(crate) at: SimTime,
    pub(crate) bytes: Vec<u8>,
    /// The tick whose Turn it answers, if that is known.
    pub(crate) answers_tick: Option<u64>,
}

/// The recorder of a world, on the world's side.
pub(crate) struct Recorder {
    config: RecordConfig,
    /// The number of the recording's file, from 1: a reset or a restored state begins another one.
    run: u32,
    thread: RecorderThread,
    /// Whether the world follows a clock, and does not wait for the disk.
    is_hurried: bool,
    /// Whether something went wrong, so that nothing is recorded any more.
    is_over: bool,
    batch: Vec<Entry>,
    /// Batches that the thread had no room for.
    backlog: Vec<Vec<Entry>>,
    digests: Digests,
    first_tick: u64,
    ticks: u64,
    state_tick: u64,
    marked: Instant,
    /// The duration of the last mark.
    mark_takes: Duration,
    /// The maker of a frame every so many ticks.
    eye: Option<(Eye, u64)>,
}

impl Recorder {
    /// Begins to record a world, whose tick may have begun.
    pub(crate) fn start(
        config: RecordConfig,
        name: &str,
        pace: Pace,
        view: View<'_>,
    ) -> Result<Self, Status> {
        Self::begin(config, 1, name, pace, view)
    }

    fn begin(
        config: RecordConfig,
        run: u32,
        name: &str,
        pace: Pace,
        View { world, .. }: View<'_>,
    ) -> Result<Self, Status> {
        let file = file::create(&config.path)?;
        let scenario = world.scenario();
        let header = header(name, world.origin(), Some(convert::pace_to(pace)));
        let description = || (world.time().as_ns(), convert::world_description(scenario));
        let description = (config.look_hz > 0.0).then(description);
        let thread = RecorderThread::start(file, header, description)?;
        let every = (config.look_hz > 0.0).then(|| {
            let ticks = 1e9 / config.look_hz / scenario.step_ns as f64;
            (Eye::of_all(world), ticks.round().max(1.0) as u64)
        });
        let mut recorder = Self {
            config,
            run,
            thread,
            is_hurried: is_hurried(pace),
            is_over: false,
            backlog: Vec::new(),
            batch: vec![Entry::State(saved::state(world))],
            digests: Digests::default(),
            first_tick: world.tick(),
            ticks: 0,
            state_tick: world.tick(),
            marked: clock::now(),
            mark_takes: Duration::ZERO,
            eye: every,
        };
        recorder.close_batch(world);
        Ok(recorder)
    }

    /// Adds a last mark, so that the file has all until here.
    fn close_batch(&mut self, world: &World) {
        self.batch.push(Entry::Mark(self.digests.last_mark(world)));
        self.send();
    }

    /// Whether it wants to see the world in the tick that comes, which must not be ahead of its brains then.
    pub(crate) fn looks(&self) -> bool {
        !self.is_over && (self.eye.is_some() || self.is_mark_due())
    }

    /// Whether frames are recorded.
    pub(crate) fn has_frames(&self) -> bool {
        self.eye.is_some()
    }

    /// Notes that the world has another pace.
    pub(crate) fn set_pace(&mut self, pace: Pace) {
        self.is_hurried = is_hurried(pace);
    }

    /// A mark takes at most a hundredth of the time, if a second is enough for that.
    fn is_mark_due(&self) -> bool {
        let interval = (self.mark_takes * 100).clamp(MARK_EVERY, MARK_AT_LAST);
        self.digests.ticks() >= MARK_EVERY_TICKS || clock::since(self.marked) >= interval
    }

    /// Records how a tick begins, before it does.
    pub(crate) fn look(&mut self, view: View<'_>) {
        let Some((eye, every)) = self.eye.as_mut().filter(|_| !self.is_over) else { return };
        eye.note(view.world);
        if view.world.tick().is_multiple_of(*every) || view.world.ending().is_some() {
            self.batch.push(Entry::Frame(Box::new(eye.frame(view))));
        }
    }

    /// Records a tick that has begun. `is_sure`: no brain has yet to answer an earlier one.
    pub(crate) fn tick(&mut self, view: View<'_>, is_sure: bool) {
        if self.is_over {
            return;
        }
        let world = view.world;
        self.ticks = world.tick().saturating_sub(self.first_tick);
        self.digests.note(world);
        for collision in world.collisions().iter().take(MAX_COLLISIONS) {
            let text = format!("`{}` ran into `{}`", collision.robot, collision.with);
            self.event(world.tick(), v1::ReplayEventKind::Collision, text);
        }
        let ended = world.ending();
        if let Some(ending) = ended {
            self.event(world.tick(), v1::ReplayEventKind::Ending, format!("the run has ended: {ending}"));
        }
        if is_sure && (self.is_mark_due() || ended.is_some()) {
            self.mark(view);
        } else if self.batch.len() >= BATCH {
            self.send();
        }
    }

    fn mark(&mut self, view: View<'_>) {
        let (began, world) = (clock::now(), view.world);
        if world.tick() >= self.state_tick + STATE_EVERY_TICKS {
            self.state_tick = world.tick();
            self.batch.push(Entry::State(saved::state(world)));
            self.thinking(world, view.sessions);
        }
        self.batch.push(Entry::Mark(self.digests.mark(world)));
        self.marked = clock::now();
        self.mark_takes = self.marked - began;
        self.send();
    }

    /// Records what brains wrote in a tick.
    pub(crate) fn inputs(&mut self, inputs: v1::RecordedInputs) {
        if !self.is_over {
            self.batch.push(Entry::Inputs(inputs));
        }
    }

    /// Records a manual change before this tick.
    pub(crate) fn change(&mut self, tick: u64, intervention: &Intervention) {
        if self.is_over {
            return;
        }
        let changes = vec![baudbot_recording::change(intervention)];
        self.event(tick, v1::ReplayEventKind::Change, described(intervention));
        self.batch.push(Entry::Inputs(v1::RecordedInputs { tick, changes, inputs: Vec::new() }));
    }

    /// Records an event.
    pub(crate) fn event(&mut self, tick: u64, kind: v1::ReplayEventKind, text: String) {
        if self.is_over {
            return;
        }
        self.batch.push(Entry::Event(v1::RecordedEvent { tick, kind: kind.into(), text }));
    }

    /// Records how long brains took to answer until now, if that was measured.
    pub(crate) fn thinking(&mut self, world: &World, sessions: &Sessions) {
        let robots = convert::thinking(world.scenario(), sessions.thought());
        if !self.is_over && !robots.is_empty() {
            self.batch.push(Entry::Thinking(v1::RecordedThinking { tick: world.tick(), robots }));
        }
    }

    fn send(&mut self) {
        let batch = std::mem::replace(&mut self.batch, Vec::with_capacity(BATCH));
        if self.is_over {
            return;
        }
        if !self.backlog.is_empty() {
            self.backlog.push(batch);
        } else if let Sent::Full(batch) = self.thread.send(batch) {
            self.backlog.push(batch);
        }
        if self.is_hurried && self.is_stuck() {
            self.backlog.clear();
            self.thread.fail("the disk is slower than the world, which follows the clock");
        }
        self.is_over = self.thread.progress().1.is_some();
    }

    /// Whether something waits for the disk. The world then waits, too, if it does not follow a clock.
    pub(crate) fn is_stuck(&self) -> bool {
        !self.backlog.is_empty()
    }

    /// Waits for the disk. Only a thread that no other world waits for may.
    pub(crate) fn wait_for_disk(&mut self) {
        self.backlog.drain(..).for_each(|batch| self.thread.send_at_last(batch));
    }

    /// Ends the recording with the world as it stands, between two ticks or within one. `reply` gets the status when the file is
    /// closed. `is_sure`: no brain has yet to answer. Otherwise the file ends with the last mark.
    pub(crate) fn stop(
        mut self,
        world: &World,
        is_sure: bool,
        reply: Option<oneshot::Sender<v1::RecordingStatus>>,
    ) {
        if !self.is_over && is_sure {
            self.ticks = world.tick().saturating_sub(self.first_tick);
            self.close_batch(world);
        }
        self.wait_for_disk();
        let status = self.status();
        self.thread.close(status, reply);
    }

    /// The world goes on from another state: ends this file, and begins the next one whose name is free. `None` if that cannot
    /// be written.
    pub(crate) fn next_run(
        self,
        (old, is_sure): (&World, bool),
        name: &str,
        pace: Pace,
        view: View<'_>,
    ) -> Option<Self> {
        let (first, run) = (self.config.clone(), self.run + 1);
        self.stop(old, is_sure, None);
        Self::go_on(first, run, name, pace, view)
    }

    /// Begins the file of this run, or the next one whose name is free. `None` if that cannot be written.
    pub(crate) fn go_on(
        first: RecordConfig,
        mut run: u32,
        name: &str,
        pace: Pace,
        view: View<'_>,
    ) -> Option<Self> {
        let next = loop {
            match Self::begin(first.of_run(run), run, name, pace, view) {
                Err(status) if status.code() == Code::AlreadyExists && run < MAX_RUNS => run += 1,
                next => break next,
            }
        };
        // The number is appended to the first name.
        let next = next.map(|next| Self { config: first, ..next });
        next.map_err(|status| event!(view, error, problem = status.message(), "recording cannot continue"))
            .ok()
    }

    /// The recording, and its place, before the number of a run.
    pub(crate) fn config(&self) -> Option<&RecordConfig> {
        (!self.is_over).then_some(&self.config)
    }

    pub(crate) fn status(&self) -> v1::RecordingStatus {
        let recording =
            if self.run == 1 { self.config.name.clone() } else { self.config.of_run(self.run).name };
        let (bytes, problem) = self.thread.progress();
        v1::RecordingStatus { recording, bytes, ticks: self.ticks, problem: problem.unwrap_or_default() }
    }
}

fn is_hurried(pace: Pace) -> bool {
    matches!(pace, Pace::Timed(_))
}

/// The outputs of brains in a tick that began at this instant.
pub(crate) fn recorded_inputs(
    (tick, start): (u64, SimTime),
    inputs: impl Iterator<Item = Input>,
) -> v1::RecordedInputs {
    let inputs = inputs.map(|input| recorded(start, input)).collect();
    v1::RecordedInputs { tick, changes: Vec::new(), inputs }
}

fn recorded(start: SimTime, input: Input) -> v1::RecordedInput {
    let Input { robot, sensor, at, bytes: data, answers_tick } = input;
    let after_ns = at.as_ns().wrapping_sub(start.as_ns()) as i64;
    let checksum = checksum(after_ns, &data);
    v1::RecordedInput {
        robot: robot as u32,
        after_ns,
        data,
        answers_tick,
        checksum,
        sensor: sensor.map(|i| i as u32),
    }
}

fn described(intervention: &Intervention) -> String {
    match intervention {
        Intervention::PlaceRobot { robot, .. } => format!("`{robot}` was moved"),
        Intervention::PlaceThing { thing, .. } => format!("`{thing}` was moved"),
        Intervention::PullCable { robot, pulled: true } => format!("the cable of `{robot}` was pulled"),
        Intervention::PullCable { robot, pulled: false } => format!("the cable of `{robot}` was plugged in"),
        Intervention::SetBaud { robot, baud } => format!("the cable of `{robot}` was set to {baud} baud"),
        Intervention::OpenPort { robot, port_use } => match port_use {
            PortUse::Open => format!("a serial port was opened for `{robot}`"),
            PortUse::Simulated => format!("a program in simulated time has the serial port of `{robot}`"),
            PortUse::Closed => format!("the serial port of `{robot}` was closed"),
        },
        Intervention::ResetBoard { robot } => {
            format!("a program has opened the port, which has reset the microcontroller of `{robot}`")
        }
    }
}
