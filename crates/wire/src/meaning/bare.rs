//! Bare messages: values and nothing else.

use super::framed::{Name, add_signals};
use super::text::Value;
use super::{Cut, Direction, Meaning};
use crate::layout::Layout;
use crate::values::Values;

/// A message has a fixed length; where it is none, a byte belongs to nothing.
pub(super) fn cut(layout: &Layout<'_>, direction: Direction, bytes: &[u8]) -> Cut {
    if bytes.len() >= len(layout, direction).max(1) { Cut::After } else { Cut::Wait }
}

fn len(layout: &Layout<'_>, direction: Direction) -> usize {
    match direction {
        Direction::Up => layout.bare_readings_len(),
        Direction::Down => layout.bare_command_len(),
    }
}

pub(super) fn read(layout: &Layout<'_>, names: &[&str], direction: Direction, bytes: &[u8]) -> Meaning {
    if bytes.len() != len(layout, direction) {
        return Meaning::not_understood(bytes, "");
    }
    match direction {
        Direction::Up => readings(layout, names, bytes),
        Direction::Down => {
            let mut meaning = Meaning::of("command");
            add_signals(&mut meaning, Values::new(layout.motors, bytes));
            meaning
        }
    }
}

fn readings(layout: &Layout<'_>, names: &[&str], bytes: &[u8]) -> Meaning {
    let mut meaning = Meaning::of("readings");
    let mut values = Values::new(layout.components, bytes);
    for (sensor, components) in layout.sensors().enumerate() {
        let mark = if sensor == 0 { ':' } else { ',' };
        meaning.add(format_args!("{mark} {}", Name(names, sensor)));
        values
            .by_ref()
            .take(components.len())
            .for_each(|value| meaning.add(format_args!(" {}", Value(value))));
    }
    meaning
}
