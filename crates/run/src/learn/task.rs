//! A scenario with its agents: what an environment is made from, again and again.

use std::sync::Arc;

use baudbot_import::source::Source;
use baudbot_scenario::Override;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;

use crate::assignment::{self, Assignment};
use crate::in_process::drivers;
use crate::learn::error::LearnError;
use crate::learn::layout::Layout;
use crate::learn::vary::Varied;

/// The request for an environment.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Changes of the scenario in the form of `--set`.
    pub overrides: Vec<String>,
    /// Brains of the catalogue for some robots, in the form of `--brain`. The robots without one are the agents.
    pub brains: Vec<String>,
    /// The robots among these that are agents: all if there are none here. The others stand.
    pub agents: Vec<String>,
    /// Fields that are drawn anew for each run.
    pub randomize: Vec<Varied>,
}

/// A task.
#[derive(Clone, Debug)]
pub struct Task {
    label: String,
    text: String,
    request: Request,
    /// The scenario with the overrides of the request.
    scenario: Arc<Scenario>,
    /// The places of the agents' robots.
    pub(crate) agents: Vec<usize>,
    pub(crate) layouts: Vec<Arc<Layout>>,
    assigned: Vec<Assignment>,
}

impl Task {
    /// A task of this scenario.
    ///
    /// # Errors
    /// If the scenario or the request is invalid; if a robot is to be an agent whose microcontroller runs a program of
    /// its own.
    pub fn new(source: Source, request: Request) -> Result<Self, LearnError> {
        request.randomize.iter().try_for_each(Varied::check)?;
        let Source { label, text, notes: _ } = source;
        let scenario = parse(&label, &text, &request, None, &[])?;
        let assigned = assigned(&request.brains, &scenario.robots)?;
        // The error for an unknown brain comes before the one for a task without a robot to drive.
        drivers(&scenario.robots, &assigned, scenario.seed)?;
        let agents = agents(&request.agents, &assigned, &scenario.robots)?;
        let layouts = agents.iter().map(|&robot| Arc::new(Layout::of(&scenario.robots[robot]))).collect();
        let scenario = Arc::new(scenario);
        let task = Self { label, text, request, scenario, agents, layouts, assigned };
        if !task.request.randomize.is_empty() {
            task.scenario(task.scenario.seed, &[])?;
        }
        Ok(task)
    }

    /// The name of the scenario, or that of its file.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The text of the scenario, with all that it refers to by file in it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The request itself.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The scenario as it is without what is drawn for a run.
    pub fn base(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The layouts of the agents' numbers, agent by agent.
    pub fn layouts(&self) -> &[Arc<Layout>] {
        &self.layouts
    }

    /// The brains of the robots that are no agents.
    pub fn brains(&self) -> &[Assignment] {
        &self.assigned
    }

    /// The scenario of a run with this seed, with more changes of fields.
    ///
    /// # Errors
    /// If the drawn and changed fields make the scenario invalid, or has other robots or other readings.
    pub(crate) fn scenario(&self, seed: u64, more: &[String]) -> Result<Arc<Scenario>, LearnError> {
        if self.request.randomize.is_empty() && more.is_empty() {
            if seed == self.scenario.seed {
                return Ok(Arc::clone(&self.scenario));
            }
            return Ok(Arc::new(Scenario { seed, ..(*self.scenario).clone() }));
        }
        let scenario = parse(&self.label, &self.text, &self.request, Some(seed), more)?;
        let has_agents = self.agents.iter().zip(&self.layouts).all(|(&robot, layout)| {
            let spec = scenario.robots.get(robot);
            spec.is_some_and(|spec| spec.name == layout.robot && Layout::of(spec).has_shape_of(layout))
        });
        if scenario.robots.len() != self.scenario.robots.len() || !has_agents {
            let problem = "changes which robots there are or what they sense, and with that the observations; make an environment for each";
            return Err(LearnError::value("randomize", problem));
        }
        Ok(Arc::new(scenario))
    }
}

fn parse(
    label: &str,
    text: &str,
    request: &Request,
    seed: Option<u64>,
    more: &[String],
) -> Result<Scenario, LearnError> {
    let wrong = |error| LearnError::Scenario { label: label.to_owned(), error };
    let given = request.overrides.iter().chain(more).map(|text| Override::parse(text));
    let mut overrides = given.collect::<Result<Vec<_>, _>>().map_err(wrong)?;
    if let Some(seed) = seed {
        for varied in &request.randomize {
            overrides.push(varied.of_run(seed).map_err(wrong)?);
        }
        overrides.push(Override::parse(&format!("seed={seed}")).map_err(wrong)?);
    }
    baudbot_scenario::parse_with(text, &overrides).map_err(wrong)
}

/// The brains of the catalogue. Unlike those of a command, a robot that is given none has none.
fn assigned(brains: &[String], robots: &[RobotSpec]) -> Result<Vec<Assignment>, LearnError> {
    let mut brains = brains.to_vec();
    if !brains.iter().any(|brain| assignment::split(brain).0.is_none()) {
        brains.push(assignment::NONE.to_owned());
    }
    let assigned = assignment::assign(&brains, robots)?;
    if let Some(task) = assigned.programs.first() {
        let problem =
            format!("`{}` is a program, which attaches to a server (`baudbot serve`)", task.program);
        return Err(LearnError::value("brains", problem));
    }
    if let Some(task) = assigned.at_ports.first() {
        let problem = format!(
            "`{}` is a program in simulated time, which an environment has no place for; leave its robot out, or use `baudbot run`",
            task.program
        );
        return Err(LearnError::value("brains", problem));
    }
    Ok(assigned.brains)
}

/// The places of the robots that a program drives.
fn agents(named: &[String], assigned: &[Assignment], robots: &[RobotSpec]) -> Result<Vec<usize>, LearnError> {
    let has_brain =
        |spec: &RobotSpec| assigned.iter().any(|assignment| assignment.robots.contains(&spec.name));
    let is_own = |spec: &RobotSpec| spec.chip.as_ref().is_some_and(|chip| chip.is_opaque());
    if named.is_empty() {
        let free = robots.iter().enumerate().filter(|(_, spec)| !has_brain(spec) && !is_own(spec));
        return Ok(free.map(|(place, _)| place).collect());
    }
    let there: Vec<_> = robots.iter().map(|spec| spec.name.clone()).collect();
    let named = assignment::named(named, &there)?;
    let wrong = |problem: String| Err(LearnError::value("agents", problem));
    let mut places = Vec::new();
    for (place, spec) in robots.iter().enumerate().filter(|(_, spec)| named.contains(&spec.name)) {
        let name = &spec.name;
        if has_brain(spec) {
            return wrong(format!("robot `{name}` has a brain, so nothing else can drive it"));
        }
        if is_own(spec) {
            return wrong(format!(
                "the microcontroller of robot `{name}` runs a program of its own, which takes no commands from an environment"
            ));
        }
        places.push(place);
    }
    Ok(places)
}
