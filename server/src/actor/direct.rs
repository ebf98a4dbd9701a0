//! A world that is driven by the thread of its brains: lockstep without a server, a network or a thread of its own.
//!
//! It is the actor of any other world, so that recordings, reports and events are the same. Only its sessions give no
//! Turns: its driver hands over the actions of each brain, in the tick in which the brain steps.

use std::sync::Arc;

use baudbot_brain::{Action, Belief};
use baudbot_proto::v1;
use baudbot_run::{LockstepWorld, PortWorld};
use baudbot_sim::cable::Cable;
use baudbot_sim::{Intervention, InterventionError, SimTime, Turn, World};
use tokio::sync::oneshot;
use tonic::Status;

use super::{NewWorld, Pending, Phase, WorldActor};
use crate::annotate;
use crate::clock;
use crate::convert;
use crate::endpoint::Endpoint;
use crate::endpoint::Mode;
use crate::limits::{InForce, Limits};
use crate::log::event;
use crate::recording::Input;
use crate::report::Report;

/// A world in lockstep that has no thread of its own: its owner makes its ticks, one half after the other, and has the brains
/// step in between. Robots that no brain was given keep still.
///
/// A run has the same bits as on a [`Server`](crate::Server) with the same brains.
pub struct DirectWorld {
    actor: WorldActor,
    /// All robots, in their order.
    endpoint: Endpoint,
    robots: Vec<usize>,
    turns: Vec<Turn>,
}

impl DirectWorld {
    /// Makes the world; its pace is taken as lockstep, and it is not paused.
    ///
    /// # Errors
    /// If its recording cannot begin.
    pub(crate) fn start(new: NewWorld) -> Result<Self, Status> {
        let record = new.record.clone();
        let charges = new.charges(&InForce::new(Limits::none()))?;
        let mut actor = WorldActor::new(new.name.as_str().into(), new, charges, Arc::default());
        actor.pacer.paused = false;
        actor.sessions.excuse_vacant_slots();
        if let Some(record) = record {
            actor.record(record)?;
        }
        let robots: Vec<_> = (0..actor.world.robots().len()).collect();
        let endpoint = Endpoint::new(Arc::clone(actor.world.scenario()), robots.clone(), Mode::Messages);
        event!(actor, info, robots = robots.len(), paused = false, "world made");
        Ok(Self { actor, endpoint, robots, turns: Vec::new() })
    }

    /// Puts a brain of this name, which has room on them, on the robots in these places.
    pub fn attach(&mut self, brain: &str, robots: &[usize]) {
        let actor = &mut self.actor;
        let session = actor.sessions.seat(brain.to_owned(), robots.to_vec());
        actor.record_attached(robots, brain, None);
        actor.log_attached(session, robots);
        actor.beliefs.hand_to(Some(session), robots);
    }

    /// Shows people what the brain of a robot believes. What is published before the second half of a tick is in the next
    /// tick's frame.
    ///
    /// # Errors
    /// `INVALID_ARGUMENT` with the field of the belief that cannot be shown.
    pub fn publish(&mut self, robot: usize, belief: Belief) -> Result<(), Status> {
        let Some(session) = self.actor.sessions.session(robot) else { return Ok(()) };
        let annotate = v1::Annotate { robot: robot as u32, belief: Some(belief.into()) };
        let (robot, belief) = annotate::checked(annotate, &self.robots)?;
        self.actor.beliefs.publish(session, robot, belief);
        Ok(())
    }

    /// Ends the world between two ticks, and waits until its recording is closed. Returns how the world then is, and
    /// how its recording ends, if it has one: with that very state.
    ///
    /// # Errors
    /// If the thread that writes the recording is gone.
    pub async fn close(mut self) -> Result<v1::WorldStatus, Status> {
        self.actor.pacer.running.set(false, clock::now());
        if !self.actor.recording.is_on() {
            // The state is that of a recording's end: its sensors have been read, also if the run was ended between two ticks.
            let mut last = self.actor.world.clone();
            last.begin();
            return Ok(convert::status(&Report { world: last, ..self.actor.report(0) }));
        }
        let (closed, file) = oneshot::channel();
        let mut report = self.actor.stop_recording(closed)?;
        report.end_recording(file).await?;
        Ok(convert::status(&report))
    }
}

impl LockstepWorld for DirectWorld {
    type Error = Status;

    fn world(&self) -> &World {
        &self.actor.world
    }

    /// A brain that waits for a message is not asked before one has come.
    fn begin(&mut self) {
        let actor = &mut self.actor;
        actor.recording.wait_for_disk();
        actor.pacer.running.set(true, clock::now());
        actor.show_start();
        self.turns = actor.world.begin().to_vec();
        actor.record_tick();
        actor.show();
        self.turns.retain(|turn| actor.sessions.session(turn.robot).is_some() && !actor.lets_sleep(*turn));
        actor.phase = Phase::Begun;
        actor.pacer.wait_from(clock::now());
    }

    fn turns(&self) -> &[Turn] {
        &self.turns
    }

    /// `INVALID_ARGUMENT` has the field of the action that is invalid, as the contract calls it.
    fn act(&mut self, turn: Turn, action: Action) -> Result<(), Status> {
        let write = convert::write(turn.robot, action);
        self.endpoint.check_part(turn.robot, &write)?;
        let actor = &mut self.actor;
        let spec = &actor.world.scenario().robots[turn.robot];
        let at = turn.at + write.thinking.on(spec);
        actor.sessions.wait_until(turn.robot, write.until);
        let sent = actor.ports.senders[turn.robot].send(spec, write.output);
        let tick = Some(actor.world.tick());
        actor.ports.inputs.push(Pending { robot: turn.robot, at, sent, tick });
        Ok(())
    }

    /// The sensors have been read a last time when the run has ended.
    fn finish(&mut self) -> bool {
        let actor = &mut self.actor;
        actor.finish_with(clock::now(), &[]);
        let goes_on = actor.world.ending().is_none();
        if !goes_on {
            actor.pacer.running.set(false, clock::now());
        }
        goes_on
    }
}

/// Programs in simulated time. All that they write is recorded.
impl PortWorld for DirectWorld {
    fn hear(&mut self, robot: usize, until: SimTime) -> Option<SimTime> {
        self.actor.world.hear(robot, until)
    }

    fn take_arrived(&mut self, robot: usize, cable: Cable, into: &mut Vec<u8>) {
        self.actor.world.take_arrived(robot, cable, into);
    }

    fn write_within(&mut self, robot: usize, cable: Cable, at: SimTime, bytes: &[u8]) -> bool {
        let is_written = self.actor.world.write_within(robot, cable, at, bytes);
        if is_written && self.actor.records() {
            let sensor = match cable {
                Cable::Robot => None,
                Cable::Sensor(i) => Some(i),
            };
            let input = Input { robot, sensor, at, bytes: bytes.to_vec(), answers_tick: None };
            self.actor.ports.within.push(input);
        }
        is_written
    }

    fn change(&mut self, change: &Intervention) -> Result<(), InterventionError> {
        self.actor.world.intervene(change)?;
        self.actor.record_change(change);
        Ok(())
    }
}
