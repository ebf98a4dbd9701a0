//! Columns of a robot's sensor values, in tables and for observers.

use baudbot_sim::robot::RobotSpec;

/// One column a value: `ir_left` for a sensor of one, `odometer.x_m` for a component of several.
pub fn sensor_columns(spec: &RobotSpec) -> Vec<String> {
    let mut columns = Vec::new();
    for sensor in &spec.sensors {
        for component in sensor.device.components() {
            columns.push(match component.name {
                "" => sensor.name.clone(),
                component => format!("{}.{component}", sensor.name),
            });
        }
    }
    columns
}
