//! Devices that look along rays: infrared, sonar, laser, line camera.

use std::f64::consts::FRAC_PI_2;

use crate::common::statistics::{SAMPLES, assert_distributed, assert_rate, chi_squared, normal};
use crate::common::{refusal, world};
use crate::devices::scene::{
    all_near, block, collect, first, named, near, scene, single, singles, view, wall, with_sensor,
};

const IR: &str =
    "kind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 0.5\nrays = 3\nrange_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1";

/// (3.12) and (3.13) for three rays at a wall `d` ahead of the sensor.
fn reflected(d: f64) -> f64 {
    let rho = |kappa: f64| {
        let along = d / kappa.cos();
        (kappa.cos() * (0.03 / (along * along) + 0.1)).min(1.0)
    };
    (rho(-0.25) + rho(0.0) + rho(0.25)) / 3.0
}

#[test]
fn an_ir_sensor_reads_the_mean_of_its_rays() {
    for d in [0.2, 0.3, 0.5, 0.9] {
        near(single(&with_sensor(&wall(0.2 + d), IR)), reflected(d));
    }
}

#[test]
fn an_ir_sensor_saturates_and_sees_nothing_beyond_its_range_or_behind_it() {
    near(single(&with_sensor(&wall(0.21), IR)), 1.0);
    near(single(&with_sensor(&wall(1.21), IR)), 0.0);
    let behind = block("back", [-0.4, -5.0, -0.3, 5.0], "");
    near(single(&with_sensor(&behind, IR)), 0.0);
    // The middle ray alone is still within the range at 0.99 m.
    near(single(&with_sensor(&wall(1.19), IR)), (0.03 / (0.99 * 0.99) + 0.1) / 3.0);
}

/// (3.13) near a wall, in numbers worked out by hand: each ray is limited to 1 before the mean is taken, and after its cosine.
#[test]
fn near_a_wall_each_ray_of_an_ir_sensor_is_limited_by_itself() {
    let read = |opening: &str, arena: &str| {
        single(&with_sensor(arena, &IR.replace("opening_rad = 0.5", &format!("opening_rad = {opening}"))))
    };
    // At 0.15 m the middle ray is 1.4333, so 1; those at ±1 rad go 0.277622 m and are 0.264335.
    let found = read("2.0", &wall(0.35));
    assert!((found - 0.509557).abs() < 1e-6, "{found}");
    // At 0.12 m those at ±0.5 rad are 1.4958, so 1 and not cos 0.5.
    near(read("1.0", &wall(0.32)), 1.0);
    // A post that one ray of three meets at 0.05 m: 12.1, so 1. The others see nothing.
    let post = block("post", [0.25, -0.001, 0.26, 0.001], "");
    near(read("0.5", &post), 1.0 / 3.0);
}

#[test]
fn what_is_exactly_as_far_as_an_ir_sensor_sees_is_not_seen() {
    let one = IR.replace("rays = 3", "rays = 1").replace("opening_rad = 0.5", "opening_rad = 0.0");
    let reading = |d: f64| single(&with_sensor(&wall(d), &one.replace("range_m = 1.0", "range_m = 0.3")));
    // 0.5 - 0.2 is 0.3 to the last bit.
    near(reading(0.5), 0.0);
    near(reading(0.5 - 1e-10), 0.03 / 0.09 + 0.1);
}

#[test]
fn an_ir_sensor_has_multiplicative_noise_3_1() {
    let toml = with_sensor(&format!("step_ms = 0.05\n{}", wall(0.6)), &format!("{IR}\nsigma = 0.05"));
    let truth = reflected(0.4);
    assert_distributed(&mut singles(&toml, SAMPLES), |scale| normal(truth, 0.05 * truth * scale));
}

const LOOKUP: &str = "kind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 0.0\nrays = 1\nrange_m = 1.0";

