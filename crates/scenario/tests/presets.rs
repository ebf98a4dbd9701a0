//! Presets: each is sound and does what the real thing does, and scenarios are filled from them as promised.

use std::f64::consts::TAU;

use crate::common::{ARSIM, refusal, run, tick, world};
use baudbot_fields::number::Number;
use baudbot_scenario::Override;
use baudbot_scenario::presets::{Preset, PresetKind, preset, presets};
use baudbot_sim::actuator::ActuatorKind;
use baudbot_sim::link::{Adapter, Ftdi, Link};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::port::Format;
use baudbot_sim::sensor::{Device, Sensor};
use baudbot_sim::{Scenario, World};

/// Encoders, which regulated motors need.
const BODY: &str = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n\
                    sensors.encoders = { kind = \"encoders\", counts_per_turn = 600 }\n";

fn of_kind(kind: PresetKind) -> impl Iterator<Item = &'static Preset> {
    presets().filter(move |preset| preset.kind == kind)
}

fn robot(fields: &str) -> String {
    format!("[[robots]]\nname = \"r\"\n{fields}")
}

fn parse(toml: &str, sets: &[&str]) -> Scenario {
    let sets: Vec<_> = sets.iter().map(|set| Override::parse(set).unwrap()).collect();
    baudbot_scenario::parse_with(toml, &sets).unwrap_or_else(|error| panic!("{error} in:\n{toml}"))
}

/// The robot of a preset, with changed `fields`.
fn spec(name: &str, fields: &str) -> RobotSpec {
    let scenario = preset_robot(name, fields, &[]);
    scenario.robots[0].clone()
}

fn preset_robot(name: &str, fields: &str, sets: &[&str]) -> Scenario {
    let sets: Vec<_> = sets.iter().map(|set| format!("robots.r.{set}")).collect();
    let sets: Vec<_> = sets.iter().map(String::as_str).collect();
    parse(&robot(&format!("preset = \"{name}\"\n{fields}")), &sets)
}

fn sensor<'a>(spec: &'a RobotSpec, name: &str) -> &'a Sensor {
    spec.sensors.iter().find(|sensor| sensor.name == name).unwrap_or_else(|| panic!("no sensor {name}"))
}

fn names(spec: &RobotSpec) -> Vec<&str> {
    spec.sensors.iter().map(|sensor| sensor.name.as_str()).collect()
}

/// A robot with this sensor.
fn with_sensor(name: &str, fields: &str) -> Sensor {
    let toml = robot(&format!("{BODY}sensors.s = {{ preset = \"{name}\"{fields} }}"));
    sensor(&parse(&toml, &[]).robots[0], "s").clone()
}

#[test]
fn every_robot_stands_alone_in_an_empty_world_in_steps_of_10_ms() {
    for preset in of_kind(PresetKind::Robot) {
        let scenario = preset_robot(preset.name, "", &[]);
        assert_eq!((scenario.step_ns, scenario.substeps), (10_000_000, 1), "{}", preset.name);
        assert!(preset.description.contains("one substep of 10 ms is enough"), "{}", preset.name);
    }
}

#[test]
fn every_part_fits_a_robot() {
    for preset in presets().filter(|preset| preset.kind != PresetKind::Robot) {
        let (part, more) = match preset.kind {
            PresetKind::Sensor => ("sensors.s", ""),
            PresetKind::Actuator => ("actuators.a", ""),
            PresetKind::Adapter => ("link.adapter", "link.preset = \"uart-115200\"\n"),
            PresetKind::Robot
            | PresetKind::Motors
            | PresetKind::Microcontroller
            | PresetKind::Link
            | PresetKind::Battery => (preset.kind.word(), ""),
        };
        // The Pololu's gears make ARSim's body stiff.
        let toml =
            format!("substeps = 100\n{}", robot(&format!("{BODY}{more}{part}.preset = \"{}\"", preset.name)));
        parse(&toml, &[]);
    }
}

#[test]
fn no_robot_is_worth_a_warning() {
    for preset in of_kind(PresetKind::Robot) {
        let warnings = baudbot_scenario::warnings(&preset_robot(preset.name, "", &[]));
        assert!(warnings.is_empty(), "{}: {}", preset.name, warnings[0]);
    }
}

/// Speed after 5 s of these signals, in m/s and rad/s. Brains that hurry would clog slow cables.
fn speeds(name: &str, left: f64, right: f64) -> (f64, f64) {
    let mut world = World::new(preset_robot(name, "", &[]).into());
    for i in 0..500 {
        if i % 25 == 0 {
            tick(&mut world, left, right);
        } else {
            world.begin();
            world.finish(&[]);
        }
    }
    let motion = world.robot(0).motion();
    (motion.speed_m_s, motion.turn_rate_rad_s)
}

