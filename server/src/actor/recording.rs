//! The recording of a world: what of it goes into the file.

use baudbot_proto::v1::{RecordedInputs, RecordingStatus, ReplayEventKind};
use baudbot_sim::{Intervention, SimTime, World};
use tokio::sync::oneshot;
use tonic::Status;

use super::ports::ToDevice;
use super::{Pending, WorldActor, view};
use crate::log::event;
use crate::message::{Order, RecordConfig};
use crate::pace::Pace;
use crate::recording::{Input, Recorder, recorded_inputs};
use crate::report::Report;

/// Robots that an event names, at most.
const MAX_NAMES: usize = 20;

/// The recording of a world, if there is one.
pub(super) struct Recording {
    recorder: Option<Recorder>,
    /// The tick in which the brain of each robot was last overtaken.
    overtaken_in: Vec<u64>,
}

impl Recording {
    /// None yet, of a world of so many robots.
    pub(super) fn new(robots: usize) -> Self {
        Self { recorder: None, overtaken_in: vec![0; robots] }
    }

    pub(super) fn is_on(&self) -> bool {
        self.recorder.is_some()
    }

    /// Whether the recorder wants to see the world in the tick that comes, which must not be ahead of its brains then.
    pub(super) fn looks(&self) -> bool {
        self.recorder.as_ref().is_some_and(Recorder::looks)
    }

    /// Whether frames of the world are recorded.
    pub(super) fn has_frames(&self) -> bool {
        self.recorder.as_ref().is_some_and(Recorder::has_frames)
    }

    /// Whether something waits for the disk.
    pub(super) fn is_stuck(&self) -> bool {
        self.recorder.as_ref().is_some_and(Recorder::is_stuck)
    }

    /// Waits for the disk, if something does.
    pub(super) fn wait_for_disk(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.wait_for_disk();
        }
    }

    pub(super) fn set_pace(&mut self, pace: Pace) {
        if let Some(recorder) = &mut self.recorder {
            recorder.set_pace(pace);
        }
    }

    /// The recording, and its place.
    pub(super) fn config(&self) -> Option<&RecordConfig> {
        self.recorder.as_ref().and_then(Recorder::config)
    }

    pub(super) fn status(&self) -> Option<RecordingStatus> {
        self.recorder.as_ref().map(Recorder::status)
    }
}

impl WorldActor {
    /// Begins to record.
    pub(super) fn record(&mut self, config: RecordConfig) -> Result<(), Status> {
        if let Some(recorder) = &self.recording.recorder {
            let text =
                format!("world: `{}` is being recorded as `{}`", self.name, recorder.status().recording);
            return Err(Status::failed_precondition(text));
        }
        self.recording.recorder = Some(Recorder::start(config, &self.name, self.pacer.pace, view!(self))?);
        self.fit_timeline();
        Ok(())
    }

    /// Goes on with a recording that its server has left, in the next file whose name is free.
    pub(super) fn record_on(&mut self, config: RecordConfig) {
        let name = config.name.clone();
        self.recording.recorder = Recorder::go_on(config, 2, &self.name, self.pacer.pace, view!(self));
        if self.recording.is_on() {
            event!(self, info, recording = name, "recording continues in another file");
        }
        self.fit_timeline();
    }

    /// Ends the recording; `closed` gets its status once the file is closed. Reports the world as the file ends with it: its
    /// tick has begun, whether it had or not.
    pub(super) fn stop_recording(
        &mut self,
        closed: oneshot::Sender<RecordingStatus>,
    ) -> Result<Report, Status> {
        let none = || Status::failed_precondition(format!("world: `{}` is not being recorded", self.name));
        let mut recorder = self.recording.recorder.take().ok_or_else(none)?;
        recorder.thinking(&self.world, &self.sessions);
        let mut last = self.world.clone();
        last.begin();
        recorder.stop(&self.world, !self.sessions.is_any_overtaken(), Some(closed));
        Ok(Report { world: last, ..self.report(0) })
    }

    /// The world is over, and waits until its file is closed.
    pub(super) fn end_recording(&mut self) {
        let Some(mut recorder) = self.recording.recorder.take() else { return };
        recorder.thinking(&self.world, &self.sessions);
        recorder.stop(&self.world, !self.sessions.is_any_overtaken(), None);
    }

    /// Shows how a tick begins, before it does: to observers, and in the recording.
    pub(super) fn show_start(&mut self) {
        if let Some(recorder) = &mut self.recording.recorder {
            recorder.look(view!(self));
        }
        self.observers.show(view!(self));
    }

