//! Sentences of a satellite navigation receiver: RMC, GGA, GSA and GSV of NMEA 0183, version 2.3.
//!
//! A sentence is one line of at most 82 ASCII characters: `$`, fields with commas between them, `*`, a checksum in two
//! upper-case hexadecimal digits, carriage return, line feed. The checksum is the exclusive or of all characters
//! between `$` and `*`. A field that is not known is empty.
//!
//! | sentence | fields |
//! |---|---|
//! | `$GPRMC` | time, `A` valid or `V` void, position, speed in knots, course, date, 2 empty, mode |
//! | `$GPGGA` | time, position, quality, satellites in use, HDOP, altitude, `M`, 4 empty |
//! | `$GPGSA` | `A`, 1 no fix or 3 in space, 12 numbers of satellites in use, PDOP, HDOP, VDOP |
//! | `$GPGSV` | sentences, which of them, satellites in view, then of 4 satellites: number, elevation, azimuth, SNR |
//!
//! A position is four fields: latitude, `N` or `S`, longitude, `E` or `W`. Time is `hhmmss.sss`, the date `ddmmyy`, a
//! latitude `ddmm.mmmm`, a longitude `dddmm.mmmm`: degrees and minutes, whose last digit is 0.185 m on the ground. What
//! a simulated receiver does not know stays empty: the magnetic variation, the geoid's height, and, unless it counts its satellites, the dilutions
//! of precision other than the horizontal one.
//!
//! One altered character is always found. Two that are altered by the same bits are not, nor is another order.

mod date;
mod parse;
mod write;

pub use date::date_after;
pub use parse::{Gga, ParseError, Position, Rmc, Sentence, parse};
pub use write::{write_gga, write_gsa, write_gsv, write_rmc};

/// The most characters of a sentence, from `$` to the line feed.
pub const MAX_SENTENCE: usize = 82;

/// The data of a receiver. Every number is written as near to it as its field allows, and NaN as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Time of the day, UTC, in milliseconds; taken modulo 24 hours.
    pub time_utc_ms: u32,
    /// Day from 1, month from 1, and the last two digits of the year.
    pub date: (u8, u8, u8),
    /// Whether there is a fix. Without one only time and date are sent, and the number of satellites.
    pub valid: bool,
    /// Degrees north of the equator, −90 to 90.
    pub latitude_deg: f64,
    /// Degrees east of Greenwich, −180 to 180.
    pub longitude_deg: f64,
    /// Speed over ground in metres per second, 0 to 5144.
    pub speed_m_s: f64,
    /// Course over ground in degrees clockwise from north; taken modulo 360.
    pub course_deg: f64,
    /// Height above mean sea level in metres, at most 99,999.9 up or down.
    pub altitude_m: f64,
    /// The number of satellites in use, 0 to 99.
    pub satellites: u8,
    /// Horizontal dilution of precision, 0 to 99.99.
    pub hdop: f64,
    /// Dilutions of precision of the position in space and of the altitude, 0 to 99.99, if the receiver tells them.
    pub pdop_vdop: Option<(f64, f64)>,
}

/// A satellite in view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Satellite {
    /// The number of the satellite, 1 to 99.
    pub prn: u8,
    /// Degrees above the horizon, 0 to 90.
    pub elevation_deg: u8,
    /// Degrees clockwise from north; taken modulo 360.
    pub azimuth_deg: u16,
    /// Ratio of signal to noise in dB, 1 to 99; 0 if the signal is not tracked, and the field is empty then.
    pub snr_db: u8,
}

const DAY_MS: u32 = 86_400_000;
/// A knot is 1852 m in an hour.
const KNOTS_PER_M_S: f64 = 3600.0 / 1852.0;

#[cfg(test)]
mod tests;
