//! Paths of runs in the plane of two variables of a motivational state, in the form of Fig. 7.2 of the notes: the lethal boundaries as
//! shaded areas, and for each behaviour the isoclines, on which the tendency to it is constant.

use super::page::{self, Frame, line, text, upwards};
use crate::palette::{FRAME, GRID, INK, LATE, PALE_INK, SERIES, WHITE};
use crate::scale::{Scale, label, multiples, number, round_up};
use crate::svg::{Canvas, Element, Place, drawn, path, rectangle, simplified};

/// The plane of two variables, for one robot.
#[derive(Clone, Debug)]
pub struct Plane {
    /// The robot's name.
    pub title: String,
    /// The variable across, and the one up.
    pub axes: [Axis; 2],
    /// The names of the behaviours.
    pub behaviors: Vec<String>,
    /// The run's path.
    pub path: Vec<Visit>,
    /// The tendencies to behaviours.
    pub tendencies: Vec<Slope>,
    /// The robot's activity at the end, in words.
    pub end: String,
}

/// A variable of the plane.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The variable's name.
    pub name: String,
    /// The boundaries at which the robot dies, below and above.
    pub lethal: [Option<f64>; 2],
}

/// A point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The values of the two variables.
    pub at: [f64; 2],
    /// The place of the behaviour that was active, in [`Plane::behaviors`].
    pub behavior: Option<usize>,
}

/// A tendency as it is in the plane: bias + slope₀ x + slope₁ y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The place of the behaviour, in [`Plane::behaviors`].
    pub behavior: usize,
    /// The tendency at the origin.
    pub bias: f64,
    /// Its change for each unit of the two variables.
    pub slopes: [f64; 2],
}

/// The picture as SVG, a plane below the other.
pub fn draw(title: &str, subtitle: &str, planes: &[Plane]) -> String {
    let mut canvas = Canvas::default();
    let height = TOP + planes.len() as f64 * EACH_PX;
    page::open(&mut canvas, (LEFT + SIDE_PX + LEGEND_PX, height), title, subtitle);
    for (i, plane) in planes.iter().enumerate() {
        let top = TOP + 24.0 + i as f64 * EACH_PX;
        let frame = Frame { left: LEFT, right: LEFT + SIDE_PX, top, bottom: top + SIDE_PX };
        plane.draw(&mut canvas, &frame);
    }
    page::close(canvas)
}

impl Slope {
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.bias + self.slopes[0] * x + self.slopes[1] * y
    }

    /// The ends of an isocline within a rectangle, the last one the highest or the one farthest to the right; `None` if it is not in there.
    fn isocline(&self, level: f64, [x, y]: [(f64, f64); 2]) -> Option<[[f64; 2]; 2]> {
        let [across, up] = self.slopes;
        let rest = level - self.bias;
        let on_side = |x: f64| Some([x, (rest - across * x) / up]).filter(|at| within(at[1], y));
        let on_level = |y: f64| Some([(rest - up * y) / across, y]).filter(|at| within(at[0], x));
        let crossings = [on_side(x.0), on_level(y.0), on_level(y.1), on_side(x.1)];
        let mut crossings = crossings.into_iter().flatten();
        let first = crossings.next()?;
        let last = crossings.next_back().filter(|last| *last != first)?;
        Some([first, last])
    }
}

fn within(number: f64, (from, to): (f64, f64)) -> bool {
    (from..=to).contains(&number)
}

impl Plane {
    fn draw(&self, canvas: &mut Canvas, frame: &Frame) {
        let ends = [0, 1].map(|axis| self.ends(axis));
        let across = Scale::new(ends[0].0, ends[0].1, (frame.left, frame.right));
        let up = Scale::new(ends[1].0, ends[1].1, (frame.bottom, frame.top));
        let title = text((frame.left, frame.top - 8.0), "start", &self.title);
        canvas.put(title.set("font-weight", "600"));
        let size = (frame.right - frame.left, frame.bottom - frame.top);
        canvas.put(rectangle((frame.left, frame.top), size).set("fill", WHITE).set("stroke", FRAME));
        ticks(canvas, frame, (&across, &up));
        self.boundaries(canvas, frame, (&across, &up));
        self.isoclines(canvas, (&across, &up), ends);
        self.trace(canvas, (&across, &up));
        let (middle_x, middle_y) = frame.middle();
        canvas.put(text((middle_x, frame.bottom + 38.0), "middle", &self.axes[0].name));
        canvas.put(upwards((24.0, middle_y), &self.axes[1].name));
        self.legend(canvas, frame);
    }

    /// Around the path and the boundaries, with a margin.
    fn ends(&self, axis: usize) -> (f64, f64) {
        let visited = self.path.iter().map(|visit| visit.at[axis]);
        let all = || visited.clone().chain(self.axes[axis].lethal.into_iter().flatten());
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        // A variable without boundaries that never changed is in the middle.
        let margin = if high > low { MARGIN * (high - low) } else { 0.5 };
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        (low - margin, high + margin)
    }

