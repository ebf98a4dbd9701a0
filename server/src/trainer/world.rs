//! A world of a trainer's stream.

use baudbot_proto::v1;
use baudbot_proto::v1::world_result::Outcome;
use tokio::sync::mpsc;
use tonic::{Code, Status};

use crate::brain_link::{CheckedStep, Steps, TURNS_AHEAD, check, take_robots};
use crate::control::scenario_of_reset;
use crate::convert;
use crate::message::{Lease, Recipient, Request, Told, Truth, WorldHandle};
use crate::registry::Registry;
use crate::sessions::RESERVED;

/// A world whose robots the trainer holds.
pub(super) struct Trained {
    world: WorldHandle,
    steps: Steps,
    told: mpsc::Receiver<Told>,
    /// The Welcome until it has been sent.
    welcome: Option<v1::Welcome>,
    /// The hold on the robots, or the reason why they were released.
    hold: Result<Hold, Status>,
    /// The reason why the last action was not done.
    refusal: Option<Status>,
    /// Responses from before this era are void: the trainer has reset the world since.
    era: u64,
    /// The number of each robot's collisions at the last report to the trainer, and its era; `None` before that.
    collisions: Option<(u64, Vec<u64>)>,
}

/// The hold of robots, and the last result for the trainer.
struct Hold {
    lease: Lease,
    /// The number of the Turn that is to be answered; `None` before the first, and once the run is over.
    turn: Option<u64>,
}

/// Takes a world back to its start. Gives the era that begins with that.
///
/// # Errors
/// Why not, with the field of the request.
pub(super) async fn reset(world: &WorldHandle, request: v1::ResetWorldRequest) -> Result<u64, Status> {
    let (scenario, _held) = scenario_of_reset(world, request).await?;
    Ok(world.request(Request::Reset(scenario)).await?.era)
}

impl Trained {
    /// Takes the robots of a Hello; all of its world if it names none.
    ///
    /// # Errors
    /// Why they cannot be had, with the field of the Hello.
    pub(super) async fn open(registry: &Registry, mut hello: v1::Hello) -> Result<Self, Status> {
        let world = registry.find("world", &hello.world)?;
        if hello.robots.is_empty() {
            // A world has the same robots all its life.
            hello.robots = world.made().robots.iter().map(|spec| spec.name.clone()).collect();
        }
        let mode = check(&hello)?;
        let (recipient, told) = mpsc::channel(TURNS_AHEAD + RESERVED);
        let attached = take_robots(&world, hello, mode, Recipient::Trainer(recipient)).await?;
        if !attached.lockstep {
            return Err(Status::failed_precondition(format!(
                "world: `{}` is not in lockstep; set its pace with SetPace",
                world.name()
            )));
        }
        let (steps, welcome) = (Steps::new(&attached, mode), Some(convert::welcome(&attached)));
        let mut lease = attached.lease;
        lease.why = "its trainer's stream ended".to_owned();
        let hold = Ok(Hold { lease, turn: None });
        Ok(Self { world, steps, told, welcome, hold, refusal: None, era: 0, collisions: None })
    }

    pub(super) fn name(&self) -> &str {
        self.world.name()
    }

    pub(super) fn handle(&self) -> &WorldHandle {
        &self.world
    }

    /// Checks a Step.
    ///
    /// # Errors
    /// If it is invalid, or answers another Turn than the last, with its field.
    pub(super) fn check(&self, step: v1::Step) -> Result<CheckedStep, Status> {
        let step = self.steps.checked(step)?;
        match &self.hold {
            Ok(Hold { turn: Some(turn), .. }) if step.turn != *turn => Err(Status::invalid_argument(
                format!("step.turn: must be {turn}, the number of the world's last Turn, is {}", step.turn),
            )),
            Ok(_) | Err(_) => Ok(step),
        }
    }

    /// Answers the last Turn.
    pub(super) fn step(&mut self, step: CheckedStep) {
        let Ok(hold) = &mut self.hold else { return };
        if hold.turn.take().is_some() {
            // The end of a world is reported by its stream.
            self.steps.send(&hold.lease, step);
        } else {
            self.refusal = Some(Status::failed_precondition("step: the run has ended; reset the world"));
        }
    }

    /// The world has been reset, or not.
    pub(super) fn note_reset(&mut self, done: Result<u64, Status>) {
        match done {
            Ok(era) => self.era = era,
            // The world is over, and the stream has the reason.
            Err(status) if status.code() == Code::Aborted => {}
            Err(status) => self.refusal = Some(status),
        }
    }

    /// The stream ends because of this.
    pub(super) fn end(&mut self, why: &str) {
        if let Ok(hold) = &mut self.hold {
            hold.lease.why = why.to_owned();
        }
    }

    /// The standing of the world after an action: waits for its next Turn, or its end.
    pub(super) async fn result(&mut self) -> v1::WorldResult {
        let result = self.next().await;
        v1::WorldResult { welcome: self.welcome.take(), ..result }
    }

    async fn next(&mut self) -> v1::WorldResult {
        if let Err(status) = &self.hold {
            return convert::closed(status);
        }
        if let Some(refusal) = self.refusal.take() {
            return convert::refused(&refusal);
        }
        loop {
            match self.told.recv().await {
                Some(Told::Turn(_, truth) | Told::Ended(truth)) if truth.era < self.era => {}
                Some(Told::Turn(turn, mut truth)) if truth.lockstep => {
                    self.note_collisions(&mut truth);
                    return self.told(convert::turned(turn, truth.standing));
                }
                Some(Told::Turn(..)) => {
                    let name = self.name();
                    return self.close(Status::failed_precondition(format!(
                        "world: `{name}` is not in lockstep any more; set its pace with SetPace, and open another stream"
                    )));
                }
                Some(Told::Ended(mut truth)) => {
                    self.note_collisions(&mut truth);
                    return self.told(convert::ended(truth.ending.as_ref(), truth.standing));
                }
                Some(Told::Close(status)) => return self.close(status),
                None => return self.close(Status::aborted(format!("world `{}` was deleted", self.name()))),
            }
        }
    }

    /// Notes a result for the trainer: a Turn, which it is to answer, or an end.
    fn told(&mut self, result: v1::WorldResult) -> v1::WorldResult {
        if let Ok(hold) = &mut self.hold {
            hold.turn = if let Some(Outcome::Turn(turn)) = &result.outcome { Some(turn.turn) } else { None };
        }
        result
    }

    /// The robots are released.
    fn close(&mut self, status: Status) -> v1::WorldResult {
        self.end(status.message());
        let result = convert::closed(&status);
        self.hold = Err(status);
        result
    }

    /// Notes how often each robot has collided, and marks those that have since the trainer's last result, or since the
    /// world was reset or restored.
    fn note_collisions(&mut self, truth: &mut Truth) {
        let truths = &mut truth.standing.truths;
        let now: Vec<_> = truths.iter().map(|robot| robot.collisions).collect();
        let before = match self.collisions.replace((truth.era, now.clone())) {
            Some((era, before)) if era == truth.era => before,
            // The world was reset or restored.
            Some(_) => std::mem::take(&mut truth.collisions_before),
            None => now,
        };
        for (robot, before) in truths.iter_mut().zip(before) {
            robot.collided = robot.collisions > before;
        }
    }
}
