use baudbot_geometry::Point;

use super::*;
use crate::localization::test_arena::{error, noisy_scan, office, pillars, urg};

const FEW: Parameters = Parameters {
    particles: 500,
    beams: 43,
    alphas: [0.01, 0.01, 0.005, 0.005],
    noise_m: 0.1,
    noise_ratio: 0.01,
    outliers: 0.05,
    resample_below: 0.5,
    slow: 0.0,
    fast: 0.0,
};

fn chance(name: &str) -> Chance {
    Chance::new(1, name)
}

#[test]
fn motions_are_a_turn_a_way_and_a_turn() {
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {expected:?}");
    };
    near(turn_way_turn(&Pose::new(3.0, 4.0, 1.0)), [0.8_f64.asin(), 5.0, 1.0 - 0.8_f64.asin()]);
    near(turn_way_turn(&Pose::new(-3.0, 4.0, 0.0)), [-(0.8_f64.asin()), -5.0, 0.8_f64.asin()]);
    near(turn_way_turn(&Pose::new(0.0, 1e-9, 3.0)), [0.0, 1e-9, 3.0]);
}

#[test]
fn particles_spread_as_the_variances_say() {
    let parameters = Parameters { particles: 20_000, alphas: [0.01, 0.02, 0.005, 0.004], ..FEW };
    let start = Estimate::exact(Pose::new(1.0, 2.0, 0.0));
    let mut particles = Particles::around(&start, parameters, chance("spread"));
    particles.advance(&Pose::new(0.4, 0.0, 0.1));
    let found = particles.estimate();
    // No first turn, then the way, then the second turn.
    let [first, second] = [0.02 * 0.16, 0.01 * 0.01 + 0.02 * 0.16];
    let expected = [0.005 * 0.16 + 0.004 * 0.01, 0.16 * first, first + second];
    for (i, expected) in expected.into_iter().enumerate() {
        let ratio = found.covariance[(i, i)] / expected;
        assert!((ratio - 1.0).abs() < 0.06, "{i}: {ratio}");
    }
    assert!(error(&found.world_from_robot, &Pose::new(1.4, 2.0, 0.1)).0 < 0.003, "{found:?}");
}

#[test]
fn without_variance_all_go_the_same_way() {
    let parameters = Parameters { alphas: [0.0; 4], ..FEW };
    let mut particles =
        Particles::around(&Estimate::exact(Pose::new(1.0, 2.0, 3.0)), parameters, chance("same"));
    let then_from_now = Pose::new(-0.3, 0.1, 0.4);
    particles.advance(&then_from_now);
    let expected = Pose::new(1.0, 2.0, 3.0).compose(&then_from_now);
    for particle in particles.particles() {
        let (m, rad) = error(&particle.world_from_robot, &expected);
        assert!(m < 1e-12 && rad < 1e-12, "{particle:?}");
    }
}

#[test]
fn drawing_anew_keeps_the_share_of_each() {
    let mut particles =
        Particles::around(&Estimate::within(Pose::new(0.0, 0.0, 0.0), 1.0, 1.0), FEW, chance("share"));
    let sum: f64 = (0..500).map(f64::from).sum();
    for (i, particle) in particles.particles.iter_mut().enumerate() {
        *particle = Particle { world_from_robot: Pose::new(i as f64, 0.0, 0.0), weight: i as f64 / sum };
    }
    particles.resample(&office(), 0.0);
    for i in 0..500 {
        let is_it =
            |particle: &&Particle| particle.world_from_robot.position == Point::new(f64::from(i), 0.0);
        let count = particles.particles.iter().filter(is_it).count() as f64;
        // With one random number for all a share is rounded up or down, never more.
        assert!((count - 500.0 * f64::from(i) / sum).abs() < 1.0, "{i}: {count}");
    }
    assert!((particles.effective() - 500.0).abs() < 1e-6);
}

#[test]
fn one_scan_tells_which_particles_are_right() {
    let (map, truth) = (office(), Pose::new(6.0, 4.8, 0.3));
    let start = Estimate::within(Pose::new(6.1, 4.75, 0.35), 0.15, 0.1);
    let mut particles = Particles::around(&start, FEW, chance("one"));
    particles.see(&map, &noisy_scan(&urg(171), &map, &truth, 0.01, &mut chance("scan")));
    let found = particles.estimate();
    assert!(error(&found.world_from_robot, &truth).0 < 0.05, "{found:?}");
    assert!(found.position_sd_m() < 0.5 * start.position_sd_m(), "{found:?}");
    let sum: f64 = particles.particles().iter().map(|particle| particle.weight).sum();
    assert!((sum - 1.0).abs() < 1e-9 && particles.effective() > 200.0);
}

