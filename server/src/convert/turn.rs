//! A Turn in bytes, as it goes over the network.
//!
//! A world with a thousand robots sends its brains eight thousand readings in every tick. Copied into types of the
//! contract, each is an allocation, and encoding them asks three times for each length. So the bytes are written
//! straight from the world, and from the end to the beginning: what is inside a message is there before its length is
//! written. A test compares with what the contract's types make of the same Turn.

use std::time::{SystemTime, UNIX_EPOCH};

use baudbot_sim::{Reading, RobotView, SimTime, World};
use bytes::Bytes;

use crate::clock;
use crate::endpoint::Mode;
use crate::pace::Terms;

/// The step of a brain of one robot.
pub(crate) struct RobotTurn {
    /// The robot's place in the stream.
    pub(crate) place: usize,
    /// The index of the robot in the world.
    pub(crate) robot: usize,
    pub(crate) at: SimTime,
}

/// The `AttachResponse` with the Turn of this number, for a brain of this mode.
pub(crate) fn turn(world: &World, number: u64, robots: &[RobotTurn], (mode, terms): (Mode, Terms)) -> Bytes {
    let room = robots.iter().map(|turn| most_bytes(&world.robot(turn.robot), mode.is_raw())).sum::<usize>();
    let mut bytes = Backwards::with_room(room + 64);
    bytes.message(2, |bytes| {
        if mode == Mode::SerialPort {
            wall_clock(bytes, terms);
        }
        bytes.varint_field(3, number);
        for turn in robots.iter().rev() {
            bytes.message(2, |bytes| robot_turn(bytes, (world, &world.robot(turn.robot)), turn, mode));
        }
        bytes.varint_field(1, world.tick());
    });
    bytes.finish()
}

/// Room for one robot's part: what is in it, and for each message in it its key, its length and its numbers.
fn most_bytes(view: &RobotView<'_>, raw: bool) -> usize {
    if raw {
        let ports = view.unread_of_ports().map(|(_, bytes)| 32 + bytes.len());
        return 64 + view.unread().len() + ports.sum::<usize>();
    }
    64 + view.readings().iter().map(|reading| 64 + 8 * reading.values.len()).sum::<usize>()
}

/// Writes the instants of the wall clock of the tick, if it follows that.
fn wall_clock(bytes: &mut Backwards, terms: Terms) {
    let Terms::FollowsClock { tick_begins, factor, .. } = terms else { return };
    let ago = clock::now().saturating_duration_since(tick_begins);
    let ahead = tick_begins.saturating_duration_since(clock::now());
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let begins_ns = (unix + ahead).saturating_sub(ago).as_nanos() as u64;
    bytes.message(4, |bytes| {
        bytes.double_field(2, factor);
        bytes.varint_field(1, begins_ns);
    });
}

