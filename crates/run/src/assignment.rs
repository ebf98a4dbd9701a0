//! The assignment of brains to robots.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_client::Error;
#[cfg(feature = "programs")]
use baudbot_proto::v1;
use baudbot_sim::model::{RobotModel, RobotSpec, Writes};
use baudbot_sim::sensor::Device;
use wildmatch::WildMatch;

#[cfg(feature = "programs")]
use crate::programs::Held;
use crate::programs::{BadProgram, EXEC, PROGRAM, PortProgram, PortTask, Program, Task};
use crate::suggest::UnknownName;

/// The drivers of the robots of a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assigned {
    /// Brains of the catalogue.
    pub brains: Vec<Assignment>,
    /// Programs of the user's own.
    pub programs: Vec<Task>,
    /// Programs at serial ports, in simulated time.
    pub at_ports: Vec<PortTask>,
}

/// Robots that one kind of brain drives, each robot with a brain of its own, over one stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// The brain in the catalogue's form: `NAME[:K=V,…]`.
    pub brain: String,
    /// The names of the robots.
    pub robots: Vec<String>,
}

impl Assigned {
    /// The driver of a robot, in the words of the request.
    pub fn brain_of(&self, robot: &str) -> Option<String> {
        let is_its = |robots: &[String]| robots.iter().any(|name| name == robot);
        let brain = self.brains.iter().find(|brain| is_its(&brain.robots)).map(|brain| brain.brain.clone());
        let program = || self.programs.iter().find(|task| is_its(&task.robots));
        let at_port = || self.at_ports.iter().find(|task| task.robot == robot);
        brain
            .or_else(|| program().map(|task| format!("{EXEC}{}", task.program)))
            .or_else(|| at_port().map(|task| format!("{PROGRAM}{}", task.program)))
    }

    /// States of robots when their brains write, unless their scenario does: of a brain of the catalogue by the
    /// catalogue; a program is taken to answer messages only.
    ///
    /// # Errors
    /// If the catalogue has no such brain.
    pub fn state_writes(&self, robots: &mut [RobotSpec]) -> Result<(), CatalogueError> {
        let mut of: HashMap<&str, Writes> = HashMap::new();
        for Assignment { brain, robots } in &self.brains {
            let writes = catalogue::writes(brain)?;
            of.extend(robots.iter().map(|robot| (robot.as_str(), writes)));
        }
        // Robots that share a model go on doing so.
        let mut last: Option<(Arc<RobotModel>, Writes, Arc<RobotModel>)> = None;
        for spec in robots.iter_mut().filter(|spec| spec.writes.is_none()) {
            let writes = of.get(spec.name.as_str()).copied().unwrap_or_default();
            let shared =
                last.as_ref().filter(|(old, its, _)| Arc::ptr_eq(old, &spec.model) && *its == writes);
            let new = shared.map_or_else(
                || Arc::new(RobotModel { writes: Some(writes), ..RobotModel::clone(&spec.model) }),
                |(_, _, new)| Arc::clone(new),
            );
            let old = std::mem::replace(&mut spec.model, Arc::clone(&new));
            last = Some((old, writes, new));
        }
        Ok(())
    }

    /// Sets a parameter of all brains that have it. The parameters of a program are known only to itself.
    ///
    /// # Errors
    /// If no brain has it.
    pub fn set_parameter(&mut self, name: &str, value: &str) -> Result<(), UnknownName> {
        let mut known = Vec::new();
        let mut found = !self.programs.is_empty();
        for task in self.at_ports.iter_mut().filter(|task| task.program.takes(name)) {
            task.parameters.insert(name.to_owned(), value.to_owned());
            found = true;
        }
        for task in &mut self.programs {
            let text = || serde_json::Value::String(value.to_owned());
            let value = serde_json::from_str(value).unwrap_or_else(|_| text());
            task.parameters.insert(name.to_owned(), value);
        }
        for assignment in &mut self.brains {
            if catalogue::takes(&assignment.brain, name) {
                let and = if assignment.brain.contains(':') { ',' } else { ':' };
                assignment.brain += &format!("{and}{name}={value}");
                found = true;
            }
            known.extend(catalogue::parameters(&assignment.brain));
        }
        if found { Ok(()) } else { Err(UnknownName::new("parameter of a brain", name, &known)) }
    }