/// (3.2) of a whole sensor.
#[test]
fn a_lookup_interpolates_between_distances_and_holds_its_ends() {
    let table =
        format!("{LOOKUP}\nlookup = {{ distances_m = [0.1, 0.5], samples = [[[0.7, 0.9]], [[0.2]]] }}");
    for (d, expected) in [(0.1, 0.8), (0.3, 0.5), (0.5, 0.2), (0.05, 0.8), (0.7, 0.2), (3.0, 0.2)] {
        near(single(&with_sensor(&format!("noise = false\n{}", wall(0.2 + d)), &table)), expected);
    }
}

#[test]
fn a_lookup_interpolates_between_angles_of_incidence() {
    let samples = "lookup = { distances_m = [0.1, 0.5], angles_rad = [0.0, 1.0], samples = [[[0.8], [0.4]], [[0.4], [0.0]]] }";
    let look = LOOKUP.replace("bearing_rad = 0.0", "mount = { x_m = 0.2, heading_rad = 0.5 }");
    // 0.3 m along the ray; the wall's normal is 0.5 rad off.
    let toml = with_sensor(&wall(0.2 + 0.3 * 0.5_f64.cos()), &format!("{look}\n{samples}"));
    near(single(&toml), 0.4);
    // A pillar is met head-on.
    let pillar = "[[arena.circles]]\nname = \"p\"\nx_m = 0.6\ny_m = 0.0\nradius_m = 0.1\n";
    near(single(&with_sensor(pillar, &format!("{LOOKUP}\n{samples}"))), 0.6);
}

#[test]
fn a_lookup_chooses_each_sample_as_often_as_another() {
    let table = format!(
        "{LOOKUP}\nlookup = {{ distances_m = [0.1, 0.5], samples = [[[0.2, 0.4, 0.6, 0.8]], [[0.0]]] }}"
    );
    let toml = with_sensor(&format!("step_ms = 0.05\n{}", wall(0.25)), &table);
    let mut counts = [0; 4];
    for value in singles(&toml, 20_000) {
        let i = (value / 0.2).round() as usize - 1;
        near(value, 0.2 * (i + 1) as f64);
        counts[i] += 1;
    }
    let outcome = chi_squared(&counts, &[0.25; 4]);
    assert!(outcome.fits(), "{counts:?}: {outcome:?}");
}

#[test]
fn a_converter_of_8_bits_in_codes_of_10_makes_multiples_of_4_up_to_1020() {
    for (d, code) in
        [(0.05, 1020.0), (0.1, 1020.0), (0.2, 768.0), (0.3, 512.0), (0.401, 252.0), (0.499, 4.0), (0.7, 0.0)]
    {
        let table = format!(
            "{LOOKUP}\nbits = 10\nconverter_bits = 8\n\
             lookup = {{ distances_m = [0.1, 0.5], samples = [[[1.0]], [[0.0]]] }}"
        );
        near(1023.0 * single(&with_sensor(&wall(0.2 + d), &table)), code);
    }
}

#[test]
fn full_scale_is_the_code_of_a_reading_of_1() {
    let ir = format!("{IR}\nbits = 13\nfull_scale = 4505");
    let world = world(&with_sensor("", &ir));
    let encoding = world.robot(0).spec().sensors[0].encodings[0];
    assert_eq!([0.0, 0.5, 1.0].map(|reading| encoding.number(reading)), [Some(0), Some(2253), Some(4505)]);
    near(encoding.value_of(4505).unwrap(), 1.0);
}

fn lamp(x: f64, y: f64, intensity: f64) -> String {
    format!("[[arena.lights]]\nname = \"l\"\nx_m = {x:?}\ny_m = {y:?}\nintensity_cd = {intensity:?}\n")
}

