//! The way from a sensor's table to a [`Sensor`].

mod dialogue;
mod place;
mod raw;
#[cfg(test)]
mod tests;

use alloc::format;
use alloc::string::String;

use baudbot_geometry::Pose;
use baudbot_wire::scip;
use toml::Table;

use super::error::Sheet;
use super::{context::Period, link};
use baudbot_fields::number::{Millis, Number, Rule};
use baudbot_fields::{Cause, FieldError, Fields, Path};
use baudbot_sim::actuator::Actuator;
use baudbot_sim::arena::Arena;
use baudbot_sim::battery::Battery;
use baudbot_sim::link::Link;
use baudbot_sim::schedule::Schedule;
use baudbot_sim::sensor::port::{Format, Port};
use baudbot_sim::sensor::{Built, Device, Fit, Mount, Noise, OwnClock, Place, Sensor, SensorKind};
use baudbot_sim::surroundings::Surroundings;
use raw::COMMON;
pub(super) use raw::Common;
#[cfg(feature = "schema")]
pub(super) use raw::{PLACE, Place as RawPlace};

type Result<T> = core::result::Result<T, FieldError>;

/// The parts of a robot that a sensor may depend on.
pub(super) struct Context<'a> {
    pub(super) step_ns: u64,
    /// Radius of the body, in metres.
    pub(super) radius_m: f64,
    /// Whether its brain is, so that there is no cable.
    pub(super) onboard: bool,
    pub(super) actuators: &'a [Actuator],
    pub(super) battery: Option<&'a Battery>,
    pub(super) surroundings: &'a Surroundings,
    /// Gets a layer for each height that something is seen from.
    pub(super) arena: &'a mut Arena,
}

/// The sensor of this name.
pub(super) fn sensor(
    path: &Path,
    name: String,
    mut table: Table,
    context: &mut Context<'_>,
) -> Result<Sensor> {
    let common: Common = Sheet::from(take(&mut table, &COMMON)).read(path)?;
    let built = built(path, &common, table, context).map_err(|error| with_common_fields(path, error))?;
    let mut port =
        common.port.as_ref().map(|raw| port(&path.field("port"), raw, &built.device)).transpose()?;
    if port.is_none() && !context.onboard && built.device.values() > usize::from(u8::MAX) {
        let problem = format!(
            "has {} values; without a `port` of its own a sensor has at most 255, unless its brain is on board",
            built.device.values()
        );
        return Err(path.error(problem));
    }
    if port.is_some() && common.bits.is_some() {
        return Err(path.field("bits").error("what goes over a port of its own has its own form"));
    }
    let noise = with_shorthands(path, common.noise, &built)?;
    let (phase_ns, acquisition_ns) = (common.phase_ms.get(), common.acquisition_us.get());
    let period_ns = common.period_ms.map_or(context.step_ns, Number::get);
    let clock = clock(path, common.clock, &built.device, (period_ns, phase_ns), port.is_some())?;
    if let Some((port, raw)) = port.as_mut().zip(common.port.as_ref()) {
        let clock_ns = clock.as_ref().map_or(0, |clock| clock.period_ns);
        port.dialogue = dialogue::dialogue(&path.field("port"), raw, &built.device, (port, clock_ns))?;
    }
    Ok(Sensor {
        name,
        device: built.device,
        noise,
        schedule: Schedule::new(period_ns, phase_ns),
        acquisition_ns,
        own_clock: clock,
        port,
        encodings: built.encodings,
    })
}

/// The device, from the fields of its place and its kind.
fn built(path: &Path, common: &Common, mut table: Table, context: &mut Context<'_>) -> Result<Built<Device>> {
    let mount = match common.kind.place() {
        Place::Inside => Mount {
            pose: Pose::default(),
            turret: None,
            height: context.arena.height(0.0),
            elevation_rad: None,
        },
        Place::Mounted => place::mount(path, &mut table, context)?,
        Place::Rim => place::centre(path, &mut table, context)?,
    };
    if mount.elevation_rad.is_some() && !common.kind.tilts() {
        let others = SensorKind::ALL.iter().filter(|kind| kind.tilts()).map(|kind| kind.name());
        let others = others.collect::<alloc::vec::Vec<_>>().join("`, `");
        let problem = format!("a sensor of kind `{}` has none; these have: `{others}`", common.kind.name());
        return Err(path.field("elevation_rad").error(problem));
    }
    let (battery, surroundings) = (context.battery, context.surroundings);
    let checked = |bits| path.whole_within("bits", bits, common.kind.least_bits(), 32);
    let bits = common.bits.map(checked).transpose()?.map(|bits| bits as u8);
    common.kind.build(Sheet::from(table), path, Fit { mount, bits, battery, surroundings })
}

/// The fields of the table of any sensor, behind those of its kind.
fn with_common_fields(path: &Path, mut error: FieldError) -> FieldError {
    if matches!(error.cause, Cause::UnknownField { .. }) && is_in(path, &error.path) {
        error.problem += &format!("; all sensors have `{}`", COMMON.join("`, `"));
    }
    error
}

/// Whether this is the path of a field of the table itself, and not of one deeper in it.
fn is_in(table: &Path, field: &str) -> bool {
    let name = field.strip_prefix(table.as_str()).and_then(|rest| rest.strip_prefix('.'));
    name.is_some_and(|name| !name.contains(['.', '[']))
}

