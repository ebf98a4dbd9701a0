//! Logs of simulated robots, and how often their hidden numbers are found.

use std::fmt::Write as _;

use baudbot_fit::choice::choose;
use baudbot_fit::estimate::{Finding, Fitted, Outcome, Remark};
use baudbot_fit::log::{Log, Options, read};
use baudbot_fit::{Robot, fit, readings};
use baudbot_scenario::Override;
use baudbot_sim::random::Stream;
use baudbot_sim::{Input, Scenario, World};
use baudbot_wire::{frame, write_command};

/// A scenario with some of its fields changed.
pub fn scenario(toml: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<_> = overrides.iter().map(|text| Override::parse(text).unwrap()).collect();
    baudbot_scenario::parse_with(toml, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// The findings of a fit of a log, as of the robot of a scenario.
pub fn findings(scenario: &Scenario, log: &str, fields: &[&str]) -> Vec<Finding> {
    fitted(scenario, log, fields).findings
}

/// The remarks of the fit.
pub fn remarks(scenario: &Scenario, log: &str, fields: &[&str]) -> Vec<Remark> {
    fitted(scenario, log, fields).remarks
}

fn fitted(scenario: &Scenario, log: &str, fields: &[&str]) -> Fitted {
    let robot = &scenario.robots[0];
    let fields: Vec<String> = fields.iter().map(ToString::to_string).collect();
    let wanted = choose(robot, &fields, &[]).unwrap_or_else(|error| panic!("{error}"));
    let tick_s = scenario.step_ns as f64 * 1e-9;
    let robot = Robot { model: robot, tick_s, substep_s: tick_s / f64::from(scenario.substeps) };
    fit(robot, &parsed(scenario, log), &wanted)
}

pub fn parsed(scenario: &Scenario, log: &str) -> Log {
    let options = Options { readings: readings(&scenario.robots[0]), ..Options::default() };
    read("log.csv", log.as_bytes(), &options, &mut |_| ()).unwrap_or_else(|error| panic!("{error}"))
}

/// The finding of a path.
pub fn of<'a>(findings: &'a [Finding], path: &str) -> &'a Outcome {
    let found = findings.iter().find(|finding| finding.path == path);
    &found.unwrap_or_else(|| panic!("no {path} in {findings:?}")).outcome
}

/// A count of the fits whose interval contains each hidden number.
#[derive(Default)]
pub struct Tally(Vec<(String, u32, Vec<String>)>);

impl Tally {
    pub fn add(&mut self, findings: &[Finding], path: &str, hidden: f64) {
        let outcome = of(findings, path);
        let is_in = matches!(outcome, Outcome::Estimate(e) if e.low <= hidden && hidden <= e.high);
        let place = self.0.iter().position(|(known, ..)| known == path).unwrap_or_else(|| {
            self.0.push((path.to_owned(), 0, Vec::new()));
            self.0.len() - 1
        });
        self.0[place].1 += u32::from(is_in);
        let text = match outcome {
            Outcome::Estimate(e) => {
                format!("{:.5e} [{:.5e} {:.5e}] of {hidden:.5e} {is_in}", e.value, e.low, e.high)
            }
            Outcome::CannotTell(reason) => format!("cannot tell: {reason}"),
        };
        self.0[place].2.push(text);
    }

    /// Fails if a number was missed more often than in a tenth of the runs.
    pub fn check(&self) {
        let mut missed = String::new();
        for (path, found, all) in &self.0 {
            println!("{path}: {found} of {}", all.len());
            if *found as usize + all.len() / 10 < all.len() {
                missed += &format!("{path}: {found} of {}\n{}\n", all.len(), all.join("\n"));
            }
        }
        assert!(missed.is_empty(), "{missed}");
    }
}

/// Runs a robot with a link without delay; `signals` are what its brain commands from a time on, and `noise` is added to the
/// measured speeds and turn rates. The log has a row a tick.
pub fn drive(scenario: Scenario, ticks: u64, mut signals: impl FnMut(f64) -> [f64; 2]) -> World2Log {
    let mut world = World::new(scenario.into());
    let mut log = World2Log::new(&world);
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let command = signals(world.time().as_seconds());
        log.row(&world, command);
        let bytes = command_bytes(&world, command);
        let inputs: Vec<_> =
            turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: &bytes }).collect();
        world.finish(&inputs);
    }
    log
}

fn command_bytes(world: &World, signals: [f64; 2]) -> Vec<u8> {
    let layout = world.robot(0).spec().firmware.layout();
    let mut payload = [0; frame::MAX_PAYLOAD];
    let n = write_command(&layout, 0, signals, &mut payload).unwrap();
    let mut bytes = [0; frame::MAX_FRAME];
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    bytes[..n].to_vec()
}

/// One row of a log.
#[derive(Clone, Debug)]
pub struct Row {
    pub time_s: f64,
    pub command: [f64; 2],
    pub pose: [f64; 3],
    pub speeds: [f64; 2],
    pub readings: Vec<f64>,
}

/// A log as it is being made.
pub struct World2Log {
    pub rows: Vec<Row>,
    pub names: Vec<String>,
}

impl World2Log {
    fn new(world: &World) -> Self {
        let spec = world.robot(0).spec();
        let names = spec.sensors.iter().flat_map(|sensor| {
            sensor.device.components().into_iter().map(|component| match component.name {
                "" => sensor.name.clone(),
                part => format!("{}.{part}", sensor.name),
            })
        });
        Self { rows: Vec::new(), names: names.collect() }
    }

    fn row(&mut self, world: &World, command: [f64; 2]) {
        let robot = world.robot(0);
        let motion = robot.motion();
        let readings = robot.sensors().zip(robot.spec().sensors.iter()).flat_map(|(sensor, spec)| {
            let sample = sensor.sample;
            (0..spec.encodings.len()).map(|i| sample.get(i).copied().unwrap_or(f64::NAN)).collect::<Vec<_>>()
        });
        self.rows.push(Row {
            time_s: world.time().as_seconds(),
            command,
            pose: [motion.pose.position.x, motion.pose.position.y, motion.pose.heading],
            speeds: [motion.speed_m_s, motion.turn_rate_rad_s],
            readings: readings.collect(),
        });
    }

    /// The table, with these groups of columns.
    pub fn table(&self, commands: bool, poses: bool, speeds: bool, readings: bool) -> String {
        let mut text = "time_s".to_owned();
        let mut head = |wanted: bool, names: &[&str]| {
            if wanted {
                names.iter().for_each(|name| write!(text, ",{name}").unwrap());
            }
        };
        head(commands, &["command_left", "command_right"]);
        head(poses, &["x_m", "y_m", "heading_rad"]);
        head(speeds, &["speed_m_s", "turn_rate_rad_s"]);
        head(readings, &self.names.iter().map(String::as_str).collect::<Vec<_>>());
        for row in &self.rows {
            write!(text, "\n{:.9}", row.time_s).unwrap();
            let mut cells = |wanted: bool, numbers: &[f64]| {
                for number in numbers.iter().filter(|_| wanted) {
                    text.push(',');
                    if number.is_finite() {
                        write!(text, "{number:.12e}").unwrap();
                    }
                }
            };
            cells(commands, &row.command);
            cells(poses, &row.pose);
            cells(speeds, &row.speeds);
            cells(readings, &row.readings);
        }
        text
    }
}

/// Numbers that are drawn for a test.
pub struct Chance(Stream);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(Stream::new(seed, "test"))
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.uniform()
    }

    pub fn normal(&mut self, sigma: f64) -> f64 {
        sigma * self.0.normal()
    }
}