    /// The robots of a world, with whether they are held and whether they should be.
    #[cfg(feature = "programs")]
    pub fn held(&self, status: &v1::WorldStatus) -> Vec<Held> {
        let held = |robot: &v1::RobotStatus| Held {
            robot: robot.robot.clone(),
            held: robot.attached,
            expected: self.brain_of(&robot.robot).is_some(),
        };
        status.robots.iter().map(held).collect()
    }
}

/// The reason why robots have not got their brains, or lost them.
#[derive(Debug, thiserror::Error)]
pub enum AssignmentError {
    /// A brain is for a robot that is not there.
    #[error(
        "{} `{robot}`; there are: {}",
        if is_pattern(robot) { "no robot has a name like" } else { "there is no robot" },
        known.join(", ")
    )]
    Robot {
        /// The name given.
        robot: String,
        /// The robots that exist.
        known: Vec<String>,
    },
    /// There are two brains for the same robot, or for all robots.
    #[error("{whom} can have only one brain")]
    Twice {
        /// The robots with two brains.
        whom: String,
    },
    /// The default brain is for robots that see.
    #[error(
        "robot `{robot}` has no IR sensors, so the default brain `{DEFAULT}` cannot drive it; name another as \
         {robot}=NAME (`baudbot brain --list` lists them; `none` is no brain)"
    )]
    Blind {
        /// The robot.
        robot: String,
    },
    /// A brain of messages is for a robot whose microcontroller speaks a language of its own.
    #[error(
        "the microcontroller of robot `{robot}` runs a program of its own, which brain `{brain}` does not understand; if the program \
         speaks \"framed\" or \"bare\", set firmware.protocol, otherwise leave the robot without a brain ({robot}=none)"
    )]
    OwnProgram {
        /// The robot.
        robot: String,
        /// The brain.
        brain: String,
    },
    /// The catalogue has no such brain for a robot.
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    /// The text behind `exec:` or `program:` is no program.
    #[error(transparent)]
    Program(#[from] BadProgram),
    /// One program attaches to a server, and another is on the thread of its world.
    #[error(
        "`{at_port}` runs in simulated time, on the thread of its world, and `{attached}` attaches to a server; let both be of one kind"
    )]
    Mixed {
        /// The one with ports.
        at_port: String,
        /// The other one.
        attached: String,
    },
    /// A stream to a server failed.
    #[error(transparent)]
    Client(#[from] Error),
}

/// Shares the robots out to brains: `NAME[:K=V,…]`, or `exec:PROGRAM`, for all that no `ROBOT=BRAIN` names. Without any for
/// all, those that are not named get the default brain. A robot may be named by a pattern (`cell-*`), too, and the name of a
/// table with `starts` is for all robots of that: its own name comes first, then the table's, then the first pattern that
/// matches.
///
/// # Errors
/// If a robot is not there, has two brains, or cannot see and is given none; if a program cannot be read.
pub fn assign(brains: &[String], robots: &[RobotSpec]) -> Result<Assigned, AssignmentError> {
    let brains = parse(brains)?;
    for (robot, _) in brains.iter().filter_map(|(robot, brain)| Some((robot.as_ref()?, brain))) {
        let is_meant = |spec: &RobotSpec| {
            spec.name == *robot || spec.table_name() == *robot || matches(robot, &spec.name)
        };
        if !robots.iter().any(is_meant) {
            let mut known: Vec<_> = robots.iter().map(|spec| spec.name.clone()).collect();
            alphanumeric_sort::sort_str_slice(&mut known);
            return Err(AssignmentError::Robot { robot: (*robot).to_owned(), known });
        }
    }
    let mut shared: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for spec in robots {
        let brain = match brain_for(spec, &brains) {
            Some(brain) if drives_itself(spec) => understood(spec, brain, &brains, robots.len() == 1)?,
            Some(brain) => brain,
            None if drives_itself(spec) => NONE,
            None if has_infrared(spec) => DEFAULT,
            None => return Err(AssignmentError::Blind { robot: spec.name.clone() }),
        };
        if brain != NONE {
            shared.entry(brain).or_default().push(spec.name.clone());
        }
    }
    shared.into_iter().try_fold(Assigned::default(), with_brain).and_then(of_one_kind)
}

