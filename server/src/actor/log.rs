//! The events of a world in the operator's log.

use super::WorldActor;
use crate::log::event;
use crate::message::Request;
use crate::quote::list;

impl WorldActor {
    /// Logs what an operator requests, unless that may yet fail or is nothing new.
    pub(super) fn log_request(&self, request: &Request) {
        match request {
            Request::Start if self.pacer.paused => event!(self, info, "world started"),
            Request::Pause if !self.pacer.paused => event!(self, info, "world paused"),
            Request::SetPace(pace) => event!(self, info, ?pace, "pace set"),
            Request::Reset(_) => event!(self, info, "world reset"),
            Request::Delete => event!(self, info, "world deleted"),
            Request::Step { ticks } => event!(self, debug, ticks, "steps requested"),
            Request::Snapshot => event!(self, debug, "snapshot taken"),
            // Such a request is logged when it is done.
            Request::Restore { .. }
            | Request::Intervene(_)
            | Request::DetachBrain { .. }
            | Request::Record(_) => {}
            Request::StopRecording(_) => event!(self, info, "recording stopped"),
            Request::Seek { tick } => event!(self, debug, to_tick = tick, "seek requested"),
            Request::Fork(pace) => event!(self, info, ?pace, "replay made live"),
            Request::Start | Request::Pause | Request::Report | Request::Save { .. } => {}
        }
    }

    /// Logs that a brain has its robots.
    pub(super) fn log_attached(&self, session: u64, robots: &[usize]) {
        let brain = self.sessions.name(session);
        event!(self, info, session, brain, robots = self.names(robots), "brain attached");
    }

    /// Logs that a brain is gone, if it was there.
    pub(super) fn log_detached(&self, session: u64, why: &str) {
        let robots = self.sessions.robots(session);
        if !robots.is_empty() {
            let brain = self.sessions.name(session);
            event!(self, info, session, brain, robots = self.names(robots), why, "brain detached");
        }
    }

    /// The names of robots, as a text.
    fn names(&self, robots: &[usize]) -> String {
        let specs = &self.world.scenario().robots;
        list(robots.iter().map(|&robot| specs[robot].name.as_str()))
    }
}
