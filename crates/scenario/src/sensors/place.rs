//! The place of a sensor on the robot.

use alloc::format;
use alloc::string::String;

use baudbot_geometry::{Direction, Pose};
use toml::Table;

use super::raw::{PLACE, Place};
use super::{Context, Path, Result, take};
use crate::error::Sheet;
use baudbot_fields::Fields;
use baudbot_fields::number::{Between, Number};
use baudbot_sim::actuator::ActuatorKind;
use baudbot_sim::sensor::Height;
use baudbot_sim::sensor::Mount;

/// Takes the fields for the mount out of a sensor's table: on the rim looking outwards, or anywhere looking any way.
pub(super) fn mount(path: &Path, table: &mut Table, context: &mut Context<'_>) -> Result<Mount> {
    let raw: Place = Sheet::from(take(table, &PLACE)).read(path)?;
    let pose = match (raw.bearing_rad, raw.mount) {
        (Some(bearing), None) => {
            let bearing = bearing.get();
            let rim = Direction::from_angle(bearing).vector() * context.radius_m;
            Pose::new(rim.x, rim.y, bearing)
        }
        (None, Some(mount)) => {
            let path = path.field("mount");
            // Farther out a sensor would look through walls that the body has not reached.
            let reach = 2.0 * context.radius_m;
            let x = path.within("x_m", mount.x_m, -reach, reach)?;
            Pose::new(x, path.within("y_m", mount.y_m, -reach, reach)?, mount.heading_rad.get())
        }
        _ => return Err(path.error("needs either `bearing_rad` (on the rim, looking outwards) or `mount`")),
    };
    let turret = raw.turret.map(|name| turret(path, &name, context)).transpose()?;
    let elevation_rad = raw.elevation_rad.map(Number::get);
    Ok(Mount { pose, turret, height: height(raw.height_m, context), elevation_rad })
}

/// The [`mount`] of a sensor that sits in the robot's centre and has a direction only.
pub(super) fn centre(path: &Path, table: &mut Table, context: &mut Context<'_>) -> Result<Mount> {
    let raw: Place = Sheet::from(take(table, &PLACE)).read(path)?;
    if raw.mount.is_some() || raw.turret.is_some() {
        return Err(path.error("is a part of the rim: it takes `bearing_rad`, no `mount` and no `turret`"));
    }
    let bearing = raw.bearing_rad.map_or(0.0, Number::get);
    let height = height(raw.height_m, context);
    let elevation_rad = raw.elevation_rad.map(Number::get);
    Ok(Mount { pose: Pose::new(0.0, 0.0, bearing), turret: None, height, elevation_rad })
}

fn height(height_m: Option<Number<Between<0, 100>>>, context: &mut Context<'_>) -> Height {
    context.arena.height(height_m.map_or(0.0, Number::get))
}

fn turret(path: &Path, name: &String, context: &Context<'_>) -> Result<usize> {
    let is_it = |actuator: &baudbot_sim::actuator::Actuator| {
        actuator.name == *name && matches!(actuator.kind, ActuatorKind::Turret(_))
    };
    context.actuators.iter().position(is_it).ok_or_else(|| {
        let problem = format!("there is no turret `{name}` among the robot's actuators");
        path.field("turret").error(problem)
    })
}
