//! Touch, light, fields, sound, floor and battery.

use std::f64::consts::LN_2;

use baudbot_sim::{Ending, Input, World};

use crate::common::statistics::{SAMPLES, assert_distributed, assert_rate, chi_squared, normal};
use crate::common::{run, tick, world, world_with};
use crate::devices::scene::{
    all_near, block, first, named, near, scene, signals, single, singles, tick_of, view, wall, with_sensor,
};

const WHISKER: &str = "kind = \"whisker\"\nbearing_rad = 0.0\nlength_m = 0.1";

/// The sense of touch (§1.2.2) of the Boe-Bot's whiskers (§1.2.4).
#[test]
fn a_whisker_touches_what_is_within_its_length() {
    for (x, touched) in [(0.25, 1.0), (0.299, 1.0), (0.301, 0.0), (2.0, 0.0)] {
        near(single(&with_sensor(&wall(x), WHISKER)), touched);
        near(single(&with_sensor(&wall(x), &format!("{WHISKER}\nactive_low = true"))), 1.0 - touched);
    }
    near(single(&with_sensor(&block("back", [-0.4, -1.0, -0.25, 1.0], ""), WHISKER)), 0.0);
    near(
        single(&with_sensor(
            &block("low", [0.25, -1.0, 0.4, 1.0], "height_m = 0.03"),
            &format!("{WHISKER}\nheight_m = 0.05"),
        )),
        0.0,
    );
}

#[test]
fn a_whiskers_range_is_its_length() {
    let world = world(&with_sensor("", WHISKER));
    assert_eq!(world.scenario().robots[0].sensors[0].device.range_m(), Some(0.1));
}

#[test]
fn a_whisker_bounces_for_a_while_after_a_change_only() {
    let sensor = named("s", &format!("{WHISKER}\nbounce_ms = 20.0"));
    let top = format!("step_ms = 0.02\n{}", wall(0.305));
    let mut world =
        world(&scene(&top, "start = { speed_m_s = 0.6 }\nfirmware = { mode = \"poll\" }", &sensor));
    let (mut touched_at, mut bounced, mut settled) = (None, Vec::new(), Vec::new());
    for i in 0..3000 {
        world.begin();
        let value = view(&world, "s").sample[0];
        let touches = world.robot(0).motion().pose.position.x >= 0.005;
        match touched_at {
            None if touches => touched_at = Some(i),
            None => assert_eq!(value, 0.0),
            Some(_) => {}
        }
        match touched_at {
            Some(at) if i - at < 1000 => bounced.push(value),
            Some(_) => settled.push(value),
            None => {}
        }
        world.finish(&[]);
    }
    let ones = bounced.iter().filter(|&&value| value == 1.0).count() as f64 / bounced.len() as f64;
    assert!((ones - 0.5).abs() < 0.06, "{ones} of {}", bounced.len());
    assert!(settled.len() > 1000 && settled.iter().all(|&value| value == 1.0));
}

#[test]
fn a_contact_that_bounces_reads_either_as_likely_as_not_and_forgets_what_it_read() {
    // The first read finds the wall, and the contact bounces for all of the run.
    for sensor in [WHISKER, BUMPER] {
        let toml = with_sensor(
            &format!("step_ms = 0.05\n{}", wall(0.205)),
            &format!("{sensor}\nbounce_ms = 2000.0"),
        );
        let values = singles(&toml, 20_000);
        assert_rate(values.iter().filter(|&&value| value == 1.0).count() as u64, 20_000, 0.5);
        let mut pairs = [0; 4];
        for pair in values.chunks_exact(2) {
            pairs[(2.0 * pair[0] + pair[1]) as usize] += 1;
        }
        let outcome = chi_squared(&pairs, &[0.25; 4]);
        assert!(outcome.fits(), "{sensor}: {pairs:?}: {outcome:?}");
    }
}

const BUMPER: &str = "kind = \"bumper\"\nbearing_rad = 0.0\nopening_rad = 1.0\ntravel_m = 0.01";

