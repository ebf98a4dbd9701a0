//! The meaning of each number of an agent's readings and actions.

use std::ops::Range;

use baudbot_brain::Body;
use baudbot_sim::model::RobotSpec;
use baudbot_wire::Encoding;

/// The readings and the actions of a robot, as arrays.
///
/// Readings have one number for each value of each sensor, in the order of the wire: shape (values). Ages and whether readings are
/// new have one for each sensor: shape (sensors). An action has the signals of the left and the right wheel and those of the
/// other actuators: shape (actions), each in [-1, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The name of the robot.
    pub robot: String,
    /// The sensors, in order.
    pub sensors: Vec<Part>,
    /// The least and the greatest of each value that the wire can carry; infinite if there is no such limit.
    pub bounds: Vec<[f64; 2]>,
    /// The names of the values: `ir_front`, `odometer.x_m`, `laser.3`, as in tables of recordings.
    pub columns: Vec<String>,
    /// The names of the numbers of an action, such as `left`, `right`, `turret`.
    pub actions: Vec<String>,
}

/// A sensor of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of the part.
    pub name: String,
    /// The kind of the part, in the word of scenarios.
    pub kind: &'static str,
    /// The part's values among all.
    pub values: Range<usize>,
}

impl Layout {
    pub(crate) fn of(spec: &RobotSpec) -> Self {
        let body = Body::from(spec);
        let (mut sensors, mut bounds) = (Vec::new(), Vec::new());
        for sensor in &body.sensors {
            let start = bounds.len();
            for component in &sensor.components {
                bounds.extend((0..component.count).map(|_| limits(component.encoding)));
            }
            let (name, kind) = (sensor.name.clone(), sensor.kind.name());
            sensors.push(Part { name, kind, values: start..bounds.len() });
        }
        let wheels = ["left", "right"].map(str::to_owned).into_iter();
        let actions = wheels.chain(body.actuators.iter().map(|actuator| actuator.name.clone())).collect();
        let columns = baudbot_sim::sensor_columns(spec);
        Self { robot: spec.name.clone(), sensors, bounds, columns, actions }
    }

    /// Whether arrays for the one are arrays for the other.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let sensors =
            |layout: &Self| layout.sensors.iter().map(|part| part.values.clone()).collect::<Vec<_>>();
        sensors(self) == sensors(other) && self.actions.len() == other.actions.len()
    }
}

/// The limits of a value that crosses the wire so.
fn limits(encoding: Encoding) -> [f64; 2] {
    match encoding {
        Encoding::Float64 => [f64::NEG_INFINITY, f64::INFINITY],
        Encoding::Level { min, max, .. } => [min.min(max), min.max(max)],
        Encoding::Signed { limit, .. } => [-limit, limit],
        // A brain sees counts go on where the register wraps.
        Encoding::Counter { .. } => [f64::NEG_INFINITY, f64::INFINITY],
    }
}
