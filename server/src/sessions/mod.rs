//! Who is attached to a world, and for whom the world waits.

mod behind;
mod fit;
mod measures;
mod steps;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use baudbot_sim::{Scenario, SimTime, Turn, World};
use tokio::sync::mpsc;
use tonic::Status;

use crate::endpoint::Until;
use crate::letter::{Attach, Delivery, RobotDelivery};
use crate::pace::WatchdogPolicy;
use crate::words::{brief, list};
use fit::check_brain;
use measures::Answering;
pub(crate) use measures::SeatMeasures;
pub(crate) use steps::STEPS_A_TICK;

/// Places in a brain's stream that turns leave free, so that the news of an end always finds room.
pub(crate) const RESERVED: usize = 8;

/// Turns that a brain may leave unanswered while the world goes on without it.
const MAX_OPEN: usize = 256;

/// The brain programs of a world and the robots' seats that they hold.
pub(crate) struct Sessions {
    by_number: BTreeMap<u64, Session>,
    next_number: u64,
    /// One for each robot of the world.
    seats: Vec<Seat>,
}

/// A brain program's stream.
struct Session {
    brain: String,
    raw: bool,
    /// Indices of its robots in the world.
    robots: Vec<usize>,
    deliveries: mpsc::Sender<Delivery>,
    /// Number of the last Turn that it was given.
    last_turn: u64,
    /// The numbers of the last Turns that it was given, and their ticks.
    given: VecDeque<(u64, u64)>,
    /// In lockstep, the numbers of the Turns that it has not answered and when their ticks began, oldest first.
    open: VecDeque<(u64, Instant)>,
    answering: Answering,
    /// It has promised to think as long as the scenario says.
    steady: bool,
    /// The steps of the last of its Turns.
    asked: Vec<Turn>,
    /// Those that the world has gone ahead of.
    behind: Vec<Turn>,
    /// Its steps in the tick that is begun; their Turn is held until it has answered the one before.
    held: Vec<Turn>,
    /// The last Turn before a reset, or a change of pace: answers to it and to earlier ones are thrown away.
    void_turn: u64,
    /// The watchdog gave up on it; it is not waited for until it has answered its last Turn.
    late: bool,
    /// Steps of it that the world has taken in this tick, and those of all ticks that it has thrown away.
    steps: usize,
    lost_steps: Arc<AtomicU64>,
}

/// A robot's place for a brain.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seat {
    pub(crate) session: Option<u64>,
    /// In lockstep the world stands still while this is so and nobody holds the robot.
    pub(crate) awaited: bool,
    pub(crate) lost_deliveries: u64,
    /// Of those that held it and are gone.
    lost_steps: u64,
    /// How those answered that held it and are gone.
    answering: Answering,
    /// Its brain is gone without having answered the Turn of this tick.
    unanswered: bool,
    /// Its brain has answered and waits for a message.
    until: Option<Until>,
}

/// How an answer stands to the Turn that a brain was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// To a Turn of before a reset, or of before the lockstep.
    Void,
    /// To the oldest Turn that is open.
    Due,
    /// Not to any Turn.
    Unasked,
}

impl Sessions {
    pub(crate) fn new(robots: usize) -> Self {
        let seat = Seat { awaited: true, ..Seat::default() };
        Self { by_number: BTreeMap::new(), next_number: 1, seats: vec![seat; robots] }
    }

