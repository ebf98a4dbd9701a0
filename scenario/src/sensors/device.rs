//! From the fields of a kind to a [`Device`] and the form of its values on the wire.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use baudbot_geometry::Fan;
use baudbot_wire::Encoding;
use toml::{Table, Value};

use super::raw::{self, Kind};
use super::{Context, Path, Result, counter, deserialize, level, levels, place};
use crate::noise;
use baudbot_sim::sensor::{
    Accelerometer, BatteryGauge, Bumper, Compass, CrossTalk, Device, Encoders, FieldSensor, FloorSensor, Gps,
    Gyroscope, Infrared, InfraredModel, Laser, LightSensor, LineCamera, Microphone, Mount, Odometer,
    Photoresistor, Sonar, StepCounter, Switch, VoltageRanger, Whisker,
};
use baudbot_sim::time::SECOND_NS;

/// A device, how its values cross the wire, and noise that its own fields ask for.
pub(super) struct Built {
    pub(super) device: Device,
    pub(super) encodings: Vec<Encoding>,
    pub(super) multiplicative: f64,
    pub(super) additive: f64,
}

impl Built {
    fn new(device: Device, encodings: Vec<Encoding>) -> Self {
        Self { device, encodings, multiplicative: 0.0, additive: 0.0 }
    }
}

/// The device that a table describes.
pub(super) fn device(
    path: &Path,
    kind: Kind,
    table: Table,
    bits: Option<u64>,
    context: &mut Context<'_>,
) -> Result<Built> {
    match kind {
        Kind::Ir => infrared(path, table, bits, context),
        Kind::IrVoltage => voltage(path, table, bits, context),
        Kind::Sonar => sonar(path, table, bits, context),
        Kind::Laser => laser(path, table, bits, context),
        Kind::LineCamera => line_camera(path, table, bits, context),
        Kind::Encoders => encoders(path, table, bits),
        Kind::Steps => {
            let _: raw::Nothing = fields(path, table)?;
            Ok(Built::new(Device::StepCounter(StepCounter), vec![counter(path, bits)?; 2]))
        }
        Kind::Odometer => odometer(path, table, bits),
        Kind::Compass => compass(path, table, bits),
        Kind::Accelerometer => accelerometer(path, table, bits),
        Kind::Gyroscope => gyroscope(path, table, bits),
        Kind::Gps => gps(path, table, bits),
        Kind::Whisker => whisker(path, table, bits, context),
        Kind::Bumper => bumper(path, table, bits, context),
        Kind::Photoresistor => photoresistor(path, table, bits, context),
        Kind::Light => light(path, table, bits, context),
        Kind::Field => field(path, table, bits, context),
        Kind::Microphone => {
            let raw: raw::Microphone = fields(path, table)?;
            let encodings = levels(path, bits, 1, 0.0, maximum(path, raw.max, bits)?)?;
            Ok(Built::new(Device::Microphone(Microphone), encodings))
        }
        Kind::Floor => floor(path, table, bits, context),
        Kind::Battery => battery(path, table, bits, context),
    }
}

/// What is left of a sensor's table once the common fields are taken out.
fn fields<T: serde::de::DeserializeOwned>(path: &Path, table: Table) -> Result<T> {
    deserialize(path.as_str(), Value::Table(table))
}

fn mounted<T: serde::de::DeserializeOwned>(
    path: &Path,
    mut table: Table,
    context: &mut Context<'_>,
) -> Result<(Mount, T)> {
    let mount = place::mount(path, &mut table, context)?;
    Ok((mount, fields(path, table)?))
}

fn fan(path: &Path, opening_rad: f64, max_rad: f64, rays: u64) -> Result<Fan> {
    let opening_rad = path.within("opening_rad", opening_rad, 0.0, max_rad)?;
    Ok(Fan::new(opening_rad, path.whole_within("rays", rays, 1, 10_000)? as usize))
}

fn infrared(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Infrared) = mounted(path, table, context)?;
    let multiplicative = path.sigma("sigma", raw.sigma)?;
    let fan = fan(path, raw.opening_rad, PI, raw.rays)?;
    let range_m = path.length("range_m", raw.range_m)?;
    let model = infrared_model(path, raw)?;
    let device = Device::Infrared(Infrared { mount, fan, range_m, model });
    Ok(Built { multiplicative, ..Built::new(device, levels(path, bits, 1, 0.0, 1.0)?) })
}

