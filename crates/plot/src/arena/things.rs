//! Things that move by themselves, with their paths, and things that can be pushed.

use baudbot_geometry::{Bounds, Point, Pose, polygon};
use baudbot_sim::Scenario;
use baudbot_sim::movable::{Movable, MovableShape};
use baudbot_sim::mover::{AfterLast, Mover, Path};

use super::extent::{self, of_disc};
use super::labels::{Labels, NAME};
use super::view::{View, arc};
use crate::palette::{MOVABLE, MOVER, darker, lighter, own_color, rgb};
use crate::quantity::{count, duration, handy};
use crate::svg::{Canvas, Element, Place, arrow_head, drawn, path};
use crate::text::width;

/// Draws the things that a window shows. Paths are drawn in the plan only.
pub(super) fn draw(canvas: &mut Canvas, view: &View, scenario: &Scenario, with_ways: bool) {
    for mover in &scenario.movers {
        if with_ways {
            canvas.open(Element::group().set("stroke", MOVER).set("fill", "none").titled(&way_title(mover)));
            draw_way(canvas, view, mover);
            canvas.close("g");
        }
        if view.shows(&of_disc(mover.start.position, mover.radius_m)) {
            let color = own_color(mover.look.color, rgb(MOVER_BODY));
            let body = outline(view, &mover.outline, mover.radius_m, &mover.start);
            let body = body.set("fill", &lighter(color, 0.55)).set("stroke", &darker(color, 0.7));
            canvas.put(body.set("stroke-width", "1.3").titled(&way_title(mover)));
        }
    }
    for thing in &scenario.movables {
        if view.shows(&of_disc(thing.start.position, extent::radius(&thing.shape))) {
            draw_movable(canvas, view, thing);
        }
    }
}

/// Puts their names.
pub(super) fn label(labels: &mut Labels, view: &View, scenario: &Scenario) {
    let movers = scenario.movers.iter().map(|mover| (&mover.name, bounds_of(mover)));
    let movables = scenario
        .movables
        .iter()
        .map(|thing| (&thing.name, of_disc(thing.start.position, extent::radius(&thing.shape))));
    for (name, bounds) in movers.chain(movables) {
        let (x, y) = view.at(bounds.center());
        let (wide, high) = (0.5 * view.length(bounds.size().x), 0.5 * view.length(bounds.size().y));
        let off = wide + 0.5 * width(name, NAME.size) + 4.0;
        labels.put(
            name,
            NAME,
            [(x, y + high + 8.0), (x, y - high - 8.0), (x + off, y), (x - off, y), (x, y)],
        );
    }
}

fn bounds_of(mover: &Mover) -> Bounds {
    let corners: Vec<_> = mover.outline.iter().map(|&corner| mover.start.transform(corner)).collect();
    Bounds::of_points(&corners).unwrap_or_else(|| of_disc(mover.start.position, mover.radius_m))
}

fn draw_movable(canvas: &mut Canvas, view: &View, thing: &Movable) {
    let color = own_color(thing.look.color, rgb(MOVABLE));
    let (body, what) = match &thing.shape {
        MovableShape::Ball { radius_m } => (outline(view, &[], *radius_m, &thing.start), "a ball"),
        MovableShape::Box { outline: corners } => (outline(view, corners, 0.0, &thing.start), "a box"),
    };
    let title = format!("{}: {what} to push, {} kg", thing.name, handy(thing.mass_kg));
    canvas.open(Element::group().set("stroke", &darker(color, 0.6)).titled(&title));
    canvas.put(body.set("fill", &lighter(color, 0.7)).set("stroke-width", "1.3"));
    // The lid of a crate, the seam of a ball.
    let mark = match &thing.shape {
        MovableShape::Ball { radius_m } => view.line(arc(&thing.start, 0.6 * radius_m, 0.6, 2.4)),
        MovableShape::Box { outline } => {
            let middle =
                view.at(thing.start.transform(polygon::centroid(outline).unwrap_or_else(Point::origin)));
            let ends = outline.iter().map(|&corner| view.at(thing.start.transform(corner)));
            ends.map(|end| path([middle, end])).collect()
        }
    };
    canvas.put(drawn(&mark).set("fill", "none").set("stroke-width", "0.7"));
    canvas.close("g");
}

