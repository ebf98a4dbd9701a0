//! Sessions: the brain programs of a world, the robots that they hold, and the answers that the world waits for.

mod debt;
mod fit;
mod lookahead;
mod measures;
mod quota;
mod session;
mod slot;
mod standing;
mod thinking;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Scenario, SimTime, Turn, World};
use tonic::Status;

use crate::clock;
use crate::endpoint::Mode;
use crate::endpoint::Until;
use crate::measures::Answering;
use crate::message::{Attach, Deliveries, Recipient};
use crate::pace::{Terms, WatchdogPolicy};
use crate::thinking::ProcessorTime;
pub(crate) use debt::Overtaken;
use debt::{Debt, Paid};
use quota::Quota;
pub(crate) use quota::STEPS_A_TICK;
pub(crate) use session::RESERVED;
use session::{Session, Turns};
use slot::{Slot, SlotState, Vacancy};

/// The brain programs of a world and the slots of its robots that they hold.
pub(crate) struct Sessions {
    by_number: BTreeMap<u64, Session>,
    next_number: u64,
    /// The number of resets, restored states and changes of pace: Turns of before are void.
    era: u64,
    /// One for each robot of the world.
    slots: Vec<Slot>,
    /// `None` if the processor time of brains is not known.
    processor: Option<ProcessorTime>,
    /// A serial port may have come or gone since [`serial_ports`](Self::serial_ports) was last asked.
    ports_may_differ: bool,
}

/// A brain that has got its robots.
pub(crate) struct NewSession {
    pub(crate) number: u64,
    /// Indices of the robots, in the order of the request.
    pub(crate) robots: Vec<usize>,
    /// The robots of the session whose last brain has left a Turn of this tick unanswered.
    left_open: Vec<usize>,
    /// The counter of the Steps that are thrown away before the world sees them.
    pub(crate) lost_steps: Arc<AtomicU64>,
}

/// The relation of a Step to the Turns that its brain was given.
pub(crate) enum Answer {
    /// The Step answers a Turn of before a reset, or of before the lockstep.
    Void,
    /// The Step answers the oldest open Turn. If the brain has promised to think as long as the scenario states, with
    /// the robots of that Turn.
    Due(Option<Vec<usize>>),
    /// The Step answers a Turn whose tick the world has ended already.
    Overtaken(Overtaken),
    /// The Step answers no Turn.
    Unasked,
}

impl Sessions {
    /// The sessions of a world whose robots have no brains yet. In lockstep it waits for brains, but not for a program
    /// at the other end of a cable of a robot with a program of its own, which uses a protocol of its own.
    pub(crate) fn new(robots: &[RobotSpec]) -> Self {
        let slot = |spec: &RobotSpec| if is_opaque(spec) { Slot::excused() } else { Slot::default() };
        Self {
            by_number: BTreeMap::new(),
            next_number: 1,
            era: 0,
            slots: robots.iter().map(slot).collect(),
            processor: None,
            ports_may_differ: false,
        }
    }

    /// Gives a brain program the robots that it asks for, or none of them.
    ///
    /// # Errors
    /// Why it cannot have one of them, with the field of the Hello.
    pub(crate) fn attach(
        &mut self,
        world: &str,
        scenario: &Scenario,
        request: Attach,
    ) -> Result<NewSession, Status> {
        let robots = self.choose(world, scenario, &request)?;
        if !request.mode.is_raw() {
            check_understood(scenario, &robots)?;
        }
        let mut left_open = robots.clone();
        left_open.retain(|&robot| self.slots[robot].vacancy() == Some(Vacancy::LeftOpen));
        let Attach { brain, mode, thinks_as_scenario, recipient, .. } = request;
        let session = Session {
            brain,
            mode,
            thinks_as_scenario,
            robots: robots.clone(),
            recipient,
            turns: Turns::of_era(self.era),
            collisions: vec![0; robots.len()],
            debt: Debt::default(),
            answering: Answering::default(),
            quota: Quota::default(),
        };
        let lost_steps = Arc::clone(session.quota.lost());
        let number = self.add(session);
        Ok(NewSession { number, robots, left_open, lost_steps })
    }

    /// Gives robots to a brain that has no stream: it steps where the world is driven. Gives the number of the session.
    pub(crate) fn seat(&mut self, brain: String, robots: Vec<usize>) -> u64 {
        // The other end does not exist: Turns are never given, and the brain gets the end in another way.
        let (deliveries, _) = Deliveries::new(1);
        let collisions = vec![0; robots.len()];
        self.add(Session {
            brain,
            mode: Mode::Messages,
            thinks_as_scenario: false,
            robots,
            recipient: Recipient::Brain(deliveries),
            turns: Turns::default(),
            collisions,
            debt: Debt::default(),
            answering: Answering::default(),
            quota: Quota::default(),
        })
    }

