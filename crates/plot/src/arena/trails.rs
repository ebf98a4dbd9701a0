//! The trails of robots in a run: a line for each, marks at its start, its end and its collisions, and a key.

use baudbot_geometry::{Bounds, Point, Pose};
use baudbot_sim::arena::Look;
use baudbot_sim::model::{RobotSpec, Start};
use baudbot_sim::{Scenario, SimTime};

use super::block::{Block, WIDTH};
use super::view::View;
use super::{body, extent};
use crate::palette::{INK, PALE_INK, PAPER, ROBOT, TRAILS, WHITE, darker};
use crate::quantity::{count, handy, length};
use crate::svg::{Canvas, Element, Place, arrow_head, drawn, path, px, simplified, text};
use crate::text::shortened;

/// The trails of all robots of a scenario, in their order.
#[derive(Clone, Debug)]
pub struct Trails {
    /// One for each robot.
    pub robots: Vec<Trail>,
    /// The instant at which they begin.
    pub from: SimTime,
    /// The instant at which they end.
    pub until: SimTime,
    /// The scenario's description, or its changes.
    pub about: String,
    /// Brains, links and seed.
    pub facts: String,
}

/// The trail of a robot.
#[derive(Clone, Debug)]
pub struct Trail {
    /// Points in the world. Between two pieces the robot was put elsewhere by hand.
    pub pieces: Vec<Vec<Point>>,
    /// The first pose.
    pub start: Pose,
    /// The last pose.
    pub end: Pose,
    /// Driven distance, in metres.
    pub distance_m: f64,
    /// Number of collisions.
    pub collisions: u64,
    /// The collisions that are marked.
    pub places: Vec<Collision>,
}

/// A collision of a robot.
#[derive(Clone, Debug)]
pub struct Collision {
    /// The robot's position.
    pub at: Point,
    /// The instant at which it happened.
    pub time: SimTime,
    /// The obstacle of a collision.
    pub with: String,
}

impl Trail {
    /// The trail of a robot that has not moved.
    pub fn at(pose: Pose) -> Self {
        let (start, end) = (pose, pose);
        Self { pieces: Vec::new(), start, end, distance_m: 0.0, collisions: 0, places: Vec::new() }
    }
}

impl Trails {
    /// The box around all of them, with the bodies at their ends; none without robots.
    pub(super) fn bounds(&self, robots: &[RobotSpec]) -> Option<Bounds> {
        let of = |(trail, robot): (&Trail, &RobotSpec)| {
            let points: Vec<_> = trail.pieces.iter().flatten().copied().collect();
            Bounds::of_points(&points).map(|all| extent::grown(&all, body::reach(robot)))
        };
        self.robots.iter().zip(robots).filter_map(of).reduce(|a, b| a.union(&b))
    }
}

/// Draws the trails, over everything else.
pub(super) fn draw(canvas: &mut Canvas, view: &View, scenario: &Scenario, trails: &Trails) {
    let robots = &scenario.robots;
    let is_crowd = robots.len() > MOST_THICK;
    for (i, (trail, robot)) in trails.robots.iter().zip(robots).enumerate() {
        let title = format!("the path of {}: {}", robot.name, told(trail));
        let group =
            Element::group().set("class", "trail").set("stroke", &color(robots, i)).set("fill", "none");
        let group = group.set("stroke-width", if is_crowd { "0.9" } else { "1.7" });
        canvas.open(group.set("stroke-linejoin", "round").set("stroke-linecap", "round").titled(&title));
        lines(canvas, view, trail);
        canvas.close("g");
    }
    // No mark is under another robot's line.
    for (i, (trail, robot)) in trails.robots.iter().zip(robots).enumerate() {
        marks(canvas, view, robot, trail, &color(robots, i));
    }
    for (trail, robot) in trails.robots.iter().zip(robots) {
        for Collision { at, time, with } in &trail.places {
            let title = format!("{} ran into {with} at {} s", robot.name, handy(time.as_seconds()));
            canvas.put(cross(view.at(*at)).titled(&title));
        }
    }
}

fn lines(canvas: &mut Canvas, view: &View, trail: &Trail) {
    let mut data = String::new();
    for piece in &trail.pieces {
        let places: Vec<_> = piece.iter().map(|&point| view.at(point)).collect();
        data += &path(simplified(&places, TOLERANCE_PX));
    }
    canvas.put(drawn(&data));
    let jumps = trail.pieces.windows(2).filter_map(|two| Some([*two[0].last()?, *two[1].first()?]));
    let jumps: String = jumps.map(|jump| view.line(jump)).collect();
    if !jumps.is_empty() {
        canvas.put(drawn(&jumps).set("stroke-dasharray", "2 5").set("stroke-width", "1.2"));
    }
}

/// Marks of the start and the end, with their headings.
fn marks(canvas: &mut Canvas, view: &View, robot: &RobotSpec, trail: &Trail, color: &str) {
    let ended = RobotSpec { start: Start { pose: trail.end, ..robot.start }, ..robot.clone() };
    canvas.open(Element::group().set("stroke", color));
    canvas.open(Element::group().titled(&format!("{} ended here", robot.name)));
    let rim = body::rim_of(view, &ended).set("fill", color).set("fill-opacity", "0.22");
    canvas.put(rim.set("stroke-width", "1.3"));
    let reach = (0.55 * view.length(robot.drive.radius_m)).clamp(5.0, 16.0);
    let (tail, tip) = along(view, &trail.end, reach);
    canvas.put(drawn(&arrow_head(tail, tip, 1.7 * reach)).set("fill", color).set("stroke", PAPER));
    canvas.close("g");
    // On top of the larger one: it may have come back.
    canvas.put(ring(view, &trail.start).titled(&format!("{} began here", robot.name)));
    canvas.close("g");
}

