//! The floor: zones, fields, lamps, and the disc that ends the run.

use baudbot_geometry::{Bounds, Circle, Point, math, polygon};
use baudbot_sim::Scenario;
use baudbot_sim::surroundings::{Field, Light, Region, Source, Surroundings, Zone};

use super::extent;
use super::labels::{Labels, NAME};
use super::view::View;
use crate::palette::{self, FIELDS, HOLLOW, LAMP, LAMP_RIM, ZoneUses};
use crate::quantity::{handy, length};
use crate::svg::{Canvas, Element, Place, arrow_head, drawn, path};
use crate::text::width;

/// Writes the hatchings and gradients that other elements refer to.
pub(super) fn definitions(canvas: &mut Canvas, around: &Surroundings) {
    let mut hues: Vec<_> = around.zones.iter().map(|zone| ZoneUses::from(zone).color()).collect();
    hues.sort_unstable();
    hues.dedup();
    for hue in hues {
        let line =
            drawn("M0 0V8").set("stroke", hue).set("stroke-width", "2.4").set("stroke-opacity", "0.55");
        let pattern = Element::new("pattern").set("id", &format!("hatch-{}", &hue[1..]));
        let pattern = pattern.set("width", "8").set("height", "8").set("patternUnits", "userSpaceOnUse");
        canvas.put(pattern.set("patternTransform", "rotate(45)").with(line));
    }
    if !around.lights.is_empty() {
        let stops = [(0.0, 0.75), (0.15, 0.45), (0.4, 0.18), (0.7, 0.05), (1.0, 0.0)];
        canvas.put(gradient("glow", LAMP, &stops));
    }
    for (i, field) in around.fields.iter().enumerate().filter(|(_, field)| !field.sources.is_empty()) {
        // A bell, three standard deviations wide.
        let stops: Vec<_> = (0..=8).map(|k| 0.125 * f64::from(k)).map(|r| (r, bell(3.0 * r))).collect();
        canvas.put(gradient(&format!("bell-{i}"), FIELDS[i % FIELDS.len()], &stops));
        if field.sources.iter().any(|source| source.strength < 0.0) {
            canvas.put(gradient(&format!("hollow-{i}"), HOLLOW, &stops));
        }
    }
    for (i, field) in around.fields.iter().enumerate() {
        slope(canvas, i, field);
    }
}

/// Draws the floor of the plan.
pub(super) fn draw(canvas: &mut Canvas, view: &View, scenario: &Scenario) {
    draw_near(canvas, view, scenario);
    // Both depend on things that are far away, and would be wrong in a smaller window.
    let around = &scenario.surroundings;
    for (i, field) in around.fields.iter().enumerate() {
        draw_slope(canvas, view, i, field);
    }
    for light in around.lights.iter().filter(|light| !is_in(view, light)) {
        draw_light(canvas, view, light);
    }
}

/// Draws the floor of any window.
pub(super) fn draw_near(canvas: &mut Canvas, view: &View, scenario: &Scenario) {
    let around = &scenario.surroundings;
    canvas.put(view.frame().set("fill", &palette::floor(around.floor)));
    for zone in around.zones.iter().filter(|zone| view.shows(&bounds(&zone.region))) {
        draw_zone(canvas, view, zone);
    }
    for (i, field) in around.fields.iter().enumerate() {
        draw_field(canvas, view, i, field);
    }
    for light in around.lights.iter().filter(|light| is_in(view, light)) {
        draw_light(canvas, view, light);
    }
    if let Some(goal) = &scenario.end.goal {
        let ring = view.circle(goal).set("fill", GOAL).set("fill-opacity", "0.1").set("stroke", GOAL);
        let ring = ring.set("stroke-width", "2").set("stroke-dasharray", "7 4");
        canvas.put(ring.titled("the run ends when a robot's centre is in here"));
    }
}

