//! Lanes: the lines of a timing diagram.

use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::timeline::What;

use super::words;

/// A line of a timing diagram. The order is that in which a reading goes round: from the sensors to the brain and back
/// to the motors. Sensors and faults go by their places on the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Lane {
    /// A sensor: when it measures, and when it is read.
    Sensor(u16),
    /// The tasks of the microcontroller's processor, one at a time.
    Microcontroller,
    /// The wire to the laptop.
    CableUp,
    /// The adapter between wire and laptop.
    Adapter,
    /// The cable of a sensor's own.
    Port(u16),
    /// The brain's steps.
    Brain,
    /// The way from the laptop to the microcontroller.
    CableDown,
    /// What is written to the device, on the cable of a sensor's own.
    PortDown(u16),
    /// When motors and other actuators take commands up.
    Motors,
    /// Events that were late, missed or lost.
    Trouble,
    /// A fault of the scenario's.
    Fault(u16),
}

impl Lane {
    /// The lanes that this is on: a read is the sensor's and the microcontroller's, and what a brain on board thinks
    /// the microcontroller thinks.
    pub fn of(what: What, robot: &RobotSpec) -> impl Iterator<Item = Self> {
        let (first, second) = match what {
            What::Acquire { sensor } => (Self::Sensor(sensor), Some(Self::Microcontroller)),
            What::Measure { sensor } => (Self::Sensor(sensor), None),
            What::Frame { .. } | What::Block | What::Obey => (Self::Microcontroller, None),
            What::Up { .. } => (Self::CableUp, None),
            What::Adapter => (Self::Adapter, None),
            What::Port { sensor, .. } => (Self::Port(sensor), None),
            What::Think { .. } => (Self::Brain, robot.is_onboard().then_some(Self::Microcontroller)),
            What::Down { .. } => (Self::CableDown, None),
            What::PortDown { sensor, .. } => (Self::PortDown(sensor), None),
            What::Act => (Self::Motors, None),
            What::Late | What::Missed { .. } | What::Lost { .. } => (Self::Trouble, None),
            What::Fault { fault } => (Self::Fault(fault), None),
        };
        std::iter::once(first).chain(second)
    }

    /// Those that a robot has whatever happens, in their order.
    pub fn all(robot: &RobotSpec) -> Vec<Self> {
        let places = (0..=u16::MAX).zip(robot.sensors.iter());
        let sensors = places.clone().map(|(i, _)| Self::Sensor(i));
        let ports = places.clone().filter(|(_, sensor)| sensor.port.is_some()).map(|(i, _)| Self::Port(i));
        let answers = |sensor: &Sensor| sensor.port.as_ref().is_some_and(|port| port.dialogue.is_some());
        let asked = places.filter(|(_, sensor)| answers(sensor)).map(|(i, _)| Self::PortDown(i));
        let is_adapted = match &robot.link {
            Link::Uart(uart) => uart.adapter != Adapter::None,
            Link::Ideal | Link::Usb(_) | Link::Onboard => false,
        };
        let has_cable = !robot.is_onboard();
        let rest = [
            (true, Self::Microcontroller),
            (has_cable, Self::CableUp),
            (is_adapted, Self::Adapter),
            (true, Self::Brain),
            (has_cable, Self::CableDown),
            (true, Self::Motors),
        ];
        let rest = rest.into_iter().filter(|(is_there, _)| *is_there).map(|(_, lane)| lane);
        let mut lanes: Vec<_> = sensors.chain(ports).chain(asked).chain(rest).collect();
        lanes.sort_unstable();
        lanes
    }

    /// Its name.
    pub fn name(self, robot: &RobotSpec) -> String {
        match self {
            Self::Sensor(i) => words::sensor(robot, i),
            Self::Microcontroller => "microcontroller".to_owned(),
            Self::CableUp => "cable up".to_owned(),
            Self::Adapter => "adapter".to_owned(),
            Self::Port(i) => format!("port of {}", words::sensor(robot, i)),
            Self::Brain => "brain".to_owned(),
            Self::CableDown => "cable down".to_owned(),
            Self::PortDown(i) => format!("to port of {}", words::sensor(robot, i)),
            Self::Motors => "motors".to_owned(),
            Self::Trouble => "late, missed, lost".to_owned(),
            Self::Fault(i) => words::fault(robot, i),
        }
    }

    /// A number of its own among a robot's lanes, above 0 and below 2²⁰.
    pub(crate) fn code(self) -> u64 {
        let (kind, place) = match self {
            Self::Sensor(i) => (1, i),
            Self::Microcontroller => (2, 0),
            Self::CableUp => (3, 0),
            Self::Adapter => (4, 0),
            Self::Port(i) => (5, i),
            Self::Brain => (6, 0),
            Self::CableDown => (7, 0),
            Self::PortDown(i) => (8, i),
            Self::Motors => (9, 0),
            Self::Trouble => (10, 0),
            Self::Fault(i) => (11, i),
        };
        kind << 16 | u64::from(place)
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    /// A robot with two sensors, one of which has a port, and an adapter.
    const ROBOT: &str = r#"
        [[robots]]
        name = "scout"
        body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
        link = { kind = "uart", baud = 9600, adapter = { kind = "cdc" } }
        [robots.sensors.compass]
        kind = "compass"
        [robots.sensors.laser]
        kind = "laser"
        bearing_rad = 0.0
        opening_rad = 1.0
        rays = 5
        range_m = 4.0
        period_ms = 100.0
        port = { link = { kind = "uart", baud = 19200 } }
    "#;

    fn lanes(toml: &str) -> Vec<String> {
        let scenario = baudbot_scenario::parse(toml).unwrap();
        let robot = &scenario.robots[0];
        Lane::all(robot).into_iter().map(|lane| lane.name(robot)).collect()
    }

    #[test]
    fn a_robot_has_the_lanes_of_what_it_has() {
        let all = [
            "compass",
            "laser",
            "microcontroller",
            "cable up",
            "adapter",
            "port of laser",
            "brain",
            "cable down",
            "motors",
        ];
        assert_eq!(lanes(ROBOT), all);
        let onboard = ROBOT.replace("\"uart\", baud = 9600, adapter = { kind = \"cdc\" }", "\"onboard\"");
        let onboard = lanes(&onboard.replace("port = { link = { kind = \"uart\", baud = 19200 } }", ""));
        assert_eq!(onboard, ["compass", "laser", "microcontroller", "brain", "motors"]);
    }

    #[test]
    fn no_two_lanes_have_the_same_number() {
        let mut codes: Vec<_> = [
            Lane::Sensor(u16::MAX),
            Lane::Microcontroller,
            Lane::CableUp,
            Lane::Adapter,
            Lane::Port(0),
            Lane::Port(u16::MAX),
            Lane::Brain,
            Lane::CableDown,
            Lane::PortDown(0),
            Lane::PortDown(u16::MAX),
            Lane::Motors,
            Lane::Trouble,
            Lane::Fault(0),
        ]
        .map(Lane::code)
        .to_vec();
        assert!(codes.is_sorted() && codes.iter().all(|code| (1..1 << 20).contains(code)), "{codes:?}");
        codes.dedup();
        assert_eq!(codes.len(), 13);
    }
}
