//! The scenarios of the workloads, written as files would be and read by the parser that reads those.

use std::fmt::Write;

use baudbot_scenario::ScenarioError;
use baudbot_sim::Scenario;

use crate::plan::{CYLINDER_RADIUS_M, Plan};

/// The floor plans.
pub mod plans {
    /// One small robot.
    pub const IR_1: &str = include_str!("../geometry/ir1.txt");
    /// Ten of them.
    pub const IR_10: &str = include_str!("../geometry/ir10.txt");
    /// A hundred of them.
    pub const IR_100: &str = include_str!("../geometry/ir100.txt");
    /// A thousand of them.
    pub const IR_1000: &str = include_str!("../geometry/ir1000.txt");
    /// An office of 100 segments with 100 robots.
    pub const OFFICE: &str = include_str!("../geometry/office.txt");
}

/// The link between a robot's brain and its body, as a value of `link` in a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cable {
    /// None: the brain is on board.
    Onboard,
    /// One that takes no time.
    Ideal,
    /// A serial cable of 9600 baud.
    Uart9600,
}

impl Cable {
    fn toml(self) -> &'static str {
        match self {
            Self::Onboard => "{ kind = \"onboard\" }",
            Self::Ideal => "{ kind = \"ideal\" }",
            Self::Uart9600 => "{ kind = \"uart\", baud = 9600 }",
        }
    }
}

/// The program of the chips of [`chips`]: one of `crates/bench/programs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// Works out numbers all the time.
    Spinning,
    /// Wakes up each 10 ms.
    Sleeping,
}

impl Program {
    fn hex(self) -> &'static str {
        match self {
            Self::Spinning => include_str!("../programs/spinning.hex"),
            Self::Sleeping => include_str!("../programs/sleeping.hex"),
        }
    }
}

/// A number of robots side by side in the open, each with an ATmega328P at 16 MHz that runs a program, and an infrared
/// sensor.
pub fn chips(robots: usize, program: Program) -> String {
    let starts: Vec<_> = (0..robots).map(|i| format!("{{ y_m = {:.1} }}", i as f64)).collect();
    format!(
        "step_ms = 10.0\nsubsteps = 10\n[[robots]]\nname = \"robot\"\nstarts = [{}]\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, \
         turn_damping_nm_s = 0.78 }}\n\
         sensors.ir = {{ kind = \"ir\", bearing_rad = 0.0, rays = 5, opening_rad = 0.5, range_m = 1.0, c1_m2 = 0.03, c2 = 0.1, \
         bits = 10 }}\nlink = {{ preset = \"uart-9600\" }}\n[robots.pins]\nA0 = \"sensors.ir\"\n\
         9 = \"motors.left.pwm\"\n8 = \"motors.left.direction\"\n10 = \"motors.right.pwm\"\n7 = \"motors.right.direction\"\n\
         [robots.microcontroller]\nprogram = {{ hex = '''\n{}''' }}\n",
        starts.join(", "),
        program.hex()
    )
}

/// The laser of each robot of an [`office`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Laser {
    /// All rays of a scan at once, a scan every so many milliseconds, handed to the brain without a cable: as in
    /// simulators that hand a controller in their own process the distances.
    Still {
        /// The time between two scans.
        period_ms: u32,
    },
    /// A URG-04LX by its preset, with the device's own clock, ten scans a second: its mirror turns for 66.5 ms of each,
    /// while the robot drives on.
    Swept {
        /// Whether it has the preset's cable, too, which carries 2,137 bytes a scan; else a scan is handed to the brain as
        /// that of the still laser is.
        cable: bool,
    },
}

impl Laser {
    /// Rays of a scan.
    pub const fn rays(self) -> usize {
        match self {
            Self::Still { .. } => 683,
            Self::Swept { .. } => 682,
        }
    }

    /// Time between two scans, in milliseconds.
    pub const fn period_ms(self) -> u32 {
        match self {
            Self::Still { period_ms } => period_ms,
            Self::Swept { .. } => 100,
        }
    }

