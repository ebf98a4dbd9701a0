//! The protocol at a serial port, if a driver of the real robot or sensor would not understand it.

use baudbot_proto::v1;
use baudbot_proto::v1::firmware::Protocol;

/// The properties of a port that the contract's description of a robot lacks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// A program of the user's own speaks for the robot, and its users know what.
    pub(crate) has_chip: bool,
    /// Whether the device answers commands, if that is known.
    pub(crate) answers: Option<bool>,
}

/// The note on the port of a robot, or of its device, at which drivers of the real thing do not understand the language.
pub(crate) fn note(robot: &v1::RobotDescription, device: Option<&str>, known: Known) -> Option<String> {
    let name = &robot.robot;
    match device {
        None if known.has_chip => None,
        None => of_robot(robot).map(|speaks| format!("{name} {speaks}")),
        Some(device) => of_device(robot, device, known).map(|speaks| format!("{name}/{device} {speaks}")),
    }
}

fn of_robot(robot: &v1::RobotDescription) -> Option<&'static str> {
    match robot.firmware.as_ref()?.protocol.as_ref()? {
        Protocol::Framed(_) => Some(
            "speaks baudbot's own frames; no driver of the real robot understands them, unless the real robot speaks them, too",
        ),
        Protocol::Bare(_) => Some(
            "speaks bare bytes, one value after the other; no driver of the real robot understands them, unless the real \
             robot speaks them, too",
        ),
        Protocol::Khepera(_) | Protocol::Create(_) | Protocol::Asercom(_) => None,
    }
}

fn of_device(robot: &v1::RobotDescription, device: &str, known: Known) -> Option<&'static str> {
    let sensor = robot.sensors.iter().find(|sensor| sensor.sensor == device)?;
    match (sensor.port?.format(), known.answers) {
        (v1::PortFormat::Scip2, Some(true))
        | (v1::PortFormat::Nmea | v1::PortFormat::Unspecified, None | Some(_)) => None,
        (v1::PortFormat::Scip2, Some(false)) => Some(
            "sends scans by SCIP 2.0 and answers no commands, so no driver of the real laser works with it; with \
             `port.dialogue` it answers as a laser by Hokuyo",
        ),
        (v1::PortFormat::Scip2, None) => Some(
            "speaks SCIP 2.0, which only drivers of lasers by Hokuyo understand, and these only if the scenario has \
             `port.dialogue`",
        ),
        (v1::PortFormat::LineImage, None | Some(_)) => {
            Some("sends baudbot's own form of images; no driver of the real camera understands it")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNKNOWN: Known = Known { has_chip: false, answers: None };

    fn robot(protocol: Protocol) -> v1::RobotDescription {
        let port = |format: v1::PortFormat| {
            Some(v1::Port { format: format.into(), message_bytes: 1, baud: None, bits_per_character: None })
        };
        let sensor = |name: &str, port: Option<v1::Port>| v1::SensorDescription {
            sensor: name.to_owned(),
            port,
            ..v1::SensorDescription::default()
        };
        v1::RobotDescription {
            robot: "r".to_owned(),
            firmware: Some(v1::Firmware { protocol: Some(protocol), period_ns: None }),
            sensors: vec![
                sensor("laser", port(v1::PortFormat::Scip2)),
                sensor("camera", port(v1::PortFormat::LineImage)),
                sensor("gps", port(v1::PortFormat::Nmea)),
                sensor("ir", None),
            ],
            ..v1::RobotDescription::default()
        }
    }

    /// There is no note about protocols of real robots, nor about a program of the user's own.
    #[test]
    fn only_what_no_real_robot_speaks_is_told() {
        let framed = robot(Protocol::Framed(v1::firmware::Framed { ages: false }));
        let bare = robot(Protocol::Bare(v1::firmware::Bare { gap_ns: 1 }));
        let khepera = robot(Protocol::Khepera(v1::firmware::Khepera {}));
        let create = robot(Protocol::Create(v1::firmware::Create { version: 2 }));
        let e_puck = robot(Protocol::Asercom(v1::firmware::Asercom {}));
        assert!(
            note(&framed, None, UNKNOWN).unwrap().starts_with("r speaks baudbot's own frames; no driver")
        );
        assert!(note(&bare, None, UNKNOWN).unwrap().starts_with("r speaks bare bytes"));
        assert_eq!(note(&khepera, None, UNKNOWN), None);
        assert_eq!(note(&create, None, UNKNOWN), None);
        assert_eq!(note(&e_puck, None, UNKNOWN), None);
        assert_eq!(note(&framed, None, Known { has_chip: true, answers: None }), None);
    }

    /// A laser that answers is one that drivers of Hokuyo's understand.
    #[test]
    fn a_laser_is_told_of_unless_it_answers_as_the_real_one() {
        let robot = robot(Protocol::Khepera(v1::firmware::Khepera {}));
        let of = |device, answers| note(&robot, Some(device), Known { has_chip: false, answers });
        assert_eq!(of("laser", Some(true)), None);
        assert!(
            of("laser", Some(false)).unwrap().starts_with("r/laser sends scans by SCIP 2.0 and answers no")
        );
        assert!(of("laser", None).unwrap().contains("only if the scenario has `port.dialogue`"));
        assert!(of("camera", None).unwrap().contains("no driver of the real camera"));
        assert_eq!((of("gps", None), of("ir", None), of("none", None)), (None, None, None));
    }
}
