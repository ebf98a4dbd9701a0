//! Beliefs of brains, from the frames of a recording.
//!
//! The run that is simulated again has no brains, so beliefs come from the file as they are. A frame has the newest belief
//! of each brain that published since the frame before; its time is that of the frame. [`Table`] writes them, and
//! [`Picture`] draws utilities, with sensors' readings from the simulation, and [`Space`] the path of motivational states.

mod picture;
mod space;
mod table;

use std::collections::BTreeSet;

use anyhow::Context;
use baudbot_proto::v1::{Belief, Motivation};
use baudbot_recording::{Frames, RecordedRun};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor_columns;

pub(super) use self::picture::Picture;
pub(super) use self::space::Space;
pub(super) use self::table::Table;
use super::window::Window;
use crate::args::ExportArgs;
use crate::error::Refused;

/// The beliefs of a run's brains.
#[derive(Clone, Debug, Default)]
pub(super) struct Beliefs {
    /// The names of their processes, in the order in which they were first published.
    processes: Vec<String>,
    /// The variables of their motivational states, in the order in which they were first published.
    variables: Vec<Variable>,
    /// One for each robot of the scenario.
    robots: Vec<Robot>,
    /// The memory for all of it, about.
    bytes: usize,
    /// The variables of the axes of [`Space`], by their places.
    axes: [usize; 2],
}

/// The beliefs of one brain.
#[derive(Clone, Debug, Default)]
struct Robot {
    name: String,
    said: Vec<Said>,
    /// The tendencies that the brain published last.
    tendencies: Vec<Tendency>,
}

/// A variable of a motivational state.
#[derive(Clone, Debug, PartialEq)]
struct Variable {
    name: String,
    internal: bool,
    /// The boundaries at which a robot dies, below and above.
    lethal: [Option<f64>; 2],
}

/// The tendency to a process.
#[derive(Clone, Debug)]
struct Tendency {
    /// The process's place in [`Beliefs::processes`].
    process: usize,
    bias: f64,
    /// The weights of variables, by their places in [`Beliefs::variables`].
    weights: Vec<(usize, f64)>,
}

/// A belief at an instant.
#[derive(Clone, Debug)]
struct Said {
    time_s: f64,
    /// The process's state, in its own words.
    state: String,
    /// x and y in metres, and the heading in radians.
    pose: Option<[f64; 3]>,
    /// The utility of each process that has one, and whether it is active, by its place in [`Beliefs::processes`].
    utilities: Vec<(usize, f64, bool)>,
    /// The value of each variable of its motivational state, by its place in [`Beliefs::variables`].
    variables: Vec<(usize, f64)>,
}

impl Said {
    /// The value of the variable at this place in [`Beliefs::variables`].
    fn variable(&self, place: usize) -> Option<f64> {
        self.variables.iter().find(|(variable, _)| *variable == place).map(|(_, value)| *value)
    }
}

impl Beliefs {
    /// The beliefs of a recording's window, if an output needs them.
    pub(super) fn wanted(args: &ExportArgs, recorded: &RecordedRun, window: &Window) -> anyhow::Result<Self> {
        let mut beliefs = Self::default();
        let Some(option) = option(args) else { return Ok(beliefs) };
        let name = |robot: &RobotSpec| Robot { name: robot.name.clone(), ..Robot::default() };
        beliefs.robots = recorded.scenario().robots.iter().map(name).collect();
        let file = args.file.display();
        let reading = || format!("cannot read {file}");
        for frame in Frames::open(&args.file).with_context(reading)? {
            let frame = frame.with_context(reading)?;
            if !(window.from_tick..=window.to_tick).contains(&frame.tick) {
                continue;
            }
            for annotation in &frame.annotations {
                let belief = annotation.belief.as_ref();
                if let Some(belief) = belief.filter(|belief| **belief != Belief::default()) {
                    beliefs.take(annotation.robot as usize, frame.time_ns as f64 / 1e9, belief);
                }
            }
            beliefs.check_size().with_context(|| format!("{option}: {file}"))?;
        }
        if beliefs.robots.iter().all(|robot| robot.said.is_empty()) {
            return Err(Refused::error(format!(
                "{option}: {file} has no beliefs there; record with a brain that publishes some, such as `sweeper`, \
                 and with --record-hz above 0"
            )));
        }
        if args.utilities_svg.is_some() && beliefs.processes.is_empty() {
            return Err(Refused::error(format!(
                "--utilities-svg: the brains of {file} have no utilities; `sweeper` and `stentor` do"
            )));
        }
        if args.space_svg.is_some() {
            beliefs.axes = space::axes(args, &beliefs)?;
        }
        Ok(beliefs)
    }

    /// Refuses more than a program may take, before it has taken much more.
    fn check_size(&self) -> anyhow::Result<()> {
        if self.bytes > MOST_BYTES || self.processes.len().max(self.variables.len()) > MOST_PROCESSES {
            return Err(Refused::error(format!(
                "more than {} MiB of beliefs, or more than {MOST_PROCESSES} processes or variables; take a shorter part with --from-s and \
                 --to-s",
                MOST_BYTES >> 20
            )));
        }
        Ok(())
    }