/// Puts names of zones, lamps and fields.
pub(super) fn label(labels: &mut Labels, view: &View, scenario: &Scenario) {
    let around = &scenario.surroundings;
    if let Some(goal) = scenario.end.goal {
        labels.put("end of the run", NAME, about(view, goal.center, view.length(goal.radius)));
    }
    for light in &around.lights {
        let at = lamp_place(view, light);
        let away = match is_in(view, light) {
            true => String::new(),
            false => format!(", {} away", length((light.position - view.world.center()).norm())),
        };
        let text = format!("{} {}{away}", light.name, candela(light.intensity_cd));
        let off = 0.5 * width(&text, NAME.size) + 10.0;
        let [below, above] = [16.0, -16.0].map(|off| (at.0, at.1 + off));
        let sides =
            [(at.0 + off, at.1), (at.0 - off, at.1), (at.0 - off, at.1 + 16.0), (at.0 - off, at.1 - 16.0)];
        labels.put(&text, NAME, [below, above].into_iter().chain(sides));
    }
    for zone in &around.zones {
        let bounds = bounds(&zone.region);
        let text = format!("{}: {}", zone.name, ZoneUses::from(zone).words().join(", "));
        let text = text.trim_end_matches(": ");
        let reach = 0.5 * view.length(bounds.size().y);
        // On a line a name could not be read; beside it, it can.
        let on_it = if 2.0 * reach < NAME.size { 3 } else { 0 };
        for text in [text, &zone.name] {
            if labels.put(text, NAME, about(view, bounds.center(), reach).into_iter().skip(on_it)) {
                break;
            }
        }
    }
    for field in &around.fields {
        for source in &field.sources {
            let text = format!("{} {}", field.name, handy(source.strength));
            labels.put(&text, NAME, about(view, source.position, view.length(source.width_m)));
        }
    }
}

fn draw_zone(canvas: &mut Canvas, view: &View, zone: &Zone) {
    let uses = ZoneUses::from(zone);
    let (hue, uses) = (uses.color(), uses.words());
    let title = format!("zone {}: {}", zone.name, uses.join(", "));
    canvas.open(Element::group().titled(&title));
    if let Some(floor) = zone.floor {
        canvas.put(region(view, &zone.region).set("fill", &palette::floor(floor)));
    }
    // A zone that is nothing but a floor of another grey is drawn as that.
    if uses.len() > usize::from(zone.floor.is_some()) || zone.floor.is_none() {
        canvas.put(region(view, &zone.region).set("fill", hue).set("fill-opacity", "0.1"));
        let hatch = format!("url(#hatch-{})", &hue[1..]);
        let hatched = region(view, &zone.region).set("fill", &hatch);
        canvas.put(hatched.set("stroke", hue).set("stroke-width", "1.2"));
    }
    canvas.close("g");
}

fn region(view: &View, region: &Region) -> Element {
    match region {
        Region::Disc(disc) => view.circle(disc),
        Region::Polygon(points) => drawn(&view.ring(points.iter().copied())),
    }
}

fn bounds(region: &Region) -> Bounds {
    match region {
        Region::Disc(disc) => Bounds::of_circle(disc),
        Region::Polygon(points) => Bounds::of_points(points)
            .unwrap_or_else(|| extent::of_disc(polygon::centroid(points).unwrap_or_else(Point::origin), 0.0)),
    }
}

fn draw_slope(canvas: &mut Canvas, view: &View, i: usize, field: &Field) {
    if field.slope_per_m != (0.0, 0.0) {
        let (x, y) = field.slope_per_m;
        let title = format!("field {}: rises by {x} a metre along x and by {y} along y", field.name);
        canvas.put(view.frame().set("fill", &format!("url(#slope-{i})")).titled(&title));
    }
}

fn draw_field(canvas: &mut Canvas, view: &View, i: usize, field: &Field) {
    let strongest = field.sources.iter().map(|source| source.strength.abs()).fold(1e-12, f64::max);
    for source in &field.sources {
        draw_bell(canvas, view, (i, field), source, source.strength.abs() / strongest);
    }
}

fn draw_bell(canvas: &mut Canvas, view: &View, (i, field): (usize, &Field), source: &Source, share: f64) {
    let disc = |sigmas: f64| Circle { center: source.position, radius: sigmas * source.width_m };
    if !view.shows(&Bounds::of_circle(&disc(3.0))) {
        return;
    }
    let (id, hue) = match source.strength < 0.0 {
        true => ("hollow", HOLLOW),
        false => ("bell", FIELDS[i % FIELDS.len()]),
    };
    let title = format!(
        "field {}: {} in the middle, 1σ is {}; rings at 1σ and 2σ",
        field.name,
        handy(source.strength),
        length(source.width_m)
    );
    canvas.open(Element::group().set("fill", "none").set("stroke", hue).titled(&title));
    let glow = view.circle(&disc(3.0)).set("stroke", "none").set("fill", &format!("url(#{id}-{i})"));
    canvas.put(glow.number("fill-opacity", 0.15 + 0.55 * share));
    for sigmas in [1.0, 2.0] {
        canvas.put(view.circle(&disc(sigmas)).set("stroke-width", "0.8").set("stroke-dasharray", "3 3"));
    }
    canvas.close("g");
}

