//! The world: the flow of Fig. 3.1 in two halves, with the brains between them.

mod answer;
mod ending;
mod frozen;
mod inputs_by_robot;
mod intervention;
mod lookahead;
mod motion;
mod ports;
mod probe;
mod reseed;
mod saved;
mod score;
mod spare;
mod starts;
mod timelines;
mod trails;
mod within;

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::collision::Collision;
use crate::hash;
use crate::heap;
use crate::model::RobotSpec;
use crate::movable::MovableState;
use crate::mover::MoverState;
use crate::parallel;
use crate::robot::{Robot, Tick};
use crate::scenario::Scenario;
use crate::scene::Frozen;
use crate::time::SimTime;
use crate::trail::Trails;
use crate::view::{RobotView, ThingView};
pub use answer::Answer;
pub use ending::Ending;
use intervention::Altered;
pub use intervention::{Intervention, InterventionError};
use lookahead::Ahead;
pub use saved::SavedError;
pub use score::Score;
use spare::Spare;

/// A world: a scenario, which changes by hand alone, and a state, which is a value: a snapshot is a clone.
///
/// ```
/// # fn main() -> Result<(), baudbot_scenario::ScenarioError> {
/// use baudbot_sim::World;
/// let scenario = baudbot_scenario::parse(
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
    /// The scenario of which the world was made.
    origin: Arc<Scenario>,
    /// The scenario as it is now: a [manual change](Self::intervene) makes it another one from then on.
    scenario: Arc<Scenario>,
    pub(crate) altered: Altered,
    state: State,
    /// What robots have added to fields.
    trails: Trails,
    /// The view of sensors in the tick that is begun: it follows from the state, and is kept for the tick's second half.
    seen: Option<Box<Frozen>>,
    ahead: Ahead,
    spare: Spare,
    is_parallel: bool,
    /// Whether a robot may ask for another baud rate.
    may_change_baud: bool,
}

/// All of the world that changes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    tick: u64,
    begun: bool,
    pub(crate) robots: Vec<Robot>,
    pub(crate) movers: Vec<MoverState>,
    pub(crate) movables: Vec<MovableState>,
    pub(crate) score: Score,
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

/// The output of a brain in its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input<'a> {
    /// Index of its robot. An index that no robot has is ignored.
    pub robot: usize,
    /// The instant at which the bytes are handed to the port, and the brain is free again. Taken as the instant of the
    /// brain's last step if it is earlier than that.
    pub at: SimTime,
    /// Bytes for the microcontroller; may be empty.
    pub bytes: &'a [u8],
}