    /// Adds a session, which holds its robots from now on. Gives its number.
    fn add(&mut self, session: Session) -> u64 {
        let number = self.next_number;
        self.next_number += 1;
        for &robot in &session.robots {
            self.slots[robot].state = SlotState::Held { session: number, until: None };
        }
        self.ports_may_differ |= session.mode == Mode::SerialPort;
        self.by_number.insert(number, session);
        number
    }

    /// Removes a brain program that is gone. Whether the world waits for its return depends on the watchdog's policy.
    pub(crate) fn detach(&mut self, number: u64, policy: Option<WatchdogPolicy>) {
        let Some(session) = self.by_number.remove(&number) else { return };
        self.ports_may_differ |= session.mode == Mode::SerialPort;
        let vacancy = match policy {
            Some(WatchdogPolicy::Wait) if session.debt.is_settled() => Vacancy::Awaited,
            Some(WatchdogPolicy::Wait) => Vacancy::LeftOpen,
            Some(WatchdogPolicy::GoOn | WatchdogPolicy::Detach) | None => Vacancy::Excused,
        };
        for robot in session.robots {
            let slot = &mut self.slots[robot];
            slot.state = SlotState::Vacant(vacancy);
            slot.answering.add(session.answering);
            slot.lost_steps += session.quota.lost().load(Ordering::Relaxed);
        }
    }

    /// Ends a brain program's stream with this status, and frees its robots.
    pub(crate) fn close(&mut self, number: u64, policy: Option<WatchdogPolicy>, status: Status) {
        if let Some(session) = self.by_number.get(&number) {
            session.recipient.close(status);
        }
        self.detach(number, policy);
    }

    /// Ends all streams.
    pub(crate) fn close_all(&mut self, status: &Status) {
        for number in self.by_number.keys().copied().collect::<Vec<_>>() {
            self.close(number, None, status.clone());
        }
    }

    /// The operator starts the world: it does not wait for brains of robots that have none.
    pub(crate) fn excuse_vacant_slots(&mut self) {
        for slot in self.slots.iter_mut().filter(|slot| slot.vacancy().is_some()) {
            slot.state = SlotState::Vacant(Vacancy::Excused);
        }
    }

    /// Whether a world in lockstep can begin no tick, because a robot has no brain.
    pub(crate) fn is_any_awaited(&self) -> bool {
        let mut vacancies = self.slots.iter().filter_map(Slot::vacancy);
        vacancies.any(|vacancy| vacancy != Vacancy::Excused)
    }

    /// Whether a world in lockstep cannot end its tick, because a brain has left it without an answer.
    pub(crate) fn is_any_left_open(&self) -> bool {
        self.slots.iter().any(|slot| slot.vacancy() == Some(Vacancy::LeftOpen))
    }

    /// The brains whose answer the world waits for.
    pub(crate) fn owing(&self) -> impl Iterator<Item = u64> {
        self.by_number.iter().filter(|(_, session)| session.debt.is_due()).map(|(number, _)| *number)
    }

    /// The name of a brain program; empty once it is gone.
    pub(crate) fn name(&self, number: u64) -> &str {
        self.by_number.get(&number).map_or("", |session| &session.brain)
    }

    /// The robots of a session; none once it is gone.
    pub(crate) fn robots(&self, number: u64) -> &[usize] {
        self.by_number.get(&number).map_or(&[], |session| &session.robots)
    }

    /// The robot at a place of a stream.
    pub(crate) fn robot(&self, number: u64, place: usize) -> Option<usize> {
        self.by_number.get(&number)?.robots.get(place).copied()
    }

    /// Notes a Step that answers the Turn of this number; 0 answers none.
    pub(crate) fn answer(&mut self, number: u64, turn: u64) -> Answer {
        self.note_thought(number, turn);
        let Some(session) = self.by_number.get_mut(&number) else { return Answer::Void };
        session.turns.note_answer(turn);
        match session.debt.pay(turn) {
            Some(Paid::Turn { turn, was_only_one }) => {
                session.answering.note(clock::since(turn.begun));
                let promised = session.thinks_as_scenario && was_only_one;
                Answer::Due(promised.then(|| turn.steps.iter().map(|step| step.robot).collect()))
            }
            Some(Paid::Overtaken(turn, overtaken)) => {
                session.answering.note(clock::since(turn.begun));
                Answer::Overtaken(overtaken)
            }
            None if session.turns.is_void(turn) => Answer::Void,
            None => Answer::Unasked,
        }
    }

    /// Notes what a robot's brain waits for before it wants to be asked again, if it waits for anything.
    pub(crate) fn wait_until(&mut self, robot: usize, until: Option<Until>) {
        self.slots[robot].set_until(until);
    }

    /// Whether a robot's brain need not be asked at this step, because it waits for something that has not come.
    pub(crate) fn sleeps(&self, turn: Turn, world: &World) -> bool {
        let slot = &self.slots[turn.robot];
        let Some(until) = slot.until() else { return false };
        let raw = slot.session().is_some_and(|number| self.by_number[&number].mode.is_raw());
        let news = if raw { world.has_bytes(turn.robot) } else { world.has_message(turn.robot) };
        !news && until.at_latest.is_none_or(|at_latest| turn.at < at_latest)
    }