    fn boundaries(&self, canvas: &mut Canvas, frame: &Frame, (across, up): (&Scale, &Scale)) {
        let [x, y] = [&self.axes[0].lethal, &self.axes[1].lethal];
        let areas = [
            x[0].map(|at| (frame.left, across.px(at), frame.top, frame.bottom)),
            x[1].map(|at| (across.px(at), frame.right, frame.top, frame.bottom)),
            y[0].map(|at| (frame.left, frame.right, up.px(at), frame.bottom)),
            y[1].map(|at| (frame.left, frame.right, frame.top, up.px(at))),
        ];
        for (left, right, top, bottom) in areas.into_iter().flatten() {
            let area = rectangle((left, top), (right - left, bottom - top)).set("class", "lethal");
            canvas.put(lethal(area).titled("lethal"));
        }
    }

    /// The isoclines at the same round levels for all behaviours: where two of one level cross, their tendencies are equal.
    fn isoclines(&self, canvas: &mut Canvas, (across, up): (&Scale, &Scale), ends: [(f64, f64); 2]) {
        let corners = |slope: &Slope| {
            let [x, y] = ends;
            [[x.0, y.0], [x.0, y.1], [x.1, y.0], [x.1, y.1]].map(|corner| slope.at(corner))
        };
        let ranges = self.tendencies.iter().map(|slope| {
            let corners = corners(slope);
            (
                corners.into_iter().fold(f64::INFINITY, f64::min),
                corners.into_iter().fold(f64::NEG_INFINITY, f64::max),
            )
        });
        let widest = ranges.clone().map(|(low, high)| high - low).fold(0.0, f64::max);
        let (step, decimals) = round_up(widest / ISOCLINES);
        for (slope, (low, high)) in self.tendencies.iter().zip(ranges) {
            let color = SERIES[slope.behavior % SERIES.len()];
            for level in multiples(low, high, step) {
                let Some(isocline) = slope.isocline(level, ends) else { continue };
                let [from, to] = isocline.map(|[x, y]| (across.px(x), up.px(y)));
                let words = format!("{}: {}", self.behaviors[slope.behavior], label(level, decimals));
                let isocline = line(from, to, color).set("stroke-dasharray", "5 4").set("class", "isocline");
                canvas.put(isocline.titled(&words));
                let small = text((to.0 - 4.0, to.1 + 12.0), "end", &label(level, decimals));
                canvas.put(small.set("font-size", "10").set("fill", color));
            }
        }
    }

    /// The path, in the colour of what was active, with a mark at each change.
    fn trace(&self, canvas: &mut Canvas, (across, up): (&Scale, &Scale)) {
        let place = |visit: &Visit| (across.px(visit.at[0]), up.px(visit.at[1]));
        let pieces: Vec<_> = self.path.chunk_by(|a, b| a.behavior == b.behavior).collect();
        for (i, piece) in pieces.iter().enumerate() {
            let color = piece[0].behavior.map_or(FRAME, |behavior| SERIES[behavior % SERIES.len()]);
            let next = pieces.get(i + 1).and_then(|next| next.first());
            let places: Vec<_> = piece.iter().chain(next).map(place).collect();
            let data = path(simplified(&places, TOLERANCE_PX));
            let stroke = drawn(&data).set("fill", "none").set("stroke", color).set("stroke-width", "2");
            canvas.put(stroke.set("stroke-linejoin", "round").set("class", "path"));
            if let Some(next) = next {
                canvas.put(dot(place(next), 2.6).set("fill", INK).titled("another behaviour"));
            }
        }
        if let (Some(first), Some(last)) = (self.path.first(), self.path.last()) {
            let words = |what: &str, [x, y]: [f64; 2]| format!("{what}: {}, {}", number(x), number(y));
            let ring = dot(place(first), 5.0).set("fill", WHITE).set("stroke", INK);
            canvas.put(ring.set("stroke-width", "1.6").titled(&words("start", first.at)));
            canvas.put(dot(place(last), 5.0).set("fill", INK).titled(&words("end", last.at)));
        }
    }

    fn legend(&self, canvas: &mut Canvas, frame: &Frame) {
        let left = frame.right + 18.0;
        let mut y = frame.top + 10.0;
        let mut entry = |mark: &[Element], words: &str| {
            let mut group = Element::group().set("transform", &format!("translate({left} {y})"));
            for part in mark {
                group = group.with(part.clone());
            }
            canvas.put(group);
            canvas.put(text((left + 30.0, y + 4.0), "start", &page::cut(words)));
            y += 20.0;
        };
        let is_there = |place: usize| {
            let visits = self.path.iter().any(|visit| visit.behavior == Some(place));
            visits || self.tendencies.iter().any(|slope| slope.behavior == place)
        };
        for (place, name) in self.behaviors.iter().enumerate().filter(|(place, _)| is_there(*place)) {
            let color = SERIES[place % SERIES.len()];
            entry(&[line((0.0, 0.0), (22.0, 0.0), color).set("stroke-width", "2")], name);
        }
        if !self.tendencies.is_empty() {
            let dashes = line((0.0, 0.0), (22.0, 0.0), PALE_INK).set("stroke-dasharray", "5 4");
            entry(&[dashes], "isoclines");
        }
        if self.axes.iter().any(|axis| axis.lethal.iter().any(Option::is_some)) {
            entry(&[lethal(rectangle((0.0, -6.0), (22.0, 12.0)))], "lethal");
        }
        entry(&[dot((11.0, 0.0), 5.0).set("fill", WHITE).set("stroke", INK)], "start");
        let end = if self.end.is_empty() { "end".to_owned() } else { format!("end: {}", self.end) };
        entry(&[dot((11.0, 0.0), 5.0).set("fill", INK)], &end);
    }
}

