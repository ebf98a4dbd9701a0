//! Recordings of worlds: what a world's own thread does for one, which is little.
//!
//! It collects what entered the world and, now and then, a fingerprint, a state and what an observer would see. A thread
//! of the recording's own ([`scribe`]) makes messages of that and writes them. What is collected goes to that thread in
//! bundles, since to wake it takes longer than to collect a tick.

mod folder;
mod scribe;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_recording::{Digests, RecordingFile, checksum, header, saved};
use baudbot_sim::{Intervention, SimTime, World};
use tokio::sync::oneshot;
use tonic::{Code, Status};

use crate::convert;
use crate::letter::{Frame, RecordingReport};
use crate::log::event;
use crate::observers::{Eye, View};
use crate::pace::Pace;
pub(crate) use folder::Folder;
use scribe::{Scribe, Sent};

/// Where a world is recorded, and what beside its inputs.
#[derive(Clone, Debug)]
pub(crate) struct RecordConfig {
    /// What people call it.
    pub(crate) name: String,
    /// Where there is no file yet.
    pub(crate) path: PathBuf,
    /// Frames a simulated second of what an observer sees; 0 for none.
    pub(crate) look_hz: f64,
}

impl RecordConfig {
    /// What comes after a reset: `run.mcap`, then `run-2.mcap`.
    fn next(&self, life: u32) -> Self {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = self.path.with_file_name(format!("{stem}-{life}.mcap"));
        Self { name: format!("{}-{life}", self.name), path, ..self.clone() }
    }
}

/// Something that is to be recorded.
pub(crate) enum Entry {
    /// What brains wrote in a tick.
    Inputs(v1::RecordedInputs),
    Mark(v1::RecordedMark),
    State(v1::RecordedState),
    Event(v1::RecordedEvent),
    Frame(Box<Frame>),
}