/// A ring with a line along the heading.
fn ring(view: &View, pose: &Pose) -> Element {
    let (middle, tip) = (view.at(pose.position), along(view, pose, 11.0).1);
    let circle = Element::new("circle").number("cx", middle.0).number("cy", middle.1).number("r", RING_PX);
    let group = Element::group().set("fill", PAPER).set("stroke-width", "1.7");
    group.with(drawn(&path([middle, tip]))).with(circle)
}

/// The places so many pixels behind and before a pose.
fn along(view: &View, pose: &Pose, reach: f64) -> (Place, Place) {
    let point = |sign: f64| view.at(pose.transform(Point::new(sign * reach / view.scale, 0.0)));
    (point(-1.0), point(1.0))
}

fn cross((x, y): Place) -> Element {
    let r = CROSS_PX;
    let data = path([(x - r, y - r), (x + r, y + r)]) + &path([(x - r, y + r), (x + r, y - r)]);
    let halo = drawn(&data).set("stroke", WHITE).set("stroke-width", "4.5");
    let lines = drawn(&data).set("stroke", COLLISION).set("stroke-width", "2.2");
    Element::group().set("fill", "none").set("stroke-linecap", "round").with(halo).with(lines)
}

/// The key of lines and marks.
pub(super) fn key(scenario: &Scenario, trails: &Trails) -> Block {
    let mut canvas = Canvas::default();
    let robots = &scenario.robots;
    let (from_s, until_s) = (trails.from.as_seconds(), trails.until.as_seconds());
    let whose = if robots.len() == 1 {
        "The path of a robot".to_owned()
    } else {
        format!("The paths of {}", count(robots.len(), "robot"))
    };
    let head = format!("{whose} from {} to {} s", handy(from_s), handy(until_s));
    canvas.put(text((0.0, 12.0), 13.0, INK, &head).set("font-weight", "600"));
    let mut y = 32.0;
    for (i, (trail, robot)) in trails.robots.iter().zip(robots).enumerate().take(MOST_NAMED) {
        let line = drawn(&format!("M0 {}H16", px(y - 4.0))).set("stroke", &color(robots, i));
        canvas.put(line.set("stroke-width", "2.4").set("stroke-linecap", "round"));
        canvas.put(text((24.0, y), SIZE, INK, &shortened(&robot.name, SIZE, NAMES)));
        canvas.put(text((24.0 + NAMES + 8.0, y), SIZE, PALE_INK, &told(trail)));
        y += LINE;
    }
    if robots.len() > MOST_NAMED {
        canvas.put(text((24.0, y), SIZE, PALE_INK, &format!("and {} more", robots.len() - MOST_NAMED)));
        y += LINE;
    }
    y += 4.0;
    for (mark, what) in entries(trails) {
        canvas.put(mark.set("transform", &format!("translate(8 {})", px(y - 4.0))));
        canvas.put(text((24.0, y), SIZE, INK, what));
        y += LINE + 2.0;
    }
    Block { canvas, height: y - 8.0 }
}

/// The marks that are in the picture.
fn entries(trails: &Trails) -> Vec<(Element, &'static str)> {
    let stroked = || Element::group().set("stroke", INK);
    let ring = Element::new("circle").number("r", RING_PX).set("fill", PAPER).set("stroke-width", "1.7");
    let ring = stroked().with(drawn("M0 0H9").set("stroke-width", "1.7")).with(ring);
    let arrow = drawn(&arrow_head((-7.0, 0.0), (7.0, 0.0), 11.0)).set("fill", INK);
    let jump =
        drawn("M-8 0H8").set("stroke", INK).set("stroke-dasharray", "2 5").set("stroke-linecap", "round");
    let has_jump = trails.robots.iter().any(|trail| trail.pieces.len() > 1);
    let has_cross = trails.robots.iter().any(|trail| !trail.places.is_empty());
    let all = [
        (!trails.robots.is_empty(), ring, "began here, and looked this way"),
        (!trails.robots.is_empty(), stroked().with(arrow), "ended here, and looked this way"),
        (has_cross, Element::group().with(cross((0.0, 0.0))), "was here when it ran into something"),
        (has_jump, jump, "was moved by hand"),
    ];
    all.into_iter().filter(|(is, ..)| *is).map(|(_, mark, what)| (mark, what)).collect()
}

fn told(trail: &Trail) -> String {
    match trail.collisions {
        0 => length(trail.distance_m),
        collisions => {
            let collisions = usize::try_from(collisions).unwrap_or(usize::MAX);
            format!("{}, {}", length(trail.distance_m), count(collisions, "collision"))
        }
    }
}

/// A robot's own colour, or else one of some in turn.
pub(super) fn color(robots: &[RobotSpec], place: usize) -> String {
    let look = &robots[place].look;
    match (look.color == Look::WALL.color, robots.len()) {
        (false, _) => darker(look.color, 0.85),
        (true, 1) => ROBOT.to_owned(),
        (true, _) => TRAILS[place % TRAILS.len()].to_owned(),
    }
}

/// The size of letters, in pixels.
const SIZE: f64 = 11.0;
/// The distance from one line to the next, in pixels.
const LINE: f64 = 15.0;
/// Room for names.
const NAMES: f64 = 0.42 * WIDTH;
/// More names than this are no help.
const MOST_NAMED: usize = 12;
/// The number of robots beyond which lines are thin.
const MOST_THICK: usize = 20;
/// A deviation that is too small to see, in pixels.
const TOLERANCE_PX: f64 = 0.2;
const RING_PX: f64 = 4.5;
const CROSS_PX: f64 = 4.5;
const COLLISION: &str = "#cc3311";
