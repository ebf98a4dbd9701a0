//! Reads sentences.

use thiserror::Error;

use super::KNOTS_PER_M_S;

/// A sentence that arrived whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sentence {
    /// The least that navigation needs.
    Rmc(Rmc),
    /// Position, altitude and quality.
    Gga(Gga),
    /// A sound sentence of another kind.
    Other,
}

/// A point of the earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Degrees north of the equator, −90 to 90.
    pub latitude_deg: f64,
    /// Degrees east of Greenwich, −180 to 180.
    pub longitude_deg: f64,
}

/// The contents of an RMC sentence. `None` is a field that is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rmc {
    /// Time of the day, UTC, in milliseconds; beyond 24 hours only in a leap second.
    pub time_utc_ms: Option<u32>,
    /// Day, month, and the last two digits of the year.
    pub date: Option<(u8, u8, u8)>,
    /// `None` if the receiver has no fix, whatever else it says.
    pub position: Option<Position>,
    /// Speed over ground in metres per second.
    pub speed_m_s: Option<f64>,
    /// Course over ground in degrees clockwise from north, 0 to 360.
    pub course_deg: Option<f64>,
}

/// The contents of a GGA sentence. `None` is a field that is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gga {
    /// Time of the day, UTC, in milliseconds; beyond 24 hours only in a leap second.
    pub time_utc_ms: Option<u32>,
    /// `None` if the receiver has no fix, whatever else it says.
    pub position: Option<Position>,
    /// The kind of fix: 0 none, 1 from satellites alone, 2 with corrections from the ground.
    pub quality: u8,
    /// The number of satellites in use.
    pub satellites: Option<u8>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Height above mean sea level in metres.
    pub altitude_m: Option<f64>,
}

/// A reason why a line is not a sentence, or not a sensible one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ParseError {
    /// The first character, or the last three, are not those of a sentence.
    #[error("a sentence begins with `$` and ends with `*` and two hexadecimal digits (0-9, A-F)")]
    Frame,
    /// The line is not the one that was sent.
    #[error("the sentence's checksum is {found:#04x}, but its characters have {expected:#04x}")]
    Checksum {
        /// The checksum of the characters that arrived.
        expected: u8,
        /// The checksum that arrived.
        found: u8,
    },
    /// The sentence ends too early.
    #[error("there must be a field {index}, {name}, but the sentence ends before it")]
    Missing {
        /// The index of the field, the sentence's name being 0.
        index: usize,
        /// The expected content.
        name: &'static str,
    },
    /// A field is invalid.
    #[error("field {index} must be {name}, and is not")]
    Field {
        /// The index of the field, the sentence's name being 0.
        index: usize,
        /// The expected content.
        name: &'static str,
    },
}

/// Reads one line, with or without its carriage return and line feed. The sentences may be of any constellation:
/// `$GNRMC` is read as `$GPRMC` is.
///
/// # Errors
/// An error if the line is not as it should be. Nothing of it should be used then.
pub fn parse(line: &[u8]) -> Result<Sentence, ParseError> {
    let line = line.strip_suffix(b"\r\n").unwrap_or(line);
    let [b'$', fields @ .., b'*', high, low] = line else { return Err(ParseError::Frame) };
    let (Some(high), Some(low)) = (hexadecimal(*high), hexadecimal(*low)) else {
        return Err(ParseError::Frame);
    };
    let (expected, found) = (fields.iter().fold(0, |sum, byte| sum ^ byte), high << 4 | low);
    if expected != found {
        return Err(ParseError::Checksum { expected, found });
    }
    let mut fields = Fields { rest: Some(fields), index: 0 };
    match fields.take("a name")? {
        [_, _, b'R', b'M', b'C'] => Ok(Sentence::Rmc(Rmc::parse(&mut fields)?)),
        [_, _, b'G', b'G', b'A'] => Ok(Sentence::Gga(Gga::parse(&mut fields)?)),
        _ => Ok(Sentence::Other),
    }
}

impl Rmc {
    fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let time_utc_ms = fields.known("a time", time_ms)?;
        let valid = fields.needed("A or V", |field| sign(field, b'A', b'V'))? > 0.0;
        let position = fields.position()?;
        let knots = fields.known("a speed", |field| decimal(field).filter(|&knots| knots >= 0.0))?;
        let course_deg = fields.known("a course", |field| {
            decimal(field).filter(|course_deg| (0.0..=360.0).contains(course_deg))
        })?;
        let date = fields.known("a date", date)?;
        let speed_m_s = knots.map(|knots| knots / KNOTS_PER_M_S);
        Ok(Self { time_utc_ms, date, position: of_fix(position, valid, 3)?, speed_m_s, course_deg })
    }
}

impl Gga {
    fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let time_utc_ms = fields.known("a time", time_ms)?;
        let position = fields.position()?;
        let quality = fields.needed("a quality", |field| small(field).filter(|&quality| quality <= 9))?;
        let satellites = fields.known("a number of satellites", small)?;
        let hdop =
            fields.known("a dilution of precision", |field| decimal(field).filter(|&hdop| hdop >= 0.0))?;
        let altitude_m = fields.known("an altitude", decimal)?;
        fields.known("M", |field| (field == b"M").then_some(()))?;
        let position = of_fix(position, quality > 0, 2)?;
        Ok(Self { time_utc_ms, position, quality, satellites, hdop, altitude_m })
    }
}