#[test]
fn a_bumper_feels_only_what_presses_its_part_of_the_rim() {
    near(single(&with_sensor(&wall(0.205), BUMPER)), 1.0);
    near(single(&with_sensor(&wall(0.215), BUMPER)), 0.0);
    near(single(&with_sensor(&block("back", [-0.4, -1.0, -0.205, 1.0], ""), BUMPER)), 0.0);
    near(single(&with_sensor(&block("left", [-1.0, 0.205, 1.0, 0.4], ""), BUMPER)), 0.0);
    let sideways = BUMPER.replace("bearing_rad = 0.0", "bearing_rad = 1.5707963");
    near(single(&with_sensor(&block("left", [-1.0, 0.205, 1.0, 0.4], ""), &sideways)), 1.0);
}

#[test]
fn a_robot_that_has_run_into_a_wall_feels_it() {
    let mut world = world(&scene(&wall(0.5), "", &named("s", BUMPER)));
    run(&mut world, 200, 0.5, 0.5);
    assert_eq!(world.robot(0).counters().collisions, 1);
    world.begin();
    assert_eq!(view(&world, "s").sample, [1.0]);
}

const PHOTORESISTOR: &str = "kind = \"photoresistor\"\nbearing_rad = 0.0\nresistance_10lux_ohm = 10000.0\ngamma = 0.7\ncapacitance_uf = 0.01";

fn lit(lux: f64) -> String {
    format!("[arena]\nambient_lux = {lux:?}\n")
}

#[test]
fn a_photoresistors_count_is_the_time_in_which_its_capacitor_falls() {
    // 1.273 R C = 127.3 µs at 10 lux: 63 counts of 2 µs; 2^(1/0.7) times the light is half of that.
    near(single(&with_sensor(&lit(10.0), PHOTORESISTOR)), 63.0);
    near(single(&with_sensor(&lit(10.0 * (LN_2 / 0.7).exp()), PHOTORESISTOR)), 31.0);
    near(single(&with_sensor(&lit(1e6), PHOTORESISTOR)), 1.0);
    near(single(&with_sensor("", PHOTORESISTOR)), 0.0);
    // RCTIME's counter counts units that are over, as on the page.
    let page = include_str!("../../../../docs/explanation/devices.md");
    assert!(page.contains("what is left of the last one is cut off"), "63.65 and 31.8 units read 63 and 31");
}

#[test]
fn a_photoresistor_in_the_dark_blocks_the_processor_for_131_ms() {
    let missed = |top: &str| {
        let sensors = named("s", &format!("{PHOTORESISTOR}\nperiod_ms = 1000.0"))
            + &named("c", "kind = \"compass\"\nperiod_ms = 10.0");
        let mut world = world(&scene(top, "", &sensors));
        run(&mut world, 20, 0.0, 0.0);
        (view(&world, "c").missed, view(&world, "c").samples)
    };
    // Due at 0, 10, … 190 ms; read at 131.07 ms, with those from 10 to 130 missed.
    assert_eq!(missed(""), (13, 7));
    assert_eq!(missed(&lit(10.0)), (0, 20));
}

#[test]
fn a_photoresistors_noise_is_normal_and_rounded_to_counts() {
    let toml = with_sensor(
        &format!("step_ms = 1.0\n{}", lit(10.0)),
        &format!("{PHOTORESISTOR}\nnoise = {{ additive = 3.0 }}"),
    );
    // Of 63 counts: from 54 to 72 one by one, and what is beyond.
    let mut counts = [0; 19];
    for value in singles(&toml, 20_000) {
        assert_eq!(value, value.round());
        counts[(value - 54.0).clamp(0.0, 18.0) as usize] += 1;
    }
    let below = |i: usize| if i == 19 { 1.0 } else { normal(63.0, 3.0)(53.5 + i as f64) };
    let share = |i: usize| below(i + 1) - if i == 0 { 0.0 } else { below(i) };
    let outcome = chi_squared(&counts, &std::array::from_fn::<_, 19, _>(share));
    assert!(outcome.fits(), "{counts:?}: {outcome:?}");
}