fn robot_turn(bytes: &mut Backwards, (world, view): (&World, &RobotView<'_>), turn: &RobotTurn, mode: Mode) {
    // Bytes that came before the port was opened are taken to have come with the tick.
    let after_ns = |unread: usize, instants: &[SimTime]| -> Vec<u64> {
        let before = std::iter::repeat_n(0, unread.saturating_sub(instants.len()));
        before.chain(instants.iter().map(|at| at.since(world.time()))).collect()
    };
    if mode.is_raw() {
        if mode == Mode::SerialPort {
            if let Some(baud) = view.spec().link.baud() {
                bytes.optional_varint_field(7, baud.into());
            }
            bytes.varints_field(6, &after_ns(view.unread().len(), view.unread_instants()));
        }
        let ports = view.unread_of_ports().zip(view.instants_of_ports());
        let is_told = |data: &[u8]| mode == Mode::SerialPort || !data.is_empty();
        let ports: Vec<_> = ports.filter(|((_, data), _)| is_told(data)).collect();
        for ((sensor, data), instants) in ports.into_iter().rev() {
            bytes.message(5, |bytes| {
                if mode == Mode::SerialPort {
                    if let Some(baud) = world.port_baud(turn.robot, sensor) {
                        bytes.optional_varint_field(4, baud.into());
                    }
                    bytes.varints_field(3, &after_ns(data.len(), instants));
                }
                bytes.bytes_field(2, data);
                bytes.varint_field(1, sensor as u64);
            });
        }
        bytes.bytes_field(3, view.unread());
    } else {
        bytes.varint_field(8, view.has_heard().into());
        let arrived = view.readings().iter().enumerate().filter(|(_, reading)| !reading.values.is_empty());
        for (sensor, read) in arrived.rev() {
            bytes.message(4, |bytes| reading(bytes, sensor, read));
        }
    }
    bytes.varint_field(2, turn.at.as_ns());
    bytes.varint_field(1, turn.place as u64);
}

fn reading(bytes: &mut Backwards, sensor: usize, reading: &Reading) {
    bytes.varint_field(5, reading.readable.into());
    bytes.varint_field(4, reading.sequence.into());
    if let Some(at) = reading.sampled_at {
        bytes.optional_varint_field(3, at.as_ns());
    }
    bytes.doubles_field(2, &reading.values);
    bytes.varint_field(1, sensor as u64);
}

/// A protobuf message that is written from its end to its beginning, last field first.
struct Backwards {
    /// The bytes so far are at the end.
    buffer: Vec<u8>,
    /// The beginning of those.
    start: usize,
}

/// Wire types of fields.
const VARINT: u64 = 0;
const EIGHT_BYTES: u64 = 1;
const WITH_LENGTH: u64 = 2;

impl Backwards {
    fn with_room(bytes: usize) -> Self {
        Self { buffer: vec![0; bytes], start: bytes }
    }

    fn finish(self) -> Bytes {
        Bytes::from(self.buffer).slice(self.start..)
    }

    /// A field with a message, whose fields `write` writes.
    fn message(&mut self, tag: u64, write: impl FnOnce(&mut Self)) {
        let end = self.buffer.len() - self.start;
        write(self);
        let length = self.buffer.len() - self.start - end;
        self.length_and_key(tag, length);
    }

    /// A field with a number, which is left out if it is 0.
    fn varint_field(&mut self, tag: u64, value: u64) {
        if value != 0 {
            self.optional_varint_field(tag, value);
        }
    }

    fn optional_varint_field(&mut self, tag: u64, value: u64) {
        self.varint(value);
        self.varint(tag << 3 | VARINT);
    }

    /// A field with bytes, which is left out if there are none.
    fn bytes_field(&mut self, tag: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.space(bytes.len()).copy_from_slice(bytes);
            self.length_and_key(tag, bytes.len());
        }
    }

    /// A field with one number.
    fn double_field(&mut self, tag: u64, value: f64) {
        self.space(8).copy_from_slice(&value.to_le_bytes());
        self.varint(tag << 3 | EIGHT_BYTES);
    }

    /// A field with whole numbers, which is left out if there are none.
    fn varints_field(&mut self, tag: u64, values: &[u64]) {
        if !values.is_empty() {
            let end = self.buffer.len() - self.start;
            values.iter().rev().for_each(|&value| self.varint(value));
            let length = self.buffer.len() - self.start - end;
            self.length_and_key(tag, length);
        }
    }

    /// A field with numbers, which is left out if there are none.
    fn doubles_field(&mut self, tag: u64, values: &[f64]) {
        if !values.is_empty() {
            let length = 8 * values.len();
            for (place, value) in self.space(length).chunks_exact_mut(8).zip(values) {
                place.copy_from_slice(&value.to_le_bytes());
            }
            self.length_and_key(tag, length);
        }
    }

    fn length_and_key(&mut self, tag: u64, length: usize) {
        self.varint(length as u64);
        self.varint(tag << 3 | WITH_LENGTH);
    }

    fn varint(&mut self, value: u64) {
        if value < 0x80 {
            self.space(1)[0] = value as u8;
            return;
        }
        let length = (u64::BITS - value.leading_zeros()).div_ceil(7) as usize;
        let mut rest = value;
        let place = self.space(length);
        for byte in &mut *place {
            *byte = rest as u8 | 0x80;
            rest >>= 7;
        }
        place[length - 1] &= 0x7f;
    }

    /// The space before what is written.
    fn space(&mut self, length: usize) -> &mut [u8] {
        if length > self.start {
            let more = length.max(self.buffer.len());
            self.buffer.splice(0..0, std::iter::repeat_n(0, more));
            self.start += more;
        }
        let end = self.start;
        self.start -= length;
        &mut self.buffer[self.start..end]
    }
}

#[cfg(test)]
mod tests {
    use baudbot_proto::v1;
    use baudbot_sim::Intervention;
    use baudbot_sim::model::PortUse;
    use prost::Message as _;

    use std::time::Instant;

    use super::*;

    /// The same Turn in types of the contract.
    fn expected(world: &World, number: u64, robots: &[RobotTurn], mode: Mode) -> Vec<u8> {
        let robots = robots.iter().map(|turn| contract_turn(world, turn, mode)).collect();
        let turn = v1::Turn { tick: world.tick(), robots, turn: number, wall_clock: None };
        v1::AttachResponse { response: Some(v1::attach_response::Response::Turn(turn)) }.encode_to_vec()
    }