/// Ambient light by an infra-red sensor (§1.2.2).
#[test]
fn an_ir_sensor_without_its_emitter_is_dark_at_1_and_0_in_the_light() {
    for rays in [1, 3] {
        let ambient = format!(
            "kind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 2.0\nrays = {rays}\nrange_m = 1.0\nambient_saturation_lux = 10.0"
        );
        let read = |top: &str| single(&with_sensor(top, &ambient));
        near(read(""), 1.0);
        // 8 cd at 2 m ahead: 2 lux; 0.9 rad aside within the opening of ±1: cos 0.9 of it.
        near(read(&lamp(2.2, 0.0, 8.0)), 0.8);
        let (sin, cos) = 0.9_f64.sin_cos();
        near(read(&lamp(0.2 + 2.0 * cos, 2.0 * sin, 8.0)), 1.0 - 0.2 * cos);
        near(read(&lamp(-2.0, 0.0, 8.0)), 1.0);
        near(read(&lamp(2.2, 0.0, 800.0)), 0.0);
        near(read("[arena]\nambient_lux = 3.0\n"), 0.7);
    }
}

const VOLTAGE: &str = "kind = \"ir-voltage\"\nbearing_rad = 0.0\nopening_rad = 0.08\nrays = 1\nrange_m = 0.8\n\
                       curve_m_v = [[0.0, 0.9], [0.06, 2.9], [0.1, 2.3], [0.8, 0.4]]\nidle_v = 0.3\nsupply_v = 5.0";

#[test]
fn an_ir_sensor_without_its_emitter_has_multiplicative_noise_too() {
    let ambient = "kind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 0.5\nrays = 1\nrange_m = 1.0\nambient_saturation_lux = 10.0\nsigma = 0.05";
    // 8 cd at 2 m ahead: 2 lux of 10.
    let toml = with_sensor(&format!("step_ms = 0.05\n{}", lamp(2.2, 0.0, 8.0)), ambient);
    let mut values = singles(&toml, SAMPLES);
    assert!(values.iter().all(|value| (0.0..=1.0).contains(value)));
    assert_distributed(&mut values, |scale| normal(0.8, 0.04 * scale));
}

/// The GP2D12's voltage (§1.2.2).
#[test]
fn a_voltage_ranger_follows_its_curve_and_folds_back_when_too_near() {
    for (d, volts) in [(0.1, 2.3), (0.45, 1.35), (0.8, 0.4), (0.9, 0.3), (0.03, 1.9), (0.06, 2.9)] {
        // Rounding must not push the last distance beyond the range.
        let d: f64 = d - 1e-12;
        let found = single(&with_sensor(&wall(0.2 + d), VOLTAGE));
        assert!((found - volts).abs() < 1e-6, "{d}: {found} should be {volts}");
    }
}

#[test]
fn a_voltage_ranger_has_additive_noise_and_no_voltage_beyond_its_supply() {
    let noisy = |sigma: f64| {
        with_sensor(
            &format!("step_ms = 0.05\n{}", wall(0.3)),
            &format!("{VOLTAGE}\nnoise = {{ additive = {sigma} }}"),
        )
    };
    assert_distributed(&mut singles(&noisy(0.03), SAMPLES), |scale| normal(2.3, 0.03 * scale));
    let wild = singles(&noisy(10.0), 1000);
    assert!(wild.iter().all(|v| (0.0..=5.0).contains(v)), "{wild:?}");
    assert!(wild.contains(&0.0) && wild.contains(&5.0));
}

const SONAR: &str =
    "kind = \"sonar\"\nbearing_rad = 0.0\nopening_rad = 0.6\nrays = 7\nmin_m = 0.02\nmax_m = 3.0";

/// Ultrasound by §3.2.3: S = min dᵢ.
#[test]
fn a_sonar_reads_the_nearest_thing_in_its_cone() {
    let pole = |y: f64| {
        format!("[[arena.circles]]\nname = \"pole\"\nx_m = 1.2\ny_m = {y}\nradius_m = 0.1\n{}", wall(2.2))
    };
    near(single(&with_sensor(&pole(0.0), SONAR)), 0.9);
    near(single(&with_sensor(&pole(1.0), SONAR)), 2.0);
    near(single(&with_sensor(&wall(4.0), SONAR)), 3.0);
    near(single(&with_sensor(&wall(0.21), SONAR)), 0.02);
}

