//! Odometer and satellite receiver.

use baudbot_sim::World;

use crate::common::statistics::{SAMPLES, assert_distributed, correlation, kolmogorov_smirnov, normal};
use crate::common::{run, world};
use crate::devices::scene::{collect, first, named, near, scene, view, with_sensor};

const ODOMETER: &str = "kind = \"odometer\"";

/// (2.7)–(2.9).
#[test]
fn an_odometer_without_noise_follows_the_true_pose() {
    let start = "start = { x_m = 1.0, y_m = -2.0, heading_rad = 0.7 }";
    let mut world = world(&scene("", start, &named("s", ODOMETER)));
    run(&mut world, 300, 0.5, 0.35);
    world.begin();
    let pose = world.robot(0).motion().pose;
    let sample = view(&world, "s").sample;
    assert!((pose.position.x - 1.0).abs() > 0.3, "{pose:?}");
    crate::devices::scene::all_near(sample, &[pose.position.x, pose.position.y, pose.heading]);
}

#[test]
fn an_odometers_heading_walks_by_a_normal_step_a_read_even_when_standing() {
    let toml = with_sensor("step_ms = 0.05", &format!("{ODOMETER}\nsigma_m = 0.002"));
    let readings = collect(&toml, SAMPLES + 1);
    let mut steps: Vec<_> = readings
        .windows(2)
        .map(|pair| {
            let change = pair[1][2] - pair[0][2];
            if change.abs() > 3.0 { change - change.signum() * std::f64::consts::TAU } else { change }
        })
        .collect();
    // (right − left) / 2R with R = 0.2 m.
    let sigma = 2.0_f64.sqrt() * 0.002 / 0.4;
    assert_distributed(&mut steps, |scale| normal(0.0, sigma * scale));
}

#[test]
fn an_odometers_way_walks_by_a_normal_step_a_read_too() {
    let toml = with_sensor("step_ms = 0.05", &format!("{ODOMETER}\nsigma_m = 0.002"));
    let readings = collect(&toml, SAMPLES + 1);
    // (left + right) / 2, along the new heading.
    let step = |pair: &[Vec<f64>]| {
        let (sin, cos) = pair[1][2].sin_cos();
        (pair[1][0] - pair[0][0]) * cos + (pair[1][1] - pair[0][1]) * sin
    };
    let mut steps: Vec<_> = readings.windows(2).map(step).collect();
    assert_distributed(&mut steps, |scale| normal(0.0, 0.002 / 2.0_f64.sqrt() * scale));
}

const ORIGIN: &str = "[arena]\nlatitude_deg = 57.7\nlongitude_deg = 11.97\n";
const METRES_PER_DEGREE: f64 = 6_371_008.8 * std::f64::consts::PI / 180.0;

fn gps(top: &str, start: &str, more: &str) -> World {
    world(&scene(&format!("{top}\n{ORIGIN}"), start, &named("s", &format!("kind = \"gps\"\n{more}"))))
}

/// A satellite receiver (§1.2.2).
#[test]
fn a_receiver_tells_latitude_longitude_speed_and_course() {
    let mut world = gps("", "start = { x_m = 100.0, y_m = 200.0, heading_rad = 0.5, speed_m_s = 0.6 }", "");
    world.begin();
    let sample = view(&world, "s").sample;
    near(sample[0], 57.7 + 200.0 / METRES_PER_DEGREE);
    near(sample[1], 11.97 + 100.0 / (METRES_PER_DEGREE * 57.7_f64.to_radians().cos()));
    crate::devices::scene::all_near(&sample[2..], &[1.0, 0.6, 0.5]);
}

#[test]
fn a_receiver_tells_the_course_of_a_robot_that_drives_backwards() {
    let mut world = gps("", "start = { heading_rad = 0.5, speed_m_s = -0.6 }", "");
    world.begin();
    crate::devices::scene::all_near(&view(&world, "s").sample[2..], &[1.0, 0.6, 0.5 - std::f64::consts::PI]);
}

