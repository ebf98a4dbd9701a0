//! A device's own cable to the laptop, past the microcontroller (Fig. 1.18): what a laser range finder, a camera
//! or a satellite receiver says on it, byte by byte.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::{line_image, nmea, port, scip};
use serde::{Deserialize, Serialize};

use crate::link::{Direction, Line, Link, Message};
use crate::port_use::PortUse;
use crate::sensor::dialogue::{self, Dialogue};
use crate::sensor::sky::{Dilution, SKY};
use crate::sensor::{Device, Sensor};
use crate::time::SimTime;

/// The model of a device's own cable.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// The cable.
    pub link: Link,
    /// The protocol.
    pub format: Format,
    /// Whether the device answers, and speaks only when it is asked; one that is missing speaks by itself, and hears nothing.
    pub dialogue: Option<Box<Dialogue>>,
}

/// The form of a device's messages.
#[derive(Clone, Debug, PartialEq)]
pub enum Format {
    /// A laser's scans in SCIP 2.0.
    Scip(scip::Format),
    /// The images of a camera, or of a line camera.
    LineImage,
    /// A satellite receiver's sentences.
    Nmea {
        /// GGA, GSA and three GSV before the RMC; else the RMC alone.
        full: bool,
    },
}

/// State of a port: its line, and what the laptop has of the message that is under way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct PortState {
    pub(crate) line: Line,
    message: Vec<u8>,
    /// Bytes that arrived since the brain's last step.
    pub(crate) unread: Vec<u8>,
    /// When each of them arrived, for a program that wants to know.
    #[serde(skip)]
    pub(crate) instants: Vec<SimTime>,
    /// As of the [laptop](crate::laptop::Laptop::arrived).
    #[serde(skip)]
    pub(crate) arrived: Vec<u8>,
    sequence: u16,
}

/// The message that a byte completed at the laptop's end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Received {
    Nothing,
    /// A message that made no sense.
    Bad,
    /// An answer of a device, which is no reading: whether it says that readings will come.
    Answer(bool),
    /// A reading: one value a component, and when it was sampled, if the message says so.
    Reading(Vec<f64>, Option<SimTime>),
}

impl PortState {
    /// Of a robot's sensor that has a port.
    pub(crate) fn new(sensor: &Sensor, seed: u64, robot: &str) -> Self {
        let link = sensor.port.as_ref().map_or(&Link::Ideal, |port| &port.link);
        let line = Line::up(link, seed, &[robot, "/", &sensor.name, ":port"]);
        Self {
            line,
            message: Vec::new(),
            unread: Vec::new(),
            instants: Vec::new(),
            arrived: Vec::new(),
            sequence: 0,
        }
    }

    /// The bytes that have arrived have been read.
    pub(crate) fn clear(&mut self) {
        self.unread.clear();
        self.instants.clear();
    }

    /// Whether the cable of this sensor can be so at `now`, on a robot with so many sensors.
    pub(crate) fn is_sound(&self, cable: &Link, now: SimTime, sensors: usize) -> bool {
        self.line.is_sound(cable, (Direction::Up, now), sensors) && self.unread.len() <= UNREAD_MAX
    }

    /// When the next byte arrives at the laptop.
    pub(crate) fn arrival(&self, cable: &Link) -> SimTime {
        self.line.arrival(cable)
    }

    /// Takes that byte, if it has arrived by `now`.
    pub(crate) fn take(&mut self, cable: &Link, now: SimTime) -> Option<(SimTime, u8)> {
        self.line.take(cable, now)
    }

    /// The device sends a measurement, and the answer is when that is on the wire; unless the line is still taken by
    /// an older one: then this one is left out, as real devices do.
    pub(crate) fn send(
        &mut self,
        sensor: &Sensor,
        port: &Port,
        i: usize,
        now: SimTime,
        (values, measured_at, truly_at): (&[f64], SimTime, SimTime),
    ) -> Option<(SimTime, SimTime)> {
        if self.line.waiting(&port.link, now) > 0 {
            return None;
        }
        let bytes = port.format.write(&sensor.device, self.sequence, measured_at, values);
        self.sequence = self.sequence.wrapping_add(1);
        let message = Message { sampled: vec![(i, truly_at)], ..Message::default() };
        Some(self.line.send_message(&port.link, now, &bytes, message))
    }

