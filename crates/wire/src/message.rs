//! Messages: what the payload of a frame means.
//!
//! The high half of the first byte is the version of the protocol, 1; the low half the kind of message. Multi-byte
//! numbers are sent least significant byte first.
//!
//! **Readings**, from the microcontroller:
//!
//! | offset | bytes | meaning |
//! |---|---|---|
//! | 0 | 1 | 0x11 |
//! | 1 | 1 | sequence number, wrapping: a gap is a lost frame |
//! | 2 | 2 | time at which the frame was closed, microcontroller's clock, unit 100 µs, wrapping after 6.5536 s |
//! | 4 | ⌈n/8⌉ | mask: bit i mod 8 of byte ⌊i/8⌋ is set if sensor i of n is in this frame |
//! | | | then for each of these, in order: |
//! | | 0 or 1 | if the layout has ages: how long before the frame's time it was sampled, unit 100 µs, at most 255 |
//! | | ≥ 0 | its components, each in its encoding |
//!
//! A sensor is in the frame if and only if it has a sample that was in no frame before. That is the Boolean
//! readability state of the notes (Wahde 2016, §3.2.1): a bit of the mask.
//!
//! **Command**, to the microcontroller:
//!
//! | offset | bytes | meaning |
//! |---|---|---|
//! | 0 | 1 | 0x12 |
//! | 1 | 1 | sequence number, wrapping |
//! | 2 | ≥ 0 | the motor signals, each in its encoding |
//!
//! **Poll**, to the microcontroller, asks for a readings message: 0x13, then a sequence number.

use thiserror::Error;

use crate::clock;
use crate::codec::{Notice, Sink, Stamp};
use crate::encoding::Encoding;
use crate::error::{NoRoom, WriteError};
use crate::layout::{COMMAND_HEADER_LEN, Layout, READINGS_HEADER_LEN, Sensors, total_len};
use crate::values::{Values, write_values};

/// A payload that makes sense under a layout.
#[derive(Clone, Debug, PartialEq)]
pub enum Message<'a> {
    /// New readings of sensors.
    Readings(Readings<'a>),
    /// Signals for the motors.
    Command(Command<'a>),
    /// A request for readings.
    Poll {
        /// The sequence number, which wraps after 255.
        sequence: u8,
    },
}

impl<'a> Message<'a> {
    /// The meaning of a frame's payload. Both ends must have the same `layout`.
    ///
    /// # Errors
    /// An error if the payload does not fit the layout. Nothing of such a message should be used.
    pub fn parse(payload: &'a [u8], layout: &Layout<'a>) -> Result<Self, MessageError> {
        let &[kind, sequence, ref body @ ..] = payload else {
            return Err(MessageError::Length { expected: COMMAND_HEADER_LEN, found: payload.len() });
        };
        if kind >> 4 != VERSION {
            return Err(MessageError::Version { expected: VERSION, found: kind >> 4 });
        }
        match kind {
            READINGS => Ok(Self::Readings(Readings::parse(payload, sequence, layout)?)),
            COMMAND => Ok(Self::Command(Command::parse(body, sequence, layout)?)),
            POLL if body.is_empty() => Ok(Self::Poll { sequence }),
            POLL => Err(MessageError::Length { expected: POLL_LEN, found: payload.len() }),
            _ => Err(MessageError::Kind { found: kind }),
        }
    }
}

/// New readings, as the microcontroller sent them.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings<'a> {
    /// The number of the microcontroller's frame; wraps after 255.
    pub sequence: u8,
    /// The microcontroller's clock when the frame was closed, in units of 100 µs; wraps. See
    /// [`unwrap_time`](crate::unwrap_time).
    pub time_100us: u16,
    mask: &'a [u8],
    body: &'a [u8],
    layout: Layout<'a>,
}

