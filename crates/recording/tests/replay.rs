//! Recordings that are run again to the same bits; a change in a file is found at its tick.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_recording::{
    Digests, RecordedRun, RecordingError, Replay, Writer, change, checksum, header, saved, topic,
};
use baudbot_sim::{Input, Intervention, Pose, Scenario, SimTime, World};
use prost::Message;

const SCENARIO: &str = r#"
seed = 3
collision = "stop-robot"
[[arena.polygons]]
name = "room"
solid = false
points_m = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
[[robots]]
name = "alice"
link = { kind = "uart", baud = 9600 }
firmware = { period_ms = 20.0 }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
[robots.sensors.ir]
kind = "ir"
bearing_rad = 0.0
rays = 5
opening_rad = 0.5
range_m = 2.0
c1_m2 = 0.03
c2 = 0.1
sigma = 0.02
bits = 8
period_ms = 10.0
[[robots]]
name = "bob"
start = { x_m = -1.0 }
link = { kind = "ideal" }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
"#;

/// The arbitrary bytes that two brains write in a tick.
fn bytes(tick: u64, robot: usize) -> Vec<u8> {
    let command = |left: i8| {
        let scenario = scenario();
        let layout = scenario.robots[robot].firmware.layout();
        let mut payload = [0; baudbot_wire::frame::MAX_PAYLOAD];
        let signals = [f64::from(left) / 100.0, 0.3];
        let n = baudbot_wire::message::write_command(&layout, tick as u8, signals, &mut payload).unwrap();
        let mut frame = [0; baudbot_wire::frame::MAX_FRAME];
        let n = baudbot_wire::frame::encode(&payload[..n], &mut frame).unwrap();
        frame[..n].to_vec()
    };
    if tick % 7 == 3 { Vec::new() } else { command((tick % 50) as i8) }
}

fn scenario() -> Arc<Scenario> {
    baudbot_scenario::parse(SCENARIO).unwrap().into()
}

/// A recording of so many ticks, with a mark every 40 and a change by hand in tick 55.
fn record(ticks: u64) -> (Vec<u8>, World) {
    let mut world = World::new(scenario());
    let mut file = Writer::new(Cursor::new(Vec::new()), &header("w", world.scenario(), None)).unwrap();
    file.state(&saved::state(&world)).unwrap();
    let mut digests = Digests::default();
    file.mark(&digests.last_mark(&world)).unwrap();
    while world.tick() < ticks {
        let tick = world.tick();
        if tick == 55 {
            let moved = Intervention::PlaceRobot { robot: "bob".into(), pose: Pose::new(-1.0, 1.0, 0.5) };
            world.intervene(&moved).unwrap();
            let changes = vec![change(&moved)];
            file.inputs(&v1::RecordedInputs { tick, changes, inputs: Vec::new() }).unwrap();
        }
        let turns = world.begin().to_vec();
        digests.note(&world);
        if tick.is_multiple_of(40) {
            file.mark(&digests.mark(&world)).unwrap();
        }
        if tick % 100 == 99 {
            file.state(&saved::state(&world)).unwrap();
        }
        let written: Vec<_> = turns.iter().map(|turn| (turn, bytes(tick, turn.robot))).collect();
        let inputs: Vec<_> =
            written.iter().map(|(turn, bytes)| Input { robot: turn.robot, at: turn.at, bytes }).collect();
        file.inputs(&v1::RecordedInputs {
            tick,
            changes: Vec::new(),
            inputs: inputs.iter().map(|input| recorded(&world, input)).collect(),
        })
        .unwrap();
        world.finish(&inputs);
    }
    file.mark(&digests.last_mark(&world)).unwrap();
    world.begin();
    (file.finish().unwrap().into_inner(), world)
}

