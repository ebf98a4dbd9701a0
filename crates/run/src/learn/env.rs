//! A world that is stepped from one message of its agents' to the next.

use std::sync::Arc;

use baudbot_sim::{Ending, Turn, World};
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::driven_world::{BareWorld, DrivenWorld, LockstepWorld};
use crate::in_process::{InProcess, drivers};
use crate::learn::agent::{Agent, SavedAgent};
use crate::learn::error::LearnError;
use crate::learn::reward::Tally;
use crate::learn::task::Task;

/// An environment.
///
/// Between two steps the world stands within a tick, at the instant at which its agents would think. A step sends the
/// agents' commands, and goes on until each of them has a message again, or for a second if none comes: a control cycle
/// of the cable.
pub struct Env {
    task: Arc<Task>,
    /// The changes of fields of this run.
    more: Vec<String>,
    /// The world, with the brains of the robots that are no agents.
    driven: InProcess,
    agents: SmallVec<[Agent; 1]>,
    before: Before,
    patience_ticks: u64,
}

/// The result of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stepped {
    /// The run ended, and not since its time was over.
    pub is_terminated: bool,
    /// The run ended since its time was over.
    pub is_truncated: bool,
}

/// The values at the end of the last step, to which a tally is the difference.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Before {
    ns: u64,
    score: Score,
    robots: SmallVec<[[f64; 3]; 1]>,
    tallies: SmallVec<[Tally; 1]>,
}

/// The counts of all robots together.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Score {
    covered: f64,
    sensed: f64,
    zones: f64,
}

impl Score {
    fn of(world: &World) -> Self {
        let (rules, score) = (&world.scenario().rules, world.score());
        if rules.floor.is_none() && score.visited().is_empty() {
            return Self::default();
        }
        Self {
            covered: score.covered(rules).unwrap_or(0.0),
            sensed: score.sensed(rules).unwrap_or(0.0),
            zones: score.visited().iter().filter(|visited| **visited).count() as f64,
        }
    }
}

impl Env {
    /// The environment of a run with this seed, with more changes of fields than those of the task, in which a first message has
    /// come.
    ///
    /// # Errors
    /// If the drawn and changed fields make the scenario invalid, or has other robots or other readings.
    pub fn new(task: Arc<Task>, seed: u64, more: &[String]) -> Result<Self, LearnError> {
        let mut env = Self::at_start(task, seed, more)?;
        env.step();
        Ok(env)
    }

    /// An environment before its first tick.
    fn at_start(task: Arc<Task>, seed: u64, more: &[String]) -> Result<Self, LearnError> {
        let scenario = task.scenario(seed, more)?;
        let brains = task.brains();
        let drivers =
            if brains.is_empty() { Vec::new() } else { drivers(&scenario.robots, brains, scenario.seed)? };
        let patience_ticks = PATIENCE_NS.div_ceil(scenario.step_ns).max(2);
        let world = bare(World::new(scenario));
        let agent = |(&robot, layout)| Agent::new(&world, robot, Arc::clone(layout));
        let agents = task.agents.iter().zip(&task.layouts).map(agent).collect();
        Ok(Self {
            task,
            more: more.to_vec(),
            driven: DrivenWorld { world, drivers },
            agents,
            before: Before::default(),
            patience_ticks,
        })
    }

    /// Begins another run of the same task; see [`new`](Self::new).
    ///
    /// # Errors
    /// As [`new`](Self::new). The present run stays as it is.
    pub fn reset(&mut self, seed: u64, more: &[String]) -> Result<(), LearnError> {
        *self = Self::new(Arc::clone(&self.task), seed, more)?;
        Ok(())
    }

    /// The environment's task.
    pub fn task(&self) -> &Arc<Task> {
        &self.task
    }

    /// The world: the truth, for trainers and for pictures.
    pub fn world(&self) -> &World {
        &self.driven.world
    }

