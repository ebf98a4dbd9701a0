//! Events in words.

use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::What;

/// The event, in few words; sensors and faults by their names.
pub fn what(what: What, robot: &RobotSpec) -> String {
    match what {
        What::Acquire { sensor: i } => format!("read {}", sensor(robot, i)),
        What::Measure { sensor: i } => format!("measure {}", sensor(robot, i)),
        What::Frame { .. } => "frame".to_owned(),
        What::Block => "wait for the transmitter".to_owned(),
        What::Up { .. } => "readings".to_owned(),
        What::Adapter => "readings in the adapter".to_owned(),
        What::Port { sensor: i, .. } => format!("message of {}", sensor(robot, i)),
        What::PortDown { sensor: i, .. } => format!("message to {}", sensor(robot, i)),
        What::Think { informed: true } => "think".to_owned(),
        What::Think { informed: false } => "think, without news".to_owned(),
        What::Down { .. } => "command".to_owned(),
        What::Obey => "obey".to_owned(),
        What::Act => "act".to_owned(),
        What::Late => "late".to_owned(),
        What::Missed { sensor: NO_SENSOR } => "missed frame".to_owned(),
        What::Missed { sensor: i } => format!("missed read of {}", sensor(robot, i)),
        What::Lost { .. } => "bytes lost".to_owned(),
        What::Fault { fault: i } => fault(robot, i),
    }
}

/// How many bytes it is about, if it is about bytes.
pub fn bytes(what: What) -> Option<u32> {
    match what {
        What::Frame { bytes }
        | What::Up { bytes }
        | What::Port { bytes, .. }
        | What::PortDown { bytes, .. }
        | What::Down { bytes }
        | What::Lost { bytes } => Some(bytes),
        What::Acquire { .. }
        | What::Measure { .. }
        | What::Block
        | What::Adapter
        | What::Think { .. }
        | What::Obey
        | What::Act
        | What::Late
        | What::Missed { .. }
        | What::Fault { .. } => None,
    }
}

/// The name of the sensor that it is about, if it is about one.
pub fn sensor_of(what: What, robot: &RobotSpec) -> Option<String> {
    match what {
        What::Acquire { sensor: i }
        | What::Measure { sensor: i }
        | What::Port { sensor: i, .. }
        | What::PortDown { sensor: i, .. } => Some(sensor(robot, i)),
        What::Missed { sensor: i } => (i != NO_SENSOR).then(|| sensor(robot, i)),
        What::Frame { .. }
        | What::Block
        | What::Up { .. }
        | What::Adapter
        | What::Think { .. }
        | What::Down { .. }
        | What::Obey
        | What::Act
        | What::Late
        | What::Lost { .. }
        | What::Fault { .. } => None,
    }
}

/// The name of the sensor at a place.
pub fn sensor(robot: &RobotSpec, place: u16) -> String {
    match robot.sensors.get(usize::from(place)) {
        Some(sensor) => sensor.name.clone(),
        None => format!("sensor {place}"),
    }
}

/// The fault at a place.
pub fn fault(robot: &RobotSpec, place: u16) -> String {
    match robot.faults.get(usize::from(place)) {
        Some(fault) => fault.kind.to_string(),
        None => format!("fault {place}"),
    }
}

/// Stands in [`What::Missed`] for a frame.
const NO_SENSOR: u16 = u16::MAX;
