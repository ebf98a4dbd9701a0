use std::sync::Arc;

use baudbot_sim::{Intervention, Scenario, World};

use super::*;
use crate::{change, checksum};

const WANDER: &str = include_str!("../../../scenarios/wander.toml");

fn world() -> World {
    World::new(Arc::<Scenario>::new(baudbot_scenario::parse(WANDER).unwrap()))
}

/// A journal of a run of so many ticks, the world at its end, and how many bytes there were, and which state, after each write.
fn run(ticks: u64) -> (Vec<u8>, Vec<(usize, u64, u64)>) {
    let mut world = world();
    let made = Arc::clone(world.origin());
    let mut entries =
        Entries::beginning("w", &world, &made, &Settings { paused: true, ..Settings::default() });
    let mut written = vec![(entries.len(), world.tick(), world.hash())];
    for tick in 0..ticks {
        if tick % 7 == 3 {
            let robot = world.scenario().robots[0].name.clone();
            let pulled = Intervention::PullCable { robot, pulled: tick % 2 == 1 };
            world.intervene(&pulled).unwrap();
            let changes = vec![change(&pulled)];
            entries.inputs(&v1::RecordedInputs { tick, changes, inputs: Vec::new() });
        }
        world.begin();
        if tick % 3 == 1 {
            let data = vec![tick as u8; 3];
            let input =
                v1::RecordedInput { after_ns: 5, checksum: checksum(5, &data), data, ..Default::default() };
            crate::replay::finish(&mut world, [&input]);
            entries.inputs(&v1::RecordedInputs { tick, changes: Vec::new(), inputs: vec![input] });
            let port = PortState { robot: 0, sequence: tick as u32, ..PortState::default() };
            entries.ports(&Ports { ports: vec![port] });
        } else {
            world.finish(&[]);
        }
        if tick % 20 == 19 {
            entries.state(&world);
        }
        let hash = world.hash();
        entries.at(At { tick: world.tick(), begun: false, state_hash: (tick % 5 == 0).then_some(hash) });
        written.push((entries.len(), world.tick(), hash));
    }
    (entries.take(), written)
}

#[test]
fn a_journal_that_is_cut_off_anywhere_gives_the_last_state_that_was_whole() {
    let (bytes, written) = run(30);
    for length in 0..=bytes.len() {
        let whole = written.iter().rev().find(|(until, _, _)| *until <= length);
        match (Journal::read(&bytes[..length]), whole) {
            (Err(JournalError::Unfinished), None) => {}
            (Ok(journal), Some((_, tick, hash))) => {
                // Entries of the next write may be whole already.
                if written.iter().any(|(until, _, _)| *until == length) {
                    let restored = journal.restore().unwrap();
                    assert_eq!((restored.world.tick(), restored.world.hash()), (*tick, *hash), "{length}");
                    assert!(restored.settings.paused && journal.torn() == 0);
                } else {
                    assert!(journal.length() + journal.torn() == length);
                }
            }
            (read, whole) => panic!("at {length}: {read:?} instead of {whole:?}"),
        }
    }
}

#[test]
fn a_bit_that_is_flipped_anywhere_is_found() {
    let (bytes, _) = run(25);
    let end = bytes.len();
    for place in 0..end {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << (place % 8);
        let read = Journal::read(&damaged);
        assert!(read.is_err(), "byte {place} of {end}: {read:?}");
    }
}

#[test]
fn zeros_behind_the_end_are_no_damage() {
    let (mut bytes, _) = run(5);
    bytes.extend([0; 100]);
    assert_eq!(Journal::read(&bytes).unwrap().torn(), 100);
}

#[test]
fn other_files_are_refused_with_words() {
    let text = |bytes: &[u8]| Journal::read(bytes).unwrap_err().to_string();
    assert_eq!(text(b"\x89MCAP0\r\n"), "is no journal of baudbot: its first line is missing");
    assert_eq!(text(b"baudbot-journal 2\n"), "is of format 2; this version of baudbot reads format 1");
    assert_eq!(text(b""), "ends before the first state");
}

#[test]
fn what_does_not_lead_where_it_led_is_told() {
    let world = world();
    let mut entries = Entries::beginning("w", &world, world.origin(), &Settings::default());
    entries.at(At { tick: 3, begun: true, state_hash: Some(1) });
    let error = Journal::read(entries.bytes()).unwrap().restore().unwrap_err().to_string();
    assert!(
        error.starts_with("does not lead to the state that it led to: the state's fingerprint at tick 3"),
        "{error}"
    );
}