#[test]
fn a_photoresistor_faces_its_lamp() {
    let lamp =
        |x: f64| format!("[[arena.lights]]\nname = \"l\"\nx_m = {x:?}\ny_m = 0.0\nintensity_cd = 10.0\n");
    near(single(&with_sensor(&lamp(1.2), PHOTORESISTOR)), 63.0);
    near(single(&with_sensor(&lamp(-1.2), PHOTORESISTOR)), 0.0);
}

const LIGHT: &str = "kind = \"light\"\nbearing_rad = 0.0\nrange_lux = 100.0";

#[test]
fn illuminance_follows_the_inverse_square_and_the_cosine() {
    let lamp = |x: f64, y: f64, more: &str| {
        format!("[[arena.lights]]\nname = \"l\"\nx_m = {x:?}\ny_m = {y:?}\nintensity_cd = 8.0\n{more}\n")
    };
    let read = |top: &str| single(&with_sensor(top, LIGHT));
    near(read(&lamp(2.2, 0.0, "")), 2.0);
    let (sin, cos) = 0.7_f64.sin_cos();
    near(read(&lamp(0.2 + 2.0 * cos, -2.0 * sin, "")), 2.0 * cos);
    near(read(&lamp(-1.0, 0.0, "")), 0.0);
    // 2 m high: d² = 8, and the surface is turned away by 45°.
    near(read(&lamp(2.2, 0.0, "height_m = 2.0")), 8.0 / 8.0 * 0.5_f64.sqrt());
    near(read(&(lit(3.0) + &lamp(2.2, 0.0, ""))), 5.0);
    near(read(&lamp(0.3, 0.0, "")), 100.0);
    near(read(&(wall(1.0) + &lamp(2.2, 0.0, ""))), 0.0);
    near(read(&(wall(1.0) + &lamp(2.2, 0.0, "shadows = false"))), 2.0);
    near(read(&(wall(3.0) + &lamp(2.2, 0.0, ""))), 2.0);
    // Straight over it the surface, which stands upright, gets nothing.
    near(read(&lamp(0.2, 0.0, "height_m = 1.0")), 0.0);
}

#[test]
fn a_lamp_blinks() {
    let lamp = "[[arena.lights]]\nname = \"l\"\nx_m = 2.2\ny_m = 0.0\nintensity_cd = 8.0\nblink_ms = 50.0\nlit_ms = 20.0\n";
    let readings = singles(&with_sensor(lamp, LIGHT), 15);
    for (i, value) in readings.into_iter().enumerate() {
        near(value, if i % 5 < 2 { 2.0 } else { 0.0 });
    }
}

#[test]
fn a_light_sensor_lags() {
    let lamp = "[[arena.lights]]\nname = \"l\"\nx_m = 2.2\ny_m = 0.0\nintensity_cd = 8.0\nblink_ms = 1000.0\nlit_ms = 100.0\n";
    let readings = singles(&with_sensor(lamp, &format!("{LIGHT}\nlag_s = 0.05")), 20);
    for (i, value) in readings.into_iter().enumerate() {
        let dark_s = (i as f64 * 0.01 - 0.09).max(0.0);
        near(value, 2.0 * (-dark_s / 0.05).exp());
    }
}

#[test]
fn a_light_sensor_has_normal_noise_and_is_never_below_darkness() {
    let toml = with_sensor(
        &format!("step_ms = 0.05\n{}", lit(50.0)),
        &format!("{LIGHT}\nnoise = {{ additive = 2.0 }}"),
    );
    assert_distributed(&mut singles(&toml, SAMPLES), |scale| normal(50.0, 2.0 * scale));
    let dark =
        singles(&with_sensor("step_ms = 0.05", &format!("{LIGHT}\nnoise = {{ additive = 2.0 }}")), 1000);
    assert!(dark.iter().all(|lux| *lux >= 0.0) && dark.iter().any(|lux| *lux > 0.0));
}

/// `r` has a light sensor; `z`, 2.2 m ahead, a lamp of 8 cd.
fn lamp_bearer(top: &str) -> World {
    let lamp = "[robots.actuators.lamp]\nkind = \"lamp\"\nintensity_cd = 8.0\n";
    let z = scene("", "start = { x_m = 2.2 }", lamp).replace("name = \"r\"", "name = \"z\"");
    let own = format!("{lamp}{}", named("s", LIGHT));
    world(&(scene(top, "", &own) + &z))
}

