//! The world: the flow of Fig. 3.1 in two halves, with the brains between them.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;

use baudbot_geometry::Circle;
use serde::{Deserialize, Serialize};

use crate::collision::{Collision, CollisionPolicy, Partner, Step};
use crate::hash;
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::scene::Scene;
use crate::time::{SECOND_NS, SimTime};
use crate::view::RobotView;

/// A world: a scenario, which never changes, and a state, which is a value: a snapshot is a clone.
///
/// ```
/// # fn main() -> Result<(), baudbot_sim::scenario::ScenarioError> {
/// use baudbot_sim::{Scenario, World};
/// let scenario = Scenario::parse(
///     r#"
///     [[robots]]
///     name = "alice"
///     body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
///     "#,
/// )?;
/// let mut world = World::new(scenario.into());
/// for _ in 0..100 {
///     world.begin();
///     // … the brains think; `world.turns()` says who may answer, and when …
///     world.finish(&[]);
/// }
/// assert_eq!(world.time().as_seconds(), 1.0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct World {
    scenario: Arc<Scenario>,
    state: State,
}

/// All that changes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    tick: u64,
    begun: bool,
    pub(crate) robots: Vec<Robot>,
    turns: Vec<Turn>,
    collisions: Vec<Collision>,
    ending: Option<Ending>,
}

/// A brain's step in this tick.
///
/// A brain is taken to wait for a message: it steps when one has arrived whole and it is done thinking, but
/// not before the tick begins, and at the latest when the tick ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Turn {
    /// Index of its robot in [`World::robots`](crate::World::robots).
    pub robot: usize,
    /// The instant of the step.
    pub at: SimTime,
}

/// What a brain did in its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input<'a> {
    /// Index of its robot. An index that no robot has is ignored.
    pub robot: usize,
    /// When the bytes are handed to the port, and the brain is free again. Taken as the instant of the
    /// brain's last step if it is earlier than that.
    pub at: SimTime,
    /// Bytes for the microcontroller; may be empty.
    pub bytes: &'a [u8],
}

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// The scenario's time is over.
    TimeIsOver,
    /// A robot ran into something.
    Collision(Collision),
    /// The robot of this name reached the scenario's goal.
    GoalReached(String),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeIsOver => f.write_str("the scenario's time is over"),
            Self::Collision(Collision { robot, with }) => write!(f, "`{robot}` ran into `{with}`"),
            Self::GoalReached(robot) => write!(f, "`{robot}` reached the goal"),
        }
    }
}

impl World {
    /// A world at its start.
    pub fn new(scenario: Arc<Scenario>) -> Self {
        let robots = scenario.robots().iter().map(|spec| Robot::new(spec, scenario.seed)).collect();
        let state =
            State { tick: 0, begun: false, robots, turns: Vec::new(), collisions: Vec::new(), ending: None };
        Self { scenario, state }
    }

    /// First half of a tick: the scene is frozen, sensors that are due sample it, the microcontrollers read
    /// and send, and what arrives is there for the brains. Says which brains step now. A second call
    /// without [`finish`](Self::finish) in between changes nothing.
    ///
    /// In a run that has ended this reads the sensors a last time at the state that it ended in, and no
    /// brain steps.
    pub fn begin(&mut self) -> &[Turn] {
        if !core::mem::replace(&mut self.state.begun, true) {
            self.state.turns.clear();
            let bodies = self.discs();
            for own in 0..self.state.robots.len() {
                self.listen(own, &bodies);
            }
        }
        &self.state.turns
    }

