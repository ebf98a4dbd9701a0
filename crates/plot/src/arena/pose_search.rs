//! The search for a robot's pose: what its laser saw, and the poses that were tried, with the marks of Fig. 6.18 of the notes.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Point, Pose, Vector, math};
use baudbot_sim::Scenario;
use baudbot_sim::model::{RobotSpec, Start};

use super::block::{Block, WIDTH};
use super::extent::of_disc;
use super::labels::{Labels, Style};
use super::view::View;
use super::{body, frame, ground, key, things, walls};
use crate::palette::{FRAME, INK, PALE_INK};
use crate::svg::{Canvas, Element, Place, arrow_head, drawn, path, px, rectangle};

/// The search for a robot's pose.
#[derive(Clone, Debug)]
pub struct PoseSearch {
    /// The robot's name.
    pub robot: String,
    /// The robot's pose.
    pub truth: Pose,
    /// The pose at which the search began.
    pub guess: Pose,
    /// The pose at which it ended.
    pub found: Pose,
    /// Poses that were rejected.
    pub rejected: Vec<Pose>,
    /// The attempt that led to the end.
    pub best: Attempt,
    /// Attempts from other poses, which led nowhere.
    pub others: Vec<Attempt>,
    /// The scan of the laser, seen from the first pose.
    pub seen_from_guess: Vec<Point>,
    /// The same, seen from the last pose.
    pub seen_from_found: Vec<Point>,
    /// The lines of the key.
    pub notes: Vec<String>,
}

/// The accepted poses of a search from one start.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The poses, with their numbers among all poses that were tried.
    pub steps: Vec<(usize, Pose)>,
}

impl PoseSearch {
    /// The box around the poses that matter.
    pub(super) fn bounds(&self) -> Bounds {
        let steps = self.best.steps.iter().map(|(_, pose)| pose.position);
        let all = steps.chain([&self.truth, &self.guess, &self.found].map(|pose| pose.position));
        all.map(|point| of_disc(point, 0.0))
            .reduce(|a, b| a.union(&b))
            .unwrap_or_else(|| of_disc(Point::origin(), 1.0))
    }

    /// The part of the world that is enlarged: a square.
    fn window(&self) -> Bounds {
        let bounds = self.bounds();
        let half = (0.6 * bounds.size().x.max(bounds.size().y)).max(LEAST_M);
        let reach = Vector::new(half, half);
        Bounds { min: bounds.center() - reach, max: bounds.center() + reach }
    }
}

/// Draws it into the plan: robots, what was seen, and both ends of the search.
pub(super) fn draw(canvas: &mut Canvas, view: &View, scenario: &Scenario, search: &PoseSearch) {
    canvas.open(Element::group().set("opacity", "0.4"));
    for robot in &scenario.robots {
        let is_own = robot.name == search.robot;
        let pose = if is_own { search.truth } else { robot.start.pose };
        body::draw(canvas, view, &RobotSpec { start: Start { pose, ..robot.start }, ..robot.clone() });
    }
    canvas.close("g");
    seen(canvas, view, search);
    let window = search.window();
    let ((left, bottom), (right, top)) = (view.at(window.min), view.at(window.max));
    let mark = rectangle((left, top), (right - left, bottom - top)).set("rx", "4").set("fill", "none");
    canvas.put(mark.set("stroke", PALE_INK).set("stroke-width", "0.8").titled("enlarged"));
    line(canvas, view, &search.best, INK, "1.2");
    ends(canvas, view, search, 2.5);
}