impl World {
    /// The bytes that its state takes in memory, without the scenario, which clones share
    /// ([`Scenario::memory_bytes`]). It is walked as for [`hash`](Self::hash), and takes about as long. Timelines are counted as
    /// they are when they are full.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>()
            + heap::of(&self.state)
            + heap::of(&self.trails)
            + heap::of(&self.altered)
            + self.state.robots.iter().map(|robot| robot.unsaved_bytes()).sum::<usize>()
            + self.state.score.coverage().map_or(0, crate::coverage::Coverage::heap_bytes)
    }

    /// A world at its start.
    pub fn new(scenario: Arc<Scenario>) -> Self {
        let robot = |spec| Robot::new(spec, scenario.seed, scenario.noise);
        let robots: Vec<_> = scenario.robots.iter().map(robot).collect();
        let state = State {
            tick: 0,
            begun: false,
            robots,
            movers: scenario.movers.iter().map(|mover| mover.at_start(scenario.seed)).collect(),
            movables: scenario.movables.iter().map(|movable| movable.at_start()).collect(),
            score: Score::new(&scenario),
            turns: Vec::new(),
            collisions: Vec::new(),
            ending: None,
        };
        let (ahead, spare, seen) = (Ahead::default(), Spare::default(), None);
        let is_parallel = cfg!(feature = "rayon") && state.robots.len() >= CROWD;
        let (origin, altered) = (Arc::clone(&scenario), Altered::default());
        let trails = scenario.trails();
        let changes = |spec: &RobotSpec| spec.firmware.protocol.changes_baud();
        let may_change_baud = scenario.robots.iter().any(changes);
        let mut world = Self {
            origin,
            scenario,
            altered,
            state,
            trails,
            seen,
            ahead,
            spare,
            is_parallel,
            may_change_baud,
        };
        world.keep_timeline(world.usual_timeline());
        for (robot, spec) in world.state.robots.iter_mut().zip(&world.scenario.robots) {
            robot.note_first_questions(spec);
        }
        world
    }

    /// Whether ticks use all threads of the rayon pool that they are called in, where there are enough robots for it.
    /// Worlds of 256 robots and more do so by default. Makes no difference to any bit.
    #[cfg(feature = "rayon")]
    pub fn set_parallel(&mut self, is_parallel: bool) {
        self.is_parallel = is_parallel;
    }

    /// First half of a tick: the scene is frozen, sensors that are due sample it, the microcontrollers read and send,
    /// and what arrives is there for the brains. Returns which brains step now. A second call without
    /// [`finish`](Self::finish) in between changes nothing.
    ///
    /// In a run that has ended this reads the sensors a last time at the state that it ended in, and no
    /// brain steps.
    pub fn begin(&mut self) -> &[Turn] {
        if !core::mem::replace(&mut self.state.begun, true) {
            self.state.turns.clear();
            self.spare.starts.take(&mut self.state.robots);
            let mut frozen = self.spare.frozen.take().unwrap_or_default();
            self.freeze(&mut frozen);
            let mut steps = core::mem::take(&mut self.spare.steps);
            steps.clear();
            steps.resize(self.state.robots.len(), None);
            let (now, end, ended) = (self.time(), self.tick_end(), self.state.ending.is_some());
            let (scenario, trails) = (&*self.scenario, &self.trails);
            parallel::each(self.is_parallel, &mut self.state.robots, &mut steps, |own, robot, step| {
                let scene = scenario.scene(&frozen, trails, own);
                let tick = Tick {
                    scene: &scene,
                    noise: scenario.noise,
                    start: now,
                    end,
                    substeps: scenario.substeps,
                };
                *step = robot.listen(&scenario.robots[own], &tick, ended);
            });
            let turns = steps.iter().enumerate().filter_map(|(robot, at)| Some(Turn { robot, at: (*at)? }));
            self.state.turns.extend(turns);
            self.spare.steps = steps;
            self.seen = Some(frozen);
        }
        &self.state.turns
    }

    /// Second half of a tick: what the brains wrote travels the links, the microcontrollers obey what has
    /// arrived, motors push, bodies move, collisions and the scenario's ends are looked at. Does nothing
    /// unless [`begin`](Self::begin) came first, and nothing once the run has ended.
    pub fn finish(&mut self, inputs: &[Input<'_>]) {
        self.finish_with(inputs, |&input| Answer::from(input));
    }

    /// Second half of a tick, with whatever the brains' answers are read from.
    fn finish_with<'a, T: Sync>(
        &mut self,
        inputs: &'a [T],
        answer: impl Fn(&'a T) -> Answer<'a> + Sync + Send,
    ) {
        if !self.state.begun || self.state.ending.is_some() {
            return;
        }
        let frozen = self.seen.take().unwrap_or_else(|| Box::new(self.frozen()));
        let (start, end) = (self.time(), self.tick_end());
        let Self { scenario, state, trails, spare, ahead, is_parallel, .. } = self;
        let (scenario, trails) = (&**scenario, &*trails);
        spare.note_steps(&state.turns, state.robots.len());
        spare.inputs_by_robot.note(inputs.iter().map(|input| answer(input).robot), state.robots.len());
        let tick = state.tick;
        // All of a robot's at once: it is seldom that a crowd is in the processor's near memory.
        let Spare { inputs_by_robot, steps, .. } = spare;
        parallel::each(*is_parallel, &mut state.robots, steps, |own, robot, step| {
            let spec = &scenario.robots[own];
            if let Some(at) = *step {
                robot.hand_over(tick, at, scenario.step_ns);
            }
            for input in inputs_by_robot.of(own).map(|i| answer(&inputs[i])) {
                robot.answer(spec, input.at, &input.written);
            }
            if let Some(at) = step.filter(|&at| !ahead.holds(&Turn { robot: own, at })) {
                robot.step_over(spec, at);
            }
            robot.send_written(spec, step.unwrap_or(start));
            let scene = scenario.scene(&frozen, trails, own);
            let tick = Tick { scene: &scene, noise: scenario.noise, start, end, substeps: scenario.substeps };
            robot.advance(spec, &tick, end, None);
            robot.lay_down_command(spec);
            robot.look_for_losses(end);
            robot.start_moving(spec, scenario.noise);
        });
        self.spare.frozen = Some(frozen);
        self.move_all();
        self.scenario.pass_trails(&mut self.trails, &self.state.robots, &mut self.spare.rows);
        self.state.tick += 1;
        self.state.begun = false;
        self.change_bauds();
        self.look_for_the_end();
    }

    /// The output of this robot's brain in the tick that is begun does not answer its step in this tick but in that
    /// one: in real time a brain may be late. It matters to [`Cycles`](crate::robot::Cycles) alone.
    pub fn answers(&mut self, robot: usize, tick: u64) {
        if let Some(robot) = self.state.robots.get_mut(robot) {
            robot.laptop.answers_tick = Some(tick).filter(|_| tick != self.state.tick);
        }
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
                self.state.ending = Some(Ending::GoalReached(self.scenario.robots[i].name.clone()));
                return;
            }
        }
        if let Some(ending) = self.judge() {
            self.state.ending = Some(ending);
            return;
        }
        if self.scenario.end.after.is_some_and(|after| self.time() >= after) {
            self.state.ending = Some(Ending::TimeIsOver);
        }
    }

    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Whether it is within a tick: between [`begin`](Self::begin) and [`finish`](Self::finish).
    pub fn is_begun(&self) -> bool {
        self.state.begun
    }

    pub(crate) fn scenario_mut(&mut self) -> &mut Scenario {
        Arc::make_mut(&mut self.scenario)
    }

    pub(crate) fn state_mut(&mut self) -> &mut State {
        &mut self.state
    }

    /// The scenario that the world was made from.
    pub fn origin(&self) -> &Arc<Scenario> {
        &self.origin
    }

    /// The scenario of the world: its [origin](Self::origin), but for changes by hand.
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

    /// The brains that step in the tick that is begun.
    pub fn turns(&self) -> &[Turn] {
        &self.state.turns
    }

    /// The reason for the end of the run, if it has ended.
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
        RobotView::new(&self.scenario.robots[i], &self.state.robots[i])
    }

    /// The things that move by themselves, then those that robots push, each in the scenario's order.
    pub fn things(&self) -> impl Iterator<Item = ThingView<'_>> {
        let movers = self.scenario.movers.iter().zip(&self.state.movers);
        let movables = self.scenario.movables.iter().zip(&self.state.movables);
        movers.map(ThingView::of_mover).chain(movables.map(ThingView::of_movable))
    }

    /// The counts of the referee.
    pub fn score(&self) -> &Score {
        &self.state.score
    }

    /// A fingerprint of the whole state: equal for equal bits, on every machine.
    pub fn hash(&self) -> u64 {
        match (self.altered.is_empty(), self.trails.is_empty()) {
            (true, true) => hash::of(&self.state),
            (false, true) => hash::of(&(&self.state, &self.altered)),
            (_, false) => hash::of(&(&self.state, &self.altered, &self.trails)),
        }
    }
}

/// The number of robots from which on several threads move them: the work of a tick is then well above what it costs to call them.
const CROWD: usize = 256;
