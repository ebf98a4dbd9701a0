//! Presets of sensors, compared with measurements of real ones: in a world with a wall or a target, many specimens at a
//! time.
//!
//! The measurements are those that the presets name as their sources.

use std::fmt::Write;

use baudbot_sim::World;
use baudbot_sim::sensor::port::Format;
use baudbot_sim::sensor::{Device, Sensor};

use crate::common::world;

/// A robot of 0.2 m at the origin that looks along x at what is in `arena`, with so many sensors of a preset on its rim.
fn robot(arena: &str, seed: u64, preset: &str, fields: &str, count: usize) -> World {
    let mut toml = format!(
        "seed = {seed}\n{arena}\n[[robots]]\nname = \"r\"\nfirmware = {{ mode = \"poll\" }}\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n"
    );
    for i in 0..count {
        writeln!(
            toml,
            "[robots.sensors.s{i}]\npreset = \"{preset}\"\nperiod_ms = 10.0\nacquisition_us = 0.0\n{fields}"
        )
        .unwrap();
    }
    world(&toml)
}

/// A wide wall, its face so far from the sensors.
fn wall(gap_m: f64) -> String {
    board(gap_m, 10.0, "")
}

/// A board of this width that faces the sensors, so far from them.
fn board(gap_m: f64, width_m: f64, more: &str) -> String {
    let (x, y) = (0.2 + gap_m, 0.5 * width_m);
    format!(
        "[[arena.polygons]]\nname = \"board\"\nclosed = false\nsolid = false\npoints_m = [[{x:?}, -{y:?}], [{x:?}, {y:?}]]\n{more}\n"
    )
}

/// The readings of specimens after so many ticks: 1050 of them in worlds of 150 each.
fn specimens(arena: &str, preset: &str, fields: &str, ticks: usize) -> Vec<f64> {
    let read = |seed| {
        let mut world = robot(arena, seed, preset, fields, 150);
        for _ in 0..ticks {
            world.begin();
            world.finish(&[]);
        }
        world.begin();
        world.robot(0).sensors().map(|sensor| sensor.sample[0]).collect::<Vec<_>>()
    };
    (0..7).flat_map(read).collect()
}