    /// Runs one robot's cable up to its brain's step.
    fn listen(&mut self, own: usize, bodies: &[Circle]) {
        let (now, end) = (self.time(), self.tick_end());
        let ended = self.state.ending.is_some();
        let robot = &mut self.state.robots[own];
        let spec = &self.scenario.robots()[own];
        let scene = Scene { arena: &self.scenario.arena, bodies, own };
        let earliest = robot.laptop.busy_until.max(now);
        if ended || earliest >= end {
            robot.advance(spec, &scene, self.scenario.noise, now + 1, None);
            return;
        }
        let step = robot.advance(spec, &scene, self.scenario.noise, end, Some(earliest));
        robot.counters.turns += 1;
        self.state.turns.push(Turn { robot: own, at: step.unwrap_or(end) });
    }

    /// Second half of a tick: what the brains wrote travels the links, the microcontrollers obey what has
    /// arrived, motors push, bodies move, collisions and the scenario's ends are looked at. Does nothing
    /// unless [`begin`](Self::begin) came first, and nothing once the run has ended.
    pub fn finish(&mut self, inputs: &[Input<'_>]) {
        if !self.state.begun || self.state.ending.is_some() {
            return;
        }
        self.hand_over();
        self.write(inputs);
        let bodies = self.discs();
        let end = self.tick_end();
        for (own, robot) in self.state.robots.iter_mut().enumerate() {
            let scene = Scene { arena: &self.scenario.arena, bodies: &bodies, own };
            robot.advance(&self.scenario.robots()[own], &scene, self.scenario.noise, end, None);
        }
        self.move_robots();
        self.state.tick += 1;
        self.state.begun = false;
        self.look_for_the_end();
    }

    fn hand_over(&mut self) {
        for turn in &self.state.turns {
            self.state.robots[turn.robot].laptop.hand_over(turn.at);
        }
    }

    fn write(&mut self, inputs: &[Input<'_>]) {
        for input in inputs {
            let Some(robot) = self.state.robots.get_mut(input.robot) else { continue };
            let at = input.at.max(robot.laptop.busy_until);
            robot.laptop.busy_until = at;
            robot.write(&self.scenario.robots()[input.robot], at, input.bytes);
        }
    }

    /// The bodies move, in substeps; a command that arrived within the tick acts from the next substep on.
    fn move_robots(&mut self) {
        let (now, dt_ns) = (self.time(), self.scenario.step_ns / u64::from(self.scenario.substeps));
        self.state.collisions.clear();
        for robot in &mut self.state.robots {
            robot.collided = false;
        }
        for i in 0..u64::from(self.scenario.substeps) {
            if self.state.ending.is_none() {
                self.substep(now + i * dt_ns, dt_ns as f64 / SECOND_NS as f64);
            }
        }
    }

    fn substep(&mut self, now: SimTime, dt: f64) {
        let before = self.discs();
        for (robot, spec) in self.state.robots.iter_mut().zip(self.scenario.robots()) {
            if let Some(signals) = robot.microcontroller.signals_at(now) {
                robot.signals = signals;
            }
            robot.motion = spec.drive.step(&robot.motion, robot.signals, dt);
        }
        match self.scenario.collision {
            CollisionPolicy::StopRun => self.stop_run(&before),
            CollisionPolicy::StopRobot => self.stop_robots(&before),
        }
        for robot in &mut self.state.robots {
            robot.counters.distance_m += (robot.motion.speed_m_s * dt).abs();
        }
    }

    fn stop_run(&mut self, before: &[Circle]) {
        let scenario = Arc::clone(&self.scenario);
        let step = Step { arena: &scenario.arena, before, after: self.discs() };
        for own in 0..before.len() {
            self.note_contact(own, step.partner(own));
        }
        self.state.ending = self.state.collisions.first().cloned().map(Ending::Collision);
    }

    /// A robot that is held back keeps its turning: a disc cannot run into anything by it.
    fn stop_robots(&mut self, before: &[Circle]) {
        let scenario = Arc::clone(&self.scenario);
        let held = Step { arena: &scenario.arena, before, after: self.discs() }.held_back();
        for (own, partner) in held.into_iter().enumerate() {
            if partner.is_some() {
                let motion = &mut self.state.robots[own].motion;
                motion.pose.position = before[own].center;
                scenario.robots()[own].drive.halt(motion);
            }
            self.note_contact(own, partner);
        }
    }

    /// A contact that lasts is one collision. A robot that was stopped creeps up again without touching at
    /// once, so its contacts last until there is some room around it.
    fn note_contact(&mut self, own: usize, partner: Option<Partner>) {
        let Some(partner) = partner else {
            if !self.state.robots[own].contacts.is_empty() && !self.is_hemmed_in(own) {
                self.state.robots[own].contacts.clear();
            }
            return;
        };
        let robot = &mut self.state.robots[own];
        robot.collided = true;
        if robot.contacts.contains(&partner) {
            return;
        }
        robot.counters.collisions += 1;
        robot.contacts.push(partner.clone());
        let robots = self.scenario.robots();
        let with = match partner {
            Partner::Shape(name) => name,
            Partner::Robot(i) => robots[i].name.clone(),
        };
        self.state.collisions.push(Collision { robot: robots[own].name.clone(), with });
    }

    fn is_hemmed_in(&self, own: usize) -> bool {
        let discs = self.discs();
        let room = Circle { radius: discs[own].radius * CONTACT_ENDS_AT, ..discs[own] };
        let meets = |(i, other): (usize, &Circle)| i != own && room.overlaps_circle(other);
        self.scenario.arena.obstacle_at(&room).is_some() || discs.iter().enumerate().any(meets)
    }

    fn look_for_the_end(&mut self) {
        if self.state.ending.is_some() {
            return;
        }
        if let Some(goal) = &self.scenario.end.goal {
            let reached = |robot: &&Robot| {
                (robot.motion.pose.position - goal.center).norm_squared() <= goal.radius * goal.radius
            };
            if let Some(i) = self.state.robots.iter().position(|robot| reached(&robot)) {
                self.state.ending = Some(Ending::GoalReached(self.scenario.robots()[i].name.clone()));
                return;
            }
        }
        if self.scenario.end.after.is_some_and(|after| self.time() >= after) {
            self.state.ending = Some(Ending::TimeIsOver);
        }
    }

    fn discs(&self) -> Vec<Circle> {
        self.state.robots.iter().zip(self.scenario.robots()).map(|(robot, spec)| robot.disc(spec)).collect()
    }

    /// What the world was made from.
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// Number of ticks finished.
    pub fn tick(&self) -> u64 {
        self.state.tick
    }

    /// The start of the tick that is begun or comes next.
    pub fn time(&self) -> SimTime {
        SimTime::from_ns(self.state.tick * self.scenario.step_ns)
    }

    fn tick_end(&self) -> SimTime {
        self.time() + self.scenario.step_ns
    }

    /// Which brains step in the tick that is begun.
    pub fn turns(&self) -> &[Turn] {
        &self.state.turns
    }

    /// Why the run ended, if it has.
    pub fn ending(&self) -> Option<&Ending> {
        self.state.ending.as_ref()
    }

    /// The collisions that began in the last tick finished.
    pub fn collisions(&self) -> &[Collision] {
        &self.state.collisions
    }

    /// The robots, in the order of their names.
    pub fn robots(&self) -> impl ExactSizeIterator<Item = RobotView<'_>> {
        (0..self.state.robots.len()).map(|i| self.robot(i))
    }

    /// The robot of this index.
    ///
    /// # Panics
    /// If there is none.
    pub fn robot(&self, i: usize) -> RobotView<'_> {
        RobotView::new(&self.scenario.robots()[i], &self.state.robots[i])
    }

    /// A fingerprint of the whole state: equal for equal bits, on every machine.
    pub fn hash(&self) -> u64 {
        hash::of(&self.state)
    }
}

/// A contact ends when a disc of so many times the radius is free; a robot stops up to a step short of what it
/// runs into, so the factor must leave room for that.
const CONTACT_ENDS_AT: f64 = 1.1;
