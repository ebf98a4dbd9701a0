//! The dialogue of brains of messages: speeds, and lines that ask for steps and proximity.

use super::answer::{COUNTERS, INFRARED};
use super::{FULL_STEPS_S, SENSORS};
use crate::codec::{Notice, Sink, Terms};
use crate::encoding::Encoding;
use crate::error::{LayoutError, WriteError};
use crate::khepera::{self, longest};
use crate::layout::Layout;
use crate::lines::{Writer, field, number};

/// The encoding of a signal: its code is a speed in steps a second.
pub const SPEED: Encoding = Encoding::Signed { bits: 11, limit: 1023.0 / FULL_STEPS_S };

/// The place of this component of the sensor of this name: 0 to 7 in the answer to `N`, 8 and 9 in that to `Q`.
pub fn place(sensor: &str, component: usize) -> Option<u8> {
    let infrared = || INFRARED.iter().position(|name| *name == sensor).filter(|_| component == 0);
    let counter = || (COUNTERS.contains(&sensor) && component < 2).then_some(SENSORS + component);
    infrared().or_else(counter).map(|place| place as u8)
}

/// The encodings that have a place, with it.
fn placed(terms: &Terms<'_>) -> impl Iterator<Item = (Encoding, usize)> {
    let components = terms.layout.components.iter().zip(terms.places);
    components.filter_map(|(encoding, place)| Some((*encoding, usize::from((*place)?))))
}

fn has_steps(terms: &Terms<'_>) -> bool {
    placed(terms).any(|(_, place)| place >= SENSORS)
}

/// Whether a robot can be driven by this layout. Owners check once, when they are configured.
///
/// # Errors
/// Names the first thing that is wrong.
pub(crate) fn check(terms: &Terms<'_>) -> Result<(), LayoutError> {
    if terms.layout.motors.len() != 2 {
        return Err(LayoutError::Motors { found: terms.layout.motors.len() });
    }
    let mut all = placed(terms).map(|(encoding, _)| encoding).chain(terms.layout.motors.iter().copied());
    if all.any(|encoding| encoding.numbers().is_none()) { Err(LayoutError::NoCode) } else { Ok(()) }
}

/// Asks for all readings of the layout: for steps first, if there are any, so that the answer to `N` is the last.
pub(crate) fn question(terms: &Terms<'_>) -> &'static [u8] {
    if has_steps(terms) { b"Q\rN\r" } else { b"N\r" }
}

/// Bytes of the shortest and of the longest answer to `N`, which has a 0 for a sensor that is missing.
pub(crate) fn readings_len(terms: &Terms<'_>) -> [usize; 2] {
    let infrared = placed(terms).filter(|(_, place)| *place < SENSORS);
    let more = infrared.map(|(encoding, _)| longest(encoding).saturating_sub(SHORTEST)).sum::<usize>();
    let least = REST + SENSORS * SHORTEST;
    [least, least + more]
}

/// Bytes of the shortest and of the longest answer to `Q`; 0 of robots without steps.
pub(crate) fn positions_len(terms: &Terms<'_>) -> [usize; 2] {
    let counter = Encoding::Counter { bits: 16 };
    if has_steps(terms) { [REST + 2 * SHORTEST, REST + 2 * longest(counter)] } else { [0; 2] }
}

/// Bytes of the shortest and of the longest command.
pub(crate) fn command_len(layout: &Layout<'_>) -> [usize; 2] {
    [2 + layout.motors.len() * SHORTEST, khepera::command_len_max(layout)]
}

/// Writes what a program says that drives and wants readings, and returns its length. The robot's command is a Khepera's.
///
/// # Errors
/// If there are not as many signals as motors, or `out` is too short.
pub(crate) fn write_exchange(
    terms: &Terms<'_>,
    signals: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let len = khepera::write_command(&terms.layout, signals, out)?;
    Writer { out, len }.end(question(terms))
}

/// Reads an answer, and gives its readings to `sink`.
pub(crate) fn read(terms: &Terms<'_>, line: &[u8], sink: &mut impl Sink) -> Notice {
    match line {
        [b'n', rest @ ..] => numbers::<SENSORS>(rest).map_or(Notice::Nonsense, |codes| {
            give(terms, 0, &codes, sink);
            Notice::Readings
        }),
        [b'q', rest @ ..] => {
            numbers(rest).map_or(Notice::Nonsense, |steps| Notice::Positions(steps.map(i32::from)))
        }
        b"d" => Notice::Acknowledgement,
        _ if line.iter().all(|byte| matches!(byte, b' '..=b'~' | 7 | 12)) => Notice::Answer,
        _ => Notice::Nonsense,
    }
}

/// Gives the steps that came before readings to `sink`.
pub(crate) fn read_positions(terms: &Terms<'_>, steps: [i32; 2], sink: &mut impl Sink) {
    give(terms, SENSORS, &steps.map(|steps| steps as i16), sink);
}

/// Gives the readings of sensors that are all in these places, from `first` on, to `sink`.
fn give(terms: &Terms<'_>, first: usize, codes: &[i16], sink: &mut impl Sink) {
    let mut rest = terms.places;
    for (sensor, components) in terms.layout.sensors().enumerate() {
        let (places, behind) = rest.split_at(components.len().min(rest.len()));
        rest = behind;
        let values = || {
            components.iter().zip(places).map(|(encoding, place)| {
                let code = *codes.get(usize::from((*place)?).checked_sub(first)?)?;
                match encoding {
                    Encoding::Counter { .. } => Some(encoding.quantise(code.into())),
                    Encoding::Level { .. } | Encoding::Signed { .. } | Encoding::Float64 => {
                        encoding.value_of(code.into())
                    }
                }
            })
        };
        if !components.is_empty() && values().count() > 0 && values().all(|value| value.is_some()) {
            sink.take(sensor, None, values().flatten());
        }
    }
}

/// So many numbers of 16 bits, with a comma before each.
fn numbers<const N: usize>(text: &[u8]) -> Option<[i16; N]> {
    let (mut rest, mut numbers) = (text, [0; N]);
    for to in &mut numbers {
        let (digits, behind) = field(rest)?;
        *to = i16::try_from(number(digits)?).ok()?;
        rest = behind;
    }
    rest.is_empty().then_some(numbers)
}

/// The letter of an answer and its end.
const REST: usize = 3;

/// The characters of the shortest number, and of the comma before it.
const SHORTEST: usize = 2;