#[test]
fn a_robots_lamp_is_seen_by_another_and_not_by_itself() {
    let mut world = lamp_bearer("");
    let read = |world: &mut World, name: &str, signal: f64| {
        tick_of(world, name, &[0.0, 0.0, signal]);
        world.begin();
        let lux = view(world, "s").sample[0];
        world.finish(&[]);
        lux
    };
    near(read(&mut world, "r", 1.0), 0.0);
    near(read(&mut world, "z", 1.0), 2.0);
    near(read(&mut world, "z", 0.5), 1.0);
    near(read(&mut world, "z", -1.0), 0.0);
    let mut shaded = lamp_bearer(&wall(1.0));
    near(read(&mut shaded, "z", 1.0), 0.0);
    assert_eq!(shaded.robot(1).actuators()[0].signal, 1.0);
}

const SCENT: &str = "[[arena.fields]]\nname = \"scent\"\nbackground = 1.0\nslope_per_m = [0.5, -0.25]\n\
                     sources = [{ x_m = 1.2, y_m = 0.0, strength = 3.0, width_m = 0.5 }]\n";

#[test]
fn a_field_sensor_reads_background_slope_and_bells_where_it_sits() {
    let read =
        |mount: &str| single(&with_sensor(SCENT, &format!("kind = \"field\"\nfield = \"scent\"\n{mount}")));
    near(read("mount = { x_m = 0.2 }"), 1.0 + 0.1 + 3.0 * (-2.0_f64).exp());
    near(read("mount = { x_m = 0.2, y_m = 0.4 }"), 1.1 - 0.1 + 3.0 * (-(1.0 + 0.16) / 0.5_f64).exp());
    near(read("bearing_rad = 0.0"), 1.1 + 3.0 * (-2.0_f64).exp());
}

#[test]
fn a_field_sensor_has_noise() {
    let sensor = "kind = \"field\"\nfield = \"scent\"\nmount = {}\nnoise = { additive = 0.1 }";
    let truth = 1.0 + 3.0 * (-1.44 / 0.5_f64).exp();
    assert_distributed(
        &mut singles(&with_sensor(&format!("step_ms = 0.05\n{SCENT}"), sensor), SAMPLES),
        |scale| normal(truth, 0.1 * scale),
    );
}

#[test]
fn a_microphone_hears_others_as_one_by_distance() {
    let speaker = "[robots.actuators.voice]\nkind = \"speaker\"\nlevel = 2.0\n";
    let other = |name: &str, x: f64, y: f64| {
        scene("", &format!("start = {{ x_m = {x:?}, y_m = {y:?} }}"), speaker)
            .replace("name = \"r\"", &format!("name = \"{name}\""))
    };
    let own = format!("{speaker}{}", named("s", "kind = \"microphone\""));
    // A wall between does not matter.
    let mut world = world(&(scene(&wall(1.0), "", &own) + &other("x", 4.0, 0.0) + &other("y", 0.0, 2.5)));
    let heard = |world: &mut World, signals: [(&str, f64); 3]| {
        for (name, signal) in signals {
            tick_of(world, name, &[0.0, 0.0, signal]);
        }
        world.begin();
        let level = view(world, "s").sample[0];
        world.finish(&[]);
        level
    };
    near(heard(&mut world, [("r", 1.0), ("x", 0.0), ("y", 0.0)]), 0.0);
    near(heard(&mut world, [("r", 1.0), ("x", 1.0), ("y", 0.0)]), 0.5);
    near(heard(&mut world, [("r", 0.0), ("x", 1.0), ("y", 0.5)]), 0.5 + 1.0 / 2.5);
}

/// Robots 2 m away with a speaker of level 2, which sounds at this frequency if at any, as a microphone of this band hears them.
fn heard(band: &str, frequency: &str) -> f64 {
    let speaker = format!(
        "start = {{ x_m = 2.0 }}\nactuators.voice = {{ kind = \"speaker\", level = 2.0{frequency} }}"
    );
    let other = scene("", &speaker, "").replace("name = \"r\"", "name = \"x\"");
    let mut world = world(&(scene("", "", &named("s", &format!("kind = \"microphone\"{band}"))) + &other));
    tick_of(&mut world, "x", &[0.0, 0.0, 1.0]);
    world.begin();
    view(&world, "s").sample[0]
}

