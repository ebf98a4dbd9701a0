//! Programs of the user's own on a robot's microcontroller. They are built by `crates/sim/tests/programs/build.py`; `tester.c` does what it
//! is asked over the cable.

use std::sync::Arc;

use baudbot_sim::model::PortUse;
use baudbot_sim::{Input, Intervention, SimTime, World};

use crate::common::{BODY, world};

const TESTER: &str = include_str!("programs/tester.hex");
const FAST_TESTER: &str = include_str!("programs/tester_115200.hex");

/// A robot with the tester on its chip, `more` of its tables, and what is on its pins.
fn robot(hex: &str, more: &str, pins: &str) -> String {
    format!(
        "noise = false\nsubsteps = 10\n[[robots]]\nname = \"r\"\n{BODY}\n{more}\n[robots.pins]\n{pins}\n\
         [robots.microcontroller]\nprogram = {{ file = \"tester.hex\", hex = '''\n{hex}''' }}\n"
    )
}

const CABLE: &str = "link = { kind = \"uart\", baud = 9600, bits_per_character = 10 }";

const MOTORS: &str = "9 = \"motors.left.pwm\"\n8 = \"motors.left.direction\"\n10 = \"motors.right.pwm\"\n\
                      7 = \"motors.right.direction\"\n";

/// Writes at the end of the next tick, and gives the bytes that come up to the end of that many ticks, with instants.
fn ask(world: &mut World, bytes: &[u8], ticks: u64) -> Vec<(SimTime, u8)> {
    let mut heard = Vec::new();
    for tick in 0..ticks {
        let turn = world.begin()[0];
        let robot = world.robot(0);
        heard.extend(robot.unread_instants().iter().copied().zip(robot.unread().iter().copied()));
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if tick == 0 { bytes } else { &[] } }]);
    }
    heard
}

fn open(toml: &str) -> World {
    let mut world = world(toml);
    world.intervene(&Intervention::OpenPort { robot: "r".into(), port_use: PortUse::Open }).unwrap();
    world
}

fn bytes(heard: &[(SimTime, u8)]) -> Vec<u8> {
    heard.iter().map(|(_, byte)| *byte).collect()
}

fn word(heard: &[(SimTime, u8)]) -> u16 {
    let bytes = bytes(heard);
    assert!(bytes.len() >= 2, "{bytes:?}");
    u16::from_le_bytes([bytes[0], bytes[1]])
}

#[test]
fn a_byte_comes_back_after_two_characters_whatever_the_tick() {
    for step_ms in ["1.0", "10.0"] {
        let mut world = open(&format!("step_ms = {step_ms}\n{}", robot(TESTER, CABLE, "")));
        let heard = ask(&mut world, b"hello", 40);
        assert_eq!(bytes(&heard), b"hello", "step_ms = {step_ms}");
        let asked = world.scenario().step_ns;
        let first = heard[0].0.as_ns() - asked;
        // The command is there at 9600 baud; the chip's receiver has it half a bit before its end, and it answers at 16
        // MHz / 16 / 104.
        let character_ns = 10 * 1_000_000_000 / 9600;
        let late = first as i64 - 2 * character_ns;
        assert!((-60_000..20_000).contains(&late), "step_ms = {step_ms}: {late} ns");
        for pair in heard.windows(2) {
            // The receiver samples each 6.5 µs.
            let gap = pair[1].0.since(pair[0].0) as i64;
            assert!((gap - character_ns).abs() <= 7000, "step_ms = {step_ms}: {gap} ns");
        }
    }
}

#[test]
fn ubrr_8_at_16_mhz_is_understood_until_a_resonator_makes_it_worse() {
    let heard = |ppm: i32| {
        let link = "link = { kind = \"uart\", baud = 115200, bits_per_character = 10 }";
        let toml = robot(FAST_TESTER, link, "") + &format!("clock_ppm = {ppm}\n");
        bytes(&ask(&mut open(&format!("step_ms = 1.0\n{toml}")), b"The quick brown fox.", 10))
    };
    // 111,111 baud: 3.5 % too slow.
    assert_eq!(heard(0), b"The quick brown fox.");
    assert_eq!(heard(5_000), b"The quick brown fox.");
    assert_ne!(heard(-20_000), b"The quick brown fox.");
    assert_eq!(heard(35_000), b"The quick brown fox.");
}