fn draw_light(canvas: &mut Canvas, view: &View, light: &Light) {
    let at = lamp_place(view, light);
    let blinks = if light.blink_ns.is_some() { ", blinks" } else { "" };
    let shadows = if light.shadows { "" } else { ", casts no shadows" };
    let title = format!(
        "lamp {}: {}, {} above the floor{blinks}{shadows}",
        light.name,
        candela(light.intensity_cd),
        length(light.height_m)
    );
    canvas.open(Element::group().titled(&title));
    let circle = |radius| Element::new("circle").number("cx", at.0).number("cy", at.1).number("r", radius);
    if is_in(view, light) {
        // As far as it gives 10 lux, within what a picture can show.
        let most = view.width().max(view.height());
        let glow = view.length(math::sqrt(light.intensity_cd / 10.0)).clamp(0.04 * most, 0.22 * most);
        canvas.put(circle(glow).set("fill", "url(#glow)"));
    } else {
        let (x, y) = view.at(light.position);
        let (dx, dy) = (x - at.0, y - at.1);
        let share = 21.0 / math::hypot(dx, dy).max(1.0);
        let tip = (at.0 + share * dx, at.1 + share * dy);
        canvas.put(drawn(&arrow_head(at, tip, 9.0)).set("fill", LAMP));
    }
    let rays: String = (0..8)
        .map(|k| math::sin_cos(f64::from(k) * std::f64::consts::FRAC_PI_4))
        .map(|(sin, cos)| path([(at.0 + 6.5 * cos, at.1 + 6.5 * sin), (at.0 + 9.5 * cos, at.1 + 9.5 * sin)]))
        .collect();
    canvas.put(drawn(&rays).set("stroke", LAMP_RIM).set("stroke-width", "1.3"));
    canvas.put(circle(4.5).set("fill", LAMP).set("stroke", LAMP_RIM));
    canvas.close("g");
}

/// The place of a lamp. Lamps outside of the window are drawn at its edge.
fn lamp_place(view: &View, light: &Light) -> Place {
    let (x, y) = view.at(light.position);
    if is_in(view, light) {
        return (x, y);
    }
    let inset = 22.0_f64.min(0.5 * view.width()).min(0.5 * view.height());
    let (right, bottom) = (view.left + view.width() - inset, view.top + view.height() - inset);
    (x.clamp(view.left + inset, right), y.clamp(view.top + inset, bottom))
}

fn is_in(view: &View, light: &Light) -> bool {
    view.shows(&extent::of_disc(light.position, 0.0))
}

/// The intensity of a lamp in words: a sun has many zeros.
pub(super) fn candela(intensity_cd: f64) -> String {
    if intensity_cd < 1e6 { format!("{} cd", handy(intensity_cd)) } else { format!("{intensity_cd:.1e} cd") }
}

/// Places for a name: a middle, and places below and above it.
fn about(view: &View, center: Point, reach: f64) -> [Place; 5] {
    let (x, y) = view.at(center);
    let near = 0.5 * reach;
    [(x, y), (x, y + near), (x, y - near), (x, y + reach + 9.0), (x, y - reach - 9.0)]
}

fn slope(canvas: &mut Canvas, i: usize, field: &Field) {
    let (x, y) = field.slope_per_m;
    let size = math::hypot(x, y);
    if size == 0.0 {
        return;
    }
    let (x, y) = (0.5 * x / size, -0.5 * y / size);
    let hue = FIELDS[i % FIELDS.len()];
    let gradient = Element::new("linearGradient").set("id", &format!("slope-{i}"));
    let gradient = gradient.number("x1", 0.5 - x).number("y1", 0.5 - y).number("x2", 0.5 + x);
    let gradient = gradient.number("y2", 0.5 + y).with(stop(0.0, hue, 0.0));
    canvas.put(gradient.with(stop(1.0, hue, 0.22)));
}

fn gradient(id: &str, hue: &str, stops: &[(f64, f64)]) -> Element {
    let gradient = Element::new("radialGradient").set("id", id);
    stops.iter().fold(gradient, |gradient, &(offset, opacity)| gradient.with(stop(offset, hue, opacity)))
}

fn stop(offset: f64, hue: &str, opacity: f64) -> Element {
    let stop = Element::new("stop").set("offset", &format!("{offset:.3}")).set("stop-color", hue);
    stop.number("stop-opacity", opacity)
}

fn bell(sigmas: f64) -> f64 {
    math::exp(-0.5 * sigmas * sigmas)
}

/// The disc that ends the run.
const GOAL: &str = "#0072b2";
