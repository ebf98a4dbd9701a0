//! Readings of sensors that have a cable of their own: the messages of [`scip`], [`line_image`] and [`nmea`] as values.
//!
//! A receiver appends each byte to a buffer, asks [`Format::find`] whether a message has ended, and has
//! [`Format::read`] turn that message into values in SI units:
//!
//! | message | values | instant of the sample |
//! |---|---|---|
//! | SCIP scan | a distance a ray, in metres, −1 without a measurement | from the scan's clock |
//! | line image | red, then green, then blue of all columns, each 0 to 1; then depths in metres, −1 for nothing within range; of a camera red, green and blue of all pixels, row by row | not in the message |
//! | NMEA RMC | latitude and longitude in degrees, 1 with a fix or 0, speed in m/s, course in radians counter-clockwise from east | from the time of day |
//! | NMEA GGA … RMC | those of the RMC, then altitude in metres, number of satellites and HDOP of the GGA | from the time of day |

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use thiserror::Error;

use crate::{line_image, nmea, scip};

/// The form of a sensor's messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A laser's scans in SCIP 2.0.
    Scip,
    /// The images of a camera, or of a line camera.
    LineImage {
        /// Bytes of a message: [`line_image::encoded_len`].
        message_len: usize,
    },
    /// A satellite receiver's sentences.
    Nmea {
        /// Whether a reading has altitude, satellites and dilution, which are in the GGA: a message goes to the end of the RMC then. Else each sentence
        /// is a message, and the RMC has everything that a reading needs; others are passed over.
        with_altitude: bool,
    },
}

/// The meaning of the received bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// The beginning of a message, after so many bytes that belong to none.
    Beginning {
        /// Bytes to be thrown away.
        skip: usize,
    },
    /// A whole message, after so many bytes that belong to none.
    Message {
        /// Bytes before the message.
        skip: usize,
    },
    /// No message begins in any of them.
    Junk,
}

