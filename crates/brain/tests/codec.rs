//! The codec of raw brains, against the bytes of a microcontroller.

use std::sync::Arc;

use baudbot_brain::{
    Actuator, ActuatorKind, Body, Component, CreateVersion, Encoding, Firmware, MotorKind, Port, PortFormat,
    Protocol, RawCommands, RawReadings, RawTurn, Sensor, SensorKind, Signals,
};
use baudbot_wire::{Decoder, Message, Sample, frame, line_image, scip, write_readings, write_values};
use proptest::collection::vec;
use proptest::prelude::*;

fn body(protocol: Protocol) -> Arc<Body> {
    let component = Component {
        name: String::new(),
        unit: "1".to_owned(),
        encoding: Encoding::Counter { bits: 16 },
        count: 1,
    };
    let sensor = |name: &str, count| Sensor {
        name: name.to_owned(),
        kind: SensorKind::Infrared,
        components: vec![component.clone(); count],
        period_ns: 20_000_000,
        phase_ns: 0,
        mount: None,
        range_m: None,
        counts_per_turn: None,
        counts_per_m: None,
        port: None,
        opening_rad: None,
        sweep: None,
        columns: None,
    };
    Arc::new(Body {
        name: "alice".to_owned(),
        radius_m: 0.2,
        half_track_m: 0.2,
        wheel_radius_m: 0.1,
        signal_limit: None,
        motor_encoding: Encoding::Signed { bits: 8, limit: 1.0 },
        sensors: vec![sensor("one", 1), sensor("two", 2)],
        firmware: Firmware { protocol, period_ns: Some(20_000_000) },
        baud: None,
        bits_per_character: None,
        motor_kind: MotorKind::Dc,
        actuators: Vec::new(),
        onboard: false,
        operations_per_s: None,
        ram_bytes: None,
    })
}

fn raw(at_ns: u64, bytes: &[u8]) -> RawTurn {
    RawTurn { tick: at_ns / 10_000_000, at_ns, bytes: bytes.to_vec(), ports: Vec::new() }
}

/// A frame closed at 7 s with a sample of the second sensor, 0.3 ms old.
fn readings_frame(body: &Body) -> Vec<u8> {
    let fresh = |sensor| (sensor == 1).then_some(Sample { age_100us: 3, values: &[5.0, -6.0] });
    let (mut payload, mut bytes) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
    let len = write_readings(&body.layout().borrow(), 9, 70_000_u32 as u16, fresh, &mut payload).unwrap();
    let len = frame::encode(&payload[..len], &mut bytes).unwrap();
    bytes[..len].to_vec()
}

#[test]
fn a_framed_reading_tells_its_age_and_is_readable_once() {
    let body = body(Protocol::Framed { ages: true });
    let bytes = readings_frame(&body);
    let mut readings = RawReadings::new(Arc::clone(&body)).unwrap();
    let (head, tail) = bytes.split_at(5);
    assert!(!readings.turn(&raw(7_000_000_000, head)).has_news());
    let turn = readings.turn(&raw(7_010_000_000, tail));
    let reading = turn.reading("two").unwrap();
    assert_eq!(reading.values, [5.0, -6.0]);
    assert_eq!((reading.sequence, reading.readable), (9, true));
    assert_eq!(reading.sampled_at_ns, Some(6_999_700_000));
    assert_eq!(reading.age_ns(turn.at_ns), Some(10_300_000));
    assert_eq!(turn.reading("one"), None);
    let turn = readings.turn(&raw(7_020_000_000, &[]));
    assert_eq!((turn.value("two"), turn.has_news()), (Some(5.0), false));
}

#[test]
fn a_bare_message_after_lost_bytes_is_found_by_the_silence_before_it() {
    let body = body(Protocol::Bare { gap_ns: 15_000_000 });
    let mut bytes = [0; 6];
    write_values(body.layout().borrow().components, [1.0, 2.0, 3.0], &mut bytes).unwrap();
    let mut readings = RawReadings::new(body).unwrap();
    // Bytes of neighbouring turns may have come back to back; two turns without any are a pause.
    readings.turn(&raw(10_000_000, &bytes[..1]));
    let turn = readings.turn(&raw(20_000_000, &bytes[1..]));
    assert_eq!(turn.reading("two").unwrap().values, [2.0, 3.0]);
    assert_eq!(turn.reading("two").unwrap().sequence, 1);
    assert_eq!(turn.reading("two").unwrap().sampled_at_ns, None);
    readings.turn(&raw(30_000_000, &bytes[3..]));
    readings.turn(&raw(40_000_000, &[]));
    readings.turn(&raw(50_000_000, &[]));
    let turn = readings.turn(&raw(60_000_000, &bytes));
    assert_eq!((turn.value("one"), turn.reading("one").unwrap().sequence), (Some(1.0), 2));
}

