//! The worlds of the kit.

use std::f64::consts::TAU;
use std::sync::Arc;

use baudbot_geometry::Pose;
use baudbot_sim::collision::CollisionPolicy;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Intervention, Scenario, SimTime, World};

use crate::error::KitError;

/// The name of the kit's world.
pub(crate) const WORLD: &str = "conform";

/// The length of a run.
const RUN: SimTime = SimTime::from_ns(10_000_000_000);

/// The second robot's brain thinks for so many ticks.
const SLOW: u64 = 5;

/// This scenario with one robot: it goes on for ten seconds, also if something is run into, as brains do that are told nonsense.
///
/// # Errors
/// There is no such robot.
pub(crate) fn alone(scenario: &Scenario, robot: Option<&str>) -> Result<Scenario, KitError> {
    let is_it = |spec: &&RobotSpec| robot.is_none_or(|name| spec.name == name);
    let Some(spec) = scenario.robots.iter().find(is_it) else {
        let robots = scenario.robots.iter().map(|spec| spec.name.clone()).collect();
        return Err(KitError::NoRobot { robot: robot.unwrap_or_default().to_owned(), robots });
    };
    let mut alone = scenario.clone();
    alone.robots = vec![spec.clone()];
    alone.serial_ports.clear();
    alone.collision = CollisionPolicy::StopRobot;
    alone.end.after = Some(RUN);
    alone.end.goal = None;
    Ok(alone)
}

/// The same with a second robot, at the nearest place that has room for it.
///
/// # Errors
/// There is no such place.
pub(crate) fn with_two(alone: &Scenario) -> Result<Scenario, KitError> {
    let mut two = alone.clone();
    let first = &alone.robots[0];
    // Robots are in the order of their names.
    let name = format!("{}_2", first.name);
    let mut second = RobotSpec { name: name.clone(), ..first.clone() };
    let mut model = (*second.model).clone();
    model.thinking_ns = SLOW * alone.step_ns;
    second.model = Arc::new(model);
    two.robots.push(second);
    let mut world = World::new(Arc::new(two.clone()));
    let start = first.start.pose;
    let room = (1..200_u32)
        .flat_map(|ring| (0..16_u32).map(move |turn| (f64::from(ring) * 0.1, f64::from(turn) / 16.0 * TAU)));
    for (distance_m, angle) in room {
        let (sin, cos) = angle.sin_cos();
        let pose = Pose::new(
            start.position.x + distance_m * cos,
            start.position.y + distance_m * sin,
            start.heading,
        );
        if world.intervene(&Intervention::PlaceRobot { robot: name.clone(), pose }).is_ok() {
            two.robots[1].start.pose = pose;
            return Ok(two);
        }
    }
    Err(KitError::NoRoom)
}
