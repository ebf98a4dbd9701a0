//! Which brain drives which robot, and the brains at work, as gRPC clients like any other.

use std::collections::BTreeMap;

use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_client::{Brain, Client, Error, Fleet, Summary, run_fleet};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Device;

/// Robots that one kind of brain drives, each robot with a brain of its own, over one stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// As in the catalogue: `NAME[:K=V,…]`.
    pub brain: String,
    /// Their names.
    pub robots: Vec<String>,
}

/// Why robots have not got their brains, or lost them.
#[derive(Debug, thiserror::Error)]
pub enum AssignmentError {
    /// A brain is for a robot that is not there.
    #[error("there is no robot `{robot}`; there are: {}", known.join(", "))]
    Robot {
        /// The name given.
        robot: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// There are two brains for the same robot, or for all robots.
    #[error("{whom} can have only one brain")]
    Twice {
        /// Which robots.
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
    /// The catalogue has no such brain for a robot.
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    /// A stream to a server failed.
    #[error(transparent)]
    Client(#[from] Error),
}

/// Shares the robots out to brains: `NAME[:K=V,…]` for all that no `ROBOT=NAME[:K=V,…]` names. Without any for all,
/// those that are not named get the default brain. The name of a table with `starts` is for all robots of that which are
/// not named themselves.
///
/// # Errors
/// If a robot is not there, has two brains, or cannot see and is given none.
pub fn assign(brains: &[String], robots: &[RobotSpec]) -> Result<Vec<Assignment>, AssignmentError> {
    let brains = parse(brains)?;
    for robot in brains.keys().flatten() {
        if !robots.iter().any(|spec| spec.name == *robot || spec.table_name() == *robot) {
            let known = robots.iter().map(|spec| spec.name.clone()).collect();
            return Err(AssignmentError::Robot { robot: (*robot).to_owned(), known });
        }
    }
    let mut assignments: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for spec in robots {
        let whose = [Some(spec.name.as_str()), Some(spec.table_name()), None];
        let brain = match whose.iter().find_map(|whose| brains.get(whose)) {
            Some(brain) => brain,
            None if has_infrared(spec) => DEFAULT,
            None => return Err(AssignmentError::Blind { robot: spec.name.clone() }),
        };
        if brain != NONE {
            assignments.entry(brain).or_default().push(spec.name.clone());
        }
    }
    Ok(assignments
        .into_iter()
        .map(|(brain, robots)| Assignment { brain: brain.to_owned(), robots })
        .collect())
}

/// Brains by robot; `None` is every robot that is not named.
fn parse(brains: &[String]) -> Result<BTreeMap<Option<&str>, &str>, AssignmentError> {
    let mut all = BTreeMap::new();
    for text in brains {
        let (robot, brain) = split(text);
        if all.insert(robot, brain).is_some() {
            let whom = robot.map_or_else(|| "all robots".to_owned(), |robot| format!("robot `{robot}`"));
            return Err(AssignmentError::Twice { whom });
        }
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

/// A brain that can drive this robot: the default one if it sees enough, else one that is blind.
pub fn fitting_brain(spec: &RobotSpec) -> &'static str {
    if has_infrared(spec) { DEFAULT } else { "wander" }
}

fn has_infrared(spec: &RobotSpec) -> bool {
    spec.sensors.iter().any(|sensor| matches!(sensor.device, Device::Infrared(_)))
}

/// An assignment that is being carried out.
pub struct AttachedBrains {
    brain: String,
    fleet: Fleet,
    brains: Vec<Box<dyn Brain + Send>>,
}

impl AttachedBrains {
    /// Takes hold of the robots and makes their brains.
    ///
    /// # Errors
    /// If the server refuses, or the catalogue has no such brain for a robot.
    pub async fn attach(
        client: Client,
        world: &str,
        assignment: Assignment,
        seed: u64,
    ) -> Result<Self, AssignmentError> {
        let robots: Vec<_> = assignment.robots.iter().map(String::as_str).collect();
        // No brain of the catalogue says how long it thought.
        let fleet = client
            .brain(catalogue::shown_name(&assignment.brain))
            .thinks_as_scenario()
            .attach_many(world, &robots)
            .await?;
        let make = |body| catalogue::brain(&assignment.brain, seed, body);
        let brains = fleet.bodies().iter().map(|body| make(body)).collect::<Result<_, _>>()?;
        Ok(Self { brain: assignment.brain, fleet, brains })
    }

    /// Drives the robots until the run is over or the server closes the stream.
    ///
    /// # Errors
    /// If the stream fails.
    pub async fn run(&mut self) -> Result<Summary, Error> {
        run_fleet(&mut self.fleet, &mut self.brains).await
    }

    /// The brain, as the assignment describes it.
    pub fn brain(&self) -> &str {
        &self.brain
    }

    /// Whether the server has closed the stream.
    pub fn is_closed(&self) -> bool {
        self.fleet.is_closed()
    }
}

/// The brain of a robot that is given none.
pub const DEFAULT: &str = "avoid";

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
        Ok(assignments.into_iter().map(|assignment| (assignment.brain, assignment.robots)).collect())
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
            assignments,
            [Assignment { brain: "wander".to_owned(), robots: vec!["ant-1".into(), "ant-2".into()] }]
        );
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