/// Tones of §1.2.3.
#[test]
fn a_band_passes_what_is_in_it_and_a_quarter_an_octave_away() {
    let band = "\nband_hz = [400.0, 800.0]";
    for (frequency_hz, share) in [
        (400.0, 1.0),
        (600.0, 1.0),
        (800.0, 1.0),
        (200.0, 0.25),
        (1600.0, 0.25),
        (800.0 * 2.0_f64.sqrt(), 0.5),
        (100.0, 1.0 / 16.0),
    ] {
        near(heard(band, &format!(", frequency_hz = {frequency_hz:?}")), share);
        assert_eq!(heard("", &format!(", frequency_hz = {frequency_hz:?}")), 1.0, "an ear without a band");
    }
    assert_eq!(heard(band, ""), 1.0, "a noise has all frequencies");
}

/// §1.2.3: two of them, turned away from each other, tell left from right, as the moth's ears do (§5.1).
#[test]
fn a_cardioid_hears_what_is_before_it_and_not_what_is_behind() {
    for (axis_rad, share) in [
        ("0.0", 1.0),
        ("1.5707963267948966", 0.5),
        ("-1.5707963267948966", 0.5),
        ("3.141592653589793", 0.0),
        ("1.0471975511965976", 0.75),
    ] {
        near(heard(&format!("\naxis_rad = {axis_rad}"), ""), share);
    }
}

/// §4.4.2, pheromone trails: what is laid down is there, and fades.
#[test]
fn a_dispenser_lays_down_its_rate_and_the_trail_fades() {
    let arena = "[[arena.fields]]\nname = \"trail\"\nbackground = 2.0\n\
                 trail = { corner_m = [-1.0, -1.0], size_m = [2.0, 2.0], cell_m = 0.5, decay_s = 4.0 }\n";
    let robot = "[robots.actuators.gland]\nkind = \"dispenser\"\nfield = \"trail\"\nrate_per_s = 3.0\n";
    let nose = named("s", "kind = \"field\"\nfield = \"trail\"\nmount = {}");
    let text = scene(arena, "start = { x_m = 0.25, y_m = 0.25 }", &format!("{robot}{nose}"));
    let mut world = world(&text);
    let step_s = world.scenario().step_ns as f64 * 1e-9;
    let mut expected = 0.0;
    for (signal, ticks) in [(1.0, 50), (0.5, 50), (-1.0, 50)] {
        for _ in 0..ticks {
            tick_of(&mut world, "r", &[0.0, 0.0, signal]);
            // A cell has 0.25 m².
            expected = expected * (-step_s / 4.0).exp() + 3.0 * signal.max(0.0) * step_s / 0.25;
        }
    }
    world.begin();
    near(view(&world, "s").sample[0], 2.0 + expected);
    // A snapshot goes on as the world does, and a state by value, too.
    world.finish(&[]);
    let mut copy = world.clone();
    let mut loaded = World::load(world.scenario().clone(), &world.save(), world.hash()).unwrap();
    for world in [&mut world, &mut copy, &mut loaded] {
        (0..20).for_each(|_| tick_of(world, "r", &[0.0, 0.0, 1.0]));
    }
    assert_eq!([copy.hash(), loaded.hash()], [world.hash(); 2]);
    let other = World::new(world.scenario().clone());
    assert_ne!(other.hash(), world.hash());
}

const TONES: &str = include_str!("../../../../catalogue/scenarios/devices/tones.toml");