/// The assignment with a brain for these robots besides.
fn with_brain(
    mut assigned: Assigned,
    (brain, robots): (&str, Vec<String>),
) -> Result<Assigned, AssignmentError> {
    if let Some(program) = PortProgram::of_brain(brain) {
        // Each robot has a process of its own: a program knows one set of ports.
        let program = program?;
        assigned.at_ports.extend(robots.into_iter().map(|robot| PortTask::new(program.clone(), robot)));
    } else if let Some(program) = Program::of_brain(brain) {
        assigned.programs.push(Task::new(program?, robots));
    } else {
        assigned.brains.push(Assignment { brain: brain.to_owned(), robots });
    }
    Ok(assigned)
}

/// Programs all attach to a server, or are all on the thread of their world.
fn of_one_kind(assigned: Assigned) -> Result<Assigned, AssignmentError> {
    if let (Some(task), Some(program)) = (assigned.at_ports.first(), assigned.programs.first()) {
        return Err(AssignmentError::Mixed {
            at_port: format!("{PROGRAM}{}", task.program),
            attached: format!("{EXEC}{}", program.program),
        });
    }
    Ok(assigned)
}

/// The drivers that may attach to a microcontroller with a program of the user's own: another such program. A brain of
/// messages that is for all of several robots is not meant for that one.
fn understood<'a>(
    spec: &RobotSpec,
    brain: &'a str,
    brains: &[(Option<&str>, &str)],
    is_alone: bool,
) -> Result<&'a str, AssignmentError> {
    if brain == NONE || brain.starts_with(EXEC) || brain.starts_with(PROGRAM) {
        return Ok(brain);
    }
    let is_named = brains.iter().any(|(robot, named)| robot.is_some() && *named == brain);
    if !is_named && !is_alone {
        return Ok(NONE);
    }
    Err(AssignmentError::OwnProgram { robot: spec.name.clone(), brain: brain.to_owned() })
}

/// Whether only a program of the user's own understands its microcontroller, which runs another one.
fn drives_itself(spec: &RobotSpec) -> bool {
    spec.chip.as_ref().is_some_and(|chip| chip.is_opaque())
}

/// The brain that a robot is given.
fn brain_for<'a>(spec: &RobotSpec, brains: &[(Option<&str>, &'a str)]) -> Option<&'a str> {
    let named = |name: Option<&str>| brains.iter().find(|(robot, _)| *robot == name);
    let by_pattern =
        || brains.iter().find(|(robot, _)| robot.is_some_and(|robot| matches(robot, &spec.name)));
    let found = named(Some(&spec.name)).or_else(|| named(Some(spec.table_name()))).or_else(by_pattern);
    found.or_else(|| named(None)).map(|(_, brain)| *brain)
}

/// Whether `ROBOT=BRAIN` names this robot, its table, or a pattern that it matches.
pub fn is_for(text: &str, spec: &RobotSpec) -> bool {
    let (robot, _) = split(text);
    robot.is_some_and(|robot| spec.name == robot || spec.table_name() == robot || matches(robot, &spec.name))
}

/// Whether this means all names that match it.
fn is_pattern(text: &str) -> bool {
    text.contains(['*', '?'])
}

/// Whether a name is one that a pattern with `*` and `?` means.
fn matches(pattern: &str, name: &str) -> bool {
    is_pattern(pattern) && WildMatch::new(pattern).matches(name)
}