    /// The robots that serial ports hold, if that may have changed since the last call.
    pub(crate) fn serial_ports(&mut self) -> Option<Vec<bool>> {
        let is_port = |slot: &Slot| {
            let held = slot.session().and_then(|number| self.by_number.get(&number));
            held.is_some_and(|session| session.mode == Mode::SerialPort)
        };
        let ports = self.ports_may_differ.then(|| self.slots.iter().map(is_port).collect());
        self.ports_may_differ = false;
        ports
    }

    /// The tick of the Turn of this number, if it is not too long ago.
    pub(crate) fn tick_of(&self, number: u64, turn: u64) -> Option<u64> {
        self.by_number.get(&number)?.turns.tick_of(turn)
    }

    /// The world is at another time, or has another pace: Turns up to now are void, and no answer is owed.
    pub(crate) fn void_turns(&mut self, world: &World) {
        for slot in &mut self.slots {
            slot.forget_open_turn();
            slot.set_until(None);
        }
        self.era += 1;
        self.ports_may_differ = true;
        self.by_number.values_mut().for_each(|session| session.begin_era(self.era, world));
    }

    /// Gives Turns to the brains whose step it is in the tick that begins. Where the world waits for them, they owe an
    /// answer.
    ///
    /// A session gets one Turn for all its robots, whatever the order of `turns`: its robots are in the order of its Hello. A
    /// brain that the world has gone ahead of gets nothing now. It would have two Turns to answer, and its answer to the
    /// first may change what the second has in it; so the second is deferred until the first is answered
    /// (`WorldActor::catch_up`).
    pub(crate) fn deliver(&mut self, world: &World, turns: &[Turn], terms: Terms) {
        let at = self.by_robot(turns);
        self.slots.iter_mut().for_each(Slot::forget_open_turn);
        for session in self.by_number.values_mut() {
            if session.debt.overtaken().is_empty() {
                session.deliver(world, &at, terms, self.processor.as_ref(), &mut self.slots);
            } else {
                let steps = session.steps(&at);
                session.debt.defer(steps);
            }
        }
    }

    /// Gives a brain that took over robots in the middle of a tick the Turn that their last brain left open. Turns that other
    /// brains have left open wait for their own successors.
    pub(crate) fn deliver_left_open(&mut self, new: &NewSession, world: &World) {
        let mut open = world.turns().to_vec();
        open.retain(|turn| new.left_open.contains(&turn.robot));
        self.deliver_to(new.number, world, &open);
    }

    /// Gives one brain the Turn of its steps in the tick that has begun.
    pub(crate) fn deliver_to(&mut self, number: u64, world: &World, turns: &[Turn]) {
        let at = self.by_robot(turns);
        let Some(session) = self.by_number.get_mut(&number) else { return };
        let terms = Terms::Waits(clock::now());
        session.deliver(world, &at, terms, self.processor.as_ref(), &mut self.slots);
    }

    /// The instants at which the robots step.
    fn by_robot(&self, turns: &[Turn]) -> Vec<Option<SimTime>> {
        let mut at = vec![None; self.slots.len()];
        for turn in turns {
            at[turn.robot] = Some(turn.at);
        }
        at
    }

    /// Sends the brains the end of the run.
    pub(crate) fn tell_ended(&self, world: &World) {
        self.by_number.values().for_each(|session| session.tell_ended(world));
    }

    /// Sends one brain the end of the run.
    pub(crate) fn tell_one_ended(&self, number: u64, world: &World) {
        if let Some(session) = self.by_number.get(&number) {
            session.tell_ended(world);
        }
    }

    /// The number of resets, restored states and changes of pace.
    pub(crate) fn era(&self) -> u64 {
        self.era
    }

    /// The session that holds a robot.
    pub(crate) fn session(&self, robot: usize) -> Option<u64> {
        self.slots.get(robot)?.session()
    }

    /// The name of the brain that holds a robot.
    pub(crate) fn brain(&self, robot: usize) -> Option<&str> {
        Some(&self.by_number.get(&self.session(robot)?)?.brain)
    }
}

/// Refuses messages with a program of the user's own, the meaning of whose bytes is unknown here.
fn check_understood(scenario: &Scenario, robots: &[usize]) -> Result<(), Status> {
    let mut specs = robots.iter().map(|&robot| &scenario.robots[robot]);
    specs.find(|spec| is_opaque(spec)).map_or(Ok(()), |spec| {
        let text = format!(
            "hello.mode: the microcontroller of robot `{}` runs a program of its own, whose messages the server cannot \
             decode; attach in RAW mode, or give it a serial port. If the program speaks \"framed\" or \"bare\", set \
             firmware.protocol",
            spec.name
        );
        Err(Status::failed_precondition(text))
    })
}

/// Whether a program of the user's own drives the robot, the meaning of whose bytes is unknown here.
fn is_opaque(spec: &RobotSpec) -> bool {
    spec.chip.as_ref().is_some_and(|chip| chip.is_opaque())
}
