//! What the log says of a world.

use super::Host;
use crate::letter::Order;
use crate::log::event;
use crate::words::list;

impl Host {
    /// Says what an operator orders, unless that may yet fail or is nothing new.
    pub(super) fn log_order(&self, order: &Order) {
        match order {
            Order::Start if self.paused => event!(self, info, "world started"),
            Order::Pause if !self.paused => event!(self, info, "world paused"),
            Order::SetPace(pace) => event!(self, info, ?pace, "pace set"),
            Order::Reset => event!(self, info, "world reset"),
            Order::Delete => event!(self, info, "world deleted"),
            Order::Step { ticks } => event!(self, debug, ticks, "steps ordered"),
            Order::Snapshot => event!(self, debug, "snapshot taken"),
            // These say so themselves.
            Order::Restore { .. } | Order::Intervene(_) | Order::DetachBrain { .. } | Order::Record(_) => {}
            Order::StopRecording(_) => event!(self, info, "recording stopped"),
            Order::Seek { tick } => event!(self, debug, to_tick = tick, "another tick ordered"),
            Order::Fork(pace) => event!(self, info, ?pace, "replay made live"),
            Order::Start | Order::Pause | Order::Report | Order::Save { .. } => {}
        }
    }

    /// Says that a brain has its robots.
    pub(super) fn log_attached(&self, session: u64, robots: &[usize]) {
        let brain = self.sessions.name(session);
        event!(self, info, session, brain, robots = self.names(robots), "brain attached");
    }

    /// Says that a brain is gone, if it was there.
    pub(super) fn log_detached(&self, session: u64, why: &str) {
        let robots = self.sessions.robots(session);
        if !robots.is_empty() {
            let brain = self.sessions.name(session);
            event!(self, info, session, brain, robots = self.names(robots), why, "brain detached");
        }
    }

    /// The names of robots, for people.
    fn names(&self, robots: &[usize]) -> String {
        let specs = self.world.scenario().robots();
        list(robots.iter().map(|&robot| specs[robot].name.as_str()))
    }
}