#[test]
fn commands_arrive_as_they_were_meant() {
    let framed = body(Protocol::Framed { ages: false });
    let mut commands = RawCommands::new(&framed).unwrap();
    let layout = framed.layout();
    let mut decoder = Decoder::new();
    let mut payload_of = |bytes: Vec<u8>| {
        let payload = bytes.iter().find_map(|&byte| decoder.push(byte).map(|frame| frame.unwrap().to_vec()));
        payload.unwrap()
    };
    let payload = payload_of(commands.command(Signals { left: 1.0, right: -1.0 }));
    let Ok(Message::Command(command)) = Message::parse(&payload, &layout.borrow()) else {
        panic!("no command")
    };
    assert!(command.values().eq([1.0, -1.0]));
    let payload = payload_of(commands.poll().unwrap());
    assert_eq!(Message::parse(&payload, &layout.borrow()), Ok(Message::Poll { sequence: 1 }));

    let mut commands = RawCommands::new(&body(Protocol::Bare { gap_ns: 1 })).unwrap();
    assert_eq!(commands.command(Signals { left: 1.0, right: 0.0 }), [127, 0]);
    assert_eq!(commands.poll(), None);

    let mut commands = RawCommands::new(&khepera()).unwrap();
    assert_eq!(commands.command(Signals { left: 1.0, right: -0.5 }), b"D,127,-64\rH\rN\r");
    assert_eq!(commands.poll().unwrap(), b"H\rN\r");
}

/// A Khepera with an infra-red sensor and encoders.
fn khepera() -> Arc<Body> {
    let mut body = Arc::unwrap_or_clone(body(Protocol::Khepera));
    body.sensors[0].components[0].encoding = Encoding::Level { bits: 10, min: 0.0, max: 1023.0 };
    Arc::new(body)
}

/// A Create with encoders, a bumper and a sensor that is not in its messages.
fn create() -> Arc<Body> {
    let mut body = Arc::unwrap_or_clone(body(Protocol::Create(CreateVersion::Two)));
    let sensor = body.sensors[0].clone();
    body.sensors[1].name = "encoders".to_owned();
    let mut bumper = Sensor { name: "bumper_left".to_owned(), ..sensor };
    bumper.components[0].encoding = Encoding::Level { bits: 1, min: 0.0, max: 1.0 };
    body.sensors.push(bumper);
    Arc::new(body)
}

#[test]
fn a_create_is_opened_once_and_then_only_driven() {
    let opening = [128, 132, 148, 3, 43, 44, 7];
    let signals = Signals { left: 0.4, right: -0.4 };
    let drive = [145, 255, 56, 0, 200];
    let mut commands = RawCommands::new(&create()).unwrap();
    assert_eq!(commands.command(signals), [&opening[..], &drive].concat());
    for _ in 0..600 {
        assert_eq!(commands.command(signals), drive);
        assert_eq!(commands.wait(), [] as [u8; 0]);
    }
    let mut commands = RawCommands::new(&create()).unwrap();
    assert_eq!(commands.wait(), opening);
    assert_eq!(commands.wait(), [] as [u8; 0]);
    assert_eq!(commands.command(signals), drive);
    assert_eq!(commands.poll().unwrap(), opening);
    assert_eq!(create().command_ns(), 0);
}