#[test]
fn robots_are_as_fast_as_the_real_ones() {
    // The turn rate is twice the speed over the track if the maker gives none.
    let real = [
        ("khepera-1", 0.5, 18.9),
        ("khepera-2", 0.5, 18.9),
        ("e-puck", 0.1288, 4.86),
        ("thymio-2", 0.126, 2.68),
        ("boe-bot", 0.168, 3.2),
        ("turtlebot3-burger", 0.22, 2.84),
        ("create-1", 0.5, 3.88),
        ("create-2", 0.5, 4.26),
        ("chalmers-40cm", 0.8, 4.7),
        // These robots have no maker: the rates follow from their motors' numbers.
        ("uno-rover", 1.0, 10.5),
        ("boe-bot-shield", 0.168, 3.2),
        ("line-follower", 0.655, 14.5),
        ("arsim", 0.7851, 4.512),
    ];
    assert_eq!(real.len(), of_kind(PresetKind::Robot).count());
    for (name, speed, turn_rate) in real {
        let (found, turning) = speeds(name, 1.0, 1.0);
        assert!(
            (found / speed - 1.0).abs() < 0.15 && turning.abs() < 0.3,
            "{name}: {found} m/s, {turning} rad/s"
        );
        let (moving, found) = speeds(name, -1.0, 1.0);
        assert!(
            (found / turn_rate - 1.0).abs() < 0.15 && moving.abs() < 0.05,
            "{name}: {found} rad/s, {moving} m/s"
        );
    }
}

#[test]
fn an_epuck_drives_at_12_88_cm_a_second() {
    assert!((speeds("e-puck", 1.0, 1.0).0 - 0.1288).abs() < 5e-5);
}

/// A Create 2 alone in the open that gets these signals at 0.5 s over its cable, in steps of 1 ms: from the command
/// until it moves, and until it has 63 % of its last speed, in s. Speeds are the true ones.
fn response(left: f64, right: f64, speed: fn(&World) -> f64) -> [f64; 2] {
    let toml = format!("noise = false\nstep_ms = 1.0\n{}", robot("preset = \"create-2\"\n"));
    let mut world = World::new(parse(&toml, &[]).into());
    let speeds: Vec<_> = (0..2000)
        .map(|i| {
            if i == 500 {
                tick(&mut world, left, right);
            } else {
                world.begin();
                world.finish(&[]);
            }
            speed(&world).abs()
        })
        .collect();
    let after = |share: f64| {
        let reached = speeds.iter().position(|speed| *speed > share * speeds[1999]).unwrap();
        (reached as f64 - 500.0) * 1e-3
    };
    [after(1e-6), after(1.0 - (-1.0_f64).exp())]
}

#[test]
fn a_create_moves_as_long_after_a_command_as_five_creates_did() {
    // MRCLAM runs 6 and 7: turns begin 0.08 to 0.12 s after the command, and lag and dead time together are 0.17 to 0.28 s,
    // 0.22 in the mean. Runs forward take 0.24 s and more.
    let turn = |signal: f64| response(-signal, signal, |world| world.robot(0).motion().turn_rate_rad_s);
    for signal in [0.13, -0.05] {
        let [begin, most] = turn(signal);
        assert!((0.08..=0.12).contains(&begin), "{begin}");
        assert!((most - 0.22).abs() < 0.01, "{most}");
        assert!((0.05..=0.2).contains(&(most - begin)), "{begin} {most}");
    }
    let [begin, most] = response(0.17, 0.17, |world| world.robot(0).motion().speed_m_s);
    assert!((0.08..=0.12).contains(&begin) && (0.17..=0.28).contains(&most), "{begin} {most}");
}

#[test]
fn a_thymio_falls_behind_at_high_speeds_as_a_measured_one_did() {
    // CharlieLeee/Mobile_Soccer, calibration/cali.md: units, seconds from a standstill, centimetres.
    for (units, seconds, cm) in
        [(100.0, 5, 16.0), (200.0, 5, 31.5), (300.0, 2, 18.0), (400.0, 2, 22.0), (500.0, 2, 24.0)]
    {
        let mut world = World::new(preset_robot("thymio-2", "", &[]).into());
        run(&mut world, 100 * seconds, units / 500.0, units / 500.0);
        let found = 100.0 * world.robot(0).counters().distance_m;
        assert!((found / cm - 1.0).abs() < 0.1, "{units}: {found} cm, not {cm}");
        // The rest of 10 % is for its noise; without it the curve fits much better.
        let mut even =
            World::new(parse(&format!("noise = false\n{}", robot("preset = \"thymio-2\"")), &[]).into());
        run(&mut even, 100 * seconds, units / 500.0, units / 500.0);
        let found = 100.0 * even.robot(0).counters().distance_m;
        assert!((found / cm - 1.0).abs() < 0.04, "{units}: {found} cm, not {cm}");
    }
}

