use std::f64::consts::{FRAC_PI_2, PI, TAU};

use baudbot_brain::Component;
use baudbot_geometry::Twist;

use super::*;
use crate::test_body::{body, turn};

const HALF_TRACK_M: f64 = 0.17;

/// A millimetre a count.
const PARAMETERS: Parameters = Parameters {
    half_track_m: HALF_TRACK_M,
    m_per_count: [0.001; 2],
    modulus: None,
    variance_m2_per_m: 1e-4,
    past_ns: PAST_NS,
    calibration: Calibration::NONE,
};

fn odometry(parameters: Parameters, start: Pose) -> Odometry {
    let mut odometry = Odometry::new(parameters, 0, Estimate::exact(start));
    odometry.encoders(0, [0.0, 0.0]);
    odometry
}

#[track_caller]
fn assert_near(found: Pose, expected: Pose, tolerance: f64) {
    let apart = (found.position - expected.position).norm();
    let turned = baudbot_geometry::angle::difference(found.heading, expected.heading).abs();
    assert!(apart <= tolerance && turned <= tolerance, "{found:?} is not {expected:?}");
}

#[test]
fn a_straight_way_leads_along_the_heading() {
    let mut odometry = odometry(PARAMETERS, Pose::new(1.0, 2.0, 0.6));
    (1..=50_u32).for_each(|i| odometry.encoders(u64::from(i), [f64::from(40 * i); 2]));
    let expected = Pose::new(1.0 + 2.0 * 0.6_f64.cos(), 2.0 + 2.0 * 0.6_f64.sin(), 0.6);
    assert_near(odometry.estimate().world_from_robot, expected, 1e-12);
}

/// (2.5)–(2.9), where the wheels' speeds are constant and the integrals are known.
#[test]
fn an_arc_is_exact_however_few_readings_arrive() {
    // A quarter of a circle of 0.5 m to the left.
    let [left, right] = [-1.0, 1.0].map(|side| 1000.0 * FRAC_PI_2 * (0.5 + side * HALF_TRACK_M));
    for readings in [1_u32, 2, 7] {
        let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
        for i in 1..=readings {
            let part = f64::from(i) / f64::from(readings);
            odometry.encoders(u64::from(i), [left * part, right * part]);
        }
        assert_near(odometry.estimate().world_from_robot, Pose::new(0.5, 0.5, FRAC_PI_2), 1e-12);
    }
}

#[test]
fn turning_on_the_spot_stays_on_it() {
    let mut odometry = odometry(PARAMETERS, Pose::new(1.0, 1.0, 0.0));
    let way = 1000.0 * HALF_TRACK_M * PI / 3.0;
    (1..=3_u32).for_each(|i| odometry.encoders(u64::from(i), [-way * f64::from(i), way * f64::from(i)]));
    assert_near(odometry.estimate().world_from_robot, Pose::new(1.0, 1.0, PI), 1e-12);
}

#[test]
fn counters_wrap_forwards_and_backwards() {
    // The wire's counters of 8 bits go from -128 to 127.
    let mut odometry = odometry(Parameters { modulus: Some(256.0), ..PARAMETERS }, Pose::new(0.0, 0.0, 0.0));
    for (i, count) in [100.0, -56.0, 44.0, -112.0].into_iter().enumerate() {
        odometry.encoders(i as u64 + 1, [count; 2]);
    }
    assert_near(odometry.estimate().world_from_robot, Pose::new(0.4, 0.0, 0.0), 1e-12);
    for (i, count) in [44.0, -56.0, 100.0, 0.0, -100.0, 56.0].into_iter().enumerate() {
        odometry.encoders(i as u64 + 5, [count; 2]);
    }
    assert_near(odometry.estimate().world_from_robot, Pose::new(-0.2, 0.0, 0.0), 1e-12);
}

/// For k in m²/m, a way s and steps of δ: the heading's variance is q s with q = k / 2R²; across it is the sum of the
/// squared lever arms, q (s³/3 − s δ²/12); their covariance is q s²/2; along it is k s / 2.
#[test]
fn covariance_of_a_straight_way_is_that_of_the_closed_form() {
    let (k, s, steps) = (PARAMETERS.variance_m2_per_m, 2.0, 20_u32);
    let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
    (1..=steps).for_each(|i| odometry.encoders(u64::from(i), [f64::from(100 * i); 2]));
    let found = odometry.estimate().covariance;
    let (q, step) = (k / (2.0 * HALF_TRACK_M * HALF_TRACK_M), s / f64::from(steps));
    let across = q * (s * s * s / 3.0 - s * step * step / 12.0);
    let expected = [((0, 0), k * s / 2.0), ((1, 1), across), ((2, 2), q * s), ((1, 2), q * s * s / 2.0)];
    for (place, expected) in expected {
        assert!(
            (found[place] / expected - 1.0).abs() < 1e-9,
            "{place:?}: {} is not {expected}",
            found[place]
        );
    }
    assert!(found[(0, 1)].abs() < 1e-18 && found[(0, 2)].abs() < 1e-18);
    assert_eq!(found[(1, 2)], found[(2, 1)]);
}

