//! Which brain drives which robot, and the brains at work, as gRPC clients like any other.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_client::{Brain, Client, Fleet, Summary, run_fleet};
use baudbot_sim::robot::RobotSpec;
use baudbot_sim::sensor::Device;

use crate::error::Refused;

/// Robots that one kind of brain drives, each robot with a brain of its own, over one stream.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Job {
    /// As in the catalogue: `NAME[:K=V,…]`.
    pub(crate) brain: String,
    pub(crate) robots: Vec<String>,
}

/// Shares the robots out to the brains that `--brain` arguments name.
pub(crate) fn share_out(arguments: &[String], robots: &[RobotSpec]) -> anyhow::Result<Vec<Job>> {
    let arguments = parse(arguments)?;
    for robot in arguments.keys().flatten() {
        if !robots.iter().any(|spec| spec.name == *robot) {
            let names: Vec<_> = robots.iter().map(|spec| spec.name.as_str()).collect();
            let problem = format!("--brain: there is no robot `{robot}`; there are: {}", names.join(", "));
            return Err(Refused::error(problem));
        }
    }
    let mut jobs: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for spec in robots {
        let brain = match arguments.get(&Some(spec.name.as_str())).or_else(|| arguments.get(&None)) {
            Some(brain) => brain,
            None => default_brain(spec)?,
        };
        if brain != NONE {
            jobs.entry(brain).or_default().push(spec.name.clone());
        }
    }
    Ok(jobs.into_iter().map(|(brain, robots)| Job { brain: brain.to_owned(), robots }).collect())
}

/// Brains by robot; `None` is every robot that is not named.
fn parse(arguments: &[String]) -> anyhow::Result<BTreeMap<Option<&str>, &str>> {
    let mut brains = BTreeMap::new();
    for argument in arguments {
        // The settings behind a colon have equals signs, too.
        let name = argument.split(':').next().unwrap_or_default();
        let (robot, brain) = match name.split_once('=') {
            Some((robot, _)) => (Some(robot), &argument[robot.len() + 1..]),
            None => (None, argument.as_str()),
        };
        if brains.insert(robot, brain).is_some() {
            let whom = robot.map_or_else(|| "all robots".to_owned(), |robot| format!("robot `{robot}`"));
            return Err(Refused::error(format!("--brain: {whom} can have only one brain")));
        }
    }
    Ok(brains)
}

/// A brain that can drive this robot: the default one if it sees enough, else one that is blind.
pub(crate) fn fitting_brain(spec: &RobotSpec) -> &'static str {
    if has_infrared(spec) { DEFAULT } else { "wander" }
}

fn has_infrared(spec: &RobotSpec) -> bool {
    spec.sensors.iter().any(|sensor| matches!(sensor.device, Device::Infrared(_)))
}

fn default_brain(spec: &RobotSpec) -> anyhow::Result<&'static str> {
    if has_infrared(spec) {
        return Ok(DEFAULT);
    }
    Err(Refused::error(format!(
        "robot `{0}` has no IR sensors, so that the default brain `{DEFAULT}` cannot drive it; give it another \
         with --brain {0}=NAME (`baudbot brain --list` lists them; `none` is no brain)",
        spec.name
    )))
}

/// A job that is being done.
pub(crate) struct Crew {
    brain: String,
    fleet: Fleet,
    brains: Vec<Box<dyn Brain + Send>>,
}

impl Crew {
    /// Takes hold of the robots and makes their brains.
    pub(crate) async fn attach(client: Client, world: &str, job: Job, seed: u64) -> anyhow::Result<Self> {
        let robots: Vec<_> = job.robots.iter().map(String::as_str).collect();
        let fleet = client.brain(shown_name(&job.brain)).attach_many(world, &robots).await?;
        let make = |body| catalogue::brain(&job.brain, seed, body);
        let brains = fleet.bodies().iter().map(|body| make(body)).collect::<Result<_, _>>();
        let brains = brains.map_err(|error| Refused::error(error.to_string()))?;
        Ok(Self { brain: job.brain, fleet, brains })
    }

