//! What a person does to the buttons, switches and potentiometers of a robot's board.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::number::{Between, Number, Seconds, Share};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::chip::{Control, Operation};
use baudbot_sim::time::SimTime;

use crate::context::Lasting;

/// A press of a button, or another operation of a control.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawOperation {
    /// Instant of the operation.
    at_s: Number<Seconds<Between<0, 100_000_000>>>,
    /// The control on a pin, such as `buttons.start`.
    control: String,
    /// Position that it is brought to: 1.0 of a closed switch, the fraction of a potentiometer's way. Default: 1.0.
    position: Option<Number<Share>>,
    /// Time after which it is brought back to 0.0. Default: 0.2 of a button; others stay where they are.
    for_s: Option<Number<Seconds<Lasting>>>,
}

/// The controls of these names, with what is done to each. Of what is done at one instant the last counts.
pub(super) fn controls(
    path: &Path,
    raw: &[RawOperation],
    names: Vec<String>,
) -> Result<Vec<Control>, FieldError> {
    if raw.len() > MAX_OPERATIONS {
        return Err(
            path.error(format!("has {} operations; at most {MAX_OPERATIONS} are possible", raw.len()))
        );
    }
    let mut controls: Vec<_> =
        names.into_iter().map(|name| Control { name, operations: Vec::new() }).collect();
    for (i, operation) in raw.iter().enumerate() {
        let place = controls.iter().position(|control| control.name == operation.control);
        let Some(place) = place else {
            let at = path.index(i).field("control");
            return Err(at.error(unknown(&operation.control, &controls)));
        };
        let at = SimTime::from_ns(operation.at_s.get());
        let is_button = operation.control.starts_with(BUTTONS);
        let for_ns = operation.for_s.map(Number::get).or_else(|| is_button.then_some(PRESS_NS));
        let position = operation.position.map_or(1.0, Number::get);
        let operations = &mut controls[place].operations;
        operations.push(Operation { at, position });
        operations.extend(for_ns.map(|for_ns| Operation { at: at + for_ns, position: 0.0 }));
    }
    for control in &mut controls {
        control.operations.sort_by_key(|operation| operation.at);
    }
    Ok(controls)
}

fn unknown(name: &str, controls: &[Control]) -> String {
    let names: Vec<_> = controls.iter().map(|control| &*control.name).collect();
    if names.is_empty() {
        return format!(
            "no pin has the control `{name}`; connect it: pins.2 = \"buttons.start\", \"switches.NAME\" or \"potentiometers.NAME\""
        );
    }
    format!("no pin has the control `{name}`; there are {}", names.join(", "))
}

/// How the names of buttons begin.
pub(super) const BUTTONS: &str = "buttons.";

/// Most operations of a robot's controls.
const MAX_OPERATIONS: usize = 1000;

/// A finger presses a button for so long.
const PRESS_NS: u64 = 200_000_000;