#[test]
fn the_adc_measures_the_sensors() {
    let toml = robot(
        TESTER,
        &format!(
            "{CABLE}\nsensors.ir = {{ kind = \"ir\", bearing_rad = 0.0, rays = 5, opening_rad = 0.5, range_m = 1.0, \
             c1_m2 = 0.03, c2 = 0.1, bits = 10 }}\nsensors.floor = {{ kind = \"floor\", mount = {{ x_m = 0.1 }} }}"
        ),
        "A0 = \"sensors.ir\"\nA1 = { to = \"sensors.floor\", volts_at_0 = 1.0, volts_per_unit = 2.0 }",
    );
    let wall = "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[0.6, -1.0], [0.8, -1.0], [0.8, 1.0], [0.6, 1.0]]\n";
    let mut world = open(&(toml + wall));
    let read = word(&ask(&mut world, b"A\0", 3));
    // Five rays of an opening of 0.5 rad, 0.6 m and more away: c1 / d² + c2, of 1.
    assert!((100..300).contains(&read), "{read}");
    // The floor is white without zones: 3 V.
    assert_eq!(word(&ask(&mut world, b"A\x01", 3)), 614);
}

#[test]
fn motors_do_what_the_pins_say() {
    let mut world = open(&robot(TESTER, CABLE, MOTORS));
    ask(&mut world, &[b'M', 60, 60], 200);
    let motion = world.robot(0).motion();
    assert!(motion.speed_m_s > 0.1 && motion.turn_rate_rad_s.abs() < 1e-9, "{motion:?}");
    let signals = world.robot(0).signals();
    // 120 of 255, and a step of the counter more.
    assert!((signals.left - 121.0 / 256.0).abs() < 1e-3 && signals.left == signals.right, "{signals:?}");
    ask(&mut world, &[b'M', 196, 60], 200);
    let motion = world.robot(0).motion();
    assert!(motion.turn_rate_rad_s > 0.1 && motion.speed_m_s.abs() < 0.01, "{motion:?}");
}

#[test]
fn a_driver_that_coasts_lets_motors_roll_on_and_one_that_brakes_stops_them() {
    let speed_after = |decay: &str| {
        let pins = format!(
            "9 = {{ to = \"motors.left.pwm\", decay = \"{decay}\" }}\n8 = \"motors.left.direction\"\n\
             10 = {{ to = \"motors.right.pwm\", decay = \"{decay}\" }}\n7 = \"motors.right.direction\"\n"
        );
        let motors =
            "motors = { resistance_ohm = 0.1, coulomb_friction_nm = 0.0, viscous_friction_nm_s = 0.0 }";
        let mut world = open(&robot(TESTER, &format!("{CABLE}\n{motors}"), &pins));
        ask(&mut world, &[b'M', 60, 60], 300);
        let before = world.robot(0).motion().speed_m_s;
        ask(&mut world, b"E", 12);
        world.robot(0).motion().speed_m_s / before
    };
    let (brakes, coasts) = (speed_after("brake"), speed_after("coast"));
    assert!(brakes < 0.75 * coasts && coasts > 0.5, "{brakes} and {coasts}");
}

#[test]
fn encoders_give_an_edge_for_each_mark() {
    let more = format!(
        "{CABLE}\nsensors.encoders = {{ kind = \"encoders\", counts_per_turn = 64, quadrature = false }}"
    );
    let pins = format!("{MOTORS}2 = \"encoders.left.a\"\n3 = \"encoders.right.a\"\n");
    let mut world = open(&robot(TESTER, &more, &pins));
    ask(&mut world, &[b'M', 90, 40], 500);
    ask(&mut world, &[b'M', 0, 0], 300);
    let travel_m = world.robot(0).motion().travel_m;
    let counts = bytes(&ask(&mut world, b"C", 3));
    let counts = [0, 2].map(|at| f64::from(u16::from_le_bytes([counts[at], counts[at + 1]])));
    for (count, travel_m) in counts.into_iter().zip([travel_m.left, travel_m.right]) {
        let expected = travel_m / (core::f64::consts::TAU * 0.1) * 64.0;
        assert!(expected > 20.0 && (count - expected).abs() <= 1.5, "{count} and {expected}");
    }
}