/// How far alice and bob are from each other after a minute in which all call, and these two go on while they hear less than 1.
fn distance_m(sets: &[&str]) -> f64 {
    let mut world = world_with(TONES, &[&["noise=false"], sets].concat());
    for _ in 0..6000 {
        let turns = world.begin().to_vec();
        let commands: Vec<_> = turns
            .iter()
            .map(|turn| {
                let robot = world.robot(turn.robot);
                let heard = robot.readings().first().and_then(|ear| ear.values.first().copied());
                let speed = heard.map_or(0.0, |heard| 0.3 * (2.0 - 2.0 * heard).tanh());
                signals(robot.spec(), &[speed, speed, 1.0])
            })
            .collect();
        let inputs = turns.iter().zip(&commands);
        let inputs: Vec<_> =
            inputs.map(|(turn, bytes)| Input { robot: turn.robot, at: turn.at, bytes }).collect();
        world.finish(&inputs);
    }
    let [alice, bob] = [0, 1].map(|robot| world.robot(robot).motion().pose.position);
    (alice - bob).norm()
}

#[test]
fn robots_that_call_each_other_meet_however_loud_another_tone_is() {
    let met = distance_m(&[]);
    // The whistle adds 0.07 to what alice hears.
    assert!((0.95..1.15).contains(&met), "{met}");
    let all = [
        "robots.alice.sensors.ear.band_hz=[20.0, 20000.0]",
        "robots.bob.sensors.ear.band_hz=[20.0, 20000.0]",
    ];
    let kept_off = distance_m(&all);
    assert!(kept_off > 3.0, "{kept_off}");
}

#[test]
fn a_microphones_noise_is_normal_and_never_below_silence() {
    let sensor = "kind = \"microphone\"\nnoise = { additive = 0.1 }";
    let mut levels = singles(&with_sensor("step_ms = 0.05", sensor), SAMPLES);
    // In silence every second reading would be negative.
    assert_rate(levels.iter().filter(|&&level| level == 0.0).count() as u64, SAMPLES as u64, 0.5);
    levels.retain(|&level| level > 0.0);
    assert_distributed(&mut levels, |scale| {
        move |level| (2.0 * normal(0.0, 0.1 * scale)(level) - 1.0).clamp(0.0, 1.0)
    });
}

#[test]
fn a_floor_sensor_reads_the_zone_under_it() {
    let zones = "[arena]\nfloor = 0.9\n[[arena.zones]]\nname = \"line\"\npoints_m = [[0.1, -1], [0.3, -1], [0.3, 1], [0.1, 1]]\nfloor = 0.1\n\
                 [[arena.zones]]\nname = \"spot\"\nx_m = 0.2\ny_m = 0.0\nradius_m = 0.05\nfloor = 0.5\n\
                 [[arena.zones]]\nname = \"charger\"\nx_m = 0.2\ny_m = 0.0\nradius_m = 0.5\ncharger_w = 1.0\n";
    let read = |x: f64, y: f64| {
        single(&with_sensor(zones, &format!("kind = \"floor\"\nmount = {{ x_m = {x:?}, y_m = {y:?} }}")))
    };
    near(read(0.0, 0.0), 0.9);
    near(read(0.2, 0.2), 0.1);
    near(read(0.2, 0.0), 0.5);
}

#[test]
fn a_floor_sensors_noise_stays_within_0_and_1() {
    let noisy = with_sensor(
        "step_ms = 0.05\n[arena]\nfloor = 0.5\n",
        "kind = \"floor\"\nmount = {}\nnoise = { uniform = 0.2 }",
    );
    assert_distributed(&mut singles(&noisy, SAMPLES), |scale| {
        crate::common::statistics::uniform(0.5 - 0.2 * scale, 0.5 + 0.2 * scale)
    });
    let wild = singles(
        &with_sensor("step_ms = 0.05", "kind = \"floor\"\nmount = {}\nnoise = { additive = 5.0 }"),
        20_000,
    );
    // The bare floor is white: every second reading is above 1.
    let ones = wild.iter().filter(|&&value| value == 1.0).count() as u64;
    assert!(wild.iter().all(|value| (0.0..=1.0).contains(value)));
    assert_rate(ones, 20_000, 0.5);
}

fn battery(more: &str) -> String {
    format!(
        "battery = {{ nominal_v = 10.0, capacity_mah = 1000.0, curve_share_v = [[0.0, 0.8], [1.0, 1.2]], {more} }}"
    )
}

fn gauged(top: &str, more: &str, robot: &str) -> World {
    world(&scene(top, &format!("{}\n{robot}", battery(more)), &named("s", "kind = \"battery\"")))
}

