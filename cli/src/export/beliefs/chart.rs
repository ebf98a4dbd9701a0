//! Charts over time, one below the other: panels of lines, and strips that say from when to when something was so.

use crate::drawing::xml::{Canvas, Element, px};
use crate::drawing::{
    FRAME, INK, PALE_INK, PAPER, Place, TRAILS, drawn, path, rectangle, shortened, simplified,
};

/// What is drawn of a robot.
pub(super) struct Chart {
    pub(super) title: String,
    pub(super) panels: Vec<Panel>,
    pub(super) strips: Vec<Strip>,
    /// When it begins and ends, in seconds.
    pub(super) span: (f64, f64),
}

/// Lines over one axis of values.
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) lines: Vec<Line>,
    /// In pixels.
    pub(super) height: f64,
}

/// A line through instants in seconds and values. It is broken where a value is not a number.
pub(super) struct Line {
    pub(super) name: String,
    /// Which of the colours.
    pub(super) color: usize,
    pub(super) points: Vec<(f64, f64)>,
}

/// From when to when something was so, in seconds.
pub(super) struct Strip {
    pub(super) name: String,
    /// Which of the colours.
    pub(super) color: usize,
    pub(super) spans: Vec<(f64, f64)>,
}

/// The whole file, with the scenario's name and what ran above all charts.
pub(super) fn draw(scenario: &str, ran: &str, charts: &[Chart]) -> String {
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
    let root = Element::new("svg").set("xmlns", "http://www.w3.org/2000/svg").number("width", width);
    let root = root.number("height", height).set("viewBox", &format!("0 0 {} {}", px(width), px(height)));
    let root = root.set("role", "img").set("font-family", "system-ui, Helvetica, Arial, sans-serif");
    canvas.open(root.set("font-size", "11").titled(&format!("Utilities over time in {scenario}")));
    let paper = rectangle((0.5, 0.5), (width - 1.0, height - 1.0)).set("rx", "10");
    canvas.put(paper.set("fill", PAPER).set("stroke", FRAME));
    canvas.append(&inside);
    canvas.close("svg");
    canvas.into_text()
}

/// From numbers to pixels along one axis.
#[derive(Clone, Copy)]
struct Axis {
    from: f64,
    to: f64,
    /// Where both are.
    px: (f64, f64),
}

impl Axis {
    fn at(&self, number: f64) -> f64 {
        let share = (number - self.from) / (self.to - self.from);
        self.px.0 + share * (self.px.1 - self.px.0)
    }

    /// Round numbers that are at least so many pixels apart, as they are written.
    fn ticks(&self, least_px: f64) -> Vec<(f64, String)> {
        let per_px = (self.to - self.from) / (self.px.1 - self.px.0).abs();
        let (step, decimals) = round(per_px * least_px);
        let (first, last) = ((self.from / step - 1e-9).ceil() as i64, (self.to / step + 1e-9).floor() as i64);
        let all = (first..=last).take(MOST_TICKS).map(|i| i as f64 * step);
        all.map(|number| (self.at(number), format!("{number:.decimals$}").replace('-', "−"))).collect()
    }
}

/// The least round number that is not below, and its decimals.
fn round(least: f64) -> (f64, usize) {
    for exponent in -9..18_i32 {
        for digit in [1, 2, 5] {
            let number: f64 = format!("{digit}e{exponent}").parse().expect("a number");
            if number >= least {
                return (number, (-exponent).max(0) as usize);
            }
        }
    }
    (1e18, 0)
}

impl Chart {
    /// Draws it from a height on; where it ends.
    fn draw(&self, canvas: &mut Canvas, top: f64) -> f64 {
        let title = text((LEFT, top), "start", &self.title, INK);
        canvas.put(title.set("font-size", "15").set("font-weight", "600"));
        let (from_s, to_s) = self.span;
        let time = Axis { from: from_s, to: to_s.max(from_s + 1e-3), px: (LEFT, LEFT + WIDTH) };
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
        for (x, number) in time.ticks(70.0) {
            canvas.put(drawn(&path([(x, y), (x, y + 5.0)])).set("stroke", FRAME));
            canvas.put(text((x, y + 18.0), "middle", &number, PALE_INK));
        }
        canvas.put(drawn(&path([(LEFT, y), (LEFT + WIDTH, y)])).set("stroke", FRAME));
        canvas.put(text((LEFT + 0.5 * WIDTH, y + 34.0), "middle", "time in s", PALE_INK));
        y + 34.0 + TOP
    }
}