#[test]
fn a_ping_is_as_long_as_the_sound_travels() {
    let more =
        format!("{CABLE}\nsensors.sonar = {{ preset = \"ping\", mount = {{ x_m = 0.0 }}, detection = 1.0 }}");
    let wall = "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[1.0, -1.0], [1.2, -1.0], [1.2, 1.0], [1.0, 1.0]]\n";
    let mut world = open(&(robot(TESTER, &more, "4 = \"sensors.sonar\"") + wall));
    let read_us = 4.0 * f64::from(word(&ask(&mut world, b"P", 6)));
    let expected_us = 2.0 / 343.4 * 1e6;
    assert!((read_us - expected_us).abs() < 30.0, "{read_us} and {expected_us}");
}

#[test]
fn a_whisker_pulls_its_pin_down() {
    let toml = |x: f64| {
        let more = format!("start = {{ x_m = {x} }}\n{CABLE}\nsensors.whisker = {{ preset = \"whisker\" }}");
        let wall = "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[1.0, -1.0], [1.2, -1.0], [1.2, 1.0], [1.0, 1.0]]\n";
        robot(TESTER, &more, "5 = \"sensors.whisker\"") + wall
    };
    assert_eq!(bytes(&ask(&mut open(&toml(0.75)), b"W", 4)), b"0");
    assert_eq!(bytes(&ask(&mut open(&toml(0.5)), b"W", 4)), b"1");
}

/// A module over a line is low over white, with the other side chosen over black, and its screw says from where on.
#[test]
fn a_comparator_gives_its_pin_a_level() {
    let level = |x_m: f64, options: &str| {
        let more = format!(
            "start = {{ x_m = {x_m} }}\n{CABLE}\nsensors.line = {{ kind = \"floor\", mount = {{ x_m = 0.1 }} }}"
        );
        let pins = format!("5 = {{ to = \"sensors.line\", {options} }}");
        let floor = "[arena]\nfloor = 0.9\n[[arena.zones]]\nname = \"line\"\nfloor = 0.1\npoints_m = [[1, -1], [2, -1], [2, 1], [1, 1]]\n";
        bytes(&ask(&mut open(&(robot(TESTER, &more, &pins) + floor)), b"W", 4))
    };
    let (white, black) = (0.0, 1.2);
    // 0.5 V over white, 4.5 V over black.
    for (options, levels) in [
        ("threshold_v = 2.5", [b"0", b"1"]),
        ("threshold_v = 2.5, low_when = \"above\"", [b"1", b"0"]),
        ("threshold_v = 0.4, hysteresis_v = 0.0", [b"1", b"1"]),
        ("threshold_v = 4.6", [b"0", b"0"]),
    ] {
        assert_eq!([level(white, options), level(black, options)], levels, "{options}");
    }
}

#[test]
fn a_person_presses_a_button_and_turns_a_potentiometer() {
    let operations = "operations = [{ at_s = 0.5, control = \"buttons.start\", for_s = 0.3 }, \
                      { at_s = 0.5, control = \"potentiometers.speed\", position = 0.25 }]";
    let toml = |options: &str| {
        let pins = format!("5 = {{ to = \"buttons.start\", {options} }}\nA0 = \"potentiometers.speed\"");
        robot(TESTER, &format!("{CABLE}\n{operations}"), &pins)
    };
    for (options, levels) in [("bounce_ms = 1", [b"1", b"0", b"1"]), ("pull = \"down\"", [b"0", b"1", b"0"])]
    {
        let mut world = open(&toml(options));
        let mut turned = Vec::new();
        for (i, level) in levels.into_iter().enumerate() {
            let until_s = [0.4, 0.6, 0.9][i];
            while world.time().as_seconds() < until_s {
                ask(&mut world, &[], 1);
            }
            assert_eq!(bytes(&ask(&mut world, b"W", 4)), level, "{options} before {until_s} s");
            turned.push(word(&ask(&mut world, b"A0", 6)));
        }
        assert_eq!(turned, [0, 256, 256]);
    }
}

