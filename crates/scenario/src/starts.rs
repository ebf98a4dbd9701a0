//! The starts of robots: one, or several that are alike but for this and their names. None may stand in anything.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Crowd, Pose, angle};

use super::context::World;
use super::names::Names;
use super::{raw, things};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::model::{RobotSpec, Start};

type Result<T> = core::result::Result<T, FieldError>;

/// The place of a robot in the file, for messages.
pub(super) struct Place {
    /// `robots[2]`, or `robots[2].starts[17]`.
    robot: Path,
    /// `robots[2].start`, or again `robots[2].starts[17]`.
    start: Path,
}

/// The number of robots that a table stands for.
pub(super) fn number(raw: &raw::Robot) -> usize {
    raw.starts.as_ref().map_or(1, Vec::len)
}

/// The robots that a table stands for: their places in the file, their names, and how they start.
///
/// The name of a table with several is no robot's, but taken all the same: overrides go by it.
pub(super) fn places(
    path: &Path,
    raw: &raw::Robot,
    names: &mut Names,
) -> Result<Vec<(Place, String, Start)>> {
    let table = names.take(&path.field("name"), &raw.name)?;
    let at = path.field("start");
    let Some(starts) = &raw.starts else {
        let none = raw::Start::default();
        let raw = raw.start.as_ref().unwrap_or(&none);
        if raw.name.is_some() {
            return Err(at.field("name").error("only one of several `starts` has a name of its own"));
        }
        return Ok(alloc::vec![(Place { robot: path.clone(), start: at }, table, start(raw))]);
    };
    if raw.start.is_some() {
        return Err(at.error("give either this or `starts`"));
    }
    let at = path.field("starts");
    if starts.is_empty() {
        return Err(at.error("is empty; there is a robot for each of them, so it needs at least one"));
    }
    let place = |(i, raw): (usize, &raw::Start)| {
        let at = at.index(i);
        let name = raw.name.clone().unwrap_or_else(|| numbered(&table, i));
        let name = names.take(&at.field("name"), &name)?;
        Ok((Place { robot: at.clone(), start: at }, name, start(raw)))
    };
    starts.iter().enumerate().map(place).collect()
}

/// The name of the robot at the start of index `i` that has none of its own.
pub(super) fn numbered(table: &str, i: usize) -> String {
    format!("{table}-{}", i + 1)
}

fn start(raw: &raw::Start) -> Start {
    Start {
        pose: Pose::new(raw.x_m.get(), raw.y_m.get(), angle::wrap(raw.heading_rad.get())),
        speed_m_s: raw.speed_m_s.get(),
        turn_rate_rad_s: raw.turn_rate_rad_s.get(),
        wheels_at_rest: raw.wheels_at_rest,
    }
}

/// Nothing may stand in the arena, in what moves or is pushed, or in another robot.
pub(super) fn stand_free(robots: &[(Place, RobotSpec)], context: &World<'_>) -> Result<()> {
    let disc = |spec: &RobotSpec| Circle { center: spec.start.pose.position, radius: spec.form().reach_m() };
    let mut crowd = Crowd::default();
    crowd.rebuild(robots.iter().map(|(_, spec)| disc(spec)));
    for (i, (place, spec)) in robots.iter().enumerate() {
        let (form, pose) = (spec.form(), &spec.start.pose);
        if let Some(name) = things::stands_in((&form, pose), context.arena, context.bodies) {
            let (size, at) = (form.reach_m(), pose.position);
            let problem = format!("at ({}, {}) a robot of radius {size} m stands in `{name}`", at.x, at.y);
            return Err(place.start.error(problem));
        }
        if let Some((other, spec)) = stands_in_robot(i, robots, &crowd).map(|i| &robots[i]) {
            let problem = format!("stands in {} (`{}`)", other.robot.as_str(), spec.name);
            return Err(place.start.error(problem));
        }
    }
    Ok(())
}

/// The first robot of those before robot `i` that it stands in.
fn stands_in_robot(i: usize, robots: &[(Place, RobotSpec)], crowd: &Crowd) -> Option<usize> {
    let body = |i: usize| robots[i].1.form().at(&robots[i].1.start.pose);
    let (own, disc) = (body(i), crowd.discs()[i]);
    let mut first = None;
    crowd.near(&disc, |j| {
        let is_first = j < i && first.is_none_or(|first| j < first);
        if is_first && crowd.discs()[j].overlaps_circle(&disc) && body(j).overlaps(&own) {
            first = Some(j);
        }
    });
    first
}