    /// The same, for what makes no difference to the run, such as how much of it is kept.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.driven.world
    }

    /// The robots that are driven from outside.
    pub fn agents(&self) -> &[Agent] {
        &self.agents
    }

    /// Sets the action of an agent for the next step. Without that it does what it did.
    ///
    /// # Errors
    /// See [`Agent::act`].
    ///
    /// # Panics
    /// If there is no such agent.
    pub fn act(
        &mut self,
        agent: usize,
        action: impl ExactSizeIterator<Item = f64>,
    ) -> Result<(), LearnError> {
        self.agents[agent].act(action)
    }

    /// Whether the run is over. A step then does nothing.
    pub fn is_over(&self) -> bool {
        self.world().ending().is_some()
    }

    /// A control cycle.
    pub fn step(&mut self) -> Stepped {
        self.agents.iter_mut().for_each(Agent::begin_step);
        let mut ticks = 0;
        while !self.is_over() {
            self.tick();
            ticks += 1;
            if !self.is_over()
                && (self.agents.iter().all(|agent| agent.has_heard) || ticks >= self.patience_ticks)
            {
                break;
            }
        }
        self.stepped()
    }

    /// Ticks until this instant of simulated time, in nanoseconds, or until the run is over: for worlds in which robots have brains.
    /// Agents do what they did.
    pub fn run_until(&mut self, ns: u64) -> Stepped {
        self.agents.iter_mut().for_each(Agent::begin_stretch);
        while !self.is_over() && self.world().time().as_ns() < ns {
            self.tick();
        }
        self.stepped()
    }

    fn stepped(&mut self) -> Stepped {
        self.count();
        let is_truncated = matches!(self.world().ending(), Some(Ending::TimeIsOver));
        Stepped { is_terminated: self.is_over() && !is_truncated, is_truncated }
    }

    /// Goes from within a tick, or from before the first, to within the next.
    fn tick(&mut self) {
        if self.world().is_begun() {
            self.each_turn(|agent, world, turn| {
                let Ok(()) = world.act(turn, agent.choose());
            });
            let Ok(()) = self.driven.think();
            self.driven.world.finish();
        }
        self.driven.world.begin();
        if self.is_over() {
            let Self { driven, agents, .. } = self;
            agents.iter_mut().for_each(|agent| agent.end(&driven.world));
            return;
        }
        self.each_turn(|agent, world, turn| agent.listen(world, turn));
    }

    /// Calls `act` for each agent whose turn it is in this tick. Agents and turns are in the order of the robots.
    fn each_turn(&mut self, mut act: impl FnMut(&mut Agent, &mut BareWorld, Turn)) {
        let Self { driven: DrivenWorld { world, .. }, agents, .. } = self;
        let mut place = 0;
        for i in 0..world.turns().len() {
            let turn = world.turns()[i];
            while agents.get(place).is_some_and(|agent| agent.robot < turn.robot) {
                place += 1;
            }
            if let Some(agent) = agents.get_mut(place).filter(|agent| agent.robot == turn.robot) {
                act(agent, world, turn);
            }
        }
    }

    /// The events of the last step, for the trainer of this agent.
    ///
    /// # Panics
    /// If there is no such agent.
    pub fn tally(&self, agent: usize) -> &Tally {
        &self.before.tallies[agent]
    }

    /// Counts what happened in the step that is over. A step begins where the last one ended.
    fn count(&mut self) {
        let success = f64::from(u8::from(self.has_succeeded()));
        let Self { driven: DrivenWorld { world, .. }, agents, before, .. } = self;
        let (ns, score) = (world.time().as_ns(), Score::of(world));
        before.robots.resize(agents.len(), [0.0; 3]);
        before.tallies.clear();
        for (agent, was) in agents.iter().zip(&mut before.robots) {
            let now = counts(world, agent.robot);
            before.tallies.push(Tally {
                seconds: (ns - before.ns) as f64 * 1e-9,
                distance_m: now[0] - was[0],
                collisions: now[1] - was[1],
                progress_m: was[2] - now[2],
                covered: score.covered - before.score.covered,
                sensed: score.sensed - before.score.sensed,
                zones: score.zones - before.score.zones,
                success,
            });
            *was = now;
        }
        (before.ns, before.score) = (ns, score);
    }

    fn has_succeeded(&self) -> bool {
        match self.world().ending() {
            Some(Ending::GoalReached(_) | Ending::AllGoals | Ending::Covered | Ending::Sensed) => true,
            Some(
                Ending::TimeIsOver
                | Ending::Collision(_)
                | Ending::Collisions(_)
                | Ending::BatteryEmpty(_)
                | Ending::DeadlineMissed(_),
            )
            | None => false,
        }
    }

    /// A copy of the world and its agents, from which a run can go on as often as one likes.
    ///
    /// # Errors
    /// If there are brains besides the agents: what they think cannot be copied.
    pub fn snapshot(&self) -> Result<Self, LearnError> {
        self.check_copy()?;
        Ok(Self {
            task: Arc::clone(&self.task),
            more: self.more.clone(),
            driven: DrivenWorld { world: self.driven.world.clone(), drivers: Vec::new() },
            agents: self.agents.clone(),
            before: self.before.clone(),
            patience_ticks: self.patience_ticks,
        })
    }

    fn check_copy(&self) -> Result<(), LearnError> {
        if self.task.brains().is_empty() {
            return Ok(());
        }
        let problem = "brains of the catalogue think in this world, and their thoughts cannot be copied; leave `brains` out";
        Err(LearnError::value("snapshot", problem))
    }

    /// The environment by value, but for events that are kept: they are of the past.
    ///
    /// # Errors
    /// As [`snapshot`](Self::snapshot).
    pub fn save(&mut self) -> Result<Vec<u8>, LearnError> {
        self.check_copy()?;
        let Self { driven: DrivenWorld { world, .. }, agents, before, more, .. } = self;
        let saved = Saved {
            seed: world.scenario().seed,
            more: more.clone(),
            world: world.save(),
            hash: world.hash(),
            agents: agents.iter().map(|agent| agent.save(world.commands(agent.robot))).collect(),
            before: before.clone(),
        };
        Ok(postcard::to_allocvec(&saved).expect("what is saved serialises"))
    }

    /// The environment of this task that was saved, in this version of the program.
    ///
    /// # Errors
    /// If the bytes are not that.
    pub fn load(task: Arc<Task>, saved: &[u8]) -> Result<Self, LearnError> {
        let wrong = |problem: &dyn std::fmt::Display| LearnError::value("state", problem.to_string());
        let saved: Saved = postcard::from_bytes(saved)
            .map_err(|error| wrong(&format!("is not an environment of this version: {error}")))?;
        let mut env = Self::at_start(task, saved.seed, &saved.more)?;
        let scenario = Arc::clone(env.world().scenario());
        let world = World::load(scenario, &saved.world, saved.hash).map_err(|error| wrong(&error))?;
        env.driven.world = bare(world);
        let Self { driven: DrivenWorld { world, .. }, agents, .. } = &mut env;
        let fits = agents.len() == saved.agents.len() && saved.before.tallies.len() == agents.len();
        let mut load = |(agent, saved): (&mut Agent, _)| agent.load(world.commands(agent.robot), saved);
        if !(fits && agents.iter_mut().zip(saved.agents).all(&mut load)) {
            return Err(wrong(&"is of other robots"));
        }
        env.before = saved.before;
        Ok(env)
    }
}

/// An environment by value. What follows from its task is not in it.
#[derive(Serialize, Deserialize)]
struct Saved {
    seed: u64,
    more: Vec<String>,
    world: Vec<u8>,
    hash: u64,
    agents: Vec<SavedAgent>,
    before: Before,
}

/// A world of which nothing is kept, and which leaves threads to other worlds.
fn bare(mut world: World) -> BareWorld {
    world.keep_timeline(0);
    // Several worlds at a time use the threads better.
    world.set_parallel(false);
    BareWorld::new(world)
}

/// The distance that a robot has driven, how often it ran into something, and how far it is from the goal.
fn counts(world: &World, robot: usize) -> [f64; 3] {
    let view = world.robot(robot);
    let counters = view.counters();
    let goal = world.scenario().end.goal.as_ref();
    let to_goal_m = goal.map_or(0.0, |goal| (view.motion().pose.position - goal.center).norm());
    [counters.distance_m, counters.collisions as f64, to_goal_m]
}

/// A step waits so long for a message, in nanoseconds of simulated time: what was lost does not come.
const PATIENCE_NS: u64 = 1_000_000_000;
