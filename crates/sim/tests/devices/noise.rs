//! Noise of all devices alike: none where there is to be none, and a stream of its own for each.

use baudbot_sim::World;

use crate::common::statistics::{SAMPLES, assert_distributed, assert_rate, correlation, normal};
use crate::common::{refusal, run, world, world_with};
use crate::devices::hostile::{act, everything};
use crate::devices::scene::{collect, named, scene, singles, specimens, view, with_sensor};

/// All that all sensors of all robots read in a run.
fn trace(overrides: &[&str], ticks: usize) -> Vec<Vec<Vec<f64>>> {
    // The doings of a person and the damage on a cable depend on the seed whether or not devices are noisy.
    let calm = everything(&["a", "b"]).replace("byte_error_rate = 0.0001", "byte_error_rate = 0.0").replace(
        "wander = { speed_m_s = 0.5, turn_s = 2.0 }",
        "stops = { points_m = [[4.5, 0.0], [4.5, 1.0]], speed_m_s = 0.5 }",
    );
    let mut world = world_with(&calm, overrides);
    (0..ticks)
        .map(|_| {
            world.begin();
            let all = world
                .robots()
                .flat_map(|robot| robot.sensors().map(|s| s.sample.to_vec()).collect::<Vec<_>>())
                .collect();
            act(&mut world, 1);
            all
        })
        .collect()
}

#[test]
fn without_noise_no_reading_of_any_device_depends_on_the_seed() {
    let one = trace(&["seed=1", "noise=false"], 300);
    let two = trace(&["seed=2", "noise=false"], 300);
    let names: Vec<_> = names();
    for (tick, (one, two)) in one.iter().zip(&two).enumerate() {
        for (i, (one, two)) in one.iter().zip(two).enumerate() {
            assert_eq!(one, two, "{} at tick {tick}", names[i]);
        }
    }
}

fn names() -> Vec<String> {
    let world = world(&everything(&["a", "b"]));
    world
        .robots()
        .flat_map(|robot| robot.spec().sensors.iter().map(|s| s.name.clone()).collect::<Vec<_>>())
        .collect()
}

#[test]
fn with_noise_every_noisy_device_depends_on_the_seed() {
    let one = trace(&["seed=1"], 200);
    let two = trace(&["seed=2"], 200);
    for (i, name) in names().into_iter().enumerate() {
        assert!(one.iter().zip(&two).any(|(one, two)| one[i] != two[i]), "{name} is the same for two seeds");
    }
}

#[test]
fn a_sensor_that_is_added_changes_no_others_noise() {
    let noisy = named("s", "kind = \"compass\"\nsigma_rad = 0.1");
    let other = named(
        "t",
        "kind = \"gyroscope\"\nrange_rad_s = 1.0\nnoise = { additive = 0.1, drift = { sigma = 0.1, time_constant_s = 1.0 } }",
    );
    let trace = |sensors: &str| collect(&scene("", "", sensors), 200);
    let alone = trace(&noisy);
    assert_eq!(alone, trace(&(noisy.clone() + &other)));
    assert_eq!(alone, trace(&(other + &noisy)));
}

#[test]
fn two_sensors_of_the_same_kind_have_independent_noise() {
    let compass = "kind = \"compass\"\nsigma_rad = 0.1";
    let mut world = world(&scene(
        "step_ms = 0.05",
        "firmware = { mode = \"poll\" }",
        &(named("s", compass) + &named("t", compass)),
    ));
    let pairs: Vec<_> = (0..20_000)
        .map(|_| {
            world.begin();
            let pair = (view(&world, "s").sample[0], view(&world, "t").sample[0]);
            world.finish(&[]);
            pair
        })
        .collect();
    assert!(correlation(&pairs).abs() < 0.025, "{}", correlation(&pairs));
}

#[test]
fn two_robots_of_the_same_make_have_independent_noise() {
    let robot = with_sensor("step_ms = 0.05", "kind = \"compass\"\nsigma_rad = 0.1");
    let other = with_sensor("", "kind = \"compass\"\nsigma_rad = 0.1\n")
        .replace("name = \"r\"", "name = \"z\"\nstart = { x_m = 2.0 }");
    let mut world = world(&(robot + &other));
    let pairs: Vec<_> = (0..20_000)
        .map(|_| {
            world.begin();
            let read = |world: &World, i: usize| world.robot(i).sensors().next().unwrap().sample[0];
            let pair = (read(&world, 0), read(&world, 1));
            world.finish(&[]);
            pair
        })
        .collect();
    assert!(correlation(&pairs).abs() < 0.025, "{}", correlation(&pairs));
}

#[test]
fn dropouts_and_spikes_come_at_their_rates() {
    let sensor =
        |noise: &str| with_sensor("step_ms = 0.05", &format!("kind = \"compass\"\nnoise = {{ {noise} }}"));
    let values = singles(&sensor("dropout = { probability = 0.1, value = 3.0 }"), SAMPLES);
    assert_rate(values.iter().filter(|&&v| v == 3.0).count() as u64, SAMPLES as u64, 0.1);
    let values = singles(&sensor("spikes = { probability = 0.1, magnitude = 2.0 }"), SAMPLES);
    assert_rate(values.iter().filter(|&&v| v != 0.0).count() as u64, SAMPLES as u64, 0.1);
}

