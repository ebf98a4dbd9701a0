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

/// The sensor that an event is about, and how many bytes, if it is about them.
pub fn sensor_and_bytes(what: What) -> (Option<u16>, Option<u32>) {
    match what {
        What::Acquire { sensor } | What::Measure { sensor } => (Some(sensor), None),
        What::Missed { sensor } => ((sensor != NO_SENSOR).then_some(sensor), None),
        What::Port { sensor, bytes } | What::PortDown { sensor, bytes } => (Some(sensor), Some(bytes)),
        What::Frame { bytes } | What::Up { bytes } | What::Down { bytes } | What::Lost { bytes } => {
            (None, Some(bytes))
        }
        What::Block | What::Adapter | What::Think { .. } | What::Obey | What::Act => (None, None),
        What::Late | What::Fault { .. } => (None, None),
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
