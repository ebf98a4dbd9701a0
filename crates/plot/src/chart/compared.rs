//! Measurements of a real thing beside those of its simulation: means with their standard deviations, and what
//! disagrees in red.

use super::page::{self, Frame, line, text, width};
use crate::palette::{FRAME, GRID, LATE, PALE_INK, PAPER, SERIES};
use crate::scale::{Scale, number};
use crate::svg::{Canvas, Element, drawn, path};

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The first line.
    pub title: String,
    /// The line below it.
    pub subtitle: String,
    /// The horizontal axis, with its unit.
    pub x: String,
    /// The vertical axis, with its unit.
    pub y: String,
    /// The points, from the left.
    pub points: Vec<Point>,
}

/// A point of both.
#[derive(Clone, Debug)]
pub struct Point {
    /// The name of the point below the axis.
    pub name: String,
    /// The place of the point on the axis; without one for each point they stand side by side.
    pub x: Option<f64>,
    /// The measured value.
    pub measured: Value,
    /// The simulated value.
    pub simulated: Value,
    /// Whether these agree.
    pub agrees: bool,
}

/// A mean with its standard deviation, if that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The mean.
    pub mean: f64,
    /// The standard deviation.
    pub sd: Option<f64>,
}

impl Chart {
    /// The picture as SVG.
    pub fn draw(&self) -> String {
        let frame = Frame { left: 78.0, right: 78.0 + PLOT.0, top: 66.0, bottom: 66.0 + PLOT.1 };
        let numbers: Option<Vec<f64>> = self.points.iter().map(|point| point.x).collect();
        let at = numbers.clone().unwrap_or_else(|| (0..self.points.len()).map(|i| i as f64).collect());
        let across = match numbers {
            Some(_) => Scale::of(&at, (frame.left, frame.right)),
            None => Scale::between(-0.5, at.len() as f64 - 0.5, (frame.left, frame.right)),
        };
        let up = Scale::round(&self.ends(), (frame.bottom, frame.top));
        let mut canvas = Canvas::default();
        page::open(&mut canvas, (frame.right + LEGEND, frame.bottom + 60.0), &self.title, &self.subtitle);
        self.grid(&mut canvas, &frame, (&across, &at), &up);
        for (series, of) in SERIES_OF {
            let values: Vec<_> = self.points.iter().map(of).collect();
            if self.points.iter().all(|point| point.x.is_some()) {
                let places = at.iter().zip(&values).map(|(x, value)| (across.px(*x), up.px(value.mean)));
                canvas.put(drawn(&path(places)).set("fill", "none").set("stroke", series.color));
            }
            for ((point, x), value) in self.points.iter().zip(&at).zip(values) {
                series.mark(&mut canvas, across.px(*x), &up, (value, point));
            }
        }
        page::names(&mut canvas, &frame, &self.x, &self.y);
        self.legend(&mut canvas, &frame);
        page::close(canvas)
    }

    /// All that the vertical axis must show.
    fn ends(&self) -> Vec<f64> {
        let values = self.points.iter().flat_map(|point| [point.measured, point.simulated]);
        let ends = values.flat_map(|Value { mean, sd }| {
            let sd = sd.unwrap_or(0.0);
            [mean - sd, mean + sd]
        });
        ends.chain([0.0]).collect()
    }

    fn grid(&self, canvas: &mut Canvas, frame: &Frame, (across, at): (&Scale, &[f64]), up: &Scale) {
        for tick in up.ticks() {
            let y = up.px(tick);
            canvas.put(line((frame.left, y), (frame.right, y), GRID));
            canvas.put(text((frame.left - 8.0, y + 4.0), "end", &number(tick)).set("fill", PALE_INK));
        }
        canvas.put(line((frame.left, frame.bottom), (frame.right, frame.bottom), FRAME));
        let mut free_from = f64::NEG_INFINITY;
        for (point, x) in self.points.iter().zip(at) {
            let (x, half) = (across.px(*x), 0.5 * width(&point.name, 12.0));
            canvas.put(line((x, frame.bottom), (x, frame.bottom + 5.0), FRAME));
            if x - half > free_from {
                let name = page::cut(&point.name);
                canvas.put(text((x, frame.bottom + 20.0), "middle", &name).set("fill", PALE_INK));
                free_from = x + half + 4.0;
            }
        }
    }

