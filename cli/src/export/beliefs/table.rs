//! Beliefs as comma-separated values.

use std::io;

use baudbot_sim::World;

use super::super::Out;
use super::super::pass::Sink;
use super::{Beliefs, Said};

/// A table that is written at the end: a row for each belief that a brain published.
pub(in super::super) struct Table {
    out: csv::Writer<Out>,
    beliefs: Beliefs,
}

impl Table {
    pub(in super::super) fn new(out: Out, beliefs: &Beliefs) -> Self {
        Self { out: csv::Writer::from_writer(out), beliefs: beliefs.clone() }
    }

    fn row(&mut self, robot: usize, said: &Said) -> io::Result<()> {
        let number = |number: f64| if number.is_nan() { String::new() } else { number.to_string() };
        let name = self.beliefs.robots[robot].name.clone();
        let mut row = vec![number(said.time_s), name, said.state.clone()];
        match said.pose {
            Some(pose) => row.extend(pose.map(number)),
            None => row.extend([const { String::new() }; 3]),
        }
        let mut cells = vec![String::new(); 2 * self.beliefs.processes.len()];
        for &(place, value, active) in &said.utilities {
            cells[2 * place] = number(value);
            cells[2 * place + 1] = u8::from(active).to_string();
        }
        row.extend(cells);
        let mut values = vec![String::new(); self.beliefs.variables.len()];
        for &(place, value) in &said.variables {
            values[place] = number(value);
        }
        row.extend(values);
        Ok(self.out.write_record(&row)?)
    }
}

impl Sink for Table {
    fn tick(&mut self, _: &World) -> io::Result<()> {
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        let fixed = ["t_s", "robot", "state", "x_m", "y_m", "heading_rad"].map(str::to_owned);
        let processes = self.beliefs.processes.iter();
        let own = processes.flat_map(|name| [format!("{name}.utility"), format!("{name}.active")]);
        let variables = self.beliefs.variables.iter().map(|variable| format!("{}.value", variable.name));
        let header: Vec<_> = fixed.into_iter().chain(own).chain(variables).collect();
        self.out.write_record(&header)?;
        let robots = std::mem::take(&mut self.beliefs.robots);
        self.beliefs.robots =
            robots.iter().map(|robot| super::Robot { said: Vec::new(), ..robot.clone() }).collect();
        let mut rows: Vec<_> = robots
            .iter()
            .enumerate()
            .flat_map(|(i, robot)| robot.said.iter().map(move |said| (i, said)))
            .collect();
        rows.sort_by(|a, b| a.1.time_s.total_cmp(&b.1.time_s).then(a.0.cmp(&b.0)));
        rows.into_iter().try_for_each(|(robot, said)| self.row(robot, said))?;
        self.out.flush()
    }
}
