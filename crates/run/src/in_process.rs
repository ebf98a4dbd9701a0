//! A world and its brains in one thread: lockstep without a network.

use std::sync::Arc;

use baudbot_brain::{Action, Belief, Body, Brain, RawCommands, Signals};
use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_sim::drive::Wheels;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Answer, Scenario, SimTime, Turn, World, Written};

use crate::assignment::Assignment;

/// A world and a brain for each of its robots, or for some of them.
pub struct InProcess {
    /// The world.
    pub world: World,
    brains: Vec<Option<Driver>>,
}

/// Why there is no brain for a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InProcessError {
    /// The catalogue has no such brain for it.
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    /// A single brain was given for several robots, or for none.
    #[error("the scenario must have one robot, it has {0}")]
    Robots(usize),
}

/// A brain with its robot's data sheet, in the process of its world.
pub struct Driver {
    body: Arc<Body>,
    brain: Box<dyn Brain + Send>,
    commands: RawCommands,
}

/// Runs a scenario with these brains, seeded with the scenario's seed, to its end, which it must have, and reads the
/// sensors a last time, as a server does. Says how the world then is.
///
/// # Errors
/// If the catalogue has no such brain for a robot.
pub fn run(scenario: Scenario, assignments: &[Assignment]) -> Result<World, InProcessError> {
    let mut local = InProcess::with_assignments(scenario, assignments)?;
    local.world.keep_timeline(0);
    local.run(u64::MAX);
    local.world.begin();
    Ok(local.world)
}

/// What a brain wants written, and when.
pub struct Output {
    robot: usize,
    at: SimTime,
    what: What,
}

enum What {
    Bytes(Vec<u8>),
    Command { sequence: u8, wheels: Wheels },
}

impl Driver {
    fn new(
        spec: &RobotSpec,
        brain: impl FnOnce(&Body) -> Result<Box<dyn Brain + Send>, InProcessError>,
    ) -> Result<Self, InProcessError> {
        let body = Arc::new(Body::from(spec));
        let commands = RawCommands::new(&body).expect("a scenario is read only if its messages fit the wire");
        Ok(Self { brain: brain(&body)?, body, commands })
    }

    /// A brain of the catalogue for each robot that an assignment names, seeded with the scenario's seed; `None` for the others.
    ///
    /// # Errors
    /// If the catalogue has no such brain for a robot.
    pub fn all(scenario: &Scenario, assignments: &[Assignment]) -> Result<Vec<Option<Self>>, InProcessError> {
        let driver = |spec: &RobotSpec| {
            let assignment = assignments.iter().find(|assignment| assignment.robots.contains(&spec.name));
            let make = |assignment: &Assignment| {
                Self::new(spec, |body| Ok(catalogue::brain(&assignment.brain, scenario.seed, body)?))
            };
            assignment.map(make).transpose()
        };
        scenario.robots.iter().map(driver).collect()
    }

    /// The brain's step at this turn of its robot's.
    pub fn step(&mut self, world: &World, turn: Turn) -> Output {
        let action = self.brain.step(&world.turn_of(turn, &self.body));
        let thinking_ns = thinking_ns(world.robot(turn.robot).spec(), &action);
        let what = match (action.signals, action.poll) {
            (Some(Signals { left, right }), _) => {
                let sequence = self.commands.next_command(&action.others);
                What::Command { sequence, wheels: Wheels { left, right } }
            }
            (None, true) => What::Bytes(self.commands.poll().unwrap_or_default()),
            (None, false) => What::Bytes(self.commands.wait()),
        };
        Output { robot: turn.robot, at: turn.at + thinking_ns, what }
    }
}

impl Output {
    /// As the world takes it, with what its driver, which is one of these, last sent to the actuators besides the wheels.
    pub fn answer<'a>(&'a self, drivers: &'a [Option<Driver>]) -> Answer<'a> {
        let written = match &self.what {
            What::Bytes(bytes) => Written::Bytes(bytes),
            What::Command { sequence, wheels } => {
                let driver = drivers[self.robot].as_ref();
                let others = driver.map_or(&[][..], |driver| driver.commands.others());
                Written::Command { sequence: *sequence, wheels: *wheels, others }
            }
        };
        Answer { robot: self.robot, at: self.at, written }
    }
}

impl InProcess {
    /// All robots get the brain that `brain` describes, seeded with the scenario's seed.
    ///
    /// # Errors
    /// If the catalogue has no such brain for a robot.
    pub fn new(scenario: Scenario, brain: &str) -> Result<Self, InProcessError> {
        let robots = scenario.robots.iter().map(|spec| spec.name.clone()).collect();
        Self::with_assignments(scenario, &[Assignment { brain: brain.to_owned(), robots }])
    }

    /// Each robot gets the brain of the assignment that names it, seeded with the scenario's seed; a robot that none names
    /// gets none.
    ///
    /// # Errors
    /// If the catalogue has no such brain for a robot.
    pub fn with_assignments(scenario: Scenario, assignments: &[Assignment]) -> Result<Self, InProcessError> {
        let brains = Driver::all(&scenario, assignments)?;
        Ok(Self { world: World::new(scenario.into()), brains })
    }

    /// As [`new`](Self::new), with a brain of the caller's own for the only robot.
    ///
    /// # Errors
    /// If there is not one robot.
    pub fn with_brain(
        scenario: Scenario,
        brain: impl Brain + Send + 'static,
    ) -> Result<Self, InProcessError> {
        let [spec] = scenario.robots.as_slice() else {
            return Err(InProcessError::Robots(scenario.robots.len()));
        };
        let brains = vec![Some(Driver::new(spec, |_| Ok(Box::new(brain)))?)];
        Ok(Self { world: World::new(scenario.into()), brains })
    }

    /// First half of a tick, the brains' steps, second half; `look` sees the world in between.
    pub fn tick(&mut self, look: impl FnOnce(&World)) {
        let turns = self.world.begin().to_vec();
        look(&self.world);
        let mut outputs: Vec<Output> = Vec::new();
        for turn in turns {
            outputs.extend(self.brains[turn.robot].as_mut().map(|driver| driver.step(&self.world, turn)));
        }
        let answers: Vec<_> = outputs.iter().map(|output| output.answer(&self.brains)).collect();
        self.world.finish_answers(&answers);
    }

    /// The belief of the brain of the robot in this place, as observers get it.
    pub fn belief(&mut self, robot: usize) -> Option<Belief> {
        self.brains.get_mut(robot)?.as_mut()?.brain.belief()
    }

    /// As many ticks, or fewer if the run ends.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            if self.world.ending().is_some() {
                return;
            }
            self.tick(|_| {});
        }
    }
}

/// How long a brain thought, as the server takes it.
fn thinking_ns(spec: &RobotSpec, action: &Action) -> u64 {
    let counted = action.operations.and_then(|operations| spec.processor.thinking_ns(operations));
    action.thinking.map(|time| time.as_nanos() as u64).or(counted).unwrap_or(spec.thinking_ns)
}