/// East and north of the origin, in metres.
fn metres(sample: &[f64]) -> (f64, f64) {
    let east = (sample[1] - 11.97) * METRES_PER_DEGREE * 57.7_f64.to_radians().cos();
    (east, (sample[0] - 57.7) * METRES_PER_DEGREE)
}

#[test]
fn a_receivers_white_noise_is_normal_on_both_axes() {
    let toml = with_sensor(&format!("step_ms = 0.05\n{ORIGIN}"), "kind = \"gps\"\nsigma_m = 0.5");
    let errors: Vec<_> = collect(&toml, SAMPLES).iter().map(|sample| metres(sample)).collect();
    assert!(correlation(&errors).abs() < 0.015, "{}", correlation(&errors));
    assert_distributed(&mut errors.iter().map(|e| e.0).collect::<Vec<_>>(), |scale| normal(0.0, 0.5 * scale));
    assert_distributed(&mut errors.iter().map(|e| e.1).collect::<Vec<_>>(), |scale| normal(0.0, 0.5 * scale));
}

#[test]
fn a_receivers_wandering_error_is_stationary_and_forgets_itself() {
    let toml = with_sensor(
        &format!("step_ms = 1000.0\nsubsteps = 50\n{ORIGIN}"),
        "kind = \"gps\"\nwander_sigma_m = 3.0\nwander_time_s = 10.0",
    );
    let runs: Vec<_> = (0..2000)
        .map(|seed| {
            let samples = collect(&format!("seed = {seed}\n{toml}"), 11);
            (metres(&samples[0]).0, metres(&samples[10]).0)
        })
        .collect();
    for mut at in [runs.iter().map(|r| r.0).collect::<Vec<_>>(), runs.iter().map(|r| r.1).collect()] {
        let outcome = kolmogorov_smirnov(&mut at, normal(0.0, 3.0));
        assert!(outcome.fits(), "{outcome:?}");
    }
    // Ten seconds are one time constant: e⁻¹, with a standard error of 0.02.
    let found = correlation(&runs);
    assert!((found - (-1.0_f64).exp()).abs() < 0.07, "{found}");
}

/// Easts of the error, one every `step_s`.
fn easts(step_s: f64, more: &str, fixes: usize) -> Vec<f64> {
    let top = format!("step_ms = {:?}\n{ORIGIN}", step_s * 1e3);
    let sensor = named("s", &format!("kind = \"gps\"\n{more}"));
    let toml = scene(&top, "motors = { kind = \"stepper\" }", &sensor);
    collect(&toml, fixes).iter().map(|sample| metres(sample).0).collect()
}

/// Autocorrelation at a lag of so many samples.
fn autocorrelation(errors: &[f64], lag: usize) -> f64 {
    let variance: f64 = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    let products: f64 = errors.iter().zip(&errors[lag..]).map(|(a, b)| a * b).sum();
    products / (errors.len() - lag) as f64 / variance
}

#[test]
fn an_error_of_two_parts_has_the_autocorrelation_of_both() {
    let both =
        "wander_sigma_m = 2.0\nwander_time_s = 30.0\nshort_wander_sigma_m = 1.5\nshort_wander_time_s = 6.0";
    // Some 1700 of the slow part's times: a standard error of about 0.03.
    let errors = easts(1.0, both, 50_000);
    let [slow, short] = [4.0, 2.25];
    for lag in [1, 3, 6, 12, 30, 60] {
        let t = lag as f64;
        let expected = (slow * (-t / 30.0).exp() + short * (-t / 6.0).exp()) / (slow + short);
        let found = autocorrelation(&errors, lag);
        assert!((found - expected).abs() < 0.08, "{t} s: {found}, not {expected}");
    }
    let variance: f64 = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    assert!((variance / 6.25 - 1.0).abs() < 0.1, "{variance}");
}

