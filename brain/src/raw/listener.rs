//! The laptop's end of a sensor's own cable: what a laser, a line camera or a satellite receiver says, byte by byte.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI, TAU};

use baudbot_wire::{line_image, nmea, scip};

use crate::body::{PortFormat, Sensor};
use crate::turn::Reading;

/// Listens to one port.
#[derive(Clone, Debug)]
pub(crate) struct Listener {
    format: Format,
    /// Values of a reading.
    values: usize,
    /// What has come of the message that is under way.
    message: Vec<u8>,
    /// Readings so far.
    sequence: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Scip,
    LineImage {
        /// Bytes of a message.
        length: usize,
    },
    Nmea,
}

const DAY_MS: u64 = 86_400_000;

/// What a message says: its values, and when they were measured, in nanoseconds.
type Said = (Vec<f64>, Option<u64>);

/// The reading of a ray that met nothing.
const NOTHING: f64 = -1.0;

/// Bytes without an end of a message after which all is thrown away.
const TOO_LONG: usize = 4 << 20;

impl Listener {
    /// `None` if the sensor has no port, or one of a format that is not known here.
    pub(crate) fn new(sensor: &Sensor) -> Option<Self> {
        let port = sensor.port.as_ref()?;
        let format = match port.format {
            PortFormat::Scip2 => Format::Scip,
            PortFormat::LineImage => Format::LineImage { length: usize::try_from(port.message_bytes).ok()? },
            PortFormat::Nmea => Format::Nmea,
            PortFormat::Other(_) => return None,
        };
        Some(Self { format, values: sensor.values(), message: Vec::new(), sequence: 0 })
    }

    /// The last reading of which the end is among these bytes, if any. Messages that make no sense are lost.
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

    /// What the message says that ends with the last byte.
    fn end(&mut self, at_ns: u64) -> Option<Said> {
        let ends = match self.format {
            Format::Scip => self.message.ends_with(b"\n\n"),
            Format::LineImage { length } => self.image_ends(length),
            Format::Nmea => self.message.ends_with(b"\n"),
        };
        if !ends {
            return None;
        }
        let message = core::mem::take(&mut self.message);
        let said = match self.format {
            Format::Scip => scan(&message, at_ns)?,
            Format::LineImage { .. } => image(&message)?,
            Format::Nmea => fix(&message, at_ns)?,
        };
        (said.0.len() == self.values).then_some(said)
    }

    /// The header says how long an image is; bytes that begin none are thrown away.
    fn image_ends(&mut self, length: usize) -> bool {
        while !self.message.is_empty() {
            match line_image::message_len(&self.message) {
                Ok(None) => return false,
                Ok(Some(found)) if found == length => return self.message.len() >= length,
                Ok(Some(_)) => self.message.drain(..1),
                Err(line_image::ParseError::Sync { skip }) => self.message.drain(..skip),
                Err(_) => self.message.drain(..1),
            };
        }
        false
    }
}

/// A laser's scan.
fn scan(message: &[u8], at_ns: u64) -> Option<Said> {
    let scan = scip::parse(message).ok()?;
    let metres = |range: Option<u32>| range.map_or(NOTHING, |mm| f64::from(mm) * 1e-3);
    // The clock of the message has 24 bits: of the instants that it may mean, the last.
    let now_ms = at_ns / 1_000_000;
    let age_ms = now_ms.wrapping_sub(scan.time_ms.into()) & 0xff_ffff;
    Some((scan.ranges_mm().map(metres).collect(), Some(now_ms.saturating_sub(age_ms) * 1_000_000)))
}

/// A line camera's image: red, green, blue and depth, each of all columns.
fn image(message: &[u8]) -> Option<Said> {
    let image = line_image::parse(message).ok()?;
    let mut values = Vec::with_capacity(4 * image.columns().len());
    for channel in 0..3 {
        values.extend(image.columns().map(|column| f64::from(column.rgb[channel]) / 255.0));
    }
    let depth = |mm: u16| if mm == 0 { NOTHING } else { f64::from(mm) * 1e-3 };
    values.extend(image.columns().map(|column| depth(column.depth_mm)));
    Some((values, None))
}

/// A satellite receiver's fix. The sentence with everything that a reading needs is the RMC, which comes last.
fn fix(line: &[u8], at_ns: u64) -> Option<Said> {
    let Ok(nmea::Sentence::Rmc(rmc)) = nmea::parse(line) else { return None };
    let (latitude, longitude) = rmc.position.map_or((0.0, 0.0), |p| (p.latitude_deg, p.longitude_deg));
    let fix = f64::from(u8::from(rmc.position.is_some()));
    // From clockwise of north, less than a turn, to counter-clockwise of east, in (-pi, pi].
    let course_rad = rmc.course_deg.map_or(0.0, |course_deg| {
        let course_rad = FRAC_PI_2 - course_deg.to_radians();
        if course_rad <= -PI { course_rad + TAU } else { course_rad }
    });
    // The time of day: of the instants that it may mean, the last.
    let now_ms = at_ns / 1_000_000;
    let age_ms = |ms: u32| (now_ms % DAY_MS + DAY_MS).saturating_sub(ms.into()) % DAY_MS;
    let measured_at_ns = rmc.time_utc_ms.map(|ms| now_ms.saturating_sub(age_ms(ms)) * 1_000_000);
    Some((vec![latitude, longitude, fix, rmc.speed_m_s.unwrap_or(0.0), course_rad], measured_at_ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_fix_nothing_of_it_is_made_up() {
        let mut line = [0; nmea::MAX_SENTENCE];
        let nothing = nmea::Fix {
            time_utc_ms: 1000,
            date: (1, 1, 16),
            valid: false,
            latitude_deg: 57.7,
            longitude_deg: 11.97,
            speed_m_s: 0.0,
            course_deg: 90.0,
            altitude_m: 0.0,
            satellites: 0,
            hdop: 1.0,
        };
        let n = nmea::write_rmc(&nothing, &mut line).unwrap();
        assert_eq!(fix(&line[..n], 1_500_000_000), Some((vec![0.0; 5], Some(1_000_000_000))));
    }
}