    /// Records a tick that has begun.
    pub(super) fn record_tick(&mut self) {
        let is_sure = !self.sessions.is_any_overtaken();
        if let Some(recorder) = &mut self.recording.recorder {
            recorder.tick(view!(self), is_sure);
        }
    }

    /// Records what was written in a tick that began so, without the answers of the robots in `open`.
    pub(super) fn record_inputs(&mut self, (tick, start): (u64, SimTime), open: &[(usize, SimTime)]) {
        for &(robot, _) in open {
            self.recording.overtaken_in[robot] = tick;
        }
        if self.records() {
            let within = std::mem::take(&mut self.ports.within);
            let robots = &self.world.scenario().robots;
            let inputs = self.ports.inputs.drain(..).map(|Pending { robot, at, sent, tick }| {
                let bytes = sent.into_bytes(&robots[robot]);
                Input { robot, sensor: None, at, bytes, answers_tick: tick }
            });
            let to_devices = self.ports.to_devices.drain(..).map(|ToDevice { robot, sensor, at, bytes }| {
                Input { robot, sensor: Some(sensor), at, bytes, answers_tick: None }
            });
            let inputs = recorded_inputs((tick, start), within.into_iter().chain(inputs).chain(to_devices));
            self.record_all(inputs);
        }
    }

    /// Whether inputs are recorded.
    pub(super) fn records(&self) -> bool {
        self.recording.is_on() || self.state.is_kept()
    }

    /// Records the answer of a brain that was overtaken.
    pub(super) fn record_late(&mut self, robot: usize, done: SimTime, bytes: Vec<u8>) {
        if !self.recording.is_on() {
            return;
        }
        let tick = self.recording.overtaken_in[robot];
        let start = SimTime::from_ns(tick * self.world.scenario().step_ns);
        let input = Input { robot, sensor: None, at: done, bytes, answers_tick: None };
        self.record_all(recorded_inputs((tick, start), std::iter::once(input)));
    }

    fn record_all(&mut self, inputs: RecordedInputs) {
        if inputs.inputs.is_empty() {
            return;
        }
        self.state.inputs(&inputs);
        if let Some(recorder) = &mut self.recording.recorder {
            recorder.inputs(inputs);
        }
    }

    pub(super) fn record_change(&mut self, intervention: &Intervention) {
        self.state.change(self.world.tick(), intervention);
        if let Some(recorder) = &mut self.recording.recorder {
            recorder.change(self.world.tick(), intervention);
        }
    }

    /// Records who is going to request what.
    pub(super) fn record_order(&mut self, Order { by, what }: &Order) {
        if let Some(recorder) = &mut self.recording.recorder {
            recorder.event(self.world.tick(), ReplayEventKind::Order, format!("{by} {what}"));
        }
    }

    /// Records that a brain has these robots; `by` is the name of the token that it has shown.
    pub(super) fn record_attached(&mut self, robots: &[usize], brain: &str, by: Option<&str>) {
        if let Some(recorder) = &mut self.recording.recorder {
            let by = by.map(|by| format!(" (token {by})")).unwrap_or_default();
            let text = format!("`{brain}` drives {}{by}", names(&self.world, robots));
            recorder.event(self.world.tick(), ReplayEventKind::Brain, text);
        }
    }

    /// Records that a brain goes.
    pub(super) fn record_detached(&mut self, session: u64, why: &str) {
        let robots = self.sessions.robots(session);
        if let Some(recorder) = &mut self.recording.recorder
            && !robots.is_empty()
        {
            let text = format!("the brain of {} is gone: {why}", names(&self.world, robots));
            recorder.event(self.world.tick(), ReplayEventKind::Brain, text);
        }
    }

    /// The world was reset or restored: the recording continues in another file.
    pub(super) fn record_next_run(&mut self, old: &World) {
        let Some(mut recorder) = self.recording.recorder.take() else { return };
        recorder.thinking(old, &self.sessions);
        let old = (old, !self.sessions.is_any_overtaken());
        self.recording.recorder = recorder.next_run(old, &self.name, self.pacer.pace, view!(self));
    }
}

fn names(world: &World, robots: &[usize]) -> String {
    let name = |&robot: &usize| format!("`{}`", world.scenario().robots[robot].name);
    robots.iter().take(MAX_NAMES).map(name).collect::<Vec<_>>().join(", ")
}
