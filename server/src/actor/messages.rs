//! Messages as they come, and what becomes of each.

use std::sync::Arc;

use tonic::Status;

use super::{WorldActor, lookahead, view};
use crate::log::event;
use crate::message::Message;
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
    }

    pub(super) fn handle_now(&mut self, message: Message) {
        if !matches!(message, Message::Step(_) | Message::Stop) {
            self.keep();
        }
        match message {
            Message::Request(request, reply) => self.handle_request(request, reply),
            Message::Order(order) => self.record_order(&order),
            Message::Describe(reply) => drop(reply.send(Arc::clone(self.world.scenario()))),
            Message::DescribeReplay(reply) => drop(reply.send(self.recorded())),
            Message::Measure(reply) => drop(reply.send(self.measure())),
            Message::Cover(reply) => drop(reply.send(CoverageReport::of(&self.world))),
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
