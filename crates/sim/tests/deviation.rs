//! Robots whose wheels are not those of their data sheet: E_d, E_s and E_b of Borenstein & Feng 1996.

use baudbot_sim::World;

use crate::common::{refusal, run, world};

/// A robot of two servos, so that its wheels turn as commanded, with encoders, an odometer and a gyroscope.
fn robot(deviation: &str) -> String {
    format!(
        "step_ms = 10.0\n\
         [[robots]]\nname = \"r\"\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, half_track_m = 0.15{deviation} }}\n\
         motors = {{ kind = \"servo\", lag_ms = 0.0, frame_ms = 0.0, curve_us_rpm = [[1300.0, -60.0], [1700.0, 60.0]] }}\n\
         [robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 100000\n\
         [robots.sensors.odometer]\nkind = \"odometer\"\n\
         [robots.sensors.gyroscope]\nkind = \"gyroscope\"\nrange_rad_s = 10.0\n"
    )
}

/// The robot after so many ticks under these signals.
fn driven(deviation: &str, ticks: u64, left: f64, right: f64) -> World {
    let mut world = world(&robot(deviation));
    run(&mut world, ticks, left, right);
    world.begin();
    world
}

fn values(world: &World, sensor: usize) -> Vec<f64> {
    world.robot(0).sensors().nth(sensor).unwrap().sample.to_vec()
}

#[test]
fn unequal_wheels_bend_a_way_that_odometry_calls_straight() {
    let world = driven(", wheel_ratio = 1.01", 200, 0.5, 0.5);
    let (motion, counts) = (world.robot(0).motion(), values(&world, 0));
    assert_eq!(counts[0], counts[1]);
    assert!(values(&world, 1)[2].abs() < 1e-12, "{:?}", values(&world, 1));
    // The right wheel goes 2 E_d / (E_d + 1) of the way, the left one 2 / (E_d + 1).
    let way_m = motion.travel_m.left;
    let turned = way_m * 2.0 * 0.01 / 2.01 / 0.3;
    assert!(way_m > 0.5 && (motion.pose.heading - turned).abs() < 1e-9, "{motion:?}: {turned}");
    assert!(motion.pose.position.y > 0.0 && motion.pose.position.x < way_m, "{motion:?}");
}

#[test]
fn a_wider_track_turns_less_than_odometry_says() {
    let world = driven(", track_ratio = 1.25", 20, -0.25, 0.25);
    let motion = world.robot(0).motion();
    let said = values(&world, 1)[2];
    assert!(said > 0.1 && (motion.pose.heading * 1.25 - said).abs() < 1e-12, "{motion:?}: {said}");
    // A sensor of the body's motion is not deceived.
    let rate = values(&world, 2)[0];
    assert!((rate * 1.25 - motion.turn_rate_rad_s).abs() < 1e-3, "{rate}: {motion:?}");
}

#[test]
fn larger_wheels_go_farther_than_they_count() {
    let (equal, larger) = (driven("", 100, 0.5, 0.5), driven(", wheel_scale = 1.1", 100, 0.5, 0.5));
    assert_eq!(values(&equal, 0), values(&larger, 0));
    let way = |world: &World| (world.robot(0).motion().pose.position.x, world.robot(0).counters().distance_m);
    let ((x, driven), (farther_x, farther)) = (way(&equal), way(&larger));
    assert!((farther_x - 1.1 * x).abs() < 1e-9 && (farther - 1.1 * driven).abs() < 1e-9, "{x}: {farther_x}");
}

#[test]
fn slip_and_deviation_multiply() {
    let ice = "[[arena.zones]]\nname = \"ice\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 50.0\nslip = 0.5\n";
    let mut slippery = world(&(robot(", wheel_scale = 1.1") + ice));
    run(&mut slippery, 100, 0.5, 0.5);
    let x = |world: &World| world.robot(0).motion().pose.position.x;
    let equal = driven("", 100, 0.5, 0.5);
    assert!((x(&slippery) - 0.55 * x(&equal)).abs() < 1e-9, "{} and {}", x(&slippery), x(&equal));
}

#[test]
fn ones_change_no_bit_and_the_numbers_of_the_data_sheet_stay() {
    let ones = ", wheel_ratio = 1.0, wheel_scale = 1.0, track_ratio = 1.0";
    let [plain, same] = ["", ones].map(|deviation| driven(deviation, 100, 0.5, 0.2));
    assert_eq!(plain.hash(), same.hash());
    assert_eq!(same.robot(0).spec().drive.deviation, None);
    let other = driven(", wheel_ratio = 1.01, wheel_scale = 0.9, track_ratio = 1.1", 100, 0.5, 0.2);
    assert_ne!(plain.hash(), other.hash());
    let [sheet, same] = [&plain, &other].map(|world| world.robot(0).spec().drive.clone());
    assert_eq!((sheet.half_track_m, sheet.wheel_radius_m), (same.half_track_m, same.wheel_radius_m));
}

#[test]
fn factors_that_no_wheel_has_are_refused() {
    for field in ["wheel_ratio", "wheel_scale", "track_ratio"] {
        let message = refusal(&robot(&format!(", {field} = 0.0")));
        let expected = format!("robots[0].body.{field}: must be between 0.5 and 2, is 0");
        assert!(message.starts_with(&expected), "{message}");
    }
}
