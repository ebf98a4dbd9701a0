//! Worlds for experiments.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::Action;
use baudbot_run::{BareWorld, LockstepWorld};
use baudbot_scenario::ScenarioError;
use baudbot_sim::{Scenario, Turn, World};

/// A robot whose body does not matter: a disc of 50 mm.
pub(super) const DISC: &str =
    "body = { radius_m = 0.05, mass_kg = 10.0, inertia_kg_m2 = 1.0, wheel_radius_m = 0.1 }";

/// Worlds of one scenario, each with robots and devices of other specimens.
pub(super) fn specimens(toml: &str, n: u64) -> Result<impl Iterator<Item = World> + use<>, ScenarioError> {
    let scenario = baudbot_scenario::parse(toml)?;
    Ok((1..=n).map(move |seed| World::new(Arc::new(Scenario { seed, ..scenario.clone() }))))
}

/// The robot's radius, in metres.
pub(super) const RIM_M: f64 = 0.05;

/// A tick in which no brain does anything.
pub(super) fn idle(world: &mut World) {
    world.begin();
    world.finish(&[]);
}

/// Writes a command at this turn, at once.
pub(super) fn command(world: &mut BareWorld, turn: Turn, [left, right]: [f64; 2]) {
    let Ok(()) = world.act(turn, Action::drive(left, right).after(Duration::ZERO));
}
