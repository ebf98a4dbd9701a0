use std::sync::Arc;

use baudbot_sim::{Intervention, Scenario, World};

use super::*;
use crate::{change, checksum};

const WANDER: &str = include_str!("../../../../catalogue/scenarios/wander.toml");

fn world() -> World {
    World::new(Arc::<Scenario>::new(baudbot_scenario::parse(WANDER).unwrap()))
}

/// The number of writes that are not on the disk yet.
const SYNCED_BEFORE: usize = 4;

/// A journal of a run of so many ticks, the world at its end, and how many bytes there were, and which state, after each write.
fn run(ticks: u64) -> (Vec<u8>, Vec<(usize, u64, u64)>) {
    let mut world = world();
    let made = Arc::clone(world.origin());
    let mut entries = Entries::beginning(
        "w",
        &world,
        &made,
        &Settings { paused: true, ..Settings::default() },
        &Ports::default(),
    );
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
        let state_hash = (tick % 5 == 0).then_some(hash);
        let on_disk = written.iter().rev().nth(SYNCED_BEFORE).map_or(0, |(until, _, _)| *until as u64);
        entries.at(At { tick: world.tick(), begun: false, state_hash, on_disk });
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
            (Ok(journal), Some((until, tick, hash))) => {
                assert_eq!((journal.length(), journal.torn()), (*until, length - until));
                // A journal that does not end with a write is the same but for the bytes behind it.
                if *until == length {
                    let restored = journal.restore().unwrap();
                    assert_eq!((restored.world.tick(), restored.world.hash()), (*tick, *hash), "{length}");
                    assert!(restored.settings.paused);
                }
            }
            (read, whole) => panic!("at {length}: {read:?} instead of {whole:?}"),
        }
    }
}

#[test]
fn a_bit_that_is_flipped_anywhere_is_found() {
    let (bytes, written) = run(25);
    let end = bytes.len();
    let on_disk = written[written.len() - 2 - SYNCED_BEFORE].0;
    for place in 0..end {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << (place % 8);
        match Journal::read(&damaged) {
            // The last writes may be unfinished: nothing of them is taken.
            Ok(journal) => assert!(place >= on_disk && journal.length() <= place, "byte {place} of {end}"),
            Err(_) => assert!(place < on_disk, "byte {place} of {end}"),
        }
    }
}

/// Random numbers, so that a run can be repeated.
fn chance(state: &mut u64, below: usize) -> usize {
    for (left, shift) in [(true, 13), (false, 7), (true, 17)] {
        *state ^= if left { *state << shift } else { *state >> shift };
    }
    (*state % below as u64) as usize
}

/// The tails of the attack: zeros, garbage, a cut, blocks that stand twice, and parts in another order.
fn tear(bytes: &[u8], sound: usize, kind: usize, state: &mut u64) -> Vec<u8> {
    let mut torn = bytes.to_vec();
    let from = bytes.len() - 1 - chance(state, (bytes.len() - sound).min(4000) - 1);
    match kind {
        0 => torn[from..].fill(0),
        1 => torn[from..].fill_with(|| chance(state, 256) as u8),
        2 => torn.truncate(from),
        3 => {
            let length = bytes.len() - from;
            torn.copy_within(from - length..from, from);
        }
        4 => torn.extend_from_within(from..),
        5 => torn.extend((0..64).map(|_| chance(state, 256) as u8)),
        6 => torn.extend([0; 4096]),
        _ => {
            // A block in the middle was not written, and those behind it were.
            let end = from + 1 + chance(state, bytes.len() - from);
            torn[from..end].fill(0);
        }
    }
    torn
}

#[test]
fn after_a_torn_tail_a_world_goes_on_from_the_last_write_that_was_whole_200_times_of_200() {
    let (bytes, written) = run(120);
    let (sound, mut state) = (written[40].0, 7);
    // Nothing behind this was on the disk for good: at least so much of it was written since.
    let on_disk = |length: usize| written.iter().rposition(|(until, _, _)| *until <= length).unwrap();
    for number in 0..200 {
        let torn = tear(&bytes, sound, number % 8, &mut state);
        let same = bytes.iter().zip(&torn).take_while(|(a, b)| a == b).count();
        let last = on_disk(same);
        let synced = torn == bytes || last + SYNCED_BEFORE + 1 >= written.len() || number % 8 != 7;
        let read = Journal::read(&torn);
        if !synced {
            // A hole in bytes that were on the disk for good is damage, and reported so.
            assert!(matches!(read, Ok(_) | Err(JournalError::Damaged(_))), "{number}: {read:?}");
            continue;
        }
        let journal = read.unwrap_or_else(|error| panic!("{number}: {error}"));
        let (until, tick, hash) = written[last];
        let restored = journal.restore().unwrap();
        assert_eq!((restored.world.tick(), restored.world.hash()), (tick, hash), "{number}");
        assert_eq!((journal.length(), journal.torn()), (until, torn.len() - until), "{number}");
    }
}