    /// A byte arrives at the laptop's end.
    pub(crate) fn receive(
        &mut self,
        port: &Port,
        device: &Device,
        (at, byte): (SimTime, u8),
        port_use: PortUse,
    ) -> Received {
        if self.unread.len() >= UNREAD_MAX {
            self.line.counters.overrun_bytes += 1;
            self.message.clear();
            return Received::Nothing;
        }
        match port_use {
            PortUse::Closed => self.unread.push(byte),
            PortUse::Open => {
                self.unread.push(byte);
                self.instants.push(at);
            }
            PortUse::Simulated => self.arrived.push(byte),
        }
        self.message.push(byte);
        let mut heard = port.hear(device, &mut self.message, at);
        if self.message.len() > port.longest(device) {
            self.message.clear();
            heard = Received::Bad;
        }
        match heard {
            Received::Nothing | Received::Answer(_) => {}
            Received::Bad => self.line.counters.bad_frames += 1,
            Received::Reading(..) => self.line.counters.messages += 1,
        }
        heard
    }
}

/// Bytes that a brain may leave unread; more are lost.
const UNREAD_MAX: usize = 4 << 20;

impl Port {
    /// More bytes than these without an end are no message: the rest of a broken one, and a whole one.
    #[inline]
    pub(crate) fn longest(&self, device: &Device) -> usize {
        match &self.dialogue {
            Some(dialogue) => 2 * dialogue::longest(&dialogue.description),
            None => self.format.longest(device),
        }
    }

    /// Takes a message out of what has come so far, if one ends there. What a device answers is no bad message, also if
    /// it is a scan that is none of the sensor's readings: another program has asked for it.
    #[inline]
    fn hear(&self, device: &Device, received: &mut Vec<u8>, at: SimTime) -> Received {
        // Of a dialogue only the end of a message needs more than this.
        if self.dialogue.is_some() && received.ends_with(b"\n\n") {
            return self.hear_answer(device, received, at);
        }
        self.format.hear(device, received, at)
    }

    /// A whole message of a device that answers has come.
    #[cold]
    #[inline(never)]
    fn hear_answer(&self, device: &Device, received: &mut Vec<u8>, at: SimTime) -> Received {
        let is_answer = match scip::status(received) {
            Some(status) if status == *b"99" => dialogue::is_foreign(&self.format, received),
            status => status.is_some(),
        };
        let is_start = is_answer && dialogue::is_start(received);
        match self.format.hear(device, received, at) {
            Received::Bad if is_answer => Received::Answer(is_start),
            heard @ (Received::Nothing | Received::Bad | Received::Answer(_) | Received::Reading(..)) => {
                heard
            }
        }
    }
}

impl Format {
    /// Bytes of one message.
    #[inline]
    pub fn message_len(&self, device: &Device) -> usize {
        match (self, device) {
            (Self::Scip(format), _) => format.message_len(),
            (Self::LineImage, Device::LineCamera(camera)) => {
                line_image::encoded_len(camera.columns() as u16, camera.rows)
            }
            (Self::LineImage, Device::Camera(camera)) => line_image::encoded_len(camera.columns, camera.rows),
            (Self::LineImage, _) => 0,
            (Self::Nmea { full }, _) => nmea_len(*full, device.values()),
        }
    }

    /// More bytes than these without an end are no message: the rest of a broken one, and a whole one.
    fn longest(&self, device: &Device) -> usize {
        match self {
            Self::Scip(_) | Self::LineImage => 2 * self.message_len(device),
            Self::Nmea { .. } if device.values() > port::VALUES_OF_RMC => SENTENCES * nmea::MAX_SENTENCE,
            Self::Nmea { .. } => nmea::MAX_SENTENCE,
        }
    }

