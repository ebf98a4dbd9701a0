use baudbot_geometry::{Circle, Point};

use super::*;
use crate::localization::test_arena::{self, error, free_pose, noisy_scan, office, quantile, rectangle, urg};

const EXACT: Parameters =
    Parameters { noise_m: 0.0, noise_ratio: 0.01, starts: 8, enough: 0.98, scans: 60, all_scans: 1000 };

/// A guess whose stated certainty fits an error of up to 0.2 m and 0.2 rad.
fn guess(pose: Pose) -> Estimate {
    guess_within(pose, 0.2)
}

fn guess_within(pose: Pose, most: f64) -> Estimate {
    Estimate::within(pose, most / 3.0_f64.sqrt(), most / 3.0_f64.sqrt())
}

/// The distance of the truth in standard deviations, squared: χ² of three degrees of freedom.
fn surprise(found: &Estimate, truth: &Pose) -> f64 {
    let off = difference(truth, &found.world_from_robot);
    off.dot(&(found.covariance.try_inverse().unwrap() * off))
}

/// Searches from guesses off by up to so many metres and radians, with the true poses.
fn searches(most: f64, noise: f64, parameters: &Parameters, count: usize) -> Vec<(Refined, Pose)> {
    let (map, laser, mut chance) = (office(), urg(171), Chance::new(1, "searches"));
    let search = |_| {
        let truth = free_pose(&map, &mut chance);
        let scan = noisy_scan(&laser, &map, &truth, noise, &mut chance);
        let start = guess_within(test_arena::moved(&truth, most, most, &mut chance), most);
        (refine(&map, &scan, &start, parameters, &mut chance), truth)
    };
    (0..count).map(search).collect()
}

#[test]
fn who_watches_is_told_of_each_pose_and_changes_nothing() {
    let (map, truth) = (office(), Pose::new(2.0, 2.0, 0.5));
    let scan = noisy_scan(&urg(171), &map, &truth, 0.01, &mut Chance::new(1, "noise"));
    let start = guess_within(Pose::new(3.0, 1.2, 1.7), 1.0);
    let parameters = Parameters { starts: 3, enough: 2.0, all_scans: 1000, ..Parameters::default() };
    let mut tried: Vec<Tried> = Vec::new();
    let found = refine_watched(&map, &scan, &start, &parameters, &mut Chance::new(1, "search"), |pose| {
        tried.push(*pose);
    });
    assert_eq!(found, refine(&map, &scan, &start, &parameters, &mut Chance::new(1, "search")));
    assert_eq!((tried.len(), tried[0].world_from_robot), (found.scans, start.world_from_robot));
    let ends: Vec<_> =
        (0..=3).map(|start| tried.iter().rfind(|tried| tried.start == start && tried.accepted)).collect();
    // The narrow loss is that of all ends, so that the least of their sums is the result.
    let best = ends.iter().flatten().min_by(|a, b| a.error.total_cmp(&b.error)).unwrap();
    assert_eq!((ends.iter().flatten().count(), best.world_from_robot), (4, found.estimate.world_from_robot));
    assert!(tried.iter().any(|tried| !tried.accepted));
}

#[test]
fn slopes_are_those_of_small_steps() {
    let pillar = Circle { center: Point::new(3.0, 1.2), radius: 0.5 };
    let map = Map::new(rectangle([0.0, 0.0, 4.0, 3.0]), vec![pillar]).unwrap();
    let robot_from_laser = Pose::new(0.15, -0.1, 0.4);
    let laser =
        VirtualLaser::like(&Scan { robot_from_laser, ..urg(50).scan(&map, &Pose::new(0.0, 0.0, 0.0)) });
    let pose = Pose::new(1.1, 1.3, -0.7);
    let lever = laser.world_from_laser(&pose).position - pose.position;
    let step = 1e-6;
    let after = |axis: usize, step: f64| {
        let mut by = Vector3::zeros();
        by[axis] = step;
        laser.scan(&map, &moved(&pose, &by)).distances_m
    };
    let mut checked = 0;
    for axis in 0..3 {
        let (before, behind) = (after(axis, -step), after(axis, step));
        for (i, echo) in laser.echoes(&map, &pose).enumerate() {
            let slope = echo.and_then(|echo| slope(&echo, &lever)).unwrap()[axis];
            let expected = (behind[i] - before[i]) / (2.0 * step);
            assert!(
                (slope - expected).abs() < 1e-4 * expected.abs().max(1.0),
                "{axis} {i}: {slope} {expected}"
            );
            checked += 1;
        }
    }
    assert_eq!(checked, 150);
}

