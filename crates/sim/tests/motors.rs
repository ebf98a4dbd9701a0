//! The effects of the kinds of motors on a robot in its world, and the errors of scenarios with them.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::common::{BODY, command, refusal, run, tick, world};
use baudbot_sim::motor::Steps;
use baudbot_sim::{Input, World};
use baudbot_wire::{frame, write_command};

const ENCODERS: &str = "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 600\n";

/// An e-puck's body: wheels of 41 mm, 53 mm apart.
const EPUCK: &str = "body = { radius_m = 0.035, mass_kg = 0.15, inertia_kg_m2 = 1e-4, wheel_radius_m = 0.0205, \
                     half_track_m = 0.0265 }";

fn robot(top: &str, body: &str, motors: &str) -> String {
    format!("{top}\n[[robots]]\nname = \"r\"\n{body}\nmotors = {{ {motors} }}\n")
}

fn speeds(world: &World) -> (f64, f64) {
    let motion = world.robot(0).motion();
    (motion.speed_m_s, motion.turn_rate_rad_s)
}

#[track_caller]
fn refused(motors: &str, expected: &str) {
    let message = refusal(&robot("", BODY, motors));
    assert!(message.starts_with(expected), "expected `{expected}` in: {message}");
}

/// (3.15), and the encoders that §3.2.4 asks for.
#[test]
fn a_velocity_regulated_robot_reaches_its_reference_speed_and_needs_encoders() {
    let body = BODY.replace("damping_n_s_m = 15.0", "damping_n_s_m = 0.0");
    let motors = "kind = \"velocity\", full_speed_m_s = 0.5, gain_n_s = 1.5";
    let mut still = world(&(robot("substeps = 10", &body, motors) + ENCODERS));
    run(&mut still, 200, 1.0, 1.0);
    assert!((speeds(&still).0 - 0.5).abs() < 1e-6, "{:?}", speeds(&still));
    // The speed V with α = 15 follows from 15 V = 2 · 10 · 1.5 (0.5 − V).
    let mut damped = world(&(robot("substeps = 10", BODY, motors) + ENCODERS));
    run(&mut damped, 200, 1.0, 1.0);
    assert!((speeds(&damped).0 - 1.0 / 3.0).abs() < 1e-6, "{:?}", speeds(&damped));
    let message = refusal(&robot("", BODY, motors));
    assert!(
        message.starts_with("robots[0].motors.kind: a velocity-regulated motor needs encoders"),
        "{message}"
    );
}

#[test]
fn a_gain_that_is_too_high_for_the_steps_is_refused() {
    let scenario = |top: &str, gain: f64| {
        robot(top, BODY, &format!("kind = \"velocity\", gain_n_s = {gain:?}")) + ENCODERS
    };
    // (15 + 2 · 10 K) 0.01 / 3 < 2 needs K < 29.25; turning, with B = 2: (0.78 + 2 · 2 · 0.2 K) 0.01 / 0.2
    // < 2, K < 49.
    baudbot_scenario::parse(&scenario("", 29.2)).unwrap();
    let message = refusal(&scenario("", 29.3));
    assert!(message.starts_with("robots[0].body: Euler steps of 10 ms are too long"), "{message}");
    assert!(message.contains("set substeps to 3 or more"), "{message}");
    baudbot_scenario::parse(&scenario("substeps = 2", 29.3)).unwrap();
}

#[test]
fn a_turret_obeys_with_its_next_pulse() {
    let turret =
        "[robots.actuators.neck]\nkind = \"turret\"\nmin_rad = -1.0\nmax_rad = 1.0\nrate_rad_s = 100.0\n";
    let mut world = world(&(robot("step_ms = 5.0", BODY, "") + turret));
    let turns: Vec<bool> = (0..6)
        .map(|i| {
            let turns = world.begin().to_vec();
            let bytes = command_of_three(&world, [0.0, 0.0, if i == 0 { 0.0 } else { 1.0 }]);
            world.finish(&[Input { robot: 0, at: turns[0].at, bytes: &bytes }]);
            world.robot(0).actuators()[0].angle_rad > 0.0
        })
        .collect();
    // Commanded in tick 1, at 5 ms; the next pulse begins at 20 ms, which is tick 4.
    assert_eq!(turns, [false, false, false, false, true, true]);
}

