//! The state of a world at every tick, as a table of comma-separated values.
//!
//! Names have no commas in them (scenario files see to that), so nothing is quoted. Numbers have 17
//! significant digits: read back, they are the same bits. What a robot does not have, or not yet, is an
//! empty cell.

use std::collections::{HashMap, HashSet};
use std::io::{self, BufWriter, Write};

use baudbot_sim::model::RobotSpec;
use baudbot_sim::{RobotView, World};
use baudbot_sim::{sensor_columns, state_columns, state_values};
use tokio::sync::oneshot;

/// A table that is being written, on its world's thread.
pub(crate) struct Table {
    out: BufWriter<Box<dyn Write + Send>>,
    /// The place of the robot's value for each robot and each sensor column.
    cells: Vec<Vec<Option<usize>>>,
    /// The same for the columns of the robots' own state.
    state_cells: Vec<Vec<Option<usize>>>,
    /// The sender, taken when the first write fails; otherwise used when the table is done.
    outcome: Option<oneshot::Sender<io::Result<()>>>,
    values: Vec<f64>,
    /// The header above the rows; taken with the first.
    header: Option<String>,
}

impl Table {
    /// A table, and how it went: an error as soon as one occurs, or else the end, when the
    /// table is dropped.
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        robots: &[RobotSpec],
    ) -> (Self, oneshot::Receiver<io::Result<()>>) {
        let (sensors, cells) = shared(robots.iter().map(sensor_columns));
        let (state, state_cells) = shared(robots.iter().map(state_columns));
        let (outcome, receiver) = oneshot::channel();
        let out = BufWriter::with_capacity(BUFFER, out);
        let header = Some(header(&sensors, &state));
        (Self { out, cells, state_cells, outcome: Some(outcome), values: Vec::new(), header }, receiver)
    }

    /// One row a robot: the state at the start of a tick, with the readings that were taken at it.
    pub(crate) fn write(&mut self, world: &World) {
        if self.outcome.is_some() {
            let written = self.rows(world);
            self.note(written);
        }
    }

    fn rows(&mut self, world: &World) -> io::Result<()> {
        if let Some(header) = self.header.take() {
            self.out.write_all(header.as_bytes())?;
        }
        for (i, robot) in world.robots().enumerate() {
            write!(self.out, "{:.16e},{}", world.time().as_seconds(), robot.spec().name)?;
            let motion = robot.motion();
            let (position, heading) = (motion.pose.position, motion.pose.heading);
            for number in [position.x, position.y, heading, motion.speed_m_s, motion.turn_rate_rad_s] {
                number_cell(&mut self.out, Some(number))?;
            }
            collect(&robot, &mut self.values);
            for cell in &self.cells[i] {
                number_cell(&mut self.out, cell.map(|value| self.values[value]))?;
            }
            number_cell(&mut self.out, Some(robot.signals().left))?;
            number_cell(&mut self.out, Some(robot.signals().right))?;
            write!(self.out, ",{}", u8::from(robot.collided()))?;
            let state = state_values(&robot);
            for cell in &self.state_cells[i] {
                number_cell(&mut self.out, cell.map(|value| state[value]))?;
            }
            writeln!(self.out)?;
        }
        Ok(())
    }

    /// The first failure is reported at once, and ends the table.
    fn note(&mut self, result: io::Result<()>) {
        if let Err(error) = result
            && let Some(outcome) = self.outcome.take()
        {
            let _ = outcome.send(Err(error));
        }
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        if let Some(outcome) = self.outcome.take() {
            // A world that never began has no table; what the file held stays.
            let done = if self.header.is_some() { Ok(()) } else { self.out.flush() };
            let _ = outcome.send(done);
        }
    }
}

/// The columns that robots have, each once, and for each robot and each of these columns the place among its own.
pub(crate) fn shared(own: impl Iterator<Item = Vec<String>>) -> (Vec<String>, Vec<Vec<Option<usize>>>) {
    let own: Vec<_> = own.collect();
    let mut seen = HashSet::new();
    let union: Vec<String> = own.iter().flatten().filter(|column| seen.insert(*column)).cloned().collect();
    let cells = own.iter().map(|own| {
        let places: HashMap<_, _> = own.iter().enumerate().map(|(i, column)| (column, i)).collect();
        union.iter().map(|column| places.get(column).copied()).collect()
    });
    let cells = cells.collect();
    (union, cells)
}

