//! Programs in simulated time, which act within a tick: instants are those of the wire, and a replay, which knows only what was
//! written, makes the same run.

use baudbot_sim::cable::Cable;
use baudbot_sim::model::PortUse;
use baudbot_sim::{Intervention, SimTime, World};
use proptest::prelude::*;

use crate::common::{BODY, world};

const TESTER: &str = include_str!("programs/tester.hex");
const CHARACTER_NS: u64 = 11 * 1_000_000_000 / 9600;

/// Bytes that have come, each with its cable and its instant.
type Heard = Vec<(Cable, SimTime, u8)>;

fn simulated(toml: &str) -> World {
    let mut world = world(toml);
    let robot = world.scenario().robots[0].name.clone();
    world.intervene(&Intervention::OpenPort { robot, port_use: PortUse::Simulated }).unwrap();
    world
}

fn khepera(step_ms: f64) -> World {
    simulated(&format!(
        "step_ms = {step_ms}\nnoise = false\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
         link = {{ baud = 9600, bits_per_character = 11 }}\nfirmware = {{ protocol = \"khepera\" }}\n"
    ))
}

fn take(world: &mut World, at: SimTime, heard: &mut Heard) {
    let ports = world.robot(0).spec().sensors.ports().to_vec();
    for cable in std::iter::once(Cable::Robot).chain(ports.into_iter().map(Cable::Sensor)) {
        let mut bytes = Vec::new();
        world.take_arrived(0, cable, &mut bytes);
        heard.extend(bytes.into_iter().map(|byte| (cable, at, byte)));
    }
}

/// Writes at these instants, and stops at each byte that comes; gives what came, and the fingerprint after each tick.
fn drive(world: &mut World, writes: &[(u64, Cable, Vec<u8>)], ticks: u64) -> (Heard, Vec<u64>) {
    let (mut heard, mut hashes, mut writes) = (Vec::new(), Vec::new(), writes.iter().peekable());
    for _ in 0..ticks {
        assert_eq!(world.begin(), [], "a program has no steps");
        let (start, end) = (world.time(), world.time() + world.scenario().step_ns);
        take(world, start, &mut heard);
        loop {
            let until = writes.peek().map_or(end, |(at, ..)| SimTime::from_ns(*at).min(end));
            while let Some(at) = world.hear(0, until) {
                take(world, at, &mut heard);
            }
            if until == end {
                break;
            }
            let (at, cable, bytes) = writes.next().unwrap();
            assert!(world.write_within(0, *cable, SimTime::from_ns(*at), bytes));
        }
        world.finish(&[]);
        hashes.push(world.hash());
    }
    (heard, hashes)
}

/// The same, knowing only what was written.
fn replay(world: &mut World, writes: &[(u64, Cable, Vec<u8>)], ticks: u64) -> Vec<u64> {
    let mut writes = writes.iter().peekable();
    let tick = |_| {
        world.begin();
        let end = (world.time() + world.scenario().step_ns).as_ns();
        while let Some((at, cable, bytes)) = writes.next_if(|(at, ..)| *at < end) {
            world.write_within(0, *cable, SimTime::from_ns(*at), bytes);
        }
        world.finish(&[]);
        world.hash()
    };
    (0..ticks).map(tick).collect()
}

#[test]
fn bytes_come_at_the_same_instants_whatever_the_tick_and_are_answered_at_once() {
    let asked_ns = 13_456_789;
    let mut all = Vec::new();
    for step_ms in [0.5, 1.0, 10.0] {
        let mut world = khepera(step_ms);
        let ticks = (200.0 / step_ms) as u64;
        let (heard, _) = drive(&mut world, &[(asked_ns, Cable::Robot, b"D,2,3\r".to_vec())], ticks);
        assert_eq!(heard.iter().map(|(.., byte)| *byte).collect::<Vec<_>>(), b"d\r\n", "{step_ms}");
        // Each character comes a character behind the one before, to the nanosecond.
        for pair in heard.windows(2) {
            assert!(pair[1].1.since(pair[0].1).abs_diff(CHARACTER_NS) <= 1, "{step_ms}: {heard:?}");
        }
        // Six characters there, the firmware's time for them, which the data sheet does not have, and one back.
        let first_ns = heard[0].1.as_ns() - asked_ns;
        assert!(
            (7 * CHARACTER_NS..7 * CHARACTER_NS + 1_000_000).contains(&first_ns),
            "{step_ms}: {first_ns}"
        );
        all.push(heard);
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "{all:?}");
}

#[test]
fn what_is_written_at_an_instant_has_left_after_its_characters() {
    let mut world = khepera(10.0);
    world.begin();
    let at = SimTime::from_ns(1_234_567);
    assert_eq!(world.hear(0, at), None);
    assert!(world.write_within(0, Cable::Robot, at, b"N\r"));
    let sent = world.sent_at(0, Cable::Robot).unwrap();
    assert!(sent.since(at).abs_diff(2 * CHARACTER_NS) <= 1, "{sent:?}");
    assert_eq!(world.unsent(0, Cable::Robot, at).unwrap().0, 2);
    assert_eq!(world.unsent(0, Cable::Robot, sent).unwrap().0, 0);
}

#[test]
fn nothing_is_heard_or_written_without_a_program_or_outside_of_a_tick() {
    let mut world = khepera(1.0);
    assert!(!world.write_within(0, Cable::Robot, SimTime::ZERO, b"N\r"), "no tick");
    world.begin();
    assert!(!world.write_within(0, Cable::Sensor(0), SimTime::ZERO, b"N\r"), "no such cable");
    assert!(!world.write_within(7, Cable::Robot, SimTime::ZERO, b"N\r"), "no such robot");
    world.finish(&[]);
    world.intervene(&Intervention::OpenPort { robot: "k".into(), port_use: PortUse::Closed }).unwrap();
    world.begin();
    assert!(!world.write_within(0, Cable::Robot, SimTime::ZERO, b"N\r"), "no program");
    assert_eq!(world.hear(0, SimTime::from_ns(1_000_000)), None);
}

/// A chip runs ahead of the laptop by less than half a bit, so that what is written at the instant of its last byte begins in time.
#[test]
fn a_chip_gets_each_byte_that_answers_its_own_at_once() {
    let mut world = simulated(&format!(
        "step_ms = 1.0\nsubsteps = 10\n[[robots]]\nname = \"r\"\n{BODY}\n[robots.microcontroller]\n\
         program = {{ file = \"tester.hex\", hex = '''\n{TESTER}''' }}\n[robots.link]\nkind = \"uart\"\nbaud = 9600\n"
    ));
    let (mut heard, mut rounds) = (Vec::new(), 0);
    for tick in 0..2000 {
        world.begin();
        let end = world.time() + world.scenario().step_ns;
        let mut at = world.time();
        if tick == 10 {
            assert!(world.write_within(0, Cable::Robot, at, b"hello"));
        }
        loop {
            world.take_arrived(0, Cable::Robot, &mut heard);
            if heard.len() == 5 {
                assert_eq!(heard, b"hello", "round {rounds}");
                heard.clear();
                rounds += 1;
                assert!(world.write_within(0, Cable::Robot, at, b"hello"));
            }
            match world.hear(0, end) {
                Some(next) => at = next,
                None => break,
            }
        }
        world.finish(&[]);
    }
    // Six characters a round, or seven: the chip answers while the next ones come.
    assert!(rounds > 250, "{rounds}");
    assert_eq!(world.robot(0).downlink().lost_bytes, 0);
}

/// Robots whose devices, firmware and cables differ, and what a program says to them.
fn robots() -> [(String, &'static [&'static [u8]]); 5] {
    let framed = format!(
        "[[robots]]\nname = \"f\"\n{BODY}\nlink = {{ kind = \"uart\", baud = 38400 }}\nsensors.c = {{ kind = \"compass\", period_ms = 7 }}\n"
    );
    let adapter = format!(
        "[[robots]]\nname = \"a\"\n{BODY}\nlink = {{ kind = \"uart\", baud = 57600, byte_error_rate = 0.01, adapter = {{ kind = \"ftdi\" }} }}\n\
         sensors.c = {{ kind = \"compass\", period_ms = 3 }}\n"
    );
    let laser = include_str!("../../../catalogue/scenarios/devices/laser.toml").to_owned();
    let khepera = "[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\nfirmware = { protocol = \"khepera\" }\n"
        .to_owned();
    let chip = format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nlink = {{ kind = \"uart\", baud = 9600, bits_per_character = 10 }}\n\
         [robots.microcontroller]\nprogram = {{ file = \"tester.hex\", hex = '''\n{TESTER}''' }}\n"
    );
    [
        (framed, &[b"\x00", b"nonsense", b"\x01\x02\x03\x00"]),
        (adapter, &[b"\x00", b"more nonsense\x00"]),
        (laser, &[b"\x00", b"BM\n", b"GD0044072500\n"]),
        (khepera, &[b"N\r", b"D,1,2\r", b"H\r", b"x"]),
        (chip, &[b"hello", b"a"]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Stops at bytes that come, and their number, move no bit.
    #[test]
    fn a_replay_makes_the_same_run(
        kind in 0_usize..5,
        step in 0_usize..3,
        said in prop::collection::vec((0_u64..300_000_000, any::<prop::sample::Index>(), any::<bool>()), 0..12),
    ) {
        let (toml, words) = robots()[kind].clone();
        let step_ms = ["0.5", "1.0", "10.0"][step];
        let toml = match toml.strip_prefix("step_ms") {
            Some(_) => toml.clone(),
            None if toml.contains("\nstep_ms") => toml.clone(),
            None => format!("step_ms = {step_ms}\nsubsteps = 10\n{toml}"),
        };
        let world = simulated(&toml);
        let sensor = world.robot(0).spec().sensors.ports().first().copied();
        let mut writes: Vec<_> = said
            .into_iter()
            .map(|(at, word, own)| {
                let cable = sensor.filter(|_| own).map_or(Cable::Robot, Cable::Sensor);
                (at, cable, word.get(words).to_vec())
            })
            .collect();
        writes.sort_by_key(|(at, ..)| *at);
        let ticks = 320_000_000 / world.scenario().step_ns;
        let (_, hashes) = drive(&mut world.clone(), &writes, ticks);
        prop_assert_eq!(&hashes, &replay(&mut world.clone(), &writes, ticks));
        // Half of it, kept and gone on with.
        let half = ticks / 2;
        let before = half * world.scenario().step_ns;
        let split = writes.partition_point(|(at, ..)| *at < before);
        let mut kept = world.clone();
        drive(&mut kept, &writes[..split], half);
        let mut loaded = World::load(kept.origin().clone(), &kept.save(), kept.hash()).unwrap();
        let (_, rest) = drive(&mut loaded, &writes[split..], ticks - half);
        prop_assert_eq!(&hashes[half as usize..], &rest[..]);
    }
}