#[test]
fn headings_are_averaged_across_half_a_turn() {
    let start = Estimate::within(Pose::new(1.0, 1.0, std::f64::consts::PI), 0.01, 0.1);
    let found = Particles::around(&start, FEW, chance("wrap")).estimate();
    assert!(error(&found.world_from_robot, &start.world_from_robot).1 < 0.03, "{found:?}");
}

/// A robot that goes around in circles, seen from truth to truth; the last estimate and truth.
fn circle(particles: &mut Particles, map: &Map, start: Pose, scans: usize) -> (Estimate, Pose) {
    let (laser, mut chance) = (urg(171), chance("circle"));
    let mut truth = start;
    let then_from_now = Pose::new(0.2, 0.02, 0.2);
    for _ in 0..scans {
        truth = truth.compose(&then_from_now);
        particles.advance(&then_from_now);
        particles.see(map, &noisy_scan(&laser, map, &truth, 0.01, &mut chance));
    }
    (particles.estimate(), truth)
}

#[test]
fn a_robot_that_knows_nothing_finds_itself() {
    let map = office();
    let parameters = Parameters { particles: 4000, ..FEW };
    let mut particles = Particles::everywhere(&map, parameters, chance("lost"));
    let (found, truth) = circle(&mut particles, &map, Pose::new(6.0, 3.5, 0.3), 20);
    let (m, rad) = error(&found.world_from_robot, &truth);
    assert!(m < 0.1 && rad < 0.05, "{m} {rad}");
}

#[test]
fn a_robot_that_was_carried_away_is_found_by_strangers_only() {
    let map = office();
    let home = Estimate::within(Pose::new(2.5, 2.0, 0.3), 0.05, 0.05);
    let lost_m = |parameters| {
        let mut particles = Particles::around(&home, parameters, chance("carried"));
        let (found, truth) = circle(&mut particles, &map, home.world_from_robot, 20);
        assert!(error(&found.world_from_robot, &truth).0 < 0.1);
        let (found, truth) = circle(&mut particles, &map, Pose::new(6.0, 3.5, 0.3), 60);
        error(&found.world_from_robot, &truth).0
    };
    let parameters = Parameters { particles: 1000, ..FEW };
    let with = lost_m(Parameters { slow: 0.02, fast: 0.2, ..parameters });
    let without = lost_m(parameters);
    assert!(with < 0.1, "{with}");
    assert!(without > 1.0, "{without}");
}

#[test]
fn four_corners_that_look_alike_stay_four() {
    // The estimate is one of them, not their middle.
    let map = pillars();
    let parameters = Parameters { particles: 4000, ..FEW };
    let mut particles = Particles::everywhere(&map, parameters, chance("alike"));
    let truth = Pose::new(1.5, 0.3, 0.2);
    let mut noise = chance("scan");
    for _ in 0..3 {
        particles.advance(&Pose::new(0.0, 0.0, 0.001));
        particles.see(&map, &noisy_scan(&urg(171), &map, &truth, 0.01, &mut noise));
    }
    let found = particles.estimate();
    let quarter = Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    let nearest = (0..4).scan(truth, |pose, _| {
        *pose = quarter.compose(pose);
        Some(error(&found.world_from_robot, pose).0)
    });
    assert!(nearest.fold(f64::INFINITY, f64::min) < 0.15, "{found:?}");
}

#[test]
fn an_empty_map_and_a_scan_of_nothing_change_nothing() {
    let nothing = Map::new(vec![], vec![]).unwrap();
    let mut particles = Particles::everywhere(&nothing, FEW, chance("nothing"));
    let before = particles.clone();
    let mut scan = urg(171).scan(&nothing, &Pose::new(0.0, 0.0, 0.0));
    particles.see(&nothing, &scan);
    scan.distances_m.fill(f64::NAN);
    particles.see(&nothing, &scan);
    for (particle, before) in particles.particles().iter().zip(before.particles()) {
        assert!((particle.weight - before.weight).abs() < 1e-12, "{particle:?}");
    }
}
