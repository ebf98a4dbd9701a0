//! The test that README.md shows, word for word.

#[test]
fn the_readme_shows_this_test() {
    let (_, shown) = include_str!("readme.rs").split_once("// README.md:\n").unwrap();
    assert!(
        include_str!("../../README.md").contains(&format!("```rust\n{shown}```")),
        "README.md lacks:\n{shown}"
    );
}

// README.md:
use baudbot_client::{Action, Brain, Turn};
use baudbot_server::drive;

/// Drives on, and turns on the spot while something is near in front.
struct Timid;

impl Brain for Timid {
    fn step(&mut self, turn: &Turn) -> Action {
        match turn.value("ir_front") {
            None => Action::wait(), // nothing has arrived yet
            Some(nearness) if nearness > 0.2 => Action::drive(0.5, -0.5),
            Some(_) => Action::drive(0.4, 0.4),
        }
    }
}

#[test]
fn twenty_seconds_without_a_collision() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = baudbot_scenario::parse(include_str!("../../scenarios/wander.toml"))?;
    let drive = drive(&scenario, Timid, 20.0)?;
    assert!(drive.collisions.is_empty(), "{:?}", drive.collisions);
    assert!(drive.distance_m() > 2.0, "{} m", drive.distance_m());
    Ok(())
}