impl<'a> Readings<'a> {
    fn parse(payload: &'a [u8], sequence: u8, layout: &Layout<'a>) -> Result<Self, MessageError> {
        let sensors = layout.sensor_count();
        let header_len = READINGS_HEADER_LEN + layout.mask_len();
        let short = MessageError::Length { expected: header_len, found: payload.len() };
        let (header, body) = payload.split_at_checked(header_len).ok_or(short)?;
        let &[_, _, low, high, ref mask @ ..] = header else { return Err(short) };
        if let Some(sensor) = (sensors..mask.len() * 8).find(|&bit| is_set(mask, bit)) {
            return Err(MessageError::Mask { sensors, found: sensor });
        }
        let time_100us = u16::from_le_bytes([low, high]);
        let readings = Self { sequence, time_100us, mask, body, layout: *layout };
        let expected =
            header_len + readings.fresh().map(|(_, sensor)| layout.entry_len(sensor)).sum::<usize>();
        if expected != payload.len() {
            return Err(MessageError::Length { expected, found: payload.len() });
        }
        Ok(readings)
    }

    /// Whether the frame holds a new sample of this sensor: its readability state.
    pub fn is_fresh(&self, sensor: usize) -> bool {
        is_set(self.mask, sensor)
    }

    /// The sensors in this frame, in the order of the layout.
    pub fn entries(&self) -> Entries<'a> {
        Entries {
            sensors: self.layout.sensors(),
            sensor: 0,
            mask: self.mask,
            body: self.body,
            ages: self.layout.ages,
        }
    }

    /// The sensors in this frame with their components' encodings.
    fn fresh(&self) -> impl Iterator<Item = (usize, &'a [Encoding])> {
        let mask = self.mask;
        self.layout.sensors().enumerate().filter(move |&(sensor, _)| is_set(mask, sensor))
    }
}

/// One sensor's part of a readings message.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<'a> {
    /// The index of the sensor in the layout.
    pub sensor: usize,
    /// The age of the sample at the frame's time, in units of 100 µs; 255 means that or longer. `None` if the layout
    /// has no ages.
    pub age_100us: Option<u8>,
    /// The components of the entry. Those sent as `Float64` may be NaN or infinite.
    pub values: Values<'a>,
}

/// Iterates over the sensors in a readings message; see [`Readings::entries`].
#[derive(Clone, Debug)]
pub struct Entries<'a> {
    sensors: Sensors<'a>,
    /// The sensor that comes next out of `sensors`.
    sensor: usize,
    mask: &'a [u8],
    body: &'a [u8],
    ages: bool,
}

impl<'a> Iterator for Entries<'a> {
    type Item = Entry<'a>;

    fn next(&mut self) -> Option<Entry<'a>> {
        loop {
            let encodings = self.sensors.next()?;
            let sensor = self.sensor;
            self.sensor += 1;
            if is_set(self.mask, sensor) {
                let age_100us = if self.ages { Some(*self.body.split_off_first()?) } else { None };
                let bytes = self.body.split_off(..total_len(encodings))?;
                return Some(Entry { sensor, age_100us, values: Values::new(encodings, bytes) });
            }
        }
    }
}

/// Motor signals, all finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Command<'a> {
    /// The number of the brain's frame; wraps after 255.
    pub sequence: u8,
    values: Values<'a>,
}

impl<'a> Command<'a> {
    fn parse(body: &'a [u8], sequence: u8, layout: &Layout<'a>) -> Result<Self, MessageError> {
        let (expected, found) = (layout.command_len(), COMMAND_HEADER_LEN + body.len());
        if expected != found {
            return Err(MessageError::Length { expected, found });
        }
        let values = Values::new(layout.motors, body);
        match values.clone().position(|value| !value.is_finite()) {
            Some(index) => Err(MessageError::NotFinite { index }),
            None => Ok(Self { sequence, values }),
        }
    }

    /// The signals, in the order of the layout's motors.
    pub fn values(&self) -> Values<'a> {
        self.values.clone()
    }
}

/// A reason why a payload is invalid under a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum MessageError {
    /// Another version of the protocol.
    #[error("version {found} of the protocol, but this is version {expected}")]
    Version {
        /// The version spoken here.
        expected: u8,
        /// The version of the message.
        found: u8,
    },
    /// No message of this version begins like this.
    #[error("there is no message of kind {found:#04x}")]
    Kind {
        /// The first byte.
        found: u8,
    },
    /// Too few or too many bytes.
    #[error("{found} bytes, but the layout makes it {expected}")]
    Length {
        /// Bytes that the layout and the message's own mask make it; or, of a message that ends before the mask
        /// does, bytes up to the end of the mask.
        expected: usize,
        /// Bytes in the payload.
        found: usize,
    },
    /// The mask speaks of a sensor that does not exist.
    #[error("readings of sensor {found}, but there are only {sensors}, counted from 0")]
    Mask {
        /// Sensors in the layout.
        sensors: usize,
        /// The first sensor that does not exist.
        found: usize,
    },
    /// A motor signal is NaN or infinite.
    #[error("motor signal {index} is not finite")]
    NotFinite {
        /// The index of the motor, counted from 0.
        index: usize,
    },
}

