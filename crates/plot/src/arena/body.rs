//! A robot's body: rim, wheels, heading, and the actuators on it.

use baudbot_geometry::{Circle, Point, Pose, math};
use baudbot_sim::actuator::{Actuator, ActuatorKind, Dispenser, Lamp, Speaker};
use baudbot_sim::arena::Look;
use baudbot_sim::model::{Part, RobotSpec};
use baudbot_sim::sensor::Device;
use baudbot_sim::surroundings::Region;

use super::view::{View, arc};
use super::walls::heights;
use crate::palette::{BODY, INK, INNER, LAMP, LAMP_RIM, ROBOT, WHITE, darker, lighter};
use crate::quantity::{count, handy, length};
use crate::svg::{Canvas, Element, arrow_head, drawn, path};

/// Draws a robot at its start.
pub(super) fn draw(canvas: &mut Canvas, view: &View, robot: &RobotSpec) {
    let title = format!("robot {}: {}", robot.name, count(robot.sensors.len(), "sensor"));
    canvas.open(Element::group().titled(&title));
    let (fill, rim) = colors(&robot.look);
    let radius = view.length(robot.drive.radius_m);
    let body = rim_of(view, robot).set("fill", &fill).set("fill-opacity", "0.92").set("stroke", &rim);
    canvas.put(body.set("stroke-width", if radius > 30.0 { "2" } else { "1.2" }));
    if radius > 4.0 {
        draw_wheels(canvas, view, robot);
    }
    for part in &robot.parts {
        draw_part(canvas, view, robot, part);
    }
    draw_heading(canvas, view, robot, &rim);
    if radius > 12.0 {
        for actuator in &robot.actuators {
            draw_actuator(canvas, view, robot, actuator);
        }
    }
    canvas.close("g");
}

/// The radius of a circle around the robot's drawing, in metres: wheels and parts may stand out.
pub(super) fn reach(robot: &RobotSpec) -> f64 {
    let drive = &robot.drive;
    let wheel = math::hypot(drive.half_track_m + 0.25 * drive.wheel_radius_m, drive.wheel_radius_m);
    robot.parts.iter().map(|part| part.outline.reach_m()).fold(drive.radius_m.max(wheel), f64::max)
}

/// The robot's outline or its disc.
pub(super) fn rim_of(view: &View, robot: &RobotSpec) -> Element {
    let pose = &robot.start.pose;
    if robot.outline.is_empty() {
        return view.circle(&Circle { center: pose.position, radius: robot.drive.radius_m });
    }
    drawn(&view.ring(robot.outline.iter().map(|&corner| pose.transform(corner))))
}

/// Draws what stands on the body, or sticks out of it.
fn draw_part(canvas: &mut Canvas, view: &View, robot: &RobotSpec, part: &Part) {
    let pose = &robot.start.pose;
    let shape = match &part.outline {
        Region::Disc(disc) => {
            view.circle(&Circle { center: pose.transform(disc.center), radius: disc.radius })
        }
        Region::Polygon(corners) => drawn(&view.ring(corners.iter().map(|&corner| pose.transform(corner)))),
    };
    let (fill, rim) = colors(&part.look);
    let title = format!("a part of {}, {}", robot.name, heights(&part.look));
    canvas.put(shape.set("fill", &fill).set("stroke", &rim).set("stroke-width", "1").titled(&title));
}

fn colors(look: &Look) -> (String, String) {
    match look.color == Look::WALL.color {
        true => (BODY.to_owned(), ROBOT.to_owned()),
        false => (lighter(look.color, 0.35), darker(look.color, 0.7)),
    }
}