    /// Gives a brain program the robots that it asks for, or none of them.
    pub(crate) fn attach(
        &mut self,
        world: &str,
        scenario: &Scenario,
        request: Attach,
    ) -> Result<(u64, Vec<usize>), Status> {
        let mut robots = Vec::new();
        for (i, name) in request.robots.iter().enumerate() {
            let Some(robot) = scenario.robots().iter().position(|spec| spec.name == *name) else {
                let names = list(scenario.robots().iter().map(|spec| spec.name.as_str()));
                let name = brief(name);
                return Err(Status::not_found(format!(
                    "hello.robots[{i}]: there is no robot `{name}` in world `{world}`; there are: {names}"
                )));
            };
            if robots.contains(&robot) {
                return Err(Status::invalid_argument(format!("hello.robots[{i}]: `{name}` is named twice")));
            }
            if let Some(session) = self.seats[robot].session {
                return Err(Status::already_exists(format!(
                    "hello.robots[{i}]: robot `{name}` of world `{world}` is held by brain `{}`",
                    self.by_number[&session].brain
                )));
            }
            check_brain(&scenario.robots()[robot], &request)?;
            robots.push(robot);
        }
        let number = self.next_number;
        self.next_number += 1;
        for &robot in &robots {
            self.seats[robot].session = Some(number);
            self.seats[robot].awaited = true;
        }
        let Attach { brain, raw, steady, deliveries, .. } = request;
        let session = Session {
            brain,
            raw,
            robots: robots.clone(),
            deliveries,
            last_turn: 0,
            given: VecDeque::new(),
            open: VecDeque::new(),
            answering: Answering::default(),
            steady,
            asked: Vec::new(),
            behind: Vec::new(),
            held: Vec::new(),
            void_turn: 0,
            late: false,
            steps: 0,
            lost_steps: Arc::default(),
        };
        self.by_number.insert(number, session);
        Ok((number, robots))
    }

    /// A brain program is gone. Whether the world waits for its return depends on the watchdog's policy.
    pub(crate) fn detach(&mut self, number: u64, policy: Option<WatchdogPolicy>) {
        let Some(session) = self.by_number.remove(&number) else { return };
        let awaited = policy == Some(WatchdogPolicy::Wait);
        for robot in session.robots {
            let seat = &mut self.seats[robot];
            (seat.session, seat.awaited, seat.until) = (None, awaited, None);
            seat.unanswered = awaited && !session.open.is_empty();
            seat.answering.add(session.answering);
            seat.lost_steps += session.lost_steps.load(Ordering::Relaxed);
        }
    }

    /// Ends a brain program's stream and frees its robots.
    pub(crate) fn close(&mut self, number: u64, policy: Option<WatchdogPolicy>, status: Status) {
        if let Some(session) = self.by_number.get(&number) {
            let _ = session.deliveries.try_send(Delivery::Close(status));
        }
        self.detach(number, policy);
    }

    /// Ends all streams.
    pub(crate) fn close_all(&mut self, status: &Status) {
        for number in self.by_number.keys().copied().collect::<Vec<_>>() {
            self.close(number, None, status.clone());
        }
    }

    /// The operator starts the world: robots that nobody holds are not waited for.
    pub(crate) fn excuse_empty_seats(&mut self) {
        for seat in self.seats.iter_mut().filter(|seat| seat.session.is_none()) {
            (seat.awaited, seat.unanswered) = (false, false);
        }
    }

    /// Whether the world must stand still for want of a brain.
    pub(crate) fn has_awaited_empty_seat(&self) -> bool {
        self.seats.iter().any(|seat| seat.awaited && seat.session.is_none())
    }

    /// Whether the world must stand still within a tick, because a brain is gone that it waits for.
    pub(crate) fn has_unanswered_empty_seat(&self) -> bool {
        self.seats.iter().any(|seat| seat.unanswered && seat.session.is_none())
    }

    /// The brains that have yet to answer the Turn of this tick.
    pub(crate) fn owing(&self) -> impl Iterator<Item = u64> {
        self.by_number
            .iter()
            .filter(|(_, session)| !session.open.is_empty() && !session.late)
            .map(|(n, _)| *n)
    }

    /// The watchdog gives up on a brain until it answers.
    pub(crate) fn mark_late(&mut self, number: u64) {
        if let Some(session) = self.by_number.get_mut(&number) {
            session.late = true;
        }
    }

    /// What a brain program calls itself; nothing once it is gone.
    pub(crate) fn name(&self, number: u64) -> &str {
        self.by_number.get(&number).map_or("", |session| &session.brain)
    }