/// A recording that is being made, as its world's thread has it.
pub(crate) struct Recorder {
    config: RecordConfig,
    /// How often the world has begun anew since it was asked for.
    life: u32,
    scribe: Scribe,
    /// The world follows a clock, and does not wait for the disk.
    is_hurried: bool,
    /// Nothing is recorded any more, as something went wrong.
    is_over: bool,
    bundle: Vec<Entry>,
    /// What the scribe had no room for.
    backlog: Vec<Vec<Entry>>,
    digests: Digests,
    first_tick: u64,
    ticks: u64,
    state_tick: u64,
    marked: Instant,
    /// What the last mark took.
    mark_takes: Duration,
    /// Looks at the world every so many ticks.
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
        life: u32,
        name: &str,
        pace: Pace,
        View { world, .. }: View<'_>,
    ) -> Result<Self, Status> {
        let file = RecordingFile::create(&config.path);
        let file = file.map_err(|error| cannot_write(&config.path, &error))?;
        let scenario = world.scenario();
        let header = header(name, world.origin(), Some(convert::pace_to(pace)));
        let described = || (world.time().as_ns(), convert::world_description(scenario));
        let described = (config.look_hz > 0.0).then(described);
        let scribe = Scribe::start(file, header, described)?;
        let every = (config.look_hz > 0.0).then(|| {
            let ticks = 1e9 / config.look_hz / scenario.step_ns() as f64;
            (Eye::of_all(world), ticks.round().max(1.0) as u64)
        });
        let mut recorder = Self {
            config,
            life,
            scribe,
            is_hurried: is_hurried(pace),
            is_over: false,
            backlog: Vec::new(),
            bundle: vec![Entry::State(saved::state(world))],
            digests: Digests::default(),
            first_tick: world.tick(),
            ticks: 0,
            state_tick: world.tick(),
            marked: Instant::now(),
            mark_takes: Duration::ZERO,
            eye: every,
        };
        recorder.close_bundle(world);
        Ok(recorder)
    }

    /// A last mark, so that the file has all until here.
    fn close_bundle(&mut self, world: &World) {
        self.bundle.push(Entry::Mark(self.digests.last_mark(world)));
        self.send();
    }

    /// Whether it wants to see the world in the tick that comes, which must not be ahead of its brains then.
    pub(crate) fn looks(&self) -> bool {
        !self.is_over && (self.eye.is_some() || self.is_mark_due())
    }

    /// The world has another pace.
    pub(crate) fn set_pace(&mut self, pace: Pace) {
        self.is_hurried = is_hurried(pace);
    }

    /// A mark takes at most a hundredth of the time, if a second is enough for that.
    fn is_mark_due(&self) -> bool {
        let interval = (self.mark_takes * 100).clamp(MARK_EVERY, MARK_AT_LAST);
        self.digests.ticks() >= MARK_EVERY_TICKS || self.marked.elapsed() >= interval
    }

    /// A tick has begun. `is_sure`: no brain has yet to answer an earlier one.
    pub(crate) fn begun(&mut self, view: View<'_>, is_sure: bool) {
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
        if let Some((eye, every)) = &mut self.eye {
            eye.note(world);
            if world.tick().is_multiple_of(*every) || ended.is_some() {
                self.bundle.push(Entry::Frame(Box::new(eye.frame(view))));
            }
        }
        if is_sure && (self.is_mark_due() || ended.is_some()) {
            self.mark(world);
        } else if self.bundle.len() >= BUNDLE {
            self.send();
        }
    }

    fn mark(&mut self, world: &World) {
        let began = Instant::now();
        if world.tick() >= self.state_tick + STATE_EVERY_TICKS {
            self.state_tick = world.tick();
            self.bundle.push(Entry::State(saved::state(world)));
        }
        self.bundle.push(Entry::Mark(self.digests.mark(world)));
        self.marked = Instant::now();
        self.mark_takes = self.marked - began;
        self.send();
    }

    /// What brains wrote in a tick that began at this instant: robot, when, bytes, and the tick that it answers if that
    /// is known.
    pub(crate) fn inputs(
        &mut self,
        (tick, start): (u64, SimTime),
        inputs: impl Iterator<Item = (usize, SimTime, Vec<u8>, Option<u64>)>,
    ) {
        if self.is_over {
            return;
        }
        let inputs: Vec<_> = inputs.map(|input| recorded(start, input)).collect();
        if !inputs.is_empty() {
            self.bundle.push(Entry::Inputs(v1::RecordedInputs { tick, changes: Vec::new(), inputs }));
        }
    }

    /// A change by hand before this tick.
    pub(crate) fn change(&mut self, tick: u64, intervention: &Intervention) {
        if self.is_over {
            return;
        }
        let changes = vec![baudbot_recording::change(intervention)];
        self.event(tick, v1::ReplayEventKind::Change, words(intervention));
        self.bundle.push(Entry::Inputs(v1::RecordedInputs { tick, changes, inputs: Vec::new() }));
    }

    /// Something happened.
    pub(crate) fn event(&mut self, tick: u64, kind: v1::ReplayEventKind, text: String) {
        if self.is_over {
            return;
        }
        self.bundle.push(Entry::Event(v1::RecordedEvent { tick, kind: kind.into(), text }));
    }

    fn send(&mut self) {
        let bundle = std::mem::replace(&mut self.bundle, Vec::with_capacity(BUNDLE));
        if self.is_over {
            return;
        }
        if !self.backlog.is_empty() {
            self.backlog.push(bundle);
        } else if let Sent::Full(bundle) = self.scribe.send(bundle) {
            self.backlog.push(bundle);
        }
        if self.is_hurried && self.is_stuck() {
            self.backlog.clear();
            self.scribe.fail("the disk is slower than the world, which follows the clock");
        }
        self.is_over = self.scribe.progress().1.is_some();
    }

    /// Whether something waits for the disk. Then the world does, if it does not follow a clock.
    pub(crate) fn is_stuck(&self) -> bool {
        !self.backlog.is_empty()
    }

    /// Waits for the disk; on the world's own thread.
    pub(crate) fn wait_for_disk(&mut self) {
        self.backlog.drain(..).for_each(|bundle| self.scribe.send_at_last(bundle));
    }

    /// Ends it as the world stands, between two ticks or within one; `reply` learns how the file is when it is closed.
    /// `is_sure`: no brain has yet to answer. Otherwise the file ends with the last mark.
    pub(crate) fn stop(
        mut self,
        world: &World,
        is_sure: bool,
        reply: Option<oneshot::Sender<RecordingReport>>,
    ) {
        if !self.is_over && is_sure {
            self.ticks = world.tick().saturating_sub(self.first_tick);
            self.close_bundle(world);
        }
        self.wait_for_disk();
        let report = self.report();
        self.scribe.close(report, reply);
    }

    /// The world goes on from another state: this recording is over, and the next begins, in the next file that is not
    /// there yet.
    pub(crate) fn begin_anew(
        self,
        (old, is_sure): (&World, bool),
        name: &str,
        pace: Pace,
        view: View<'_>,
    ) -> Option<Self> {
        let (first, mut life) = (self.config.clone(), self.life + 1);
        self.stop(old, is_sure, None);
        let next = loop {
            match Self::begin(first.next(life), life, name, pace, view) {
                Err(status) if status.code() == Code::AlreadyExists && life < MAX_LIVES => life += 1,
                next => break next,
            }
        };
        // The number is counted from the first name.
        let next = next.map(|next| Self { config: first, ..next });
        next.map_err(|status| event!(view, error, problem = status.message(), "recording ended by a reset"))
            .ok()
    }

    /// How it goes.
    pub(crate) fn report(&self) -> RecordingReport {
        let name = if self.life == 1 { self.config.name.clone() } else { self.config.next(self.life).name };
        let (bytes, problem) = self.scribe.progress();
        RecordingReport { name, bytes, ticks: self.ticks, problem }
    }
}

