//! The common parts of charts: paper, title, frame, and names of axes.

use crate::palette::{INK, PALE_INK, PAPER};
use crate::svg::{self, Canvas, Element, px};

/// The frame of the data, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Frame {
    pub(super) fn middle(&self) -> (f64, f64) {
        (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom))
    }
}

/// A picture of this size with a title: what is put is in it until [`close`].
pub(super) fn open(canvas: &mut Canvas, (width, height): (f64, f64), title: &str, subtitle: &str) {
    let root = svg::root((width, height));
    canvas.open(root.set("font-family", FONT).set("font-size", "12").set("fill", INK).titled(title));
    let paper = Element::new("rect").number("width", width).number("height", height).number("rx", 8.0);
    canvas.put(paper.set("fill", PAPER));
    let title = text((20.0, 28.0), "start", title).set("font-size", "16").set("font-weight", "600");
    canvas.put(title);
    let fits = ((width - 40.0) / self::width("m", 12.0)) as usize;
    canvas.put(text((20.0, 47.0), "start", &cut_to(subtitle, fits)).set("fill", PALE_INK));
}

pub(super) fn close(mut canvas: Canvas) -> String {
    canvas.close("svg");
    canvas.into_text()
}

/// Text at a place; `anchor` is `start`, `middle` or `end`.
pub(super) fn text((x, y): (f64, f64), anchor: &str, text: &str) -> Element {
    Element::new("text").number("x", x).number("y", y).set("text-anchor", anchor).text(text)
}

/// Text that reads upwards, about a place.
pub(super) fn upwards((x, y): (f64, f64), words: &str) -> Element {
    let turned = format!("translate({} {}) rotate(-90)", px(x), px(y));
    Element::new("text").set("transform", &turned).set("text-anchor", "middle").text(words)
}

/// A straight line.
pub(super) fn line((x1, y1): (f64, f64), (x2, y2): (f64, f64), color: &str) -> Element {
    let line = Element::new("line").number("x1", x1).number("y1", y1).number("x2", x2).number("y2", y2);
    line.set("stroke", color)
}

/// Names of the axes.
pub(super) fn names(canvas: &mut Canvas, frame: &Frame, x: &str, y: &str) {
    let (middle_x, middle_y) = frame.middle();
    canvas.put(text((middle_x, frame.bottom + 42.0), "middle", x).set("font-weight", "600"));
    canvas.put(upwards((22.0, middle_y), y).set("font-weight", "600"));
}

/// A mark of another form for each line or group, for people who see no colours.
pub(super) fn marker(i: usize, (x, y): (f64, f64), color: &str) -> Element {
    let corners: &[(f64, f64)] = match i % 4 {
        1 => &[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)],
        2 => &[(0.0, -4.8), (4.6, 3.6), (-4.6, 3.6)],
        3 => &[(0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0)],
        _ => {
            let circle = Element::new("circle").number("cx", x).number("cy", y).number("r", 4.0);
            return circle.set("fill", color).set("stroke", PAPER);
        }
    };
    let points: Vec<_> = corners.iter().map(|(dx, dy)| format!("{} {}", px(x + dx), px(y + dy))).collect();
    Element::new("polygon").set("points", &points.join(" ")).set("fill", color).set("stroke", PAPER)
}

/// About how wide a text is, in pixels: fonts differ.
pub(super) fn width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}

/// A text that is cut if it is long.
pub(super) fn cut(text: &str) -> String {
    cut_to(text, MOST)
}

/// A text of at most so many characters, with a sign that there was more.
fn cut_to(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        text.to_owned()
    } else {
        text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
    }
}

const FONT: &str = "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif";

/// Characters of the longest name that is shown whole.
const MOST: usize = 28;
