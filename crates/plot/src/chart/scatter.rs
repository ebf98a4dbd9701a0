//! Places in a plane, in groups, with the centre of gravity of each group: both axes have the same scale.

use super::page::{self, Frame, line, marker, text, width};
use crate::palette::{FRAME, GRID, PALE_INK, SERIES};
use crate::scale::{Scale, label, multiples, number, round_up};
use crate::svg::{Canvas, Element};

/// Groups of places.
#[derive(Clone, Debug)]
pub struct Scatter {
    /// The first line.
    pub title: String,
    /// The line below it.
    pub subtitle: String,
    /// Name of the horizontal axis, with its unit.
    pub x: String,
    /// Name of the vertical axis, with its unit.
    pub y: String,
    /// The groups, at most one a colour of [`SERIES`].
    pub groups: Vec<Group>,
}

/// Places of one colour.
#[derive(Clone, Debug)]
pub struct Group {
    /// The name of the group in the legend.
    pub name: String,
    /// Numbers across and up, in the units of the axes.
    pub places: Vec<[f64; 2]>,
}

/// The two axes.
struct Plane {
    across: Scale,
    up: Scale,
    /// The numbers at their ends.
    ends: [(f64, f64); 2],
    /// The distance between two ticks, and its decimals.
    step: (f64, usize),
}

impl Group {
    /// The mean of its places; `None` without any.
    pub fn center(&self) -> Option<[f64; 2]> {
        let count = self.places.len() as f64;
        let mean = |axis: usize| self.places.iter().map(|place| place[axis]).sum::<f64>() / count;
        (!self.places.is_empty()).then(|| [mean(0), mean(1)])
    }
}

impl Scatter {
    /// The picture, as SVG. The origin is always in it, with a cross.
    pub fn draw(&self) -> String {
        let names = self.groups.iter().map(|group| width(&group.name, 12.0));
        let legend = names.fold(width(CENTER, 12.0), f64::max) + 62.0;
        let frame = Frame { left: 78.0, right: 78.0 + SIDE_PX, top: 66.0, bottom: 66.0 + SIDE_PX };
        let plane = self.plane(&frame);
        let Plane { across, up, .. } = &plane;
        let mut canvas = Canvas::default();
        page::open(&mut canvas, (frame.right + legend, frame.bottom + 60.0), &self.title, &self.subtitle);
        grid(&mut canvas, &frame, &plane);
        for (i, group) in self.groups.iter().enumerate() {
            let color = SERIES[i % SERIES.len()];
            for &[x, y] in &group.places {
                let words = format!("{}: {}, {}", group.name, number(x), number(y));
                canvas.put(marker(i, (across.px(x), up.px(y)), color).titled(&words));
            }
            if let Some([x, y]) = group.center() {
                let words = format!("{CENTER}, {}: {}, {}", group.name, number(x), number(y));
                let origin = (across.px(0.0), up.px(0.0));
                let at = (across.px(x), up.px(y));
                canvas.put(line(origin, at, color).set("stroke-dasharray", "4 3"));
                canvas.put(ring(at, color).titled(&words));
            }
        }
        page::names(&mut canvas, &frame, &self.x, &self.y);
        self.legend(&mut canvas, &frame);
        page::close(canvas)
    }

