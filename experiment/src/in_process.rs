//! A world and its brains in one thread: lockstep without a network.

use std::sync::Arc;

use baudbot_brain::{Action, Belief, Body, Brain, RawCommands, Signals};
use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_sim::drive::Wheels;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Answer, Scenario, SimTime, World, Written};

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

struct Driver {
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

/// What a brain wants written.
enum Output {
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
        let driver = |spec: &RobotSpec| {
            let assignment = assignments.iter().find(|assignment| assignment.robots.contains(&spec.name));
            let make = |assignment: &Assignment| {
                Driver::new(spec, |body| Ok(catalogue::brain(&assignment.brain, scenario.seed, body)?))
            };
            assignment.map(make).transpose()
        };
        let brains = scenario.robots.iter().map(driver).collect::<Result<_, _>>()?;
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
        let mut outputs: Vec<(usize, SimTime, Output)> = Vec::new();
        for turn in turns {
            let Some(driver) = &mut self.brains[turn.robot] else { continue };
            let view = self.world.robot(turn.robot);
            let action = driver.brain.step(&self.world.turn_of(turn, &driver.body));
            let thinking_ns = thinking_ns(view.spec(), &action);
            let output = match (action.signals, action.poll) {
                (Some(Signals { left, right }), _) => {
                    let sequence = driver.commands.next_command(&action.others);
                    Output::Command { sequence, wheels: Wheels { left, right } }
                }
                (None, true) => Output::Bytes(driver.commands.poll().unwrap_or_default()),
                (None, false) => Output::Bytes(driver.commands.wait()),
            };
            outputs.push((turn.robot, turn.at + thinking_ns, output));
        }
        let others =
            |robot: usize| self.brains[robot].as_ref().map_or(&[][..], |driver| driver.commands.others());
        let answers: Vec<_> = outputs
            .iter()
            .map(|(robot, at, output)| {
                let written = match output {
                    Output::Bytes(bytes) => Written::Bytes(bytes),
                    Output::Command { sequence, wheels } => {
                        Written::Command { sequence: *sequence, wheels: *wheels, others: others(*robot) }
                    }
                };
                Answer { robot: *robot, at: *at, written }
            })
            .collect();
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