#[test]
fn an_epucks_motors_make_the_rates_of_its_firmware_and_save_power_when_slow() {
    let Motors::Stepper(stepper) = spec("e-puck", "").drive.motor.clone() else { panic!("no stepper") };
    for (asked, ticks) in
        [(1000, 10), (950, 10), (900, 11), (800, 12), (700, 14), (600, 16), (500, 20), (400, 25), (300, 33)]
    {
        let found = stepper.pulses_per_s(f64::from(asked) / 1000.0);
        assert_eq!(found, 10_000.0 / f64::from(ticks), "{asked}");
        assert!(found <= stepper.max_rate_steps_s.map_or(f64::INFINITY, Number::get), "{found}");
    }
    let share = |signal: f64| stepper.power_w(signal) / stepper.holding_w;
    assert!((share(0.5) - 500.0 / 650.0).abs() < 1e-3, "{}", share(0.5));
    assert_eq!((share(0.0), share(1.0)), (0.0, 1.0));
    // Through its cable: 800 is a code of 11 bits, and 833 steps/s are made of it.
    let (speed, _) = speeds("e-puck", 0.8, 0.8);
    assert!((speed - TAU * 0.0205 * 10.0 / 12.0).abs() < 1e-9, "{speed}");
}

/// Charge in mAh and mean voltage of a cell that the four of the preset give at a constant current, if each holds so much.
fn discharge(capacity_mah: f64, current_a: f64) -> (f64, f64) {
    let fields = format!("battery = {{ preset = \"4xaa-nimh\", capacity_mah = {capacity_mah:?} }}");
    let battery = spec("boe-bot", &fields).battery.clone().unwrap();
    let (mut state, mut seconds, mut volts) = (battery.full(), 0.0, 0.0);
    loop {
        let voltage = state.voltage_v(&battery, current_a);
        let before = state.charge_c;
        if voltage <= 0.0 || state.draw(&battery, voltage * current_a, 1.0) <= 0.0 {
            return (current_a * seconds / 3.6, volts / seconds / 4.0);
        }
        // The last second is not a whole one.
        let whole = (battery.yield_at(current_a) * (before - state.charge_c) / current_a).min(1.0);
        (seconds, volts) = (seconds + whole, volts + whole * voltage);
    }
}

#[test]
fn aa_cells_give_less_charge_and_a_lower_voltage_the_more_current_is_drawn() {
    // GP EkoPower of 1050 mAh (rightbattery.com).
    for (current_a, mah, volts) in
        [(0.2, 991.0, 1.216), (0.5, 910.0, 1.146), (1.0, 747.0, 1.068), (2.0, 12.0, 1.0)]
    {
        let (found_mah, found_v) = discharge(1050.0, current_a);
        assert!((found_mah / mah - 1.0).abs() < 0.05, "{current_a} A: {found_mah} mAh, not {mah}");
        assert!((found_v / volts - 1.0).abs() < 0.13, "{current_a} A: {found_v} V, not {volts}");
        if current_a <= 1.0 {
            assert!((found_mah / mah - 1.0).abs() < 0.01, "{current_a} A: {found_mah} mAh, not {mah}");
            assert!((found_v / volts - 1.0).abs() < 0.02, "{current_a} A: {found_v} V, not {volts}");
        }
    }
}

#[test]
fn a_boe_bot_drives_for_two_thirds_of_the_time_that_the_charge_of_its_cells_would_last() {
    // Two servos of 1.2 W and 0.2 W of electronics are 0.54 A at 4.8 V: 0.2 Ah would last for 1330 s. The last tenth of the
    // charge has a lower voltage, so some 0.65 A, which get 0.8 of it.
    let mut world = World::new(preset_robot("boe-bot", "battery = { charge = 0.1 }", &[]).into());
    let mut seconds = 0;
    while world.robot(0).battery().is_some_and(|(battery, state)| !state.is_empty(battery)) {
        for i in 0..100 {
            if i % 25 == 0 {
                tick(&mut world, 0.2, 0.25);
            } else {
                world.begin();
                world.finish(&[]);
            }
        }
        seconds += 1;
    }
    assert!((800..1000).contains(&seconds), "{seconds}");
}