    fn write(&self, device: &Device, sequence: u16, at: SimTime, values: &[f64]) -> Vec<u8> {
        match (self, device) {
            (Self::Scip(format), _) => {
                let mut bytes = vec![0; format.message_len()];
                let millimetres = values.iter().map(|&d| if d < 0.0 { 0 } else { (d * 1e3 + 0.5) as u32 });
                let time_ms = (at.as_ns() / 1_000_000) as u32;
                let n = scip::encode(format, time_ms, millimetres, &mut bytes).expect(FITS);
                bytes.truncate(n);
                bytes
            }
            (Self::LineImage, Device::LineCamera(camera)) => {
                let n = camera.columns();
                let mut bytes = vec![0; self.message_len(device)];
                let level = |channel: usize, i: usize| (values[channel * n + i] * 255.0 + 0.5) as u8;
                let columns = (0..n).map(|i| line_image::Column {
                    rgb: [level(0, i), level(1, i), level(2, i)],
                    depth_mm: depth_mm(values[3 * n + i]),
                });
                let written = line_image::encode(sequence, columns, camera.rows, &mut bytes).expect(FITS);
                bytes.truncate(written);
                bytes
            }
            (Self::LineImage, Device::Camera(camera)) => {
                let mut bytes = vec![0; self.message_len(device)];
                let level = |i: usize| (values[i] * 255.0 + 0.5) as u8;
                let n = camera.pixels();
                let pixels = (0..n).map(|i| [level(i), level(n + i), level(2 * n + i)]);
                let size = (camera.columns, camera.rows);
                let written = line_image::encode_pixels(sequence, size, pixels, &mut bytes).expect(FITS);
                bytes.truncate(written);
                bytes
            }
            (Self::Nmea { full }, _) => gps_message(*full, at, values),
            (Self::LineImage, _) => Vec::new(),
        }
    }

    /// Takes a message out of what has come so far, if one ends there. It is asked for each byte.
    #[inline(always)]
    fn hear(&self, device: &Device, received: &mut Vec<u8>, at: SimTime) -> Received {
        let format = match self {
            Self::Scip(_) => port::Format::Scip,
            Self::LineImage => port::Format::LineImage { message_len: self.message_len(device) },
            Self::Nmea { .. } => port::Format::nmea(device.values()),
        };
        let skip = match format.find(received) {
            port::Found::Message { skip } => skip,
            port::Found::Beginning { skip } => {
                received.drain(..skip);
                return Received::Nothing;
            }
            port::Found::Junk => {
                received.clear();
                return Received::Bad;
            }
        };
        let message = core::mem::take(received);
        let mut values = vec![0.0; device.values()];
        match format.read(&message[skip..], at.as_ns(), &mut values) {
            Ok(port::Message::Reading { sampled_at_ns }) => {
                Received::Reading(values, sampled_at_ns.map(SimTime::from_ns))
            }
            Ok(port::Message::Other) => Received::Nothing,
            Err(_) => Received::Bad,
        }
    }
}

/// 0 stands for nothing within range, so what touches the camera is a millimetre away.
fn depth_mm(depth_m: f64) -> u16 {
    if depth_m < 0.0 { 0 } else { (depth_m * 1e3 + 0.5).clamp(1.0, 65_535.0) as u16 }
}

/// The reason why writing cannot fail.
const FITS: &str = "the buffer is as long as the message";

const DAY_MS: u64 = 86_400_000;

/// A GGA, a GSA, three GSV and an RMC.
const SENTENCES: usize = 6;

/// Bytes of a receiver's message with so many values.
fn nmea_len(full: bool, values: usize) -> usize {
    let usual = [57.7, 11.97, 1.0, 0.0, 0.0, 100.0, 12.0, 1.0];
    gps_message(full, SimTime::from_ns(0), usual.get(..values).unwrap_or_default()).len()
}