#[test]
fn a_stream_is_readable_as_far_as_it_is_told() {
    let mut readings = RawReadings::new(create()).unwrap();
    let message = [19, 8, 43, 255, 255, 44, 1, 0, 7, 2, 142];
    let sum = message.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    let message = [&message[..10], &[message[10].wrapping_sub(sum)]].concat();
    assert!(!readings.turn(&raw(10_000_000, &message[..6])).has_news());
    let turn = readings.turn(&raw(20_000_000, &message[6..]));
    assert_eq!(turn.reading("encoders").unwrap().values, [-1.0, 256.0]);
    assert_eq!((turn.value("bumper_left"), turn.value("one")), (Some(1.0), None));
    let reading = turn.reading("encoders").unwrap();
    assert_eq!((reading.sampled_at_ns, reading.sequence, reading.readable), (None, 1, true));
    assert!(!readings.turn(&raw(30_000_000, &[])).has_news());
}

#[test]
fn an_answer_in_text_is_readable_and_the_acknowledgement_is_no_news() {
    let mut readings = RawReadings::new(khepera()).unwrap();
    assert!(!readings.turn(&raw(10_000_000, b"d\r\nh,-8,32")).has_news());
    assert!(!readings.turn(&raw(20_000_000, b"767\r\nn,70")).has_news());
    let turn = readings.turn(&raw(30_000_000, b"0\r\nd\r\n"));
    assert_eq!(turn.reading("one").unwrap().values, [700.0]);
    let reading = turn.reading("two").unwrap();
    assert_eq!(reading.values, [-8.0, 32767.0]);
    assert_eq!((reading.sampled_at_ns, reading.sequence, reading.readable), (None, 1, true));
    let turn = readings.turn(&raw(40_000_000, b"n,1,2\r\nn,1024\r\nx\r\n"));
    assert_eq!((turn.value("one"), turn.has_news()), (Some(700.0), false));
    // Without positions before it, an answer has none.
    let turn = readings.turn(&raw(50_000_000, b"n,5\r\n"));
    let readable = |name| turn.reading(name).is_some_and(|reading| reading.readable);
    assert_eq!((turn.value("one"), readable("one"), readable("two")), (Some(5.0), true, false));
}

#[test]
fn a_body_that_lines_of_text_cannot_speak_of_is_refused() {
    let mut exact = Arc::unwrap_or_clone(body(Protocol::Khepera));
    exact.motor_encoding = Encoding::Float64;
    assert!(RawCommands::new(&exact).is_err());
    let mut body = Arc::unwrap_or_clone(with_ports());
    body.firmware.protocol = Protocol::Khepera;
    assert!(RawReadings::new(Arc::new(body)).is_err());
}

#[test]
fn a_command_in_text_takes_as_long_as_the_longest_with_its_poll() {
    let mut body = Arc::unwrap_or_clone(khepera());
    (body.baud, body.bits_per_character) = (Some(9600), Some(11));
    // `D,-127,-127`, `H` and `N` with their ends: 16 characters of 11 bits.
    assert_eq!(body.command_ns(), 18_333_334);
}

/// A laser's scan of three rays, taken at 250 ms; the middle one met nothing.
fn scan() -> Vec<u8> {
    let format =
        scip::Format { characters: scip::Characters::Three, first_step: 0, last_step: 2, cluster: 1 };
    let mut bytes = vec![0; format.message_len()];
    let len = scip::encode(&format, 250, [1000, 0, 2500].into_iter(), &mut bytes).unwrap();
    bytes.truncate(len);
    bytes
}

/// A body with a turret and with sensors that have ports, one of them before those on the wire.
fn with_ports() -> Arc<Body> {
    let mut body = Arc::unwrap_or_clone(body(Protocol::Framed { ages: true }));
    for (place, format, count) in [
        (0, PortFormat::Scip2, 3),
        (3, PortFormat::LineImage, 8),
        (4, PortFormat::Nmea, 5),
        (5, PortFormat::Unknown, 1),
    ] {
        let mut sensor = body.sensors.last().unwrap().clone();
        sensor.components.truncate(1);
        sensor.components[0].count = count;
        let message_bytes = line_image::encoded_len(2, 1) as u64;
        let port = Port { format, message_bytes, baud: None, bits_per_character: None };
        (sensor.name, sensor.port) = (format.name().into(), Some(port));
        body.sensors.insert(place, sensor);
    }
    body.actuators.push(Actuator {
        name: "head".into(),
        kind: ActuatorKind::Turret,
        range_rad: Some([-1.0, 1.0]),
    });
    Arc::new(body)
}

