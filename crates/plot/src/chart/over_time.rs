//! Values over time, a chart for each robot: panels of lines, and strips that show when something was active.

use super::page;
use crate::palette::{FRAME, GRID, INK, PALE_INK, TRAILS, WHITE};
use crate::scale::Scale;
use crate::svg::{self, Canvas, Element, Place, drawn, path, px, rectangle, simplified};
use crate::text::shortened;

/// A chart of one robot.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The robot's name.
    pub title: String,
    /// Panels of lines, from above.
    pub panels: Vec<Panel>,
    /// Strips below the panels.
    pub strips: Vec<Strip>,
    /// Begin and end, in seconds.
    pub span: (f64, f64),
}

/// Lines over one axis of values.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The name of the values.
    pub title: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// Height, in pixels.
    pub height: f64,
}

/// A line. It is broken where a value is not a number.
#[derive(Clone, Debug)]
pub struct Line {
    /// The name in the legend.
    pub name: String,
    /// The place of the colour in [`TRAILS`].
    pub color: usize,
    /// Instants in seconds, and values.
    pub points: Vec<(f64, f64)>,
}

/// Spans of time in which something was active.
#[derive(Clone, Debug)]
pub struct Strip {
    /// The name in the legend.
    pub name: String,
    /// The place of the colour in [`TRAILS`].
    pub color: usize,
    /// Begin and end of each span, in seconds.
    pub spans: Vec<(f64, f64)>,
}

/// The picture as SVG, with the scenario's name and what ran above all charts.
pub fn draw(scenario: &str, ran: &str, charts: &[Chart]) -> String {
    let mut inside = Canvas::default();
    let title = text((LEFT, 34.0), "start", &shortened(scenario, 20.0, WIDTH), INK);
    inside.put(title.set("font-size", "20").set("font-weight", "600"));
    let ran = text((LEFT, 56.0), "start", &shortened(ran, 13.0, WIDTH), PALE_INK);
    inside.put(ran.set("font-size", "13"));
    let mut y = HEAD + TOP;
    for chart in charts {
        y = chart.draw(&mut inside, y);
    }
    let (width, height) = (LEFT + WIDTH + RIGHT, y.ceil());
    let mut canvas = Canvas::default();
    let root = svg::root((width, height))
        .set("role", "img")
        .set("font-family", "system-ui, Helvetica, Arial, sans-serif");
    canvas.open(root.set("font-size", "11").titled(&format!("Utilities over time in {scenario}")));
    canvas.put(svg::paper((width, height)));
    canvas.append(&inside);
    canvas.close("svg");
    canvas.into_text()
}

impl Chart {
    /// Draws it from a height on, and returns where it ends.
    fn draw(&self, canvas: &mut Canvas, top: f64) -> f64 {
        let title = text((LEFT, top), "start", &self.title, INK);
        canvas.put(title.set("font-size", "15").set("font-weight", "600"));
        let (from_s, to_s) = self.span;
        let time = Scale::new(from_s, to_s.max(from_s + 1e-3), (LEFT, LEFT + WIDTH));
        let mut y = top + 14.0;
        for panel in &self.panels {
            panel.draw(canvas, &time, y);
            y += panel.height + GAP;
        }
        y -= GAP - 8.0;
        for strip in &self.strips {
            strip.draw(canvas, &time, y);
            y += STRIP_PX;
        }
        for (x, number) in time.labelled_ticks(70.0) {
            canvas.put(drawn(&path([(x, y), (x, y + 5.0)])).set("stroke", FRAME));
            canvas.put(text((x, y + 18.0), "middle", &number, PALE_INK));
        }
        canvas.put(drawn(&path([(LEFT, y), (LEFT + WIDTH, y)])).set("stroke", FRAME));
        canvas.put(text((LEFT + 0.5 * WIDTH, y + 34.0), "middle", "time in s", PALE_INK));
        y + 34.0 + TOP
    }
}

