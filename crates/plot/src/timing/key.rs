//! The key of the colours.

use super::bars::sample;
use super::class::Class;
use super::wave::{self, Look};
use crate::palette::{LATE, PALE_INK};
use crate::svg::{Canvas, text};
use crate::text::width;

/// Writes the key from a corner on, in lines that fit into a width, and returns its height. All are pixels.
pub(super) fn draw(
    canvas: &mut Canvas,
    (classes, looks): (&[Class], &[Look]),
    is_late: bool,
    (left, top): (f64, f64),
    room: f64,
) -> f64 {
    let styles = classes.iter().map(|class| class.style());
    let bars = styles.map(|style| (Sample::Bar(style.color, style.is_mark), style.words));
    let late = is_late.then_some((Sample::Bar(LATE, false), "longer than Δt"));
    let waves = looks.iter().map(|look| (Sample::Wave(*look), look.words()));
    let (mut x, mut y) = (left, top);
    for (shown, words) in bars.chain(late).chain(waves) {
        let wide = 20.0 + width(words, SIZE) + 14.0;
        if x + wide > left + room && x > left {
            (x, y) = (left, y + LINE);
        }
        canvas.put(match shown {
            Sample::Bar(color, is_mark) => sample(x, y, color, is_mark),
            Sample::Wave(look) => wave::sample(x, y, look),
        });
        canvas.put(text((x + 20.0, y + 4.0), SIZE, PALE_INK, words));
        x += wide;
    }
    y + LINE - top
}

/// The sample before the words.
enum Sample {
    /// A colour, and whether it is that of a mark.
    Bar(&'static str, bool),
    Wave(Look),
}

const SIZE: f64 = 11.0;
/// Height of a line, in pixels.
const LINE: f64 = 19.0;
