//! The lines of a timing diagram: which events are on them, and what they are called.

use baudbot_sim::chip::Signal;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::What;

use super::diagram::Group;
use super::words;

/// A line of a timing diagram. The order is that in which a reading goes round: from the sensors to the brain and back
/// to the motors. Sensors and faults go by their places on the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LaneId {
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
    /// The bytes written to the device, on a sensor's own cable.
    PortDown(u16),
    /// The instants at which motors and other actuators take commands up.
    Motors,
    /// Events that were late, missed or lost.
    Trouble,
    /// A fault of the scenario's.
    Fault(u16),
    /// A signal of a chip, by its place among [all](baudbot_sim::chip::ChipSpec::signals).
    Signal(u16),
}

impl LaneId {
    /// The lane of an event.
    pub fn of(what: What) -> Self {
        match what {
            What::Acquire { sensor } | What::Measure { sensor } => Self::Sensor(sensor),
            What::Frame { .. } | What::Block | What::Obey => Self::Microcontroller,
            What::Up { .. } => Self::CableUp,
            What::Adapter => Self::Adapter,
            What::Port { sensor, .. } => Self::Port(sensor),
            What::Think { .. } => Self::Brain,
            What::Down { .. } => Self::CableDown,
            What::PortDown { sensor, .. } => Self::PortDown(sensor),
            What::Act => Self::Motors,
            What::Late | What::Missed { .. } | What::Lost { .. } => Self::Trouble,
            What::Fault { fault } => Self::Fault(fault),
        }
    }

    /// All lanes of an event: a read is the sensor's and the microcontroller's, and what a brain on board thinks the
    /// microcontroller thinks.
    pub fn all_of(what: What, robot: &RobotSpec) -> impl Iterator<Item = Self> {
        let is_read = matches!(what, What::Acquire { .. });
        let is_thought_on_board = matches!(what, What::Think { .. }) && robot.is_onboard();
        let second = (is_read || is_thought_on_board).then_some(Self::Microcontroller);
        std::iter::once(Self::of(what)).chain(second)
    }

    /// The lanes that a robot has in any case, in their order.
    pub fn always(robot: &RobotSpec) -> Vec<Self> {
        let mut lanes = vec![Self::Microcontroller, Self::Brain, Self::Motors];
        if !robot.is_onboard() {
            lanes.extend([Self::CableUp, Self::CableDown]);
        }
        match &robot.link {
            Link::Uart(uart) if uart.adapter != Adapter::None => lanes.push(Self::Adapter),
            Link::Uart(_) | Link::Ideal | Link::Usb(_) | Link::Onboard => {}
        }
        for (i, sensor) in (0..=u16::MAX).zip(robot.sensors.iter()) {
            let port = sensor.port.as_ref();
            lanes.push(Self::Sensor(i));
            lanes.extend(port.map(|_| Self::Port(i)));
            lanes.extend(port.and_then(|port| port.dialogue.as_ref()).map(|_| Self::PortDown(i)));
        }
        lanes.sort_unstable();
        lanes
    }

    /// The name of the lane.
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
            Self::Signal(i) => {
                signal(robot, i).map_or_else(|| format!("signal {i}"), |signal| signal.label())
            }
        }
    }

    /// A number of its own among a robot's lanes, above 0 and below 2²⁰.
    pub(crate) fn code(self) -> u64 {
        let (kind, place, _) = self.parts();
        kind << 16 | u64::from(place)
    }

    /// The lane's part of the path.
    pub(crate) fn group(self) -> Group {
        self.parts().2
    }

    /// The number of its kind, its place among those, and its part of the path.
    fn parts(self) -> (u64, u16, Group) {
        match self {
            Self::Sensor(i) => (1, i, Group::Sensors),
            Self::Microcontroller => (2, 0, Group::Microcontroller),
            Self::CableUp => (3, 0, Group::Up),
            Self::Adapter => (4, 0, Group::Up),
            Self::Port(i) => (5, i, Group::Up),
            Self::Brain => (6, 0, Group::Brain),
            Self::CableDown => (7, 0, Group::Down),
            Self::PortDown(i) => (8, i, Group::Down),
            Self::Motors => (9, 0, Group::Motors),
            Self::Trouble => (10, 0, Group::Trouble),
            Self::Fault(i) => (11, i, Group::Trouble),
            Self::Signal(i) => (12, i, Group::Pins),
        }
    }
}

/// The signal at a place, if the robot has a chip with it.
pub(crate) fn signal(robot: &RobotSpec, place: u16) -> Option<Signal> {
    robot.chip.as_ref()?.signals().into_iter().nth(place.into())
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
        LaneId::always(robot).into_iter().map(|lane| lane.name(robot)).collect()
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
            LaneId::Sensor(u16::MAX),
            LaneId::Microcontroller,
            LaneId::CableUp,
            LaneId::Adapter,
            LaneId::Port(0),
            LaneId::Port(u16::MAX),
            LaneId::Brain,
            LaneId::CableDown,
            LaneId::PortDown(0),
            LaneId::PortDown(u16::MAX),
            LaneId::Motors,
            LaneId::Trouble,
            LaneId::Fault(0),
            LaneId::Signal(u16::MAX),
        ]
        .map(LaneId::code)
        .to_vec();
        assert!(codes.is_sorted() && codes.iter().all(|code| (1..1 << 20).contains(code)), "{codes:?}");
        codes.dedup();
        assert_eq!(codes.len(), 14);
    }
}
