//! The key of the colours.

use super::bars::sample;
use super::class::Class;
use crate::palette::{LATE, PALE_INK};
use crate::svg::{Canvas, text};
use crate::text::width;

/// Writes the key from a corner on, in lines that fit into a width, and returns its height. All are pixels.
pub(super) fn draw(
    canvas: &mut Canvas,
    classes: &[Class],
    is_late: bool,
    (left, top): (f64, f64),
    room: f64,
) -> f64 {
    let (mut x, mut y) = (left, top);
    let entries = classes.iter().map(|class| (class.color(), class.words(), is_mark(*class)));
    let late = is_late.then_some((LATE, "longer than Δt", false));
    for (color, words, is_mark) in entries.chain(late) {
        let wide = 20.0 + width(words, SIZE) + 14.0;
        if x + wide > left + room && x > left {
            (x, y) = (left, y + LINE);
        }
        canvas.put(sample(x, y, color, is_mark));
        canvas.put(text((x + 20.0, y + 4.0), SIZE, PALE_INK, words));
        x += wide;
    }
    y + LINE - top
}

/// Whether bars of a class have no duration.
fn is_mark(class: Class) -> bool {
    match class {
        Class::Act | Class::Late | Class::Missed | Class::Lost => true,
        Class::Acquire
        | Class::Measure
        | Class::Frame
        | Class::Block
        | Class::Up
        | Class::Adapter
        | Class::Port
        | Class::Think
        | Class::Down
        | Class::PortDown
        | Class::Obey
        | Class::Fault => false,
    }
}

const SIZE: f64 = 11.0;
/// Height of a line, in pixels.
const LINE: f64 = 19.0;
