//! Utilities over time, in the form of Fig. 8.3 of the notes: a line for each process, and below them those that were
//! active.

use std::io::{self, Write};

use baudbot_plot::chart::over_time::{self, Chart, Line, Panel, Strip};
use baudbot_recording::RecordedRun;
use baudbot_sim::{RobotView, World};

use super::super::Out;
use super::super::pass::Sink;
use super::super::ran::Ran;
use super::{Beliefs, Column, MOST_ROBOTS, Robot};
use crate::csv::collect;

/// A picture that is drawn at the end.
pub(in super::super) struct Picture {
    out: Out,
    /// The scenario's name, or the world's.
    name: String,
    ran: Ran,
    beliefs: Beliefs,
    columns: Vec<Column>,
    /// Instants in seconds and readings for each robot and each column.
    readings: Vec<Vec<Vec<(f64, f64)>>>,
    values: Vec<f64>,
    /// The instants at which it begins and ends, in seconds.
    span: Option<(f64, f64)>,
}

impl Picture {
    pub(in super::super) fn new(
        out: Out,
        recorded: &RecordedRun,
        beliefs: &Beliefs,
        columns: &[Column],
    ) -> Self {
        let scenario = &recorded.scenario().name;
        let name = if scenario.is_empty() { &recorded.header().world } else { scenario };
        let readings = vec![vec![Vec::new(); columns.len()]; beliefs.robots.len()];
        Self {
            out,
            name: name.to_owned(),
            ran: Ran::of(recorded),
            beliefs: beliefs.clone(),
            columns: columns.to_vec(),
            readings,
            values: Vec::new(),
            span: None,
        }
    }

    fn read(&mut self, i: usize, robot: &RobotView<'_>, time_s: f64) {
        collect(robot, &mut self.values);
        for (column, readings) in self.columns.iter().zip(&mut self.readings[i]) {
            let Some(&value) = column.places[i].and_then(|place| self.values.get(place)) else { continue };
            // Only the ends of a constant stretch are needed.
            if let [.., (_, before), (last_s, last)] = readings.as_mut_slice()
                && *before == value
                && *last == value
            {
                *last_s = time_s;
                continue;
            }
            readings.push((time_s, value));
        }
    }

    fn charts(&self) -> Vec<Chart> {
        let robots = self.beliefs.robots.iter().enumerate();
        let told = robots.filter(|(_, robot)| robot.said.iter().any(|said| !said.utilities.is_empty()));
        told.take(MOST_ROBOTS).map(|(i, robot)| self.chart(i, robot)).collect()
    }

    fn chart(&self, i: usize, robot: &Robot) -> Chart {
        let of_column = |(column, readings): (&Column, &Vec<(f64, f64)>)| Panel {
            title: column.name.clone(),
            lines: vec![Line { name: column.name.clone(), color: 0, points: readings.clone() }],
            height: READINGS_PX,
        };
        let has = |(column, _): &(&Column, &Vec<(f64, f64)>)| column.places[i].is_some();
        let mut panels: Vec<_> =
            self.columns.iter().zip(&self.readings[i]).filter(has).map(of_column).collect();
        let processes = self.beliefs.processes.iter().enumerate();
        let lines = processes.clone().map(|(place, name)| {
            let value = |utilities: &[(usize, f64, bool)]| {
                utilities.iter().find(|(process, ..)| *process == place).map(|(_, value, _)| *value)
            };
            let points = robot.said.iter().filter_map(|said| Some((said.time_s, value(&said.utilities)?)));
            Line { name: name.clone(), color: place, points: points.collect() }
        });
        let lines: Vec<_> = lines.filter(|line| !line.points.is_empty()).collect();
        panels.extend(self.internal(robot));
        panels.push(Panel { title: "utility".to_owned(), lines, height: UTILITIES_PX });
        let end_s = self.span.map_or(0.0, |(_, end_s)| end_s);
        let strips = processes.map(|(place, name)| Strip {
            name: name.clone(),
            color: place,
            spans: spans(robot, place, end_s),
        });
        let strips = strips.filter(|strip| !strip.spans.is_empty()).collect();
        Chart { title: robot.name.clone(), panels, strips, span: self.span.unwrap_or((0.0, 1.0)) }
    }

    /// The internal variables of the brain's motivational state, if it has any.
    fn internal(&self, robot: &Robot) -> Option<Panel> {
        let internal = self.beliefs.variables.iter().enumerate().filter(|(_, variable)| variable.internal);
        let lines = internal.map(|(place, variable)| {
            let points = robot.said.iter().filter_map(|said| Some((said.time_s, said.variable(place)?)));
            Line { name: variable.name.clone(), color: place, points: points.collect() }
        });
        let lines: Vec<_> = lines.filter(|line| !line.points.is_empty()).collect();
        (!lines.is_empty()).then(|| Panel { title: "internal state".to_owned(), lines, height: READINGS_PX })
    }
}

/// The spans in which a process was active, in seconds: from a belief with it until one without.
fn spans(robot: &Robot, process: usize, end_s: f64) -> Vec<(f64, f64)> {
    let mut spans: Vec<(f64, f64)> = Vec::new();
    let mut since = None;
    for said in &robot.said {
        let active = said.utilities.iter().any(|&(place, _, active)| place == process && active);
        match (since, active) {
            (None, true) => since = Some(said.time_s),
            (Some(from_s), false) => {
                spans.push((from_s, said.time_s));
                since = None;
            }
            _ => {}
        }
    }
    spans.extend(since.map(|from_s| (from_s, end_s)));
    spans
}

impl Sink for Picture {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        let now_s = world.time().as_seconds();
        self.span = Some((self.span.map_or(now_s, |(from_s, _)| from_s), now_s));
        self.ran.see(world);
        if !self.columns.is_empty() {
            for (i, robot) in world.robots().enumerate() {
                self.read(i, &robot, now_s);
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        let picture = over_time::draw(&self.name, &self.ran.facts(), &self.charts());
        self.out.write_all(picture.as_bytes())?;
        self.out.flush()
    }
}

const READINGS_PX: f64 = 110.0;
const UTILITIES_PX: f64 = 220.0;

#[cfg(test)]
mod tests {
    use super::super::Said;
    use super::*;

    #[test]
    fn a_process_is_active_until_its_brain_says_otherwise() {
        let said = |time_s: f64, active: bool| Said {
            time_s,
            state: String::new(),
            pose: None,
            utilities: vec![(0, 0.5, !active), (1, 0.5, active)],
            variables: vec![],
        };
        let times = [(0.0, false), (1.0, true), (1.5, true), (2.0, false), (3.0, true)];
        let said = times.map(|(time_s, active)| said(time_s, active)).to_vec();
        let robot = Robot { name: "alice".to_owned(), said, ..Robot::default() };
        assert_eq!(spans(&robot, 1, 4.0), [(1.0, 2.0), (3.0, 4.0)]);
        assert_eq!(spans(&robot, 0, 4.0), [(0.0, 1.0), (2.0, 3.0)]);
        assert!(spans(&robot, 2, 4.0).is_empty());
    }
}