/// Positions of a receiver that stands still, in metres east of the true place, one a second.
fn easts(seconds: usize) -> Vec<f64> {
    let toml = robot("motors = { kind = \"stepper\" }\nsensors.s = { preset = \"gps-garmin-15\" }\n");
    let body = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
    let mut world = World::new(parse(&format!("step_ms = 1000.0\n{toml}{body}"), &[]).into());
    let mut easts = Vec::new();
    for _ in 0..seconds {
        world.begin();
        let view = world.robot(0).sensors().next().unwrap();
        easts.push(view.sample.get(1).copied().unwrap_or(0.0) * 6_371_008.8 * TAU / 360.0);
        world.finish(&[]);
    }
    easts.split_off(2)
}

#[test]
fn a_garmins_error_bends_at_a_minute_falls_slowly_and_is_1_5_m_in_twelve_minutes() {
    let errors = easts(200_000);
    let mean_square = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    let at = |lag: usize| {
        let products: f64 = errors.iter().zip(&errors[lag..]).map(|(a, b)| a * b).sum();
        products / (errors.len() - lag) as f64 / mean_square(&errors)
    };
    // The loss of the correlation in each minute: much in the first, less in those that follow.
    let falls = [0, 60, 180, 300].map(|lag| (at(lag.max(1)) - at(lag + 60)) / at(lag.max(1)));
    assert!(falls[0] > 1.5 * falls[2] && falls[0] > 1.2 * falls[1], "{falls:?}");
    assert!(at(300) > 0.15 && at(300) < 0.45, "{}", at(300));
    let windows: Vec<_> = errors
        .chunks_exact(700)
        .map(|window| {
            let mean = window.iter().sum::<f64>() / 700.0;
            mean_square(window) - mean * mean
        })
        .collect();
    let deviation = (windows.iter().sum::<f64>() / windows.len() as f64).sqrt();
    assert!((deviation - 1.5).abs() < 0.1, "{deviation}");
}

#[test]
fn presets_have_the_numbers_that_were_confirmed() {
    let counts = |spec: &RobotSpec| {
        let Device::Encoders(encoders) = &sensor(spec, "encoders").device else { panic!("no encoders") };
        encoders.counts_per_turn
    };
    // AutonomyLab/libcreate: wheels of 72.1 mm by callipers, 508.8 counts a turn.
    let create = spec("create-2", "");
    assert!((create.drive.wheel_radius_m - 0.03605).abs() < 1e-4, "{}", create.drive.wheel_radius_m);
    assert!((f64::from(counts(&create)) / 508.8 - 1.0).abs() < 5e-4, "{}", counts(&create));
    // ROBOTIS-GIT/turtlebot3, burger.yaml.
    let burger = spec("turtlebot3-burger", "");
    assert_eq!((burger.drive.half_track_m, burger.drive.wheel_radius_m), (0.080, 0.033));
    // nihakue/pykhepera and Player: 12 counts a millimetre, a unit of speed of 8 mm/s, wheels 53 mm apart.
    for name in ["khepera-1", "khepera-2"] {
        let khepera = spec(name, "");
        let per_mm = f64::from(counts(&khepera)) / (TAU * khepera.drive.wheel_radius_m * 1e3);
        assert!((per_mm / 12.0 - 1.0).abs() < 0.01, "{name}: {per_mm}");
        let unit_mm_s = 1.0 / per_mm / 10e-3;
        assert!((unit_mm_s / 8.0 - 1.0).abs() < 0.05, "{name}: {unit_mm_s}");
        assert_eq!((counts(&khepera), khepera.drive.half_track_m), (600, 0.0265), "{name}");
    }
    // kriswiner/MPU6050: 0.5 to several degrees a minute.
    let drift = with_sensor("mpu-6050-gyro", "").noise.drift.unwrap();
    let per_minute = drift.sigma.to_degrees() * 60.0;
    assert!((0.5..=5.0).contains(&per_minute), "{per_minute}");
    // emesystems.com: 140 µs for an output, 290 µs for a jump.
    let stamp = spec("boe-bot", "").processor.operations_per_s.unwrap();
    assert!((1.0 / 290e-6..=1.0 / 140e-6).contains(&stamp), "{stamp}");
    // arduino/ArduinoCore-avr, HardwareSerial.h.
    let chalmers = spec("chalmers-40cm", "");
    assert!(matches!(&chalmers.link, Link::Uart(uart) if uart.receive_depth == 64));
}

#[test]
fn arsims_robot_is_that_of_its_scenario_to_the_bit() {
    let (arena, robot) = ARSIM.split_once("[[robots]]").unwrap();
    assert!(robot.contains("x_m = -0.2"));
    let filled = format!(
        "{arena}[[robots]]\nname = \"robot\"\npreset = \"arsim\"\nstart = {{ x_m = -0.2, y_m = 0.0 }}\n"
    );
    let mut worlds = [world(ARSIM), world(&filled)];
    for world in &mut worlds {
        run(world, 200, 0.4, 1.2);
    }
    assert_eq!(worlds[0].robots().len(), 1);
    assert_eq!(worlds[0].hash(), worlds[1].hash());
}