/// Ultrasound by §3.2.3: the probability p.
#[test]
fn a_sonar_hears_an_echo_as_often_as_its_detection_says() {
    let toml = with_sensor(
        &format!("step_ms = 0.05\n{}", wall(1.2)),
        &format!("{SONAR}\ndetection = 0.7\nsound_m_s = 100000"),
    );
    let mut heard = 0;
    for value in singles(&toml, 30_000) {
        assert!(value == 3.0 || (value - 1.0).abs() < 1e-9, "{value}");
        heard += u64::from(value < 2.0);
    }
    assert_rate(heard, 30_000, 0.7);
}

#[test]
fn noise_of_a_sonar_is_normal_on_an_echo_and_leaves_silence_alone() {
    let toml = with_sensor(
        &format!("step_ms = 0.05\n{}", wall(1.2)),
        &format!("{SONAR}\ndetection = 0.9\nsound_m_s = 100000\nnoise = {{ additive = 0.02 }}"),
    );
    let mut echoes = singles(&toml, SAMPLES);
    echoes.retain(|&value| value != 3.0);
    assert_rate(SAMPLES as u64 - echoes.len() as u64, SAMPLES as u64, 0.1);
    assert_distributed(&mut echoes, |scale| normal(1.0, 0.02 * scale));
}

/// The farthest distance at which a sonar that reaches 6 m gets an echo of something so wide and so high: by steps of 1
/// cm.
fn heard_up_to(width_m: f64, height_m: f64) -> f64 {
    let sonar = SONAR.replace("max_m = 3.0", "max_m = 6.0\nwall_range_m = 6.0\nheight_m = 0.01");
    let hears = |d: &f64| {
        let (x, y) = (0.2 + d, 0.5 * width_m);
        let board = block("board", [x, -y, x + 0.01, y], &format!("height_m = {height_m:?}"));
        single(&with_sensor(&board, &sonar)) < 6.0
    };
    (5..=600).map(|cm| f64::from(cm) * 0.01).take_while(hears).last().unwrap()
}

#[test]
fn a_sonar_loses_a_target_the_sooner_the_smaller_it_is_and_a_wall_where_it_should() {
    let wide: Vec<_> = [0.01, 0.03, 0.1, 0.3].into_iter().map(|width| heard_up_to(width, 1.0)).collect();
    assert!(wide.is_sorted() && wide[0] < 2.5 && wide[3] > 5.97, "{wide:?}");
    let high: Vec<_> = [0.01, 0.03, 0.1, 0.3].into_iter().map(|height| heard_up_to(1.0, height)).collect();
    assert!(high.is_sorted() && high[0] < 2.5 && high[3] > 5.97, "{high:?}");
    // Width and height do alike, but for the steps in which the width is found.
    assert!(wide.iter().zip(&high).all(|(wide, high)| (wide / high - 1.0).abs() < 0.1), "{wide:?} {high:?}");
}

#[test]
fn a_wall_of_many_short_pieces_is_as_loud_as_one_piece() {
    let sonar = SONAR.replace("max_m = 3.0", "max_m = 6.0\nwall_range_m = 6.0");
    let pieces: String = (-60..60)
        .map(|i| block(&format!("p{i}"), [5.7, 0.01 * f64::from(i), 5.8, 0.01 * f64::from(i + 1)], ""))
        .collect();
    near(single(&with_sensor(&pieces, &sonar)), 5.5);
}

/// The instant at which the microcontroller gets to read the compass, whose turn comes right after the sonar's.
fn compass_after_sonar(top: &str, sonar: &str) -> u64 {
    let sensors = named("s", sonar) + &named("c", "kind = \"compass\"\nperiod_ms = 1.0");
    let mut world = world(&scene(&format!("step_ms = 100.0\n{top}"), "", &sensors));
    world.begin();
    world.finish(&[]);
    let first = view(&world, "c");
    assert_eq!(first.samples + first.missed, if first.missed > 0 { 100 } else { first.samples }, "{first:?}");
    first.missed
}