/// The noise, with the fields of a kind that are short for it.
fn with_shorthands(path: &Path, mut noise: Noise, built: &Built<Device>) -> Result<Noise> {
    if built.multiplicative != 0.0 && noise.multiplicative != 0.0 {
        return Err(path.field("sigma").error("is short for noise.multiplicative, which is given, too"));
    }
    if built.additive != 0.0 && noise.additive != 0.0 {
        return Err(path.field("sigma_rad").error("is short for noise.additive, which is given, too"));
    }
    noise.multiplicative += built.multiplicative;
    noise.additive += built.additive;
    if !built.device.is_analog() && !noise.is_none() {
        let problem =
            format!("a sensor of kind `{}` is digital and takes none of these", built.device.kind());
        return Err(path.field("noise").error(problem));
    }
    Ok(noise)
}

/// Takes some fields out of a table.
pub(super) fn take(table: &mut Table, fields: &[&str]) -> Table {
    fields.iter().filter_map(|&field| table.remove_entry(field)).collect()
}

/// Lasers and devices with a port measure at their own pace, also if the scenario does not state so.
fn clock(
    path: &Path,
    raw: Option<raw::Clock>,
    device: &Device,
    (period_ns, phase_ns): (u64, u64),
    has_port: bool,
) -> Result<Option<OwnClock>> {
    let sweep_ns = if let Device::Laser(laser) = device { laser.sweep_ns } else { 0 };
    let Some(raw) = raw else {
        if !has_port && !matches!(device, Device::Laser(_)) {
            return Ok(None);
        }
        let phase_ns = Some(phase_ns);
        fits(path, sweep_ns, period_ns)?;
        return Ok(Some(OwnClock { period_ns, spread_ns: 0, jitter_ns: 0, phase_ns, latency_ns: 0 }));
    };
    if let Some(why) = device.no_clock() {
        return Err(path.field("clock").error(why));
    }
    let path = path.field("clock");
    let period_ms = raw.period_ms.get();
    let period_ns = Millis::<Period>::value(period_ms);
    let clock = OwnClock {
        period_ns,
        spread_ns: path.ms("spread_ms", raw.spread_ms.get(), 0.0, 0.9 * period_ms)?,
        jitter_ns: path.ms("jitter_ms", raw.jitter_ms.get(), 0.0, period_ms)?,
        phase_ns: raw.phase_ms.map(Number::get),
        latency_ns: raw.latency_ms.get(),
    };
    fits(&path, sweep_ns + clock.latency_ns + clock.jitter_ns, period_ns - clock.spread_ns)?;
    Ok(Some(clock))
}

/// A measurement must be over before the next one begins.
fn fits(path: &Path, takes_ns: u64, period_ns: u64) -> Result<()> {
    if takes_ns <= period_ns {
        return Ok(());
    }
    let (takes, period) = (takes_ns as f64 * 1e-6, period_ns as f64 * 1e-6);
    let problem = format!("a measurement takes up to {takes} ms, but the next may begin after {period} ms");
    Err(path.field("period_ms").error(problem))
}

fn port(path: &Path, raw: &raw::Port, device: &Device) -> Result<Port> {
    let problem = format!("a sensor of kind `{}` has none", device.kind());
    let (is_laser, is_gps) = (matches!(device, Device::Laser(_)), matches!(device, Device::Gps(_)));
    if !is_laser {
        path.refuse_all(&given!(raw; characters, first_step, dialogue, model), &problem)?;
    }
    path.refuse("sentences", raw.sentences.is_some() && !is_gps, &problem)?;
    let format = if let Device::Laser(laser) = device {
        scip_format(path, raw, laser.rays())?
    } else if let Device::LineCamera(_) | Device::Camera(_) = device {
        Format::LineImage
    } else if is_gps {
        let full = raw.sentences != Some(raw::Sentences::Rmc);
        let problem = "an RMC has no altitude; a receiver with `satellites` sends `all`";
        path.refuse("sentences", !full && matches!(device, Device::Gps(gps) if gps.satellites), problem)?;
        Format::Nmea { full }
    } else {
        let problem = format!(
            "a sensor of kind `{}` is read by the microcontroller; lasers, cameras and gps can have a \
             port of their own",
            device.kind()
        );
        return Err(path.error(problem));
    };
    let link = link::link(&path.field("link"), &raw.link)?;
    if matches!(link, Link::Onboard) {
        return Err(path.field("link").field("kind").error("a port is a cable: `uart`, `usb` or `ideal`"));
    }
    Ok(Port { link, format, dialogue: None })
}

fn scip_format(path: &Path, raw: &raw::Port, rays: usize) -> Result<Format> {
    let characters = match raw.characters.unwrap_or(3) {
        2 => scip::Characters::Two,
        3 => scip::Characters::Three,
        n => return Err(path.field("characters").error(format!("must be 2 or 3, is {n}"))),
    };
    let first = raw.first_step.map_or(0, Number::get);
    let last = path.whole_within("first_step", first + rays as u64 - 1, 0, 9999)?;
    Ok(Format::Scip(scip::Format {
        characters,
        first_step: first as u16,
        last_step: last as u16,
        cluster: 1,
    }))
}
