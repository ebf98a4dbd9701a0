//! Actuators besides the wheels.

use alloc::string::String;

use toml::Table;

use super::error::Sheet;
use baudbot_fields::{FieldError, Fields, Path};
use baudbot_sim::actuator::{Actuator, ActuatorKind};

/// The kind of actuator. Default: required.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) enum RawActuatorKind {
    Turret,
    Lamp,
    Speaker,
}

type Result<T> = core::result::Result<T, FieldError>;

/// The actuator of this name.
pub(super) fn actuator(path: &Path, name: String, mut table: Table) -> Result<Actuator> {
    let kind = table.remove("kind").ok_or_else(|| {
        path.field("kind").error("is missing; an actuator is a `turret`, a `lamp` or a `speaker`")
    })?;
    let kind: RawActuatorKind = Sheet::from(kind).read(&path.field("kind"))?;
    let fields = Sheet::from(table);
    let kind = match kind {
        RawActuatorKind::Turret => ActuatorKind::Turret(fields.read(path)?),
        RawActuatorKind::Lamp => ActuatorKind::Lamp(fields.read(path)?),
        RawActuatorKind::Speaker => ActuatorKind::Speaker(fields.read(path)?),
    };
    Ok(Actuator { name, kind })
}
