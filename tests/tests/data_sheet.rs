//! A brain's knowledge of its robot, for all scenarios of devices.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use baudbot_client::Body;
use baudbot_proto::v1::RobotDescription;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::SensorKind;

/// Calls this for each robot.
fn for_each_robot(mut check: impl FnMut(&RobotSpec)) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/scenarios/devices");
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let toml = fs::read_to_string(&path).unwrap();
            let scenario =
                baudbot_scenario::parse(&toml).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            scenario.robots.iter().for_each(&mut check);
        }
    }
}

#[test]
fn the_contract_says_all_of_a_body_and_nothing_else() {
    for_each_robot(|spec| {
        let body = Body::from(spec);
        let described = RobotDescription::from(&body);
        let again = Body::try_from(described.clone()).unwrap();
        assert_eq!(again, body);
        assert_eq!(RobotDescription::from(&again), described);
    });
}

#[test]
fn kinds_are_called_what_scenarios_call_them() {
    let (mut sensors, mut motors) = (BTreeSet::new(), BTreeSet::new());
    for_each_robot(|spec| {
        let body = Body::from(spec);
        assert_eq!(body.motor_kind.name(), spec.drive.motor.kind());
        motors.insert(spec.drive.motor.kind());
        for (actuator, spec) in body.actuators.iter().zip(&spec.actuators) {
            assert_eq!(actuator.kind.name(), spec.kind());
        }
        for (sensor, spec) in body.sensors.iter().zip(spec.sensors.iter()) {
            assert_eq!(sensor.kind.name(), spec.device.kind());
            sensors.insert(spec.device.kind());
        }
    });
    assert_eq!((sensors.len(), motors.len()), (SensorKind::ALL.len(), 4), "{sensors:?} {motors:?}");
}
