//! The frame of the plan: axes in metres, a faint grid, and a scale bar.

use super::labels::{Style, written};
use super::view::View;
use crate::palette::{FRAME, GRID, INK, PALE_INK};
use crate::quantity::length;
use crate::scale::{label, multiples, round_up};
use crate::svg::{Canvas, Element, drawn, path, px};

/// Room that the left axis takes, in pixels.
pub(super) const LEFT: f64 = 58.0;
/// Room that the lower axis and the bar take, in pixels.
pub(super) const BELOW: f64 = 62.0;

/// Draws the grid, below everything else.
pub(super) fn grid(canvas: &mut Canvas, view: &View) {
    let (right, bottom) = (view.left + view.width(), view.top + view.height());
    let vertical = ticks(view, view.world.min.x, view.world.max.x).into_iter().map(|(x, _)| {
        let x = view.left + (x - view.world.min.x) * view.scale;
        path([(x, view.top), (x, bottom)])
    });
    let horizontal = ticks(view, view.world.min.y, view.world.max.y).into_iter().map(|(y, _)| {
        let y = view.top + (view.world.max.y - y) * view.scale;
        path([(view.left, y), (right, y)])
    });
    let lines: String = vertical.chain(horizontal).collect();
    canvas.put(drawn(&lines).set("stroke", GRID).set("stroke-width", "0.7").set("fill", "none"));
}

/// Draws the axes, on the left and below, and the scale bar.
pub(super) fn axes(canvas: &mut Canvas, view: &View) {
    let bottom = view.top + view.height();
    canvas.put(view.frame().set("fill", "none").set("stroke", FRAME));
    canvas.open(Element::group().set("font-size", "11").set("fill", PALE_INK));
    let mut marks = String::new();
    for (x, text) in ticks(view, view.world.min.x, view.world.max.x) {
        let x = view.left + (x - view.world.min.x) * view.scale;
        marks += &path([(x, bottom), (x, bottom + 5.0)]);
        canvas.put(tick(x, bottom + 18.0, "middle", &text));
    }
    for (y, text) in ticks(view, view.world.min.y, view.world.max.y) {
        let y = view.top + (view.world.max.y - y) * view.scale;
        marks += &path([(view.left - 5.0, y), (view.left, y)]);
        canvas.put(tick(view.left - 9.0, y + 4.0, "end", &text));
    }
    canvas.put(tick(view.left + 0.5 * view.width(), bottom + 36.0, "middle", "x in m"));
    let middle = Element::new("text").set("text-anchor", "middle");
    let (x, y) = (view.left - 40.0, view.top + 0.5 * view.height());
    let turned = format!("translate({} {}) rotate(-90)", px(x), px(y));
    canvas.put(middle.set("transform", &turned).text("y in m"));
    canvas.close("g");
    canvas.put(drawn(&marks).set("stroke", FRAME).set("fill", "none"));
    let bar = step(view.scale).0;
    measure(canvas, (view.left + view.width() - view.length(bar), bottom + 32.0), bar, view.scale);
}

/// Draws a scale bar of a length in metres, from its left end.
pub(super) fn measure(canvas: &mut Canvas, (x, y): (f64, f64), metres: f64, scale: f64) {
    let right = x + metres * scale;
    let data = path([(x, y - 4.0), (x, y), (right, y), (right, y - 4.0)]);
    canvas.put(drawn(&data).set("stroke", INK).set("stroke-width", "1.5").set("fill", "none"));
    let style = Style { size: 11.0, color: INK, bold: false };
    canvas.put(written((0.5 * (x + right), y + 9.0), &length(metres), style));
}

/// The round length that is at least so many pixels long, and its decimals.
pub(super) fn step(scale: f64) -> (f64, usize) {
    round_up((LEAST_PX / scale).min(1e9))
}

fn ticks(view: &View, min: f64, max: f64) -> Vec<(f64, String)> {
    let (step, decimals) = step(view.scale);
    multiples(min, max, step).map(|value| (value, label(value, decimals))).collect()
}

fn tick(x: f64, y: f64, anchor: &str, text: &str) -> Element {
    Element::new("text").number("x", x).number("y", y).set("text-anchor", anchor).text(text)
}

/// The least distance of ticks, in pixels.
const LEAST_PX: f64 = 62.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_at_round_numbers() {
        assert_eq!(step(150.0), (0.5, 1));
        assert_eq!(step(62.0), (1.0, 0));
        assert_eq!(step(1e-3), (1e5, 0));
        assert_eq!(step(0.0), (1e9, 0));
    }
}
