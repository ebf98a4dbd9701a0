//! Traces, written and read again.

use std::collections::BTreeMap;

use baudbot_sim::timeline::{Event, What};
use baudbot_sim::{Scenario, SimTime};
use proptest::prelude::*;
use prost::Message;

use super::TraceWriter;
use super::packet::{COUNTER, INSTANT, SLICE_BEGIN, SLICE_END, TracePacket};

/// `Trace` of the format.
#[derive(Clone, PartialEq, Message)]
struct Trace {
    #[prost(message, repeated, tag = "1")]
    packets: Vec<TracePacket>,
}

fn scenario() -> Scenario {
    let robot = |name: &str, x_m: f64| {
        format!(
            "[[robots]]\nname = \"{name}\"\nlink = {{ kind = \"uart\", baud = 9600 }}\n\
             body = {{ radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n\
             start.x_m = {x_m:?}\nsensors.compass = {{ kind = \"compass\" }}\n"
        )
    };
    baudbot_scenario::parse(&(robot("alice", 0.0) + &robot("bob", 1.0))).unwrap()
}

fn event(start: u64, end: u64, what: What) -> Event {
    Event { start: SimTime::from_ns(start), end: SimTime::from_ns(end), what }
}

fn written(events: &[(usize, Event)]) -> Trace {
    let mut writer = TraceWriter::new(Vec::new(), "box", &scenario().robots).unwrap();
    events.iter().for_each(|(robot, event)| writer.event(*robot, event).unwrap());
    Trace::decode(&*writer.finish().unwrap()).unwrap()
}

#[test]
fn signals_of_a_chip_have_tracks_of_slices_and_of_numbers() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../catalogue/scenarios"));
    let text = std::fs::read_to_string(folder.join("firmware.toml")).unwrap();
    let scenario = baudbot_scenario::parse(&baudbot_import::inline(&text, folder).unwrap()).unwrap();
    let chip = scenario.robots[0].chip.as_ref().unwrap();
    let place = |name: &str| chip.signals().iter().position(|signal| signal.name() == name).unwrap();
    let mut writer = TraceWriter::new(Vec::new(), "box", &scenario.robots).unwrap();
    let at = SimTime::from_ns;
    writer.signal_slice(0, place("D9"), (at(5), at(9)), "high").unwrap();
    writer.signal_slice(0, place("D9"), (at(9), at(9)), "nothing").unwrap();
    writer.signal_value(0, place("adc2"), at(7), 512).unwrap();
    assert!(writer.signal_slice(0, 1000, (at(5), at(9)), "high").is_err());
    assert!(writer.signal_slice(1, 0, (at(5), at(9)), "high").is_err());
    let trace = Trace::decode(&*writer.finish().unwrap()).unwrap();
    let (d9, adc2) = ("D9 motors.left.pwm".to_owned(), "adc2 sensors.ir_front".to_owned());
    let expected = [
        (d9.clone(), 5, SLICE_BEGIN, "high".to_owned()),
        (adc2, 7, COUNTER, String::new()),
        (d9, 9, SLICE_END, String::new()),
    ];
    assert_eq!(events(&trace), expected);
    let values: Vec<_> =
        trace.packets.iter().filter_map(|packet| packet.track_event.as_ref()?.counter_value).collect();
    assert_eq!(values, [512]);
    let counters =
        trace.packets.iter().filter_map(|packet| packet.track_descriptor.as_ref()?.counter.as_ref());
    assert_eq!(counters.count(), 1);
}

/// Names of the tracks by their numbers.
fn tracks(trace: &Trace) -> BTreeMap<u64, String> {
    let descriptors = trace.packets.iter().filter_map(|packet| packet.track_descriptor.as_ref());
    let name = |process: Option<&super::packet::ProcessDescriptor>| process?.process_name.clone();
    descriptors
        .map(|track| {
            let name = track.name.clone().or_else(|| name(track.process.as_ref()));
            (track.uuid.unwrap(), name.unwrap())
        })
        .collect()
}