fn recorded(world: &World, input: &Input<'_>) -> v1::RecordedInput {
    let after_ns = (input.at.as_ns() - world.time().as_ns()) as i64;
    let (data, robot) = (input.bytes.to_vec(), input.robot as u32);
    v1::RecordedInput {
        robot,
        after_ns,
        checksum: checksum(after_ns, &data),
        data,
        answers_tick: None,
        sensor: None,
    }
}

fn recorded_run(file: &[u8]) -> Arc<RecordedRun> {
    RecordedRun::read(file).unwrap().into()
}

/// Replays a file to its end.
fn replay(file: &[u8]) -> (Replay, World) {
    let (mut replay, mut world) = Replay::start(recorded_run(file)).unwrap();
    while replay.step(&mut world).unwrap() {}
    (replay, world)
}

/// The same file, with each message of a topic put through this.
fn rewritten(file: &[u8], of: &str, mut change: impl FnMut(Vec<u8>) -> Option<Vec<u8>>) -> Vec<u8> {
    let mut out = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let mut channels = BTreeMap::new();
    for message in mcap::MessageStream::new(file).unwrap() {
        let message = message.unwrap();
        let own = Arc::clone(&message.channel);
        let channel = *channels.entry(own.topic.clone()).or_insert_with(|| {
            let schema = own.schema.as_ref().unwrap();
            let schema = out.add_schema(&schema.name, &schema.encoding, &schema.data).unwrap();
            out.add_channel(schema, &own.topic, "protobuf", &BTreeMap::new()).unwrap()
        });
        let data = message.data.to_vec();
        let data = if own.topic == of { change(data) } else { Some(data) };
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        if let Some(data) = data {
            out.write_to_known_channel(&header, &data).unwrap();
        }
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

/// The file with one flipped bit in the bytes that a brain wrote in this tick; `mended`: with a checksum that fits the
/// altered bytes.
fn flipped(file: &[u8], tick: u64, mended: bool) -> Vec<u8> {
    rewritten(file, topic::INPUTS, |data| {
        let mut inputs = v1::RecordedInputs::decode(data.as_slice()).unwrap();
        if let Some(input) =
            inputs.inputs.iter_mut().find(|input| inputs.tick == tick && !input.data.is_empty())
        {
            input.data[3] ^= 0x10;
            if mended {
                input.checksum = checksum(input.after_ns, &input.data);
            }
        }
        Some(inputs.encode_to_vec())
    })
}

#[test]
fn a_recording_is_replayed_to_the_same_bits() {
    let (file, recorded) = record(300);
    let (replay, world) = replay(&file);
    assert_eq!(replay.difference(), None);
    assert_eq!((world.tick(), world.hash()), (300, recorded.hash()));
    assert_eq!(world.save(), recorded.save());
    assert!(world.robots().all(|robot| robot.counters().distance_m > 0.05));
}

#[test]
fn any_tick_can_be_gone_to_from_any_other() {
    let (file, _) = record(300);
    let (mut replay, mut world) = Replay::start(recorded_run(&file)).unwrap();
    let mut hashes = vec![world.hash()];
    while replay.step(&mut world).unwrap() {
        hashes.push(world.hash());
    }
    assert_eq!(hashes.len(), 301);
    for tick in [299, 300, 0, 150, 149, 148, 20, 250, 250, 9999, 1, 56, 55, 54] {
        replay.seek(&mut world, tick).unwrap();
        assert_eq!(world.tick(), tick.min(300));
        assert_eq!(world.hash(), hashes[world.tick() as usize], "tick {tick}");
    }
    assert_eq!(replay.difference(), None);
}

#[test]
fn a_flipped_bit_of_an_input_is_found_at_its_tick() {
    let (file, _) = record(300);
    for tick in [1, 2, 30, 32, 57, 123, 204, 299] {
        let (replay, _) = replay(&flipped(&file, tick, false));
        let difference = replay.difference().unwrap_or_else(|| panic!("tick {tick}"));
        assert_eq!(difference.tick, tick);
        assert!(
            difference.what.ends_with("the bytes of its brain differ from the recorded ones"),
            "{difference}"
        );
    }
}

#[test]
fn an_input_that_was_forged_is_found_by_what_it_does() {
    let (file, _) = record(300);
    for tick in [2, 32, 123] {
        let (replay, _) = replay(&flipped(&file, tick, true));
        let difference = replay.difference().unwrap_or_else(|| panic!("tick {tick}"));
        // The byte arrives late on a cable that is full.
        assert!((tick + 1..tick + 60).contains(&difference.tick), "{tick}: {difference}");
        let what = &difference.what;
        assert!(what == "`alice`: cable" || what.starts_with("the state's fingerprint"), "{difference}");
    }
}

#[test]
fn an_input_or_a_change_that_is_missing_is_found() {
    let (file, _) = record(300);
    let without = |tick: u64, changes: bool| {
        rewritten(&file, topic::INPUTS, |data| {
            let inputs = v1::RecordedInputs::decode(data.as_slice()).unwrap();
            (inputs.tick != tick || inputs.changes.is_empty() == changes).then_some(data)
        })
    };
    let (replayed, _) = replay(&without(55, true));
    let difference = replayed.difference().unwrap();
    assert_eq!((difference.tick, difference.what.as_str()), (55, "`bob`: pose"));
    let (replayed, _) = replay(&without(100, false));
    assert!((101..104).contains(&replayed.difference().unwrap().tick));
}

#[test]
fn what_comes_late_is_put_into_its_tick() {
    let (file, recorded) = record(120);
    // Inputs of some ticks come behind those of later ones, as of a world that is ahead of its brains.
    let mut held = Vec::new();
    let mut late = Vec::new();
    rewritten(&file, topic::INPUTS, |data| {
        let tick = v1::RecordedInputs::decode(data.as_slice()).unwrap().tick;
        if tick % 5 == 1 {
            held.push(data.clone());
        } else {
            late.push(data.clone());
        }
        if tick % 5 == 0 {
            late.append(&mut held);
        }
        Some(data)
    });
    late.append(&mut held);
    let mut late = late.into_iter();
    let (replay, world) = replay(&rewritten(&file, topic::INPUTS, |_| late.next()));
    assert_eq!((replay.difference(), world.hash()), (None, recorded.hash()));
}

#[test]
fn a_file_that_is_cut_off_or_damaged_is_replayed_as_far_as_it_goes() {
    let (file, _) = record(300);
    let mut last = Vec::new();
    for n in (0..file.len()).step_by(97) {
        match RecordedRun::read(&file[..n]) {
            Ok(run) => {
                // The index at the end is not missed.
                assert!(run.problem().is_some() || run.last_tick() == 300, "{n}");
                last.push(run.last_tick());
                let (mut replay, mut world) = Replay::start(Arc::new(run)).unwrap();
                while replay.step(&mut world).unwrap() {}
                assert_eq!(replay.difference(), None);
            }
            Err(error) => assert!(
                matches!(
                    error,
                    RecordingError::Empty | RecordingError::NotMcap(_) | RecordingError::Headless(_)
                ) && last.is_empty(),
                "{n}: {error}"
            ),
        }
    }
    assert!(last.is_sorted() && last.contains(&0) && last.contains(&160) && last.contains(&300));
    // A bit that the disk has flipped is found by the chunk's own checksum.
    let mut flips = 0;
    for n in (200..file.len()).step_by(61) {
        let mut damaged = file.clone();
        damaged[n] ^= 4;
        if let Ok(run) = RecordedRun::read(damaged.as_slice()) {
            flips += usize::from(run.problem().is_some());
            let (mut replay, mut world) = Replay::start(Arc::new(run)).unwrap();
            while replay.step(&mut world).unwrap() {}
            assert_eq!(replay.difference(), None, "byte {n}");
        }
    }
    assert!(flips > 20, "{flips}");
}

#[test]
fn what_is_no_recording_of_ours_is_refused_with_the_reason() {
    let refused = |file: &[u8]| RecordedRun::read(file).map(drop).unwrap_err().to_string();
    assert!(refused(b"name = \"wander\"").contains("is not an MCAP file"));
    assert!(refused(b"").contains("is not an MCAP file"));
    let (file, _) = record(10);
    let without_header = rewritten(&file, topic::HEADER, |_| None);
    assert!(refused(&without_header).contains("not a recording of baudbot"));
    let with = |change: fn(&mut v1::RecordingHeader)| {
        rewritten(&file, topic::HEADER, |data| {
            let mut header = v1::RecordingHeader::decode(data.as_slice()).unwrap();
            change(&mut header);
            Some(header.encode_to_vec())
        })
    };
    let newer = refused(&with(|header| {
        header.format = 2;
        header.program_version = "9.0.0".into();
    }));
    assert_eq!(
        newer,
        "is of format 2, which a newer version of baudbot wrote (9.0.0); this one reads format 1"
    );
    let unsound = refused(&with(|header| header.scenario_toml = "step_ms = -1".into()));
    assert!(unsound.contains("has a scenario that cannot be used: step_ms: must"), "{unsound}");
    assert!(refused(&rewritten(&file, topic::STATE, |_| None)).contains("before the first state"));
    assert!(refused(&rewritten(&file, topic::INPUTS, |_| Some(vec![255]))).contains("cannot be read"));
}

#[test]
fn a_recording_of_another_version_is_done_again_from_its_start() {
    let (file, _) = record(50);
    let header = rewritten(&file, topic::HEADER, |data| {
        let mut header = v1::RecordingHeader::decode(data.as_slice()).unwrap();
        header.program_version = "0.0.1".into();
        Some(header.encode_to_vec())
    });
    let broken = |data: Vec<u8>| {
        let mut state = v1::RecordedState::decode(data.as_slice()).unwrap();
        state.state.truncate(20);
        Some(state.encode_to_vec())
    };
    let other = rewritten(&header, topic::STATE, broken);
    let (replay, _) = replay(&other);
    assert_eq!(replay.difference(), None);
    // A state of this version that cannot be read is an error.
    let error = Replay::start(recorded_run(&rewritten(&file, topic::STATE, broken))).unwrap_err();
    assert!(error.to_string().starts_with("begins with a state (tick 0, of baudbot"), "{error}");
}

#[test]
fn a_state_by_value_is_a_recording_of_one_tick() {
    let (_, mut world) = record(70);
    let bytes = saved::to_bytes("w", &world).unwrap();
    assert!(bytes.len() < 16_000, "{}", bytes.len());
    let run = RecordedRun::read(bytes.as_slice()).unwrap();
    assert_eq!((run.first_tick(), run.last_tick(), run.header().world.as_str()), (70, 70, "w"));
    let mut again = run.first_state().unwrap();
    assert_eq!(again.hash(), world.hash());
    for world in [&mut world, &mut again] {
        for _ in 0..50 {
            world.begin();
            world.finish(&[Input { robot: 0, at: SimTime::ZERO, bytes: &[1, 2, 3] }]);
        }
    }
    assert_eq!(again.hash(), world.hash());
}

/// The places of a file's chunks: the records between them have no messages.
fn chunks(file: &[u8]) -> Vec<std::ops::Range<usize>> {
    let (mut at, mut chunks) = (8, Vec::new());
    while at + 9 <= file.len() - 8 {
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap()) as usize;
        // The head of a chunk matters too, but for the times of its messages.
        if file[at] == 6 {
            chunks.push(at..at + 9);
            chunks.push(at + 9 + 16..at + 9 + length);
        }
        at += 9 + length;
    }
    chunks
}

/// The name of a chunk's packing is outside of its checksum.
#[cfg(feature = "lz4")]
#[test]
fn a_chunk_whose_packing_is_damaged_costs_that_chunk() {
    let (file, _) = record(300);
    let names = file.windows(7).enumerate().filter(|(_, bytes)| bytes == b"\x03\0\0\0lz4");
    let places: Vec<_> = names.map(|(place, _)| place + 6).collect();
    assert!(places.len() > 3, "{places:?}");
    let is_less = |place: &&usize| {
        let mut damaged = file.clone();
        damaged[**place] ^= 1;
        let run = recorded_run(&damaged);
        assert!(run.is_whole() || run.problem().is_some(), "byte {place}");
        !run.is_whole()
    };
    // The index at the end of the file names them once more, and nothing needs that.
    assert_eq!(places[1..].iter().filter(is_less).count(), places.len() / 2 - 1);
}

#[test]
fn of_500_flipped_bits_none_passes_unless_it_is_outside_of_all_messages() {
    let (file, recorded) = record(300);
    let chunks = chunks(&file);
    // As good as chance, and the same each time.
    let places = (0..500_usize).map(|i| (i * 7919 * 7919) % (8 * file.len()));
    let read = |run: &RecordedRun| format!("{run:?}").split(", condition: ").next().unwrap().to_owned();
    let sound = read(&recorded_run(&file));
    let (mut passed, mut went_on) = (0, 0);
    for place in places {
        let mut damaged = file.clone();
        damaged[place / 8] ^= 1 << (place % 8);
        let Ok(run) = RecordedRun::read(damaged.as_slice()) else { continue };
        let (is_whole, stretches) = (run.is_whole(), run.stretches().len());
        let run = Arc::new(run);
        let Ok((mut replay, mut world)) = Replay::start(Arc::clone(&run)) else { continue };
        while replay.step(&mut world).unwrap() {}
        assert_eq!(replay.difference(), None, "bit {place}");
        if is_whole {
            passed += 1;
            // A chunk has some bytes that mark its end, behind the last ones that count.
            if chunks.iter().any(|chunk| chunk.contains(&(place / 8))) {
                assert_eq!(read(&run), sound, "bit {place}");
            }
            assert_eq!((world.tick(), world.hash()), (300, recorded.hash()), "bit {place}");
        } else {
            went_on += usize::from(stretches > 1 && world.hash() == recorded.hash());
        }
    }
    assert!(passed < 250 && went_on > 50, "{passed}, {went_on}");
}

#[test]
fn behind_damage_a_replay_goes_on_at_the_next_state() {
    let (file, recorded) = record(300);
    // The chunk with the marks and inputs of ticks 121 to 160.
    let chunks = chunks(&file);
    let mut damaged = file.clone();
    damaged[chunks[chunks.len() / 2].end - 5] ^= 1;
    let run = recorded_run(&damaged);
    let ticks: Vec<_> = run.stretches().iter().map(|part| (part.first_tick, part.last_tick)).collect();
    let [(0, gap), (state, 300)] = ticks[..] else { panic!("{ticks:?}") };
    assert!(gap < state && state % 100 == 99, "{ticks:?}");
    assert_eq!((run.extent(), run.is_whole()), ((0, 300), false));
    assert!(run.problem().unwrap().starts_with("the file is damaged at byte"), "{:?}", run.problem());
    let (mut replay, mut world) = Replay::start(run).unwrap();
    let mut seen = vec![world.tick()];
    while replay.step(&mut world).unwrap() {
        seen.push(world.tick());
    }
    let expected: Vec<_> = (0..=gap).chain(state..=300).collect();
    assert_eq!((seen, replay.difference(), world.hash()), (expected, None, recorded.hash()));
    // Any tick can be gone to that is there; of the others, to the last before them.
    for (tick, found) in [(gap + 1, gap), (300, 300), (3, 3), (state - 1, gap), (state, state), (0, 0)] {
        replay.seek(&mut world, tick).unwrap();
        assert_eq!(world.tick(), found, "{tick}");
    }
    assert_eq!(replay.difference(), None);
}