    fn take(&mut self, robot: usize, time_s: f64, belief: &Belief) {
        let mut utilities = Vec::with_capacity(belief.utilities.len());
        for utility in &belief.utilities {
            let place = place_of(&mut self.processes, |name| *name == utility.name, || utility.name.clone());
            utilities.push((place, utility.value, utility.active));
        }
        let pose = belief.pose.as_ref().map(|pose| [pose.x_m, pose.y_m, pose.heading_rad]);
        let variables = belief.motivation.as_ref().map(|motivation| self.take_motivation(robot, motivation));
        let variables = variables.unwrap_or_default();
        let lists = size_of_val(utilities.as_slice()) + size_of_val(variables.as_slice());
        self.bytes += size_of::<Said>() + belief.state.len() + lists;
        if let Some(robot) = self.robots.get_mut(robot) {
            robot.said.push(Said { time_s, state: belief.state.clone(), pose, utilities, variables });
        }
    }

    /// Keeps the tendencies, and returns the values of variables.
    fn take_motivation(&mut self, robot: usize, motivation: &Motivation) -> Vec<(usize, f64)> {
        let mut values = Vec::with_capacity(motivation.variables.len());
        for variable in &motivation.variables {
            let make = || Variable {
                name: variable.name.clone(),
                internal: variable.internal,
                lethal: [variable.lethal_below, variable.lethal_above],
            };
            let is_it = |known: &Variable| known.name == variable.name;
            values.push((place_of(&mut self.variables, is_it, make), variable.value));
        }
        let tendencies = motivation.tendencies.iter().map(|tendency| Tendency {
            process: place_of(&mut self.processes, |name| *name == tendency.name, || tendency.name.clone()),
            bias: tendency.bias,
            weights: values.iter().map(|(place, _)| *place).zip(tendency.weights.iter().copied()).collect(),
        });
        let tendencies = tendencies.collect();
        if let Some(robot) = self.robots.get_mut(robot) {
            robot.tendencies = tendencies;
        }
        values
    }
}

/// The place of what is known in a list, or of what is made and added at its end.
fn place_of<T>(known: &mut Vec<T>, is_it: impl Fn(&T) -> bool, make: impl FnOnce() -> T) -> usize {
    let place = known.iter().position(is_it);
    place.unwrap_or_else(|| {
        known.push(make());
        known.len() - 1
    })
}

/// The first option that needs beliefs.
fn option(args: &ExportArgs) -> Option<&'static str> {
    args.outputs()
        .map(|(option, _)| option)
        .find(|option| ["--beliefs-csv", "--utilities-svg", "--space-svg"].contains(option))
}

/// A column of sensors' readings, for each robot its place among the robot's own.
#[derive(Clone, Debug)]
pub(super) struct Column {
    name: String,
    places: Vec<Option<usize>>,
}

/// The columns of these names; each must be one of some robot's.
pub(super) fn columns(names: &[String], robots: &[RobotSpec]) -> anyhow::Result<Vec<Column>> {
    let known: Vec<_> = robots.iter().map(sensor_columns).collect();
    let find = |name: &String| {
        let places: Vec<_> =
            known.iter().map(|columns| columns.iter().position(|column| column == name)).collect();
        if places.iter().all(Option::is_none) {
            let all: BTreeSet<_> = known.iter().flatten().map(String::as_str).collect();
            let all = all.into_iter().take(MOST_NAMED).collect::<Vec<_>>().join(", ");
            let problem = format!("--with: no robot has a sensor's column `{name}`; there are: {all}");
            return Err(Refused::error(problem));
        }
        Ok(Column { name: name.clone(), places })
    };
    names.iter().map(find).collect()
}

/// The memory that a program may take for beliefs, of which a small file can have many: hours of a brain that publishes
/// all that it may, at 10 Hz.
const MOST_BYTES: usize = 1 << 30;

/// More than any brain has.
const MOST_PROCESSES: usize = 1000;

/// Charts of more robots are no help.
const MOST_ROBOTS: usize = 8;

/// More columns than this are no help.
const MOST_NAMED: usize = 40;

#[cfg(test)]
mod tests {
    use baudbot_proto::v1::Utility;

    use super::*;

    fn belief(process: usize, state: &str) -> Belief {
        let utility = Utility { name: format!("process {process}"), value: 0.5, active: false };
        Belief { state: state.to_owned(), utilities: vec![utility], ..Belief::default() }
    }

    #[test]
    fn more_processes_than_any_brain_has_are_refused() {
        let mut beliefs = Beliefs { robots: vec![Robot::default()], ..Beliefs::default() };
        (0..MOST_PROCESSES).for_each(|process| beliefs.take(0, 0.0, &belief(process, "")));
        beliefs.take(0, 1.0, &belief(0, ""));
        beliefs.check_size().unwrap();
        beliefs.take(0, 2.0, &belief(MOST_PROCESSES, ""));
        let error = beliefs.check_size().unwrap_err().to_string();
        assert!(error.contains("more than 1000 processes") && error.contains("--from-s"), "{error}");
    }

    #[test]
    fn beliefs_that_take_too_much_memory_are_refused() {
        let mut beliefs = Beliefs { robots: vec![Robot::default()], ..Beliefs::default() };
        let state = "x".repeat(1 << 20);
        beliefs.take(0, 0.0, &belief(0, &state));
        let bytes = beliefs.bytes;
        assert!((1 << 20..(1 << 20) + 1024).contains(&bytes), "{bytes}");
        // The count is set as if a thousand such beliefs had been taken.
        beliefs.bytes = MOST_BYTES - bytes;
        beliefs.take(0, 0.1, &belief(0, &state));
        beliefs.check_size().unwrap();
        beliefs.take(0, 0.2, &belief(0, &state));
        let error = beliefs.check_size().unwrap_err().to_string();
        assert!(error.contains("more than 1024 MiB of beliefs"), "{error}");
    }
}