/// Track, instant in ns, kind and name of each event, in the order in which Perfetto takes them.
fn events(trace: &Trace) -> Vec<(String, u64, i32, String)> {
    let tracks = tracks(trace);
    let mut events: Vec<_> = trace
        .packets
        .iter()
        .filter_map(|packet| {
            let event = packet.track_event.as_ref()?;
            let track = tracks[&event.track_uuid.unwrap()].clone();
            let name = event.name.clone().unwrap_or_default();
            Some((track, packet.timestamp.unwrap(), event.r#type.unwrap(), name))
        })
        .collect();
    events.sort_by_key(|(_, at, ..)| *at);
    events
}

#[test]
fn a_read_is_a_slice_of_the_sensor_and_of_the_microcontroller() {
    let trace = written(&[(1, event(10, 30, What::Acquire { sensor: 0 }))]);
    let slice = |track: &str, at, kind, name: &str| (track.to_owned(), at, kind, name.to_owned());
    let expected = [
        slice("compass", 10, SLICE_BEGIN, "read compass"),
        slice("microcontroller", 10, SLICE_BEGIN, "read compass"),
        slice("compass", 30, SLICE_END, ""),
        slice("microcontroller", 30, SLICE_END, ""),
    ];
    assert_eq!(events(&trace), expected);
}

#[test]
fn every_robot_is_a_process_and_no_two_tracks_have_the_same_number() {
    let trace = written(&[]);
    let processes = trace.packets.iter().filter_map(|packet| {
        let process = packet.track_descriptor.as_ref()?.process.as_ref()?;
        Some((process.pid?, process.process_name.clone()?))
    });
    assert_eq!(processes.collect::<Vec<_>>(), [(1, "alice (box)".to_owned()), (2, "bob (box)".to_owned())]);
    let described = trace.packets.iter().filter(|packet| packet.track_descriptor.is_some()).count();
    // Two processes, each with a compass, a microcontroller, a cable up and down, a brain and motors.
    assert_eq!((described, tracks(&trace).len()), (14, 14));
    assert!(trace.packets.iter().all(|packet| packet.trusted_packet_sequence_id == Some(1)));
}

#[test]
fn a_slice_that_ends_where_the_next_begins_ends_first() {
    let up = |start, end| (0, event(start, end, What::Up { bytes: 19 }));
    let kinds = |events: &[(usize, Event)]| -> Vec<_> {
        let trace = written(events);
        self::events(&trace).into_iter().map(|(_, at, kind, _)| (at, kind)).collect()
    };
    let expected = [(0, SLICE_BEGIN), (5, SLICE_END), (5, SLICE_BEGIN), (9, SLICE_END)];
    assert_eq!(kinds(&[up(0, 5), up(5, 9)]), expected);
    assert_eq!(kinds(&[up(5, 9), up(0, 5)]), expected);
}

#[test]
fn what_overlaps_is_on_a_track_of_its_own() {
    let trace =
        written(&[(0, event(0, 10, What::Down { bytes: 6 })), (0, event(5, 15, What::Down { bytes: 6 }))]);
    let tracks: Vec<_> = events(&trace).into_iter().map(|(track, at, ..)| (track, at)).collect();
    let first = "cable down".to_owned();
    let second = "cable down (2)".to_owned();
    assert_eq!(tracks, [(first.clone(), 0), (second.clone(), 5), (first, 10), (second, 15)]);
}

#[test]
fn bytes_sensors_and_news_are_told_of_a_slice() {
    let trace = written(&[
        (0, event(0, 10, What::Port { sensor: 0, bytes: 7 })),
        (0, event(20, 30, What::Think { informed: false })),
    ]);
    let begins = trace.packets.iter().filter_map(|packet| packet.track_event.as_ref());
    let begins: Vec<_> = begins.filter(|event| event.r#type == Some(SLICE_BEGIN)).collect();
    let [port, think] = &begins[..] else { panic!("{begins:?}") };
    let [bytes, sensor] = &port.debug_annotations[..] else { panic!("{port:?}") };
    assert_eq!((bytes.name.as_deref(), bytes.uint_value), (Some("bytes"), Some(7)));
    assert_eq!((sensor.name.as_deref(), sensor.string_value.as_deref()), (Some("sensor"), Some("compass")));
    let [informed] = &think.debug_annotations[..] else { panic!("{think:?}") };
    assert_eq!((informed.name.as_deref(), informed.bool_value), (Some("informed"), Some(false)));
    assert_eq!((&port.categories[..], &think.categories[..]), (&["cable".into()][..], &["brain".into()][..]));
}

#[test]
fn what_was_not_recorded_leaves_a_mark_at_the_latest_instant() {
    let mut writer = TraceWriter::new(Vec::new(), "box", &scenario().robots).unwrap();
    writer.event(0, &event(0, 40, What::Block)).unwrap();
    writer.lost(0, 12).unwrap();
    let trace = Trace::decode(&*writer.finish().unwrap()).unwrap();
    let mark = ("late, missed, lost".to_owned(), 40, INSTANT, "events not recorded".to_owned());
    assert!(events(&trace).contains(&mark), "{:?}", events(&trace));
}

#[test]
fn a_robot_or_a_sensor_that_is_not_there_is_no_panic() {
    let mut writer = TraceWriter::new(Vec::new(), "box", &scenario().robots).unwrap();
    assert!(writer.event(2, &event(0, 1, What::Act)).is_err() && writer.lost(2, 1).is_err());
    writer.event(0, &event(0, 1, What::Acquire { sensor: 9 })).unwrap();
    let trace = Trace::decode(&*writer.finish().unwrap()).unwrap();
    assert!(events(&trace).iter().any(|(track, ..)| track == "sensor 9"));
}

#[test]
fn a_trace_grows_on_its_way_and_not_at_its_end() {
    let mut writer = TraceWriter::new(Counting(0), "box", &scenario().robots).unwrap();
    for i in 0..1000 {
        writer.event(0, &event(10 * i, 10 * i + 5, What::Frame { bytes: 9 })).unwrap();
    }
    let before = writer.written().0;
    let after = writer.finish().unwrap().0;
    assert!(before > 20 * (after - before), "{before} bytes, then {}", after - before);
}

/// Counts what is written.
struct Counting(usize);

impl std::io::Write for Counting {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn any_what() -> impl Strategy<Value = What> {
    prop_oneof![
        any::<u16>().prop_map(|sensor| What::Acquire { sensor }),
        any::<u16>().prop_map(|sensor| What::Missed { sensor }),
        any::<u32>().prop_map(|bytes| What::Up { bytes }),
        any::<u32>().prop_map(|bytes| What::Lost { bytes }),
        any::<u16>().prop_map(|fault| What::Fault { fault }),
        Just(What::Act),
        Just(What::Late),
    ]
}

proptest! {
    #[test]
    fn slices_nest_on_every_track_whatever_happens(
        spans in prop::collection::vec((any_what(), 0_u64..500, 0_u64..60), 0..200),
        far in prop::collection::vec((any_what(), any::<u64>(), any::<u64>()), 0..20),
    ) {
        let near = spans.into_iter().map(|(what, start, length)| event(start, start + length, what));
        let far = far.into_iter().map(|(what, start, end)| event(start, end, what));
        let all: Vec<_> = near.chain(far).map(|event| (0, event)).collect();
        let mut open: BTreeMap<String, i32> = BTreeMap::new();
        for (track, at, kind, _) in events(&written(&all)) {
            let depth = open.entry(track.clone()).or_default();
            *depth += match kind { SLICE_BEGIN => 1, SLICE_END => -1, _ => 0 };
            prop_assert!((0..=1).contains(depth), "{} at {}", track, at);
        }
        prop_assert!(open.values().all(|depth| *depth == 0));
    }
}