fn infrared_model(path: &Path, raw: raw::Infrared) -> Result<InfraredModel> {
    match (raw.c1_m2, raw.c2, raw.lookup, raw.ambient_saturation_lux) {
        (Some(c1), Some(c2), None, None) => Ok(InfraredModel::Phenomenological {
            c1_m2: path.not_negative("c1_m2", c1)?,
            c2: path.not_negative("c2", c2)?,
        }),
        (None, None, Some(raw), None) => {
            Ok(InfraredModel::Lookup(noise::lookup(&path.field("lookup"), raw)?))
        }
        (None, None, None, Some(lux)) => {
            let saturation_lux = path.positive("ambient_saturation_lux", lux)?;
            Ok(InfraredModel::Ambient { saturation_lux, opening_rad: raw.opening_rad })
        }
        (Some(_), None, None, None) => Err(path.field("c2").error("goes with c1_m2 and is missing")),
        (None, Some(_), None, None) => Err(path.field("c1_m2").error("goes with c2 and is missing")),
        _ => Err(path.error("needs exactly one of: `c1_m2` with `c2`, `lookup`, `ambient_saturation_lux`")),
    }
}

fn voltage(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::VoltageRanger) = mounted(path, table, context)?;
    let at = path.field("curve_m_v");
    if raw.curve_m_v.len() < 2 {
        return Err(
            at.error(format!("needs at least 2 pairs of distance and voltage, has {}", raw.curve_m_v.len()))
        );
    }
    for (i, pair) in raw.curve_m_v.iter().enumerate() {
        at.index(i).not_negative("distance", pair[0])?;
        at.index(i).not_negative("voltage", pair[1])?;
        if i > 0 && pair[0] <= raw.curve_m_v[i - 1][0] {
            let problem = format!("distances must increase, {} follows {}", pair[0], raw.curve_m_v[i - 1][0]);
            return Err(at.index(i).error(problem));
        }
    }
    let supply_v = path.positive("supply_v", raw.supply_v)?;
    let device = Device::VoltageRanger(VoltageRanger {
        mount,
        fan: fan(path, raw.opening_rad, PI, raw.rays)?,
        range_m: path.length("range_m", raw.range_m)?,
        curve: raw.curve_m_v.into_iter().map(|[d, v]| (d, v)).collect(),
        idle_v: path.within("idle_v", raw.idle_v, 0.0, supply_v)?,
        supply_v,
    });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, supply_v)?))
}

fn sonar(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Sonar) = mounted(path, table, context)?;
    let max_m = path.length("max_m", raw.max_m)?;
    let sound_m_s = path.within("sound_m_s", raw.sound_m_s, 1.0, 1e5)?;
    let echo_ms = 2.0 * max_m / sound_m_s * 1e3;
    let device = Device::Sonar(Sonar {
        mount,
        fan: fan(path, raw.opening_rad, PI, raw.rays)?,
        min_m: path.within("min_m", raw.min_m, 0.0, max_m)?,
        max_m,
        detection: path.within("detection", raw.detection, 0.0, 1.0)?,
        sound_m_s,
        holdoff_ns: path.us("holdoff_us", raw.holdoff_us, 1e6)?,
        timeout_ns: path.ms("timeout_ms", raw.timeout_ms.unwrap_or(echo_ms), 0.001, 1e6)?,
        cross_talk: if raw.cross_talk { CrossTalk::On } else { CrossTalk::Off },
    });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, max_m)?))
}

fn laser(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Laser) = mounted(path, table, context)?;
    let range_m = path.length("range_m", raw.range_m)?;
    let device = Device::Laser(Laser {
        mount,
        fan: fan(path, raw.opening_rad, TAU, raw.rays)?,
        min_m: path.within("min_m", raw.min_m, 0.0, range_m)?,
        range_m,
        sweep_ns: path.ms("sweep_ms", raw.sweep_ms, 0.0, 1e6)?,
        clockwise: raw.clockwise,
    });
    let encodings = levels(path, bits, device.values(), -1.0, range_m)?;
    Ok(Built::new(device, encodings))
}

