//! Wheel encoders and the step counter.

use std::f64::consts::TAU;

use baudbot_sim::World;

use crate::common::statistics::assert_rate;
use crate::common::{run, world};
use crate::devices::scene::{first, named, scene, view, with_sensor};

fn driving(encoders: &str, top: &str) -> World {
    world(&scene(top, "", &named("s", &format!("kind = \"encoders\"\n{encoders}"))))
}

fn counts(world: &mut World) -> [f64; 2] {
    world.begin();
    let counts = view(world, "s").sample;
    let counts = [counts[0], counts[1]];
    world.finish(&[]);
    counts
}

/// The count of a wheel of 0.1 m that has rolled so far.
fn marks(travel_m: f64, per_turn: f64) -> f64 {
    (travel_m * per_turn / (TAU * 0.1)).floor()
}

/// An encoder with two detectors (§1.2.2): the right panel of Fig. 1.6.
#[test]
fn quadrature_encoders_count_both_ways() {
    let mut world = driving("counts_per_turn = 600", "");
    run(&mut world, 200, 0.5, 0.3);
    let travel = world.robot(0).motion().travel_m;
    assert_eq!(counts(&mut world), [marks(travel.left, 600.0), marks(travel.right, 600.0)]);
    run(&mut world, 600, -0.5, -0.5);
    let travel = world.robot(0).motion().travel_m;
    assert!(travel.left < -0.5, "{travel:?}");
    assert_eq!(counts(&mut world), [marks(travel.left, 600.0), marks(travel.right, 600.0)]);
}

/// The left panel of Fig. 1.6: one detector knows no direction.
#[test]
fn a_single_channel_counts_up_both_ways() {
    let mut world = driving("counts_per_turn = 100\nquadrature = false", "");
    let (mut expected, mut last) = (0.0, 0.0);
    for tick in 0..400 {
        let signal = if tick < 200 { 0.5 } else { -0.5 };
        world.begin();
        let passed = marks(world.robot(0).motion().travel_m.left, 100.0);
        expected += f64::abs(passed - last);
        last = passed;
        assert_eq!(view(&world, "s").sample[0], expected, "tick {tick}");
        crate::common::tick(&mut world, signal, signal);
    }
    assert!(expected > last.abs() + 20.0, "{expected} and {last}");
}

#[test]
fn marks_are_lost_with_their_probability() {
    let mut world = driving("counts_per_turn = 20000\nloss = 0.2", "");
    run(&mut world, 400, 0.6, 0.6);
    let passed = marks(world.robot(0).motion().travel_m.left, 20_000.0);
    let [left, right] = counts(&mut world);
    assert!(passed > 20_000.0, "{passed}");
    assert_rate((passed - left) as u64, passed as u64, 0.2);
    assert_ne!(left, right, "each wheel has its own luck");
}

#[test]
fn a_lossy_quadrature_encoder_loses_backwards_too() {
    let mut world = driving("counts_per_turn = 20000\nloss = 0.2", "");
    run(&mut world, 400, -0.6, -0.6);
    let passed = -marks(world.robot(0).motion().travel_m.left, 20_000.0);
    let [left, _] = counts(&mut world);
    assert_rate((passed + left) as u64, passed as u64, 0.2);
}

#[test]
fn without_noise_no_mark_is_lost() {
    let mut world = driving("counts_per_turn = 600\nloss = 0.2", "noise = false");
    run(&mut world, 200, 0.5, 0.5);
    let travel = world.robot(0).motion().travel_m;
    assert_eq!(counts(&mut world)[0], marks(travel.left, 600.0));
}

#[test]
fn a_counter_of_8_bits_wraps_on_the_wire() {
    let mut world = driving("counts_per_turn = 600\nbits = 8", "");
    for _ in 0..300 {
        world.begin();
        let (truth, told) = (view(&world, "s").sample[0], world.robot(0).readings()[0].values[0]);
        assert!((-128.0..128.0).contains(&told), "{told}");
        assert_eq!((truth - told).rem_euclid(256.0), 0.0, "{truth} and {told}");
        crate::common::tick(&mut world, 0.5, 0.5);
    }
    assert!(view(&world, "s").sample[0] > 400.0);
}

#[test]
fn encoders_count_more_than_the_robot_moves_on_slippery_ground() {
    let zone =
        "[[arena.zones]]\nname = \"ice\"\npoints_m = [[-5, -5], [5, -5], [5, 5], [-5, 5]]\nslip = 0.25\n";
    let mut world = driving("counts_per_turn = 600", zone);
    run(&mut world, 300, 0.5, 0.5);
    let motion = *world.robot(0).motion();
    let moved = motion.pose.position.x;
    assert!((moved / motion.travel_m.left - 0.75).abs() < 1e-6, "{moved} and {:?}", motion.travel_m);
    assert_eq!(counts(&mut world)[0], marks(motion.travel_m.left, 600.0));
}

#[test]
fn slip_under_one_wheel_turns_the_robot() {
    // The left wheel, at y = 0.2, stands on ice.
    let zone =
        "[[arena.zones]]\nname = \"ice\"\npoints_m = [[-9, 0.1], [9, 0.1], [9, 9], [-9, 9]]\nslip = 0.5\n";
    let mut world = driving("counts_per_turn = 600", zone);
    run(&mut world, 20, 0.5, 0.5);
    assert!(world.robot(0).motion().pose.heading > 0.0, "{:?}", world.robot(0).motion());
}

#[test]
fn a_step_counter_counts_commanded_steps_also_those_that_are_lost() {
    let wall = crate::devices::scene::wall(0.25);
    let robot = "motors = { kind = \"stepper\", steps_per_turn = 1000, full_rate_steps_s = 1000, max_acceleration_steps_s2 = 4000 }";
    let mut world = world(&scene(&wall, robot, &named("s", "kind = \"steps\"")));
    run(&mut world, 100, 1.0, 0.5);
    let [left, right] = counts(&mut world);
    // The first command acts in the first tick; both wheels were commanded to 10 and 5 steps a tick.
    assert!((left - 1000.0).abs() <= 1.0 && (right - 500.0).abs() <= 1.0, "{left} {right}");
    let rolled = world.robot(0).motion().travel_m.left * 1000.0 / (TAU * 0.1);
    assert!(rolled < 400.0, "held back at the wall after {rolled}");
}

#[test]
fn a_standing_robot_has_counted_nothing() {
    assert_eq!(first(&with_sensor("", "kind = \"encoders\"\ncounts_per_turn = 600")), [0.0, 0.0]);
}
