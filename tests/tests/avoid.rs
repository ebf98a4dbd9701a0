//! `avoid` in `wander.toml`: ten simulated minutes without a collision, over 20 seeds.

use baudbot_tests::{InProcess, WANDER, scenario};

#[test]
fn avoid_drives_ten_minutes_over_20_seeds_without_a_collision() {
    for seed in 1..=20 {
        let mut local = InProcess::new(scenario(WANDER, &[&format!("seed={seed}")]), "avoid").unwrap();
        local.run(60_000);
        let robot = local.world.robot(0);
        assert_eq!(local.world.ending(), None, "seed {seed} at {}", local.world.time());
        assert_eq!(robot.counters().collisions, 0, "seed {seed}");
        // The robot must have driven, as one that stands does not collide.
        assert!(robot.counters().distance_m > 60.0, "seed {seed}: {} m", robot.counters().distance_m);
    }
}