fn line_camera(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::LineCamera) = mounted(path, table, context)?;
    let columns = path.whole_within("columns", raw.columns, 1, 4096)? as usize;
    let opening_rad = path.within("opening_rad", raw.opening_rad, 0.0, TAU)?;
    let range_m = path.within("range_m", raw.range_m, 1e-6, 65.0)?;
    let rows = path.whole_within("rows", raw.rows, 1, 4096)? as u16;
    if columns * usize::from(rows) > MAX_PIXELS {
        let problem = format!("{columns} columns and {rows} rows are more than {MAX_PIXELS} pixels");
        return Err(path.field("rows").error(problem));
    }
    let camera =
        LineCamera { mount, fan: Fan::new(opening_rad, columns), range_m, background: raw.background, rows };
    let mut encodings = levels(path, bits, 3 * columns, 0.0, 1.0)?;
    encodings.extend(levels(path, bits, columns, -1.0, range_m)?);
    Ok(Built::new(Device::LineCamera(camera), encodings))
}

/// Most pixels of an image.
const MAX_PIXELS: usize = 1 << 20;

fn encoders(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Encoders = fields(path, table)?;
    let device = Device::Encoders(Encoders {
        counts_per_turn: path.whole_within("counts_per_turn", raw.counts_per_turn, 1, 1_000_000)? as u32,
        quadrature: raw.quadrature,
        loss: path.within("loss", raw.loss, 0.0, 1.0)?,
    });
    Ok(Built::new(device, vec![counter(path, bits)?; 2]))
}

fn odometer(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Odometer = fields(path, table)?;
    let sigma_m = path.sigma("sigma_m", raw.sigma_m)?;
    let range = path.length("position_range_m", raw.position_range_m)?;
    let position = level(path, bits, -range, range)?;
    let encodings = vec![position, position, level(path, bits, -PI, PI)?];
    Ok(Built::new(Device::Odometer(Odometer { sigma_m }), encodings))
}

fn compass(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Compass = fields(path, table)?;
    let additive = path.sigma("sigma_rad", raw.sigma_rad)?;
    let angle = |field, value| path.within(field, value, -TAU, TAU);
    let device = Device::Compass(Compass {
        hard_iron_rad: (
            angle("hard_iron_rad", raw.hard_iron_rad)?,
            angle("hard_iron_phase_rad", raw.hard_iron_phase_rad)?,
        ),
        soft_iron_rad: (
            angle("soft_iron_rad", raw.soft_iron_rad)?,
            angle("soft_iron_phase_rad", raw.soft_iron_phase_rad)?,
        ),
    });
    Ok(Built { additive, ..Built::new(device, levels(path, bits, 1, -PI, PI)?) })
}

fn accelerometer(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Accelerometer = fields(path, table)?;
    let range_m_s2 = path.positive("range_m_s2", raw.range_m_s2)?;
    let bandwidth_hz = raw.bandwidth_hz.map(|hz| path.positive("bandwidth_hz", hz)).transpose()?;
    let device = Device::Accelerometer(Accelerometer { range_m_s2, bandwidth_hz });
    Ok(Built::new(device, levels(path, bits, 2, -range_m_s2, range_m_s2)?))
}

fn gyroscope(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Gyroscope = fields(path, table)?;
    let range_rad_s = path.positive("range_rad_s", raw.range_rad_s)?;
    let bandwidth_hz = raw.bandwidth_hz.map(|hz| path.positive("bandwidth_hz", hz)).transpose()?;
    let device = Device::Gyroscope(Gyroscope { range_rad_s, bandwidth_hz });
    Ok(Built::new(device, levels(path, bits, 1, -range_rad_s, range_rad_s)?))
}

fn gps(path: &Path, table: Table, bits: Option<u64>) -> Result<Built> {
    let raw: raw::Gps = fields(path, table)?;
    let reacquire_s = path.within("reacquire_s", raw.reacquire_s, 0.0, 1e6)?;
    let device = Device::Gps(Gps {
        wander_sigma_m: path.sigma("wander_sigma_m", raw.wander_sigma_m)?,
        wander_time_s: path.positive("wander_time_s", raw.wander_time_s)?,
        sigma_m: path.sigma("sigma_m", raw.sigma_m)?,
        speed_sigma_m_s: path.sigma("speed_sigma_m_s", raw.speed_sigma_m_s)?,
        reacquire_ns: (reacquire_s * SECOND_NS as f64) as u64,
    });
    let ranges = [(-90.0, 90.0), (-180.0, 180.0), (0.0, 1.0), (0.0, 100.0), (-PI, PI)];
    let encodings = ranges.map(|(min, max)| level(path, bits, min, max));
    Ok(Built::new(device, encodings.into_iter().collect::<Result<_>>()?))
}