#[test]
fn ports_are_heard_and_do_not_shift_the_sensors_on_the_wire() {
    let body = with_ports();
    let mut readings = RawReadings::new(Arc::clone(&body)).unwrap();
    let scan = scan();
    let (head, tail) = scan.split_at(9);
    let mut turn = raw(7_000_000_000, &readings_frame(&body));
    turn.ports = vec![(0, head.to_vec())];
    let first = readings.turn(&turn);
    assert_eq!(first.reading("two").unwrap().values, [5.0, -6.0]);
    assert_eq!((first.reading("one"), first.reading("scip2")), (None, None));
    turn = raw(7_010_000_000, &[]);
    turn.ports = vec![(0, tail.to_vec())];
    let second = readings.turn(&turn);
    let reading = second.reading("scip2").unwrap();
    assert_eq!(reading.values, [1.0, -1.0, 2.5]);
    assert_eq!((reading.sampled_at_ns, reading.sequence, reading.readable), (Some(250_000_000), 1, true));
    assert!(!second.reading("two").unwrap().readable);
    assert!(!readings.turn(&raw(7_020_000_000, &[])).has_news());
}

#[test]
fn an_image_is_found_among_other_bytes() {
    let body = with_ports();
    let mut readings = RawReadings::new(Arc::clone(&body)).unwrap();
    let column = |red, depth_mm| line_image::Column { rgb: [red, 0, 255], depth_mm };
    let mut bytes = vec![0xa5, 1, 2, 3];
    bytes.resize(4 + line_image::encoded_len(2, 1), 0);
    line_image::encode(9, [column(0, 0), column(255, 1500)].into_iter(), 1, &mut bytes[4..]).unwrap();
    let mut turn = raw(0, &[]);
    turn.ports = vec![(body.sensor_index("line-image").unwrap(), bytes)];
    let image = readings.turn(&turn).reading("line-image").cloned().unwrap();
    assert_eq!(image.values, [0.0, 1.0, 0.0, 0.0, 1.0, 1.0, -1.0, 1.5]);
}

#[test]
fn other_actuators_get_what_they_were_last_sent() {
    let body = with_ports();
    let mut commands = RawCommands::new(&body).unwrap();
    let layout = body.layout();
    let mut values = |others: &[f64]| {
        let bytes = commands.command_with(Signals { left: 1.0, right: 0.0 }, others);
        let mut decoder = Decoder::new();
        let payload = bytes.iter().find_map(|&byte| decoder.push(byte).map(|frame| frame.unwrap().to_vec()));
        match Message::parse(&payload.unwrap(), &layout.borrow()) {
            Ok(Message::Command(command)) => command.values().collect::<Vec<_>>(),
            other => panic!("no command but {other:?}"),
        }
    };
    assert_eq!(values(&[]), [1.0, 0.0, 0.0]);
    assert_eq!(values(&[-1.0]), [1.0, 0.0, -1.0]);
    assert_eq!(values(&[]), [1.0, 0.0, -1.0]);
}

proptest! {
    #[test]
    fn any_bytes_on_ports_do_no_harm(turns in vec((vec(any::<u8>(), 0..60), any::<u64>()), 0..20)) {
        let body = with_ports();
        let mut readings = RawReadings::new(Arc::clone(&body)).unwrap();
        for (bytes, at_ns) in &turns {
            let mut turn = raw(*at_ns, &[]);
            turn.ports = (0..body.sensors.len()).map(|place| (place, bytes.clone())).collect();
            prop_assert_eq!(readings.turn(&turn).readings.len(), body.sensors.len());
        }
    }

    #[test]
    fn any_bytes_do_no_harm(turns in vec((vec(any::<u8>(), 0..40), any::<u64>()), 0..20), gap_ns: u64) {
        let create = Protocol::Create(CreateVersion::Two);
        for protocol in [Protocol::Framed { ages: true }, Protocol::Bare { gap_ns }, Protocol::Khepera, create] {
            let body = if protocol == Protocol::Khepera { khepera() } else { body(protocol) };
            let mut readings = RawReadings::new(body).unwrap();
            for (bytes, at_ns) in &turns {
                let turn = readings.turn(&raw(*at_ns, bytes));
                prop_assert_eq!(turn.readings.len(), 2);
            }
        }
    }
}
