//! Sensors: fans as far as they really see, rays, whiskers, bumpers, and mounts.

use baudbot_geometry::{Fan, Point, Pose};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::raycast::{CastRay, RayCaster};
use baudbot_sim::sensor::{Mount, Sensor, Style, Symbol};

use super::extent::of_disc;
use super::view::{View, arc};
use crate::palette::WHITE;
use crate::quantity::{count, duration, handy, length};
use crate::svg::{Canvas, Element, Place, drawn, path, px, rectangle, simplified};

/// Draws the areas that a robot's sensors see, below the robots.
pub(super) fn fans(canvas: &mut Canvas, view: &View, caster: &RayCaster<'_>, robot: (usize, &RobotSpec)) {
    for sensor in robot.1.sensors.iter() {
        let area = area(view, caster, robot, sensor);
        let color = sensor.device.sensor_kind().style().color;
        let outer = Element::group().set("fill", color).set("stroke", color).titled(&title(robot.1, sensor));
        if !area.is_empty() {
            canvas.open(outer);
            canvas.append(&area);
            canvas.close("g");
        }
    }
}

/// The area that a sensor sees; nothing of sensors that look nowhere, and of those that touch, which are drawn over the robots.
fn area(view: &View, caster: &RayCaster<'_>, robot: (usize, &RobotSpec), sensor: &Sensor) -> Canvas {
    let mut area = Canvas::default();
    let Some(mount) = sensor.device.mount() else { return area };
    match (sensor.device.acceptance_rad(), sensor.device.sensor_kind().style().symbol) {
        (Some(opening_rad), _) => area.put(facing(view, caster, robot, (mount, opening_rad))),
        (None, Symbol::Line | Symbol::Arc) => {}
        (None, Symbol::Dot | Symbol::Square | Symbol::Ring) => {
            fan(&mut area, view, caster, (robot.0, sensor, mount));
        }
    }
    area
}

/// Draws the area that a sensor sees, and its rays unless there are many.
fn fan(
    group: &mut Canvas,
    view: &View,
    caster: &RayCaster<'_>,
    (robot, sensor, mount): (usize, &Sensor, &Mount),
) {
    let (Some(fan), Some(range_m)) = (sensor.device.fan(), sensor.device.range_m()) else { return };
    let wedge = wedge(view, caster, robot, (mount, fan, range_m));
    group.put(drawn(&wedge).set("stroke", "none").set("fill-opacity", "0.16"));
    if fan.len() <= MOST_RAYS {
        rays(group, view, &caster.sees(robot, sensor));
    }
}

/// Draws the areas of a robot that is one of many: one shape for each colour, and no rays.
pub(super) fn brief_fans(
    canvas: &mut Canvas,
    view: &View,
    caster: &RayCaster<'_>,
    robot: (usize, &RobotSpec),
) {
    let mut shapes: Vec<(&str, String)> = Vec::new();
    for device in robot.1.sensors.iter().map(|sensor| &sensor.device) {
        let (Some(mount), Some(fan), Some(range_m)) = (device.mount(), device.fan(), device.range_m()) else {
            continue;
        };
        let wedge = wedge(view, caster, robot.0, (mount, fan, range_m));
        let color = device.sensor_kind().style().color;
        match shapes.iter_mut().find(|(other, _)| *other == color) {
            Some((_, data)) => *data += &wedge,
            None => shapes.push((color, wedge)),
        }
    }
    for (color, data) in shapes {
        canvas.put(drawn(&data).set("fill", color).set("fill-opacity", "0.14"));
    }
}

/// Draws the mounts of sensors and whatever touches, over the robots.
pub(super) fn mounts(canvas: &mut Canvas, view: &View, caster: &RayCaster<'_>, robot: (usize, &RobotSpec)) {
    let spec = robot.1;
    let radius = view.length(spec.drive.radius_m);
    let dot = (0.06 * radius).clamp(1.2, 4.5);
    for sensor in spec.sensors.iter() {
        let Style { color, symbol } = sensor.device.sensor_kind().style();
        let Some(place) = place(view, caster, robot, sensor) else { continue };
        canvas.open(Element::group().set("fill", color).set("stroke", color).titled(&title(spec, sensor)));
        let circle =
            |r: f64| Element::new("circle").number("cx", place.0).number("cy", place.1).number("r", r);
        match symbol {
            Symbol::Line => {
                for cast in caster.sees(robot.0, sensor) {
                    whisker_line(canvas, view, &cast);
                }
                canvas.put(circle(0.8 * dot));
            }
            Symbol::Arc => {
                let bar = drawn(&view.line(rim_arc(caster, robot, sensor, 1.0)));
                let bar = bar.set("fill", "none").set("stroke-linecap", "round");
                canvas.put(
                    bar.number("stroke-width", (0.1 * radius).clamp(2.0, 7.0)).set("stroke-opacity", "0.85"),
                );
            }
            Symbol::Square => {
                let corner = (place.0 - dot, place.1 - dot);
                canvas.put(rectangle(corner, (2.0 * dot, 2.0 * dot)).set("stroke", WHITE));
            }
            Symbol::Ring => {
                canvas.put(circle(2.2 * dot).set("fill", "none").set("stroke-width", "1.4"));
            }
            Symbol::Dot => canvas.put(circle(dot).set("stroke", WHITE).set("stroke-width", "0.8")),
        }
        canvas.close("g");
    }
}