/// One sensor's new sample, to be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// The age of the sample at the frame's time, in units of 100 µs; see [`age_100us`](crate::age_100us). Not sent
    /// if the layout has no ages.
    pub age_100us: u8,
    /// One value for each component of the sensor.
    pub values: &'a [f64],
}

/// Writes a readings message to the front of `out` and returns its length. `fresh` is asked once for each sensor of
/// the layout, in order, for its sample if that was in no frame before.
///
/// # Errors
/// If a sample has not as many values as its sensor has components, or `out` is too short; one of
/// [`Layout::readings_len_max`] bytes is not.
pub fn write_readings<'s>(
    layout: &Layout<'_>,
    sequence: u8,
    time_100us: u16,
    mut fresh: impl FnMut(usize) -> Option<Sample<'s>>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let room = out.len();
    let no_room = || NoRoom { needed: layout.readings_len_max(), room };
    let [low, high] = time_100us.to_le_bytes();
    let (header, mut rest) = out.split_first_chunk_mut::<READINGS_HEADER_LEN>().ok_or_else(no_room)?;
    *header = [READINGS, sequence, low, high];
    let mask = rest.split_off_mut(..layout.mask_len()).ok_or_else(no_room)?;
    mask.fill(0);
    let mut len = header.len() + mask.len();
    for (sensor, encodings) in layout.sensors().enumerate() {
        let Some(sample) = fresh(sensor) else { continue };
        if let Some(byte) = mask.get_mut(sensor / 8) {
            *byte |= 1 << (sensor % 8);
        }
        let entry = rest.split_off_mut(..layout.entry_len(encodings)).ok_or_else(no_room)?;
        len += entry.len();
        let (age, values) = entry.split_at_mut(usize::from(layout.ages));
        age.fill(sample.age_100us);
        write_values(encodings, sample.values.iter().copied(), values)?;
    }
    Ok(len)
}

/// Writes a command message to the front of `out` and returns its length.
///
/// # Errors
/// If there are not as many values as motors, or `out` is shorter than [`Layout::command_len`].
pub fn write_command(
    layout: &Layout<'_>,
    sequence: u8,
    values: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let no_room = NoRoom { needed: layout.command_len(), room: out.len() };
    if no_room.needed > no_room.room {
        return Err(no_room.into());
    }
    let (header, body) = out.split_first_chunk_mut().ok_or(no_room)?;
    *header = [COMMAND, sequence];
    Ok(header.len() + write_values(layout.motors, values, body)?)
}

/// Reads a message that came to the laptop at this instant, and gives its readings to `sink`.
pub(crate) fn read(layout: &Layout<'_>, payload: &[u8], at_ns: u64, sink: &mut impl Sink) -> Notice {
    let Ok(Message::Readings(message)) = Message::parse(payload, layout) else { return Notice::Nonsense };
    let closed_ns = clock::unwrap_time(message.time_100us, at_ns);
    for entry in message.entries() {
        // The largest age on the wire stands for any from there on, so it is no measurement.
        let age = entry.age_100us.filter(|&age| age < u8::MAX);
        let age_ns = age.map(|age| u64::from(age) * clock::UNIT_NS);
        let sampled_at_ns = age_ns.map(|age_ns| closed_ns.saturating_sub(age_ns));
        sink.take(entry.sensor, Some(Stamp { sequence: message.sequence, sampled_at_ns }), entry.values);
    }
    Notice::Readings
}

/// The payload of a poll message.
pub const fn poll(sequence: u8) -> [u8; POLL_LEN] {
    [POLL, sequence]
}

fn is_set(mask: &[u8], bit: usize) -> bool {
    mask.get(bit / 8).is_some_and(|byte| byte >> (bit % 8) & 1 == 1)
}

/// Bytes of a poll message.
pub const POLL_LEN: usize = 2;