#[test]
fn a_khepera_reads_a_sensor_every_2_5_ms_and_each_every_20_ms() {
    for name in ["khepera-1", "khepera-2"] {
        let spec = spec(name, "");
        let irs = spec.sensors.iter().filter(|sensor| matches!(sensor.device, Device::Infrared(_)));
        let times: Vec<_> = irs.map(|ir| (ir.schedule.period_ns(), ir.schedule.phase_ns())).collect();
        let expected: Vec<_> = (0..8).map(|i| (20_000_000, i * 2_500_000)).collect();
        assert_eq!(times, expected, "{name}");
    }
}

/// The servo of Fig. 1.14. The seconds for 60° are those without load at 4.8 and 6 V.
#[test]
fn a_hitec_645_turns_60_degrees_in_its_time_and_ignores_8_us() {
    for (name, seconds) in [("hs-645mg", 0.24), ("hs-645mg-6v", 0.2)] {
        let scenario = parse(&robot(&format!("{BODY}actuators.neck = {{ preset = \"{name}\" }}")), &[]);
        let ActuatorKind::Turret(servo) = &scenario.robots[0].actuators[0].kind else {
            panic!("{name}: no turret")
        };
        let steps = (seconds * 1000.0) as usize;
        let angle = (0..steps).fold(0.0, |angle, _| servo.step(angle, TAU / 4.0, 0.001));
        assert!((angle - TAU / 6.0).abs() < 0.001, "{name}: {angle}");
        // 180° from 600 to 2400 µs.
        let us = |us: f64| servo.target_rad(us / 900.0);
        assert_eq!((us(-900.0), us(900.0)), (-TAU / 4.0, TAU / 4.0));
        assert_eq!(servo.step(0.0, us(7.9), 1.0), 0.0, "{name}");
        assert!((servo.step(0.0, us(8.1), 1.0).to_degrees() - 0.81).abs() < 1e-9, "{name}");
    }
}

#[test]
fn a_boe_bots_servo_has_the_curve_of_its_manual() {
    let Motors::Servo(servo) = spec("boe-bot", "").drive.motor.clone() else { panic!("no servo") };
    let rpm = |pulse_us: f64| servo.target_rad_s((pulse_us - 1500.0) / 200.0) * 60.0 / TAU;
    for (pulse, expected) in [(1300.0, -48.0), (1400.0, -44.0), (1500.0, 0.0), (1600.0, 44.0), (1700.0, 48.0)]
    {
        assert!((rpm(pulse) - expected).abs() < 1e-9, "{pulse} {}", rpm(pulse));
    }
    let pulses: Vec<_> = (1300..=1700).step_by(10).map(|pulse| rpm(f64::from(pulse))).collect();
    assert!(
        pulses.is_sorted() && pulses.iter().rev().zip(&pulses).all(|(a, b)| (a + b).abs() < 1e-9),
        "{pulses:?}"
    );
}

#[test]
fn a_pings_echo_pulse_is_within_its_limits() {
    let sensor = with_sensor("ping", "");
    let Device::Sonar(sonar) = &sensor.device else { panic!("no sonar") };
    let shortest = sonar.echo_ns(0.0) as f64 * 1e-3;
    assert!((shortest - 115.0).abs() < 2.0, "{shortest}");
    assert!(sonar.echo_ns(sonar.max_m) < sonar.timeout_ns && sonar.timeout_ns == 18_500_000);
    // The time from the trigger until the next one may come: 19.45 ms at worst.
    let worst = sensor.acquisition_ns + sonar.holdoff_ns + sonar.timeout_ns;
    assert_eq!(worst, 19_455_000);
}

#[test]
fn a_gp2d12s_voltages_are_its_data_sheets() {
    let sensor = with_sensor("gp2d12", "");
    let Device::VoltageRanger(ranger) = &sensor.device else { panic!("no voltage") };
    let at = |distance| ranger.voltage_at(distance);
    assert!(
        (at(0.8) - 0.40).abs() < 1e-3 && (at(0.1) - at(0.8) - 2.0).abs() < 1e-3,
        "{} {}",
        at(0.1),
        at(0.8)
    );
    assert!(at(0.03) < at(0.06) && at(0.06) < at(0.05) && (at(0.03) - at(0.08)).abs() < 0.1, "no fold-back");
    let clock = sensor.own_clock.unwrap();
    assert_eq!((clock.period_ns, clock.spread_ns, clock.phase_ns), (38_300_000, 9_600_000, None));
}

