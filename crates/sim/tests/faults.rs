//! Faults by script and by chance: what they do, and to nothing else.

use crate::common::{BODY, refusal, run, world};
use baudbot_sim::World;
use baudbot_sim::timeline::What;

fn robot(link: &str, faults: &str) -> String {
    format!(
        "noise = false\n[[robots]]\nname = \"r\"\n{BODY}\nlink = {{ {link} }}\nfirmware = {{ protocol = \"bare\" }}\n\
         faults = [{faults}]\n\
         [robots.sensors.odometer]\nkind = \"odometer\"\nposition_range_m = 100\n"
    )
}

const UART: &str = "kind = \"uart\", baud = 115200";

fn faults(world: &World) -> Vec<(u64, u64)> {
    let ms = |event: &baudbot_sim::timeline::Event| {
        (event.start.as_ns() / 1_000_000, event.end.as_ns() / 1_000_000)
    };
    let events = world.robot(0).timeline().events();
    events.filter(|event| matches!(event.what, What::Fault { .. })).map(ms).collect()
}

#[test]
fn a_cable_that_is_cut_for_200_ms_loses_what_is_on_it_for_so_long() {
    let mut world = world(&robot(UART, "{ kind = \"cable\", from_s = 1.0, for_s = 0.2 }"));
    run(&mut world, 300, 0.1, 0.1);
    let robot = world.robot(0);
    assert_eq!(robot.uplink().messages, 280);
    assert!((280..=281).contains(&robot.downlink().messages), "one was on its way");
    assert!(robot.uplink().lost_bytes > 0);
    assert_eq!(faults(&world), [(1000, 1200)]);
    let lost = robot.timeline().events().filter(|event| matches!(event.what, What::Lost { .. })).count();
    assert_eq!(lost, 20);
}

#[test]
fn byte_errors_come_while_the_fault_is_in_force() {
    let fault = "{ kind = \"byte-errors\", byte_error_rate = 1.0, from_s = 0.5, for_s = 0.25 }";
    let mut world = world(&robot(UART, fault));
    run(&mut world, 50, 0.1, 0.1);
    assert_eq!(world.robot(0).uplink().corrupted_bytes, 0);
    run(&mut world, 50, 0.1, 0.1);
    let (up, message) =
        (world.robot(0).uplink(), world.robot(0).spec().firmware.layout().bare_readings_len());
    assert_eq!(up.corrupted_bytes, 25 * message as u64);
}

#[test]
fn a_stalled_brain_takes_no_step_and_then_goes_on() {
    let mut world = world(&robot(UART, "{ kind = \"brain\", from_s = 1.0, for_s = 0.5 }"));
    run(&mut world, 200, 0.1, 0.1);
    assert_eq!(world.robot(0).counters().turns, 150);
    assert!((149..=150).contains(&world.robot(0).commands()), "the last may be on its way");
}

#[test]
fn a_sensor_that_sticks_gives_its_last_value_and_grows_old() {
    let mut world =
        world(&robot(UART, "{ kind = \"sensor\", sensor = \"odometer\", from_s = 1.0, for_s = 0.5 }"));
    let x_m = |world: &World| world.robot(0).sensors().next().unwrap().sample[0];
    run(&mut world, 100, 0.1, 0.1);
    let stuck_at = x_m(&world);
    run(&mut world, 50, 0.1, 0.1);
    assert!(stuck_at > 0.0 && x_m(&world) == stuck_at);
    run(&mut world, 1, 0.1, 0.1);
    assert!(x_m(&world) > stuck_at + 0.01);
    let oldest_ns = world.robot(0).sensors().next().unwrap().freshness.ages.max_ns().unwrap();
    assert!((500_000_000..520_000_000).contains(&oldest_ns), "{oldest_ns}");
}

#[test]
fn a_sensor_whose_signal_is_lost_gives_zero_and_is_back_at_once() {
    let lost = "{ kind = \"lost-signal\", sensor = \"odometer\", from_s = 1.0, for_s = 0.5 }";
    let stuck = "{ kind = \"sensor\", sensor = \"odometer\", from_s = 1.2, for_s = 0.6 }";
    let mut world = world(&robot(UART, &format!("{lost}, {stuck}")));
    let x_m = |world: &World| world.robot(0).sensors().next().unwrap().sample[0];
    run(&mut world, 100, 0.1, 0.1);
    let before = x_m(&world);
    for _ in 0..50 {
        run(&mut world, 1, 0.1, 0.1);
        assert_eq!(world.robot(0).sensors().next().unwrap().sample, [0.0; 3]);
    }
    // The instant from which it sticks is before its first value: it sticks to nothing.
    run(&mut world, 30, 0.1, 0.1);
    assert_eq!(x_m(&world), 0.0);
    run(&mut world, 1, 0.1, 0.1);
    assert!(before > 0.0 && x_m(&world) > before + 0.01, "{before}");
}