    fn legend(&self, canvas: &mut Canvas, frame: &Frame) {
        let left = frame.right + 18.0;
        let disagrees = self.points.iter().any(|point| !point.agrees);
        let entries = SERIES_OF.iter().map(|(series, _)| (series.name, series.color));
        let entries = entries.chain(disagrees.then_some(("disagrees", LATE)));
        for (i, (name, color)) in entries.enumerate() {
            let y = frame.top + 12.0 + 20.0 * i as f64;
            canvas.put(circle((left + 6.0, y), color));
            canvas.put(text((left + 18.0, y + 4.0), "start", name));
        }
    }
}

/// The drawing of one of the two.
struct Series {
    name: &'static str,
    color: &'static str,
    /// The distance from the point's place, in pixels, so that neither covers the other.
    beside: f64,
}

type Of = fn(&Point) -> Value;

const SERIES_OF: [(Series, Of); 2] = [
    (Series { name: "measured", color: SERIES[6], beside: -4.0 }, |point| point.measured),
    (Series { name: "simulated", color: SERIES[0], beside: 4.0 }, |point| point.simulated),
];

impl Series {
    fn mark(&self, canvas: &mut Canvas, x: f64, up: &Scale, (value, point): (Value, &Point)) {
        let Value { mean, sd } = value;
        let color = if point.agrees || self.beside < 0.0 { self.color } else { LATE };
        let x = x + self.beside;
        if let Some(sd) = sd.filter(|sd| *sd > 0.0) {
            let (low, high) = (up.px(mean - sd), up.px(mean + sd));
            canvas.put(line((x, low), (x, high), color).set("stroke-width", "2"));
            for y in [low, high] {
                canvas.put(line((x - 3.0, y), (x + 3.0, y), color).set("stroke-width", "2"));
            }
        }
        let spread = sd.map(|sd| format!(" ± {}", number(sd))).unwrap_or_default();
        let words = format!("{}, {}: {}{spread}", self.name, point.name, number(mean));
        canvas.put(circle((x, up.px(mean)), color).titled(&words));
    }
}

fn circle((x, y): (f64, f64), color: &str) -> Element {
    let circle = Element::new("circle").number("cx", x).number("cy", y).number("r", 4.0);
    circle.set("fill", color).set("stroke", PAPER)
}

/// Size of the plot, in pixels.
const PLOT: (f64, f64) = (560.0, 300.0);
/// Width of the legend, in pixels.
const LEGEND: f64 = 120.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x: [Option<f64>; 2]) -> String {
        let point = |(i, x): (usize, Option<f64>)| Point {
            name: format!("place {i}"),
            x,
            measured: Value { mean: 1.0, sd: Some(0.25) },
            simulated: Value { mean: 1.5, sd: None },
            agrees: i == 0,
        };
        let [title, subtitle, x_axis, y_axis] = ["t < u", "s", "x [m]", "y [1]"].map(str::to_owned);
        let points = x.into_iter().enumerate().map(point).collect();
        Chart { title, subtitle, x: x_axis, y: y_axis, points }.draw()
    }

    #[test]
    fn what_disagrees_is_red_and_named_and_the_picture_is_xml() {
        for x in [[Some(1.0), Some(2.0)], [None, None]] {
            let picture = chart(x);
            roxmltree::Document::parse(&picture).unwrap();
            assert!(
                picture.contains("measured, place 0: 1 ± 0.25")
                    && picture.contains("simulated, place 1: 1.5")
            );
            assert_eq!(picture.matches(LATE).count(), 2, "the point and the legend");
        }
    }
}