#[test]
fn a_second_part_that_is_off_draws_nothing_and_changes_nothing() {
    let one = "wander_sigma_m = 2.0\nsigma_m = 0.1";
    let off = "wander_sigma_m = 2.0\nsigma_m = 0.1\nshort_wander_sigma_m = 0.0\nshort_wander_time_s = 1.0";
    assert_eq!(easts(1.0, one, 50), easts(1.0, off, 50));
}

#[test]
fn a_receivers_speed_has_its_own_noise() {
    let toml = with_sensor(&format!("step_ms = 0.05\n{ORIGIN}"), "kind = \"gps\"\nspeed_sigma_m_s = 0.1");
    // Of a standing robot: the absolute value of N(0, 0.1).
    let mut speeds: Vec<_> = collect(&toml, 20_000).iter().map(|sample| sample[3]).collect();
    let outcome = kolmogorov_smirnov(&mut speeds, |v| (2.0 * normal(0.0, 0.1)(v) - 1.0).max(0.0));
    assert!(outcome.fits(), "{outcome:?}");
}

#[test]
fn without_sky_there_is_no_fix_and_the_last_position_is_repeated() {
    let zone = "[[arena.zones]]\nname = \"house\"\nx_m = 1.0\ny_m = 0.0\nradius_m = 0.7\nindoors = true\n";
    let toml = format!("{ORIGIN}{zone}");
    let sensor = named("s", "kind = \"gps\"\nreacquire_s = 0.5\nperiod_ms = 10.0");
    let mut world = world(&scene(&toml, "start = { speed_m_s = 0.7 }", &sensor));
    let (mut fixes, mut last, mut truth) = (Vec::new(), [0.0; 5], Vec::new());
    for _ in 0..500 {
        world.begin();
        let sample = view(&world, "s").sample;
        if sample[2] == 0.0 {
            assert_eq!((sample[0], sample[1], sample[3], sample[4]), (last[0], last[1], 0.0, 0.0));
        }
        last.copy_from_slice(sample);
        fixes.push(sample[2] == 1.0);
        truth.push((world.robot(0).motion().pose.position.x - 1.0).abs() > 0.7);
        crate::common::tick(&mut world, 0.8, 0.8);
    }
    let lost = truth.iter().position(|sky| !sky).unwrap();
    let back = lost + truth[lost..].iter().position(|&sky| sky).unwrap();
    assert!(fixes[..lost].iter().all(|&fix| fix));
    assert!(fixes[lost..back + 50].iter().all(|&fix| !fix));
    assert!(fixes[back + 50..].iter().all(|&fix| fix), "{back}");
}

#[test]
fn indoors_there_never_is_a_fix() {
    let toml = with_sensor("[arena]\nindoors = true\n", "kind = \"gps\"");
    assert_eq!(first(&toml), [0.0; 5]);
}

/// The satellites above horizons that leave so many of them.
const HORIZONS: [(usize, f64); 3] = [(9, 30.0), (6, 50.0), (4, 62.0)];

/// HDOP and VDOP of the highest satellites, by another program.
fn dilution(satellites: usize) -> (f64, f64) {
    match satellites {
        12 => (0.8749, 1.2453),
        9 => (1.237, 2.3532),
        6 => (2.1962, 6.0196),
        4 => (4.5925, 16.2256),
        _ => panic!("no dilution of {satellites} satellites"),
    }
}

/// Everywhere a horizon so high.
fn street(horizon_deg: f64) -> String {
    format!(
        "{ORIGIN}altitude_m = 100.0\n[[arena.zones]]\nname = \"street\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 1000.0\n\
         horizon_deg = {horizon_deg:?}\n"
    )
}