#[test]
fn covariance_is_how_far_noisy_wheels_end_apart() {
    let mut chance = crate::Chance::new(1, "wheels");
    let k = PARAMETERS.variance_m2_per_m;
    let (mut seen, runs) = (nalgebra::Matrix3::zeros(), 2000);
    let quiet = drive_arc(|_| 0.0);
    for _ in 0..runs {
        let noisy = drive_arc(|way_m| {
            // The sum of twelve uniform deviates has variance 1.
            let normal = (0..12).map(|_| chance.uniform()).sum::<f64>() - 6.0;
            normal * (k * way_m).sqrt()
        });
        let (found, expected) = (noisy.world_from_robot, quiet.world_from_robot);
        let off = found.position - expected.position;
        let error = nalgebra::Vector3::new(off.x, off.y, found.heading - expected.heading);
        seen += error * error.transpose() / f64::from(runs);
    }
    for i in 0..3 {
        let ratio = seen[(i, i)] / quiet.covariance[(i, i)];
        // Five standard errors of a variance from so many runs.
        assert!((ratio - 1.0).abs() < 5.0 * (2.0 / f64::from(runs)).sqrt(), "{i}: {ratio}");
    }
}

/// A third of a circle in thirty steps, with an error added to each wheel's way.
fn drive_arc(mut error_m: impl FnMut(f64) -> f64) -> Estimate {
    let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
    let mut counts = [0.0; 2];
    for i in 1..=30 {
        for (count, way_m) in counts.iter_mut().zip([0.06, 0.08]) {
            *count += 1000.0 * (way_m + error_m(way_m));
        }
        odometry.encoders(i, counts);
    }
    odometry.estimate()
}

#[test]
fn earlier_poses_are_looked_up_between_readings() {
    let mut odometry = odometry(Parameters { past_ns: 2500, ..PARAMETERS }, Pose::new(0.0, 0.0, 0.0));
    (1..=5_u32).for_each(|i| odometry.encoders(u64::from(1000 * i), [f64::from(100 * i); 2]));
    let at = |at_ns| odometry.at(at_ns).map(|estimate| estimate.world_from_robot.position.x);
    assert!((at(4250).unwrap() - 0.425).abs() < 1e-12, "{:?}", at(4250));
    assert!((at(3000).unwrap() - 0.3).abs() < 1e-12, "{:?}", at(3000));
    assert!((at(9000).unwrap() - 0.5).abs() < 1e-12, "stands since the last reading");
    assert_eq!(at(1999), None, "forgotten");
    let sd = |at_ns| odometry.at(at_ns).unwrap().position_sd_m();
    assert!(sd(4000) < sd(4500) && sd(4500) < sd(5000));
}

#[test]
fn a_late_correction_moves_all_that_came_after() {
    // An arc, so that a turned start bends the rest of the way.
    let drive = |start: Estimate, from: u32| {
        let mut odometry = Odometry::new(PARAMETERS, u64::from(1000 * from), start);
        let counts = |i: u32| [f64::from(100 * i), f64::from(120 * i)];
        (from..=8).for_each(|i| odometry.encoders(u64::from(1000 * i), counts(i)));
        odometry
    };
    let better = Estimate::within(Pose::new(3.0, -1.0, 2.0), 0.01, 0.02);
    let mut late = drive(Estimate::exact(Pose::new(0.0, 0.0, 0.0)), 0);
    assert!(late.correct(3000, better));
    let direct = drive(better, 3);
    assert_near(late.estimate().world_from_robot, direct.estimate().world_from_robot, 1e-12);
    assert!((late.estimate().covariance - direct.estimate().covariance).norm() < 1e-15);
    assert_eq!(late.at_ns(), 8000);
    let before = late.clone();
    assert!(!late.correct(2000, better) && late == before, "what is newer is known better");
}

/// A scan that began before another was matched is corrected by how the robot went meanwhile.
#[test]
fn the_way_to_what_is_corrected_moves_with_it() {
    for at_ns in [3000, 3250, 5000, 7000] {
        let mut odometry = odometry(PARAMETERS, Pose::new(0.5, 0.0, 0.3));
        (1..=5_u32).for_each(|i| {
            odometry.encoders(u64::from(1000 * i), [100.0, 120.0].map(|way| way * f64::from(i)));
        });
        let pose = |odometry: &Odometry, at_ns| odometry.at(at_ns).unwrap().world_from_robot;
        let then_from_now = |odometry: &Odometry, from_ns, to_ns| {
            pose(odometry, from_ns).inverse().compose(&pose(odometry, to_ns))
        };
        let before = odometry.clone();
        let better = Estimate::within(Pose::new(3.0, -1.0, 2.0), 0.01, 0.02);
        assert!(odometry.correct(at_ns, better));
        assert_near(pose(&odometry, at_ns), better.world_from_robot, 1e-12);
        for (from_ns, to_ns) in [(0, 1000), (500, 2700), (2800, 3000), (2800, 3100), (3100, 4600), (0, 5000)]
        {
            let (old, new) =
                (then_from_now(&before, from_ns, to_ns), then_from_now(&odometry, from_ns, to_ns));
            assert_near(new, old, 1e-4);
        }
    }
}