/// A laser has a clock and a cable of its own.
#[test]
fn a_laser_whose_signal_is_lost_gives_zeros_in_all_its_rays() {
    let toml = robot(UART, "{ kind = \"lost-signal\", sensor = \"urg\", from_s = 1.0, for_s = 1.0 }")
        + "[robots.sensors.urg]\npreset = \"urg-04lx\"\nmount = {}\n";
    let mut world = world(&toml);
    let mut scans = [0; 2];
    for _ in 0..300 {
        run(&mut world, 1, 0.0, 0.0);
        let urg = world.robot(0).sensors().nth(1).unwrap();
        let lost = (1.2..1.9).contains(&world.time().as_seconds());
        let is_there = world.time().as_seconds() < 0.9 || world.time().as_seconds() > 2.2;
        if urg.samples > 0 && (lost || is_there) {
            assert_eq!(urg.sample.iter().all(|&value| value == 0.0), lost, "{}", world.time().as_seconds());
            scans[usize::from(lost)] += 1;
        }
    }
    assert!(scans.iter().all(|&n| n > 50), "{scans:?}");
}

#[test]
fn faults_by_chance_come_once_in_each_span_and_depend_on_the_seed_alone() {
    let fault = "{ kind = \"cable\", every_s = 1.0, for_s = 0.1 }";
    let with = |seed: u64, list: &str| {
        let mut world = world(&format!("seed = {seed}\n{}", robot(UART, list)));
        world.keep_timeline(100_000);
        run(&mut world, 1000, 0.1, 0.1);
        world
    };
    let world = with(1, fault);
    let found = faults(&world);
    assert_eq!(found.iter().map(|(from, _)| from / 1000).collect::<Vec<_>>(), (0..10).collect::<Vec<_>>());
    assert_eq!(with(1, fault).hash(), world.hash());
    assert_ne!(faults(&with(2, fault)), found);
    // Another fault behind it leaves it where it was.
    let two = format!("{fault}, {{ kind = \"brain\", every_s = 2.0, for_s = 0.1 }}");
    let both = faults(&with(1, &two));
    assert!(found.iter().all(|one| both.contains(one)) && both.len() == 15, "{both:?}");
}

#[test]
fn what_makes_no_sense_is_refused_with_its_path() {
    let of = |link: &str, fault: &str| refusal(&robot(link, fault));
    let cases = [
        (UART, "{ kind = \"cable\", for_s = 1 }", "robots[0].faults[0].from_s: is missing; give the time"),
        (
            UART,
            "{ kind = \"cable\", for_s = 1, from_s = 1, every_s = 2 }",
            "faults[0].every_s: give either this",
        ),
        (
            UART,
            "{ kind = \"cable\", for_s = 3, every_s = 2 }",
            "faults[0].for_s: must not be longer than every_s",
        ),
        (UART, "{ kind = \"cable\", for_s = -1, from_s = 2 }", "faults[0].for_s: must be between"),
        (UART, "{ kind = \"byte-errors\", for_s = 1, from_s = 2 }", "faults[0].byte_error_rate: is missing"),
        (
            UART,
            "{ kind = \"cable\", for_s = 1, from_s = 2, sensor = \"x\" }",
            "faults[0].sensor: only for kind",
        ),
        (UART, "{ kind = \"sensor\", for_s = 1, from_s = 2 }", "faults[0].sensor: is missing"),
        (UART, "{ kind = \"lost-signal\", for_s = 1, from_s = 2 }", "faults[0].sensor: is missing"),
        (
            UART,
            "{ kind = \"sensor\", for_s = 1, from_s = 2, sensor = \"x\" }",
            "faults[0].sensor: there is no sensor `x`; there are: odometer",
        ),
        (
            "kind = \"ideal\"",
            "{ kind = \"cable\", for_s = 1, from_s = 2 }",
            "faults[0].kind: there is no cable",
        ),
        (
            "kind = \"usb\"",
            "{ kind = \"byte-errors\", byte_error_rate = 0.1, for_s = 1, from_s = 2 }",
            "faults[0].kind: USB detects and corrects its errors",
        ),
        (UART, "{ kind = \"gremlin\", for_s = 1, from_s = 2 }", "must be one of "),
    ];
    for (link, fault, expected) in cases {
        let message = of(link, fault);
        assert!(message.contains(expected), "expected `{expected}` in: {message}");
    }
    let late = refusal(&format!("[[robots]]\nname = \"r\"\n{BODY}\nbrain = {{ on_late = \"stop\" }}"));
    assert!(late.contains("robots[0].brain.on_late: needs a deadline: deadline_ms"), "{late}");
}

#[test]
fn a_stall_that_is_short_delays_a_step_by_no_more_than_itself() {
    let stall = "{ kind = \"brain\", from_s = 0.10003, for_s = 0.002 }";
    let mut world = world(&robot("kind = \"usb\"", stall));
    for _ in 0..10 {
        world.begin();
        world.finish(&[]);
    }
    let undisturbed_ns = 101_000_000;
    assert_eq!(world.begin()[0].at.as_ns(), undisturbed_ns + 1_030_000, "at the stall's end");
}

#[test]
fn a_brain_takes_no_step_at_the_instant_at_which_a_stall_begins() {
    let mut world = world(&robot(UART, "{ kind = \"brain\", from_s = 0.05, for_s = 0.03 }"));
    let mut steps = Vec::new();
    for _ in 0..12 {
        steps.extend(world.begin().iter().map(|turn| turn.at.as_ns()));
        world.finish(&[]);
    }
    assert!(steps.iter().all(|ns| !(50_000_000..80_000_000).contains(ns)), "{steps:?}");
    assert!(steps.iter().any(|ns| *ns >= 80_000_000));
}
