//! A chip, its clock and its program.

use alloc::format;
use alloc::string::{String, ToString};

use baudbot_avr::fuses::Taken;
use baudbot_avr::{Fuses, Part, Program};
use baudbot_board::{ChipClock, Net};
use baudbot_fields::Path;
use baudbot_fields::number::Number;
use baudbot_geometry::math;

use super::Result;
use crate::on_pin::RawProgram;
use crate::raw;

/// The part that the microcontroller is.
pub(super) fn part(path: &Path, raw: &raw::Microcontroller) -> Result<Part> {
    let Some(name) = &raw.chip else { return Ok(Part::Atmega328P) };
    Part::by_name(name).ok_or_else(|| {
        let known: alloc::vec::Vec<_> =
            Part::ALL.iter().map(|part| part.properties().name.to_ascii_lowercase()).collect();
        path.field("chip").error(format!("`{name}` is none of {}", known.join(", ")))
    })
}

/// The clock source of the chip.
pub(super) fn clock(path: &Path, raw: &raw::Microcontroller) -> Result<ChipClock> {
    let hz = raw.clock_hz.map_or(USUAL_HZ, Number::get);
    if math::floor(hz) != hz {
        return Err(path.field("clock_hz").error(format!("must be a whole number of hertz, is {hz}")));
    }
    let ppm = raw.clock_ppm.map_or(0.0, Number::get);
    let clock = ChipClock::exact(hz as u32).and_then(|clock| clock.with_ppb(math::round(ppm * 1e3) as i64));
    clock.map_err(|error| path.field("clock_ppm").error(error.to_string()))
}

/// The program.
pub(super) fn program(path: &Path, raw: &RawProgram, part: Part) -> Result<Program> {
    let at = path.field("program");
    let inline = match raw {
        RawProgram::Inline(inline) => inline,
        RawProgram::File(name) => {
            let problem = format!(
                "names the file `{name}`, which is read only from a scenario file; on the command line write \
                 --firmware ROBOT={name}"
            );
            return Err(at.error(problem));
        }
    };
    let wrong = |what: &str, problem: String| {
        let file = if inline.file.is_empty() { String::new() } else { format!("{}: ", inline.file) };
        at.error(format!("{file}{what}{problem}"))
    };
    if let Some(device) = inline.device.as_ref().filter(|device| !runs_on(device, part)) {
        let name = part.properties().name;
        let fix = format!(
            "it was built for an `{device}`, and the chip is an `{name}`: build it with -mmcu={name}, or set `chip`"
        );
        return Err(wrong("", fix));
    }
    let program = Program::from_hex(part, inline.hex.as_bytes());
    let program = program.map_err(|error| wrong("", error.to_string()))?;
    let eeprom = inline.eeprom_hex.as_ref();
    let program = program.with_extras(eeprom.map(|hex| hex.as_bytes()), inline.fuses, inline.data_end);
    program.map_err(|error| wrong("EEPROM: ", error.to_string()))
}

/// Whether a part can run what was built for another one: its vectors are as long, and it has no less memory.
fn runs_on(device: &str, part: Part) -> bool {
    let bytes = |part: Part| part.properties().flash_bytes;
    let digits: String = device.chars().filter(char::is_ascii_digit).collect();
    let number = |part: &Part| {
        part.properties().name.chars().filter(char::is_ascii_digit).collect::<String>() == digits
    };
    let Some(built_for) = Part::ALL.into_iter().find(number) else { return false };
    // An ATmega48 and an ATmega88 have vectors of one word.
    let is_small = |part: Part| bytes(part) <= 8 << 10;
    is_small(built_for) == is_small(part) && bytes(built_for) <= bytes(part)
}

/// The fuses, as the scenario or else the program's file has them.
pub(super) fn fuses(path: &Path, microcontroller: &raw::Microcontroller) -> Result<Option<Fuses>> {
    let Some(given) = &microcontroller.fuses else {
        let Some(RawProgram::Inline(inline)) = &microcontroller.program else { return Ok(None) };
        return Ok(inline.fuses.map(|[low, high, extended]| Fuses { low, high, extended }));
    };
    let at = path.field("fuses");
    let byte = |byte: u64| u8::try_from(byte).map_err(|_| at.error(format!("{byte} is not a byte")));
    let [low, high, extended] = given[..] else {
        return Err(at.error(format!("must be the bytes low, high and extended, has {}", given.len())));
    };
    Ok(Some(Fuses { low: byte(low)?, high: byte(high)?, extended: byte(extended)? }))
}

/// Whether nothing else has a pin for good. A board without named fuses has a crystal.
pub(super) fn check_pin(path: &Path, pin: &str, fuses: Option<Fuses>) -> Result<()> {
    let taken = Net::by_name(pin).and_then(Net::pin);
    let problem = match taken.and_then(|pin| fuses.unwrap_or(Fuses::ARDUINO_UNO).takes(pin)) {
        None => return Ok(()),
        Some(Taken::Clock) => {
            "is a pin of the clock source: on a board with a crystal use another pin; it is free if \
             microcontroller.fuses choose an internal oscillator"
        }
        Some(Taken::Reset) => {
            "is the reset pin: use another pin; it is free if microcontroller.fuses have RSTDISBL"
        }
    };
    Err(path.error(problem))
}

const USUAL_HZ: f64 = 16e6;