impl Panel {
    fn draw(&self, canvas: &mut Canvas, time: &Scale, top: f64) {
        let up = self.axis(top);
        let frame = rectangle((LEFT, top), (WIDTH, self.height)).set("fill", WHITE);
        canvas.put(frame.set("stroke", FRAME).set("stroke-width", "0.8"));
        for (y, number) in up.labelled_ticks(26.0) {
            let line = drawn(&path([(LEFT, y), (LEFT + WIDTH, y)]));
            canvas.put(line.set("stroke", GRID).set("stroke-width", "0.7"));
            canvas.put(text((LEFT - 7.0, y + 4.0), "end", &number, PALE_INK));
        }
        let middle = format!("translate(16 {}) rotate(-90)", px(top + 0.5 * self.height));
        let name = Element::new("text").set("text-anchor", "middle").set("transform", &middle);
        canvas.put(name.set("fill", PALE_INK).text(&self.title));
        for line in &self.lines {
            let data: String = line.pieces(time, &up).map(path).collect();
            let stroke = drawn(&data).set("fill", "none").set("stroke", color(line.color));
            let stroke = stroke.set("stroke-width", "1.5").set("stroke-linejoin", "round");
            canvas.put(stroke.set("class", "line").titled(&line.name));
        }
        if self.lines.len() > 1 {
            for (i, line) in self.lines.iter().enumerate() {
                let y = top + 12.0 + 15.0 * i as f64;
                let (x, stroke) = (LEFT + WIDTH + 12.0, color(line.color));
                let mark = drawn(&path([(x, y - 4.0), (x + 16.0, y - 4.0)])).set("stroke", stroke);
                canvas.put(mark.set("stroke-width", "2.4"));
                canvas.put(text((x + 22.0, y), "start", &line.name, INK));
            }
        }
    }

    /// The scale from the least value to the greatest; it includes 0.
    fn axis(&self, top: f64) -> Scale {
        let values = || self.lines.iter().flat_map(|line| &line.points).map(|(_, value)| *value);
        let finite = || values().filter(|value| value.is_finite());
        let (least, most) = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
        let margin = if most > least { 0.05 * (most - least) } else { 0.5 };
        let below = if least < 0.0 { margin } else { 0.0 };
        Scale::new(least - below, most + margin, (top + self.height, top))
    }
}

impl Line {
    /// The line's pieces in the picture, simplified.
    fn pieces(&self, time: &Scale, up: &Scale) -> impl Iterator<Item = Vec<Place>> {
        self.points.split(|(_, value)| !value.is_finite()).map(|piece| {
            let places: Vec<_> =
                piece.iter().map(|&(at_s, value)| (time.px_beyond(at_s), up.px_beyond(value))).collect();
            simplified(&places, TOLERANCE_PX)
        })
    }
}

impl Strip {
    fn draw(&self, canvas: &mut Canvas, time: &Scale, top: f64) {
        canvas.open(Element::group().set("fill", color(self.color)).set("class", "active"));
        for &(from_s, to_s) in &self.spans {
            let (from, to) = (time.px_beyond(from_s), time.px_beyond(to_s));
            // Even the shortest span is visible.
            canvas.put(rectangle((from, top + 2.0), ((to - from).max(0.6), STRIP_PX - 4.0)));
        }
        canvas.close("g");
        canvas.put(text((LEFT + WIDTH + 12.0, top + STRIP_PX - 4.0), "start", &self.name, INK));
    }
}

fn color(place: usize) -> &'static str {
    TRAILS[place % TRAILS.len()]
}

fn text(at: Place, anchor: &str, text: &str, color: &str) -> Element {
    page::text(at, anchor, text).set("fill", color)
}

const LEFT: f64 = 64.0;
const WIDTH: f64 = 760.0;
/// Room for names.
const RIGHT: f64 = 150.0;
const TOP: f64 = 28.0;
/// The header above all charts.
const HEAD: f64 = 60.0;
/// The gap between two panels, in pixels.
const GAP: f64 = 16.0;
const STRIP_PX: f64 = 15.0;
/// Deviations that are too small to see.
const TOLERANCE_PX: f64 = 0.15;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_broken_where_there_is_no_number() {
        let points = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 0.5), (3.0, 0.0)];
        let line = Line { name: "u".to_owned(), color: 0, points };
        let (time, up) = (Scale::new(0.0, 3.0, (0.0, 30.0)), Scale::new(0.0, 1.0, (10.0, 0.0)));
        let pieces: Vec<_> = line.pieces(&time, &up).collect();
        assert_eq!(pieces, [vec![(0.0, 0.0)], vec![(20.0, 5.0), (30.0, 10.0)]]);
    }
}
