//! The way from a port's table to the dialogue on it.

use alloc::boxed::Box;
use core::f64::consts::TAU;

use baudbot_fields::{FieldError, Path};
use baudbot_sim::link::Link;
use baudbot_sim::sensor::Device;
use baudbot_sim::sensor::dialogue::Dialogue;
use baudbot_sim::sensor::port::{Format, Port};
use baudbot_wire::scip::device::{Description, Model};

use super::raw;

/// The dialogue, if the table asks for one, of a device that measures once in so many nanoseconds.
pub(super) fn dialogue(
    path: &Path,
    raw: &raw::Port,
    device: &Device,
    (port, clock_ns): (&Port, u64),
) -> Result<Option<Box<Dialogue>>, FieldError> {
    let Some(begin) = raw.dialogue else {
        path.refuse("model", raw.model.is_some(), "a device without a `dialogue` does not report its model")?;
        return Ok(None);
    };
    let (Device::Laser(laser), Format::Scip(format)) = (device, &port.format) else { return Ok(None) };
    let clockwise = "a device that speaks SCIP counts its steps counter-clockwise";
    path.refuse("dialogue", laser.clockwise, clockwise)?;
    let is_shared = matches!(&port.link, Link::Uart(uart) if uart.turnaround_ns.is_some());
    path.refuse("dialogue", is_shared, "needs a cable that carries both directions at once")?;
    let gaps = laser.rays().saturating_sub(1) as f64;
    let steps = if gaps > 0.0 { TAU * gaps / laser.fan.opening_rad() } else { 360.0 };
    let description = Description {
        model: match raw.model.unwrap_or(raw::Model::Urg04lx) {
            raw::Model::Urg04lx => Model::Urg04lx,
            raw::Model::Ust10lx => Model::Ust10lx,
        },
        least_mm: (laser.min_m * 1e3 + 0.5) as u32,
        most_mm: (laser.range_m * 1e3 + 0.5) as u32,
        steps_per_turn: (steps + 0.5) as u16,
        first_step: format.first_step,
        last_step: format.last_step,
        front_step: (format.first_step + format.last_step) / 2,
        turns_per_minute: (60e9 / clock_ns.max(1) as f64 + 0.5) as u16,
    };
    Ok(Some(Box::new(Dialogue::new(description, begin, &port.link))))
}
