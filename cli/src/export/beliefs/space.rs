//! The run's path in the space of two variables of its brains' motivational states, in the form of Fig. 7.2 of the notes.

use std::io::{self, Write};

use baudbot_plot::chart::space::{self, Axis, Plane, Slope, Visit};
use baudbot_recording::RecordedRun;
use baudbot_sim::World;

use super::super::Out;
use super::super::pass::Sink;
use super::super::ran::Ran;
use super::{Beliefs, Robot, Said};
use crate::args::ExportArgs;
use crate::error::Refused;

/// A picture that is drawn at the end.
pub(in super::super) struct Space {
    out: Out,
    name: String,
    ran: Ran,
    beliefs: Beliefs,
}

/// The places of the two variables of the axes: those that are named, or else the first ones, those with a lethal boundary before other
/// internal ones and these before what is sensed.
pub(super) fn axes(args: &ExportArgs, beliefs: &Beliefs) -> anyhow::Result<[usize; 2]> {
    let file = args.file.display();
    let mut places: Vec<_> = (0..beliefs.variables.len()).collect();
    places.sort_by_key(|&place| {
        let variable = &beliefs.variables[place];
        (variable.lethal == [None; 2], !variable.internal, place)
    });
    let [first, second, ..] = places[..] else {
        return Err(Refused::error(format!(
            "--space-svg: the brains of {file} publish no two variables of a motivational state; `waterhole` does"
        )));
    };
    let find = |name: &String| {
        beliefs.variables.iter().position(|variable| variable.name == *name).ok_or_else(|| {
            let known: Vec<_> = beliefs.variables.iter().map(|variable| variable.name.as_str()).collect();
            let known = known.join(", ");
            Refused::error(format!("--axes: no brain of {file} has a variable `{name}`; there are: {known}"))
        })
    };
    match &args.axes[..] {
        [] => Ok([first, second]),
        [across, up] if across != up => Ok([find(across)?, find(up)?]),
        names => {
            let names = names.join(",");
            Err(Refused::error(format!("--axes {names}: must be two different variables, as hunger,thirst")))
        }
    }
}

impl Space {
    pub(in super::super) fn new(out: Out, recorded: &RecordedRun, beliefs: &Beliefs) -> Self {
        let scenario = &recorded.scenario().name;
        let name = if scenario.is_empty() { &recorded.header().world } else { scenario };
        Self { out, name: name.to_owned(), ran: Ran::of(recorded), beliefs: beliefs.clone() }
    }

    /// The plane of a robot; `None` if its brain has not both variables.
    fn plane(&self, robot: &Robot) -> Option<Plane> {
        let path: Vec<_> = robot.said.iter().filter_map(|said| self.visit(said)).collect();
        let end = robot.said.last()?.state.clone();
        let axis = |place: usize| {
            let variable = &self.beliefs.variables[place];
            Axis { name: variable.name.clone(), lethal: variable.lethal }
        };
        let tendencies = robot.tendencies.iter().map(|tendency| self.slope(robot, tendency));
        (!path.is_empty()).then(|| Plane {
            title: robot.name.clone(),
            axes: self.beliefs.axes.map(axis),
            behaviors: self.beliefs.processes.clone(),
            tendencies: tendencies.filter(|slope| slope.slopes != [0.0; 2]).collect(),
            path,
            end,
        })
    }

    fn visit(&self, said: &Said) -> Option<Visit> {
        let [x, y] = self.beliefs.axes.map(|axis| said.variable(axis));
        let active = said.utilities.iter().find(|(.., active)| *active);
        Some(Visit { at: [x?, y?], behavior: active.map(|&(process, ..)| process) })
    }

    /// A tendency in the plane. Other variables count as what they were on average.
    fn slope(&self, robot: &Robot, tendency: &super::Tendency) -> Slope {
        let weight = |place: usize| {
            tendency
                .weights
                .iter()
                .find(|(variable, _)| *variable == place)
                .map_or(0.0, |(_, weight)| *weight)
        };
        let mean = |place: usize| {
            let values = robot.said.iter().filter_map(|said| said.variable(place));
            let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            if count > 0.0 { sum / count } else { 0.0 }
        };
        let others = tendency.weights.iter().filter(|(place, _)| !self.beliefs.axes.contains(place));
        let others: f64 = others.map(|&(place, weight)| weight * mean(place)).sum();
        Slope {
            behavior: tendency.process,
            bias: tendency.bias + others,
            slopes: self.beliefs.axes.map(weight),
        }
    }
}

impl Sink for Space {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        self.ran.see(world);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        let planes: Vec<_> = self.beliefs.robots.iter().filter_map(|robot| self.plane(robot)).collect();
        let shown = &planes[..planes.len().min(super::MOST_ROBOTS)];
        let picture = space::draw(&self.name, &self.ran.facts(), shown);
        self.out.write_all(picture.as_bytes())?;
        self.out.flush()
    }
}
