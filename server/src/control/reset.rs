//! The scenario of a reset: that of the world with another seed, other starts, other numbers.

use std::collections::BTreeSet;
use std::sync::Arc;

use baudbot_brain::Body;
use baudbot_proto::v1;
use baudbot_scenario::Override;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use tonic::Status;

use super::create::{gone, parse_overrides, parsing_bytes, scenario_error};
use crate::limits::{Cancelled, ScenarioHeld};
use crate::message::WorldHandle;
use crate::quote::brief;

/// The scenario from which a world is to begin again, with the memory that is held for it until the world has it.
///
/// # Errors
/// If the request's fields are invalid, or change what brains have received. The world is unchanged then.
pub(crate) async fn scenario_of_reset(
    world: &WorldHandle,
    request: v1::ResetWorldRequest,
) -> Result<(Arc<Scenario>, Option<Arc<ScenarioHeld>>), Status> {
    let made = Arc::clone(world.made());
    if request.seed.is_none() && request.starts.is_empty() && request.overrides.is_empty() {
        return Ok((made, None));
    }
    let limits = world.limits().clone();
    let read = move |cancelled: &Cancelled| {
        let scenario = changed(&made, &request, cancelled)?;
        let held = limits.hold_scenario(&scenario)?;
        Ok((scenario, Some(held)))
    };
    world.limits().read(parsing_bytes(&world.made().source.toml), read).await?
}

fn changed(
    made: &Scenario,
    request: &v1::ResetWorldRequest,
    cancelled: &Cancelled,
) -> Result<Arc<Scenario>, Status> {
    let numbers = overrides(made, request)?;
    let starts = starts(made, &request.starts)?;
    let is_wanted = || !cancelled.is_so();
    let parse = |changes: &[Override]| baudbot_scenario::parse_while(&made.source.toml, changes, &is_wanted);
    let scenario = parse(&[&*numbers, &*starts].concat()).map_err(|error| {
        // The fault is in the new overrides if they alone are refused: all else has been parsed once.
        match parse(&numbers) {
            Err(error) => scenario_error("overrides", &error),
            Ok(_) => scenario_error("starts", &error),
        }
    })?;
    let scenario = scenario.ok_or_else(gone)?;
    keeps_promises(made, &scenario)?;
    Ok(scenario.into())
}

/// The changes with which the world was made, then those of the request but for its starts.
fn overrides(made: &Scenario, request: &v1::ResetWorldRequest) -> Result<Vec<Override>, Status> {
    let mut changes = parse_overrides(&made.source.overrides)?;
    changes.extend(parse_overrides(&request.overrides)?);
    if let Some(seed) = request.seed {
        if i64::try_from(seed).is_err() {
            return Err(Status::invalid_argument(format!("seed: must be 0 to 2^63 - 1, is {seed}")));
        }
        changes.push(own(&format!("seed={seed}"))?);
    }
    Ok(changes)
}

fn starts(made: &Scenario, starts: &[v1::RobotStart]) -> Result<Vec<Override>, Status> {
    let (mut changes, mut seen) = (Vec::new(), BTreeSet::new());
    for (i, v1::RobotStart { robot, x_m, y_m, heading_rad }) in starts.iter().enumerate() {
        if made.robots.binary_search_by(|spec| spec.name.cmp(robot)).is_err() {
            let robot = brief(robot);
            return Err(Status::not_found(format!("starts[{i}].robot: there is no robot `{robot}`")));
        }
        if !seen.insert(robot) {
            return Err(Status::invalid_argument(format!("starts[{i}].robot: `{robot}` is named twice")));
        }
        for (field, value) in [("x_m", x_m), ("y_m", y_m), ("heading_rad", heading_rad)] {
            if !value.is_finite() {
                let text = format!("starts[{i}].{field}: must be a finite number, is {value}");
                return Err(Status::invalid_argument(text));
            }
            // The number with `Debug` is a float in TOML, too, and the same one.
            changes.push(own(&format!("robots.{robot}.start.{field}={value:?}"))?);
        }
    }
    Ok(changes)
}

/// An override that is made here.
fn own(text: &str) -> Result<Override, Status> {
    Override::parse(text).map_err(|error| scenario_error("starts", &error))
}

/// Checks that brains which hold robots of the world know what there is to know of the new scenario, too.
fn keeps_promises(old: &Scenario, new: &Scenario) -> Result<(), Status> {
    let names =
        |scenario: &Scenario| scenario.robots.iter().map(|spec| spec.name.clone()).collect::<Vec<_>>();
    let field = if old.step_ns != new.step_ns {
        Some("step_ms".to_owned())
    } else if names(old) != names(new) {
        Some("robots".to_owned())
    } else {
        old.robots.iter().zip(&new.robots).find_map(|(old, new)| changed_field(old, new))
    };
    let Some(field) = field else { return Ok(()) };
    Err(Status::failed_precondition(format!(
        "overrides: {field}: brains get this only when they attach, so a reset cannot change it; make another world with \
         CreateWorld"
    )))
}

/// The first part of a robot's data sheet that differs, by its path in the scenario. The baud rate of the cable to its brain is
/// left out, since `SetBaud` changes it without the brain's knowledge, too.
fn changed_field(old: &RobotSpec, new: &RobotSpec) -> Option<String> {
    let (before, mut after) = (Body::from(old), Body::from(new));
    if before.baud.is_some() && after.baud.is_some() {
        after.baud = before.baud;
    }
    if before == after {
        return None;
    }
    let body = |body: &Body| [body.radius_m, body.half_track_m, body.wheel_radius_m];
    let firmware = |body: &Body| (body.firmware, body.motor_encoding);
    let link = |body: &Body| (body.baud, body.bits_per_character, body.onboard);
    let parts = [
        (".body", body(&before) != body(&after)),
        (".motors", before.motor_kind != after.motor_kind),
        (".actuators", before.actuators != after.actuators),
        (".sensors", before.sensors != after.sensors),
        (".firmware", firmware(&before) != firmware(&after)),
        (".link", link(&before) != link(&after)),
    ];
    let part = parts.into_iter().find(|(_, differs)| *differs).map_or("", |(part, _)| part);
    let sensors = before.sensors.iter().zip(&after.sensors);
    let sensor = match sensors.into_iter().find(|(before, after)| before != after) {
        Some((sensor, _)) if part == ".sensors" => format!(".{}", sensor.name),
        Some(_) | None => String::new(),
    };
    Some(format!("robots.{}{part}{sensor}", old.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_reads_a_scenario_for_a_client_that_has_gone() {
        let made = baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/wander.toml")).unwrap();
        let request = v1::ResetWorldRequest { seed: Some(7), ..Default::default() };
        assert_eq!(changed(&made, &request, &Cancelled::default()).unwrap().seed, 7);
        let gone = changed(&made, &request, &Cancelled::gone()).unwrap_err();
        assert_eq!(gone.code(), tonic::Code::Cancelled);
    }
}