/// The poses that were tried, enlarged.
pub(super) fn enlarged(search: &PoseSearch, scenario: &Scenario, plan_scale: f64) -> Block {
    let window = search.window();
    let view = View { world: window, scale: WIDTH / window.size().x, left: 0.0, top: HEAD };
    let mut canvas = Canvas::default();
    let times = view.scale / plan_scale;
    let digits = if times < 10.0 { 1 } else { 0 };
    let head = Element::new("text").set("x", "0").set("y", "12").set("font-size", "13").set("fill", INK);
    canvas.put(
        head.set("font-weight", "600")
            .text(&format!("poses that were tried, {times:.digits$} times as large")),
    );
    let shape = || view.frame().set("rx", "8");
    canvas.put(Element::new("clipPath").set("id", "poses").with(shape()));
    canvas.open(Element::group().set("clip-path", "url(#poses)"));
    ground::draw_near(&mut canvas, &view, scenario);
    walls::draw(&mut canvas, &view, &scenario.arena);
    things::draw(&mut canvas, &view, scenario, false);
    seen(&mut canvas, &view, search);
    let rejected: String = search.rejected.iter().map(|pose| heading(&view, pose, 5.0)).collect();
    canvas.put(stroke(&rejected, REJECTED, "0.8").set("class", "rejected"));
    for other in &search.others {
        line(&mut canvas, &view, other, OTHER, "1");
    }
    line(&mut canvas, &view, &search.best, INK, "0.9");
    marks(&mut canvas, &view, &search.best);
    ends(&mut canvas, &view, search, 4.5);
    canvas.append(&numbers(&view, search));
    canvas.close("g");
    canvas.put(shape().set("fill", "none").set("stroke", FRAME));
    let bar = frame::step(view.scale).0;
    let place = (WIDTH - view.length(bar) - 12.0, HEAD + view.height() - 24.0);
    frame::measure(&mut canvas, place, bar, view.scale);
    Block { canvas, height: HEAD + view.height() }
}

/// The key.
pub(super) fn key(search: &PoseSearch) -> Block {
    let place = Pose::new(5.0, -5.0, 0.0);
    let view = View { world: of_disc(Point::origin(), 0.0), scale: 1.0, left: 0.0, top: 0.0 };
    let with_heading = |mark: Element, color: &str| {
        Element::group().with(stroke(&heading(&view, &place, 11.0), color, "1.4")).with(mark)
    };
    let dots = |color: &str| stroke("M1 5h.01M8 5h.01M15 5h.01", color, "2.6").set("stroke-linecap", "round");
    let accepted = disc((5.0, 5.0), 2.6).set("fill", "#ffffff").set("stroke", INK);
    let mut marks = vec![
        (with_heading(square((5.0, 5.0), 4.0, TRUTH, TRUTH), TRUTH), "where the robot is"),
        (with_heading(disc((5.0, 5.0), 4.0).set("fill", GUESS), GUESS), "where it believed it was"),
        (with_heading(square((5.0, 5.0), 4.0, "#ffffff", FOUND), FOUND), "where the search ended"),
        (with_heading(accepted, INK), "a pose at which it went on, with its number"),
        (stroke(&heading(&view, &place, 8.0), REJECTED, "1.2"), "a pose that was no better"),
        (stroke("M0 5H16", OTHER, "1.4"), "a path from another start"),
        (dots(GUESS), "what the laser saw, from where it believed it was"),
        (dots(FOUND), "the same from where the search ended"),
    ];
    if search.others.is_empty() {
        marks.remove(5);
    }
    key::of_marks(&search.notes, marks)
}

/// Draws what the laser saw.
fn seen(canvas: &mut Canvas, view: &View, search: &PoseSearch) {
    for (points, color, class) in [
        (&search.seen_from_guess, GUESS, "seen-from-guess"),
        (&search.seen_from_found, FOUND, "seen-from-found"),
    ] {
        let shown = points.iter().filter(|point| view.shows(&of_disc(**point, 0.0)));
        // Lines of no length, with round ends.
        let dots = shown.fold(String::new(), |mut data, &point| {
            let (x, y) = view.at(point);
            let _ = write!(data, "M{} {}h.01", px(x), px(y));
            data
        });
        canvas.put(stroke(&dots, color, "2.6").set("stroke-linecap", "round").set("class", class));
    }
}

fn line(canvas: &mut Canvas, view: &View, attempt: &Attempt, color: &str, width: &str) {
    let data = view.line(attempt.steps.iter().map(|(_, pose)| pose.position));
    canvas.put(stroke(&data, color, width).set("stroke-linejoin", "round").set("class", "attempt"));
}

