//! The table of a run as Parquet: the rows and columns of the comma-separated one, with the unit in every name.

use std::io;

use baudbot_experiment::columnar::{Column, Kind, Writer};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{RobotView, World};
use baudbot_sim::{sensor_columns_with_units, state_columns, state_values};

use super::Out;
use super::pass::Sink;
use crate::csv::{collect, shared};

/// A table that is being written, some rows at a time.
pub(super) struct Rows {
    /// The output until the first row, with which the writer takes it.
    out: Option<Out>,
    writer: Option<Writer<Out>>,
    names: Vec<(String, Kind)>,
    /// The place of the robot's value for each robot and each sensor column.
    cells: Vec<Vec<Option<usize>>>,
    /// The same for the columns of the robots' own state.
    state_cells: Vec<Vec<Option<usize>>>,
    robots: Vec<Option<String>>,
    /// In the order of the columns, but for `robot` and `collided`.
    numbers: Vec<Vec<Option<f64>>>,
    collided: Vec<Option<bool>>,
    /// Rows that are written at a time.
    group: usize,
    values: Vec<f64>,
}

impl Rows {
    pub(super) fn new(out: Out, robots: &[RobotSpec]) -> Self {
        let (sensors, cells) = shared(robots.iter().map(sensor_columns_with_units));
        let (state, state_cells) = shared(robots.iter().map(state_columns));
        let names = names(sensors, state);
        let numbers = vec![Vec::new(); names.len() - 2];
        Self {
            out: Some(out),
            writer: None,
            group: (MOST_VALUES / names.len()).clamp(1, MOST_ROWS),
            names,
            cells,
            state_cells,
            robots: Vec::new(),
            numbers,
            collided: Vec::new(),
            values: Vec::new(),
        }
    }

    fn row(&mut self, i: usize, robot: &RobotView<'_>, world: &World) {
        let motion = robot.motion();
        let (position, heading) = (motion.pose.position, motion.pose.heading);
        let time_s = world.time().as_seconds();
        let state = state_values(robot);
        collect(robot, &mut self.values);
        let own = [time_s, position.x, position.y, heading, motion.speed_m_s, motion.turn_rate_rad_s];
        let signals = robot.signals();
        let read = self.cells[i].iter().map(|cell| cell.map(|value| self.values[value]));
        let kept = self.state_cells[i].iter().map(|cell| cell.map(|value| state[value]));
        let row = own.map(Some).into_iter().chain(read).chain([signals.left, signals.right].map(Some));
        for (column, value) in self.numbers.iter_mut().zip(row.chain(kept)) {
            column.push(value.filter(|value| !value.is_nan()));
        }
        self.robots.push(Some(robot.spec().name.clone()));
        self.collided.push(Some(robot.collided()));
    }

    fn write(&mut self) -> io::Result<()> {
        if let Some(out) = self.out.take() {
            self.writer = Some(Writer::new(out, "run", &self.names)?);
        }
        let rows = self.robots.len();
        let taken = |column: &mut Vec<_>| std::mem::replace(column, Vec::with_capacity(rows));
        let mut numbers: Vec<_> =
            self.numbers.iter_mut().map(|column| Column::Number(taken(column))).collect();
        numbers.insert(ROBOT, Column::Text(std::mem::take(&mut self.robots)));
        let collided = self.names.iter().position(|(_, kind)| *kind == Kind::Truth);
        let collided = collided.expect("there is such a column");
        numbers.insert(collided, Column::Truth(std::mem::take(&mut self.collided)));
        self.writer.as_mut().map_or(Ok(()), |writer| writer.rows(numbers))
    }
}

impl Sink for Rows {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        for (i, robot) in world.robots().enumerate() {
            self.row(i, &robot, world);
        }
        if self.robots.len() >= self.group { self.write() } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if !self.robots.is_empty() || self.writer.is_none() {
            self.write()?;
        }
        self.writer.map_or(Ok(()), Writer::finish)
    }
}

/// The place of the robot's name.
const ROBOT: usize = 1;

fn names(sensors: Vec<String>, state: Vec<String>) -> Vec<(String, Kind)> {
    let number = |name: &str| (name.to_owned(), Kind::Number);
    let mut names = vec![number("time_s"), ("robot".to_owned(), Kind::Text)];
    names.extend(["x_m", "y_m", "heading_rad", "speed_m_s", "turn_rate_rad_s"].map(number));
    names.extend(sensors.into_iter().map(|name| (name, Kind::Number)));
    names.extend(["left_signal", "right_signal"].map(number));
    names.push(("collided".to_owned(), Kind::Truth));
    names.extend(state.into_iter().map(|name| (name, Kind::Number)));
    names
}

/// Values that wait to be written, so that an hour of a run takes no more memory than a minute.
const MOST_VALUES: usize = 2_000_000;
/// Rows that wait to be written.
const MOST_ROWS: usize = 100_000;