/// A sonar's time of flight (§1.2.2).
#[test]
fn a_sonar_keeps_the_microcontroller_busy_until_its_echo_is_back() {
    let sonar = format!("{SONAR}\nperiod_ms = 1000.0\nholdoff_us = 750.0\ntimeout_ms = 18.5");
    // 0.75 ms and 2 · 1.7 m at 340 m/s, 10 ms: the compass, due each ms from 0 on, is read at 10.75 ms.
    assert_eq!(compass_after_sonar(&wall(1.9), &sonar), 10);
    // No echo comes: 0.75 + 18.5 ms.
    assert_eq!(compass_after_sonar("", &sonar), 19);
    assert_eq!(compass_after_sonar(&wall(0.21), &sonar), 0);
}

#[test]
fn the_compass_is_read_at_the_very_instant_at_which_the_echo_is_back() {
    let sonar = format!("{SONAR}\nperiod_ms = 1000.0\nholdoff_us = 750.0");
    let sensors = named("s", &sonar) + &named("c", "kind = \"compass\"\nperiod_ms = 1000.0");
    let mut world = world(&scene(&format!("step_ms = 100.0\n{}", wall(1.9)), "", &sensors));
    world.begin();
    world.finish(&[]);
    assert_eq!(view(&world, "c").sampled_at.as_ns(), 10_750_000);
}

#[test]
fn a_sonar_may_take_the_pulse_of_another_for_its_echo() {
    let read = |cross_talk: bool| {
        let sonar =
            format!("[robots.sensors.s]\n{SONAR}\nperiod_ms = 10.0\ncross_talk = {cross_talk}\nphase_ms = ");
        let toml = scene("noise = false", "", &format!("{sonar}1.0"))
            + &scene("", "start = { x_m = 2.4, heading_rad = 3.141592653589793 }", &format!("{sonar}0.0"))
                .replace("name = \"r\"", "name = \"z\"");
        let mut world = world(&toml);
        for _ in 0..4 {
            world.begin();
            world.finish(&[]);
        }
        view(&world, "s").sample[0]
    };
    // The bodies face each other: 2.4 − 0.2 − 0.2 m from sensor to body.
    near(read(false), 2.0);
    assert!(read(true) < 2.0, "{}", read(true));
}

#[test]
fn a_strange_pulse_seems_as_far_away_as_an_echo_that_comes_with_it() {
    let sonar = |phase_ms: f64| {
        format!("[robots.sensors.s]\n{SONAR}\nperiod_ms = 1000.0\ncross_talk = true\nphase_ms = {phase_ms:?}")
    };
    let toml = scene("noise = false\nstep_ms = 10.0", "", &sonar(10.0))
        + &scene("", "start = { x_m = 2.4, heading_rad = 3.141592653589793 }", &sonar(9.0))
            .replace("name = \"r\"", "name = \"z\"");
    let mut world = world(&toml);
    for _ in 0..3 {
        world.begin();
        world.finish(&[]);
    }
    // The pulse was sent 1 ms before, 2 m away: it had 2 − 0.34 m to go, and an echo would have gone half of that.
    let seems_m = view(&world, "s").sample[0];
    assert!((seems_m - 0.83).abs() < 1e-6, "{seems_m}");
}

const LASER: &str = "kind = \"laser\"\nmount = {}\nopening_rad = 3.141592653589793\nrays = 5\nrange_m = 4.0";

/// A laser by §1.2.2 and §3.2.3: Sᵢ = dᵢ, or −1.
#[test]
fn a_laser_reads_each_direction_from_right_to_left_and_minus_1_for_nothing() {
    let walls =
        wall(1.0) + &block("right", [-1.0, -2.1, 0.5, -2.0], "") + &block("left", [-1.0, 6.0, 0.5, 6.1], "");
    let slant = 2.0_f64.sqrt();
    let expected = [2.0, slant, 1.0, slant, -1.0];
    all_near(&first(&with_sensor(&walls, LASER)), &expected);
    let reversed: Vec<_> = expected.iter().rev().copied().collect();
    all_near(&first(&with_sensor(&walls, &format!("{LASER}\nclockwise = true"))), &reversed);
}