/// The message of a receiver on one fix. Without values of the sky there are all the satellites in it, and an HDOP of 1.
fn gps_message(full: bool, at: SimTime, values: &[f64]) -> Vec<u8> {
    let Some((&[latitude_deg, longitude_deg, fix, speed_m_s, course_rad], of_sky)) =
        values.split_first_chunk()
    else {
        return Vec::new();
    };
    let (altitude_m, seen, hdop, pdop_vdop) = match *of_sky {
        [altitude_m, seen, hdop] => {
            let dilution = Dilution::of(seen as usize);
            let pdop_vdop = (dilution.of_position(), dilution.vertical);
            (altitude_m, (seen as usize).min(SKY.len()), hdop, Some(pdop_vdop))
        }
        _ => (0.0, SKY.len(), 1.0, None),
    };
    let hidden = SKY.len() - seen;
    let fix = nmea::Fix {
        time_utc_ms: (at.as_ns() / 1_000_000 % DAY_MS) as u32,
        date: nmea::date_after((at.as_ns() / 1_000_000 / DAY_MS) as u32),
        valid: fix > 0.5,
        latitude_deg,
        longitude_deg,
        speed_m_s,
        course_deg: (core::f64::consts::FRAC_PI_2 - course_rad).to_degrees(),
        altitude_m,
        satellites: seen as u8,
        hdop,
        pdop_vdop,
    };
    sentences(&fix, full.then_some(hidden))
}

/// The RMC of a fix, and before it, of so many hidden satellites, the other sentences.
fn sentences(fix: &nmea::Fix, hidden: Option<usize>) -> Vec<u8> {
    let mut bytes = vec![0; SENTENCES * nmea::MAX_SENTENCE];
    let mut n = 0;
    if let Some(hidden) = hidden {
        let mut in_view = SKY;
        in_view[..hidden].iter_mut().for_each(|satellite| satellite.snr_db = 0);
        n += nmea::write_gga(fix, &mut bytes[n..]).expect(FITS);
        n += nmea::write_gsa(fix, &in_view[hidden..], &mut bytes[n..]).expect(FITS);
        n += nmea::write_gsv(&in_view, &mut bytes[n..]).expect(FITS);
    }
    n += nmea::write_rmc(fix, &mut bytes[n..]).expect(FITS);
    bytes.truncate(n);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receivers_sentences_take_most_of_each_second_at_4800_baud() {
        let full = nmea_len(true, 5);
        assert!((380..=480).contains(&full), "{full}");
        let alone = nmea_len(false, 5);
        assert!((60..=82).contains(&alone), "{alone}");
        // The altitude, and two more dilutions.
        assert_eq!(nmea_len(true, 8), full + 2 + 8);
    }

    #[test]
    fn the_date_goes_on_at_midnight() {
        let rmc =
            |s: u64| gps_message(false, SimTime::from_ns(s * 1_000_000_000), &[57.7, 11.97, 1.0, 0.0, 0.0]);
        let has = |bytes: Vec<u8>, text: &[u8]| bytes.windows(text.len()).any(|window| window == text);
        assert!(has(rmc(86_399), b",235959.000,") && has(rmc(86_399), b",010116,"));
        assert!(has(rmc(86_400), b",000000.000,") && has(rmc(86_400), b",020116,"));
    }

    #[test]
    fn a_fix_survives_its_sentence_to_less_than_a_fifth_of_a_metre() {
        let bytes = gps_message(false, SimTime::from_ns(1_000_000_000), &[57.7, 11.97, 1.0, 0.5, 0.25]);
        let mut values = [0.0; 5];
        port::Format::nmea(5).read(&bytes, 1_100_000_000, &mut values).unwrap();
        let metres = (values[0] - 57.7).hypot(values[1] - 11.97) * 111_195.0;
        assert!(metres < 0.2, "{metres}");
        assert_eq!(values[2], 1.0);
        assert!((values[3] - 0.5).abs() < 0.005 && (values[4] - 0.25).abs() < 1e-3, "{values:?}");
    }
}
