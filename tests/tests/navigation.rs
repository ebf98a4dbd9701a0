//! Ways to a goal, through cables.

use baudbot_tests::{InProcess, WANDER, scenario};

const WEDGE: &str = include_str!("../../catalogue/scenarios/wedge.toml");

/// The place of the wedge's robot after so many seconds, and the reason for the end of its run, if it ended.
fn wedge(brain: &str, y_m: f64, seconds: u64) -> ([f64; 2], Option<String>) {
    let start = format!("robots.robot.start.y_m={y_m}");
    let mut local = InProcess::new(scenario(WEDGE, &[&start]), brain).unwrap();
    local.run(seconds * 100);
    let at = local.world.robots().next().unwrap().motion().pose.position;
    ([at.x, at.y], local.world.ending().map(ToString::to_string))
}

/// Fig. 6.13, and the way out that the notes leave to waypoints.
#[test]
fn a_robot_that_is_locked_in_a_potential_field_gets_out() {
    let ([x, y], ending) = wedge("wedge:motor.follow.parameters.escape_after_s=0", 0.0, 60);
    assert!(
        ending.is_none() && (x - 0.385).abs() < 0.03 && y.abs() < 0.03,
        "it stays locked: {x} {y} {ending:?}"
    );
    for y_m in [-0.6, -0.3, 0.0, 0.3, 0.6] {
        let (at, ending) = wedge("wedge", y_m, 120);
        assert!(ending.as_ref().is_some_and(|ending| ending.contains("goal")), "{y_m}: {at:?} {ending:?}");
    }
}

/// Listing 5.4 across 9600 baud: D = 1 m, of which it leaves 2 % by construction.
#[test]
fn a_metre_is_driven_within_three_percent_at_9600_baud() {
    let odometer = "robots.robot.sensors.odometer={ kind = \"odometer\", sigma_m = 0.0001, bits = 16 }";
    let changes = [odometer, "robots.robot.firmware.period_ms=40.0"];
    let mut local = InProcess::new(scenario(WANDER, &changes), "navigate").unwrap();
    let at = |local: &InProcess| local.world.robots().next().unwrap().motion().pose.position;
    let from = at(&local);
    local.run(2000);
    let to = at(&local);
    let driven_m = (to.x - from.x).hypot(to.y - from.y);
    assert!((driven_m - 1.0).abs() < 0.03, "{driven_m}");
}