#[test]
fn a_laser_cannot_tell_less_than_its_least_distance() {
    let one = LASER.replace("rays = 5", "rays = 1");
    all_near(&first(&with_sensor(&wall(0.25), &format!("{one}\nmin_m = 0.3"))), &[0.3]);
}

#[test]
fn noise_of_a_laser_is_normal_on_each_ray_and_makes_no_echo_of_nothing() {
    let walls = format!("step_ms = 0.05\n{}", wall(1.0));
    let scans = collect(&with_sensor(&walls, &format!("{LASER}\nnoise = {{ additive = 0.01 }}")), 50_000);
    let mut ahead: Vec<_> = scans.iter().map(|scan| scan[2]).collect();
    assert_distributed(&mut ahead, |scale| normal(1.0, 0.01 * scale));
    for noise in [
        "additive = 2.0",
        "uniform = 3.0",
        "spikes = { probability = 0.5, magnitude = 5.0 }",
        "offset_spread = 3.0",
        "drift = { sigma = 3.0, time_constant_s = 0.001 }",
    ] {
        let scans = collect(&with_sensor(&walls, &format!("{LASER}\nnoise = {{ {noise} }}")), 200);
        assert!(scans.iter().all(|scan| scan[0] == -1.0 && scan[4] == -1.0), "{noise}: {:?}", &scans[..5]);
    }
    let dropout = with_sensor(
        &walls,
        &format!("{LASER}\nnoise = {{ dropout = {{ probability = 1.0, value = 4.0 }} }}"),
    );
    assert_eq!(first(&dropout), [4.0; 5]);
}

#[test]
fn a_high_laser_overlooks_what_a_low_infrared_sensor_sees() {
    let low = block("crate", [1.0, -1.0, 1.2, 1.0], "height_m = 0.3") + &wall(3.0);
    let laser = "kind = \"laser\"\nbearing_rad = 0.0\nopening_rad = 0.0\nrays = 1\nrange_m = 5.0";
    let at = |height: f64| first(&with_sensor(&low, &format!("{laser}\nheight_m = {height}")))[0];
    near(at(0.9), 2.8);
    near(at(0.1), 0.8);
    near(at(0.3), 0.8);
    let ir = |height: f64| single(&with_sensor(&low, &format!("{IR}\nheight_m = {height}")));
    assert!(ir(0.1) > 0.1, "{}", ir(0.1));
    near(ir(0.9), 0.0);
}

#[test]
fn a_low_robot_or_box_is_overlooked_too() {
    let laser =
        "kind = \"laser\"\nbearing_rad = 0.0\nopening_rad = 0.0\nrays = 1\nrange_m = 5.0\nheight_m = ";
    let thing = "[[arena.movables]]\nname = \"box\"\nsize_m = [0.4, 0.4]\nx_m = 1.2\ny_m = 0.0\nmass_kg = 1.0\nfriction = 0.5\nheight_m = 0.3\n";
    let mover = "[[arena.movers]]\nname = \"cart\"\nradius_m = 0.2\nheight_m = 0.3\nstops = { points_m = [[1.2, 0.0], [1.2, 0.1]], speed_m_s = 0.001 }\n";
    let other = "[[robots]]\nname = \"z\"\nstart = { x_m = 1.2 }\nbody = { radius_m = 0.2, height_m = 0.3, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
    for (top, more) in [(thing, ""), (mover, ""), ("", other)] {
        let read = |height: f64| first(&(with_sensor(top, &format!("{laser}{height}")) + more))[0];
        near(read(0.1), 0.8);
        near(read(0.9), -1.0);
    }
}

