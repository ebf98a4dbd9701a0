//! Actuators besides the wheels.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use toml::Table;

use super::error::Sheet;
use baudbot_fields::number::{Number, UpTo};
use baudbot_fields::{FieldError, Fields, Path};
use baudbot_sim::actuator::{Actuator, ActuatorKind, Dispenser};
use baudbot_sim::surroundings::Surroundings;

/// The kind of actuator. Default: required.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) enum RawActuatorKind {
    Turret,
    Lamp,
    Speaker,
    Dispenser,
}

/// The fields of a dispenser.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawDispenser {
    /// Field that it adds to. Range: name of one of the arena's fields with a `trail`.
    field: String,
    /// Amount that it lays down each second at signal 1: so much raises the field by 1 on a square metre.
    rate_per_s: Number<UpTo<1_000_000>>,
}

type Result<T> = core::result::Result<T, FieldError>;

/// The actuator of this name.
pub(super) fn actuator(
    path: &Path,
    name: String,
    mut table: Table,
    surroundings: &Surroundings,
) -> Result<Actuator> {
    let kind = table.remove("kind").ok_or_else(|| {
        path.field("kind")
            .error("is missing; an actuator is a `turret`, a `lamp`, a `speaker` or a `dispenser`")
    })?;
    let kind: RawActuatorKind = Sheet::from(kind).read(&path.field("kind"))?;
    let fields = Sheet::from(table);
    let kind = match kind {
        RawActuatorKind::Turret => ActuatorKind::Turret(fields.read(path)?),
        RawActuatorKind::Lamp => ActuatorKind::Lamp(fields.read(path)?),
        RawActuatorKind::Speaker => ActuatorKind::Speaker(fields.read(path)?),
        RawActuatorKind::Dispenser => {
            ActuatorKind::Dispenser(dispenser(path, &fields.read(path)?, surroundings)?)
        }
    };
    Ok(Actuator { name, kind })
}

fn dispenser(path: &Path, raw: &RawDispenser, surroundings: &Surroundings) -> Result<Dispenser> {
    let fields = &surroundings.fields;
    let trails = fields.iter().filter(|field| field.trail.is_some()).map(|field| field.name.as_str());
    let field = fields.iter().position(|field| field.name == raw.field && field.trail.is_some()).ok_or_else(
        || {
            let known = trails.collect::<Vec<_>>().join(", ");
            let known = if known.is_empty() { "none" } else { &known };
            path.field("field")
                .error(format!("the arena has no field `{}` with a `trail`; there are: {known}", raw.field))
        },
    )?;
    Ok(Dispenser { field, rate_per_s: raw.rate_per_s.get() })
}