/// Draws the accepted poses.
fn marks(canvas: &mut Canvas, view: &View, attempt: &Attempt) {
    for (number, pose) in &attempt.steps {
        canvas.open(
            Element::group().set("class", "accepted").titled(&format!("pose {number}: {}", told(pose))),
        );
        canvas.put(stroke(&heading(view, pose, 13.0), INK, "0.9"));
        canvas.put(disc(view.at(pose.position), 2.6).set("fill", "#ffffff").set("stroke", INK));
        canvas.close("g");
    }
}

/// Draws the true pose and both ends of the search.
fn ends(canvas: &mut Canvas, view: &View, search: &PoseSearch, size: f64) {
    let ends = [
        (&search.truth, "truth", "where the robot is", TRUTH),
        (&search.guess, "guess", "where it believed it was", GUESS),
        (&search.found, "found", "where the search ended", FOUND),
    ];
    for (pose, class, what, color) in ends {
        let at = view.at(pose.position);
        canvas.open(Element::group().set("class", class).titled(&format!("{what}: {}", told(pose))));
        canvas.put(stroke(&heading(view, pose, 4.5 * size), color, "1.6"));
        canvas.put(match class {
            "truth" => square(at, size, color, color),
            "found" => square(at, 1.35 * size, "none", color),
            _ => disc(at, size).set("fill", color),
        });
        canvas.close("g");
    }
}

/// Numbers of the poses, as far as there is room for them.
fn numbers(view: &View, search: &PoseSearch) -> Canvas {
    let (left, top) = (view.left + 3.0, view.top + 3.0);
    let mut labels = Labels::new((left, top), (left + view.width() - 6.0, top + view.height() - 6.0));
    for pose in [&search.truth, &search.guess, &search.found] {
        labels.keep_disc(view.at(pose.position), 7.0);
    }
    for (_, pose) in &search.best.steps {
        labels.keep_disc(view.at(pose.position), 3.2);
    }
    let style = Style { size: 9.0, color: INK, bold: false };
    // The guess is no. 0, which is at its mark.
    for (number, pose) in search.best.steps.iter().filter(|(number, _)| *number > 0) {
        let (x, y) = view.at(pose.position);
        let places = [(9.0, -8.0), (-9.0, -8.0), (9.0, 8.0), (-9.0, 8.0), (0.0, -11.0), (0.0, 11.0)];
        labels.put(&number.to_string(), style, places.map(|(right, down)| (x + right, y + down)));
    }
    labels.into_canvas()
}

/// An arrow from a pose along its heading, so many pixels long, as the data of a path.
fn heading(view: &View, pose: &Pose, length: f64) -> String {
    let (from, (sin, cos)) = (view.at(pose.position), math::sin_cos(pose.heading));
    let to = (from.0 + length * cos, from.1 - length * sin);
    path([from, to]) + &arrow_head(from, to, 0.3 * length)
}

fn stroke(data: &str, color: &str, width: &str) -> Element {
    drawn(data).set("fill", "none").set("stroke", color).set("stroke-width", width)
}

fn disc((x, y): Place, radius: f64) -> Element {
    Element::new("circle").number("cx", x).number("cy", y).number("r", radius)
}

fn square((x, y): Place, half: f64, fill: &str, color: &str) -> Element {
    let shape = rectangle((x - half, y - half), (2.0 * half, 2.0 * half)).set("fill", fill);
    shape.set("stroke", color).set("stroke-width", "1.6")
}

fn told(pose: &Pose) -> String {
    format!("({:.3}, {:.3}), {:.3} rad", pose.position.x, pose.position.y, pose.heading)
}

/// Room for the heading.
const HEAD: f64 = 20.0;
/// Half of what is enlarged is at least so wide, in metres.
const LEAST_M: f64 = 0.02;
const TRUTH: &str = "#126b2e";
const GUESS: &str = "#d55e00";
const FOUND: &str = "#0072b2";
const REJECTED: &str = "#a9b1bd";
const OTHER: &str = "#aa4499";
