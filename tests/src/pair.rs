//! A world and its brains in one thread: lockstep without a network.

use std::sync::Arc;

use baudbot_brains::catalogue;
use baudbot_client::{Body, Brain, Component, Firmware, Mount, Protocol, RawCommands, Reading, Sensor, Turn};
use baudbot_sim::firmware::{Mode, Protocol as SimProtocol};
use baudbot_sim::link::Link;
use baudbot_sim::robot::RobotSpec;
use baudbot_sim::sensor::Device;
use baudbot_sim::{Input, RobotView, Scenario, SimTime, World};

/// A world and a brain for each of its robots.
pub struct Pair {
    /// The world.
    pub world: World,
    brains: Vec<Driver>,
}

struct Driver {
    body: Arc<Body>,
    brain: Box<dyn Brain + Send>,
    commands: RawCommands,
}

impl Pair {
    /// All robots get the brain that `brain` describes, seeded with the scenario's seed.
    ///
    /// # Panics
    /// If the catalogue has no such brain for a robot.
    pub fn new(scenario: Scenario, brain: &str) -> Self {
        let driver = |spec| {
            let body = Arc::new(body(spec));
            let brain = catalogue::brain(brain, scenario.seed(), &body).expect("a brain of the catalogue");
            let commands = RawCommands::new(&body).expect("a sound body");
            Driver { body, brain, commands }
        };
        let brains = scenario.robots().iter().map(driver).collect();
        Self { world: World::new(scenario.into()), brains }
    }

    /// As [`new`](Self::new), with a brain of the test's own for the only robot.
    ///
    /// # Panics
    /// If there is not one robot.
    pub fn with_brain(scenario: Scenario, brain: impl Brain + Send + 'static) -> Self {
        let [spec] = scenario.robots() else { panic!("a scenario with one robot") };
        let body = Arc::new(body(spec));
        let commands = RawCommands::new(&body).expect("a sound body");
        let brains = vec![Driver { body, brain: Box::new(brain), commands }];
        Self { world: World::new(scenario.into()), brains }
    }

    /// First half of a tick, the brains' steps, second half; `look` sees the world in between.
    pub fn tick(&mut self, look: impl FnOnce(&World)) {
        let turns = self.world.begin().to_vec();
        look(&self.world);
        let mut answers: Vec<(usize, SimTime, Vec<u8>)> = Vec::new();
        for turn in turns {
            let driver = &mut self.brains[turn.robot];
            let view = self.world.robot(turn.robot);
            let action = driver.brain.step(&client_turn(&driver.body, &view, self.world.tick(), turn.at));
            let thinking_ns =
                action.thinking.map_or_else(|| view.spec().thinking_ns, |time| time.as_nanos() as u64);
            let bytes = match (action.signals, action.poll) {
                (Some(signals), _) => driver.commands.command(signals),
                (None, true) => driver.commands.poll().unwrap_or_default(),
                (None, false) => Vec::new(),
            };
            answers.push((turn.robot, turn.at + thinking_ns, bytes));
        }
        let inputs: Vec<_> =
            answers.iter().map(|(robot, at, bytes)| Input { robot: *robot, at: *at, bytes }).collect();
        self.world.finish(&inputs);
    }

    /// As many ticks, or fewer if the run ends.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            if self.world.ending().is_some() {
                return;
            }
            self.tick(|_| {});
        }
    }
}

/// The turn of a brain of messages, as the server gives it.
fn client_turn(body: &Arc<Body>, view: &RobotView<'_>, tick: u64, at: SimTime) -> Turn {
    let reading = |reading: &baudbot_sim::Reading| {
        (!reading.values.is_empty()).then(|| Reading {
            values: reading.values.clone(),
            sampled_at_ns: reading.sampled_at.map(SimTime::as_ns),
            sequence: reading.sequence.into(),
            readable: reading.readable,
        })
    };
    let readings = view.readings().iter().map(reading).collect();
    Turn { tick, at_ns: at.as_ns(), readings, body: Arc::clone(body) }
}

/// The data sheet of a robot, as the server gives it.
pub fn body(spec: &RobotSpec) -> Body {
    let (baud, bits_per_character) = match &spec.link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
        Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character.into())),
    };
    let protocol = match spec.firmware.protocol {
        SimProtocol::Framed { ages } => Protocol::Framed { ages },
        SimProtocol::Bare { gap_ns } => Protocol::Bare { gap_ns },
    };
    let period_ns = match spec.firmware.mode {
        Mode::Stream(schedule) => Some(schedule.period_ns()),
        Mode::Poll => None,
    };
    Body {
        name: spec.name.clone(),
        radius_m: spec.drive.radius_m,
        half_track_m: spec.drive.half_track_m,
        wheel_radius_m: spec.drive.wheel_radius_m,
        signal_limit: spec.signal_limit,
        motor_encoding: spec.firmware.motor_encoding(),
        sensors: spec.sensors.iter().map(sensor).collect(),
        firmware: Firmware { protocol, period_ns },
        baud,
        bits_per_character,
    }
}

fn sensor(spec: &baudbot_sim::sensor::Sensor) -> Sensor {
    let components = spec.device.components();
    let components = components.iter().zip(&spec.encodings);
    let components = components.map(|(component, &encoding)| Component {
        name: component.name.to_owned(),
        unit: component.unit.to_owned(),
        encoding,
    });
    let mount = spec.device.mount().map(|mount| {
        let (x_m, y_m) = (mount.pose.position.x, mount.pose.position.y);
        Mount { x_m, y_m, heading_rad: mount.pose.heading }
    });
    let counts_per_turn = match &spec.device {
        Device::Encoders(encoders) => Some(encoders.counts_per_turn),
        _ => None,
    };
    Sensor {
        name: spec.name.clone(),
        kind: spec.device.kind().to_owned(),
        components: components.collect(),
        period_ns: spec.schedule.period_ns(),
        phase_ns: spec.schedule.phase_ns(),
        mount,
        range_m: spec.device.range_m(),
        counts_per_turn,
    }
}