const VERSION: u8 = 1;
const READINGS: u8 = VERSION << 4 | 1;
const COMMAND: u8 = VERSION << 4 | 2;
const POLL: u8 = VERSION << 4 | 3;

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;
    use crate::frame::MAX_PAYLOAD;

    /// A layout's data, owned, with values to send.
    #[derive(Clone, Debug)]
    struct Owner {
        components: Vec<Encoding>,
        counts: Vec<u8>,
        ages: bool,
        /// Per sensor: its age and values, if it is fresh.
        samples: Vec<Option<(u8, Vec<f64>)>>,
    }

    impl Owner {
        fn layout(&self) -> Layout<'_> {
            let Self { components, counts, ages, .. } = self;
            Layout { components, counts, motors: components, ages: *ages }
        }

        fn write(&self, sequence: u8, time_100us: u16) -> Vec<u8> {
            let mut out = vec![0xaa; MAX_PAYLOAD];
            let fresh = |sensor: usize| {
                self.samples[sensor].as_ref().map(|(age, values)| Sample { age_100us: *age, values })
            };
            let len = write_readings(&self.layout(), sequence, time_100us, fresh, &mut out).unwrap();
            out.truncate(len);
            out
        }

        /// The samples as they should arrive.
        fn quantised(&self) -> Vec<(usize, Option<u8>, Vec<f64>)> {
            let sensors = self.layout().sensors().collect::<Vec<_>>();
            let fresh = self.samples.iter().enumerate().filter_map(|(i, sample)| Some((i, sample.as_ref()?)));
            fresh
                .map(|(i, (age, values))| {
                    let values = sensors[i].iter().zip(values).map(|(e, &value)| e.quantise(value));
                    (i, self.ages.then_some(*age), values.collect())
                })
                .collect()
        }
    }

    fn encoding() -> impl Strategy<Value = Encoding> {
        prop_oneof![
            Just(Encoding::Float64),
            (1..=32u8).prop_map(|bits| Encoding::Level { bits, min: -3.0, max: 7.0 }),
            (2..=32u8).prop_map(|bits| Encoding::Signed { bits, limit: 2.0 }),
            (8..=32u8).prop_map(|bits| Encoding::Counter { bits }),
        ]
    }

    fn owner() -> impl Strategy<Value = Owner> {
        let sensor = vec((encoding(), -10.0..10.0), 0..4);
        (vec((sensor, any::<u8>(), any::<bool>()), 0..12), any::<bool>()).prop_map(|(sensors, ages)| Owner {
            components: sensors.iter().flat_map(|(parts, ..)| parts.iter().map(|part| part.0)).collect(),
            counts: sensors.iter().map(|(parts, ..)| parts.len() as u8).collect(),
            ages,
            samples: sensors
                .iter()
                .map(|(parts, age, fresh)| fresh.then(|| (*age, parts.iter().map(|part| part.1).collect())))
                .collect(),
        })
    }

    proptest! {
        #[test]
        fn readings_arrive_as_they_were_sent(owner in owner(), sequence: u8, time_100us: u16) {
            let payload = owner.write(sequence, time_100us);
            let layout = owner.layout();
            prop_assert_eq!(layout.check(), Ok(()));
            prop_assert!(payload.len() <= layout.readings_len_max());
            let Ok(Message::Readings(readings)) = Message::parse(&payload, &layout) else {
                panic!("not readings")
            };
            prop_assert_eq!((readings.sequence, readings.time_100us), (sequence, time_100us));
            let arrived: Vec<(_, _, Vec<f64>)> =
                readings.entries().map(|entry| (entry.sensor, entry.age_100us, entry.values.collect())).collect();
            prop_assert_eq!(arrived, owner.quantised());
            for (sensor, sample) in owner.samples.iter().enumerate() {
                prop_assert_eq!(readings.is_fresh(sensor), sample.is_some());
            }
        }

        #[test]
        fn a_command_arrives_as_it_was_sent(
            motors in vec((encoding(), -10.0..10.0), 0..20), sequence: u8,
        ) {
            let (encodings, values): (Vec<_>, Vec<f64>) = motors.into_iter().unzip();
            let layout = Layout { components: &[], counts: &[], motors: &encodings, ages: false };
            let mut payload = vec![0; layout.command_len()];
            prop_assert_eq!(write_command(&layout, sequence, values.clone(), &mut payload), Ok(payload.len()));
            let Ok(Message::Command(command)) = Message::parse(&payload, &layout) else {
                panic!("not a command")
            };
            prop_assert_eq!(command.sequence, sequence);
            prop_assert!(command.values().eq(encodings.iter().zip(values).map(|(e, value)| e.quantise(value))));
        }

        #[test]
        fn a_poll_arrives_as_it_was_sent(owner in owner(), sequence: u8) {
            let poll = poll(sequence);
            prop_assert_eq!(Message::parse(&poll, &owner.layout()), Ok(Message::Poll { sequence }));
        }

        #[test]
        fn a_message_cut_short_or_gone_on_with_is_refused(owner in owner(), extra in 1..20usize) {
            let mut payload = owner.write(0, 0);
            for len in 0..payload.len() {
                prop_assert!(Message::parse(&payload[..len], &owner.layout()).is_err());
            }
            let expected = payload.len();
            payload.extend(vec![0; extra]);
            let error = MessageError::Length { expected, found: expected + extra };
            prop_assert_eq!(Message::parse(&payload, &owner.layout()), Err(error));
        }

        #[test]
        fn any_bytes_under_any_layout_do_no_harm(
            owner in owner(),
            counts in vec(any::<u8>(), 0..40),
            mut payload in vec(any::<u8>(), 0..100),
            kind in 0x10..0x15u8,
        ) {
            if let Some(first) = payload.first_mut() {
                *first = kind;
            }
            for layout in [owner.layout(), Layout { counts: &counts, ..owner.layout() }] {
                match Message::parse(&payload, &layout) {
                    Ok(Message::Readings(readings)) => {
                        prop_assert_eq!(readings.entries().count(), readings.fresh().count());
                    }
                    Ok(Message::Command(command)) => {
                        prop_assert_eq!(command.values().count(), layout.motors.len());
                    }
                    _ => {}
                }
            }
        }

        #[test]
        fn a_short_buffer_is_refused(owner in owner(), room in 0..200usize) {
            let needed = owner.write(0, 0).len();
            let fresh = |sensor: usize| {
                owner.samples[sensor].as_ref().map(|(age, values)| Sample { age_100us: *age, values })
            };
            let written = write_readings(&owner.layout(), 0, 0, fresh, &mut vec![0; room]);
            prop_assert_eq!(written.is_ok(), room >= needed, "{:?}", written);
        }
    }

    const WHEELS: Layout<'_> = Layout {
        components: &[Encoding::Counter { bits: 16 }],
        counts: &[1],
        motors: &[Encoding::Float64; 2],
        ages: true,
    };

    #[test]
    fn a_signal_that_is_not_finite_is_refused() {
        let mut payload = [0; 18];
        write_command(&WHEELS, 0, [1.0, f64::NAN], &mut payload).unwrap();
        assert_eq!(Message::parse(&payload, &WHEELS), Err(MessageError::NotFinite { index: 1 }));
    }

    #[test]
    fn errors_carry_what_disagrees() {
        let parse = |payload: &'static [u8]| Message::parse(payload, &WHEELS).unwrap_err();
        assert_eq!(parse(&[]), MessageError::Length { expected: 2, found: 0 });
        assert_eq!(parse(&[0x23, 0]), MessageError::Version { expected: 1, found: 2 });
        assert_eq!(parse(&[0x14, 0]), MessageError::Kind { found: 0x14 });
        assert_eq!(parse(&[0x13, 0, 0]), MessageError::Length { expected: 2, found: 3 });
        assert_eq!(parse(&[0x12, 0, 0]), MessageError::Length { expected: 18, found: 3 });
        assert_eq!(parse(&[0x11, 0, 0, 0]), MessageError::Length { expected: 5, found: 4 });
        assert_eq!(parse(&[0x11, 0, 0, 0, 1]), MessageError::Length { expected: 8, found: 5 });
        assert_eq!(parse(&[0x11, 0, 0, 0, 4]), MessageError::Mask { sensors: 1, found: 2 });
    }

    #[test]
    fn a_sample_with_too_few_values_is_refused() {
        let fresh = |_| Some(Sample { age_100us: 0, values: &[] });
        let written = write_readings(&WHEELS, 0, 0, fresh, &mut [0; 99]);
        assert_eq!(written, Err(WriteError::Count { expected: 1, found: 0 }));
    }
}