impl Panel {
    fn draw(&self, canvas: &mut Canvas, time: &Axis, top: f64) {
        let up = self.axis(top);
        let frame = rectangle((LEFT, top), (WIDTH, self.height)).set("fill", "#ffffff");
        canvas.put(frame.set("stroke", FRAME).set("stroke-width", "0.8"));
        for (y, number) in up.ticks(26.0) {
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

    /// From the least value to the greatest, and 0.
    fn axis(&self, top: f64) -> Axis {
        let values = || self.lines.iter().flat_map(|line| &line.points).map(|(_, value)| *value);
        let finite = || values().filter(|value| value.is_finite());
        let (least, most) = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
        let margin = if most > least { 0.05 * (most - least) } else { 0.5 };
        let below = if least < 0.0 { margin } else { 0.0 };
        Axis { from: least - below, to: most + margin, px: (top + self.height, top) }
    }
}

impl Line {
    /// Its pieces in the picture, without points that nobody would miss.
    fn pieces(&self, time: &Axis, up: &Axis) -> impl Iterator<Item = Vec<Place>> {
        self.points.split(|(_, value)| !value.is_finite()).map(|piece| {
            let places: Vec<_> = piece.iter().map(|&(at_s, value)| (time.at(at_s), up.at(value))).collect();
            simplified(&places, TOLERANCE_PX)
        })
    }
}

impl Strip {
    fn draw(&self, canvas: &mut Canvas, time: &Axis, top: f64) {
        canvas.open(Element::group().set("fill", color(self.color)).set("class", "active"));
        for &(from_s, to_s) in &self.spans {
            let (from, to) = (time.at(from_s), time.at(to_s));
            // As short as it may be, it is to be seen.
            canvas.put(rectangle((from, top + 2.0), ((to - from).max(0.6), STRIP_PX - 4.0)));
        }
        canvas.close("g");
        canvas.put(text((LEFT + WIDTH + 12.0, top + STRIP_PX - 4.0), "start", &self.name, INK));
    }
}

fn color(place: usize) -> &'static str {
    TRAILS[place % TRAILS.len()]
}

fn text((x, y): Place, anchor: &str, text: &str, color: &str) -> Element {
    let at = Element::new("text").number("x", x).number("y", y).set("text-anchor", anchor);
    at.set("fill", color).text(text)
}

const LEFT: f64 = 64.0;
const WIDTH: f64 = 760.0;
/// Room for names.
const RIGHT: f64 = 150.0;
const TOP: f64 = 28.0;
/// What is above all charts.
const HEAD: f64 = 60.0;
/// Between two panels.
const GAP: f64 = 16.0;
const STRIP_PX: f64 = 15.0;
/// What nobody sees.
const TOLERANCE_PX: f64 = 0.15;
/// More ticks than any axis has room for.
const MOST_TICKS: usize = 100;
const GRID: &str = "#dfe3ea";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_far_enough_apart() {
        let axis = Axis { from: -0.3, to: 1.2, px: (220.0, 0.0) };
        let ticks = axis.ticks(26.0);
        let words: Vec<_> = ticks.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(words, ["−0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"]);
        assert!(ticks.windows(2).all(|pair| pair[0].0 - pair[1].0 > 26.0), "{ticks:?}");
    }

    #[test]
    fn a_line_is_broken_where_there_is_no_number() {
        let points = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 0.5), (3.0, 0.0)];
        let line = Line { name: "u".to_owned(), color: 0, points };
        let (time, up) =
            (Axis { from: 0.0, to: 3.0, px: (0.0, 30.0) }, Axis { from: 0.0, to: 1.0, px: (10.0, 0.0) });
        let pieces: Vec<_> = line.pieces(&time, &up).collect();
        assert_eq!(pieces, [vec![(0.0, 0.0)], vec![(20.0, 5.0), (30.0, 10.0)]]);
    }
}