    /// The table of the laser of robot `i`: devices are not synchronised, so the scans of many robots are spread over
    /// their period.
    fn toml(self, i: usize) -> String {
        let rays = self.rays();
        match self {
            Self::Still { period_ms } => {
                let phase_ms = i as f64 * 10.0 % f64::from(period_ms);
                format!(
                    "[robots.sensors.laser]\nkind = \"laser\"\nmount = {{}}\nopening_rad = {LASER_OPENING_RAD}\n\
                     rays = {rays}\nrange_m = 4.0\nsweep_ms = 0.0\nperiod_ms = {period_ms}\nphase_ms = {phase_ms}\n\
                     noise = {{ additive = 0.01 }}\n"
                )
            }
            // The sensor is that of catalogue/scenarios/explore-office.toml. Its clock begins anywhere.
            Self::Swept { cable: true } => {
                "[robots.sensors.laser]\npreset = \"urg-04lx\"\nmount = {}\nrange_m = 4.0\n".to_owned()
            }
            Self::Swept { cable: false } => URG_WITHOUT_ITS_CABLE.to_owned(),
        }
    }
}

/// The devices of small robots, besides their bodies and motors, which are an e-puck's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Infrared {
    /// The cable to the brains.
    pub cable: Cable,
    /// Length of a step, in milliseconds.
    pub step_ms: f64,
    /// The number of the eight infra-red sensors that they have.
    pub sensors: usize,
    /// Whether they have encoders, too.
    pub encoders: bool,
}

impl Infrared {
    /// An `Infrared` with all eight sensors, steps of 10 ms, and no encoders.
    pub fn new(cable: Cable) -> Self {
        Self { cable, step_ms: 10.0, sensors: SENSORS_M_DEG.len(), encoders: false }
    }

    /// Such robots where the plan has them, alike but for that.
    pub fn scenario(&self, plan: &Plan) -> String {
        let mut toml = head("infrared", self.step_ms);
        arena(&mut toml, plan);
        toml += "[[robots]]\nname = \"r\"\nstarts = [\n";
        for (i, &[x, y, heading]) in plan.robots.iter().enumerate() {
            let _ = writeln!(
                toml,
                "    {{ name = \"{}\", x_m = {x:?}, y_m = {y:?}, heading_rad = {heading:?} }},",
                name(i)
            );
        }
        let _ = write!(toml, "]\n{SMALL_BODY}link = {}\n", self.cable.toml());
        self.senses(&mut toml);
        toml
    }

    /// Read and sent in every step, as exact numbers; on a serial cable as often and as short as there is time for.
    fn senses(&self, toml: &mut String) {
        let serial = self.cable == Cable::Uart9600;
        if serial {
            let _ = writeln!(toml, "firmware = {{ period_ms = {SERIAL_MS} }}");
        }
        for (i, [x, y, degrees]) in SENSORS_M_DEG.into_iter().enumerate().take(self.sensors) {
            let heading = degrees.to_radians();
            let _ = write!(
                toml,
                "[robots.sensors.ir_{i}]\nkind = \"ir\"\n\
                 mount = {{ x_m = {x:?}, y_m = {y:?}, heading_rad = {heading:?} }}\n\
                 rays = 3\nopening_rad = {IR_OPENING_RAD}\nrange_m = 0.12\n\
                 c1_m2 = 2.0e-4\nc2 = 0.0\nsigma = 0.02\n"
            );
            if serial {
                let _ = writeln!(toml, "bits = 8\nperiod_ms = {SERIAL_MS}");
            }
        }
        if self.encoders {
            *toml += "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 1000\nbits = 16\n";
        }
    }
}

/// The first `robots` robots of a plan, each with a laser and its brain on board; steps of 10 ms.
pub fn office(plan: &Plan, robots: usize, laser: Laser) -> String {
    let mut toml = head("office", 10.0);
    arena(&mut toml, plan);
    for (i, &start) in plan.robots.iter().take(robots).enumerate() {
        robot(&mut toml, i, start);
        toml += &laser.toml(i);
        toml += "[robots.link]\nkind = \"onboard\"\n";
    }
    toml
}

/// The scenario of a text.
///
/// # Errors
/// If it refuses it.
pub fn parse(toml: &str) -> Result<Scenario, ScenarioError> {
    baudbot_scenario::parse(toml)
}

