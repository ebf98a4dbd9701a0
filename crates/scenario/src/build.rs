//! The way from the raw file to a [`Scenario`]: every number is checked, then nothing can be wrong.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::Point;

use super::arena::{arena, surroundings};
use super::context::{self, Step};
use super::names::Names;
use super::robots;
use super::shapes::{disc, each};
use baudbot_fields::number::{Millis, Number, Rule};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::scenario::{End, Scenario, Source};

use super::{raw, things};
use baudbot_fields::printable::is_printable;
use baudbot_sim::arena::Arena;
use baudbot_sim::collision::CollisionPolicy;
use baudbot_sim::coverage::Floor;
use baudbot_sim::model::{OnLate, RobotSpec};
use baudbot_sim::movable::{Body, Movable};
use baudbot_sim::mover::{Mover, Path as Way};
use baudbot_sim::rules::Rules;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::surroundings::Surroundings;
use baudbot_sim::time::SimTime;

type Result<T> = core::result::Result<T, FieldError>;

pub(super) fn scenario(raw: raw::Scenario, source: Source) -> Result<Scenario> {
    let path = Path::root();
    let step = step(&path, &raw)?;
    let at = path.field("arena");
    let mut names = Names::default();
    let mut arena = arena(&at, &raw.arena, &mut names)?;
    let surroundings = surroundings(&at, &raw.arena, step.step_ns)?;
    let movers = each(&at, "movers", &raw.arena.movers, |path, raw| things::mover(path, raw, &mut names))?;
    let movables =
        each(&at, "movables", &raw.arena.movables, |path, raw| things::movable(path, raw, &mut names))?;
    let bodies = stand(&at, &movers, &movables, &arena)?;
    let mut world = context::World {
        step,
        seed: raw.seed,
        surroundings: &surroundings,
        arena: &mut arena,
        bodies: &bodies,
        serial_ports: Vec::new(),
    };
    let robots = robots::robots(&path.field("robots"), raw.robots, &mut world)?;
    Ok(Scenario {
        serial_ports: world.serial_ports,
        source,
        name: name(&path, raw.name)?,
        description: raw.description,
        seed: raw.seed,
        step_ns: step.step_ns,
        substeps: step.substeps as u32,
        noise: raw.noise,
        collision: collision(&path, &raw.collision, raw.wall_friction)?,
        rules: rules(&path, &raw.end, &raw.metrics, (&arena, &surroundings), &robots)?,
        end: end(raw.end),
        arena: arena.into(),
        surroundings,
        movers,
        movables,
        robots,
    })
}

fn collision(path: &Path, raw: &raw::Collision, friction: Option<f64>) -> Result<CollisionPolicy> {
    let policy = match raw {
        raw::Collision::Slide => {
            let friction = friction.unwrap_or(WOOD_ON_WOOD);
            if friction.is_nan() || friction < 0.0 {
                let problem = format!("must not be negative, is {friction}");
                return Err(path.field("wall_friction").error(problem));
            }
            return Ok(CollisionPolicy::Slide { friction });
        }
        raw::Collision::StopRun => CollisionPolicy::StopRun,
        raw::Collision::StopRobot => CollisionPolicy::StopRobot,
    };
    path.refuse(
        "wall_friction",
        friction.is_some(),
        "only robots that slide have it: collision = \"slide\"",
    )?;
    Ok(policy)
}

/// Coefficient of kinetic friction of wood on wood: Ling, Sanny & Moebs, *University Physics*, volume 1 (OpenStax 2016),
/// table 6.1, which has the same for metal on wood.
const WOOD_ON_WOOD: f64 = 0.3;

fn step(path: &Path, raw: &raw::Scenario) -> Result<Step> {
    let step_ms = raw.step_ms.get();
    let step_ns = Millis::<raw::Step>::value(step_ms);
    let substeps = u64::from(raw.substeps.get());
    if !step_ns.is_multiple_of(substeps) {
        let fits = |count: &u64| step_ns.is_multiple_of(*count);
        let below = (1..substeps).rev().find(fits).unwrap_or(1);
        let above = (substeps + 1..=context::MAX_SUBSTEPS).find(fits);
        let above = above.map(|above| format!(" or {above}")).unwrap_or_default();
        let problem = format!(
            "{substeps} substeps do not divide {step_ms} ms into whole nanoseconds; {below}{above} do"
        );
        return Err(path.field("substeps").error(problem));
    }
    Ok(Step { step_ns, substeps })
}

