//! Worlds and frames for observers.

use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::Scenario;
use baudbot_sim::actuator::ActuatorState;
use baudbot_sim::arena::{Look, Pillar, Polygon};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::movable::{Movable, MovableShape};
use baudbot_sim::mover::Mover;
use baudbot_sim::surroundings::{Field, Light, Region, Source, Zone};
use bytes::Bytes;
use prost::Message as _;

use super::brain::description;
use super::detail::detail;
use super::{battery, pins, score};
use crate::columns::sensor_columns;
use crate::frame::{Frame, Own, RobotTruth, Thing, Truth};

/// The description of a world: what stands still in it, and what moves.
pub(crate) fn world_description(scenario: &Scenario) -> v1::DescribeWorldResponse {
    let surroundings = &scenario.surroundings;
    v1::DescribeWorldResponse {
        scenario: scenario.name.clone(),
        description: scenario.description.clone(),
        step_ns: scenario.step_ns,
        polygons: scenario.arena.polygons().iter().map(polygon).collect(),
        circles: scenario.arena.pillars().iter().map(disc).collect(),
        robots: scenario.robots.iter().map(robot).collect(),
        things: scenario.movers.iter().map(mover).chain(scenario.movables.iter().map(movable)).collect(),
        zones: surroundings.zones.iter().map(zone).collect(),
        lights: surroundings.lights.iter().map(light).collect(),
        fields: surroundings.fields.iter().map(field).collect(),
    }
}

fn point(point: &(impl Into<[f64; 2]> + Copy)) -> v1::Point {
    let [x_m, y_m] = (*point).into();
    v1::Point { x_m, y_m }
}

fn look(look: &Look) -> Option<v1::Look> {
    let [red, green, blue] = look.color.map(u32::from);
    let height_m = Some(look.height_m).filter(|height| height.is_finite());
    Some(v1::Look { height_m, red, green, blue })
}

fn polygon(polygon: &Polygon) -> v1::Polygon {
    v1::Polygon {
        name: polygon.name.clone(),
        points: polygon.points.iter().map(point).collect(),
        solid: polygon.solid,
        closed: polygon.closed,
        look: look(&polygon.look),
    }
}

fn disc(pillar: &Pillar) -> v1::Disc {
    v1::Disc {
        name: pillar.name.clone(),
        center: Some(point(&pillar.circle.center)),
        radius_m: pillar.circle.radius,
        look: look(&pillar.look),
    }
}

fn robot(spec: &RobotSpec) -> v1::ObservedRobot {
    v1::ObservedRobot {
        robot: spec.name.clone(),
        radius_m: spec.drive.radius_m,
        sensor_columns: sensor_columns(spec),
        outline: spec.outline.iter().map(point).collect(),
        look: look(&spec.look),
        actuators: spec.actuators.iter().map(|actuator| actuator.name.clone()).collect(),
        description: Some(description(spec)),
        deadline_ns: spec.deadline.within_ns,
        pins: spec.chip.iter().flat_map(|chip| pins::signals(chip)).collect(),
    }
}

/// The outline of a polygon, or without corners that of a disc about its own origin.
fn outline<P: Into<[f64; 2]> + Copy>(corners: &[P], radius_m: f64) -> Option<v1::Outline> {
    let points: Vec<_> = corners.iter().map(point).collect();
    let disc = points.is_empty();
    let center = disc.then(v1::Point::default);
    Some(v1::Outline { points, center, radius_m: if disc { radius_m } else { 0.0 } })
}

fn mover(mover: &Mover) -> v1::ObservedThing {
    v1::ObservedThing {
        thing: mover.name.clone(),
        movable: false,
        outline: outline(&mover.outline, mover.radius_m),
        look: look(&mover.look),
    }
}

fn movable(movable: &Movable) -> v1::ObservedThing {
    let (corners, radius_m) = match &movable.shape {
        MovableShape::Ball { radius_m } => (&[][..], *radius_m),
        MovableShape::Box { outline } => (outline.as_slice(), 0.0),
    };
    v1::ObservedThing {
        thing: movable.name.clone(),
        movable: true,
        outline: outline(corners, radius_m),
        look: look(&movable.look),
    }
}

