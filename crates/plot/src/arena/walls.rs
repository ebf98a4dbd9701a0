//! Walls and pillars.

use baudbot_geometry::{Bounds, Point};
use baudbot_sim::arena::{Arena, Look, Pillar, Polygon};

use super::labels::{Area, Labels, NAME};
use super::view::View;
use crate::palette::{WALL, css, darker, lighter, own_color, rgb};
use crate::quantity::length;
use crate::svg::{Canvas, Element, Place, drawn};
use crate::text::width;

/// Draws the walls and pillars that a window shows.
pub(super) fn draw(canvas: &mut Canvas, view: &View, arena: &Arena) {
    canvas.open(Element::group().set("stroke-linejoin", "round"));
    for polygon in arena.polygons() {
        if Bounds::of_points(&polygon.points).is_some_and(|bounds| view.shows(&bounds)) {
            canvas.put(draw_polygon(view, polygon));
        }
    }
    for pillar in arena.pillars().iter().filter(|pillar| view.shows(&Bounds::of_circle(&pillar.circle))) {
        let title = format!("{}: a pillar, {}", pillar.name, heights(&pillar.look));
        canvas.put(solid(view.circle(&pillar.circle), &pillar.look).titled(&title));
    }
    canvas.close("g");
}

/// Puts names into solid things that are large enough, and keeps the others free of labels; those it returns with their names.
pub(super) fn label_inside(labels: &mut Labels, view: &View, arena: &Arena) -> Vec<(String, Area)> {
    let mut outside = Vec::new();
    let polygons = arena.polygons().iter().filter(|polygon| polygon.solid).filter_map(|polygon| {
        let bounds = Bounds::of_points(&polygon.points)?;
        Some((name(&polygon.name, &polygon.look), bounds))
    });
    let named = |pillar: &Pillar| (name(&pillar.name, &pillar.look), Bounds::of_circle(&pillar.circle));
    for (text, bounds) in polygons.chain(arena.pillars().iter().map(named)).filter(|(_, at)| view.shows(at)) {
        let area = area(view, &bounds);
        let (middle, size) = (center(&area), (area.max.0 - area.min.0, area.max.1 - area.min.1));
        let fits = width(&text, NAME.size) < size.0 && NAME.size + 2.0 < size.1;
        if !(fits && labels.put(&text, NAME, [middle])) {
            outside.push((text, area));
        }
    }
    // A large solid thing may be anything but its box: an L around a room.
    let plan = view.width() * view.height();
    for (_, area) in &outside {
        if (area.max.0 - area.min.0) * (area.max.1 - area.min.1) < 0.1 * plan {
            labels.keep(*area);
        }
    }
    outside
}

/// Puts names of hollow things, and names beside the solid things that are left.
pub(super) fn label_outside(labels: &mut Labels, view: &View, arena: &Arena, outside: &[(String, Area)]) {
    for (text, area) in outside {
        let (x, y) = center(area);
        let (wide, high) = (0.5 * width(text, NAME.size) + 4.0, 0.5 * NAME.size + 4.0);
        let (left, right) = ((area.min.0 - wide, y), (area.max.0 + wide, y));
        labels.put(text, NAME, [(x, area.max.1 + high), (x, area.min.1 - high), right, left]);
    }
    for polygon in arena.polygons().iter().filter(|polygon| !polygon.solid) {
        let text = name(&polygon.name, &polygon.look);
        let middles = polygon.edges().map(|edge| edge.start + 0.5 * (edge.end - edge.start));
        let highest = middles.reduce(|a: Point, b| if b.y > a.y { b } else { a });
        let Some((x, y)) = highest.map(|middle| view.at(middle)) else { continue };
        let wide = 0.5 * width(&text, NAME.size) + 5.0;
        labels.put(&text, NAME, [(x, y + 12.0), (x, y - 12.0), (x + wide, y), (x - wide, y)]);
    }
}

fn draw_polygon(view: &View, polygon: &Polygon) -> Element {
    let points = polygon.points.iter().copied();
    let what = match (polygon.solid, polygon.closed) {
        (true, _) => "solid",
        (false, true) => "hollow",
        (false, false) => "an open line",
    };
    let title = format!("{}: {what}, {}", polygon.name, heights(&polygon.look));
    if polygon.solid {
        return solid(drawn(&view.ring(points)), &polygon.look).titled(&title);
    }
    let data = if polygon.closed { view.ring(points) } else { view.line(points) };
    let color = own_color(polygon.look.color, rgb(WALL));
    let line = drawn(&data).set("fill", "none").set("stroke-linecap", "round");
    match polygon.look.height_m.is_finite() {
        true => {
            line.set("stroke", &lighter(color, 0.6)).set("stroke-width", "2.5").set("stroke-dasharray", "6 4")
        }
        false => line.set("stroke", &css(color)).set("stroke-width", "3"),
    }
    .titled(&title)
}

/// A solid thing. Low ones are lighter: some sensors overlook them.
fn solid(shape: Element, look: &Look) -> Element {
    let color = own_color(look.color, rgb(WALL));
    if look.height_m.is_finite() {
        let shape = shape.set("fill", &lighter(color, 0.4)).set("stroke", &css(color));
        return under(shape.set("stroke-dasharray", "5 3"), look);
    }
    under(shape, look).set("fill", &css(color)).set("stroke", &darker(color, 0.65))
}

/// What some sensors see under is half transparent.
fn under(shape: Element, look: &Look) -> Element {
    if look.lower_edge_m > 0.0 { shape.set("fill-opacity", "0.45") } else { shape }
}

fn name(name: &str, look: &Look) -> String {
    match (look.lower_edge_m > 0.0, look.height_m.is_finite()) {
        (true, true) => format!("{name} ↕{} to {}", length(look.lower_edge_m), length(look.height_m)),
        (true, false) => format!("{name} ↕from {}", length(look.lower_edge_m)),
        (false, true) => format!("{name} ↕{}", length(look.height_m)),
        (false, false) => name.to_owned(),
    }
}

/// From where to where it reaches, in words.
pub(super) fn heights(look: &Look) -> String {
    let top = match look.height_m.is_finite() {
        true => format!("{} high", length(look.height_m)),
        false => "as high as any sensor".to_owned(),
    };
    if look.lower_edge_m > 0.0 { format!("{top}, from {} on", length(look.lower_edge_m)) } else { top }
}

fn area(view: &View, bounds: &Bounds) -> Area {
    let ((left, bottom), (right, top)) = (view.at(bounds.min), view.at(bounds.max));
    Area { min: (left, top), max: (right, bottom) }
}

fn center(area: &Area) -> Place {
    (0.5 * (area.min.0 + area.max.0), 0.5 * (area.min.1 + area.max.1))
}