#[test]
fn servos_obey_the_width_of_their_pulses_and_stand_without() {
    let pins = "11 = \"motors.left\"\n12 = \"motors.right\"\n";
    let more = format!("{CABLE}\nmotors = {{ preset = \"parallax-servo\" }}");
    let mut world = open(&robot(TESTER, &more, pins));
    for _ in 0..20 {
        // About 1.7 ms and 1.3 ms: both wheels forwards.
        ask(&mut world, &[b'V', 255, 255], 1);
        ask(&mut world, &[], 1);
    }
    let signals = world.robot(0).signals();
    assert!(signals.left < -0.5 && signals.right > 0.5, "pulses of 1 ms: {signals:?}");
    ask(&mut world, &[], 20);
    assert_eq!([world.robot(0).signals().left, world.robot(0).signals().right], [0.0, 0.0]);
}

#[test]
fn a_run_that_is_saved_and_loaded_in_the_middle_goes_on_to_the_same_bits() {
    let more = format!(
        "{CABLE}\nsensors.encoders = {{ kind = \"encoders\", counts_per_turn = 64, quadrature = false }}"
    );
    let toml = robot(TESTER, &more, &format!("{MOTORS}2 = \"encoders.left.a\"\n"));
    let mut world = open(&toml);
    ask(&mut world, b"K!", 3);
    ask(&mut world, &[b'M', 90, 40], 7);
    for _ in 0..40 {
        ask(&mut world, b"C", 1);
        let mut again = World::load(Arc::clone(world.origin()), &world.save(), world.hash()).unwrap();
        let (mut other, mut copy) = (again.clone(), world.clone());
        let heard = [&mut again, &mut other, &mut copy].map(|world| (ask(world, b"CR", 5), world.hash()));
        assert_eq!(heard[0], heard[1]);
        assert_eq!(heard[0], heard[2]);
    }
}

#[test]
fn the_eeprom_outlives_a_reset_and_the_bootloader_makes_the_robot_wait() {
    let toml = robot(TESTER, CABLE, "") + "bootloader_s = 0.2\n";
    let mut world = open(&toml);
    assert_eq!(bytes(&ask(&mut world, b"x", 10)), b"", "it is not there yet");
    ask(&mut world, &[], 15);
    assert_eq!(bytes(&ask(&mut world, b"y", 4)), b"y");
    ask(&mut world, b"K!", 3);
    world.intervene(&Intervention::ResetBoard { robot: "r".into() }).unwrap();
    assert_eq!(bytes(&ask(&mut world, b"x", 10)), b"");
    ask(&mut world, &[], 15);
    assert_eq!(bytes(&ask(&mut world, b"R", 4)), b"!");
}

#[test]
fn two_robots_with_one_program_do_not_disturb_each_other() {
    let one = robot(TESTER, CABLE, MOTORS);
    let second = one
        .split_once("[[robots]]")
        .unwrap()
        .1
        .replace("name = \"r\"", "name = \"s\"\nstart = { x_m = 3.0 }");
    let mut alone = open(&one);
    let mut both = open(&format!("{one}\n[[robots]]{second}"));
    for world in [&mut alone, &mut both] {
        ask(world, &[b'M', 90, 40], 100);
    }
    assert_eq!(alone.robot(0).motion(), both.robot(0).motion());
    assert_eq!(both.robot(1).motion().speed_m_s, 0.0);
}

#[test]
fn a_rate_that_is_changed_by_hand_is_that_of_the_laptops_end() {
    let mut world = open(&format!("step_ms = 1.0\n{}", robot(TESTER, CABLE, "")));
    let set = |world: &mut World, baud: u32| {
        world.intervene(&Intervention::SetBaud { robot: "r".into(), baud }).unwrap();
    };
    set(&mut world, 19_200);
    assert_ne!(bytes(&ask(&mut world, b"hello", 30)), b"hello");
    set(&mut world, 9600);
    ask(&mut world, &[], 20);
    assert_eq!(bytes(&ask(&mut world, b"hello", 30)), b"hello");
}
