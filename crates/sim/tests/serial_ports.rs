//! Serial ports that programs open: bytes at their instants, whatever the tick; boards that are reset; the same run again.

use baudbot_sim::model::PortUse;
use baudbot_sim::{Input, Intervention, InterventionError, SimTime, World};

use crate::common::{BODY, world};

/// A Khepera of 10 sensors' worth of text, at 9600 baud with 11 bits a character.
fn khepera(step_ms: f64) -> World {
    world(&format!(
        "step_ms = {step_ms}\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
         link = {{ baud = 9600, bits_per_character = 11 }}\nfirmware = {{ protocol = \"khepera\" }}\n"
    ))
}

fn open(world: &mut World, open: bool) {
    let port_use = if open { PortUse::Open } else { PortUse::Closed };
    world.intervene(&Intervention::OpenPort { robot: "k".into(), port_use }).unwrap();
}

/// Writes a line at the end of the first tick; gives all bytes that come, with their instants.
fn answer(world: &mut World, line: &[u8], ticks: u64) -> Vec<(SimTime, u8)> {
    let mut heard = Vec::new();
    for tick in 0..ticks {
        let turn = world.begin()[0];
        let robot = world.robot(0);
        // Instants are no part of a state that was saved.
        let known = robot.unread_instants().len();
        assert!(tick == 0 || robot.spec().port_use == PortUse::Closed || robot.unread().len() == known);
        heard.extend(robot.unread_instants().iter().copied().zip(robot.unread().iter().copied()));
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if tick == 0 { line } else { &[] } }]);
    }
    heard
}

const CHARACTER_NS: u64 = 11 * 1_000_000_000 / 9600;

#[test]
fn bytes_come_at_the_instants_of_the_cable_whatever_the_tick() {
    for step_ms in [0.5, 1.0, 10.0] {
        let mut world = khepera(step_ms);
        open(&mut world, true);
        let heard = answer(&mut world, b"N\r", (100.0 / step_ms) as u64);
        let asked = SimTime::from_ns((step_ms * 1e6) as u64);
        let gaps: Vec<_> = heard.windows(2).map(|pair| pair[1].0.since(pair[0].0)).collect();
        assert!(gaps.iter().all(|gap| gap.abs_diff(CHARACTER_NS) <= 1), "{step_ms}: {gaps:?}");
        // Two characters there, and then the answer's first.
        let first = heard[0].0.since(asked);
        assert!((3 * CHARACTER_NS..3 * CHARACTER_NS + 2_000_000).contains(&first), "{step_ms}: {first}");
        let text: Vec<u8> = heard.iter().map(|(_, byte)| *byte).collect();
        assert!(text.starts_with(b"n,") && text.ends_with(b"\r\n"), "{text:?}");
    }
}

#[test]
fn each_tick_has_a_step_at_its_end_and_hands_over_all_that_came_in_it() {
    let mut world = khepera(10.0);
    open(&mut world, true);
    for tick in 1..=20 {
        let turns = world.begin().to_vec();
        assert_eq!(turns.len(), 1);
        assert_eq!(turns[0].at, SimTime::from_ns(tick * 10_000_000));
        let within = |at: &SimTime| *at >= world.time() && *at < turns[0].at;
        assert!(world.robot(0).unread_instants().iter().all(within));
        world.finish(&[Input { robot: 0, at: turns[0].at, bytes: b"N\r" }]);
    }
}

#[test]
fn a_port_is_part_of_the_state_and_the_same_inputs_make_the_same_run() {
    let run = |world: &mut World, ticks| drop(answer(world, b"D,5,5\rN\r", ticks));
    let (mut one, mut other, mut never) = (khepera(2.0), khepera(2.0), khepera(2.0));
    for world in [&mut one, &mut other] {
        open(world, true);
        run(world, 30);
    }
    assert_eq!(one.hash(), other.hash());
    let saved = one.save();
    let mut loaded = World::load(one.origin().clone(), &saved, one.hash()).unwrap();
    for world in [&mut one, &mut loaded] {
        run(world, 30);
        open(world, false);
        run(world, 30);
    }
    assert_eq!(one.hash(), loaded.hash());
    let plain = never.hash();
    assert_eq!(plain, khepera(2.0).hash());
    open(&mut never, true);
    assert_ne!(never.hash(), plain);
}

