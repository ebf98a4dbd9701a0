//! The files in which worlds are kept: recordings, states and journals.

use std::io::Cursor;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_recording::journal::{At, Entries, Journal, Ports, Settings};
use baudbot_recording::{Digests, Frames, RecordedRun, Replay, Writer, checksum, header, saved};
use baudbot_sim::{Input, Scenario, World};

use super::{Target, outcome};

pub(super) fn targets() -> anyhow::Result<Vec<Target>> {
    let scenario: Arc<Scenario> = Arc::new(baudbot_scenario::parse(SCENARIO)?);
    let mut world = World::new(Arc::clone(&scenario));
    let (recording, mut states) = (record(&mut world)?, vec![world.save()]);
    run(&mut world, 33);
    world.begin();
    states.push(world.save());
    let seeds = vec![recording, saved::to_bytes("w", &world)?];
    let mut journal =
        Entries::beginning("w", &world, world.origin(), &Settings::default(), &Ports::default());
    for tick in 34..60 {
        run(&mut world, 1);
        journal.at(At { tick, ..At::default() });
    }
    Ok(vec![
        Target {
            name: "recordings",
            what: "recordings, replayed",
            seeds,
            words: RECORDS,
            run: Box::new(recordings),
        },
        Target {
            name: "journals",
            what: "journals of worlds, gone on with",
            seeds: vec![journal.take()],
            words: RECORDS,
            run: Box::new(journals),
        },
        Target {
            name: "states",
            what: "states with the fingerprint that they have, run on",
            seeds: states,
            words: NUMBERS,
            run: Box::new(move |bytes| state(&scenario, bytes)),
        },
    ])
}

/// A scenario with a device with its own clock, one with its own cable, an adapter, things that move and a floor that
/// is counted.
const SCENARIO: &str = include_str!("world.toml");

/// Worlds that are not restored are salvaged.
fn journals(bytes: &[u8]) -> u64 {
    match Journal::read(bytes).and_then(|journal| journal.restore()) {
        Ok(restored) => restored.world.tick(),
        Err(error) => match Journal::salvage(bytes) {
            Ok(salvaged) => salvaged.restored.world.tick(),
            Err(_) => outcome(&error.to_string()),
        },
    }
}

fn recordings(bytes: &[u8]) -> u64 {
    Frames::read(bytes).take(10).for_each(drop);
    let recorded = match RecordedRun::read_at_most(bytes, 64 << 20) {
        Ok(recorded) => recorded,
        Err(error) => return outcome(&error.to_string()),
    };
    let condition = u64::from(recorded.is_whole()) + 2 * recorded.stretches().len() as u64;
    let (mut replay, mut world) = match Replay::start(Arc::new(recorded)) {
        Ok(started) => started,
        Err(error) => return outcome(&error.to_string()),
    };
    for _ in 0..300 {
        if !matches!(replay.step(&mut world), Ok(true)) {
            break;
        }
    }
    condition ^ replay.difference().map_or(0, |difference| outcome(&difference.what))
}

/// The fingerprint of a forged state is correct, as a deliberate forgery has it so.
fn state(scenario: &Arc<Scenario>, bytes: &[u8]) -> u64 {
    let plain = bytes.strip_suffix(&[0]).unwrap_or(bytes);
    let mut found = 0;
    for part in [plain, bytes] {
        let hash = part.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        match World::load(Arc::clone(scenario), bytes, hash) {
            Ok(mut world) => {
                let length = world.save().len();
                run(&mut world, 60);
                assert!(world.save().len() < 2 * length + 100_000);
                found ^= 1;
            }
            Err(error) => found ^= outcome(&error.to_string()),
        }
    }
    found
}

fn run(world: &mut World, ticks: u64) {
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let inputs = turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: COMMAND });
        let inputs: Vec<_> = inputs.collect();
        world.finish(&inputs);
    }
}

/// A recording of 80 ticks, with two states in it.
fn record(world: &mut World) -> anyhow::Result<Vec<u8>> {
    let mut file = Writer::new(Cursor::new(Vec::new()), &header("w", world.scenario(), None))?;
    file.state(&saved::state(world))?;
    let mut digests = Digests::default();
    file.mark(&digests.last_mark(world))?;
    for tick in 0..80 {
        let turns = world.begin().to_vec();
        digests.note(world);
        if tick % 20 == 0 {
            file.state(&saved::state(world))?;
            file.mark(&digests.mark(world))?;
        }
        let start = world.time().as_ns();
        let recorded = turns.iter().map(|turn| {
            let after_ns = (turn.at.as_ns() - start) as i64;
            let (data, robot) = (COMMAND.to_vec(), turn.robot as u32);
            v1::RecordedInput {
                robot,
                after_ns,
                checksum: checksum(after_ns, &data),
                data,
                answers_tick: None,
                sensor: None,
            }
        });
        file.inputs(&v1::RecordedInputs { tick, changes: Vec::new(), inputs: recorded.collect() })?;
        let inputs = turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: COMMAND });
        let inputs: Vec<_> = inputs.collect();
        world.finish(&inputs);
    }
    file.mark(&digests.last_mark(world))?;
    Ok(file.finish()?.into_inner())
}

/// The command of a brain.
const COMMAND: &[u8] = &[0x03, 0x10, 0x07, 0x40, 0x20, 0x11, 0x00];

const RECORDS: &[&[u8]] =
    &[b"lz4", b"/baudbot/state", b"\x06", b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00", b"\xff\xff\xff\xff"];

const NUMBERS: &[&[u8]] = &[
    b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"\xff\xff\xff\xff\x0f",
    b"\x80\x01",
    b"\x00\x00\x00\x00\x00\x00\xf8\x7f",
    b"\x00\x00\x00\x00\x00\x00\xf0\x7f",
    b"\xff\xff\xff\xff\xff\xff\xef\x7f",
];