fn switch(path: &Path, active_low: bool, bounce_ms: f64) -> Result<Switch> {
    Ok(Switch { active_low, bounce_ns: path.ms("bounce_ms", bounce_ms, 0.0, 1e4)? })
}

fn whisker(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Whisker) = mounted(path, table, context)?;
    let length_m = path.length("length_m", raw.length_m)?;
    let device =
        Device::Whisker(Whisker { mount, length_m, switch: switch(path, raw.active_low, raw.bounce_ms)? });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, 1.0)?))
}

fn bumper(path: &Path, mut table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let mount = place::centre(path, &mut table, context)?;
    let raw: raw::Bumper = fields(path, table)?;
    let device = Device::Bumper(Bumper {
        mount,
        fan: fan(path, raw.opening_rad, TAU, raw.rays)?,
        travel_m: path.length("travel_m", raw.travel_m)?,
        switch: switch(path, raw.active_low, raw.bounce_ms)?,
    });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, 1.0)?))
}

fn photoresistor(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Photoresistor) = mounted(path, table, context)?;
    let light = LightSensor {
        mount,
        opening_rad: path.within("opening_rad", raw.opening_rad, 0.0, TAU)?,
        range_lux: f64::INFINITY,
        lag_s: path.within("lag_s", raw.lag_s, 0.0, 1e3)?,
    };
    let max_counts = path.whole_within("max_counts", raw.max_counts, 1, u64::from(u32::MAX))? as u32;
    let unit_ns = path.us("unit_us", raw.unit_us, 1e6)?;
    if unit_ns == 0 {
        return Err(path.field("unit_us").error("must be at least a nanosecond"));
    }
    let device = Device::Photoresistor(Photoresistor {
        light,
        resistance_10lux_ohm: path.positive("resistance_10lux_ohm", raw.resistance_10lux_ohm)?,
        gamma: path.positive("gamma", raw.gamma)?,
        capacitance_f: path.positive("capacitance_uf", raw.capacitance_uf)? * 1e-6,
        unit_ns,
        max_counts,
    });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, f64::from(max_counts))?))
}

fn light(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Light) = mounted(path, table, context)?;
    let range_lux = path.positive("range_lux", raw.range_lux)?;
    let device = Device::Light(LightSensor {
        mount,
        opening_rad: path.within("opening_rad", raw.opening_rad, 0.0, TAU)?,
        range_lux,
        lag_s: path.within("lag_s", raw.lag_s, 0.0, 1e3)?,
    });
    Ok(Built::new(device, levels(path, bits, 1, 0.0, range_lux)?))
}

fn field(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, raw): (_, raw::Field) = mounted(path, table, context)?;
    let fields = &context.surroundings.fields;
    let field = fields.iter().position(|field| field.name == raw.field).ok_or_else(|| {
        let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
        let problem = match names.join(", ") {
            none if none.is_empty() => format!("the arena has no field `{}`, it has none at all", raw.field),
            names => format!("the arena has no field `{}`; there are: {names}", raw.field),
        };
        path.field("field").error(problem)
    })?;
    let encodings = levels(path, bits, 1, 0.0, maximum(path, raw.max, bits)?)?;
    Ok(Built::new(Device::Field(FieldSensor { mount, field }), encodings))
}

/// The largest value that a sensor of so many bits can tell, where nothing else says it.
fn maximum(path: &Path, max: Option<f64>, bits: Option<u64>) -> Result<f64> {
    match (max, bits) {
        (Some(max), _) => path.positive("max", max),
        (None, None) => Ok(f64::MAX),
        (None, Some(_)) => {
            Err(path.field("max").error("is needed with `bits`: the value of the largest code"))
        }
    }
}

fn floor(path: &Path, table: Table, bits: Option<u64>, context: &mut Context<'_>) -> Result<Built> {
    let (mount, _): (_, raw::Nothing) = mounted(path, table, context)?;
    Ok(Built::new(Device::Floor(FloorSensor { mount }), levels(path, bits, 1, 0.0, 1.0)?))
}

fn battery(path: &Path, table: Table, bits: Option<u64>, context: &Context<'_>) -> Result<Built> {
    let _: raw::Nothing = fields(path, table)?;
    let battery = context.battery.ok_or_else(|| path.error("the robot has no `battery` to gauge"))?;
    let encodings = vec![level(path, bits, 0.0, 2.0 * battery.nominal_v)?, level(path, bits, 0.0, 1.0)?];
    Ok(Built::new(Device::Battery(BatteryGauge), encodings))
}