#[test]
fn a_journal_of_format_1_goes_on_after_a_torn_tail_too() {
    let bytes = include_bytes!("../../../../tests/data/released/0.1/state/worlds/kept/journal-1");
    let whole = Journal::read(bytes).unwrap().restore().unwrap().world;
    assert_eq!(whole.tick(), 25);
    let mut state = 9;
    for number in 0..70 {
        let torn = tear(bytes, bytes.len() - 200, number % 7, &mut state);
        let restored = Journal::read(&torn).and_then(|journal| journal.restore());
        let world = restored.unwrap_or_else(|error| panic!("{number}: {error}")).world;
        assert!(world.tick() < 25 || world.hash() == whole.hash(), "{number}");
    }
}

#[test]
fn of_a_damaged_journal_is_salvaged_what_is_sound() {
    let (bytes, written) = run(70);
    let state_of = |length: usize| written.iter().rev().find(|(until, _, _)| *until <= length).unwrap();
    let told = |salvaged: &Salvaged| (salvaged.restored.world.tick(), salvaged.restored.world.hash());
    // Before the last state, at tick 60: that has all that was before it.
    let mut early = bytes.clone();
    early[written[10].0 + 3] ^= 1;
    assert!(matches!(Journal::read(&early), Err(JournalError::Damaged(at)) if at <= written[10].0));
    let salvaged = Journal::salvage(&early).unwrap();
    let last = written.last().unwrap();
    assert_eq!((told(&salvaged), salvaged.passed.len(), salvaged.left_out.1), ((last.1, last.2), 1, 0));
    // Behind it: up to there.
    let mut late = bytes.clone();
    let place = written[64].0 + 3;
    late[place] ^= 1;
    let salvaged = Journal::salvage(&late).unwrap();
    let (until, tick, hash) = *state_of(place);
    assert_eq!((told(&salvaged), salvaged.left_out), ((tick, hash), (until, bytes.len() - until)));
    assert!(salvaged.passed.is_empty() && salvaged.restored.settings.paused);
    // In the scenario there is nothing to be done.
    let mut none = bytes;
    none[100] ^= 1;
    assert!(Journal::salvage(&none).is_err());
}

#[test]
fn what_leads_elsewhere_is_salvaged_up_to_the_last_fingerprint_before() {
    let mut world = world();
    let made = Arc::clone(world.origin());
    let mut entries = Entries::beginning("w", &world, &made, &Settings::default(), &Ports::default());
    let mut sure = 0;
    for tick in 1..=20 {
        world.begin();
        world.finish(&[]);
        let hash = world.hash();
        if tick == 10 {
            sure = hash;
        }
        let state_hash = (tick % 10 == 0).then_some(if tick == 20 { hash ^ 1 } else { hash });
        entries.at(At { tick, state_hash, ..At::default() });
    }
    let salvaged = Journal::salvage(entries.bytes()).unwrap();
    assert_eq!((salvaged.restored.world.tick(), salvaged.restored.world.hash()), (10, sure));
    assert!(matches!(salvaged.differs, Some(JournalError::Differs { tick: 20, .. })));
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
    assert_eq!(text(b"baudbot-journal 3\n"), "is of format 3; this version of baudbot reads formats 1 to 2");
    assert_eq!(text(b""), "ends before the first state");
}

#[test]
fn what_does_not_lead_where_it_led_is_told() {
    let world = world();
    let mut entries =
        Entries::beginning("w", &world, world.origin(), &Settings::default(), &Ports::default());
    entries.at(At { tick: 3, begun: true, state_hash: Some(1), on_disk: 0 });
    let error = Journal::read(entries.bytes()).unwrap().restore().unwrap_err().to_string();
    assert!(error.starts_with("does not reproduce its state: the state's fingerprint at tick 3"), "{error}");
}