const CAMERA: &str = "kind = \"line-camera\"\nmount = {}\nopening_rad = 3.141592653589793\ncolumns = 3\nrange_m = 5.0\nbackground = [10, 20, 30]";

#[test]
fn a_line_camera_sees_colours_and_depths_from_left_to_right() {
    let top = block("red", [-0.5, 2.0, 0.5, 2.1], "color = [255, 0, 51]")
        + "[[arena.circles]]\nname = \"green\"\nx_m = 1.5\ny_m = 0.0\nradius_m = 0.5\ncolor = [0, 255, 102]\n";
    let level = |n: f64| n / 255.0;
    let expected = [1.0, 0.0, level(10.0), 0.0, 1.0, level(20.0), 0.2, 0.4, level(30.0), 2.0, 1.0, -1.0];
    all_near(&first(&with_sensor(&top, CAMERA)), &expected);
}

#[test]
fn a_line_cameras_noise_keeps_colours_within_bounds_and_nothing_where_it_is() {
    let noisy = with_sensor("step_ms = 0.05", &format!("{CAMERA}\nnoise = {{ additive = 2.0 }}"));
    for image in collect(&noisy, 500) {
        assert!(image[..9].iter().all(|level| (0.0..=1.0).contains(level)), "{image:?}");
        assert_eq!(image[9..], [-1.0; 3]);
    }
}

#[test]
fn a_line_camera_sees_robots_in_their_colour() {
    let other = "[[robots]]\nname = \"z\"\nstart = { x_m = 1.2 }\nbody = { radius_m = 0.2, color = [255, 0, 0], mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
    let image = first(&(with_sensor("", CAMERA) + other));
    all_near(&[image[1], image[4], image[7], image[10]], &[1.0, 0.0, 0.0, 1.0]);
}

/// A camera of 1 × 8 pixels, each a tenth of a metre high at a metre, whose middle is half a metre above the floor.
const IMAGE: &str = "kind = \"camera\"\nmount = {}\nheight_m = 0.5\nopening_rad = 0.09991679144388553\ncolumns = 1\nrows = 8\nrange_m = 20.0\nbackground = [255, 0, 0]\nfloor = [0, 255, 0]";

/// The image of [`IMAGE`] as letters, from the top.
fn letters(toml: &str) -> String {
    let image = first(toml);
    let letter = |i: usize| match [image[i], image[8 + i], image[16 + i]] {
        [1.0, 0.0, 0.0] => 's',
        [0.0, 1.0, 0.0] => 'f',
        [0.0, 0.0, 1.0] => 'b',
        [1.0, 1.0, 1.0] => 'w',
        other => panic!("{other:?}"),
    };
    (0..8).map(letter).collect()
}

/// The camera of §1.2.2, as one eye of the head in Fig. 1.9.
#[test]
fn a_camera_sees_over_a_box_its_top_and_the_floor_before_it() {
    // Lines of sight fall or rise by 0.05, 0.15, 0.25 and 0.35 a metre: to the floor after 10, 3.3, 2 and 1.43 metres.
    assert_eq!(letters(&with_sensor("", IMAGE)), "ssssffff");
    let white = "color = [255, 255, 255]\nheight_m = 0.82";
    let wall = block("wall", [8.0, -1.0, 8.1, 1.0], white);
    // At 8 m they are at 0.9 and at 0.1 m.
    assert_eq!(letters(&with_sensor(&wall, IMAGE)), "sssswfff");
    let blue = "color = [0, 0, 255]\nheight_m = 0.3";
    let low = block("low", [1.5, -1.0, 2.5, 1.0], blue);
    // At 1.5 m they are at 0.425, 0.275, 0.125 and below the floor; the first is over the box until 2.5 m, where it is at 0.375.
    assert_eq!(letters(&with_sensor(&(wall.clone() + &low), IMAGE)), "sssswbbf");
    let flat = block("flat", [1.0, -1.0, 3.0, 1.0], "color = [0, 0, 255]\nheight_m = 0.1");
    // At a height of 0.1 m they are after 8, 2.67, 1.6 and 1.14 m: three of them on the box.
    assert_eq!(letters(&with_sensor(&(wall + &flat), IMAGE)), "sssswbbb");
}

