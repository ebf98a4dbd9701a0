//! Manual changes: an operator moves a robot, or pulls its cable.

use baudbot_sim::{Intervention, InterventionError};
use tonic::Status;

use super::{Phase, WorldActor, view};
use crate::log::event;
use crate::message::{Message, Reply, Request};
use crate::quote::brief;
use crate::report::Report;

/// Changes that wait for the end of the tick, at most.
const MAX_INTERVENTIONS: usize = 64;

/// Changes that wait for the end of the tick, each with its reply.
#[derive(Default)]
pub(super) struct Interventions(Vec<(Intervention, Reply<Report>)>);

impl Interventions {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl WorldActor {
    /// Makes a change as soon as no tick is under way, and then replies.
    pub(super) fn request_intervention(&mut self, intervention: Intervention, reply: Reply<Report>) {
        if self.interventions.0.len() >= MAX_INTERVENTIONS {
            let text = format!(
                "intervention: {MAX_INTERVENTIONS} interventions wait for the end of the tick, which is the limit"
            );
            return drop(reply.send(Err(Status::resource_exhausted(text))));
        }
        self.interventions.0.push((intervention, reply));
        if self.phase != Phase::Begun {
            self.intervene();
        }
    }

    /// Makes all changes that wait, now that no tick is under way.
    pub(super) fn intervene(&mut self) {
        let mut any = false;
        for (intervention, reply) in std::mem::take(&mut self.interventions.0) {
            if reply.is_closed() {
                continue; // its client is gone
            }
            let done = self.world.intervene(&intervention);
            event!(self, debug, ?intervention, done = done.is_ok(), "manual change");
            any |= done.is_ok();
            if done.is_ok() {
                self.record_change(&intervention);
                self.keep_now();
            }
            let answer = done.map(|()| self.report(0)).map_err(|error| refused(&error));
            drop(reply.send(answer));
        }
        if any {
            self.changes += 1;
            self.observers.show_now(view!(self));
        }
    }

    /// Refuses all changes that wait: they were meant for the world as it was.
    pub(super) fn drop_interventions(&mut self) {
        let gone =
            || Err(Status::aborted("intervention: the world was reset or restored before it took effect"));
        for message in std::mem::take(&mut self.deferred) {
            if let Message::Request(Request::Intervene(_), reply) = message {
                drop(reply.send(gone()));
            } else {
                self.deferred.push_back(message);
            }
        }
        for (_, reply) in std::mem::take(&mut self.interventions.0) {
            drop(reply.send(gone()));
        }
    }
}

fn refused(error: &InterventionError) -> Status {
    let text = format!("intervention: {}", brief(&error.to_string()));
    match error {
        InterventionError::Unknown { .. } => Status::not_found(text),
        // The actor changes nothing within a tick, so the state was restored.
        InterventionError::WithinTick => Status::failed_precondition(format!(
            "{text}: the restored state was saved within a tick; it can be changed after a step"
        )),
        InterventionError::Place { .. } | InterventionError::Baud { .. } => Status::invalid_argument(text),
        InterventionError::Ended
        | InterventionError::NoRoom { .. }
        | InterventionError::NoCable { .. }
        | InterventionError::TooOften { .. } => Status::failed_precondition(text),
    }
}