/// The movers and the pushed things at their starts: pushed things must stand free, of movers too. A door may sit in a
/// wall.
fn stand(path: &Path, movers: &[Mover], movables: &[Movable], arena: &Arena) -> Result<Vec<(String, Body)>> {
    let at_start = |mover: &Mover| (mover.name.clone(), mover.form().at(&mover.start));
    let mut bodies: Vec<_> = movers.iter().map(at_start).collect();
    let wanders = |mover: &Mover| matches!(mover.path, Way::Wander { .. });
    for (i, mover) in movers.iter().enumerate().filter(|(_, mover)| wanders(mover)) {
        if let Some(name) = things::stands_in((&mover.form(), &mover.start), arena, &[]) {
            let problem = format!("`{}` stands in `{name}`, so it could never wander", mover.name);
            return Err(path.field("movers").index(i).error(problem));
        }
    }
    for (i, movable) in movables.iter().enumerate() {
        let form = movable.shape.form();
        if let Some(name) = things::stands_in((&form, &movable.start), arena, &bodies) {
            return Err(path
                .field("movables")
                .index(i)
                .error(format!("`{}` stands in `{name}`", movable.name)));
        }
        bodies.push((movable.name.clone(), form.at(&movable.start)));
    }
    Ok(bodies)
}

fn end(raw: raw::End) -> End {
    let after = raw.after_s.map(|after| SimTime::from_ns(after.get()));
    End { after, goal: raw.goal.map(|goal| disc(goal.x_m, goal.y_m, goal.radius_m)) }
}

fn rules(
    path: &Path,
    end: &raw::End,
    metrics: &raw::Metrics,
    (arena, surroundings): (&Arena, &Surroundings),
    robots: &[RobotSpec],
) -> Result<Rules> {
    let (at, end_at) = (path.field("metrics"), path.field("end"));
    let starts: Vec<Point> = robots.iter().map(|robot| robot.start.pose.position).collect();
    let floor = |cell_m: Number<_>| Floor::new(arena, cell_m.get(), &starts);
    let floor = metrics.cell_m.map(floor).transpose();
    let floor = floor.map_err(|error| at.field("cell_m").error(format!("{error}")))?;
    let (covered, sensed) = (end.covered.map(Number::get), end.sensed.map(Number::get));
    if (covered.is_some() || sensed.is_some() || metrics.sensed_by.is_some()) && floor.is_none() {
        return Err(at.field("cell_m").error("is missing: the size of the floor's cells that are counted"));
    }
    if sensed.is_some() && metrics.sensed_by.is_none() {
        return Err(at.field("sensed_by").error("is missing: the name of the sensor whose rays are counted"));
    }
    can_end(&end_at, end, surroundings, robots)?;
    Ok(Rules {
        floor,
        sensed_by: metrics
            .sensed_by
            .as_deref()
            .map_or(Ok(Vec::new()), |name| sensed_by(&at, name, robots))?,
        sense_ns: metrics.sense_ms.map_or(USUAL_SENSE_NS, Number::get),
        collisions: end.collisions.map(Number::get),
        all_goals: end.all_goals,
        covered,
        sensed,
        battery_empty: end.battery_empty,
        missed_deadline: robots.iter().any(|robot| robot.deadline.on_late == Some(OnLate::End)),
    })
}

/// The default interval at which rays are counted, in nanoseconds.
const USUAL_SENSE_NS: u64 = 100_000_000;

/// Refuses ends that cannot come, or that have come already.
fn can_end(path: &Path, end: &raw::End, surroundings: &Surroundings, robots: &[RobotSpec]) -> Result<()> {
    if end.all_goals && !surroundings.zones.iter().any(|zone| zone.goal) {
        return Err(path.field("all_goals").error("no zone of the arena has goal = true"));
    }
    if end.battery_empty && robots.iter().all(|robot| robot.battery.is_none()) {
        return Err(path.field("battery_empty").error("no robot has a battery"));
    }
    Ok(())
}

/// A scenario's name, which lists and pictures show.
fn name(path: &Path, name: String) -> Result<String> {
    if name.chars().all(is_printable) {
        return Ok(name);
    }
    Err(path.field("name").error(format!("must be on one line and without control characters, is `{name}`")))
}

fn sensed_by(path: &Path, name: &str, robots: &[RobotSpec]) -> Result<Vec<Option<usize>>> {
    let looks = |sensor: &Sensor| sensor.device.fan().is_some() && sensor.device.range_m().is_some();
    let place =
        |robot: &RobotSpec| robot.sensors.iter().position(|sensor| sensor.name == name && looks(sensor));
    let places: Vec<_> = robots.iter().map(place).collect();
    if places.iter().all(Option::is_none) {
        return Err(path.field("sensed_by").error(format!("no robot has a sensor `{name}` with rays")));
    }
    let mut chosen = robots.iter().zip(&places).filter_map(|(robot, place)| robot.sensors.get((*place)?));
    if chosen.any(|sensor| sensor.device.mount().is_some_and(|mount| mount.elevation_rad.is_some())) {
        let problem = format!("the rays of `{name}` have an elevation; coverage is that of level rays");
        return Err(path.field("sensed_by").error(problem));
    }
    Ok(places)
}