#[test]
fn a_battery_gauge_reads_voltage_and_charge() {
    let mut world = gauged("", "idle_w = 36.0, charge = 0.5", "motors = { kind = \"servo\", idle_w = 0.0 }");
    world.begin();
    all_near(view(&world, "s").sample, &[10.0, 0.5]);
    run(&mut world, 100, 0.0, 0.0);
    world.begin();
    // 36 W at 10 V are 3.6 A: of 3600 C one thousandth a second; meanwhile the voltage hardly sinks.
    let sample = view(&world, "s").sample;
    assert!(
        (sample[1] - 0.499).abs() < 1e-6 && (sample[0] - (8.0 + 4.0 * sample[1])).abs() < 1e-3,
        "{sample:?}"
    );
}

#[test]
fn internal_resistance_lowers_the_voltage_under_load() {
    let mut world = gauged(
        "",
        "idle_w = 16.0, charge = 0.5, internal_resistance_ohm = 1.0",
        "motors = { kind = \"servo\", idle_w = 0.0 }",
    );
    run(&mut world, 1, 0.0, 0.0);
    world.begin();
    // (10 − I) I = 16: 2 A, 8 V.
    assert!((view(&world, "s").sample[0] - 8.0).abs() < 1e-3, "{:?}", view(&world, "s").sample);
}

#[test]
fn an_empty_battery_stops_the_motors_and_may_end_the_run() {
    let mut world = gauged("", "idle_w = 100.0, charge = 0.005", "");
    run(&mut world, 20, 0.5, 0.5);
    assert!(world.robot(0).motion().speed_m_s > 0.02);
    run(&mut world, 500, 0.5, 0.5);
    assert!(world.robot(0).motion().speed_m_s.abs() < 1e-3, "{:?}", world.robot(0).motion());
    assert_eq!(world.ending(), None);

    let mut world = gauged("[end]\nbattery_empty = true\n", "idle_w = 100.0, charge = 0.005", "");
    run(&mut world, 500, 0.5, 0.5);
    assert_eq!(world.ending(), Some(&Ending::BatteryEmpty("r".into())));
}

#[test]
fn a_charger_fills_the_battery_of_who_stands_on_it() {
    let zone = |x: f64| {
        format!(
            "[[arena.zones]]\nname = \"dock\"\nx_m = {x:?}\ny_m = 0.0\nradius_m = 0.5\ncharger_w = 360.0\n"
        )
    };
    let share = |x: f64| {
        let mut world = gauged(&zone(x), "charge = 0.5", "motors = { kind = \"servo\", idle_w = 0.0 }");
        run(&mut world, 100, 0.0, 0.0);
        world.begin();
        view(&world, "s").sample[1]
    };
    // 360 W at 10 V are 36 A: a hundredth of 3600 C a second.
    assert!((share(0.0) - 0.51).abs() < 1e-4, "{}", share(0.0));
    near(share(5.0), 0.5);
}

#[test]
fn a_full_battery_takes_no_more() {
    let zone = "[[arena.zones]]\nname = \"dock\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 0.5\ncharger_w = 3600.0\n";
    let mut world = gauged(zone, "charge = 0.99", "");
    for _ in 0..500 {
        tick(&mut world, 0.0, 0.0);
        assert!(world.robot(0).battery().unwrap().1.charge_c <= 3600.0);
    }
    world.begin();
    near(view(&world, "s").sample[1], 1.0);
}

#[test]
fn a_battery_gauge_has_noise() {
    let toml = scene(
        "step_ms = 0.05",
        &battery("charge = 0.5"),
        &named("s", "kind = \"battery\"\nnoise = { additive = 0.01 }"),
    )
    .replace("motors", "# motors");
    let servo = toml.replace(
        "[robots.sensors.s]",
        "motors = { kind = \"servo\", idle_w = 0.0 }\nfirmware = { mode = \"poll\" }\n[robots.sensors.s]",
    );
    assert_distributed(&mut singles(&servo, SAMPLES), |scale| normal(10.0, 0.01 * scale));
    assert_eq!(first(&servo).len(), 2);
}