#[test]
fn a_correction_between_readings_keeps_the_rest_of_the_step() {
    let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
    (1..=3_u32).for_each(|i| odometry.encoders(u64::from(1000 * i), [f64::from(100 * i); 2]));
    assert!(odometry.correct(1250, Estimate::exact(Pose::new(0.0, 5.0, FRAC_PI_2))));
    assert_near(odometry.estimate().world_from_robot, Pose::new(0.0, 5.175, FRAC_PI_2), 1e-12);
}

#[test]
fn a_reset_forgets_the_past_but_not_the_counts() {
    let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
    odometry.encoders(1000, [100.0; 2]);
    odometry.reset(Estimate::exact(Pose::new(7.0, 7.0, 0.0)));
    assert_eq!(odometry.at(999), None);
    odometry.encoders(2000, [150.0; 2]);
    assert_near(odometry.estimate().world_from_robot, Pose::new(7.05, 7.0, 0.0), 1e-12);
}

#[test]
fn only_the_changes_of_an_odometer_count() {
    let mut odometry = Odometry::new(PARAMETERS, 0, Estimate::exact(Pose::new(1.0, 1.0, FRAC_PI_2)));
    // The odometer's frame begins elsewhere, and its way has a corner that no arc has.
    let places = [(9.0, 9.0, PI), (8.0, 9.0, PI), (8.0, 8.0, -FRAC_PI_2)];
    for (i, (x, y, heading)) in places.into_iter().enumerate() {
        odometry.odometer(i as u64, Pose::new(x, y, heading));
    }
    // Ahead one, then to the left one, and turned to the left.
    assert_near(odometry.estimate().world_from_robot, Pose::new(0.0, 2.0, PI), 1e-12);
    assert!(odometry.estimate().heading_sd_rad() > 0.0);
}

#[test]
fn of_an_odometer_the_wheels_are_guessed_as_they_were() {
    let wheels = Step::of_wheels([0.3, 0.5], HALF_TRACK_M);
    let start = Estimate::exact(Pose::new(0.0, 0.0, 0.0));
    let [driven, guessed] = [wheels, Step::of_motion(wheels.then_from_now, HALF_TRACK_M)]
        .map(|s| s.apply(&start, HALF_TRACK_M, 1e-4));
    assert_near(guessed.world_from_robot, driven.world_from_robot, 1e-15);
    assert!((guessed.covariance - driven.covariance).norm() < 1e-15);
}

#[test]
fn a_data_sheet_says_what_a_count_is() {
    let mut body = body(&[("wheels", "encoders", 0.0), ("place", "odometer", 0.0)]);
    body.sensors[0].counts_per_turn = Some(500);
    let encoding = Encoding::Counter { bits: 16 };
    let component = Component { name: String::new(), unit: "1".to_owned(), encoding, count: 1 };
    body.sensors[0].components = vec![component; 2];
    let parameters = Parameters::of(&body, "wheels").unwrap();
    assert_eq!(parameters.modulus, Some(65536.0));
    assert_eq!(parameters.m_per_count, [TAU * 0.1 / 500.0; 2]);
    assert_eq!(Parameters::of(&body, "place").unwrap().modulus, None);
    assert_eq!(Parameters::of(&body, "nose"), None);
}

#[test]
fn a_turn_is_read_when_it_brings_something_new() {
    let mut body = body(&[("wheels", "encoders", 0.0), ("place", "odometer", 0.0)]);
    body.sensors[0].counts_per_turn = Some(500);
    let start = Estimate::exact(Pose::new(0.0, 0.0, 0.0));
    let mut odometry = Odometry::new(PARAMETERS, 0, start);
    let mut says =
        |at_ns, values: &[f64]| odometry.read(&turn(&body, at_ns, &[Some(values), None]), "wheels");
    assert!(says(10, &[5.0, 5.0]) && says(20, &[105.0, 105.0]));
    assert!(!says(30, &[200.0]), "half a reading is none");
    assert!(!says(30, &[200.0, f64::NAN]), "nor is nonsense");
    let mut old = turn(&body, 40, &[Some(&[300.0, 300.0]), None]);
    old.readings[0].as_mut().unwrap().readable = false;
    assert!(!odometry.read(&old, "wheels") && !odometry.read(&old, "place"));
    assert_near(odometry.estimate().world_from_robot, Pose::new(0.1, 0.0, 0.0), 1e-12);
    assert_eq!(odometry.at_ns(), 20);
}