fn header(sensors: &[String], state: &[String]) -> String {
    let mut header = "t_s,robot,x_m,y_m,heading_rad,speed_m_s,turn_rate_rad_s".to_owned();
    let columns = sensors.iter().map(String::as_str);
    let columns = columns.chain(["left_signal", "right_signal", "collided"]);
    for column in columns.chain(state.iter().map(String::as_str)) {
        header.push(',');
        header.push_str(column);
    }
    header + "\n"
}

/// The last samples of all of a robot's sensors, NaN before the first.
pub(crate) fn collect(robot: &RobotView<'_>, values: &mut Vec<f64>) {
    values.clear();
    for (sensor, spec) in robot.sensors().zip(robot.spec().sensors.iter()) {
        let missing = spec.encodings.len() - sensor.sample.len();
        values.extend(sensor.sample.iter().copied().chain(std::iter::repeat_n(f64::NAN, missing)));
    }
}

fn number_cell(out: &mut impl Write, number: Option<f64>) -> io::Result<()> {
    match number {
        Some(number) if !number.is_nan() => write!(out, ",{number:.16e}"),
        _ => out.write_all(b","),
    }
}

const BUFFER: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use baudbot_scenario::Override;

    use super::*;

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    struct Full;

    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    const TWO_ROBOTS: &str = r#"
        [[robots]]
        name = "b"
        body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
        sensors.heading = { kind = "compass" }

        [[robots]]
        name = "a"
        start.x_m = 0.3
        body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
        sensors.odometer = { kind = "odometer", sigma_m = 0.0, phase_ms = 1.0 }
    "#;

    #[test]
    fn robots_with_other_sensors_share_a_table() {
        let shared = Shared::default();
        let start = Override::parse("robots.a.start.heading_rad=0.1").unwrap();
        let mut world = World::new(baudbot_scenario::parse_with(TWO_ROBOTS, &[start]).unwrap().into());
        let (mut table, mut outcome) = Table::new(Box::new(shared.clone()), &world.scenario().robots);
        world.begin();
        table.write(&world);
        assert!(outcome.try_recv().is_err(), "nothing to tell yet");
        drop(table);
        assert!(outcome.try_recv().unwrap().is_ok());
        let text = String::from_utf8(shared.0.lock().unwrap().clone()).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let sensors = ["odometer.x_m", "odometer.y_m", "odometer.heading_rad", "heading"];
        assert_eq!(rows[0][7..11], sensors);
        assert_eq!((rows[1][1], rows[2][1]), ("a", "b"));
        assert_eq!(rows[1][2].parse(), Ok(0.3));
        assert_eq!(rows[1][4], "1.0000000000000001e-1", "17 digits");
        assert_eq!(rows[2][7..11], ["", "", "", "0.0000000000000000e0"]);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    }

    #[test]
    fn a_world_that_never_begins_leaves_no_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let world = World::new(baudbot_scenario::parse(TWO_ROBOTS).unwrap().into());
        let (table, mut outcome) =
            Table::new(crate::output_files::open(&path).unwrap(), &world.scenario().robots);
        drop(table);
        assert!(outcome.try_recv().unwrap().is_ok());
        assert!(!path.exists());
    }

    #[test]
    fn a_failure_is_told_at_once_and_once() {
        let mut world = World::new(baudbot_scenario::parse(TWO_ROBOTS).unwrap().into());
        let (mut table, mut outcome) = Table::new(Box::new(Full), &world.scenario().robots);
        world.begin();
        // The buffer holds the first rows.
        for _ in 0..BUFFER / 100 {
            table.write(&world);
        }
        assert_eq!(outcome.try_recv().unwrap().unwrap_err().kind(), io::ErrorKind::StorageFull);
        table.write(&world);
        drop(table);
    }
}