#[test]
fn a_drift_is_stationary_over_specimens_and_forgets_itself_in_its_time() {
    let sensor = with_sensor(
        "step_ms = 10.0",
        "kind = \"compass\"\nnoise = { drift = { sigma = 0.2, time_constant_s = 0.5 } }",
    );
    let pairs: Vec<_> = (0..2000)
        .map(|seed| {
            let values = singles(&format!("seed = {seed}\n{sensor}"), 51);
            (values[0], values[50])
        })
        .collect();
    assert!((correlation(&pairs) - (-1.0_f64).exp()).abs() < 0.07, "{}", correlation(&pairs));
    for mut at in [pairs.iter().map(|p| p.0).collect::<Vec<_>>(), pairs.iter().map(|p| p.1).collect()] {
        let outcome = crate::common::statistics::kolmogorov_smirnov(&mut at, normal(0.0, 0.2));
        assert!(outcome.fits(), "{outcome:?}");
    }
}

#[test]
fn gains_are_a_specimens_and_stay() {
    let sensor =
        with_sensor("[arena]\nfloor = 0.5\n", "kind = \"floor\"\nmount = {}\nnoise = { gain_spread = 0.1 }");
    let mut gains = specimens(&sensor, 2000);
    let outcome = crate::common::statistics::kolmogorov_smirnov(&mut gains, normal(0.5, 0.05));
    assert!(outcome.fits(), "{outcome:?}");
    let values = singles(&sensor, 50);
    assert!(values.iter().all(|&v| v == values[0]));
}

#[test]
fn what_goes_on_the_wire_is_quantised_and_the_truth_is_not() {
    let toml = scene("step_ms = 1.0", "", &named("s", "kind = \"compass\"\nsigma_rad = 0.3\nbits = 8"));
    let mut world = world(&toml);
    for _ in 0..500 {
        world.begin();
        let (truth, told) = (view(&world, "s").sample[0], world.robot(0).readings()[0].values[0]);
        let step = std::f64::consts::TAU / 255.0;
        assert!((truth - told).abs() <= 0.5 * step + 1e-9, "{truth} and {told}");
        assert!(
            ((told + std::f64::consts::PI) / step)
                .fract()
                .min(1.0 - ((told + std::f64::consts::PI) / step).fract())
                < 1e-6
        );
        world.finish(&[]);
    }
}

#[test]
fn the_shorthand_of_a_compass_and_its_noise_are_not_both_given() {
    let message =
        refusal(&with_sensor("", "kind = \"compass\"\nsigma_rad = 0.1\nnoise = { additive = 0.2 }"));
    assert!(message.contains("sensors.s.sigma_rad: is short for noise.additive"), "{message}");
}

#[test]
fn noise_of_a_camera_is_that_of_each_column() {
    let camera = "kind = \"line-camera\"\nmount = {}\nopening_rad = 1.0\ncolumns = 3\nrange_m = 5.0\nnoise = { additive = 0.02 }";
    let images = collect(
        &with_sensor(&format!("step_ms = 0.05\n{}", crate::devices::scene::wall(2.0)), camera),
        SAMPLES,
    );
    let grey = 128.0 / 255.0;
    assert_distributed(&mut images.iter().map(|image| image[1]).collect::<Vec<_>>(), |scale| {
        normal(grey, 0.02 * scale)
    });
    assert_distributed(&mut images.iter().map(|image| image[10]).collect::<Vec<_>>(), |scale| {
        normal(2.0, 0.02 * scale)
    });
    let pairs: Vec<_> = images[..20_000].iter().map(|image| (image[0], image[10])).collect();
    assert!(correlation(&pairs).abs() < 0.025);
}

#[test]
fn noise_of_an_image_is_that_of_each_pixel() {
    let camera = "kind = \"camera\"\nmount = {}\nopening_rad = 1.0\ncolumns = 2\nrows = 1\nrange_m = 5.0\nnoise = { additive = 0.02 }";
    let top = format!("step_ms = 0.05\n{}", crate::devices::scene::wall(2.0));
    let images = collect(&with_sensor(&top, camera), SAMPLES);
    assert_distributed(&mut images.iter().map(|image| image[3]).collect::<Vec<_>>(), |scale| {
        normal(128.0 / 255.0, 0.02 * scale)
    });
    let pairs: Vec<_> = images[..20_000].iter().map(|image| (image[0], image[1])).collect();
    assert!(correlation(&pairs).abs() < 0.025);
}

#[test]
fn noise_needs_no_brain() {
    let toml = with_sensor("", "kind = \"compass\"\nsigma_rad = 0.1");
    let mut driven = world(&toml);
    let mut left = world(&toml);
    run(&mut driven, 50, 0.0, 0.0);
    for _ in 0..50 {
        left.begin();
        left.finish(&[]);
    }
    assert_eq!(view(&driven, "s").sample, view(&left, "s").sample);
}