/// Motors that obey commands at once, on a robot with a lamp.
fn at_once(top: &str, motors: &str) -> World {
    let lamp = "[robots.actuators.lamp]\nkind = \"lamp\"\nintensity_cd = 1.0\n";
    let motors = format!("kind = \"stepper\", max_acceleration_steps_s2 = 1e9{motors}");
    world(&(robot(top, BODY, &motors) + lamp))
}

/// Ticks in which the robot moves and in which its lamp is lit, if both are commanded in tick 1 and then nothing more.
fn told_once(mut world: World, ticks: usize) -> [Vec<usize>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for i in 0..ticks {
        let at = world.begin()[0].at;
        let bytes = if i == 1 { command_of_three(&world, [1.0; 3]) } else { Vec::new() };
        world.finish(&[Input { robot: 0, at, bytes: &bytes }]);
        if speeds(&world).0 > 0.0 {
            found[0].push(i);
        }
        if world.robot(0).actuators()[0].signal > 0.0 {
            found[1].push(i);
        }
    }
    found
}

#[test]
fn a_dead_time_delays_the_motors_by_so_much_and_nothing_else() {
    let found = |dead: &str| told_once(at_once("step_ms = 10.0", dead), 20);
    // The command comes at 10 ms: 95 ms later is within the step from 100 ms on, so the one at 110 ms is the first to
    // have it.
    for (dead, first) in [("", 1), (", dead_time_ms = 10.0", 2), (", dead_time_ms = 95.0", 11)] {
        let [moves, lit] = found(dead);
        assert_eq!(moves, (first..20).collect::<Vec<_>>(), "{dead}");
        assert_eq!(lit, (1..20).collect::<Vec<_>>(), "{dead}");
    }
    let cycles = |dead: &str| {
        let mut world = at_once("step_ms = 10.0", dead);
        run_three(&mut world, 50);
        let cycles = world.robot(0).cycles().clone();
        (cycles.kept, cycles.late, cycles.durations.max_ns())
    };
    assert_eq!(cycles(", dead_time_ms = 95.0"), cycles(""));
    assert!(cycles("").0 >= 49, "{:?}", cycles(""));
}

fn run_three(world: &mut World, ticks: usize) {
    for i in 0..ticks {
        let at = world.begin()[0].at;
        let bytes = command_of_three(world, [(i % 3) as f64 / 2.0, 0.5, 0.1]);
        world.finish(&[Input { robot: 0, at, bytes: &bytes }]);
    }
}

#[test]
fn what_stops_the_motors_passes_their_dead_time_too() {
    let moves = |motors: &str| told_once(at_once("step_ms = 10.0", motors), 40)[0].clone();
    // The command comes at 10 ms, and the firmware stops the motors at 60 ms; both act 100 ms later.
    assert_eq!(moves(", timeout_ms = 50.0"), (1..6).collect::<Vec<_>>());
    assert_eq!(moves(", timeout_ms = 50.0, dead_time_ms = 100.0"), (11..16).collect::<Vec<_>>());
    // A deadline of 20 ms that is missed after the second step, found out by the third.
    let late = |dead: &str| {
        let late = "brain = { deadline_ms = 20.0, on_late = \"stop\" }\n";
        let motors = format!("kind = \"stepper\", max_acceleration_steps_s2 = 1e9{dead}");
        let mut world = world(&(robot("step_ms = 10.0", BODY, &motors) + late));
        let tick = |i: u64| {
            let at = world.begin()[0].at;
            let bytes = if i == 0 { command(world.robot(0).spec(), 1.0, 1.0) } else { Vec::new() };
            world.finish(&[Input { robot: 0, at, bytes: &bytes }]);
            speeds(&world).0 > 0.0
        };
        (0..30).map(tick).collect::<Vec<_>>()
    };
    let (at_once, later) = (late(""), late(", dead_time_ms = 100.0"));
    assert!(at_once.contains(&true) && !at_once[29], "{at_once:?}");
    assert_eq!(later[..10], [false; 10]);
    assert_eq!(later[10..], at_once[..20]);
}

