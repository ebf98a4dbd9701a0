//! Robots that speak the Open Interface of an iRobot Create: the devices that they may have, and their packets.

use alloc::format;

use baudbot_fields::{FieldError, Path};
use baudbot_wire::Encoding;
use baudbot_wire::create::{Signal, Version};

use baudbot_sim::battery::Battery;
use baudbot_sim::firmware::Protocol;
use baudbot_sim::sensor::{Device, Sensor};

type Result<T> = core::result::Result<T, FieldError>;

/// The protocol of a robot with these sensors and motors.
pub(super) fn protocol(
    path: &Path,
    version: Version,
    sensors: &[&Sensor],
    motors: &[Encoding],
) -> Result<Protocol> {
    let path = path.field("protocol");
    let others = motors.len().saturating_sub(2);
    if others > 0 {
        let problem = format!(
            "the Open Interface has no command for actuators besides the wheels, and there are {others}; take another \
             protocol, or leave them out"
        );
        return Err(path.error(problem));
    }
    for sensor in sensors {
        is_told(&path, version, sensor)?;
    }
    Ok(Protocol::Create(version))
}

/// Each sensor has its packets. The encoders of a first Create have none: its motors are regulated by them.
fn is_told(path: &Path, version: Version, sensor: &Sensor) -> Result<()> {
    if version == Version::One && matches!(sensor.device, Device::Encoders(_)) {
        return Ok(());
    }
    for (i, encoding) in sensor.encodings.iter().enumerate() {
        let Some(signal) = Signal::of(version, &sensor.name, i) else {
            let problem = format!(
                "the Open Interface of a Create {} has no packet for sensor `{}`; docs/reference/robots/create.md lists the names \
                 that it sends",
                version.number(),
                sensor.name
            );
            return Err(path.error(problem));
        };
        if bits(*encoding) != Some(signal.bits) {
            let problem = format!(
                "the Open Interface sends sensor `{}` in {} bits; give it `bits` = {1}",
                sensor.name, signal.bits
            );
            return Err(path.error(problem));
        }
    }
    Ok(())
}

fn bits(encoding: Encoding) -> Option<u8> {
    match encoding {
        Encoding::Float64 => None,
        Encoding::Level { bits, .. } | Encoding::Signed { bits, .. } | Encoding::Counter { bits } => {
            Some(bits)
        }
    }
}

/// A battery's voltage is sent in mV and its charge in mAh.
pub(super) fn tell_battery(sensors: &mut [Sensor], battery: Option<&Battery>) {
    let Some(battery) = battery else { return };
    for sensor in sensors.iter_mut().filter(|sensor| matches!(sensor.device, Device::Battery(_))) {
        if let [voltage @ Encoding::Level { bits: 16, .. }, charge @ Encoding::Level { bits: 16, .. }] =
            &mut sensor.encodings[..]
        {
            *voltage = Encoding::Level { bits: 16, min: 0.0, max: MOST_CODE / 1e3 };
            *charge = Encoding::Level {
                bits: 16,
                min: 0.0,
                max: MOST_CODE * COULOMBS_PER_MAH / battery.capacity_c(),
            };
        }
    }
}

const MOST_CODE: f64 = 65_535.0;

/// 1 mAh.
const COULOMBS_PER_MAH: f64 = 3.6;