#[test]
fn a_urgs_scan_is_a_message_of_2137_bytes() {
    let sensor = with_sensor("urg-04lx", "");
    let Device::Laser(laser) = &sensor.device else { panic!("no laser") };
    let step = TAU / 1024.0;
    let gaps = laser.fan.relative().len() - 1;
    let opening = 2.0 * laser.fan.kappas()[gaps];
    assert!(gaps == 681 && (opening / gaps as f64 - step).abs() < 1e-8, "{gaps} {opening}");
    let Format::Scip(format) = sensor.port.unwrap().format else { panic!("no SCIP") };
    assert_eq!((format.first_step, format.last_step, format.message_len()), (44, 725, 2137));
}

#[test]
fn a_pololu_turns_and_stalls_as_its_data_sheet_says() {
    let toml = format!("substeps = 100\n{}", robot(&format!("{BODY}motors.preset = \"pololu-37d-30-1\"")));
    let Motors::Dc(mut motor) = parse(&toml, &[]).robots[0].drive.motor.clone() else {
        panic!("no DC motor")
    };
    let no_load = 330.0 * TAU / 60.0;
    assert!(motor.torque_nm(1.0, 0.98 * no_load) > 0.0 && motor.torque_nm(1.0, 1.02 * no_load) < 0.0);
    assert!((motor.power_w(1.0, 0.0) / 12.0 - 5.5).abs() < 0.01);
    motor.max_torque_nm = 10.0;
    assert!((motor.torque_nm(1.0, 0.0) - 1.37).abs() < 0.02, "{}", motor.torque_nm(1.0, 0.0));
}

#[test]
fn no_preset_is_made_of_itself() {
    fn uses(preset: &Preset) -> Vec<&'static Preset> {
        let lines =
            preset.text.lines().filter_map(|line| line.strip_prefix("preset = \"")?.split('"').next());
        lines.map(|name| self::preset(name).unwrap_or_else(|| panic!("{}: {name}", preset.name))).collect()
    }
    for start in presets() {
        let mut below = uses(start);
        for _ in 0..presets().count() {
            assert!(below.iter().all(|used| used.name != start.name), "{}", start.name);
            below = below.into_iter().flat_map(uses).collect();
        }
        assert!(below.is_empty(), "{}", start.name);
    }
}

#[test]
fn every_file_is_a_preset() {
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/presets")).unwrap();
    let mut files: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    let mut known: Vec<_> = presets().map(|preset| format!("{}.toml", preset.name)).collect();
    files.sort();
    known.sort();
    assert_eq!(files, known);
}

#[test]
fn the_pages_of_presets_list_every_preset_and_their_examples_are_scenarios() {
    const DOCS: &str = include_str!("../../../docs/reference/presets.md");
    const LIST: &str = include_str!("../../../docs/reference/preset-list.md");
    for preset in presets() {
        let row = format!("| `{}` | {} |", preset.name, preset.description);
        assert!(LIST.contains(&row), "no row `{row}`");
    }
    let examples: Vec<_> =
        DOCS.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(examples.len(), 2);
    examples.into_iter().for_each(|example| drop(parse(example, &[])));
}

#[test]
fn what_the_file_says_wins_field_by_field() {
    let spec = spec(
        "khepera-1",
        "body = { mass_kg = 0.07 }\nlink = { baud = 38400 }\nsensors.ir_0 = { noise = { uniform = 0.0 } }",
    );
    assert_eq!((spec.drive.mass_kg, spec.drive.radius_m), (0.07, 0.0275));
    assert!(matches!(&spec.link, Link::Uart(uart) if uart.baud == 38_400 && uart.receive_depth == 2));
    let noise = &sensor(&spec, "ir_0").noise;
    assert_eq!((noise.uniform, noise.gain_spread), (0.0, 0.165));
    assert_eq!(sensor(&spec, "ir_1").noise.uniform, 0.01);
}

#[test]
fn a_table_of_another_kind_or_with_a_preset_of_its_own_takes_nothing_from_the_robots() {
    let other =
        spec("khepera-1", "link = { kind = \"ideal\" }\nmotors = { kind = \"stepper\", signal_bits = 8 }");
    assert_eq!(other.link, Link::Ideal);
    assert!(matches!(other.drive.motor, Motors::Stepper(_)));
    let own = spec("khepera-1", "link = { preset = \"uart-38400\" }\nmicrocontroller = { preset = \"bs2\" }");
    assert!(matches!(&own.link, Link::Uart(uart) if uart.baud == 38_400 && uart.receive_depth == 64));
    assert_eq!(own.processor.ram_bytes, Some(26));
    let polled = spec("thymio-2", "firmware = { mode = \"poll\" }");
    assert_eq!(polled.firmware.mode, baudbot_sim::firmware::Mode::Poll);
}

