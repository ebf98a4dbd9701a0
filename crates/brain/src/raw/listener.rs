//! The laptop's end of a sensor's own cable: the output of a laser, a line camera or a satellite receiver, byte by
//! byte.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::port::{Format, Found, Message};

use crate::body::{PortFormat, Sensor};
use crate::turn::Reading;

/// Listens to one port.
#[derive(Clone, Debug)]
pub(crate) struct Listener {
    format: Format,
    /// Values of a reading.
    values: usize,
    /// The bytes of the message that is under way.
    message: Vec<u8>,
    /// Readings so far.
    sequence: u8,
}

/// The content of a message: its values, and the instant of their measurement, in nanoseconds.
type Said = (Vec<f64>, Option<u64>);

/// Bytes without an end of a message after which all is thrown away.
const TOO_LONG: usize = 4 << 20;

impl Listener {
    /// `None` if the sensor has no port, or one of a format that is not known here.
    pub(crate) fn new(sensor: &Sensor) -> Option<Self> {
        let port = sensor.port.as_ref()?;
        let format = match port.format {
            PortFormat::Scip2 => Format::Scip,
            PortFormat::LineImage => {
                Format::LineImage { message_len: usize::try_from(port.message_bytes).ok()? }
            }
            PortFormat::Nmea => Format::nmea(sensor.values()),
            PortFormat::Unknown => return None,
        };
        Some(Self { format, values: sensor.values(), message: Vec::new(), sequence: 0 })
    }

    /// The last reading of which the end is among these bytes, if any. Invalid messages are lost.
    pub(crate) fn hear(&mut self, bytes: &[u8], at_ns: u64) -> Option<Reading> {
        let mut last = None;
        for &byte in bytes {
            self.message.push(byte);
            if let Some((values, sampled_at_ns)) = self.end(at_ns) {
                self.sequence = self.sequence.wrapping_add(1);
                let sequence = self.sequence.into();
                last = Some(Reading { values, sampled_at_ns, sequence, readable: true });
            }
            if self.message.len() > TOO_LONG {
                self.message.clear();
            }
        }
        last
    }

    /// The content of the message that ends with the last byte.
    fn end(&mut self, at_ns: u64) -> Option<Said> {
        let skip = match self.format.find(&self.message) {
            Found::Message { skip } => skip,
            Found::Beginning { skip } => {
                self.message.drain(..skip);
                return None;
            }
            Found::Junk => {
                self.message.clear();
                return None;
            }
        };
        let message = core::mem::take(&mut self.message);
        let mut values = vec![0.0; self.values];
        match self.format.read(&message[skip..], at_ns, &mut values) {
            Ok(Message::Reading { sampled_at_ns }) => Some((values, sampled_at_ns)),
            Ok(Message::Other) | Err(_) => None,
        }
    }
}