/// The names that are meant: a name itself, or those that a pattern matches, in their natural order (`cell-2` before
/// `cell-10`), each once.
///
/// # Errors
/// If one means none of those that are there.
pub fn named(patterns: &[String], there: &[String]) -> Result<Vec<String>, AssignmentError> {
    let mut sorted = there.to_vec();
    alphanumeric_sort::sort_str_slice(&mut sorted);
    let mut found: Vec<String> = Vec::new();
    for pattern in patterns {
        let before = found.len();
        let meant = |name: &&String| *name == pattern || matches(pattern, name);
        let mut any = false;
        for name in sorted.iter().filter(meant) {
            any = true;
            if !found[..before].contains(name) {
                found.push(name.clone());
            }
        }
        if !any {
            return Err(AssignmentError::Robot { robot: pattern.clone(), known: sorted });
        }
    }
    Ok(found)
}

/// Brains with the robot that each is for; `None` is every robot that is not named.
fn parse(brains: &[String]) -> Result<Vec<(Option<&str>, &str)>, AssignmentError> {
    let mut all: Vec<(Option<&str>, &str)> = Vec::new();
    for text in brains {
        let (robot, brain) = split(text);
        if all.iter().any(|(other, _)| *other == robot) {
            let whom = robot.map_or_else(|| "all robots".to_owned(), |robot| format!("robot `{robot}`"));
            return Err(AssignmentError::Twice { whom });
        }
        all.push((robot, brain));
    }
    Ok(all)
}

/// The robot that a brain is for, if it names one, and the brain.
pub fn split(text: &str) -> (Option<&str>, &str) {
    // The settings behind a colon have equals signs, too.
    let name = text.split(':').next().unwrap_or_default();
    match name.split_once('=') {
        Some((robot, _)) => (Some(robot), &text[robot.len() + 1..]),
        None => (None, text),
    }
}

/// Whether the default brain can drive this robot.
pub fn sees(spec: &RobotSpec) -> bool {
    has_infrared(spec) && !drives_itself(spec)
}

/// A brain that can drive this robot: the default one if it sees enough, else one that is blind.
pub fn fitting_brain(spec: &RobotSpec) -> &'static str {
    if has_infrared(spec) { DEFAULT } else { "wander" }
}

fn has_infrared(spec: &RobotSpec) -> bool {
    spec.sensors.iter().any(|sensor| matches!(sensor.device, Device::Infrared(_)))
}

/// The brain of a robot that is given none.
pub const DEFAULT: &str = "avoid";

/// The time that a program has until it holds its robots. Some load much before that.
pub const START_PATIENCE: Duration = Duration::from_secs(60);

/// The word for no brain.
pub const NONE: &str = "none";

#[cfg(test)]
mod tests {

    use super::*;

    fn assignments(arguments: &[&str]) -> Result<Vec<(String, Vec<String>)>, String> {
        let robot = |name: &str, x: f64, sensors: &str| {
            format!(
                "[[robots]]\nname = \"{name}\"\nstart.x_m = {x:?}\n{sensors}\n\
                 body = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }}\n"
            )
        };
        let ir = "sensors.front = { kind = \"ir\", bearing_rad = 0.0, rays = 1, opening_rad = 0.0, range_m = 1.0, c1_m2 = 0.03, c2 = 0.1 }";
        let toml = robot("alice", 0.0, ir) + &robot("bob", 1.0, "") + &robot("carol", 2.0, ir);
        let scenario = baudbot_scenario::parse(&toml).map_err(|error| error.to_string())?;
        let arguments: Vec<_> = arguments.iter().map(|&argument| argument.to_owned()).collect();
        let assignments = assign(&arguments, &scenario.robots).map_err(|error| error.to_string())?;
        Ok(assignments.brains.into_iter().map(|assignment| (assignment.brain, assignment.robots)).collect())
    }

    fn assignment(brain: &str, robots: &[&str]) -> (String, Vec<String>) {
        (brain.to_owned(), robots.iter().map(|&robot| robot.to_owned()).collect())
    }