#[test]
fn another_way_to_say_it_drops_the_presets() {
    let fields = "[robots.sensors.ir_0]\nbearing_rad = 0.5\n\
                  [robots.sensors.ir_1]\nambient_saturation_lux = 500.0\n";
    let moved = spec("khepera-1", fields);
    let Device::Infrared(ir) = &sensor(&moved, "ir_0").device else { panic!("no IR") };
    assert_eq!(ir.mount.pose.heading, 0.5);
    let square = "body.outline_m = [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03]]";
    assert_eq!(spec("khepera-1", square).outline.len(), 4);
    assert_eq!(spec("thymio-2", "body.radius_m = 0.07").outline.len(), 0);
    let mounted = with_sensor("gp2d12", ", mount = { x_m = 0.1 }");
    assert!(matches!(mounted.device, Device::VoltageRanger(ranger) if ranger.mount.pose.position.x == 0.1));
}

/// The adapter of a link.
fn adapter(link: &Link) -> Adapter {
    let Link::Uart(uart) = link else { panic!("no uart: {link:?}") };
    uart.adapter
}

#[test]
fn adapters_have_presets_in_every_link_and_give_way_as_other_parts_do() {
    let down_ns = |link: &Link| match adapter(link) {
        Adapter::Cdc(frames) | Adapter::Ftdi(Ftdi { frames, .. }) => frames.down_ns,
        Adapter::None | Adapter::Bluetooth(_) => None,
    };
    let link = |fields: &str, sets: &[&str]| preset_robot("khepera-1", fields, sets).robots[0].link.clone();
    // In a link of the robot's preset, and in one of the link's own.
    let own = link("link = { adapter = { preset = \"ch340\" } }", &[]);
    assert_eq!(down_ns(&own), Some(43_000));
    let other =
        link("link = { preset = \"uart-115200\", adapter = { preset = \"ft232r\", latency_ms = 2 } }", &[]);
    assert!(matches!(adapter(&other), Adapter::Ftdi(ftdi) if ftdi.latency_ns == 2_000_000));
    assert_eq!(down_ns(&other), Some(80_000));
    // By overrides, and in place of a radio.
    let set = link("", &["link.adapter={ preset = \"atmega16u2\", jitter_us = 0 }"]);
    assert!(matches!(adapter(&set), Adapter::Cdc(frames) if frames.extra == 2 && frames.jitter_ns == 0));
    let cabled = spec("e-puck", "link = { adapter = { preset = \"ft232r-1ms\" } }").link.clone();
    assert!(matches!(adapter(&cabled), Adapter::Ftdi(ftdi) if ftdi.latency_ns == 1_000_000));
    // The adapter of a sensor's own cable.
    let laser = with_sensor(
        "urg-04lx",
        ", port = { link = { preset = \"uart-115200\", adapter = { preset = \"ch340\" } } }",
    );
    assert_eq!(down_ns(&laser.port.unwrap().link), Some(43_000));
    let message = refusal(&robot(&format!(
        "{BODY}link = {{ kind = \"uart\", baud = 9600, adapter.preset = \"usb\" }}"
    )));
    assert_eq!(message, "robots[0].link.adapter.preset: `usb` is a link, but an adapter is needed");
}

#[test]
fn radios_hold_what_was_measured() {
    let range_ms = |name: &str| {
        let toml = robot(&format!("{BODY}link.preset = \"{name}\""));
        let Adapter::Bluetooth(radio) = adapter(&parse(&toml, &[]).robots[0].link) else {
            panic!("no radio")
        };
        [radio.latency_ns - radio.spread_ns, radio.latency_ns + radio.spread_ns].map(|ns| ns as f64 * 1e-6)
    };
    // 100 commands by BLE: 108 ± 26 ms, four fifths of them from 77 to 140 ms (garretthagen21/OmniBot).
    let [least, most] = range_ms("ble");
    assert!(
        ((least + most) / 2.0 - 108.0).abs() < 1.0 && ((most - least) / 12_f64.sqrt() - 26.0).abs() < 0.1
    );
    let [p10, p90] = [0.1, 0.9].map(|share| least + share * (most - least));
    assert!((p10 - 77.0).abs() < 6.0 && (p90 - 140.0).abs() < 6.0, "{p10} {p90}");
    // A query, one packet there and two back: 30 to 80 ms. A message of several bytes, two packets: 120 ms.
    let [least, most] = range_ms("bluetooth");
    assert!(3.0 * least <= 30.0 && 3.0 * most >= 80.0 && 2.0 * most >= 120.0, "{least} {most}");
}