/// Draws the wheels from above. Those with encoders have stripes.
fn draw_wheels(canvas: &mut Canvas, view: &View, robot: &RobotSpec) {
    let drive = &robot.drive;
    let counted = robot.sensors.iter().find(|sensor| matches!(sensor.device, Device::Encoders(_)));
    let half_length = drive.wheel_radius_m;
    let half_width = (0.25 * drive.wheel_radius_m).max(0.06 * drive.radius_m).max(1.0 / view.scale);
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let middle = Pose { heading: 0.0, position: Point::new(0.0, sign * drive.half_track_m) };
        let wheel = robot.start.pose.compose(&middle);
        let point = |x: f64, y: f64| wheel.transform(Point::new(x, y));
        let (x, y) = (half_length, half_width);
        let encoder = counted.map_or_else(String::new, |sensor| format!(", counted by {}", sensor.name));
        let title =
            format!("{side} wheel of {}, radius {}{encoder}", robot.name, length(drive.wheel_radius_m));
        canvas.open(Element::group().titled(&title));
        let rubber = drawn(&view.ring([point(-x, -y), point(x, -y), point(x, y), point(-x, y)]));
        canvas.put(
            rubber
                .set("fill", INK)
                .set("stroke", INK)
                .set("stroke-width", "1")
                .set("stroke-linejoin", "round"),
        );
        if counted.is_some() {
            let stripe = |share: f64| view.line([point(share * x, -y), point(share * x, y)]);
            let stripes: String = [-0.66, -0.22, 0.22, 0.66].map(stripe).concat();
            canvas.put(drawn(&stripes).set("stroke", WHITE).set("stroke-width", "1.2"));
        }
        canvas.close("g");
    }
}

fn draw_heading(canvas: &mut Canvas, view: &View, robot: &RobotSpec, color: &str) {
    let tip = robot.start.pose.transform(Point::new(0.62 * robot.drive.radius_m, 0.0));
    let (from, to) = (view.at(robot.start.pose.position), view.at(tip));
    let radius = view.length(robot.drive.radius_m);
    let line = drawn(&path([from, to])).set("stroke", color).set("fill", "none");
    canvas.put(line.set("stroke-width", if radius > 30.0 { "2" } else { "1" }));
    if radius > 6.0 {
        let head = arrow_head(from, to, (0.22 * radius).clamp(3.0, 12.0));
        canvas.put(drawn(&head).set("fill", color));
    }
}

fn draw_actuator(canvas: &mut Canvas, view: &View, robot: &RobotSpec, actuator: &Actuator) {
    let pose = &robot.start.pose;
    let radius = robot.drive.radius_m;
    let ring = |share: f64| view.circle(&Circle { center: pose.position, radius: share * radius });
    let name = &actuator.name;
    match &actuator.kind {
        ActuatorKind::Turret(servo) => {
            let (min, max) = (servo.min_rad, servo.max_rad);
            let title = format!("turret {name}: turns from {} to {} rad", handy(min), handy(max));
            canvas.open(Element::group().set("stroke", INNER).titled(&title));
            let sector = view.line(arc(pose, 0.46 * radius, min, max));
            canvas.put(
                drawn(&sector).set("fill", "none").set("stroke-width", "3.5").set("stroke-opacity", "0.45"),
            );
            let ends = [min, max].map(|end| {
                let at = |share: f64| arc(pose, share * radius, end, end).next().unwrap_or(pose.position);
                view.line([at(0.38), at(0.54)])
            });
            canvas.put(drawn(&ends.concat()).set("stroke-width", "1.4"));
            canvas.put(ring(0.28).set("fill", "none").set("stroke-width", "1.6"));
            canvas.close("g");
        }
        ActuatorKind::Lamp(Lamp { intensity_cd, .. }) => {
            let title = format!("lamp {name}: up to {} cd", handy(*intensity_cd));
            canvas.put(ring(0.09).set("fill", LAMP).set("stroke", LAMP_RIM).titled(&title));
        }
        ActuatorKind::Speaker(Speaker { level, .. }) => {
            let title = format!("loudspeaker {name}: up to {}", handy(*level));
            let back = Pose { heading: pose.heading + std::f64::consts::PI, ..*pose };
            let waves: String =
                [0.14, 0.2, 0.26].map(|share| view.line(arc(&back, share * radius, -0.7, 0.7))).concat();
            canvas.put(drawn(&waves).set("stroke", INK).set("fill", "none").titled(&title));
        }
        ActuatorKind::Dispenser(Dispenser { rate_per_s, .. }) => {
            let title = format!("dispenser {name}: up to {} each second", handy(*rate_per_s));
            canvas.put(ring(0.07).set("fill", INK).titled(&title));
        }
    }
}