    #[test]
    fn robots_are_shared_out() {
        let all = ["alice", "bob", "carol"];
        assert_eq!(assignments(&["constant:left=0.5"]), Ok(vec![assignment("constant:left=0.5", &all)]));
        assert_eq!(assignments(&["bob=none"]), Ok(vec![assignment("avoid", &["alice", "carol"])]));
        let mixed = assignments(&["bob=constant:left=0.1,right=0.2", "wander"]);
        let expected = vec![
            assignment("constant:left=0.1,right=0.2", &["bob"]),
            assignment("wander", &["alice", "carol"]),
        ];
        assert_eq!(mixed, Ok(expected));
        assert_eq!(assignments(&["none"]), Ok(vec![]));
    }

    #[test]
    fn a_brain_may_be_for_all_robots_of_a_table() {
        let toml = "[[robots]]\nname = \"ant\"\nstarts = [{}, { x_m = 1.0 }, { x_m = 2.0, name = \"queen\" }]\n\
                    body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }\n";
        let scenario = baudbot_scenario::parse(toml).unwrap();
        let arguments = ["constant", "ant=wander", "queen=none"].map(str::to_owned);
        let assignments = assign(&arguments, &scenario.robots).unwrap();
        assert_eq!(
            assignments.brains,
            [Assignment { brain: "wander".to_owned(), robots: vec!["ant-1".into(), "ant-2".into()] }]
        );
    }

    #[test]
    fn patterns_and_programs_have_their_robots() {
        let brains =
            ["*o*=wander", "alice=exec:python3 'my follow.py' --gain=2", "exec:./a"].map(str::to_owned);
        let body = "body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
        let robots: String = [("alice", 0), ("bob", 1), ("carol", 2), ("dan", 3)]
            .map(|(name, x)| format!("[[robots]]\nname = \"{name}\"\nstart.x_m = {x}.0\n{body}\n"))
            .concat();
        let scenario = baudbot_scenario::parse(&robots).unwrap();
        let assigned = assign(&brains, &scenario.robots).unwrap();
        assert_eq!(
            assigned.brains,
            [Assignment { brain: "wander".to_owned(), robots: vec!["bob".into(), "carol".into()] }]
        );
        let programs: Vec<_> =
            assigned.programs.iter().map(|task| (task.program.to_string(), task.robots.clone())).collect();
        let expected = [("./a", "dan"), ("python3 'my follow.py' --gain=2", "alice")];
        assert_eq!(programs, expected.map(|(program, robot)| (program.to_owned(), vec![robot.to_owned()])));
        assert_eq!(assigned.brain_of("dan").unwrap(), "exec:./a");
        assert_eq!(assigned.brain_of("bob").unwrap(), "wander");
        let bad = assign(&["exec:".to_owned()], &scenario.robots).unwrap_err().to_string();
        assert_eq!(bad, "`exec:` names no program; write it as in exec:python3 follow.py");
    }

    #[test]
    fn names_have_patterns_and_a_natural_order() {
        let there = ["cell-1", "cell-10", "cell-2", "ant"].map(str::to_owned);
        let of = |patterns: &[&str]| {
            let patterns: Vec<_> = patterns.iter().map(|&pattern| pattern.to_owned()).collect();
            named(&patterns, &there).map_err(|error| error.to_string())
        };
        assert_eq!(of(&["cell-*"]).unwrap(), ["cell-1", "cell-2", "cell-10"]);
        assert_eq!(of(&["cell-10", "*"]).unwrap(), ["cell-10", "ant", "cell-1", "cell-2"]);
        let error = "no robot has a name like `bee-*`; there are: ant, cell-1, cell-2, cell-10";
        assert_eq!(of(&["bee-*"]).unwrap_err(), error);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(assignments(&[]).unwrap_err().contains("robot `bob` has no IR sensors"));
        assert!(assignments(&["dave=avoid"]).unwrap_err().ends_with("there are: alice, bob, carol"));
        assert!(
            assignments(&["avoid", "wander"]).unwrap_err().contains("all robots can have only one brain")
        );
        assert!(
            assignments(&["bob=avoid", "bob=none"]).unwrap_err().contains("robot `bob` can have only one")
        );
    }
}