/// The place of a sensor in the picture, unless it has none in particular.
pub(super) fn place(
    view: &View,
    caster: &RayCaster<'_>,
    (i, robot): (usize, &RobotSpec),
    sensor: &Sensor,
) -> Option<Place> {
    match sensor.device.sensor_kind().style().symbol {
        Symbol::Arc => rim_arc(caster, (i, robot), sensor, 0.6).next().map(|point| view.at(point)),
        Symbol::Ring => {
            Some(view.at(robot.start.pose.transform(Point::new(-0.35 * robot.drive.radius_m, 0.0))))
        }
        Symbol::Dot | Symbol::Square | Symbol::Line => {
            sensor.device.mount().map(|mount| view.at(caster.place(i, mount).position))
        }
    }
}

/// The part of the robot's rim along which a sensor feels, or a share of that part about its middle.
fn rim_arc(
    caster: &RayCaster<'_>,
    (i, robot): (usize, &RobotSpec),
    sensor: &Sensor,
    share: f64,
) -> impl Iterator<Item = Point> {
    let sense = sensor.device.mount().zip(sensor.device.fan());
    sense.into_iter().flat_map(move |(mount, fan)| {
        let kappas = fan.kappas();
        let ends = [kappas[0], kappas[kappas.len() - 1]].map(|end| share * end);
        arc(&caster.place(i, mount), robot.drive.radius_m, ends[0], ends[1])
    })
}

/// The tooltip of a sensor.
pub(super) fn title(robot: &RobotSpec, sensor: &Sensor) -> String {
    let range = sensor.device.range_m().map(|range| format!(", range {}", length(range)));
    let rays = sensor.device.fan().map(|fan| format!(", {}", count(fan.len(), "ray")));
    let height = sensor.device.mount().map(|mount| mount.height.above_floor_m).filter(|height| *height > 0.0);
    let height = height.map(|height| format!(", {} above the floor", length(height)));
    let elevation_rad = sensor.device.mount().and_then(|mount| mount.elevation_rad);
    let elevation = elevation_rad.map(|elevation_rad| format!(", raised by {} rad", handy(elevation_rad)));
    let more: String = [range, rays, height, elevation].into_iter().flatten().collect();
    format!("{}.{}: {}{more}, every {}", robot.name, sensor.name, sensor.device.kind(), period(sensor))
}

/// The period of its own clock, or that of its reads.
pub(super) fn period(sensor: &Sensor) -> String {
    let own = sensor.own_clock.map(|clock| clock.period_ns);
    duration(own.unwrap_or_else(|| sensor.schedule.period_ns()) as f64)
}

/// The area that is seen through a fan, as the data of a path. A single ray is a line.
fn wedge(
    view: &View,
    caster: &RayCaster<'_>,
    robot: usize,
    (mount, fan, range_m): (&Mount, &Fan, f64),
) -> String {
    let pose = caster.place(robot, mount);
    // The range is cut at the window's farthest corner, as nothing beyond it is drawn.
    let range_m = range_m.min(1.1 * farthest(view, &pose));
    let kappas = fan.kappas();
    let opening = kappas[kappas.len() - 1] - kappas[0];
    let enough = (opening * view.length(range_m) / 1.5).ceil() as usize;
    let rays = enough.max(fan.len().min(720)).clamp(1, MOST_SAMPLES);
    let smooth = Fan::new(opening, rays);
    let casts = caster.along(robot, mount, &smooth, range_m);
    let ends: Vec<_> = casts.iter().map(|cast| view.at(cast.end())).collect();
    let origin = view.at(pose.position);
    let around = opening > std::f64::consts::TAU - 1e-3;
    path(simplified(&ends, 0.25).into_iter().chain((!around).then_some(origin))) + "Z"
}

/// A distance in metres that no corner of the window exceeds.
fn farthest(view: &View, pose: &Pose) -> f64 {
    (pose.position - view.world.center()).norm() + 0.5 * view.world.size().norm()
}

/// Draws rays as thin lines, with dots where they meet something.
fn rays(canvas: &mut Canvas, view: &View, casts: &[CastRay]) {
    let line = |cast: &CastRay| view.line([cast.ray.origin, cast.end()]);
    let lines: String = casts.iter().map(line).collect();
    canvas.put(drawn(&lines).set("fill", "none").set("stroke-width", "0.6").set("stroke-opacity", "0.6"));
    canvas.put_dots(&dots(view, casts));
}

fn dots(view: &View, casts: &[CastRay]) -> String {
    let hits = casts.iter().filter_map(|cast| Some(cast.ray.at(cast.distance_m?)));
    let seen = hits.filter(|&hit| view.shows(&of_disc(hit, 0.0))).map(|hit| view.at(hit));
    // Lines of no length, with round ends.
    seen.map(|(x, y)| format!("M{} {}h.01", px(x), px(y))).collect()
}

fn whisker_line(canvas: &mut Canvas, view: &View, cast: &CastRay) {
    let line = drawn(&view.line([cast.ray.origin, cast.end()])).set("fill", "none");
    canvas.put(line.set("stroke-width", "1.8").set("stroke-linecap", "round"));
    canvas.put_dots(&dots(view, std::slice::from_ref(cast)));
}

/// The direction and the opening of a light sensor, which has no range.
fn facing(
    view: &View,
    caster: &RayCaster<'_>,
    (i, robot): (usize, &RobotSpec),
    (mount, opening): (&Mount, f64),
) -> Element {
    let pose = caster.place(i, mount);
    let rim = arc(&pose, 0.55 * robot.drive.radius_m, -0.5 * opening, 0.5 * opening);
    let sector = drawn(&view.ring(rim.chain([pose.position])));
    let sector = sector.set("fill-opacity", "0.22").set("stroke-width", "0.7").set("stroke-dasharray", "2 2");
    sector.set("stroke-linejoin", "round")
}

/// Fans of more rays are drawn as areas only.
const MOST_RAYS: usize = 32;
/// The most corners of an area before it is simplified.
const MOST_SAMPLES: usize = 1440;