fn mean_and_sd(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// The sensor that a preset is.
fn sensor(preset: &str) -> Sensor {
    robot("", 0, preset, "", 1).robot(0).spec().sensors[0].clone()
}

/// Eight sensors of a Khepera II on five days, in mm and counts: mean and standard deviation over sensors and days.
const KHEPERA: [(f64, f64, f64); 10] = [
    (10.0, 965.0, 117.0),
    (20.0, 276.0, 56.0),
    (30.0, 155.0, 43.0),
    (40.0, 114.0, 39.0),
    (50.0, 98.0, 37.0),
    (60.0, 87.0, 36.0),
    (70.0, 84.0, 37.0),
    (80.0, 79.0, 35.0),
    (90.0, 77.0, 35.0),
    (100.0, 64.0, 35.0),
];

#[test]
fn kheperas_read_a_wall_as_eight_sensors_did_on_five_days_and_differ_as_much() {
    for preset in ["khepera-1-ir", "khepera-2-ir"] {
        for (mm, mean, sd) in KHEPERA {
            let read = specimens(&wall(mm * 1e-3), preset, "", 0);
            let (found, spread) = mean_and_sd(read.iter().map(|value| 1023.0 * value));
            let near = if mm == 10.0 { 0.3 * sd } else { 0.1 * sd };
            assert!((found - mean).abs() < near, "{preset} at {mm} mm: {found}, measured {mean}");
            assert!((spread / sd - 1.0).abs() < 0.15, "{preset} at {mm} mm: sd {spread}, measured {sd}");
        }
    }
}

#[test]
fn a_khepera_with_nothing_near_keeps_a_residual_value_that_is_never_below_0() {
    for preset in ["khepera-1-ir", "khepera-2-ir"] {
        let read = specimens("", preset, "", 0);
        let (found, spread) = mean_and_sd(read.iter().map(|value| 1023.0 * value));
        // The measured ones: 64 and 77 at 90 and 100 mm, and 56 to 196 where nothing was near.
        assert!((60.0..80.0).contains(&found) && (28.0..40.0).contains(&spread), "{found}, sd {spread}");
        assert!(read.iter().all(|value| *value >= 0.0));
    }
}

#[test]
fn every_value_of_a_khepera_is_a_multiple_of_4_and_1020_is_the_largest() {
    let encoding = sensor("khepera-2-ir").encodings[0];
    let codes = |gap_m| {
        specimens(&wall(gap_m), "khepera-2-ir", "", 0).into_iter().map(move |value| encoding.number(value))
    };
    let codes: Vec<_> =
        [0.005, 0.015, 0.02, 0.05, 1.0].into_iter().flat_map(codes).map(Option::unwrap).collect();
    assert!(codes.iter().all(|code| code % 4 == 0), "{codes:?}");
    assert_eq!(codes.iter().max(), Some(&1020));
}

/// Webots' table from real e-pucks, in mm and counts of 4095: mean, and standard deviation as a part of it.
const EPUCK: [(f64, f64, f64); 10] = [
    (0.0, 4095.0, 0.002),
    (5.0, 2133.0, 0.003),
    (10.0, 1466.0, 0.007),
    (15.0, 601.0, 0.041),
    (20.0, 384.0, 0.015),
    (30.0, 235.0, 0.024),
    (40.0, 158.0, 0.029),
    (50.0, 120.0, 0.042),
    (60.0, 104.0, 0.031),
    (70.0, 67.0, 0.049),
];

#[test]
fn an_epucks_readings_scatter_about_the_table_of_real_ones_as_they_did() {
    for (mm, mean, relative) in EPUCK {
        // One specimen's readings: 1050 sensors with the same gain.
        let read = specimens(&wall(mm * 1e-3), "e-puck-ir", "noise.gain_spread = 0.0", 0);
        let (found, spread) = mean_and_sd(read.iter().map(|value| 4095.0 * value));
        let sd = relative * mean;
        assert!((found - mean).abs() < sd, "{mm} mm: {found}, measured {mean}, sd {sd}");
        // Half of the readings are cut off at full scale.
        let least = if mm == 0.0 { 0.4 } else { 0.9 };
        assert!((least..1.1).contains(&(spread / sd)), "{mm} mm: sd {spread}, measured {sd}");
    }
    // A wall that is out of range is read as one at 70 mm.
    let read = specimens("", "e-puck-ir", "", 0);
    let (found, _) = mean_and_sd(read.iter().map(|value| 4095.0 * value));
    assert!((found - 67.0).abs() < 3.0, "{found}");
}

#[test]
fn an_epuck_reads_a_pair_of_sensors_256_times_a_second_and_each_64_times() {
    let world = world("[[robots]]\nname = \"e\"\npreset = \"e-puck\"\n");
    let sensors = world.robot(0).spec().sensors.iter();
    let times: Vec<_> = sensors
        .filter(|sensor| matches!(sensor.device, Device::Infrared(_)))
        .map(|sensor| (sensor.schedule.period_ns() * 64, sensor.schedule.phase_ns() * 256))
        .collect();
    let expected: Vec<_> = (0..8).map(|i| (1_000_000_000, i % 4 * 1_000_000_000)).collect();
    assert_eq!(times, expected);
}

#[test]
fn a_thymio_reads_webots_table_in_counts_of_4505() {
    let measured = [
        (0.0, 4235.0),
        (10.0, 4279.0),
        (20.0, 4139.0),
        (30.0, 3515.0),
        (40.0, 2965.0),
        (50.0, 2570.0),
        (60.0, 2248.0),
        (70.0, 1941.0),
        (80.0, 1597.0),
        (90.0, 1195.0),
        (100.0, 0.0),
        (1000.0, 0.0),
    ];
    let encoding = sensor("thymio-2-ir").encodings[0];
    assert_eq!(encoding.number(1.0), Some(4505));
    for (mm, mean) in measured {
        let read = specimens(&wall(mm * 1e-3), "thymio-2-ir", "noise.gain_spread = 0.0", 0);
        let codes: Vec<_> = read.iter().map(|value| encoding.number(*value).unwrap() as f64).collect();
        let (found, spread) = mean_and_sd(codes.iter().copied());
        assert!((found - mean).abs() <= 0.005 * mean, "{mm} mm: {found}, measured {mean}");
        assert!((spread - 0.01 * mean).abs() <= 0.001 * mean, "{mm} mm: sd {spread}");
        assert!(codes.iter().all(|code| *code <= 4505.0));
    }
}

#[test]
fn a_gp2d12s_voltages_and_their_spread_are_those_of_five_specimens_of_its_successor() {
    let measured = [
        (0.05, 3.18, 0.12),
        (0.10, 2.30, 0.20),
        (0.15, 1.61, 0.12),
        (0.20, 1.28, 0.09),
        (0.25, 1.02, 0.09),
        (0.30, 0.90, 0.07),
        (0.35, 0.74, 0.08),
        (0.40, 0.66, 0.05),
        (0.45, 0.63, 0.10),
    ];
    let read = |gap_m: f64| {
        let read = specimens(&wall(gap_m), "gp2d12", "clock = { phase_ms = 0.0 }", 3);
        mean_and_sd(read.into_iter())
    };
    let mut relative = 0.0;
    for (gap_m, mean, sd) in measured {
        let (found, spread) = read(gap_m);
        assert!((found / mean - 1.0).abs() < 0.05, "{gap_m} m: {found} V, measured {mean} V");
        assert!((0.6..1.75).contains(&(spread / sd)), "{gap_m} m: sd {spread} V, measured {sd} V");
        relative += spread / found / measured.len() as f64;
    }
    assert!((0.07..0.09).contains(&relative), "they differ by {relative}, measured 7 to 9 %");
    // Three more tables: 540 to 558 counts at 3 cm, 620 to 623 at 6 cm.
    let counts = |gap_m| read(gap_m).0 / 5.0 * 1023.0;
    assert!((540.0..558.0).contains(&counts(0.03)), "{}", counts(0.03));
    assert!((615.0..628.0).contains(&counts(0.06)), "{}", counts(0.06));
}

/// The farthest distance at which a sonar of a preset gets an echo of a target, in steps of 1 cm; without noise.
fn heard_up_to(preset: &str, target: impl Fn(f64) -> String) -> f64 {
    let hears = |gap_m: f64| {
        let arena = format!("noise = false\n{}", target(gap_m));
        let mut world = robot(&arena, 0, preset, "height_m = 0.02", 1);
        world.begin();
        (world.robot(0).sensors().next().unwrap().sample[0] - gap_m).abs() < 0.05
    };
    let steps = (5..400).map(|cm| f64::from(cm) * 0.01);
    steps.take_while(|gap_m| hears(*gap_m)).last().unwrap()
}

fn cylinder(gap_m: f64) -> String {
    format!("[[arena.circles]]\nname = \"c\"\nradius_m = 0.045\ny_m = 0.0\nx_m = {:?}\n", 0.2 + gap_m + 0.045)
}

#[test]
fn an_hc_sr04_loses_a_yardstick_and_a_small_plate_where_a_real_one_does_but_no_wall() {
    let yardstick = heard_up_to("hc-sr04", |gap_m| board(gap_m, 0.035, ""));
    assert!((yardstick - 2.45).abs() < 0.15, "{yardstick}, measured 2.45 m");
    let plate = heard_up_to("hc-sr04", |gap_m| board(gap_m, 0.035, "height_m = 0.035"));
    assert!((plate - 1.70).abs() < 0.1, "{plate}, measured 1.70 m");
    assert!(heard_up_to("hc-sr04", wall) > 3.98);
}

#[test]
fn a_ping_loses_a_cylinder_of_9_cm_at_2_29_m_and_a_wall_at_3() {
    let lost = heard_up_to("ping", cylinder);
    assert!((lost - 2.29).abs() < 0.1, "{lost}, measured 2.29 m");
    assert!((heard_up_to("ping", wall) - 3.0).abs() < 0.06);
}

#[test]
fn a_wall_behind_what_is_too_small_to_be_heard_is_heard() {
    let arena = format!("noise = false\n{}{}", cylinder(2.5), wall(2.8));
    let mut world = robot(&arena, 0, "ping", "", 1);
    world.begin();
    let found = world.robot(0).sensors().next().unwrap().sample[0];
    // The rays beside the cylinder meet it.
    assert!((found - 2.8).abs() < 0.005, "{found}");
}

/// A board off the axis that is turned to the sensor gives an echo up to half of 20° to 21°.
#[test]
fn the_cone_of_an_hc_sr04_is_20_degrees_wide() {
    let hears = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let at = |aside: f64| (0.2 + 1.0 * cos - aside * sin, 1.0 * sin + aside * cos);
        // Objects behind the axis of the sensor do not come into its cone.
        let (a, b) = (at(0.0), at(1.0));
        let arena = format!(
            "noise = false\n[[arena.polygons]]\nname = \"board\"\nclosed = false\nsolid = false\n\
             points_m = [[{:?}, {:?}], [{:?}, {:?}]]\n",
            a.0, a.1, b.0, b.1
        );
        let mut world = robot(&arena, 0, "hc-sr04", "", 1);
        world.begin();
        world.robot(0).sensors().next().unwrap().sample[0] < 3.9
    };
    assert!(hears(9.5) && !hears(10.5));
}