/// The cable was out; the robot went on for a while and then stood, or the other way round.
#[test]
fn where_a_robot_was_while_nothing_came_for_long_nobody_knows_if_it_moved() {
    const MS: u64 = 1_000_000;
    let after_s = |seconds: f64, counts: [f64; 2]| {
        let mut odometry = odometry(PARAMETERS, Pose::new(0.0, 0.0, 0.0));
        odometry.encoders(100 * MS, [0.0; 2]);
        odometry.encoders(100 * MS + (1e9 * seconds) as u64, counts);
        odometry
    };
    let turned = [-100.0, 100.0];
    let odometry = after_s(2.0, turned);
    assert!(
        odometry.at(100 * MS).is_some() && odometry.at(2100 * MS).is_some() && odometry.at(50 * MS).is_some()
    );
    assert_eq!((odometry.at(1100 * MS), odometry.correctable(1100 * MS)), (None, None));
    let mut corrected = odometry.clone();
    assert!(
        !corrected.correct(1100 * MS, Estimate::exact(Pose::new(0.0, 0.0, 0.3))) && corrected == odometry
    );
    assert!(after_s(0.5, turned).at(300 * MS).is_some(), "not for long");
    assert!(after_s(2.0, [10.0, -10.0]).at(1100 * MS).is_some(), "hardly moved");
}

#[test]
fn a_track_has_the_same_poses_in_whatever_order() {
    let mut odometry = odometry(PARAMETERS, Pose::new(1.0, 2.0, 0.6));
    let ms = 1_000_000;
    for i in 1..=20_u32 {
        odometry.encoders(u64::from(i) * 20 * ms, [f64::from(i * i), f64::from(i * (30 - i))]);
    }
    odometry.correct(70 * ms, Estimate::exact(Pose::new(0.0, 0.0, 3.0)));
    let mut chance = crate::Chance::new(1, "track");
    let mut track = odometry.track();
    let at_random = (0..500).map(|_| (chance.uniform() * 450.0) as u64 * ms);
    for at_ns in (0..450).map(|at_ms| at_ms * ms + 1).chain(at_random) {
        let expected = odometry.at(at_ns).map(|estimate| estimate.world_from_robot);
        assert_eq!(track.pose_at(at_ns), expected, "{at_ns}");
    }
}

/// A robot whose right wheel is 2 % larger than the left one, and whose wheels are 5 % farther apart than in its data
/// sheet.
const MEASURED: Calibration = Calibration { wheels: [0.99, 1.0098], track: 1.05 };

#[test]
fn a_calibrated_robot_knows_its_wheels() {
    let mut odometry = odometry(Parameters { calibration: MEASURED, ..PARAMETERS }, Pose::new(0.0, 0.0, 0.0));
    odometry.encoders(1, [1000.0, 1000.0]);
    let turned = (1.0098 - 0.99) / (2.0 * 1.05 * HALF_TRACK_M);
    let expected = Twist { forward: 0.9999, turn: turned }.then_from_now();
    assert_near(odometry.estimate().world_from_robot, expected, 1e-12);
}

#[test]
fn what_an_odometer_reckons_wrong_is_reckoned_again() {
    let calibrated = Parameters { calibration: MEASURED, ..PARAMETERS };
    let [mut counts, mut told] =
        [0, 1].map(|_| Odometry::new(calibrated, 0, Estimate::within(Pose::new(0.0, 0.0, 0.0), 0.0, 0.0)));
    // The robot's own odometer believes the data sheet.
    let mut odometer_from_robot = Pose::new(3.0, -1.0, 2.0);
    counts.encoders(0, [0.0; 2]);
    told.odometer(0, odometer_from_robot);
    for (i, [left, right]) in [[400.0, 500.0], [900.0, 450.0], [-200.0, 300.0]].into_iter().enumerate() {
        let before = if i == 0 { [0.0; 2] } else { [[400.0, 500.0], [900.0, 450.0]][i - 1] };
        let ways_m = [0.001 * (left - before[0]), 0.001 * (right - before[1])];
        odometer_from_robot =
            odometer_from_robot.compose(&Twist::of_wheels(ways_m, HALF_TRACK_M).then_from_now());
        counts.encoders(i as u64 + 1, [left, right]);
        told.odometer(i as u64 + 1, odometer_from_robot);
    }
    assert_near(told.estimate().world_from_robot, counts.estimate().world_from_robot, 1e-12);
    assert!(counts.estimate().world_from_robot.position.coords.norm() > 0.05);
}
