//! Cables under a protocol analyser: the bytes and their instants, and that looking changes nothing.

use baudbot_sim::cable::{Cable, Listener};
use baudbot_sim::timeline::What;
use baudbot_sim::{Input, World};
use baudbot_wire::meaning::Direction;

use crate::common::{BODY, tick, world};

/// An item: its direction, its instants in nanoseconds, its bytes, its text.
type Said = (Direction, [u64; 2], Vec<u8>, String);

/// The messages on a cable while `each` does so many ticks.
fn said(world: &mut World, cable: Cable, ticks: u64, mut each: impl FnMut(&mut World, u64)) -> Vec<Said> {
    world.keep_tape(0, 1 << 14);
    let mut listener = Listener::new(world.robot(0).spec(), cable).unwrap();
    let mut said = Vec::new();
    for i in 0..ticks {
        each(world, i);
        listener.look(&world.robot(0), world.time(), &mut |item, _| {
            let instants = [item.from_ns, item.to_ns];
            said.push((item.direction, instants, item.bytes.to_vec(), item.text.to_owned()));
        });
    }
    assert_eq!(listener.missed_bytes(), 0);
    said
}

fn khepera() -> World {
    world(
        "step_ms = 1.0\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
         link = { baud = 9600, bits_per_character = 10 }\nfirmware = { protocol = \"khepera\" }\n",
    )
}

/// Writes in the first tick.
fn write(world: &mut World, i: u64, bytes: &[u8]) {
    let turns = world.begin().to_vec();
    let bytes = if i == 0 { bytes } else { &[] };
    let inputs: Vec<_> = turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes }).collect();
    world.finish(&inputs);
}

const CHARACTER_NS: u64 = 1_041_667;

#[test]
fn a_kheperas_questions_and_answers_are_told_at_their_instants() {
    let mut world = khepera();
    let said = said(&mut world, Cable::Robot, 200, |world, i| write(world, i, b"D,5,5\rN\r"));
    let texts: Vec<_> = said.iter().map(|(_, _, _, text)| text.as_str()).collect();
    assert_eq!(texts[0], "D,5,5: set speed 5 5");
    assert!(texts.contains(&"N: ask proximity") && texts.contains(&"d: speed set"), "{texts:?}");
    assert!(texts.iter().any(|text| text.starts_with("n: proximity ")), "{texts:?}");
    let (direction, [from_ns, to_ns], bytes, _) = &said[0];
    assert_eq!((*direction, bytes.as_slice()), (Direction::Down, &b"D,5,5\r"[..]));
    assert!((to_ns - from_ns).abs_diff(5 * CHARACTER_NS) <= 6, "{from_ns} {to_ns}");
    let of = |direction| said.iter().filter(move |one| one.0 == direction).map(|one| one.2.len() as u64);
    let robot = world.robot(0);
    assert_eq!(of(Direction::Up).sum::<u64>(), robot.uplink().bytes);
    assert_eq!(of(Direction::Down).sum::<u64>(), robot.downlink().bytes);
}

fn laser(dialogue: &str, link: &str) -> World {
    world(&format!(
        "step_ms = 10.0\n[[robots]]\nname = \"r\"\n{BODY}\n[robots.sensors.laser]\nkind = \"laser\"\n\
         bearing_rad = 0.0\nopening_rad = 1.0\nrays = 5\nrange_m = 4.0\nperiod_ms = 100.0\n\
         port = {{ link = {{ {link} }}{dialogue} }}\n"
    ))
}

const UART: &str = "kind = \"uart\", baud = 19200";

#[test]
fn what_a_range_finder_is_asked_and_answers_is_told_and_on_the_timeline() {
    let mut world = laser(", dialogue = \"driver\"", UART);
    let said = said(&mut world, Cable::Sensor(0), 50, |world, _| tick(world, 0.0, 0.0));
    let texts: Vec<_> = said.iter().map(|(_, _, _, text)| text.as_str()).collect();
    let begin = ["BM: laser on", "BM: status 00 (accepted)"];
    assert_eq!(texts[..2], begin);
    assert!(texts[2].starts_with("MD") && texts[2].ends_with(", without an end"), "{texts:?}");
    assert!(texts.last().unwrap().ends_with("5 distances, checksums right"), "{texts:?}");
    let events = world.robot(0).timeline().events();
    let down: Vec<_> = events.filter(|event| matches!(event.what, What::PortDown { .. })).collect();
    let [first, second, ..] = &down[..] else { panic!("{down:?}") };
    assert_eq!(first.what, What::PortDown { sensor: 0, bytes: 3 });
    assert_eq!((first.start.as_ns(), first.end.as_ns()), (0, 30_000_000_000 / 19200));
    assert_eq!(second.what, What::PortDown { sensor: 0, bytes: 16 });
    let up = world.robot(0).timeline().events().find(|event| matches!(event.what, What::Port { .. }));
    assert_eq!(up.unwrap().what, What::Port { sensor: 0, bytes: 8 });
}

#[test]
fn a_device_that_speaks_by_itself_and_a_brain_on_board_have_the_cables_that_they_have() {
    let world = laser("", UART);
    let cables: Vec<_> = Cable::all(world.robot(0).spec()).collect();
    assert_eq!(cables, [Cable::Robot, Cable::Sensor(0)]);
    assert!(Listener::new(world.robot(0).spec(), Cable::Sensor(1)).is_none());
    let onboard = crate::common::world_with(
        &format!("[[robots]]\nname = \"r\"\nlink = {{ kind = \"onboard\" }}\n{BODY}\n"),
        &[],
    );
    assert_eq!(Cable::all(onboard.robot(0).spec()).count(), 0);
    assert!(Listener::new(onboard.robot(0).spec(), Cable::Robot).is_none());
}

#[test]
fn looking_at_cables_changes_no_bit_of_a_run() {
    let adapter = "kind = \"uart\", baud = 19200, byte_error_rate = 0.01, adapter = { kind = \"ftdi\" }";
    for make in [
        khepera,
        || laser(", dialogue = \"driver\"", UART),
        || laser("", "kind = \"uart\", baud = 19200, adapter = { kind = \"ftdi\" }"),
        || laser("", "kind = \"ideal\""),
    ] {
        let (mut plain, mut listened) = (make(), make());
        let cables: Vec<_> = Cable::all(listened.robot(0).spec()).collect();
        for cable in cables {
            said(&mut listened, cable, 100, |world, _| tick(world, 0.1, 0.2));
            (0..100).for_each(|_| tick(&mut plain, 0.1, 0.2));
            assert_eq!(plain.hash(), listened.hash(), "{cable:?}");
        }
    }
    let toml = format!(
        "[[robots]]\nname = \"r\"\n{BODY}\nlink = {{ {adapter} }}\n[robots.sensors.c]\nkind = \"compass\"\n"
    );
    let (mut plain, mut listened) = (world(&toml), world(&toml));
    let said = said(&mut listened, Cable::Robot, 300, |world, _| tick(world, 0.1, 0.2));
    (0..300).for_each(|_| tick(&mut plain, 0.1, 0.2));
    assert_eq!(plain.hash(), listened.hash());
    assert!(said.iter().any(|(_, _, _, text)| text.contains("damaged frame")), "bytes are told as they came");
}