#[test]
fn an_rplidar_has_267_points_a_turn_of_2000_a_second() {
    let sensor = sensor("rplidar-a1");
    let Device::Laser(laser) = &sensor.device else { panic!("no laser") };
    let period_ns = sensor.own_clock.unwrap().period_ns;
    assert_eq!((laser.rays(), period_ns), (267, 133_500_000));
    assert!((laser.sweep_ns as f64 / 266.0 - 500_000.0).abs() < 1.0, "{}", laser.sweep_ns);
    let turn = laser.fan.opening_rad() * 267.0 / 266.0;
    assert!((turn - std::f64::consts::TAU).abs() < 1e-5, "{turn}");
    let Format::Scip(format) = sensor.port.unwrap().format else { panic!("no SCIP") };
    let on_line_ms = format.message_len() as f64 * 10.0 / 115.2;
    assert!(on_line_ms < 133.5, "a scan takes {on_line_ms} ms of its cable");
}

#[test]
fn an_lds_01_and_a_urg_04lx_are_those_of_their_drivers() {
    let lds = sensor("lds-01");
    let Device::Laser(laser) = &lds.device else { panic!("no laser") };
    assert_eq!((laser.rays(), laser.min_m, laser.range_m), (360, 0.12, 3.5));
    assert_eq!(lds.own_clock.unwrap().period_ns, 200_000_000);
    assert!(matches!(lds.port.unwrap().link, baudbot_sim::link::Link::Uart(uart) if uart.baud == 230_400));
    // The answer to its `PP`: DMIN, DMAX, AMIN, AMAX, SCAN.
    let urg = sensor("urg-04lx");
    let Device::Laser(laser) = &urg.device else { panic!("no laser") };
    assert_eq!((laser.min_m, laser.range_m), (0.02, 5.6));
    let Format::Scip(format) = urg.port.unwrap().format else { panic!("no SCIP") };
    assert_eq!((format.first_step, format.last_step), (44, 725));
    assert_eq!(urg.own_clock.unwrap().period_ns, 60_000_000_000 / 600);
}
