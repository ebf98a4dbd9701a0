//! The part of the world that a picture shows.

use baudbot_geometry::{Bounds, Circle, Point, Pose, Vector, polygon};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::movable::MovableShape;
use baudbot_sim::mover::{Mover, Path};
use baudbot_sim::surroundings::Region;

/// The box around walls, things and robots, with a margin. Zones, lamps and bells widen it by a half at most: next to a sun
/// a kilometre away, a room would be a dot.
pub(super) fn of(scenario: &Scenario) -> Bounds {
    let core = core(scenario);
    let others = others(scenario);
    let all = match core {
        None => others.into_iter().reduce(|a, b| a.union(&b)),
        Some(core) => Some(others.iter().filter(|other| is_near(&core, other)).fold(core, |a, b| a.union(b))),
    };
    let nothing = Bounds { min: Point::new(-1.0, -1.0), max: Point::new(1.0, 1.0) };
    let all = all.map_or(nothing, |all| if has_walls(scenario) { all } else { grown(&all, reach(scenario)) });
    framed(&all)
}

/// The box around a robot's body at its start, whichever way it is turned.
pub(super) fn of_robot(robot: &RobotSpec) -> Bounds {
    of_disc(robot.start.pose.position, robot.drive.radius_m)
}

/// The box around a disc.
pub(super) fn of_disc(center: Point, radius: f64) -> Bounds {
    Bounds::of_circle(&Circle { center, radius })
}

/// A box with a margin in metres on each side.
pub(super) fn grown(bounds: &Bounds, by: f64) -> Bounds {
    let by = Vector::new(by, by);
    Bounds { min: bounds.min - by, max: bounds.max + by }
}

/// The distance of the farthest point of a movable body from its middle, in metres.
pub(super) fn radius(shape: &MovableShape) -> f64 {
    match shape {
        MovableShape::Ball { radius_m } => *radius_m,
        MovableShape::Box { outline } => polygon::bounding_radius(outline),
    }
}

fn core(scenario: &Scenario) -> Option<Bounds> {
    let arena = &scenario.arena;
    let polygons = arena.polygons().iter().filter_map(|polygon| Bounds::of_points(&polygon.points));
    let pillars = arena.pillars().iter().map(|pillar| Bounds::of_circle(&pillar.circle));
    let movers = scenario.movers.iter().map(of_mover);
    let movable = |thing: &baudbot_sim::movable::Movable| of_disc(thing.start.position, radius(&thing.shape));
    let movables = scenario.movables.iter().map(movable);
    let robots = scenario.robots.iter().map(of_robot);
    let goal = scenario.end.goal.iter().map(Bounds::of_circle);
    let all = polygons.chain(pillars).chain(movers).chain(movables).chain(robots).chain(goal);
    all.reduce(|a, b| a.union(&b))
}

fn of_mover(mover: &Mover) -> Bounds {
    let start = of_disc(mover.start.position, mover.radius_m);
    match &mover.path {
        Path::Stops { points, .. } => {
            points.iter().fold(start, |all, &point| all.union(&of_disc(point, mover.radius_m)))
        }
        Path::Swing { ends_rad: [from, to], .. } => {
            let share = |i: i32| from + (to - from) * f64::from(i) / 16.0;
            let poses = (0..=16).map(|i| Pose { heading: share(i), ..mover.start });
            let corner = |pose: Pose| mover.outline.iter().map(move |&corner| pose.transform(corner));
            Bounds::of_points(&poses.flat_map(corner).collect::<Vec<_>>()).unwrap_or(start)
        }
        Path::Wander { .. } => start,
    }
}

fn others(scenario: &Scenario) -> Vec<Bounds> {
    let around = &scenario.surroundings;
    let zones = around.zones.iter().filter_map(|zone| match &zone.region {
        Region::Disc(disc) => Some(Bounds::of_circle(disc)),
        Region::Polygon(points) => Bounds::of_points(points),
    });
    let lights = around.lights.iter().map(|light| of_disc(light.position, 0.0));
    let sources = around.fields.iter().flat_map(|field| &field.sources);
    zones.chain(lights).chain(sources.map(|source| of_disc(source.position, source.width_m))).collect()
}

fn is_near(core: &Bounds, other: &Bounds) -> bool {
    let (most, all) = (1.5 * core.size(), core.union(other).size());
    let size = most.x.max(most.y);
    all.x <= size && all.y <= size
}

fn has_walls(scenario: &Scenario) -> bool {
    !scenario.arena.polygons().is_empty() || !scenario.arena.pillars().is_empty()
}

/// The margin in a world without walls, in metres: sensors must have room for their fans.
fn reach(scenario: &Scenario) -> f64 {
    let of_robot = |robot: &RobotSpec| {
        let range = robot.sensors.iter().filter_map(|sensor| sensor.device.range_m()).fold(0.0, f64::max);
        range.clamp(3.0 * robot.drive.radius_m, 12.0 * robot.drive.radius_m)
    };
    scenario.robots.iter().map(of_robot).fold(0.0, f64::max)
}

/// A box with a margin that is neither too wide nor too high.
fn framed(bounds: &Bounds) -> Bounds {
    let size = bounds.size();
    let long = size.x.max(size.y).max(1e-6);
    let framed = grown(bounds, 0.03 * long);
    let lacking = framed.size().map(|side| (0.5 * (0.3 * long - side)).max(0.0));
    Bounds { min: framed.min - lacking, max: framed.max + lacking }
}
