//! Messages as they come, and what becomes of each.

use std::sync::Arc;

use tonic::Status;

use super::{WorldActor, lookahead, view};
use crate::log::event;
use crate::message::{Message, Request};
use crate::report::CoverageReport;

impl WorldActor {
    /// Handles a message, or defers it if it would see the world and the world is ahead of its brains.
    pub(super) fn handle(&mut self, message: Message) {
        if self.sessions.is_any_overtaken() && lookahead::sees_world(&message) {
            self.deferred.push_back(message);
            return;
        }
        self.handle_now(message);
        self.handle_deferred();
        self.answer_halts();
    }

    pub(super) fn handle_now(&mut self, message: Message) {
        if !matches!(message, Message::Step(_) | Message::Stop) {
            self.keep();
        }
        self.changes += u64::from(changes_status(&message));
        match message {
            Message::Request(request, reply) => self.handle_request(request, reply),
            Message::Order(order) => self.record_order(&order),
            Message::Describe(reply) => drop(reply.send(Arc::clone(self.world.scenario()))),
            Message::DescribeReplay(reply) => drop(reply.send(self.recorded())),
            Message::Measure(reply) => drop(reply.send(self.measure())),
            Message::Cover(reply) => drop(reply.send(CoverageReport::of(&self.world, self.sessions.era()))),
            Message::Stand(known, reply) => {
                let standing = self.standing(known.as_ref());
                if standing.report.is_some() {
                    self.keep_now();
                }
                drop(reply.send(standing));
            }
            Message::Watch(watch) => {
                self.observers.keep_pins(Some(&watch), &mut self.world);
                self.observers.add(watch, view!(self));
                self.fit_timeline();
            }
            Message::WatchCable(watch) => self.cables.add(watch, &mut self.world),
            Message::Attach(request, reply) => self.attach(request, reply),
            Message::Step(step) => self.take_step(step),
            Message::Detach { session, why } => {
                let owed = self.sessions.take_overtaken(session);
                self.let_go(session, &why, &owed);
                self.sessions.detach(session, self.policy());
            }
            Message::Stop => {
                event!(self, info, "world over, since its server stops");
                // UNAVAILABLE, as a server at the same address may have the same world in a moment.
                self.over =
                    Some(Status::unavailable(format!("world `{}` is over, as its server stops", self.name)));
            }
        }
    }
}

/// Whether the status for operators changes by this message, before the next tick. Changes by a Step are reported with
/// the tick, unless its stream ends.
fn changes_status(message: &Message) -> bool {
    match message {
        Message::Request(Request::Report | Request::Save { .. }, _)
        | Message::Order(_)
        | Message::Describe(_)
        | Message::DescribeReplay(_)
        | Message::Measure(_)
        | Message::Cover(_)
        | Message::Stand(..)
        | Message::Watch(_)
        | Message::WatchCable(_)
        | Message::Step(_) => false,
        Message::Request(..) | Message::Attach(..) | Message::Detach { .. } | Message::Stop => true,
    }
}
