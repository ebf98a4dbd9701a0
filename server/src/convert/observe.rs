//! Worlds and frames for observers.

use baudbot_proto::v1;
use baudbot_sim::actuator::ActuatorState;
use baudbot_sim::arena::{Look, Pillar, Polygon};
use baudbot_sim::model::{Part, RobotSpec};
use baudbot_sim::movable::{Movable, MovableShape};
use baudbot_sim::mover::Mover;
use baudbot_sim::surroundings::{Field, Light, Region, Source, Zone};
use baudbot_sim::{Pose, Scenario, ThingView, World, sensor_columns};

use super::brain::description;
use super::{battery, pins, score};

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
    Some(v1::Look { height_m, red, green, blue, lower_edge_m: look.lower_edge_m })
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
        parts: spec.parts.iter().map(part).collect(),
    }
}

fn part(part: &Part) -> v1::BodyPart {
    v1::BodyPart { outline: Some(region(&part.outline)), look: look(&part.look) }
}

fn region(region: &Region) -> v1::Outline {
    match region {
        Region::Disc(disc) => {
            v1::Outline { points: Vec::new(), center: Some(point(&disc.center)), radius_m: disc.radius }
        }
        Region::Polygon(corners) => {
            v1::Outline { points: corners.iter().map(point).collect(), center: None, radius_m: 0.0 }
        }
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
    v1::Zone {
        zone: zone.name.clone(),
        outline: Some(region(&zone.region)),
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

/// The part of a frame that is the same for all observers: the truth at the start of a tick.
pub(crate) fn truth(world: &World) -> v1::WatchResponse {
    v1::WatchResponse {
        tick: world.tick(),
        time_ns: world.time().as_ns(),
        robots: (0..world.robots().len()).map(|i| robot_truth(world, i)).collect(),
        ending: world.ending().map(ToString::to_string).unwrap_or_default(),
        things: world.things().map(thing).collect(),
        score: score(world),
        ..Default::default()
    }
}

fn thing(ThingView { name, pose, blocked_ns, .. }: ThingView<'_>) -> v1::ThingTruth {
    let Pose { position, heading: heading_rad } = pose;
    v1::ThingTruth { thing: name.to_owned(), x_m: position.x, y_m: position.y, heading_rad, blocked_ns }
}

fn robot_truth(world: &World, index: usize) -> v1::RobotTruth {
    let robot = world.robot_at_start(index).unwrap_or_else(|| world.robot(index));
    let (motion, signals) = (robot.motion(), robot.signals());
    let mut samples = Vec::new();
    for (sensor, spec) in robot.sensors().zip(robot.spec().sensors.iter()) {
        let missing = spec.encodings.len() - sensor.sample.len();
        samples.extend(sensor.sample.iter().copied().chain(std::iter::repeat_n(f64::NAN, missing)));
    }
    let actuator =
        |state: &ActuatorState| v1::ActuatorTruth { signal: state.signal, angle_rad: state.angle_rad };
    v1::RobotTruth {
        x_m: motion.pose.position.x,
        y_m: motion.pose.position.y,
        heading_rad: motion.pose.heading,
        speed_m_s: motion.speed_m_s,
        turn_rate_rad_s: motion.turn_rate_rad_s,
        left_signal: signals.left,
        right_signal: signals.right,
        collided: robot.collided(),
        samples,
        battery: battery(&robot),
        actuators: robot.actuators().iter().map(actuator).collect(),
        in_zone_ns: world.score().in_zone_ns(index).to_vec(),
    }
}