/// The position, if there is a fix; there must be one then, beginning in field `index`.
fn of_fix(position: Option<Position>, fix: bool, index: usize) -> Result<Option<Position>, ParseError> {
    match (fix, position) {
        (false, _) => Ok(None),
        (true, None) => Err(ParseError::Field { index, name: "a whole position, as there is a fix" }),
        (true, position) => Ok(position),
    }
}

struct Fields<'a> {
    /// The text behind the last comma, if there was one.
    rest: Option<&'a [u8]>,
    /// The index of the next field.
    index: usize,
}

impl<'a> Fields<'a> {
    fn take(&mut self, name: &'static str) -> Result<&'a [u8], ParseError> {
        let rest = self.rest.ok_or(ParseError::Missing { index: self.index, name })?;
        let mut parts = rest.splitn(2, |&byte| byte == b',');
        let field = parts.next().unwrap_or_default();
        self.rest = parts.next();
        self.index += 1;
        Ok(field)
    }

    /// The next field as `read` parses it, or `None` if it is empty.
    fn known<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&[u8]) -> Option<T>,
    ) -> Result<Option<T>, ParseError> {
        let field = self.take(name)?;
        if field.is_empty() {
            return Ok(None);
        }
        read(field).map(Some).ok_or(ParseError::Field { index: self.index - 1, name })
    }

    /// The next field, which must not be empty.
    fn needed<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&[u8]) -> Option<T>,
    ) -> Result<T, ParseError> {
        self.known(name, read)?.ok_or(ParseError::Field { index: self.index - 1, name })
    }

    /// The four fields of a position, or `None` if one of them is empty.
    fn position(&mut self) -> Result<Option<Position>, ParseError> {
        let latitude = self.known("a latitude", |field| degrees(field, 2, 90.0))?;
        let north = self.known("N or S", |field| sign(field, b'N', b'S'))?;
        let longitude = self.known("a longitude", |field| degrees(field, 3, 180.0))?;
        let east = self.known("E or W", |field| sign(field, b'E', b'W'))?;
        let (Some(latitude), Some(north), Some(longitude), Some(east)) = (latitude, north, longitude, east)
        else {
            return Ok(None);
        };
        Ok(Some(Position { latitude_deg: north * latitude, longitude_deg: east * longitude }))
    }
}

/// The number of an upper-case hexadecimal digit. A lower-case one would let an altered checksum pass.
fn hexadecimal(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

/// The sign 1 or -1.
fn sign(field: &[u8], positive: u8, negative: u8) -> Option<f64> {
    match field {
        [letter] if *letter == positive => Some(1.0),
        [letter] if *letter == negative => Some(-1.0),
        _ => None,
    }
}

/// A finite number. Core also reads exponents and names of infinity, which no receiver sends.
fn decimal(field: &[u8]) -> Option<f64> {
    let digits = field.strip_prefix(b"-").unwrap_or(field);
    if !digits.iter().all(|&byte| byte.is_ascii_digit() || byte == b'.') {
        return None;
    }
    let number: f64 = core::str::from_utf8(field).ok()?.parse().ok()?;
    number.is_finite().then_some(number)
}

/// A whole number of at most 255.
fn small(field: &[u8]) -> Option<u8> {
    let digits = (1..=3).contains(&field.len()) && field.iter().all(u8::is_ascii_digit);
    if digits { core::str::from_utf8(field).ok()?.parse().ok() } else { None }
}

/// `len` digits of degrees, then minutes, as degrees of at most `limit`.
fn degrees(field: &[u8], len: usize, limit: f64) -> Option<f64> {
    let (whole, minutes) = field.split_at_checked(len)?;
    let minutes = decimal(minutes).filter(|minutes| (0.0..60.0).contains(minutes))?;
    let degrees = f64::from(small(whole)?) + minutes / 60.0;
    (degrees <= limit).then_some(degrees)
}

/// Three numbers of two digits.
fn pairs(&[a, b, c, d, e, f]: &[u8; 6]) -> Option<[u8; 3]> {
    Some([small(&[a, b])?, small(&[c, d])?, small(&[e, f])?])
}

fn date(field: &[u8]) -> Option<(u8, u8, u8)> {
    let [day, month, year] = pairs(field.try_into().ok()?)?;
    ((1..=31).contains(&day) && (1..=12).contains(&month)).then_some((day, month, year))
}

/// `hhmmss`, and a fraction of a second of any length, which is cut to milliseconds.
fn time_ms(field: &[u8]) -> Option<u32> {
    let (whole, fraction) = field.split_first_chunk()?;
    let [hours, minutes, seconds] = pairs(whole)?.map(u32::from);
    let digits = match fraction {
        [] => fraction,
        [b'.', digits @ ..] if digits.iter().all(u8::is_ascii_digit) => digits,
        _ => return None,
    };
    let digit = |at| digits.get(at).map_or(0, |digit| u32::from(digit - b'0'));
    let whole_ms = ((hours * 60 + minutes) * 60 + seconds) * 1000;
    (hours < 24 && minutes < 60 && seconds <= 60)
        .then(|| whole_ms + digit(0) * 100 + digit(1) * 10 + digit(2))
}