fn ticks(canvas: &mut Canvas, frame: &Frame, (across, up): (&Scale, &Scale)) {
    for (x, number) in across.labelled_ticks(50.0) {
        canvas.put(line((x, frame.top), (x, frame.bottom), GRID));
        canvas.put(text((x, frame.bottom + 18.0), "middle", &number).set("fill", PALE_INK));
    }
    for (y, number) in up.labelled_ticks(40.0) {
        canvas.put(line((frame.left, y), (frame.right, y), GRID));
        canvas.put(text((frame.left - 8.0, y + 4.0), "end", &number).set("fill", PALE_INK));
    }
}

fn dot((x, y): Place, radius: f64) -> Element {
    Element::new("circle").number("cx", x).number("cy", y).number("r", radius)
}

fn lethal(area: Element) -> Element {
    area.set("fill", LATE).set("fill-opacity", "0.16")
}

const LEFT: f64 = 78.0;
const TOP: f64 = 62.0;
/// Side of a frame, in pixels.
const SIDE_PX: f64 = 420.0;
/// The height of a plane with the names of its axes, in pixels.
const EACH_PX: f64 = SIDE_PX + 92.0;
/// Room for the legend, in pixels.
const LEGEND_PX: f64 = 250.0;
/// The margin on either side of an axis, in parts of what is on it.
const MARGIN: f64 = 0.08;
/// Isoclines of the behaviour whose tendency changes most, about.
const ISOCLINES: f64 = 6.0;
/// Deviations that are too small to see.
const TOLERANCE_PX: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> Plane {
        let axis = |name: &str| Axis { name: name.to_owned(), lethal: [None, Some(1.0)] };
        let visit = |x: f64, y: f64, behavior| Visit { at: [x, y], behavior: Some(behavior) };
        Plane {
            title: "robot".to_owned(),
            axes: [axis("hunger"), axis("thirst")],
            behaviors: vec!["eat".to_owned(), "drink".to_owned()],
            path: vec![visit(0.5, 0.2, 0), visit(0.3, 0.4, 0), visit(0.2, 0.5, 1), visit(0.4, 0.3, 1)],
            tendencies: vec![
                Slope { behavior: 0, bias: 0.0, slopes: [1.0, 0.0] },
                Slope { behavior: 1, bias: 0.0, slopes: [0.0, 1.0] },
            ],
            end: "drink".to_owned(),
        }
    }

    /// Fig. 7.2: lethal boundaries, isoclines of both behaviours, and a path that changes its colour where the behaviour does.
    #[test]
    fn a_plane_has_boundaries_isoclines_and_the_path() {
        let svg = draw("waterhole", "a run", &[plane()]);
        let count = |words: &str| svg.matches(words).count();
        assert_eq!((count("class=\"lethal\""), count("class=\"path\"")), (2, 2));
        assert_eq!(count("another behaviour"), 1);
        assert!(svg.contains("eat: 0.4") && svg.contains("drink: 0.4"), "{svg}");
        assert!(svg.contains("start: 0.5, 0.2") && svg.contains("end: drink") && !svg.contains("NaN"));
    }

    #[test]
    fn on_an_isocline_the_tendency_is_constant_and_it_ends_at_the_frame() {
        let slope = Slope { behavior: 0, bias: 0.1, slopes: [1.0, 2.0] };
        let frame = [(0.0, 1.0), (0.0, 2.0)];
        let ends = slope.isocline(1.1, frame).unwrap();
        assert_eq!(ends, [[0.0, 0.5], [1.0, 0.0]]);
        assert!(ends.iter().all(|end| (slope.at(*end) - 1.1).abs() < 1e-12));
        assert_eq!(slope.isocline(9.0, frame), None);
        let level = Slope { slopes: [0.0, 0.0], ..slope };
        assert_eq!(level.isocline(0.1, frame), None, "a constant has no isoclines");
    }

    #[test]
    fn a_run_without_a_path_is_an_empty_frame() {
        let empty = Plane { path: vec![], tendencies: vec![], ..plane() };
        assert!(!draw("waterhole", "", &[empty]).contains("NaN"));
    }
}