    /// The robots of a stream; none once it is gone.
    pub(crate) fn robots(&self, number: u64) -> &[usize] {
        self.by_number.get(&number).map_or(&[], |session| &session.robots)
    }

    /// The robot behind a slot of a stream.
    pub(crate) fn robot(&self, number: u64, slot: usize) -> Option<usize> {
        self.by_number.get(&number)?.robots.get(slot).copied()
    }

    /// Notes an answer to the Turn of this number; 0 answers none.
    pub(crate) fn answered(&mut self, number: u64, turn: u64) -> Answer {
        let Some(session) = self.by_number.get_mut(&number) else { return Answer::Void };
        if let Some((_, begun)) = session.open.pop_front_if(|(number, _)| *number == turn) {
            session.answering.note(begun.elapsed());
            session.late &= !session.open.is_empty();
            return Answer::Due;
        }
        if turn != 0 && turn <= session.void_turn { Answer::Void } else { Answer::Unasked }
    }

    /// A robot's brain waits for a message, or, if not, is to be asked at its next step.
    pub(crate) fn wait_until(&mut self, robot: usize, until: Option<Until>) {
        self.seats[robot].until = until;
    }

    /// Whether a robot's brain need not be asked at this step, because it waits for something that has not come.
    pub(crate) fn sleeps(&self, turn: Turn, world: &World) -> bool {
        let seat = &self.seats[turn.robot];
        let Some(until) = seat.until else { return false };
        let raw = seat.session.is_some_and(|number| self.by_number[&number].raw);
        let news = if raw { world.has_bytes(turn.robot) } else { world.has_message(turn.robot) };
        !news && until.at_latest.is_none_or(|at_latest| turn.at < at_latest)
    }

    /// The tick of the Turn of this number, if it is not too long ago.
    pub(crate) fn tick_of(&self, session: u64, turn: u64) -> Option<u64> {
        let given = &self.by_number.get(&session)?.given;
        given.iter().rev().find(|(number, _)| *number == turn).map(|(_, tick)| *tick)
    }

    /// The world is at another time, or at another pace: Turns up to now are void, and no answer is owed.
    pub(crate) fn void_turns(&mut self) {
        self.forget_unanswered();
        for seat in &mut self.seats {
            seat.until = None;
        }
        for session in self.by_number.values_mut() {
            session.void_turn = session.last_turn;
            session.open.clear();
            session.behind.clear();
            session.held.clear();
            session.late = false;
        }
    }

    /// Tells the brains whose step it is. In lockstep they owe an answer from when the tick has `begun`.
    pub(crate) fn deliver(&mut self, world: &World, turns: &[Turn], begun: Option<Instant>) {
        let mut at: Vec<Option<SimTime>> = vec![None; self.seats.len()];
        for turn in turns {
            at[turn.robot] = Some(turn.at);
        }
        self.forget_unanswered();
        for session in self.by_number.values_mut() {
            if session.behind.is_empty() {
                session.deliver(world, &at, begun, &mut self.seats);
            } else {
                session.hold(&at);
            }
        }
    }

    fn forget_unanswered(&mut self) {
        for seat in &mut self.seats {
            seat.unanswered = false;
        }
    }

    /// Gives a brain that took over a robot in the middle of a tick the Turn that its predecessor left open.
    pub(crate) fn deliver_unanswered(&mut self, number: u64, world: &World) {
        let Some(session) = self.by_number.get_mut(&number) else { return };
        let mut at: Vec<Option<SimTime>> = vec![None; self.seats.len()];
        for turn in world.turns() {
            at[turn.robot] = std::mem::take(&mut self.seats[turn.robot].unanswered).then_some(turn.at);
        }
        session.deliver(world, &at, Some(Instant::now()), &mut self.seats);
    }

