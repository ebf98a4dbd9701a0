//! A brain that is driven in a test: a scenario and a brain in, what the robot did out. No network, no thread, no clock.

use std::sync::Arc;

use baudbot_brain::{Body, Brain};
use baudbot_fields::{FieldError, Path};
use baudbot_run::{DrivenWorld, Driver, LockstepWorld, Refusal};
use baudbot_sim::{Ending, Pose, RobotView, Scenario, SimTime, World};
use tonic::Status;

use crate::server::{ServerError, WorldConfig};

/// Lets a brain drive the only robot of a scenario for so many seconds of simulated time, or until the run ends for another
/// reason. It is the run of `baudbot run --seconds`, to the last bit: the time takes the place of the scenario's `end.after_s`.
///
/// ```
/// use baudbot_brain::{Action, Brain, Turn};
///
/// /// Drives on, and turns on the spot while something is near in front.
/// struct Timid;
///
/// impl Brain for Timid {
///     fn step(&mut self, turn: &Turn) -> Action {
///         let ahead = ["ir_front_left", "ir_front", "ir_front_right"];
///         let is_near = |sensor| turn.value(sensor).is_none_or(|nearness| nearness > 0.2);
///         let action = if ahead.into_iter().any(is_near) { Action::drive(0.5, -0.5) } else { Action::drive(0.4, 0.4) };
///         // One command for each message, and another if none comes for 0.1 s: the cable may have lost the last.
///         action.until_message_or(turn.at_ns + 100_000_000)
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scenario = baudbot_scenario::parse(include_str!("../../catalogue/scenarios/wander.toml"))?;
/// let drive = baudbot_server::drive(&scenario, Timid, 60.0)?;
/// assert!(drive.collisions.is_empty(), "{:?}", drive.collisions);
/// assert!(drive.distance_m() > 10.0, "{} m", drive.distance_m());
/// assert_eq!(drive.state_hash(), baudbot_server::drive(&scenario, Timid, 60.0)?.state_hash());
/// # Ok(())
/// # }
/// ```
///
/// A brain that is to be looked at afterwards is lent (`&mut brain`). Another seed is `scenario.seed = 2`, or an override of
/// the file's field (`baudbot_scenario::parse_with`).
///
/// # Errors
/// If there is not one robot, the time is none, or the brain does what its robot cannot do.
pub fn drive(scenario: &Scenario, brain: impl Brain, seconds: f64) -> Result<Drive, DriveError> {
    let [_] = scenario.robots.as_slice() else {
        return Err(DriveError::Robots(scenario.robots.len()));
    };
    let mut brain = Some(brain);
    let mut drives = drive_each(scenario, |_| brain.take(), seconds)?;
    Ok(drives.remove(0))
}

/// The same as [`drive`](drive()), for any number of robots: `brain` makes the brain of each from its data sheet; a
/// robot for which it makes none keeps still. The drives are in the order of the robots' names.
///
/// # Errors
/// If the time is none, or a brain does what its robot cannot do.
pub fn drive_each<B: Brain>(
    scenario: &Scenario,
    mut brain: impl FnMut(&Body) -> Option<B>,
    seconds: f64,
) -> Result<Vec<Drive>, DriveError> {
    let limit = SimTime::from_ns(Path::root().s("seconds", seconds, 1e-9, 1e8)?);
    let mut scenario = scenario.clone();
    scenario.end.after = Some(limit);
    let mut driver = |body: Body| {
        let brain = brain(&body)?;
        Some(Driver::new(body, brain))
    };
    let drivers: Vec<_> = scenario.robots.iter().map(|spec| driver(Body::from(spec))).collect();
    let mut state = World::new(scenario.into());
    state.keep_timeline(0);
    let mut run = DrivenWorld { world: WorldConfig::from_state("drive", state).direct()?, drivers };
    for robot in (0..run.drivers.len()).filter(|&robot| run.drivers[robot].is_some()) {
        run.world.attach("brain", &[robot]);
    }
    let mut traces = vec![Trace::default(); run.drivers.len()];
    let mut look = |world: &World| {
        traces.iter_mut().zip(world.robots()).for_each(|(trace, robot)| trace.look(world, &robot));
    };
    look(run.world.world());
    while run.advance(|_| Ok(()))? {
        look(run.world.world());
    }
    look(run.world.world());
    let world = Arc::new(run.world.world().clone());
    let ending = world.ending().expect("it was driven until it ended");
    let drive = |(place, Trace { path, collisions }): (usize, Trace)| Drive {
        robot: world.scenario().robots[place].name.clone(),
        path,
        collisions,
        ending: ending.clone(),
        world: Arc::clone(&world),
        place,
    };
    Ok(traces.into_iter().enumerate().map(drive).collect())
}