fn is_hurried(pace: Pace) -> bool {
    matches!(pace, Pace::Timed(_))
}

fn recorded(
    start: SimTime,
    (robot, at, data, answers_tick): (usize, SimTime, Vec<u8>, Option<u64>),
) -> v1::RecordedInput {
    let after_ns = at.as_ns().wrapping_sub(start.as_ns()) as i64;
    let checksum = checksum(after_ns, &data);
    v1::RecordedInput { robot: robot as u32, after_ns, data, answers_tick, checksum }
}

fn words(intervention: &Intervention) -> String {
    match intervention {
        Intervention::PlaceRobot { robot, .. } => format!("`{robot}` was put somewhere else"),
        Intervention::PlaceThing { thing, .. } => format!("`{thing}` was put somewhere else"),
        Intervention::PullCable { robot, pulled: true } => format!("the cable of `{robot}` was pulled"),
        Intervention::PullCable { robot, pulled: false } => format!("the cable of `{robot}` was plugged in"),
        Intervention::SetBaud { robot, baud } => format!("the cable of `{robot}` was set to {baud} baud"),
    }
}

/// An error that says which file and why.
pub(crate) fn cannot_write(path: &Path, error: &std::io::Error) -> Status {
    let text = format!("recording: cannot write {}: {error}", path.display());
    match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            let path = path.display();
            Status::already_exists(format!(
                "recording: {path} is there already, and no file is replaced; name another, or delete it"
            ))
        }
        _ => Status::failed_precondition(text),
    }
}

/// What was recorded as far as this, by the wall clock, is not lost if the program is killed; twice as often as
/// promised, since it has to be written yet.
const MARK_EVERY: Duration = Duration::from_millis(400);

/// Of a world that runs much faster than the clock, so that what is lost by a full disk is little.
const MARK_EVERY_TICKS: u64 = 2000;

/// However long a mark takes.
const MARK_AT_LAST: Duration = Duration::from_millis(800);

/// From state to state, who replays simulates so many ticks.
const STATE_EVERY_TICKS: u64 = 6000;

/// Files of one recording.
const MAX_LIVES: u32 = 100_000;

/// Entries that go to the scribe at once.
const BUNDLE: usize = 512;

/// Collisions of a tick that are told one by one.
const MAX_COLLISIONS: usize = 100;

/// A tape that is shared.
pub(crate) type SharedTape = Arc<baudbot_recording::Tape>;