fn zone(zone: &Zone) -> v1::Zone {
    let outline = match &zone.region {
        Region::Disc(disc) => {
            v1::Outline { points: Vec::new(), center: Some(point(&disc.center)), radius_m: disc.radius }
        }
        Region::Polygon(corners) => {
            v1::Outline { points: corners.iter().map(point).collect(), center: None, radius_m: 0.0 }
        }
    };
    v1::Zone {
        zone: zone.name.clone(),
        outline: Some(outline),
        goal: zone.goal,
        charger_w: zone.charger_w,
        floor: zone.floor,
        slip: zone.slip,
        indoors: zone.indoors,
    }
}

fn light(light: &Light) -> v1::Light {
    v1::Light {
        light: light.name.clone(),
        position: Some(point(&light.position)),
        height_m: light.height_m,
        intensity_cd: light.intensity_cd,
        period_ns: light.blink_ns.map(|(period, _)| period),
        lit_ns: light.blink_ns.map(|(_, lit)| lit),
    }
}

fn field(field: &Field) -> v1::ScalarField {
    let (slope_x_per_m, slope_y_per_m) = field.slope_per_m;
    let source = |source: &Source| v1::FieldSource {
        position: Some(point(&source.position)),
        strength: source.strength,
        width_m: source.width_m,
    };
    v1::ScalarField {
        field: field.name.clone(),
        background: field.background,
        slope_x_per_m,
        slope_y_per_m,
        sources: field.sources.iter().map(source).collect(),
    }
}

/// A frame for an observer.
pub(crate) fn frame(Frame { truth, own }: Frame) -> v1::WatchResponse {
    let v1::WatchResponse { collisions, missed_frames, details, annotations, .. } = own_part(own);
    v1::WatchResponse { collisions, missed_frames, details, annotations, ..truth_part(truth) }
}

/// The part of a frame that is the same for all observers. With [`own_in_bytes`] behind it, it is a frame.
pub(crate) fn truth_in_bytes(truth: Truth) -> Bytes {
    truth_part(truth).encode_to_vec().into()
}

/// The part of a frame that is one observer's.
pub(crate) fn own_in_bytes(own: Own) -> Bytes {
    own_part(own).encode_to_vec().into()
}

fn truth_part(truth: Truth) -> v1::WatchResponse {
    v1::WatchResponse {
        tick: truth.tick,
        time_ns: truth.time.as_ns(),
        robots: truth.robots.into_iter().map(robot_truth).collect(),
        ending: truth.ending.unwrap_or_default(),
        things: truth.things.into_iter().map(thing).collect(),
        score: truth.score.map(score),
        ..Default::default()
    }
}

fn own_part(own: Own) -> v1::WatchResponse {
    let collisions = own.collisions.into_iter();
    v1::WatchResponse {
        collisions: collisions.map(|c| v1::Collision { robot: c.robot, with: c.with }).collect(),
        missed_frames: own.missed_frames,
        details: own.details.into_iter().map(detail).collect(),
        annotations: own.beliefs.iter().map(annotation).collect(),
        ..Default::default()
    }
}

fn annotation((robot, belief): &(usize, Arc<v1::Belief>)) -> v1::Annotation {
    v1::Annotation { robot: *robot as u32, belief: Some(v1::Belief::clone(belief)) }
}

fn thing(Thing { name, x_m, y_m, heading_rad, blocked_ns }: Thing) -> v1::ThingTruth {
    v1::ThingTruth { thing: name, x_m, y_m, heading_rad, blocked_ns }
}

fn robot_truth(truth: RobotTruth) -> v1::RobotTruth {
    v1::RobotTruth {
        x_m: truth.motion.pose.position.x,
        y_m: truth.motion.pose.position.y,
        heading_rad: truth.motion.pose.heading,
        speed_m_s: truth.motion.speed_m_s,
        turn_rate_rad_s: truth.motion.turn_rate_rad_s,
        left_signal: truth.signals.left,
        right_signal: truth.signals.right,
        collided: truth.collided,
        samples: truth.samples,
        battery: truth.battery.map(battery),
        actuators: truth
            .actuators
            .into_iter()
            .map(|ActuatorState { signal, angle_rad, .. }| v1::ActuatorTruth { signal, angle_rad })
            .collect(),
        in_zone_ns: truth.in_zone_ns,
    }
}