#[test]
fn a_servo_has_its_dead_time_after_its_pulse() {
    let motors = "kind = \"servo\", lag_ms = 0.0, dead_time_ms = 10.0";
    let mut world = world(&robot("step_ms = 5.0", BODY, motors));
    run(&mut world, 1, 0.0, 0.0);
    // Commanded at 5 ms, in a pulse from 20 ms on.
    let moves: Vec<bool> = (1..8)
        .map(|_| {
            tick(&mut world, 1.0, 1.0);
            speeds(&world).0 > 0.0
        })
        .collect();
    assert_eq!(moves, [false, false, false, false, false, true, true]);
}

#[test]
fn a_move_to_a_position_passes_the_dead_time_too() {
    let begins = |dead: &str| {
        let mut world = world(&format!(
            "step_ms = 10.0\nnoise = false\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
             firmware = {{ protocol = \"khepera\" }}\nlink = {{ kind = \"ideal\" }}\nmotors = {{ {dead} }}\n"
        ));
        let moves = |i: usize| {
            let at = world.begin()[0].at;
            let bytes: &[u8] = if i == 0 { b"C,500,500\r" } else { b"" };
            world.finish(&[Input { robot: 0, at, bytes }]);
            speeds(&world).0 > 0.0
        };
        (0..60).map(moves).position(|moves| moves).unwrap()
    };
    assert_eq!(begins("dead_time_ms = 200.0"), begins("") + 20);
}

#[test]
fn what_is_under_way_to_the_motors_is_part_of_the_state() {
    let mut world = at_once("step_ms = 10.0\nnoise = false", ", dead_time_ms = 95.0");
    run_three(&mut world, 30);
    let scenario = Arc::clone(world.scenario());
    let mut loaded = World::load(scenario, &world.save(), world.hash()).unwrap();
    for _ in 0..30 {
        run_three(&mut world, 1);
        run_three(&mut loaded, 1);
        assert_eq!((loaded.hash(), speeds(&loaded)), (world.hash(), speeds(&world)));
    }
    // Two worlds that differ in nothing else yet.
    let mut other = world.clone();
    run_three(&mut world, 1);
    let at = other.begin()[0].at;
    let bytes = command_of_three(&other, [0.9, 0.5, 0.1]);
    other.finish(&[Input { robot: 0, at, bytes: &bytes }]);
    assert_eq!(speeds(&other), speeds(&world));
    assert_ne!(other.hash(), world.hash());
}

#[test]
fn a_flood_of_commands_leaves_no_more_under_way_than_one_a_step() {
    let mut world = at_once("step_ms = 10.0\nsubsteps = 2", ", dead_time_ms = 1000.0");
    let (mut sizes, commands) = (Vec::new(), 2000);
    for i in 0..300 {
        let at = world.begin()[0].at;
        let signal = |n: u32| f64::from(n + i) / f64::from(commands + 300);
        let bytes: Vec<_> =
            (0..commands).flat_map(|n| command_of_three(&world, [signal(n), 0.5, 0.1])).collect();
        world.finish(&[Input { robot: 0, at, bytes: &bytes }]);
        sizes.push(world.save().len());
    }
    // A hundred entries of at most 26 bytes, and counters that grow by a byte now and then.
    assert!(sizes[299] < sizes[0] + 3000 && sizes[299] <= sizes[150] + 100, "{sizes:?}");
}

#[test]
fn a_dead_time_of_0_is_none_to_the_bit() {
    let worlds = ["", ", dead_time_ms = 0.0"].map(|dead| {
        let mut world = at_once("step_ms = 10.0", dead);
        run_three(&mut world, 100);
        (world.hash(), world.save())
    });
    assert_eq!(worlds[0], worlds[1]);
}

fn command_of_three(world: &World, signals: [f64; 3]) -> Vec<u8> {
    let layout = world.robot(0).spec().firmware.layout();
    let (mut payload, mut bytes) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
    let n = write_command(&layout, 0, signals, &mut payload).unwrap();
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    bytes[..n].to_vec()
}

/// Pulses come at intervals T: Fig. 1.15.
#[test]
fn a_servo_obeys_with_its_next_pulse() {
    let motors = "kind = \"servo\", lag_ms = 0.0";
    let mut world = world(&robot("step_ms = 5.0", BODY, motors));
    run(&mut world, 1, 0.0, 0.0);
    let full = 0.1 * 48.0 * TAU / 60.0;
    // Commanded at 5 ms; the next pulse begins at 20 ms, which is tick 4.
    let moves: Vec<bool> = (1..6)
        .map(|_| {
            tick(&mut world, 1.0, 1.0);
            speeds(&world).0 > 0.0
        })
        .collect();
    assert_eq!(moves, [false, false, false, true, true]);
    assert!((speeds(&world).0 - full).abs() < 1e-12, "{:?}", speeds(&world));
}

#[test]
fn servos_turn_a_robot_as_its_wheels_say_and_follow_with_their_lag() {
    let mut world = world(&robot("step_ms = 10.0", BODY, "kind = \"servo\", frame_ms = 0.0"));
    run(&mut world, 6, -1.0, 1.0);
    // 60 ms, one time constant, at a rim speed of 0.1 · 48 rpm; (2.6) with R = 0.2 m.
    let turn_rate = 0.1 * 48.0 * TAU / 60.0 / 0.2 * (1.0 - (-1.0_f64).exp());
    let (speed, found) = speeds(&world);
    assert!(speed.abs() < 1e-12 && (found - turn_rate).abs() < 1e-12, "{speed} {found} {turn_rate}");
}

#[test]
fn no_body_is_too_light_for_motors_that_hold_their_speed() {
    let light = BODY.replace("mass_kg = 3.0, inertia_kg_m2 = 0.2", "mass_kg = 1e-6, inertia_kg_m2 = 1e-9");
    for kind in ["servo", "stepper"] {
        baudbot_scenario::parse(&robot("", &light, &format!("kind = \"{kind}\""))).unwrap();
    }
    assert!(refusal(&robot("", &light, "kind = \"dc\"")).contains("would blow up"));
}

fn steps(world: &World) -> [f64; 4] {
    let Steps { left, right } = world.robot(0).motion().steps.expect("stepper motors count their steps");
    [left.commanded_steps, left.lost_steps, right.commanded_steps, right.lost_steps]
}

#[test]
fn an_epuck_drives_at_its_top_speed_and_counts_its_steps() {
    let mut world = world(&robot("", EPUCK, "kind = \"stepper\", max_acceleration_steps_s2 = 1e6"));
    run(&mut world, 100, 1.0, 0.5);
    let (speed, turn_rate) = speeds(&world);
    let rim = TAU * 0.0205;
    assert!((rim - 0.1288).abs() < 5e-5, "{rim}");
    assert!((speed - 0.75 * rim).abs() < 1e-12, "{speed}");
    assert!((turn_rate + 0.5 * rim / 0.053).abs() < 1e-12, "{turn_rate}");
    let [left, left_lost, right, right_lost] = steps(&world);
    assert!((left - 1000.0).abs() < 1e-9 && (right - 500.0).abs() < 1e-9, "{left} {right}");
    assert_eq!([left_lost, right_lost], [0.0, 0.0]);
    let travel = world.robot(0).motion().travel_m;
    assert!((travel.left - rim).abs() < 1e-9 && (travel.right - 0.5 * rim).abs() < 1e-9, "{travel:?}");
}

#[test]
fn an_epuck_that_stands_at_a_wall_loses_its_steps() {
    let wall = "[[arena.polygons]]\nname = \"w\"\npoints_m = [[0.1, -1], [0.2, -1], [0.2, 1], [0.1, 1]]";
    let mut world = world(&robot(wall, EPUCK, "kind = \"stepper\""));
    run(&mut world, 200, 1.0, 1.0);
    let before = steps(&world);
    run(&mut world, 100, 1.0, 1.0);
    let after = steps(&world);
    assert!(world.robot(0).counters().collisions == 1, "{:?}", world.robot(0).counters());
    assert!((after[0] - before[0] - 1000.0).abs() < 1e-6, "{before:?} {after:?}");
    // Of 1000 steps a second the rotor makes the 40 that it gets up to within a step of 10 ms, and slips.
    assert!((after[1] - before[1] - 960.0).abs() < 1e-6, "{before:?} {after:?}");
}

#[test]
fn motor_noise_needs_noise_and_depends_on_the_seed() {
    let path = |seed: u32, noise: bool, motors: &str| {
        let mut world = world(&robot(&format!("seed = {seed}\nnoise = {noise}"), BODY, motors));
        run(&mut world, 100, 0.5, 0.5);
        world.robot(0).motion().pose
    };
    let noisy = "noise_sigma = 0.05, noise_spread = 0.05";
    assert_ne!(path(1, true, noisy), path(2, true, noisy));
    assert_ne!(path(1, true, noisy), path(1, true, ""));
    assert_eq!(path(1, false, noisy), path(2, true, ""));
    // Without a spread a robot goes straight on in the mean, with one it does not.
    assert!(
        path(1, true, "noise_sigma = 0.05").heading.abs()
            < path(1, true, "noise_spread = 0.05").heading.abs()
    );
}

#[test]
fn fields_of_another_kind_and_numbers_that_make_no_sense_name_their_path() {
    refused("kind = \"magnetic\"", "robots[0].motors.kind: must be one of `dc`");
    refused("steps_per_turn = 200", "robots[0].motors.steps_per_turn: unknown field `steps_per_turn`");
    refused("kind = \"servo\", gear_ratio = 2.0", "robots[0].motors.gear_ratio: unknown field `gear_ratio`");
    refused("kind = \"stepper\", track_factor = 0.5", "robots[0].motors.track_factor: unknown field");
    refused("kind = \"velocity\", voltage_v = 12", "robots[0].motors.voltage_v: unknown field");
    refused("kind = \"velocity\", gain_n_s = 0", "robots[0].motors.gain_n_s: must be positive, is 0");
    refused("noise_sigma = -0.1", "robots[0].motors.noise_sigma: must be between 0 and 1, is -0.1");
    refused("kind = \"stepper\", steps_per_turn = 0.5", "robots[0].motors.steps_per_turn: must be between 1");
    refused(
        "kind = \"stepper\", max_rate_steps_s = nan",
        "robots[0].motors.max_rate_steps_s: must be positive",
    );
    let servo = |more: &str, expected: &str| {
        refused(&format!("kind = \"servo\", {more}"), &format!("robots[0].motors.{expected}"));
    };
    servo("curve_us_rpm = []", "curve_us_rpm: a curve has 1 to 1000 points; this one has 0");
    servo(
        "curve_us_rpm = [[1500, 0], [1400, 3]]",
        "curve_us_rpm[1]: pulses must increase, 1400 follows 1500",
    );
    servo("curve_us_rpm = [[nan, 0]]", "curve_us_rpm[0].pulse_us: must be between 0 and 1000000, is NaN");
    servo("curve_us_rpm = [[1500, 1e9]]", "curve_us_rpm[0].rpm: must be between");
    servo("curve_us_rpm = [[1500]]", "curve_us_rpm[0]: must have 2 elements, has 1");
    servo("frame_ms = -1", "frame_ms: must be between 0");
    refused("dead_time_ms = -1", "robots[0].motors.dead_time_ms: must be between 0 and 1000, is -1");
    refused("dead_time_ms = 1001", "robots[0].motors.dead_time_ms: must be between 0 and 1000, is 1001");
    refused("kind = \"stepper\", timer_hz = 0", "robots[0].motors.timer_hz: must be positive, is 0");
    refused("kind = \"stepper\", hold_ms = -1", "robots[0].motors.hold_ms: must be between 0 and 1000000");
    refused("kind = \"servo\", timer_hz = 10", "robots[0].motors.timer_hz: unknown field `timer_hz`");
    let curve = |points: &str, expected: &str| {
        refused(
            &format!("kind = \"velocity\", curve_signal_share = {points}"),
            &format!("robots[0].motors.curve_signal_share{expected}"),
        );
    };
    curve("[[-0.1, 1.0]]", "[0].signal: must be between 0 and 1, is -0.1");
    curve("[[0.1, 1.5]]", "[0].share: must be between 0.001 and 1, is 1.5");
    curve("[[0.5, 1.0], [0.5, 0.9]]", "[1]: signals must increase, 0.5 follows 0.5");
}

#[test]
fn a_winding_that_follows_far_faster_than_a_step_is_refused() {
    refused("inductance_h = -1.0", "robots[0].motors.inductance_h: must not be negative, is -1");
    refused(
        "inductance_h = 1e-15",
        "robots[0].motors.inductance_h: changes the current far faster than a step",
    );
    refused(
        "inductance_h = 1e-3, resistance_ohm = 1e300",
        "robots[0].motors.inductance_h: changes the current",
    );
}

#[test]
fn a_rotor_is_a_part_of_the_inertia_of_its_wheel() {
    // By (1.5) and (1.10) I of the rotor counts G² times at the wheel, here 0.85 · 9 · 2e-4.
    let body = |more: &str| BODY.replace("damping_n_s_m", &format!("{more}damping_n_s_m"));
    let gear = "gear_ratio = 3.0, gear_efficiency = 0.85";
    let with_rotor = robot("", BODY, &format!("{gear}, rotor_inertia_kg_m2 = 2e-4"));
    let wheel = format!("wheel_inertia_kg_m2 = {:?}, ", 0.85 * 3.0 * (3.0 * 2e-4));
    let with_wheel = robot("", &body(&wheel), gear);
    let after = |scenario: &str| {
        let mut world = world(scenario);
        run(&mut world, 100, 0.7, 0.4);
        *world.robot(0).motion()
    };
    assert_eq!(after(&with_rotor), after(&with_wheel));
    assert_ne!(after(&with_rotor), after(&robot("", BODY, gear)));
}

#[test]
fn a_battery_gives_what_flows_through_the_windings() {
    // Friction holds the wheels at 0.2 V: in each, V²/R flows after some time constants of 16 ms.
    let motors = "coulomb_friction_nm = 1.0, inductance_h = 0.01, voltage_v = 12.0";
    let battery = "[robots.battery]\nnominal_v = 12.0\ncapacity_mah = 2000.0\ncurve_share_v = [[0.0, 1.0]]\n";
    let mut world = world(&(robot("step_ms = 1.0", BODY, motors) + battery));
    run(&mut world, 1000, 0.2 / 12.0, 0.2 / 12.0);
    let expected_a = 0.2 / 0.62;
    let currents = world.robot(0).currents_a().expect("motors with an inductance have currents");
    assert!((currents.left - expected_a).abs() < 1e-9, "{currents:?}");
    let (_, state) = world.robot(0).battery().unwrap();
    assert!((state.current_a - 2.0 * 0.2 * expected_a / 12.0).abs() < 1e-9, "{state:?}");
}

#[test]
fn currents_are_a_part_of_a_saved_world() {
    let scenario = robot("step_ms = 1.0", BODY, "inductance_h = 0.1");
    let mut original = world(&scenario);
    run(&mut original, 20, 1.0, 0.5);
    let load = |scenario: &str| {
        let scenario = baudbot_scenario::parse(scenario).unwrap();
        World::load(scenario.into(), &original.save(), original.hash())
    };
    let error = load(&robot("step_ms = 1.0", BODY, "")).unwrap_err();
    assert!(error.to_string().contains("windings"), "{error}");
    let mut copy = load(&scenario).unwrap();
    for world in [&mut original, &mut copy] {
        run(world, 20, 1.0, 0.5);
    }
    assert_eq!(original.hash(), copy.hash());
}
