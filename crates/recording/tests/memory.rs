//! The memory for a file: it depends on the file's content, whatever lengths it claims. Allocations of other threads do
//! not count.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_recording::{Digests, Frames, RecordedRun, Writer, header, saved, topic};
use baudbot_sim::{Scenario, World};
use prost::Message;

const SCENARIO: &str = r#"
[[robots]]
name = "alice"
link = { kind = "uart", baud = 9600 }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
"#;

/// The promise of `docs/reference/recording.md`: so many bytes for each of the file's, and these.
const OF_A_BYTE: u64 = 2_048;
const ANYWAY: u64 = 24 << 20;

fn peak(file: &[u8]) -> u64 {
    let read = || {
        if let Ok(recorded) = RecordedRun::read(file) {
            drop(recorded.first_state());
        }
        Frames::read(file).for_each(drop);
    };
    allocation_counter::measure(read).bytes_max
}

fn assert_small(file: &[u8], what: &str) {
    let most = file.len() as u64 * OF_A_BYTE + ANYWAY;
    let bytes = peak(file);
    assert!(bytes <= most, "{what}: {bytes} bytes for a file of {}, at most {most} are allowed", file.len());
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn file(records: &[Vec<u8>]) -> Vec<u8> {
    let empty = record(1, &[0; 8]);
    [b"\x89MCAP0\r\n".to_vec(), empty, records.concat()].concat()
}

/// A chunk that claims to unpack to so many bytes.
fn chunk(size: u64, packed: &[u8]) -> Vec<u8> {
    let fields = [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &3_u32.to_le_bytes(), b"lz4"].concat();
    record(6, &[&fields[..], &(packed.len() as u64).to_le_bytes(), packed].concat())
}

#[test]
fn no_length_that_a_file_claims_asks_for_memory() {
    // A schema whose name is of 4 GB: 44 bytes that ended a server.
    let schema = |name: u32| record(3, &[&1_u16.to_le_bytes()[..], &name.to_le_bytes(), &[0; 4]].concat());
    assert_small(&file(&[schema(u32::MAX)]), "a schema's name");
    assert_eq!(file(&[schema(u32::MAX)]).len(), 44);
    for kind in 1..=15 {
        assert_small(&file(&[record(kind, &[0xff; 40])]), "fields");
        let claims = [&[kind][..], &(1_u64 << 29).to_le_bytes(), &[0; 30]].concat();
        assert_small(&file(&[claims]), "a record");
    }
    for size in [1 << 20, 1 << 30, 1 << 40, u64::MAX] {
        assert_small(&file(&[chunk(size, &[7; 200])]), "a chunk");
    }
    // The bytes unpack to many times their number.
    let mut zeros = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), 64 << 20), &mut zeros).unwrap();
    let (packed, done) = zeros.finish();
    done.unwrap();
    assert_small(&file(&[chunk(64 << 20, &packed)]), "zeros");
    assert_small(&file(&[chunk(1 << 20, &packed)]), "more zeros than are claimed");
}

#[test]
fn a_damaged_state_takes_as_much_memory_as_its_length_allows() {
    let scenario: Arc<Scenario> = Arc::new(baudbot_scenario::parse(SCENARIO).unwrap());
    let mut world = World::new(scenario);
    (0..50).for_each(|_| {
        world.begin();
        world.finish(&[]);
    });
    let state = saved::to_bytes("w", &world).unwrap();
    assert_small(&state, "a state");
    let header = header("w", world.scenario(), None);
    let mut writer = Writer::new(Cursor::new(Vec::new()), &header).unwrap();
    writer.state(&saved::state(&world)).unwrap();
    writer.mark(&Digests::default().last_mark(&world)).unwrap();
    let recorded = writer.finish().unwrap().into_inner();
    for i in 0..200_usize {
        let mut damaged = recorded.clone();
        let place = (i * 7919 * 31) % damaged.len();
        damaged[place] ^= [0xff, 0x80, 0x01, 0x7f][i % 4];
        assert_small(&damaged, &format!("byte {place}"));
    }
}

/// Files that were made up to do harm: one ended a server, one took 2 GB, one 273 MB.
#[test]
fn files_that_did_harm_do_none_any_more() {
    let files: [(&str, &[u8]); 3] = [
        ("bomb", include_bytes!("hostile/bomb.mcap")),
        ("mem-636", include_bytes!("hostile/mem-636.mcap")),
        ("slow-2357", include_bytes!("hostile/slow-2357.mcap")),
    ];
    for (name, file) in files {
        assert_small(file, name);
    }
}