    /// Drives the robots until the run is over or the server closes the stream.
    pub(crate) async fn run(&mut self) -> anyhow::Result<Summary> {
        let summary = run_fleet(&mut self.fleet, &mut self.brains).await;
        summary.with_context(|| format!("brain `{}` failed", self.brain))
    }

    /// Whether the server has closed the stream.
    pub(crate) fn is_closed(&self) -> bool {
        self.fleet.is_closed()
    }
}

/// Refuses a name that is in no catalogue before anything is started for it.
pub(crate) fn check_name(description: &str) -> anyhow::Result<()> {
    let name = description.split(':').next().unwrap_or_default();
    let entries = catalogue::catalogue();
    if entries.iter().any(|entry| entry.name == name) {
        return Ok(());
    }
    let names: BTreeSet<_> = entries.iter().map(|entry| entry.name).collect();
    let names: Vec<_> = names.into_iter().collect();
    Err(Refused::error(format!("there is no brain `{name}`; there are: {}", names.join(", "))))
}

/// The name that people see; the contract allows 64 bytes.
fn shown_name(description: &str) -> String {
    let mut end = description.len().min(64);
    while !description.is_char_boundary(end) {
        end -= 1;
    }
    description[..end].to_owned()
}

/// The brain of a robot that is given none.
const DEFAULT: &str = "avoid";

/// The word for no brain.
const NONE: &str = "none";

#[cfg(test)]
mod tests {
    use baudbot_sim::Scenario;

    use super::*;

    fn jobs(arguments: &[&str]) -> Result<Vec<(String, Vec<String>)>, String> {
        let robot = |name: &str, x: f64, sensors: &str| {
            format!(
                "[[robots]]\nname = \"{name}\"\nstart.x_m = {x:?}\n{sensors}\n\
                 body = {{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }}\n"
            )
        };
        let ir = "sensors.front = { kind = \"ir\", bearing_rad = 0.0, rays = 1, opening_rad = 0.0, range_m = 1.0, c1_m2 = 0.03, c2 = 0.1 }";
        let toml = robot("alice", 0.0, ir) + &robot("bob", 1.0, "") + &robot("carol", 2.0, ir);
        let scenario = Scenario::parse(&toml).map_err(|error| error.to_string())?;
        let arguments: Vec<_> = arguments.iter().map(|&argument| argument.to_owned()).collect();
        let jobs = share_out(&arguments, scenario.robots()).map_err(|error| error.to_string())?;
        Ok(jobs.into_iter().map(|job| (job.brain, job.robots)).collect())
    }

    fn job(brain: &str, robots: &[&str]) -> (String, Vec<String>) {
        (brain.to_owned(), robots.iter().map(|&robot| robot.to_owned()).collect())
    }

    #[test]
    fn robots_are_shared_out() {
        let all = ["alice", "bob", "carol"];
        assert_eq!(jobs(&["constant:left=0.5"]), Ok(vec![job("constant:left=0.5", &all)]));
        assert_eq!(jobs(&["bob=none"]), Ok(vec![job("avoid", &["alice", "carol"])]));
        let mixed = jobs(&["bob=constant:left=0.1,right=0.2", "wander"]);
        let expected = vec![job("constant:left=0.1,right=0.2", &["bob"]), job("wander", &["alice", "carol"])];
        assert_eq!(mixed, Ok(expected));
        assert_eq!(jobs(&["none"]), Ok(vec![]));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(jobs(&[]).unwrap_err().contains("robot `bob` has no IR sensors"));
        assert!(jobs(&["dave=avoid"]).unwrap_err().ends_with("there are: alice, bob, carol"));
        assert!(jobs(&["avoid", "wander"]).unwrap_err().contains("all robots can have only one brain"));
        assert!(jobs(&["bob=avoid", "bob=none"]).unwrap_err().contains("robot `bob` can have only one"));
    }

    #[test]
    fn long_names_are_cut() {
        assert_eq!(shown_name(&"ä".repeat(40)), "ä".repeat(32));
        assert_eq!(shown_name(&format!("a{}", "ä".repeat(40))).len(), 63);
    }
}