/// The true course of a robot: a brain never knows it.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Name of the robot.
    pub robot: String,
    /// The places: at the start, and after each tick.
    pub path: Vec<PathPoint>,
    /// The collisions, in order.
    pub collisions: Vec<DriveCollision>,
    /// The reason for the end of the run.
    pub ending: Ending,
    /// The world at the end, with all that was counted (`world.score()`, `world.robots()`).
    pub world: Arc<World>,
    place: usize,
}

/// The place of a robot at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// The instant, in seconds of simulated time.
    pub time_s: f64,
    /// The true pose of its centre, world from robot: metres and radians.
    pub pose: Pose,
}

/// A collision of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveCollision {
    /// The end of the tick in which it did, in seconds of simulated time.
    pub time_s: f64,
    /// Name of the shape, the thing or the other robot.
    pub with: String,
}

impl Drive {
    /// The instant at which the run ended, in seconds of simulated time.
    pub fn time_s(&self) -> f64 {
        self.world.time().as_seconds()
    }

    /// Distance that the robot's centre has travelled, in metres, forwards and backwards added.
    pub fn distance_m(&self) -> f64 {
        self.world.robot(self.place).counters().distance_m
    }

    /// The fingerprint of the whole world at the end, the one of `baudbot run`: equal for equal bits, on every machine.
    pub fn state_hash(&self) -> u64 {
        self.world.hash()
    }
}

