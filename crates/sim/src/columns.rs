//! Columns of the values that tables and frames have of a robot.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use crate::actuator::ActuatorKind;
use crate::model::RobotSpec;
use crate::view::RobotView;
use crate::wheels::Wheels;

/// The names of the sensors' values: `ir_left` for a sensor of one, `odometer.x_m` for a component of several,
/// `laser.0` and so on for a component of many values, `camera.red.0` for several of those.
pub fn sensor_columns(spec: &RobotSpec) -> Vec<String> {
    columns(spec, |name, _| name.to_owned())
}

/// The same as [`sensor_columns`], with the unit in each name that has one: `sonar.m`, `gyroscope.rad_s`, `laser.m.0`.
/// A sensor's name has no dot, so that none of them is called as a column of anything else.
pub fn sensor_columns_with_units(spec: &RobotSpec) -> Vec<String> {
    columns(spec, |name, unit| match unit {
        "" | "1" | "count" => name.to_owned(),
        unit => format!("{name}.{}", unit.to_lowercase().replace('/', "_").replace('^', "")),
    })
}

/// `name` makes the name of a sensor with a single component, from the sensor's name and the component's unit.
fn columns(spec: &RobotSpec, name: impl Fn(&str, &str) -> String) -> Vec<String> {
    let mut columns = Vec::new();
    for sensor in spec.sensors.iter() {
        for component in sensor.device.components() {
            let column = match component.name {
                "" => name(&sensor.name, component.unit),
                component => format!("{}.{component}", sensor.name),
            };
            match component.count {
                1 => columns.push(column),
                many => columns.extend((0..many).map(|i| format!("{column}.{i}"))),
            }
        }
    }
    columns
}

/// The names of the robot's own values besides its motion: `head.angle_rad` for a turret, two for a battery, and two for motors
/// with an inductance. Those of a battery differ from a gauge's components, whose sensor may be called `battery`, too.
pub fn state_columns(spec: &RobotSpec) -> Vec<String> {
    let turrets = spec.actuators.iter().filter(|actuator| matches!(actuator.kind, ActuatorKind::Turret(_)));
    let mut columns: Vec<_> = turrets.map(|turret| format!("{}.angle_rad", turret.name)).collect();
    if spec.battery.is_some() {
        columns.extend(["battery.share", "battery.terminal_v"].map(str::to_owned));
    }
    if spec.drive.motor.has_windings() {
        columns.extend(["motors.left_current_a", "motors.right_current_a"].map(str::to_owned));
    }
    columns
}

/// The values of [`state_columns`].
pub fn state_values(robot: &RobotView<'_>) -> Vec<f64> {
    let actuators = robot.spec().actuators.iter().zip(robot.actuators());
    let turrets = actuators.filter(|(actuator, _)| matches!(actuator.kind, ActuatorKind::Turret(_)));
    let mut values: Vec<_> = turrets.map(|(_, state)| state.angle_rad).collect();
    if let Some((battery, state)) = robot.battery() {
        values.extend([state.share(battery), state.terminal_v(battery)]);
    }
    if let Some(&Wheels { left, right }) = robot.currents_a() {
        values.extend([left, right]);
    }
    values
}
