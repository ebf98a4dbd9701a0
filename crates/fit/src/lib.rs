//! Fits numbers of a scenario to logs of real robots.
//!
//! 1. [`log`] reads a log: a table with units in the names of its columns.
//! 2. [`fields`] lists the fields of a robot that a log can tell, and [`choice`] finds those that are wanted.
//! 3. `models` say how likely a log is: [`echo`](crate::fit), radio, the curve of an IR sensor, the response to commands,
//!    odometry, a compass.
//! 4. [`search`] finds the most likely numbers, and their intervals by profiles of the likelihood.
//! 5. [`estimate`] is what comes out: numbers with intervals, or why the log cannot tell them.
//!
//! There is no clock, no file and no chance in here: the same log and robot give the same numbers.

pub mod choice;
pub mod estimate;
pub mod fields;
pub mod log;
mod models;
pub mod search;
mod statistics;

use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::model::RobotModel;
use baudbot_sim::sensor::{Device, Sensor};

use crate::estimate::{Fitted, Reason};
use crate::fields::{BodyField, Field, SensorField};
use crate::log::{Log, Quantity};
use crate::models::{Case, compass, curve, echo, radio, response, travel};

pub use models::Robot;

/// Fits fields of a robot to a log.
pub fn fit(robot: Robot<'_>, log: &Log, wanted: &[Field]) -> Fitted {
    let mut all = Fitted::default();
    let mut take = |fitted: Fitted| {
        all.findings.extend(fitted.findings);
        all.residuals.extend(fitted.residuals);
        all.remarks.extend(fitted.remarks);
    };
    for (part, fields) in parts(&robot, log, wanted) {
        let case = Case { robot, log, wanted: &fields };
        take(match part {
            Part::Link => link(&case),
            Part::Curve(_) => curve::fit(&case),
            Part::Compass(sensor) => compass::fit(&case, sensor),
            Part::Odometer(sensor) => travel::odometer(&case, sensor),
            Part::Losses(sensor) => travel::losses(&case, sensor),
            Part::Wheels => travel::wheels(&case),
            Part::Response => response::fit(&case),
        });
    }
    separate(&mut all, wanted, robot.model);
    all
}

/// The columns of sensors that the table of a run has of this robot, and fits may need.
pub fn readings(robot: &RobotModel) -> Vec<String> {
    let columns = robot.sensors.iter().flat_map(|sensor| {
        let parts: &[&str] = if matches!(sensor.device, Device::Compass(_)) {
            &[""]
        } else if matches!(sensor.device, Device::Odometer(_)) {
            &[".x_m", ".y_m", ".heading_rad"]
        } else if matches!(sensor.device, Device::Encoders(_)) {
            &[".left", ".right"]
        } else {
            &[]
        };
        parts.iter().map(|part| format!("{}{part}", sensor.name))
    });
    columns.collect()
}

/// The models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Link,
    /// The curve of this kind of sensor.
    Curve(usize),
    Compass(usize),
    Odometer(usize),
    Losses(usize),
    Wheels,
    Response,
}

/// Distributes the fields over the models.
fn parts(robot: &Robot<'_>, log: &Log, wanted: &[Field]) -> Vec<(Part, Vec<Field>)> {
    let mut parts: Vec<(Part, Vec<Field>)> = Vec::new();
    for &field in wanted {
        let part = part(robot, log, field);
        match parts.iter_mut().find(|(known, _)| *known == part) {
            Some((_, fields)) => fields.push(field),
            None => parts.push((part, vec![field])),
        }
    }
    parts
}

fn part(robot: &Robot<'_>, log: &Log, field: Field) -> Part {
    match field {
        Field::Adapter(_) => Part::Link,
        Field::Sensor(sensor, of) => part_of_sensor(robot.model, sensor, of),
        Field::Motors(_) => Part::Response,
        Field::Body(_) => {
            let case = Case { robot: *robot, log, wanted: &[] };
            let is_counted = models::motion::Wheels::of(&case).is_some();
            let has_poses = log.column(Quantity::X).is_some();
            let is_commanded =
                log.column(Quantity::CommandLeft).is_some() || log.column(Quantity::CommandSpeed).is_some();
            if (is_counted && has_poses) || !is_commanded { Part::Wheels } else { Part::Response }
        }
    }
}

fn part_of_sensor(robot: &RobotModel, sensor: usize, field: SensorField) -> Part {
    match field {
        SensorField::OdometerSigma => Part::Odometer(sensor),
        SensorField::Loss => Part::Losses(sensor),
        SensorField::HardIron
        | SensorField::HardIronPhase
        | SensorField::SoftIron
        | SensorField::SoftIronPhase => Part::Compass(sensor),
        SensorField::C1 | SensorField::C2 => part_of_curve(robot, sensor),
        SensorField::GainSpread
        | SensorField::OffsetSpread
        | SensorField::Multiplicative
        | SensorField::Additive
        | SensorField::Uniform => {
            let is_compass = matches!(robot.sensors[sensor].device, Device::Compass(_));
            if is_compass { Part::Compass(sensor) } else { part_of_curve(robot, sensor) }
        }
    }
}

/// Sensors of one kind are fitted together, as specimens of it.
fn part_of_curve(robot: &RobotModel, sensor: usize) -> Part {
    let is_same = |other: &Sensor| curve::same_kind(&robot.sensors[sensor], other);
    Part::Curve(robot.sensors.iter().position(is_same).unwrap_or(sensor))
}

fn link(case: &Case<'_>) -> Fitted {
    let uart = match &case.robot.model.link {
        Link::Uart(uart) => uart,
        Link::Ideal | Link::Onboard | Link::Usb(_) => {
            let reason = Reason::Columns { needs: "adapter: the scenario's link is no UART".into() };
            return Fitted::only(case.none(&reason));
        }
    };
    match &uart.adapter {
        Adapter::Bluetooth(radio) => radio::fit(case, uart, radio),
        Adapter::None | Adapter::Cdc(_) | Adapter::Ftdi(_) => echo::fit(case, uart),
    }
}

/// Lost marks and the radius of the wheels make up for each other: where both are wanted, neither is a result.
fn separate(all: &mut Fitted, wanted: &[Field], robot: &RobotModel) {
    let radius = Field::Body(BodyField::WheelRadius);
    let is_loss = |field: &&Field| matches!(field, Field::Sensor(_, of) if *of == travel::LOSS);
    let Some(loss) = wanted.iter().find(is_loss).filter(|_| wanted.contains(&radius)) else { return };
    let pair = [(*loss, radius), (radius, *loss)];
    for (field, other) in pair.map(|(field, other)| (field.path(robot), other.path(robot))) {
        if let Some(finding) = all.findings.iter_mut().find(|finding| finding.path == field) {
            let with = format!("`{other}`; choose one of them");
            finding.outcome = estimate::Outcome::CannotTell(Reason::Confounded { with });
        }
    }
}