#[test]
fn sensors_can_be_left_out_and_added_behind_the_presets() {
    let fields = "without = [\"ir_6\", \"ir_7\", \"ir_0\", \"ir_6\"]\n\
                  [robots.sensors.zebra]\nkind = \"compass\"\nbits = 8\n\
                  [robots.sensors.ir_2]\nrange_m = 0.06\n\
                  [robots.sensors.abacus]\npreset = \"hmc6352\"\n";
    let spec = spec("khepera-1", fields);
    assert_eq!(names(&spec), ["ir_1", "ir_2", "ir_3", "ir_4", "ir_5", "encoders", "zebra", "abacus"]);
    let Device::Infrared(ir) = &sensor(&spec, "ir_2").device else { panic!("no IR") };
    assert_eq!((ir.range_m, ir.fan.len()), (0.06, 5));
}

#[test]
fn overrides_choose_presets_and_change_what_the_file_does_not_mention() {
    let chosen = preset_robot("khepera-1", "", &["preset=arsim"]);
    assert_eq!(names(&chosen.robots[0]), ["ir_left", "ir_right", "odometer"]);
    let chosen =
        parse(&robot("preset = \"khepera-1\""), &["robots[0].preset=khepera-2", "robots.r.body.mass_kg=0.1"]);
    assert_eq!((chosen.robots[0].drive.radius_m, chosen.robots[0].drive.mass_kg), (0.035, 0.1));
    let sets = ["sensors.ir_3.range_m=0.04", "link={ kind = \"ideal\" }", "without=[\"ir_0\"]"];
    let changed = preset_robot("khepera-1", "", &sets);
    let changed = &changed.robots[0];
    assert!(matches!(&sensor(changed, "ir_3").device, Device::Infrared(ir) if ir.range_m == 0.04));
    assert_eq!((&changed.link, changed.sensors.len()), (&Link::Ideal, 8));
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let refused = |fields: &str, expected: &str| {
        assert_eq!(refusal(&robot(fields)), expected);
    };
    refused(
        "preset = \"kephera\"",
        "robots[0].preset: there is no preset `kephera`; did you mean `khepera-1`, `khepera-2`? `baudbot preset` \
         lists all",
    );
    refused(
        "preset = \"xyzzyplugh\"",
        "robots[0].preset: there is no preset `xyzzyplugh`; `baudbot preset` lists all",
    );
    refused("preset = \"gp2d12\"", "robots[0].preset: `gp2d12` is a sensor, but a robot is needed");
    refused("preset = 3", "robots[0].preset: must be the name of a preset, is of type integer");
    refused(
        "without = [\"ir_6\"]",
        "robots[0].without: lists sensors of a `preset` to leave out, but there is no `preset`",
    );
    refused(
        "preset = \"arsim\"\nwithout = [\"ir_left\", \"ir_6\"]",
        "robots[0].without[1]: the preset has no sensor `ir_6`; there are: ir_left, ir_right, odometer",
    );
    refused(
        "preset = \"arsim\"\nwithout = \"ir_6\"",
        "robots[0].without: must be a list of sensors' names, is of type string",
    );
    let place = |place: &str| refusal(&robot(&format!("{BODY}{place}.preset = \"arsim\"")));
    assert_eq!(
        place("sensors.front"),
        "robots[0].sensors.front.preset: `arsim` is a robot, but a sensor is needed"
    );
    assert_eq!(
        place("sensors.s.port.link"),
        "robots[0].sensors.s.port.link.preset: `arsim` is a robot, but a link is needed"
    );
    assert_eq!(
        place("motors"),
        "robots[0].motors.preset: `arsim` is a robot, but a pair of motors is needed"
    );
    for part in ["microcontroller", "link", "battery"] {
        assert!(place(part).starts_with(&format!("robots[0].{part}.preset: `arsim` is a robot")), "{part}");
    }
    // A field that the preset's kind does not have is refused as if it stood there.
    let message = refusal(&robot("preset = \"arsim\"\nsensors.ir_left.colour = 3"));
    assert!(message.starts_with("robots[0].sensors.ir_left.colour: unknown field `colour`"), "{message}");
}

#[test]
fn nobody_makes_more_of_presets_than_there_may_be() {
    let many = "[[robots]]\nname=\"r\"\npreset=\"arsim\"\n".repeat(10_001);
    assert_eq!(refusal(&many), "robots: there are 10001, the limit is 10000");
    let sensors: String = (0..100_001).map(|i| format!("s{i}.preset=\"hmc6352\"\n")).collect();
    let message =
        refusal(&robot(&format!("{BODY}[robots.sensors]\n{sensors}").replace("sensors.encoders", "#")));
    assert!(message.ends_with("presets are used more than 100000 times"), "{message}");
}
