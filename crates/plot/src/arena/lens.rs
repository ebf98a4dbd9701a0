//! Enlargements of robots that are too small in the plan.

use baudbot_geometry::{Bounds, Vector, math};
use baudbot_sim::raycast::RayCaster;
use baudbot_sim::{Scenario, World};

use super::block::{Block, WIDTH};
use super::kinds::Kind;
use super::labels::{Labels, Style};
use super::view::View;
use super::{body, extent, frame, ground, senses, things, walls};
use crate::palette::{self, FRAME, INK, PALE_INK};
use crate::svg::{Canvas, Element, Place, rectangle};
use crate::text::shortened;

/// The first robot of a kind with its surroundings.
pub(super) fn draw(
    number: usize,
    kind: &Kind<'_>,
    world: &World,
    caster: &RayCaster<'_>,
    (height, plan_scale): (f64, f64),
) -> Block {
    let view = View { left: 0.0, top: HEAD, ..window(kind, height) };
    let mut canvas = Canvas::default();
    let head = Element::new("text").set("x", "0").set("y", "12").set("font-size", "13").set("fill", INK);
    let times = view.scale / plan_scale;
    let digits = if times < 10.0 { 1 } else { 0 };
    let text = format!("{}, {times:.digits$} times as large", shortened(&kind.robot.name, 13.0, 170.0));
    canvas.put(head.set("font-weight", "600").text(&text));
    let id = format!("lens-{number}");
    let shape = || view.frame().set("rx", "8");
    canvas.put(Element::new("clipPath").set("id", &id).with(shape()));
    canvas.open(Element::group().set("clip-path", &format!("url(#{id})")));
    let mut labels = Labels::new((4.0, HEAD + 4.0), (WIDTH - 4.0, HEAD + view.height() - 4.0));
    draw_inside(&mut canvas, &mut labels, &view, kind, world, caster);
    canvas.append(&labels.into_canvas());
    canvas.close("g");
    canvas.put(shape().set("fill", "none").set("stroke", FRAME));
    let bar = frame::step(view.scale).0;
    frame::measure(
        &mut canvas,
        (WIDTH - view.length(bar) - 12.0, HEAD + view.height() - 24.0),
        bar,
        view.scale,
    );
    Block { canvas, height: HEAD + view.height() }
}

/// The place above the enlarged part of the plan.
pub(super) fn above(plan: &View, kind: &Kind<'_>, height: f64) -> Place {
    let world = window(kind, height).world;
    let (x, y) = plan.at(baudbot_geometry::Point::new(world.center().x, world.max.y));
    (x, y - 9.0)
}

/// Marks the enlarged part of the plan.
pub(super) fn mark(canvas: &mut Canvas, plan: &View, kind: &Kind<'_>, height: f64) {
    let world = window(kind, height).world;
    let (left, bottom) = plan.at(world.min);
    let (right, top) = plan.at(world.max);
    let mark = rectangle((left, top), (right - left, bottom - top)).set("rx", "4").set("fill", "none");
    let title = format!("enlarged: {}", kind.robot.name);
    canvas.put(
        mark.set("stroke", PALE_INK).set("stroke-width", "0.8").set("stroke-opacity", "0.7").titled(&title),
    );
}

/// Puts labels at a robot's sensors.
pub(super) fn label_sensors(labels: &mut Labels, view: &View, caster: &RayCaster<'_>, kind: &Kind<'_>) {
    let robot = (kind.first, kind.robot);
    let middle = view.at(kind.robot.start.pose.position);
    let rim = view.length(kind.robot.drive.radius_m);
    for sensor in kind.robot.sensors.iter() {
        let Some(place) = senses::place(view, caster, robot, sensor) else { continue };
        // Dark enough for text on its fan.
        let color = palette::darker(palette::rgb(sensor.device.sensor_kind().style().color), 0.62);
        let style = Style { size: 10.5, color: &color, bold: false };
        let off: Place = (place.0 - middle.0, middle.1 - place.1);
        let far = math::hypot(off.0, off.1);
        // A sensor in the middle is labelled by its direction.
        let facing = sensor.device.mount().map(|mount| caster.place(kind.first, mount).heading);
        let way = if far > 0.3 * rim { math::atan2(off.1, off.0) } else { facing.unwrap_or(0.0) };
        labels.put_off(&sensor.name, style, place, way, (rim - far).max(0.0) + 14.0);
    }
}

fn draw_inside(
    canvas: &mut Canvas,
    labels: &mut Labels,
    view: &View,
    kind: &Kind<'_>,
    world: &World,
    caster: &RayCaster<'_>,
) {
    let scenario: &Scenario = world.scenario();
    ground::draw_near(canvas, view, scenario);
    walls::draw(canvas, view, &scenario.arena);
    things::draw(canvas, view, scenario, false);
    let robot = (kind.first, kind.robot);
    senses::fans(canvas, view, caster, robot);
    let near = |other: &&baudbot_sim::model::RobotSpec| view.shows(&extent::of_robot(other));
    for other in scenario.robots.iter().filter(near) {
        body::draw(canvas, view, other);
    }
    senses::mounts(canvas, view, caster, robot);
    labels.keep_disc(view.at(kind.robot.start.pose.position), view.length(kind.robot.drive.radius_m) + 2.0);
    label_sensors(labels, view, caster, kind);
}

/// The window: the body, and as much of its sensors' ranges as leaves the body large enough.
fn window(kind: &Kind<'_>, height: f64) -> View {
    let radius = kind.robot.drive.radius_m;
    let reach = |sensor: &baudbot_sim::sensor::Sensor| {
        let off = sensor.device.mount().map_or(0.0, |mount| mount.pose.position.coords.norm());
        off + sensor.device.range_m().unwrap_or(0.0)
    };
    let farthest = kind.robot.sensors.iter().map(reach).fold(0.0, f64::max);
    let half = (1.1 * farthest).clamp(2.0 * radius, 3.2 * radius);
    let scale = 0.5 * height / half;
    let size = Vector::new(0.5 * WIDTH / scale, half);
    let middle = kind.robot.start.pose.position;
    View { world: Bounds { min: middle - size, max: middle + size }, scale, left: 0.0, top: 0.0 }
}

/// Room for the name, in pixels.
const HEAD: f64 = 20.0;
