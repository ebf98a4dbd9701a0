//! The way from the raw microcontroller to the cost of its tasks, and when it begins.

use super::raw;
use baudbot_fields::number::Number;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::firmware::{Firmware, Mode};
use baudbot_sim::link::Link;
use baudbot_sim::processor::Processor;
use baudbot_sim::sensor::Sensor;

type Result<T> = core::result::Result<T, FieldError>;

/// The costs of the microcontroller's tasks.
pub(super) fn processor(raw: &raw::Microcontroller) -> Processor {
    Processor {
        framing_ns_per_byte: raw.framing_us_per_byte.get(),
        receiving_ns_per_byte: raw.receiving_us_per_byte.get(),
        obeying_ns: raw.obeying_us.get(),
        operations_per_s: raw.operations_per_s.map(Number::get),
        ram_bytes: raw.ram_bytes,
        bootloader_ns: raw.bootloader_s.get(),
    }
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