/// A file without checksums once led to a subtraction in the reader that overflowed.
#[test]
fn a_file_without_checksums_is_read_as_far_as_it_makes_sense() {
    let message = record(5, &[0; 22]);
    for cut in 0..message.len() {
        let records = &message[..cut];
        let fields = [&[0; 16][..], &(records.len() as u64).to_le_bytes(), &[0; 8]].concat();
        let chunk = record(6, &[&fields[..], &(records.len() as u64).to_le_bytes(), records].concat());
        assert_small(&file(&[chunk]), "a cut message");
    }
    // The inner record is longer than the chunk.
    let inner = [&[5][..], &1_000_u64.to_le_bytes(), &[0; 100]].concat();
    let fields = [&[0; 16][..], &(inner.len() as u64).to_le_bytes(), &[0; 8]].concat();
    let chunk = record(6, &[&fields[..], &(inner.len() as u64).to_le_bytes(), &inner].concat());
    assert_small(&file(&[chunk]), "an inner record");
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A chunk that is not packed, of messages on topics, which have been announced.
fn messages(messages: &[(&str, &[u8])]) -> Vec<u8> {
    let topics: BTreeSet<_> = messages.iter().map(|(topic, _)| *topic).collect();
    let id = |topic: &str| (topics.iter().position(|other| *other == topic).unwrap() as u16).to_le_bytes();
    let channel = |topic: &&str| record(4, &[&id(topic)[..], &[0; 2], &text(topic), &[0; 8]].concat());
    let mut records: Vec<u8> = topics.iter().flat_map(channel).collect();
    for (topic, data) in messages {
        records.extend(record(5, &[&id(topic)[..], &[0; 20], data].concat()));
    }
    let length = (records.len() as u64).to_le_bytes();
    record(6, &[&[0; 16][..], &length, &[0; 8], &length, &records].concat())
}

fn refused(file: &[u8]) -> String {
    assert_small(file, "a recording");
    RecordedRun::read(file).map(drop).unwrap_err().to_string()
}

/// A list of texts without a letter is two bytes a text in the file, and 24 in memory.
#[test]
fn what_is_empty_is_not_there_in_any_number() {
    let scenario: Arc<Scenario> = Arc::new(baudbot_scenario::parse(SCENARIO).unwrap());
    let header = header("w", &scenario, None).encode_to_vec();
    for (field, key) in [(5, 0x2a), (10, 0x52)] {
        let crowded = [header.clone(), [key, 0].repeat(5_000_000)].concat();
        let said = refused(&file(&[messages(&[(topic::HEADER, &crowded)])]));
        assert!(said.contains(&format!("entries in field {field}; there are at most 100000")), "{said}");
    }
    for (field, key) in [(2, 0x12), (3, 0x1a)] {
        let inputs = [vec![8, 1], [key, 0].repeat(5_000_000)].concat();
        let said = refused(&file(&[messages(&[(topic::HEADER, &header), (topic::INPUTS, &inputs)])]));
        assert!(said.contains(&format!("entries in field {field}; there are at most 10000")), "{said}");
    }
}

/// Each of these marks begins a part of its own. To look through all of them for each would take hours.
#[test]
fn a_million_parts_are_looked_through_once() {
    let scenario: Arc<Scenario> = Arc::new(baudbot_scenario::parse(SCENARIO).unwrap());
    let header = header("w", &scenario, None).encode_to_vec();
    let mark = (topic::MARKS, &[0x18, 2][..]);
    let all = [vec![(topic::HEADER, &header[..])], vec![mark; 1_000_000]].concat();
    let said = refused(&file(&[messages(&all)]));
    assert!(said.contains("is cut off before the first state"), "{said}");
}

/// A window of a table has an end because a tick has a length.
#[test]
fn a_step_that_the_scenario_does_not_have_is_refused() {
    let scenario: Arc<Scenario> = Arc::new(baudbot_scenario::parse(SCENARIO).unwrap());
    for step_ns in [0, 1, u64::MAX] {
        let header = v1::RecordingHeader { step_ns, ..header("w", &scenario, None) }.encode_to_vec();
        let said = refused(&file(&[messages(&[(topic::HEADER, &header)])]));
        assert!(said.contains("a header of another scenario"), "{said}");
    }
}
