//! From the raw microcontroller to the cost of its tasks, and when it begins.

use super::raw;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::firmware::{Firmware, Mode};
use baudbot_sim::link::Link;
use baudbot_sim::processor::Processor;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::time::SECOND_NS;

type Result<T> = core::result::Result<T, FieldError>;

/// Longest wait of a bootloader, in seconds.
const MOST_BOOTLOADER_S: f64 = 60.0;

/// What its tasks cost.
pub(super) fn processor(path: &Path, raw: &raw::Microcontroller) -> Result<Processor> {
    Ok(Processor {
        framing_ns_per_byte: path.us("framing_us_per_byte", raw.framing_us_per_byte, 1e6)?,
        receiving_ns_per_byte: path.us("receiving_us_per_byte", raw.receiving_us_per_byte, 1e6)?,
        obeying_ns: path.us("obeying_us", raw.obeying_us, 1e6)?,
        operations_per_s: raw
            .operations_per_s
            .map(|n| path.within("operations_per_s", n, 1.0, 1e12))
            .transpose()?,
        ram_bytes: raw.ram_bytes,
        bootloader_ns: {
            let s = path.within("bootloader_s", raw.bootloader_s, 0.0, MOST_BOOTLOADER_S)?;
            (s * SECOND_NS as f64 + 0.5) as u64
        },
    })
}

/// Nothing is due before the bootloader starts the firmware, and then all is due as much later.
pub(super) fn start_later(
    path: &Path,
    (processor, link): (&Processor, &Link),
    firmware: &mut Firmware,
    sensors: &mut [Sensor],
) -> Result<()> {
    let ns = processor.bootloader_ns;
    if ns == 0 {
        return Ok(());
    }
    if matches!(link, Link::Onboard) {
        let problem = "is the wait of a chip that is reset when its serial port is opened, and on board nothing opens \
                       one; leave it out, or use the preset `atmega328p` in place of `arduino-uno`";
        return Err(path.field("microcontroller").field("bootloader_s").error(problem));
    }
    for sensor in sensors.iter_mut().filter(|sensor| sensor.is_on_wire()) {
        sensor.schedule = sensor.schedule.later_by(ns);
    }
    if let Mode::Stream(schedule) = &mut firmware.mode {
        *schedule = schedule.later_by(ns);
    }
    Ok(())
}