/// A reason why there is no drive.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// One brain was given, and there is not one robot.
    #[error("the scenario must have one robot, it has {0}; `drive_each` makes a brain for each")]
    Robots(usize),
    /// The time is no time of a run.
    #[error(transparent)]
    Seconds(#[from] FieldError),
    /// The world cannot be made.
    #[error(transparent)]
    World(#[from] ServerError),
    /// A brain did what its robot cannot do.
    #[error("at {time_s} s the brain of `{robot}` failed: {}", status.message())]
    Brain {
        /// Name of the robot.
        robot: String,
        /// The instant of its step, in seconds of simulated time.
        time_s: f64,
        /// The status of the server.
        status: Box<Status>,
    },
}

/// The path and the collisions of a robot.
#[derive(Clone, Default)]
struct Trace {
    path: Vec<PathPoint>,
    collisions: Vec<DriveCollision>,
}

impl From<Refusal<Status>> for DriveError {
    fn from(Refusal { robot, turn, error }: Refusal<Status>) -> Self {
        Self::Brain { robot, time_s: turn.at.as_seconds(), status: error.into() }
    }
}

impl Trace {
    /// Takes a look at the world between two ticks.
    fn look(&mut self, world: &World, robot: &RobotView<'_>) {
        let time_s = world.time().as_seconds();
        self.path.push(PathPoint { time_s, pose: robot.motion().pose });
        let own = world.collisions().iter().filter(|collision| collision.robot == robot.spec().name);
        self.collisions.extend(own.map(|collision| DriveCollision { time_s, with: collision.with.clone() }));
    }
}

#[cfg(test)]
mod tests {
    use baudbot_brain::Action;

    use super::*;

    /// Drives straight on, and counts its steps.
    #[derive(Default)]
    struct Straight {
        steps: u64,
        left: f64,
    }

    impl Brain for Straight {
        fn step(&mut self, _: &baudbot_brain::Turn) -> Action {
            self.steps += 1;
            Action::drive(0.5 + self.left, 0.5)
        }
    }

    fn wander() -> Scenario {
        baudbot_scenario::parse(include_str!("../../catalogue/scenarios/wander.toml")).unwrap()
    }

    /// Two robots that stand side by side in the open.
    fn two() -> Scenario {
        let robot = |name: &str, y: f64| {
            format!("[[robots]]\nname = \"{name}\"\npreset = \"khepera-1\"\nstart.y_m = {y:?}\n")
        };
        baudbot_scenario::parse(&(robot("bob", 1.0) + &robot("alice", 0.0))).unwrap()
    }

    #[test]
    fn a_drive_has_its_path_its_end_and_the_brain_that_was_lent() {
        let mut brain = Straight::default();
        let drive = drive(&wander(), &mut brain, 1.0).unwrap();
        assert_eq!((&drive.ending, drive.time_s()), (&Ending::TimeIsOver, 1.0));
        assert_eq!(drive.path.len(), 101);
        assert_eq!(drive.path[0].time_s, 0.0);
        let way = drive.path[100].pose.position - drive.path[0].pose.position;
        assert!((way.norm() - drive.distance_m()).abs() < 1e-6, "{way} {}", drive.distance_m());
        assert!(drive.collisions.is_empty() && brain.steps > 0, "{:?} {}", drive.collisions, brain.steps);
    }

    #[test]
    fn a_collision_is_told_with_its_time_and_ends_a_run_whose_policy_says_so() {
        let mut scenario = wander();
        let ended = drive(&scenario, Straight::default(), 60.0).unwrap();
        let [collision] = ended.collisions.as_slice() else { panic!("{:?}", ended.collisions) };
        assert_eq!((collision.with.as_str(), collision.time_s), ("wall_right", ended.time_s()));
        assert!(matches!(&ended.ending, Ending::Collision(_)), "{:?}", ended.ending);
        scenario.collision = baudbot_sim::collision::CollisionPolicy::StopRobot;
        let stopped = drive(&scenario, Straight::default(), 60.0).unwrap();
        assert_eq!(stopped.time_s(), 60.0);
        assert_eq!(stopped.collisions[0].time_s, collision.time_s);
    }

    #[test]
    fn robots_have_a_brain_each_or_none() {
        let only_bob = |body: &Body| (body.name == "bob").then(Straight::default);
        let drives = drive_each(&two(), only_bob, 2.0).unwrap();
        let names: Vec<_> = drives.iter().map(|drive| drive.robot.as_str()).collect();
        assert_eq!(names, ["alice", "bob"]);
        assert_eq!(drives[0].distance_m(), 0.0);
        assert!(drives[1].distance_m() > 0.1, "{}", drives[1].distance_m());
        assert_eq!(drives[0].state_hash(), drives[1].state_hash());
    }

    #[test]
    fn what_cannot_be_driven_is_told_in_a_sentence() {
        let text = |scenario: &Scenario, brain: Straight, seconds: f64| {
            drive(scenario, brain, seconds).unwrap_err().to_string()
        };
        let robots = "the scenario must have one robot, it has 2; `drive_each` makes a brain for each";
        assert_eq!(text(&two(), Straight::default(), 1.0), robots);
        for seconds in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
            let error = text(&wander(), Straight::default(), seconds);
            assert!(error.starts_with("seconds: must be between "), "{error}");
        }
        let error = text(&wander(), Straight { left: f64::NAN, ..Straight::default() }, 1.0);
        assert!(error.starts_with("at 0.") && error.contains("the brain of `robot` failed: "), "{error}");
    }
}