/// A reason why a message is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ReadError {
    /// The scan did not arrive whole.
    #[error(transparent)]
    Scip(#[from] scip::ParseError),
    /// The image did not arrive whole.
    #[error(transparent)]
    LineImage(#[from] line_image::ParseError),
    /// The sentence did not arrive whole.
    #[error(transparent)]
    Nmea(#[from] nmea::ParseError),
    /// Another device sends as many values.
    #[error("the message has {found} values, but the sensor has {expected}")]
    Values {
        /// Values that the sensor has.
        expected: usize,
        /// Values of the message.
        found: usize,
    },
}

/// A message that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// A reading.
    Reading {
        /// The instant of the sample in nanoseconds, if the message says it.
        sampled_at_ns: Option<u64>,
    },
    /// A sound message without a reading.
    Other,
}

impl Format {
    /// That of a receiver whose readings have so many values.
    #[must_use]
    pub const fn nmea(values: usize) -> Self {
        Self::Nmea { with_altitude: values > VALUES_OF_RMC }
    }

    /// Finds a message that ends with the last byte. To be called after every byte.
    #[must_use]
    pub fn find(self, received: &[u8]) -> Found {
        let is_whole = match self {
            Self::Scip => received.ends_with(b"\n\n"),
            Self::Nmea { with_altitude } => {
                received.ends_with(b"\n")
                    && (!with_altitude || sentences(received).last().is_some_and(is_rmc))
            }
            Self::LineImage { message_len } => return find_image(received, message_len),
        };
        if is_whole { Found::Message { skip: 0 } } else { Found::Beginning { skip: 0 } }
    }

    /// Reads a whole message that arrived at `now_ns` nanoseconds into the sensor's values. Where a message's clock wraps,
    /// the sample was taken at the last of the instants that it may mean.
    ///
    /// # Errors
    /// If the message is damaged, or is not one of a sensor with so many values. The values are unspecified then.
    pub fn read(self, message: &[u8], now_ns: u64, values: &mut [f64]) -> Result<Message, ReadError> {
        match self {
            Self::Scip => read_scan(message, now_ns, values),
            Self::LineImage { .. } => read_image(message, values),
            Self::Nmea { with_altitude: false } => read_fix(message, now_ns, values),
            Self::Nmea { with_altitude: true } => read_fix_in_space(message, now_ns, values),
        }
    }
}

/// The header says how long an image is.
fn find_image(received: &[u8], message_len: usize) -> Found {
    let mut skip = 0;
    while let Some(rest) = received.get(skip..).filter(|rest| !rest.is_empty()) {
        skip += match line_image::message_len(rest) {
            Ok(None) => return Found::Beginning { skip },
            Ok(Some(found)) if found == message_len && rest.len() < found => {
                return Found::Beginning { skip };
            }
            Ok(Some(found)) if found == message_len => return Found::Message { skip },
            Err(line_image::ParseError::Sync { skip }) => skip,
            Ok(Some(_)) | Err(_) => 1,
        };
    }
    Found::Junk
}

fn read_scan(message: &[u8], now_ns: u64, values: &mut [f64]) -> Result<Message, ReadError> {
    let scan = scip::parse(message)?;
    let ranges_mm = scan.ranges_mm();
    check_count(values, ranges_mm.len())?;
    for (value, range_mm) in values.iter_mut().zip(ranges_mm) {
        *value = range_mm.map_or(NOTHING, |range_mm| f64::from(range_mm) * 1e-3);
    }
    // The clock of a scan has 24 bits.
    let now_ms = now_ns / 1_000_000;
    let age_ms = now_ms.wrapping_sub(scan.time_ms.into()) & 0xff_ffff;
    Ok(Message::Reading { sampled_at_ns: Some(now_ms.saturating_sub(age_ms) * 1_000_000) })
}

fn read_image(message: &[u8], values: &mut [f64]) -> Result<Message, ReadError> {
    let image = line_image::parse(message)?;
    let pixels = usize::from(image.columns) * usize::from(image.rows);
    if values.len() == 3 * pixels {
        let rows = (0..image.rows).filter_map(|row| image.row(row));
        for (i, pixel) in rows.flatten().enumerate() {
            for (value, level) in values.iter_mut().skip(i).step_by(pixels).zip(pixel) {
                *value = f64::from(*level) / 255.0;
            }
        }
        return Ok(Message::Reading { sampled_at_ns: None });
    }
    let columns = image.columns();
    let count = columns.len();
    check_count(values, 4 * count)?;
    for (i, column) in columns.enumerate() {
        let depth_m = f64::from(column.depth_mm) * 1e-3;
        let [red, green, blue] = column.rgb.map(|level| f64::from(level) / 255.0);
        let of_column = [red, green, blue, if column.depth_mm == 0 { NOTHING } else { depth_m }];
        for (value, of_column) in values.iter_mut().skip(i).step_by(count).zip(of_column) {
            *value = of_column;
        }
    }
    Ok(Message::Reading { sampled_at_ns: None })
}

fn read_fix(message: &[u8], now_ns: u64, values: &mut [f64]) -> Result<Message, ReadError> {
    let nmea::Sentence::Rmc(rmc) = nmea::parse(message)? else { return Ok(Message::Other) };
    let (latitude_deg, longitude_deg) =
        rmc.position.map_or((0.0, 0.0), |p| (p.latitude_deg, p.longitude_deg));
    let fix = f64::from(u8::from(rmc.position.is_some()));
    // From clockwise of north, at most a turn, to counter-clockwise of east, in (-pi, pi].
    let course_rad = rmc.course_deg.map_or(0.0, |course_deg| {
        let course_rad = FRAC_PI_2 - course_deg.to_radians();
        if course_rad <= -PI { course_rad + TAU } else { course_rad }
    });
    let of_fix = [latitude_deg, longitude_deg, fix, rmc.speed_m_s.unwrap_or(0.0), course_rad];
    check_count(values, of_fix.len())?;
    values.copy_from_slice(&of_fix);
    let now_ms = now_ns / 1_000_000;
    let age_ms = |time_ms: u32| (now_ms % DAY_MS + DAY_MS).saturating_sub(time_ms.into()) % DAY_MS;
    let sampled_at_ns = rmc.time_utc_ms.map(|time_ms| now_ms.saturating_sub(age_ms(time_ms)) * 1_000_000);
    Ok(Message::Reading { sampled_at_ns })
}

/// The last sentence is the RMC.
fn read_fix_in_space(message: &[u8], now_ns: u64, values: &mut [f64]) -> Result<Message, ReadError> {
    let mut of_gga = None;
    for sentence in sentences(message) {
        if let nmea::Sentence::Gga(gga) = nmea::parse(sentence)? {
            let satellites = f64::from(gga.satellites.unwrap_or(0));
            of_gga = Some([gga.altitude_m.unwrap_or(0.0), satellites, gga.hdop.unwrap_or(0.0)]);
        }
    }
    let of_gga = of_gga.as_ref().map_or(&[][..], |values| &values[..]);
    check_count(values, VALUES_OF_RMC + of_gga.len())?;
    let (of_rmc, of_space) = values.split_at_mut(VALUES_OF_RMC);
    of_space.copy_from_slice(of_gga);
    sentences(message).last().map_or(Ok(Message::Other), |rmc| read_fix(rmc, now_ns, of_rmc))
}

/// The lines of a message, with their ends.
fn sentences(message: &[u8]) -> impl Iterator<Item = &[u8]> {
    message.split_inclusive(|&byte| byte == b'\n')
}

fn is_rmc(sentence: &[u8]) -> bool {
    sentence.get(3..6) == Some(b"RMC")
}

fn check_count(values: &[f64], found: usize) -> Result<(), ReadError> {
    let expected = values.len();
    if found == expected { Ok(()) } else { Err(ReadError::Values { expected, found }) }
}

/// The value of a ray or a column without a measurement.
const NOTHING: f64 = -1.0;

const DAY_MS: u64 = 86_400_000;

/// Values of a reading that an RMC has.
pub const VALUES_OF_RMC: usize = 5;

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;

    const IMAGE: Format = Format::LineImage { message_len: line_image::encoded_len(2, 3) };

    /// Two columns, the second of which sees nothing.
    fn image() -> Vec<u8> {
        let columns = [([255, 0, 51], 1500), ([0, 102, 255], 0)];
        let columns = columns.map(|(rgb, depth_mm)| line_image::Column { rgb, depth_mm });
        let mut bytes = vec![0; line_image::encoded_len(2, 3)];
        line_image::encode(7, columns.into_iter(), 3, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn an_image_is_found_after_bytes_that_begin_none() {
        let mut received = vec![];
        let all = [b"no".as_slice(), &image()].concat();
        for (i, &byte) in all.iter().enumerate() {
            received.push(byte);
            match IMAGE.find(&received) {
                Found::Junk => received.clear(),
                Found::Beginning { skip } => drop(received.drain(..skip)),
                Found::Message { skip } => assert_eq!((i + 1, skip), (all.len(), 0)),
            }
        }
        assert_eq!(received, image());
        assert_eq!(IMAGE.find(b"junk"), Found::Junk);
        assert_eq!(IMAGE.find(&[b"no".as_slice(), &image()].concat()), Found::Message { skip: 2 });
        let other = Format::LineImage { message_len: line_image::encoded_len(2, 4) };
        assert!(!matches!(other.find(&image()), Found::Message { .. }), "another camera's");
    }

    #[test]
    fn the_values_of_an_image_are_channel_by_channel() {
        let mut values = [f64::NAN; 8];
        assert_eq!(IMAGE.read(&image(), 5, &mut values), Ok(Message::Reading { sampled_at_ns: None }));
        assert_eq!(values, [1.0, 0.0, 0.0, 0.4, 0.2, 1.0, 1.5, -1.0]);
        let error = IMAGE.read(&image(), 5, &mut values[..4]);
        assert_eq!(error, Err(ReadError::Values { expected: 4, found: 8 }));
        let mut damaged = image();
        damaged[9] ^= 1;
        assert!(matches!(IMAGE.read(&damaged, 5, &mut values), Err(ReadError::LineImage(_))));
    }

    #[test]
    fn a_scans_clock_means_the_last_instant_that_it_can() {
        let format =
            scip::Format { characters: scip::Characters::Three, first_step: 0, last_step: 2, cluster: 1 };
        let mut bytes = vec![0; format.message_len()];
        let n = scip::encode(&format, 0xff_fffe, [1250, 0, 4000].into_iter(), &mut bytes).unwrap();
        assert_eq!(Format::Scip.find(&bytes[..n - 1]), Found::Beginning { skip: 0 });
        assert_eq!(Format::Scip.find(&bytes[..n]), Found::Message { skip: 0 });
        let mut values = [0.0; 3];
        let read = Format::Scip.read(&bytes[..n], 0x100_0003 * 1_000_000, &mut values);
        assert_eq!(read, Ok(Message::Reading { sampled_at_ns: Some(0xff_fffe * 1_000_000) }));
        assert_eq!(values, [1.25, -1.0, 4.0]);
    }

    fn fix(valid: bool, time_utc_ms: u32) -> Vec<u8> {
        let fix = nmea::Fix {
            time_utc_ms,
            date: (1, 1, 16),
            valid,
            latitude_deg: 57.7,
            longitude_deg: 11.97,
            speed_m_s: 0.5,
            course_deg: 300.0,
            altitude_m: 0.0,
            satellites: 12,
            hdop: 1.0,
            pdop_vdop: None,
        };
        let mut line = vec![0; nmea::MAX_SENTENCE];
        let n = nmea::write_rmc(&fix, &mut line).unwrap();
        line.truncate(n);
        line
    }

    #[test]
    fn a_course_is_counted_from_east() {
        let mut values = [0.0; 5];
        Format::nmea(5).read(&fix(true, 0), 0, &mut values).unwrap();
        assert!((values[4] - 150_f64.to_radians()).abs() < 1e-9, "{values:?}");
        assert_eq!(values[2], 1.0);
    }

    #[test]
    fn without_a_fix_nothing_of_it_is_made_up() {
        let mut values = [9.0; 5];
        let read = Format::nmea(5).read(&fix(false, 1000), 1_500_000_000, &mut values);
        assert_eq!(read, Ok(Message::Reading { sampled_at_ns: Some(1_000_000_000) }));
        assert_eq!(values, [0.0; 5]);
    }

    #[test]
    fn a_reading_with_an_altitude_is_all_sentences_to_the_rmc() {
        let fix_in_space = nmea::Fix {
            time_utc_ms: 1_000,
            date: (1, 1, 16),
            valid: true,
            latitude_deg: 57.7,
            longitude_deg: 11.97,
            speed_m_s: 0.5,
            course_deg: 90.0,
            altitude_m: 12.3,
            satellites: 6,
            hdop: 2.2,
            pdop_vdop: None,
        };
        let mut bytes = vec![0; nmea::MAX_SENTENCE];
        let n = nmea::write_gga(&fix_in_space, &mut bytes).unwrap();
        bytes.truncate(n);
        let format = Format::nmea(8);
        assert_eq!(format.find(&bytes), Found::Beginning { skip: 0 });
        bytes.extend(fix(true, 1_000));
        assert_eq!(format.find(&bytes[..bytes.len() - 1]), Found::Beginning { skip: 0 });
        assert_eq!(format.find(&bytes), Found::Message { skip: 0 });
        let mut values = [0.0; 8];
        let read = format.read(&bytes, 1_500_000_000, &mut values);
        assert_eq!(read, Ok(Message::Reading { sampled_at_ns: Some(1_000_000_000) }));
        assert_eq!((values[2], &values[5..]), (1.0, &[12.3, 6.0, 2.2][..]));
        let without = format.read(&bytes[n..], 1_500_000_000, &mut values);
        assert_eq!(without, Err(ReadError::Values { expected: 8, found: 5 }));
        bytes[9] ^= 1;
        assert!(matches!(format.read(&bytes, 0, &mut values), Err(ReadError::Nmea(_))));
    }

    #[test]
    fn a_fix_after_midnight_is_of_its_own_day() {
        let mut values = [0.0; 5];
        for (sampled, heard) in
            [(1_000, 1_400), (2 * DAY_MS + 7, 2 * DAY_MS + 400), (DAY_MS - 5, DAY_MS + 300)]
        {
            let line = fix(true, (sampled % DAY_MS) as u32);
            let read = Format::nmea(5).read(&line, heard * 1_000_000, &mut values);
            assert_eq!(read, Ok(Message::Reading { sampled_at_ns: Some(sampled * 1_000_000) }));
        }
    }
}
