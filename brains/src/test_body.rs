//! Bodies and turns made up for tests.

use std::f64::consts::PI;
use std::sync::Arc;

use baudbot_brain::{
    Body, Component, Encoding, Firmware, MotorKind, Mount, Protocol, Reading, Sensor, SensorKind, Sweep, Turn,
};

/// A body with sensors of these names, kinds and headings.
pub(crate) fn body(sensors: &[(&str, &str, f64)]) -> Body {
    let component =
        |count| Component { name: String::new(), unit: "1".to_owned(), encoding: Encoding::Float64, count };
    let sensor = |&(name, kind, heading_rad): &(&str, &str, f64)| Sensor {
        name: name.to_owned(),
        kind: kind_named(kind),
        components: match kind {
            "odometer" => vec![component(1); 3],
            "laser" => vec![component(3)],
            _ => vec![component(1)],
        },
        period_ns: 20_000_000,
        phase_ns: 0,
        mount: Some(Mount { heading_rad, ..Mount::default() }),
        range_m: Some(1.0),
        counts_per_turn: None,
        counts_per_m: None,
        port: None,
        opening_rad: (kind == "laser").then_some(4.0 * PI / 3.0),
        columns: None,
        sweep: (kind == "laser").then_some(Sweep { duration_ns: 66_500_000, clockwise: false }),
    };
    Body {
        name: "alice".to_owned(),
        radius_m: 0.2,
        half_track_m: 0.2,
        wheel_radius_m: 0.1,
        signal_limit: Some(1.0),
        motor_encoding: Encoding::Signed { bits: 8, limit: 1.0 },
        sensors: sensors.iter().map(sensor).collect(),
        firmware: Firmware { protocol: Protocol::Framed { ages: true }, period_ns: Some(20_000_000) },
        baud: Some(9600),
        bits_per_character: Some(10),
        motor_kind: MotorKind::Dc,
        actuators: Vec::new(),
        onboard: false,
        operations_per_s: None,
        ram_bytes: None,
    }
}

fn kind_named(name: &str) -> SensorKind {
    SensorKind::ALL.iter().find(|kind| kind.name() == name).copied().unwrap_or(SensorKind::Unknown)
}

/// A turn at this instant, with new readings of these values, sensor by sensor.
pub(crate) fn turn(body: &Body, at_ns: u64, values: &[Option<&[f64]>]) -> Turn {
    let reading = |values: &[f64]| Reading {
        values: values.to_vec(),
        sampled_at_ns: Some(at_ns),
        sequence: 0,
        readable: true,
    };
    Turn {
        tick: at_ns / 10_000_000,
        at_ns,
        readings: values.iter().map(|values| values.map(reading)).collect(),
        body: Arc::new(body.clone()),
        // Tests give readings and no messages.
        has_message: false,
    }
}