    /// Tells a brain that these are its steps in the tick that is begun.
    pub(crate) fn deliver_to(&mut self, number: u64, world: &World, turns: &[Turn]) {
        let Some(session) = self.by_number.get_mut(&number) else { return };
        let mut at: Vec<Option<SimTime>> = vec![None; self.seats.len()];
        for turn in turns {
            at[turn.robot] = Some(turn.at);
        }
        session.deliver(world, &at, Some(Instant::now()), &mut self.seats);
    }

    /// Tells the brains that the run is over.
    pub(crate) fn tell_ended(&self, tick: u64) {
        for number in self.by_number.keys() {
            self.tell_one_ended(*number, tick);
        }
    }

    /// Tells one brain that the run is over.
    pub(crate) fn tell_one_ended(&self, number: u64, tick: u64) {
        if let Some(session) = self.by_number.get(&number) {
            let _ = session.deliveries.try_send(Delivery::Ended { tick });
        }
    }

    /// The program that holds a robot.
    pub(crate) fn session(&self, robot: usize) -> Option<u64> {
        self.seats.get(robot)?.session
    }

    /// The name of the brain that holds a robot.
    pub(crate) fn brain(&self, robot: usize) -> Option<&str> {
        Some(&self.by_number.get(&self.session(robot)?)?.brain)
    }

    /// Each seat with the name of the brain that holds it.
    pub(crate) fn seats(&self) -> impl Iterator<Item = (&Seat, Option<&str>)> {
        self.seats.iter().map(|seat| {
            let brain = seat.session.and_then(|number| self.by_number.get(&number));
            (seat, brain.map(|session| session.brain.as_str()))
        })
    }
}

impl Session {
    fn hold(&mut self, at: &[Option<SimTime>]) {
        let robots = self.robots.iter();
        self.held = robots.filter_map(|&robot| Some(Turn { robot, at: at[robot]? })).collect();
    }

    /// Sends the Turns of its robots that have one. A stream that is full, because its brain does not read,
    /// loses the delivery; that is counted, and the world does not wait for an answer to it.
    fn deliver(&mut self, world: &World, at: &[Option<SimTime>], begun: Option<Instant>, seats: &mut [Seat]) {
        let slots = self.robots.iter().enumerate();
        let robots: Vec<RobotDelivery> = slots
            .filter_map(|(slot, &robot)| Some(delivery(world, robot, slot, at[robot]?, self.raw)))
            .collect();
        if robots.is_empty() {
            return;
        }
        let number = self.last_turn + 1;
        let delivery = Delivery::Turn { number, tick: world.tick(), robots };
        let room = self.deliveries.capacity() > RESERVED && self.open.len() < MAX_OPEN;
        if room && self.deliveries.try_send(delivery).is_ok() {
            self.last_turn = number;
            if self.given.len() == MAX_OPEN {
                self.given.pop_front();
            }
            self.given.push_back((number, world.tick()));
            self.open.extend(begun.map(|begun| (number, begun)));
            let robots = self.robots.iter();
            self.asked.clear();
            self.asked.extend(robots.filter_map(|&robot| Some(Turn { robot, at: at[robot]? })));
            for &robot in self.robots.iter().filter(|&&robot| at[robot].is_some()) {
                seats[robot].until = None;
            }
        } else {
            for &robot in &self.robots {
                seats[robot].lost_deliveries += 1;
            }
        }
    }
}

fn delivery(world: &World, robot: usize, slot: usize, at: SimTime, raw: bool) -> RobotDelivery {
    let view = world.robot(robot);
    let mut delivery = RobotDelivery { slot, at, raw: Vec::new(), ports: Vec::new(), readings: Vec::new() };
    if raw {
        delivery.raw = view.unread().to_vec();
        let ports = view.unread_of_ports().filter(|(_, bytes)| !bytes.is_empty());
        delivery.ports = ports.map(|(sensor, bytes)| (sensor, bytes.to_vec())).collect();
    } else {
        let arrived = view.readings().iter().enumerate().filter(|(_, reading)| !reading.values.is_empty());
        delivery.readings = arrived.map(|(i, reading)| (i, reading.clone())).collect();
    }
    delivery
}
