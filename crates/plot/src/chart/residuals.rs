//! Points over a quantity, a panel for each set of them: the differences that a fit leaves.

use super::page::{self, Frame, line, text};
use crate::palette::{FRAME, GRID, SERIES};
use crate::scale::{Scale, number};
use crate::svg::{Canvas, Element, px};

/// A panel of points.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The line above it.
    pub title: String,
    /// The names of the axes, with units: horizontal and vertical.
    pub axes: (String, String),
    /// The points. Those that are no finite numbers are left out.
    pub points: Vec<(f64, f64)>,
}

/// The picture as SVG.
pub fn draw(title: &str, subtitle: &str, panels: &[Panel]) -> String {
    let height = TOP + PANEL * panels.len().max(1) as f64;
    let mut canvas = Canvas::default();
    page::open(&mut canvas, (WIDTH, height), title, subtitle);
    for (i, panel) in panels.iter().enumerate() {
        panel.draw(&mut canvas, TOP + PANEL * i as f64);
    }
    page::close(canvas)
}

impl Panel {
    fn draw(&self, canvas: &mut Canvas, top: f64) {
        let frame = Frame { left: LEFT, right: WIDTH - RIGHT, top: top + HEAD, bottom: top + PANEL - FOOT };
        let points: Vec<_> =
            self.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        canvas.put(text((frame.left, top + 12.0), "start", &self.title));
        let ends = |of: fn(&(f64, f64)) -> f64| {
            let fold = |(low, high): (f64, f64), number: f64| (low.min(number), high.max(number));
            // Of nothing, or of one number, there is no range.
            let (low, high) = points.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), fold);
            if points.is_empty() {
                return (0.0, 1.0);
            }
            if low < high { (low, high) } else { (low - 1.0, low + 1.0) }
        };
        let ((x_low, x_high), (y_low, y_high)) = (ends(|point| point.0), ends(|point| point.1));
        let x = Scale::between(x_low, x_high, (frame.left, frame.right));
        let y = Scale::between(y_low, y_high, (frame.bottom, frame.top));
        for tick in y.ticks() {
            let at = y.px(tick);
            let color = if tick == 0.0 { FRAME } else { GRID };
            canvas.put(line((frame.left, at), (frame.right, at), color));
            canvas.put(text((frame.left - 6.0, at + 4.0), "end", &number(tick)));
        }
        for tick in x.ticks() {
            canvas.put(text((x.px(tick), frame.bottom + 16.0), "middle", &number(tick)));
        }
        canvas.put(line((frame.left, frame.bottom), (frame.right, frame.bottom), FRAME));
        page::names(canvas, &frame, &self.axes.0, &self.axes.1);
        // A picture of a million points is none.
        let stride = points.len().div_ceil(MOST_POINTS).max(1);
        for (at_x, at_y) in points.iter().step_by(stride) {
            let dot = Element::new("circle").set("cx", &px(x.px(*at_x))).set("cy", &px(y.px(*at_y)));
            canvas.put(dot.set("r", "1.6").set("fill", SERIES[0]).set("fill-opacity", "0.6"));
        }
    }
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 90.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 84.0;
const PANEL: f64 = 250.0;
const HEAD: f64 = 22.0;
const FOOT: f64 = 56.0;

/// Most points of a panel that are drawn.
const MOST_POINTS: usize = 4000;

#[cfg(test)]
mod tests {
    use super::{Panel, draw};

    #[test]
    fn each_panel_has_its_points_and_names_and_odd_numbers_are_left_out() {
        let panel = |points: Vec<(f64, f64)>| Panel {
            title: "a < b".into(),
            axes: ("time in s".into(), "m".into()),
            points,
        };
        let many = (0..100_000).map(|i| (f64::from(i), 1.0)).collect();
        let picture = draw(
            "Residuals",
            "of log.csv",
            &[panel(vec![(0.0, 1.0), (f64::NAN, 2.0), (2.0, -1.0)]), panel(many), panel(vec![])],
        );
        let document = roxmltree::Document::parse(&picture).unwrap();
        let circles = document.descendants().filter(|node| node.has_tag_name("circle")).count();
        assert_eq!(circles, 2 + 4000);
        assert!(picture.contains("a &lt; b") && !picture.contains("NaN"), "{picture:.500}");
    }
}