    fn contract_turn(world: &World, turn: &RobotTurn, mode: Mode) -> v1::RobotTurn {
        let view = world.robot(turn.robot);
        let mut expected =
            v1::RobotTurn { robot: turn.place as u32, at_ns: turn.at.as_ns(), ..v1::RobotTurn::default() };
        let after_ns = |instants: &[SimTime]| match mode {
            Mode::SerialPort => instants.iter().map(|at| at.since(world.time())).collect(),
            Mode::Raw | Mode::Messages => Vec::new(),
        };
        if mode.is_raw() {
            expected.raw = view.unread().to_vec();
            expected.raw_after_ns = after_ns(view.unread_instants());
            let ports = view.unread_of_ports().zip(view.instants_of_ports());
            let port = |((sensor, data), instants): ((usize, &[u8]), &[SimTime])| v1::PortBytes {
                sensor: sensor as u32,
                data: data.to_vec(),
                after_ns: after_ns(instants),
                baud: world.port_baud(turn.robot, sensor).filter(|_| mode == Mode::SerialPort),
            };
            let is_told = |data: &[u8]| mode == Mode::SerialPort || !data.is_empty();
            expected.ports = ports.filter(|((_, data), _)| is_told(data)).map(port).collect();
            expected.baud = view.spec().link.baud().filter(|_| mode == Mode::SerialPort);
        } else {
            let arrived = view.readings().iter().enumerate().filter(|(_, read)| !read.values.is_empty());
            let reading = |(sensor, read): (usize, &Reading)| v1::Reading {
                sensor: sensor as u32,
                values: read.values.to_vec(),
                sampled_at_ns: read.sampled_at.map(|at| at.as_ns()),
                sequence: read.sequence.into(),
                readable: read.readable,
            };
            expected.readings = arrived.map(reading).collect();
            expected.has_message = view.has_heard();
        }
        expected
    }

    #[test]
    fn turns_have_the_bytes_that_the_contracts_types_have() {
        let scenarios = [
            include_str!("../../../catalogue/scenarios/wander.toml"),
            include_str!("../../../catalogue/scenarios/khepera.toml"),
            include_str!("../../../catalogue/scenarios/ecoli.toml"),
            include_str!("../../../catalogue/scenarios/devices/laser.toml"),
        ];
        let (mut with_ports, mut opened) = (0, 0);
        for toml in scenarios {
            let mut world = World::new(baudbot_scenario::parse(toml).unwrap().into());
            let robot = world.scenario().robots[0].name.clone();
            let opens = world.intervene(&Intervention::OpenPort { robot, port_use: PortUse::Open });
            opened += usize::from(opens.is_ok());
            for tick in 0..60 {
                world.begin();
                let robots: Vec<_> = (0..world.robots().len())
                    .map(|robot| RobotTurn { place: robot * 70, robot, at: world.time() })
                    .collect();
                for mode in [Mode::Messages, Mode::Raw, Mode::SerialPort] {
                    let robots = if mode == Mode::SerialPort { &robots[..1] } else { &robots[..] };
                    let bytes = turn(&world, tick * 1000, robots, (mode, Terms::GoesOn));
                    assert_eq!(bytes, expected(&world, tick * 1000, robots, mode));
                }
                let ports = world
                    .robots()
                    .map(|robot| robot.unread_of_ports().filter(|(_, data)| !data.is_empty()).count());
                with_ports += ports.sum::<usize>();
                world.finish(&[]);
            }
        }
        assert!(with_ports > 0 && opened > 2, "no port has been tried");
    }

    #[test]
    fn a_port_is_told_when_the_tick_begins_by_the_wall_clock() {
        let world = World::new(
            baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/khepera.toml"))
                .unwrap()
                .into(),
        );
        let (now, tick_begins) = (Instant::now(), Instant::now() - std::time::Duration::from_millis(5));
        let terms = Terms::FollowsClock { now, tick_begins, factor: 2.0 };
        let of_mode = |mode| {
            let bytes = turn(&world, 1, &[], (mode, terms));
            let response = v1::AttachResponse::decode(bytes).unwrap().response.unwrap();
            let v1::attach_response::Response::Turn(turn) = response else { panic!("{response:?}") };
            turn.wall_clock
        };
        assert_eq!([Mode::Messages, Mode::Raw].map(of_mode), [None, None], "no clock for brains");
        let told = of_mode(Mode::SerialPort).unwrap();
        assert_eq!(told.factor, 2.0);
        let unix_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64;
        let ago_ms = (unix_ns - told.tick_begins_unix_ns) / 1_000_000;
        assert!((5..60_000).contains(&ago_ms), "{ago_ms}");
    }

    #[test]
    fn numbers_of_any_length_have_the_bytes_that_the_contract_gives_them() {
        for bits in 0..=64 {
            for value in [(1_u128 << bits) as u64, ((1_u128 << bits) - 1) as u64] {
                let mut bytes = Backwards::with_room(0);
                bytes.varint_field(1, value);
                let expected = v1::Ended { tick: value }.encode_to_vec();
                assert_eq!(bytes.finish(), expected, "{value}");
            }
        }
    }
}