#[test]
fn closing_a_port_lets_brains_step_at_messages_again() {
    let mut world = khepera(10.0);
    open(&mut world, true);
    answer(&mut world, b"N\r", 3);
    open(&mut world, false);
    assert_eq!(world.robot(0).unread(), b"", "who closes a port leaves nothing");
    let mut steps = Vec::new();
    for tick in 0..20 {
        let turn = world.begin()[0];
        steps.push(turn.at.as_ns() % 10_000_000);
        assert_eq!(world.robot(0).unread_instants(), []);
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if tick == 0 { b"N\r" } else { &[] } }]);
    }
    assert!(steps.iter().any(|at| *at != 0), "a step within a tick, when the answer was whole: {steps:?}");
}

#[test]
fn a_board_is_reset_and_boots_again_and_what_came_meanwhile_is_lost() {
    let mut world = world(&format!(
        "step_ms = 1.0\n[[robots]]\nname = \"k\"\n{BODY}\nmicrocontroller = {{ bootloader_s = 0.5 }}\n\
         motors = {{ signal_bits = 8 }}\nlink = {{ kind = \"uart\", baud = 115200 }}\n\
         firmware = {{ protocol = \"khepera\" }}\nsensors.c = {{ kind = \"compass\", bits = 8, period_ms = 10 }}\n"
    ));
    open(&mut world, true);
    assert_eq!(answer(&mut world, b"N\r", 400), [], "still in the bootloader");
    answer(&mut world, b"", 300);
    answer(&mut world, b"D,50,50\r", 100);
    assert!(world.robot(0).signals().left > 0.0);
    world.intervene(&Intervention::ResetBoard { robot: "k".into() }).unwrap();
    let heard = answer(&mut world, b"N\r", 450);
    assert_eq!(heard, [], "boots");
    assert_eq!(world.robot(0).signals().left, 0.0, "motors get no signal");
    answer(&mut world, b"", 100);
    let heard: Vec<u8> = answer(&mut world, b"N\r", 100).into_iter().map(|(_, byte)| byte).collect();
    assert!(heard.starts_with(b"n,"), "{heard:?}");
    let (saved, hash) = (world.save(), world.hash());
    let mut loaded = World::load(world.origin().clone(), &saved, hash).unwrap();
    assert_eq!(answer(&mut loaded, b"N\r", 50), answer(&mut world, b"N\r", 50));
    assert_eq!(loaded.hash(), world.hash());
}

#[test]
fn programs_open_ports_and_reset_boards_as_often_as_they_like() {
    let mut world = khepera(1.0);
    open(&mut world, true);
    let once = world.save().len();
    let reset = Intervention::ResetBoard { robot: "k".into() };
    for _ in 0..10_001 {
        open(&mut world, false);
        open(&mut world, true);
        world.intervene(&reset).unwrap();
    }
    assert!(world.save().len() < once + 100, "only the last time is kept");
    answer(&mut world, b"N\r", 20);
    let loaded = World::load(world.origin().clone(), &world.save(), world.hash()).unwrap();
    assert_eq!(loaded.hash(), world.hash());
    open(&mut world, false);
    // The pulls of a cable have a limit, but a port can always be closed.
    open(&mut world, true);
    let pull = |pulled| Intervention::PullCable { robot: "k".into(), pulled };
    let refused = (0..10_000).find_map(|i| world.intervene(&pull(i % 2 == 0)).err());
    assert_eq!(refused, Some(InterventionError::TooOften { robot: "k".into() }));
    world.intervene(&reset).unwrap();
    open(&mut world, false);
}

#[test]
fn a_robot_without_a_cable_has_no_port() {
    let mut world = world(&format!("[[robots]]\nname = \"k\"\n{BODY}\nlink = {{ kind = \"onboard\" }}\n"));
    for intervention in [
        Intervention::OpenPort { robot: "k".into(), port_use: PortUse::Open },
        Intervention::ResetBoard { robot: "k".into() },
    ] {
        let error = world.intervene(&intervention).unwrap_err();
        assert_eq!(error, InterventionError::NoCable { robot: "k".into(), cable: "cable" });
    }
    let missing = Intervention::OpenPort { robot: "x".into(), port_use: PortUse::Open };
    assert!(matches!(world.intervene(&missing), Err(InterventionError::Unknown { .. })));
}
