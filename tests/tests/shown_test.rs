//! The test that docs/how-to/ci.md shows, word for word.

#[test]
fn the_how_to_shows_this_test() {
    let (_, shown) = include_str!("shown_test.rs").split_once("// docs/how-to/ci.md:\n").unwrap();
    assert!(
        include_str!("../../docs/how-to/ci.md").contains(&format!("```rust\n{shown}```")),
        "docs/how-to/ci.md lacks:\n{shown}"
    );
}

// docs/how-to/ci.md:
use baudbot_client::{Action, Brain, Turn};
use baudbot_server::drive;

/// Drives on, and turns on the spot while something is near in front.
struct Timid;

impl Brain for Timid {
    fn step(&mut self, turn: &Turn) -> Action {
        let ahead = ["ir_front_left", "ir_front", "ir_front_right"];
        let is_near = |sensor| turn.value(sensor).is_none_or(|nearness| nearness > 0.2);
        let action =
            if ahead.into_iter().any(is_near) { Action::drive(0.5, -0.5) } else { Action::drive(0.4, 0.4) };
        // One command for each message, and another if none comes for 0.1 s: the cable may have lost the last.
        action.until_message_or(turn.at_ns + 100_000_000)
    }
}

#[test]
fn a_minute_without_a_collision() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = baudbot_scenario::parse(include_str!("../../catalogue/scenarios/wander.toml"))?;
    let drive = drive(&scenario, Timid, 60.0)?;
    assert!(drive.collisions.is_empty(), "{:?}", drive.collisions);
    assert!(drive.distance_m() > 10.0, "{} m", drive.distance_m());
    Ok(())
}
