//! What of a world goes into its recording.

use baudbot_proto::v1::ReplayEventKind;
use baudbot_sim::{Intervention, SimTime, World};
use tokio::sync::oneshot;
use tonic::Status;

use super::Host;
use crate::letter::RecordingReport;
use crate::observers::View;
use crate::recording::{RecordConfig, Recorder};

impl Host {
    /// Begins to record.
    pub(crate) fn record(&mut self, config: RecordConfig) -> Result<(), Status> {
        if let Some(recorder) = &self.recorder {
            let text = format!("world: `{}` is being recorded as `{}`", self.name, recorder.report().name);
            return Err(Status::failed_precondition(text));
        }
        let view =
            View { name: &self.name, world: &self.world, sessions: &self.sessions, beliefs: &self.beliefs };
        self.recorder = Some(Recorder::start(config, &self.name, self.pace, view)?);
        Ok(())
    }

    /// `told` learns how the file is once it is closed. Gives the world as the file ends with it: its tick begun,
    /// whether it was or not.
    pub(super) fn stop_recording(&mut self, told: oneshot::Sender<RecordingReport>) -> Result<World, Status> {
        let none = || Status::failed_precondition(format!("world: `{}` is not being recorded", self.name));
        let recorder = self.recorder.take().ok_or_else(none)?;
        let mut last = self.world.clone();
        last.begin();
        recorder.stop(&self.world, !self.sessions.is_behind(), Some(told));
        Ok(last)
    }

    /// The world is over, and waits until its file is.
    pub(super) fn end_recording(&mut self) {
        let Some(recorder) = self.recorder.take() else { return };
        recorder.stop(&self.world, !self.sessions.is_behind(), None);
    }

    /// The tick has begun.
    pub(super) fn record_begun(&mut self) {
        let is_sure = !self.sessions.is_behind();
        let view =
            View { name: &self.name, world: &self.world, sessions: &self.sessions, beliefs: &self.beliefs };
        if let Some(recorder) = &mut self.recorder {
            recorder.begun(view, is_sure);
        }
    }

    /// The tick is over that began so, without the answers of some robots.
    pub(super) fn record_inputs(&mut self, began: (u64, SimTime), open: &[(usize, SimTime)]) {
        for &(robot, _) in open {
            self.behind_since[robot] = began.0;
        }
        if let Some(recorder) = &mut self.recorder {
            let inputs = self.inputs.drain(..);
            recorder.inputs(began, inputs.map(|p| (p.robot, p.at, p.bytes, p.tick)));
        }
    }

    /// A brain that was left behind has answered.
    pub(super) fn record_late(&mut self, robot: usize, done: SimTime, bytes: Vec<u8>) {
        let Some(recorder) = &mut self.recorder else { return };
        let tick = self.behind_since[robot];
        let start = SimTime::from_ns(tick * self.world.scenario().step_ns());
        recorder.inputs((tick, start), [(robot, done, bytes, None)].into_iter());
    }

    pub(super) fn record_change(&mut self, intervention: &Intervention) {
        if let Some(recorder) = &mut self.recorder {
            recorder.change(self.world.tick(), intervention);
        }
    }

    /// A brain has come.
    pub(super) fn record_come(&mut self, robots: &[usize], brain: &str) {
        if let Some(recorder) = &mut self.recorder {
            let text = format!("`{brain}` drives {}", names(&self.world, robots));
            recorder.event(self.world.tick(), ReplayEventKind::Brain, text);
        }
    }

    /// A brain is gone.
    pub(super) fn record_gone(&mut self, session: u64, why: &str) {
        let robots = self.sessions.robots(session);
        if let Some(recorder) = &mut self.recorder
            && !robots.is_empty()
        {
            let text = format!("the brain of {} is gone: {why}", names(&self.world, robots));
            recorder.event(self.world.tick(), ReplayEventKind::Brain, text);
        }
    }

    /// The world was reset or restored: another file begins.
    pub(super) fn record_anew(&mut self, old: &World) {
        let view =
            View { name: &self.name, world: &self.world, sessions: &self.sessions, beliefs: &self.beliefs };
        let (recorder, old) = (self.recorder.take(), (old, !self.sessions.is_behind()));
        self.recorder = recorder.and_then(|recorder| recorder.begin_anew(old, &self.name, self.pace, view));
    }
}

fn names(world: &World, robots: &[usize]) -> String {
    let name = |&robot: &usize| format!("`{}`", world.scenario().robots()[robot].name);
    robots.iter().take(MAX_NAMES).map(name).collect::<Vec<_>>().join(", ")
}

/// Robots that an event names.
const MAX_NAMES: usize = 20;