#[test]
fn a_scan_is_matched_to_millimetres_in_few_virtual_scans() {
    let found = searches(0.2, 0.01, &EXACT, 120);
    let errors: Vec<_> =
        found.iter().map(|(found, truth)| error(&found.estimate.world_from_robot, truth)).collect();
    let (m, rad): (Vec<_>, Vec<_>) = errors.into_iter().unzip();
    let scans: Vec<_> = found.iter().map(|(found, _)| found.scans as f64).collect();
    let lost = m.iter().filter(|m| **m > 0.1).count();
    let figures = [quantile(&m, 0.5), quantile(&m, 0.9), quantile(&rad, 0.5), quantile(&scans, 0.5)];
    assert!(lost <= 5, "{lost} of 120 are lost");
    for (figure, most) in figures.into_iter().zip([0.0035, 0.0125, 0.001, 33.0]) {
        assert!(figure <= most, "{figures:?}");
    }
}

#[test]
fn without_noise_it_is_exact() {
    // A guess that hardly pulls, and no other start.
    let (map, laser, mut chance) = (office(), urg(171), Chance::new(2, "exact"));
    let mut errors = vec![];
    for _ in 0..60 {
        let truth = free_pose(&map, &mut chance);
        let start = Estimate::within(test_arena::moved(&truth, 0.2, 0.2, &mut chance), 100.0, 100.0);
        let parameters = Parameters { starts: 0, ..EXACT };
        let found = refine(&map, &laser.scan(&map, &truth), &start, &parameters, &mut chance);
        errors.push(error(&found.estimate.world_from_robot, &truth).0);
    }
    assert!(quantile(&errors, 0.5) < 1e-5, "{}", quantile(&errors, 0.5));
}

#[test]
fn its_covariance_is_honest() {
    let found = searches(0.2, 0.01, &EXACT, 120);
    let surprises: Vec<_> = found.iter().map(|(found, truth)| surprise(&found.estimate, truth)).collect();
    let median = quantile(&surprises, 0.5);
    assert!((1.8..3.0).contains(&median), "of χ² it is 2.37: {median}");
    // With only one wall in sight the pose stays as uncertain as it was, and the covariance has it. Few are truly
    // wrong.
    let wrong = surprises.iter().filter(|surprise| **surprise > 16.3).count();
    assert!(wrong <= 4, "{wrong} of 120, in place of 0.1 %");
}

#[test]
fn more_starts_find_what_one_misses() {
    let wrong = |starts| {
        let found = searches(0.5, 0.01, &Parameters { starts, ..EXACT }, 100);
        found.iter().filter(|(found, truth)| surprise(&found.estimate, truth) > 50.0).count()
    };
    let (one, many) = (wrong(0), wrong(8));
    assert!(2 * many < one, "{many} {one}");
}

#[test]
fn along_a_corridor_the_guess_decides() {
    let map = Map::new(rectangle([-15.0, -1.0, 15.0, 1.0]), vec![]).unwrap();
    let (truth, mut chance) = (Pose::new(0.0, 0.2, 0.3), Chance::new(3, "corridor"));
    let scan = noisy_scan(&urg(171), &map, &truth, 0.01, &mut chance);
    let found = refine(&map, &scan, &guess(Pose::new(0.1, 0.1, 0.35)), &EXACT, &mut chance).estimate;
    assert!((found.world_from_robot.position.x - 0.1).abs() < 0.02, "{found:?}");
    assert!((found.world_from_robot.position.y - 0.2).abs() < 0.01, "{found:?}");
    let [along, across] = [0, 1].map(|i| found.covariance[(i, i)].sqrt());
    assert!(along > 0.1 && across < 0.005, "{along} {across}");
}

#[test]
fn people_in_front_of_the_laser_bend_it_little() {
    let (map, truth, mut chance) = (office(), Pose::new(6.0, 5.0, 0.3), Chance::new(4, "people"));
    let mut scan = noisy_scan(&urg(171), &map, &truth, 0.01, &mut chance);
    for range in [20..45, 110..120] {
        scan.distances_m[range].iter_mut().for_each(|distance| *distance = distance.min(0.7));
    }
    let found = refine(&map, &scan, &guess(Pose::new(6.1, 4.9, 0.2)), &EXACT, &mut chance);
    assert!(error(&found.estimate.world_from_robot, &truth).0 < 0.01, "{found:?}");
    assert!((0.7..0.9).contains(&found.fit), "{found:?}");
}

#[test]
fn unknown_rays_and_an_empty_map_leave_the_guess() {
    let (map, mut chance) = (office(), Chance::new(5, "nothing"));
    let start = guess(Pose::new(2.0, 2.0, 0.5));
    let mut scan = urg(171).scan(&map, &start.world_from_robot);
    scan.distances_m.fill(f64::NAN);
    let found = refine(&map, &scan, &start, &EXACT, &mut chance);
    assert!((found.estimate.covariance - start.covariance).norm() < 1e-9);
    assert_eq!((found.estimate.world_from_robot, found.fit), (start.world_from_robot, 0.0));
    let nothing = Map::new(vec![], vec![]).unwrap();
    let scan = urg(171).scan(&map, &start.world_from_robot);
    let found = refine(&nothing, &scan, &start, &EXACT, &mut chance);
    assert_eq!(found.estimate.world_from_robot, start.world_from_robot);
    assert!((found.estimate.covariance - start.covariance).norm() < 1e-9);
    assert!(found.fit < 0.5, "{found:?}");
}