fn head(name: &str, step_ms: f64) -> String {
    format!("name = \"{name}\"\nseed = 1\nstep_ms = {step_ms}\ncollision = \"stop-robot\"\n")
}

fn arena(toml: &mut String, plan: &Plan) {
    let mut polygon = |name: &str, i: usize, flags: &str, points: &[[f64; 2]]| {
        let points = format!("{points:?}");
        let _ = write!(toml, "[[arena.polygons]]\nname = \"{name}-{i}\"\n{flags}points_m = {points}\n");
    };
    for (i, &[x0, y0, x1, y1]) in plan.walls.iter().enumerate() {
        polygon("wall", i, "solid = false\nclosed = false\n", &[[x0, y0], [x1, y1]]);
    }
    for (i, &[x, y, width, height]) in plan.boxes.iter().enumerate() {
        let (w, h) = (width / 2.0, height / 2.0);
        polygon("box", i, "", &[[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]]);
    }
    for (i, [x, y]) in plan.cylinders.iter().enumerate() {
        let _ = write!(
            toml,
            "[[arena.circles]]\nname = \"cylinder-{i}\"\nx_m = {x:?}\ny_m = {y:?}\n\
             radius_m = {CYLINDER_RADIUS_M}\n"
        );
    }
}

/// A robot of the office, still without sensors.
fn robot(toml: &mut String, i: usize, [x, y, heading]: [f64; 3]) {
    let _ = write!(
        toml,
        "[[robots]]\nname = \"{}\"\n\
         start = {{ x_m = {x:?}, y_m = {y:?}, heading_rad = {heading:?} }}\n{OFFICE_BODY}",
        name(i)
    );
}

fn name(i: usize) -> String {
    format!("r{i:04}")
}

/// Time between two readings on a serial cable of 9600 baud: a frame of one value takes some 10 ms.
const SERIAL_MS: f64 = 20.0;

/// 30°.
const IR_OPENING_RAD: f64 = std::f64::consts::PI / 6.0;

/// 240°, and so many rays that two neighbours are 0.352° apart.
const LASER_OPENING_RAD: f64 = 240.0 * std::f64::consts::PI / 180.0;

/// crates/scenario/presets/urg-04lx.toml but for its port, which a file cannot take from a preset.
const URG_WITHOUT_ITS_CABLE: &str = "\
[robots.sensors.laser]
kind = \"laser\"
mount = {}
opening_rad = 4.178564
rays = 682
min_m = 0.02
range_m = 4.0
sweep_ms = 66.5039
clock = { period_ms = 100.0 }
period_ms = 100.0
noise = { multiplicative = 0.004, additive = 0.003 }
";

/// Places on the body and bearings of the small robot's sensors, as on an e-puck.
const SENSORS_M_DEG: [[f64; 3]; 8] = [
    [0.0335, -0.0105, -18.0],
    [0.023, -0.026, -45.0],
    [0.0, -0.033, -90.0],
    [-0.030, -0.018, -142.0],
    [-0.030, 0.018, 142.0],
    [0.0, 0.033, 90.0],
    [0.023, 0.026, 45.0],
    [0.0335, 0.0105, 18.0],
];

/// The e-puck's of `crates/scenario/presets/e-puck.toml`, with stepper motors whose wheels have the speeds that are commanded. They are
/// not those of a preset, which may be corrected: that would be another workload.
const SMALL_BODY: &str = "\
body = { radius_m = 0.035, mass_kg = 0.15, inertia_kg_m2 = 9.2e-5, wheel_radius_m = 0.0205, half_track_m = 0.0265 }
motors = { kind = \"stepper\", steps_per_turn = 1000, full_rate_steps_s = 1000, max_rate_steps_s = 1200, max_acceleration_steps_s2 = 4000 }
";

/// A disc of 0.3 m with steppers: up to 0.5 m/s.
const OFFICE_BODY: &str = "\
body = { radius_m = 0.15, mass_kg = 3.0, inertia_kg_m2 = 0.034, wheel_radius_m = 0.05, half_track_m = 0.13 }
motors = { kind = \"stepper\", steps_per_turn = 1000, full_rate_steps_s = 1591.5, max_acceleration_steps_s2 = 6000 }
";
