//! The bars of a row.

use super::axis::Axis;
use super::diagram::{Bar, ROW, rectangle};
use crate::palette::{FRAME, LATE, PALE_INK, WHITE};
use crate::svg::{Canvas, Element, px, text};
use crate::text::width;

/// Draws a row of bars, whose middle is at a height, in pixels. Bars are red after `late_from_ns`.
pub(super) fn draw(canvas: &mut Canvas, axis: &Axis, row: &[&Bar], middle: f64, late_from_ns: Option<u64>) {
    let mut last: Option<Span> = None;
    for (i, bar) in row.iter().enumerate() {
        let span = Span::of(bar, axis);
        // Of what is in one pixel, and alike, one is enough: a long window has any number of bars.
        if last.is_some_and(|last| span.right - last.right < LEAST && span.left - last.left < LEAST)
            && row[i - 1].class == bar.class
        {
            continue;
        }
        last = Some(span);
        canvas.open(Element::group().titled(&bar.title));
        let late_from = late_from_ns.filter(|from| bar.can_be_late() && *from < bar.end_ns.max(bar.start_ns));
        let late_from = late_from.map(|from| axis.x(from).clamp(span.left, span.right));
        if bar.is_mark() {
            let color = if late_from.is_some() { LATE } else { bar.class.style().color };
            canvas.put(aside(diamond(span.left, middle, color), bar));
        } else {
            span.draw(canvas, bar, middle, late_from);
        }
        let free_until = row.get(i + 1).map_or_else(|| axis.right(), |next| Span::of(next, axis).reach().0);
        label(canvas, axis, bar, span, (middle, free_until), late_from);
        canvas.close("g");
    }
}

/// The part of the picture's width that a bar takes, in pixels.
#[derive(Clone, Copy, Debug)]
struct Span {
    left: f64,
    right: f64,
    is_mark: bool,
}

impl Span {
    /// The span of a bar. It ends near the window.
    fn of(bar: &Bar, axis: &Axis) -> Self {
        let near = |at_ns| axis.x(at_ns).clamp(axis.left - 20.0, axis.right() + 20.0);
        let left = near(bar.start_ns);
        let right = if bar.is_mark() { left } else { near(bar.end_ns).max(left + LEAST) };
        Self { left, right, is_mark: bar.is_mark() }
    }

    /// The same with the corners of a mark.
    fn reach(self) -> (f64, f64) {
        let more = if self.is_mark { DIAMOND } else { 0.0 };
        (self.left - more, self.right + more)
    }

    fn draw(self, canvas: &mut Canvas, bar: &Bar, middle: f64, late_from: Option<f64>) {
        let wide = self.right - self.left;
        let radius = (0.3 * wide).min(3.0);
        let top = middle - 0.5 * HEIGHT;
        let whole = rectangle((self.left, top), (wide, HEIGHT)).number("rx", radius);
        // Lines of the axis do not show through what is pale.
        canvas.put(whole.clone().set("fill", WHITE));
        let is_late = late_from.is_some_and(|from| from <= self.left + LEAST);
        let color = if is_late { LATE } else { bar.class.style().color };
        let rim = if wide > 4.0 { "0.8" } else { "0" };
        let rimmed = |part: Element| part.set("stroke", WHITE).set("stroke-width", rim);
        canvas.put(aside(rimmed(whole.set("fill", color)), bar));
        if let Some(from) = late_from.filter(|_| !is_late) {
            let late = rectangle((from, top), (self.right - from, HEIGHT)).number("rx", radius);
            canvas.put(rimmed(late.set("fill", LATE)));
        }
    }
}

/// Makes the element paler, if its bar is aside.
fn aside(element: Element, bar: &Bar) -> Element {
    if bar.is_aside { element.set("fill-opacity", "0.32") } else { element }
}

/// Writes the label into the bar, into the wider part if a part is late, or else beside it if there is room.
fn label(
    canvas: &mut Canvas,
    axis: &Axis,
    bar: &Bar,
    span: Span,
    (middle, free_until): (f64, f64),
    late_from: Option<f64>,
) {
    let wide = width(&bar.label, SIZE);
    // The label is placed on the visible part of the bar.
    let (start, end) = (span.left.max(axis.left), span.right.min(axis.right()));
    let from = late_from.unwrap_or(end).clamp(start.min(end), end);
    let is_late = end - from > from - start;
    let (left, right) = if is_late { (from, end) } else { (start, from) };
    let y = middle + 0.36 * SIZE;
    if right - left >= wide + 6.0 {
        let ink = match (is_late, bar.is_aside) {
            (true, _) => WHITE,
            (false, true) => PALE_INK,
            (false, false) => bar.class.style().ink,
        };
        let label = text((0.5 * (left + right), y), SIZE, ink, &bar.label);
        canvas.put(label.set("text-anchor", "middle"));
    } else if free_until - span.reach().1 >= wide + 8.0 && !bar.label.is_empty() {
        let color = if bar.is_aside { FRAME } else { PALE_INK };
        canvas.put(text((span.reach().1 + 4.0, y), SIZE, color, &bar.label));
    }
}

fn diamond(x: f64, y: f64, color: &str) -> Element {
    let data = format!("M{} {}l{2} {2}l-{2} {2}l-{2} -{2}z", px(x), px(y - DIAMOND), px(DIAMOND));
    Element::new("path").set("d", &data).set("fill", color).set("stroke", WHITE).set("stroke-width", "0.8")
}

/// A mark for the key: the same as in the picture.
pub(super) fn sample(x: f64, y: f64, color: &str, is_mark: bool) -> Element {
    match is_mark {
        true => diamond(x + 7.0, y, color),
        false => rectangle((x, y - 5.0), (14.0, 10.0)).set("rx", "2.5").set("fill", color),
    }
}

/// Height of a bar, in pixels.
const HEIGHT: f64 = ROW - 7.0;
/// Size of the labels.
pub(super) const SIZE: f64 = 10.5;
/// No bar is narrower than this, in pixels.
const LEAST: f64 = 1.5;
/// The distance from the middle of a mark to its corners, in pixels.
const DIAMOND: f64 = 6.0;
