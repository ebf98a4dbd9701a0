//! Ticks one by one: the stepped pace.

use super::{Phase, WorldActor};
use crate::message::Reply;
use crate::pace::Pace;
use crate::report::Report;
use tonic::Status;

/// The ticks that a StepWorld has asked for.
#[derive(Default)]
pub(super) struct Stepper {
    /// Ticks that are still to be done.
    pub(super) credits: u64,
    /// The reply when they are.
    reply: Option<Reply<Report>>,
}

impl Stepper {
    /// Whether a client waits for the ticks.
    fn is_wanted(&self) -> bool {
        self.reply.as_ref().is_some_and(|reply| !reply.is_closed())
    }
}

impl WorldActor {
    /// Does so many ticks, and then replies.
    pub(super) fn step(&mut self, ticks: u64, reply: Reply<Report>) {
        if let Err(status) = self.check_step() {
            return drop(reply.send(Err(status)));
        }
        self.pacer.paused = false;
        self.stepper = Stepper { credits: ticks.max(1), reply: Some(reply) };
    }

    fn check_step(&self) -> Result<(), Status> {
        let refused = |text: String| Err(Status::failed_precondition(text));
        if !matches!(self.pacer.pace, Pace::Stepped(_)) {
            return refused("the world's pace is not stepped; set it with SetPace".into());
        }
        if let Some(ending) = self.world.ending() {
            return refused(format!("the run has ended ({ending}); reset or restore the world"));
        }
        if self.is_at_replays_end() {
            let text = "the recording ends here; seek an earlier tick, or continue live with ForkReplay";
            return refused(text.into());
        }
        if self.replaying.is_none() && self.phase != Phase::Begun && self.sessions.is_any_awaited() {
            let text = "a robot has no brain, and the world waits for one; attach one, or continue \
                        without it by StartWorld";
            return refused(text.into());
        }
        if self.stepper.is_wanted() {
            return refused(format!(
                "world: `{}` is running another StepWorld, with {} ticks left; wait for it, or end it with PauseWorld",
                self.name, self.stepper.credits
            ));
        }
        Ok(())
    }

    /// Whether the world stands because it does only the ticks that are asked for.
    pub(super) fn is_out_of_credit(&self) -> bool {
        matches!(self.pacer.pace, Pace::Stepped(_)) && self.stepper.credits == 0
    }

    /// A tick is done. If the client of a StepWorld is gone, the ticks that are left are not done.
    pub(super) fn spend_credit(&mut self) {
        let left = self.stepper.credits.saturating_sub(1);
        self.stepper.credits = if self.stepper.is_wanted() { left } else { 0 };
    }

    /// Does no further ticks for a StepWorld.
    pub(super) fn end_stepping(&mut self) {
        self.stepper.credits = 0;
        // Within a tick, at its end.
        if self.phase == Phase::Between {
            self.answer_stepper();
        }
    }

    pub(super) fn answer_stepper(&mut self) {
        if let Some(reply) = self.stepper.reply.take() {
            self.keep_now();
            drop(reply.send(Ok(self.report(0))));
        }
    }
}