/// §1.2.2: latitude, longitude, altitude, and the number of satellites.
#[test]
fn a_receiver_tells_altitude_satellites_and_dilution() {
    for (satellites, horizon_deg) in HORIZONS.into_iter().chain([(12, 0.0)]) {
        let toml = with_sensor(
            &format!("noise = false\n{}", street(horizon_deg)),
            "kind = \"gps\"\nsatellites = true",
        );
        let sample = first(&toml);
        assert_eq!((sample[2], sample[5], sample[6]), (1.0, 100.0, satellites as f64), "{sample:?}");
        assert!((sample[7] - dilution(satellites).0).abs() < 1e-4, "{sample:?}");
    }
}

#[test]
fn three_satellites_make_no_fix() {
    let toml = with_sensor(&street(65.0), "kind = \"gps\"\nsatellites = true");
    assert_eq!(first(&toml), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let plain = with_sensor(&street(65.0), "kind = \"gps\"");
    assert_eq!(first(&plain)[2], 1.0, "a receiver that counts no satellites knows roofs only");
}

#[test]
fn under_the_open_sky_positions_are_those_of_a_receiver_without_altitude() {
    let gps = "kind = \"gps\"\nwander_sigma_m = 2.0\nshort_wander_sigma_m = 1.0\nsigma_m = 0.5\nspeed_sigma_m_s = 0.1";
    let plain = collect(&with_sensor(ORIGIN, gps), 50);
    let counting = collect(&with_sensor(ORIGIN, &format!("{gps}\nsatellites = true")), 50);
    for (plain, counting) in plain.iter().zip(&counting) {
        assert_eq!(plain[..], counting[..5]);
    }
}

#[test]
fn errors_of_position_and_altitude_grow_with_their_dilutions() {
    for (satellites, horizon_deg) in [(6, 50.0), (12, 0.0)] {
        let top = format!("step_ms = 0.05\n{}", street(horizon_deg));
        let readings =
            collect(&with_sensor(&top, "kind = \"gps\"\nsatellites = true\nsigma_m = 0.5"), SAMPLES);
        // Half a metre along each axis is √2 · 0.5 m in the plane, with all satellites.
        let distance_m = 0.5 * 2.0_f64.sqrt() / dilution(12).0;
        let (horizontal, vertical) = dilution(satellites);
        let (along, up) = (distance_m * horizontal / 2.0_f64.sqrt(), distance_m * vertical);
        let mut easts: Vec<_> = readings.iter().map(|sample| metres(sample).0).collect();
        assert_distributed(&mut easts, |scale| normal(0.0, along * scale));
        let mut altitudes: Vec<_> = readings.iter().map(|sample| sample[5] - 100.0).collect();
        assert_distributed(&mut altitudes, |scale| normal(0.0, up * scale));
        let pairs: Vec<_> = readings.iter().map(|sample| (metres(sample).0, sample[5])).collect();
        assert!(correlation(&pairs).abs() < 0.015, "{}", correlation(&pairs));
    }
}

#[test]
fn an_altitudes_error_wanders_as_the_positions_do() {
    let toml = with_sensor(
        &format!("step_ms = 1000.0\nsubsteps = 50\n{ORIGIN}"),
        "kind = \"gps\"\nsatellites = true\nwander_sigma_m = 3.0\nwander_time_s = 10.0",
    );
    let runs: Vec<_> = (0..2000)
        .map(|seed| {
            let samples = collect(&format!("seed = {seed}\n{toml}"), 11);
            (samples[0][5], samples[10][5])
        })
        .collect();
    let sigma = 3.0 * 2.0_f64.sqrt() * dilution(12).1 / dilution(12).0;
    for mut at in [runs.iter().map(|r| r.0).collect::<Vec<_>>(), runs.iter().map(|r| r.1).collect()] {
        let outcome = kolmogorov_smirnov(&mut at, normal(0.0, sigma));
        assert!(outcome.fits(), "{outcome:?}");
    }
    let found = correlation(&runs);
    assert!((found - (-1.0_f64).exp()).abs() < 0.07, "{found}");
}