fn outline(view: &View, corners: &[Point], radius_m: f64, pose: &Pose) -> Element {
    if corners.is_empty() {
        return view.circle(&baudbot_geometry::Circle { center: pose.position, radius: radius_m });
    }
    drawn(&view.ring(corners.iter().map(|&corner| pose.transform(corner))))
}

fn way_title(mover: &Mover) -> String {
    let way = match &mover.path {
        Path::Stops { points, speed_m_s, after, .. } => {
            let after = match after {
                AfterLast::Stay => "and stays there",
                AfterLast::Cycle => "round and round",
                AfterLast::Return => "to and fro",
            };
            format!("{} at {speed_m_s} m/s, {after}", count(points.len(), "stop"))
        }
        Path::Swing { ends_rad: [from, to], rate_rad_s, .. } => {
            format!("swings from {} to {} rad at {rate_rad_s} rad/s", handy(*from), handy(*to))
        }
        Path::Wander { speed_m_s, turn_ns } => {
            format!("wanders at {speed_m_s} m/s, turns every {} or sooner", duration(*turn_ns as f64))
        }
    };
    format!("{}: moves by itself, {way}", mover.name)
}

fn draw_way(canvas: &mut Canvas, view: &View, mover: &Mover) {
    let ghost = |pose: &Pose| {
        let ghost = outline(view, &mover.outline, mover.radius_m, pose);
        ghost.set("stroke-width", "0.8").set("stroke-dasharray", "2 3")
    };
    match &mover.path {
        Path::Stops { points, after, .. } => {
            for &point in &points[1..] {
                canvas.put(ghost(&Pose { position: point, ..mover.start }));
            }
            draw_stops(canvas, view, points, *after);
        }
        Path::Swing { ends_rad: [from, to], .. } => {
            let hinge = Pose { heading: 0.0, ..mover.start };
            canvas.put(ghost(&Pose { heading: *to, ..mover.start }));
            let tip = mover
                .outline
                .iter()
                .copied()
                .reduce(|a, b| if b.coords.norm() > a.coords.norm() { b } else { a });
            let (radius, off) = tip.map_or((mover.radius_m, 0.0), |tip| {
                (tip.coords.norm(), baudbot_geometry::math::atan2(tip.y, tip.x))
            });
            let way: Vec<_> = arc(&hinge, radius, from + off, to + off).map(|point| view.at(point)).collect();
            arrowed(canvas, &way);
        }
        Path::Wander { .. } => {
            let ring = of_disc(mover.start.position, 2.0 * mover.radius_m);
            let ring = baudbot_geometry::Circle { center: ring.center(), radius: 2.0 * mover.radius_m };
            let ring = view.circle(&ring).set("stroke-width", "1.6").set("stroke-dasharray", "0.1 5");
            canvas.put(ring.set("stroke-linecap", "round"));
        }
    }
}

fn draw_stops(canvas: &mut Canvas, view: &View, points: &[Point], after: AfterLast) {
    let mut way: Vec<_> = points.iter().map(|&point| view.at(point)).collect();
    if after == AfterLast::Cycle {
        way.push(way[0]);
    }
    arrowed(canvas, &way);
    if after == AfterLast::Return
        && let [first, second, ..] = way[..]
    {
        canvas.put(drawn(&arrow_head(second, first, 8.0)).set("fill", MOVER).set("stroke", "none"));
    }
}

fn arrowed(canvas: &mut Canvas, way: &[Place]) {
    let line = drawn(&path(way.iter().copied())).set("stroke-width", "1.3").set("stroke-dasharray", "6 4");
    canvas.put(line);
    if let [.., before, last] = *way {
        canvas.put(drawn(&arrow_head(before, last, 8.0)).set("fill", MOVER).set("stroke", "none"));
    }
}

/// A mover without a colour of its own.
const MOVER_BODY: &str = "#be828c";