    /// Around all places and the origin, with a margin.
    fn plane(&self, frame: &Frame) -> Plane {
        let mut low = [0.0_f64; 2];
        let mut high = [0.0_f64; 2];
        for place in self.groups.iter().flat_map(|group| &group.places) {
            for axis in [0, 1] {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let span = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE) * MARGIN;
        let [x, y] = [0, 1].map(|axis| {
            let middle = 0.5 * (low[axis] + high[axis]);
            (middle - 0.5 * span, middle + 0.5 * span)
        });
        let across = Scale::new(x.0, x.1, (frame.left, frame.right));
        let up = Scale::new(y.0, y.1, (frame.bottom, frame.top));
        Plane { across, up, ends: [x, y], step: round_up(span / TICKS) }
    }

    fn legend(&self, canvas: &mut Canvas, frame: &Frame) {
        let left = frame.right + 18.0;
        for (i, group) in self.groups.iter().enumerate() {
            let y = frame.top + 10.0 + 20.0 * i as f64;
            canvas.put(marker(i, (left + 8.0, y), SERIES[i % SERIES.len()]));
            canvas.put(text((left + 24.0, y + 4.0), "start", &group.name));
        }
        let y = frame.top + 10.0 + 20.0 * self.groups.len() as f64;
        canvas.put(ring((left + 8.0, y), FRAME));
        canvas.put(text((left + 24.0, y + 4.0), "start", CENTER));
    }
}

fn grid(canvas: &mut Canvas, frame: &Frame, plane: &Plane) {
    let Plane { across, up, ends: [x_ends, y_ends], step: (step, decimals) } = plane;
    let color = |number: f64| if number == 0.0 { FRAME } else { GRID };
    for x in multiples(x_ends.0, x_ends.1, *step) {
        let at = across.px(x);
        canvas.put(line((at, frame.top), (at, frame.bottom), color(x)));
        let words = text((at, frame.bottom + 20.0), "middle", &label(x, *decimals));
        canvas.put(words.set("fill", PALE_INK));
    }
    for y in multiples(y_ends.0, y_ends.1, *step) {
        let at = up.px(y);
        canvas.put(line((frame.left, at), (frame.right, at), color(y)));
        canvas.put(text((frame.left - 8.0, at + 4.0), "end", &label(y, *decimals)).set("fill", PALE_INK));
    }
}

/// The mark of a centre of gravity.
fn ring((x, y): (f64, f64), color: &str) -> Element {
    let ring = Element::new("circle").number("cx", x).number("cy", y).number("r", 9.0);
    ring.set("fill", "none").set("stroke", color).set("stroke-width", "2")
}

const CENTER: &str = "centre of gravity";

/// The factor by which the frame is larger than the places.
const MARGIN: f64 = 1.16;

/// Side of the frame, in pixels.
const SIDE_PX: f64 = 400.0;

/// About so many ticks an axis has.
const TICKS: f64 = 6.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn scatter(groups: Vec<Group>) -> Scatter {
        let [title, subtitle, x, y] = ["Title", "below", "x, mm", "y, mm"].map(str::to_owned);
        Scatter { title, subtitle, x, y, groups }
    }

    fn group(name: &str, places: &[[f64; 2]]) -> Group {
        Group { name: name.to_owned(), places: places.to_vec() }
    }

    #[test]
    fn each_place_and_each_centre_has_a_mark_that_says_where_it_is() {
        let cw = group("cw", &[[-300.0, -100.0], [-320.0, -80.0]]);
        assert_eq!(cw.center(), Some([-310.0, -90.0]));
        let svg = scatter(vec![cw, group("ccw", &[[20.0, 30.0]])]).draw();
        for words in ["cw: −300, −100", "cw: −320, −80", "centre of gravity, cw: −310, −90", "ccw: 20, 30"]
        {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        assert!(svg.contains(SERIES[0]) && svg.contains(SERIES[1]));
    }

    #[test]
    fn without_places_there_is_an_empty_frame() {
        let svg = scatter(vec![group("cw", &[])]).draw();
        assert!(svg.contains("x, mm") && !svg.contains("NaN"), "{svg}");
    }

    #[test]
    fn both_axes_have_the_same_scale() {
        let scatter = scatter(vec![group("cw", &[[-10.0, 2.0], [90.0, 4.0]])]);
        let frame = Frame { left: 0.0, right: 100.0, top: 0.0, bottom: 100.0 };
        let Plane { across, up, .. } = scatter.plane(&frame);
        let per_unit = [across.px(50.0) - across.px(0.0), up.px(0.0) - up.px(50.0)];
        assert!((per_unit[0] - per_unit[1]).abs() < 1e-9, "{per_unit:?}");
    }
}
