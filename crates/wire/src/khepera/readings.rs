//! The way from answers to readings.

use super::{Answer, counted};
use crate::codec::{Notice, Sink, take_all};
use crate::encoding::Encoding;
use crate::layout::Layout;

/// Reads an answer, and gives its readings to `sink`: those of all components that are no counters.
pub(crate) fn read(layout: &Layout<'_>, line: &[u8], sink: &mut impl Sink) -> Notice {
    match Answer::parse(line, layout) {
        Ok(Answer::Readings(values)) => {
            let sensors = layout.sensors().enumerate();
            let is_told = |own: &[Encoding]| !own.is_empty() && counted(own, [0; 2]).is_none();
            take_all(sensors.filter(|(_, own)| is_told(own)), values, sink)
        }
        Ok(Answer::Positions(positions)) => Notice::Positions(positions),
        Ok(Answer::Acknowledgement) => Notice::Acknowledgement,
        Ok(Answer::Registers(_) | Answer::Refusal) => Notice::Answer,
        Err(_) => Notice::Nonsense,
    }
}

/// Gives the positions that came before readings to `sink`.
pub(crate) fn read_positions(layout: &Layout<'_>, positions: [i32; 2], sink: &mut impl Sink) {
    for (sensor, components) in layout.sensors().enumerate() {
        if let Some(values) = counted(components, positions) {
            sink.take(sensor, None, values.into_iter());
        }
    }
}