#[test]
fn a_camera_that_stands_in_something_sees_that_and_nothing_else() {
    let inside = IMAGE.replace("mount = {}", "mount = { x_m = 0.3 }");
    let box_ahead = block("box", [0.25, -1.0, 1.0, 1.0], "color = [0, 0, 255]");
    assert_eq!(letters(&with_sensor(&box_ahead, &inside)), "bbbbbbbb");
}

#[test]
fn a_robot_does_not_see_itself_from_anywhere_on_its_body() {
    for mount in [
        "bearing_rad = 0.0",
        "mount = {}",
        "mount = { x_m = -0.4, y_m = 0.1 }",
        "mount = { x_m = -0.1, heading_rad = 3.0 }",
    ] {
        let laser = format!(
            "kind = \"laser\"\n{mount}\nopening_rad = 6.28\nrays = 64\nrange_m = 5.0\nbits = 8\nperiod_ms = 10.0"
        );
        let toml = with_sensor("", &laser);
        assert!(first(&toml).iter().all(|&d| d == -1.0), "{mount}");
    }
}

#[test]
fn a_sensor_that_stands_in_a_wall_reads_something_finite() {
    // The sensor is mounted half a metre ahead of a robot that stands before the wall.
    for sensor in [IR, LOOKUP, VOLTAGE, SONAR, LASER, CAMERA] {
        let inside = sensor
            .replace("bearing_rad = 0.0", "mount = { x_m = 0.3 }")
            .replace("mount = {}", "mount = { x_m = 0.3 }");
        let inside = if sensor == LOOKUP {
            format!("{inside}\nlookup = {{ distances_m = [0.1, 0.5], samples = [[[0.7]], [[0.2]]] }}")
        } else {
            inside
        };
        for x in [0.25, 0.3, 0.2] {
            let values = first(&with_sensor(&wall(x), &inside));
            assert!(values.iter().all(|value| value.is_finite()), "{inside}: {values:?}");
        }
    }
}

#[test]
fn ten_thousand_rays_are_taken_and_ten_thousand_and_one_are_not() {
    let laser = |rays: u32| {
        format!(
            "kind = \"laser\"\nmount = {{}}\nopening_rad = 6.28\nrays = {rays}\nrange_m = 5.0\nport = {{ link = {{ kind = \"ideal\" }} }}"
        )
    };
    assert_eq!(first(&with_sensor(&wall(1.0), &laser(9_999))).len(), 9_999);
    let message = refusal(&with_sensor("", &laser(10_001)));
    assert!(message.contains("sensors.s.rays: must be between 1 and 10000, is 10001"), "{message}");
}

#[test]
fn a_laser_on_a_turret_looks_where_the_turret_stands() {
    let actuator = "[robots.actuators.head]\nkind = \"turret\"\nmin_rad = -1.5707963267948966\nmax_rad = 1.5707963267948966\nrate_rad_s = 100.0\n";
    let laser = "kind = \"laser\"\nmount = { x_m = 0.1 }\nturret = \"head\"\nopening_rad = 0.0\nrays = 1\nrange_m = 5.0";
    let left = block("left", [-1.0, 1.1, 1.0, 1.2], "") + &wall(2.1);
    let mut world = world(&scene(&left, "", &(actuator.to_string() + &named("s", laser))));
    world.begin();
    near(view(&world, "s").sample[0], 2.0);
    for _ in 0..6 {
        crate::devices::scene::tick_of(&mut world, "r", &[0.0, 0.0, 1.0]);
    }
    world.begin();
    near(world.robot(0).actuators()[0].angle_rad, FRAC_PI_2);
    near(view(&world, "s").sample[0], 1.0);
}
