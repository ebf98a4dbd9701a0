//! Writes sentences.

use core::fmt::{self, Display, Write};

use super::{DAY_MS, Fix, KNOTS_PER_M_S, Satellite};
use crate::encoding::round;
use crate::error::NoRoom;

/// Writes the least that navigation needs (RMC) to the front of `out` and returns its length, at most
/// [`MAX_SENTENCE`](super::MAX_SENTENCE).
///
/// # Errors
/// If `out` is too short.
pub fn write_rmc(fix: &Fix, out: &mut [u8]) -> Result<usize, NoRoom> {
    let knots = Known(fix.valid, Fixed::new(fix.speed_m_s * KNOTS_PER_M_S, 2, 0..=999_999));
    let hundredths = round(fix.course_deg % 360.0 * 100.0).rem_euclid(36_000);
    let course = Known(fix.valid, Fixed { units: hundredths, decimals: 2 });
    let (time, position, date) = (Time(fix.time_utc_ms), Place(fix), Date(fix.date));
    let (status, mode) = if fix.valid { ('A', 'A') } else { ('V', 'N') };
    let mut line = Line::new(out);
    line.sentence(format_args!("GPRMC,{time},{status},{position},{knots},{course},{date},,,{mode}"));
    line.finish()
}

/// Writes position, altitude and quality (GGA) to the front of `out` and returns its length, at most
/// [`MAX_SENTENCE`](super::MAX_SENTENCE).
///
/// # Errors
/// If `out` is too short.
pub fn write_gga(fix: &Fix, out: &mut [u8]) -> Result<usize, NoRoom> {
    let altitude = Known(fix.valid, Fixed::new(fix.altitude_m, 1, -999_999..=999_999));
    let (time, position, hdop) = (Time(fix.time_utc_ms), Place(fix), hdop(fix));
    let (quality, satellites) = (u8::from(fix.valid), fix.satellites.min(99));
    let mut line = Line::new(out);
    line.sentence(format_args!("GPGGA,{time},{position},{quality},{satellites:02},{hdop},{altitude},M,,,,"));
    line.finish()
}

/// Writes which satellites are in use (GSA) to the front of `out` and returns its length, at most
/// [`MAX_SENTENCE`](super::MAX_SENTENCE). In use are the first [`Fix::satellites`] of `in_view`, of which the sentence
/// holds 12; without a fix none.
///
/// # Errors
/// If `out` is too short.
pub fn write_gsa(fix: &Fix, in_view: &[Satellite], out: &mut [u8]) -> Result<usize, NoRoom> {
    let in_use = in_view.iter().take(if fix.valid { fix.satellites.into() } else { 0 });
    let (dimensions, hdop) = (if fix.valid { 3 } else { 1 }, hdop(fix));
    let (pdop, vdop) = fix.pdop_vdop.unwrap_or_default();
    let [pdop, vdop] =
        [pdop, vdop].map(|dop| Known(fix.valid && fix.pdop_vdop.is_some(), Fixed::new(dop, 2, 0..=9999)));
    let mut line = Line::new(out);
    line.sentence(format_args!("GPGSA,A,{dimensions},{},{pdop},{hdop},{vdop}", InUse(in_use)));
    line.finish()
}

/// Writes the satellites in view (GSV) to the front of `out`, four in a sentence, and returns the length of all
/// sentences, each of at most [`MAX_SENTENCE`](super::MAX_SENTENCE). Without satellites there is one sentence;
/// more than 36 would be more sentences than one digit counts, and the remainder is left out.
///
/// # Errors
/// If `out` is too short.
pub fn write_gsv(in_view: &[Satellite], out: &mut [u8]) -> Result<usize, NoRoom> {
    let in_view = in_view.get(..36).unwrap_or(in_view);
    let (sentences, count) = (in_view.len().div_ceil(4).max(1), in_view.len());
    let mut line = Line::new(out);
    for index in 0..sentences {
        let four = InView(in_view.iter().skip(index * 4).take(4));
        line.sentence(format_args!("GPGSV,{sentences},{},{count:02}{four}", index + 1));
    }
    line.finish()
}

/// Writes sentences one after the other. Counts what would not fit, so that the error can say what would.
struct Line<'a> {
    out: &'a mut [u8],
    len: usize,
    /// The exclusive or of all since the sentence began.
    sum: u8,
}

impl<'a> Line<'a> {
    const fn new(out: &'a mut [u8]) -> Self {
        Self { out, len: 0, sum: 0 }
    }

    fn sentence(&mut self, fields: fmt::Arguments<'_>) {
        self.put(b'$');
        self.sum = 0;
        // Neither the line nor a field ever reports an error: what is too long is counted.
        let _ = self.write_fmt(fields);
        let sum = self.sum;
        let _ = write!(self, "*{sum:02X}\r\n");
    }

    fn put(&mut self, byte: u8) {
        if let Some(place) = self.out.get_mut(self.len) {
            *place = byte;
        }
        self.len += 1;
        self.sum ^= byte;
    }

    const fn finish(self) -> Result<usize, NoRoom> {
        let (needed, room) = (self.len, self.out.len());
        if needed > room { Err(NoRoom { needed, room }) } else { Ok(needed) }
    }
}

impl Write for Line<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.put(byte));
        Ok(())
    }
}

/// A number with a fixed count of decimals. Integers have no surprises in their last digit.
struct Fixed {
    units: i64,
    decimals: u8,
}

impl Fixed {
    /// The nearest to `value` whose number of units of the last digit is in `range`.
    fn new(value: f64, decimals: u8, range: core::ops::RangeInclusive<i64>) -> Self {
        let units = round(value * 10i64.pow(decimals.into()) as f64);
        Self { units: units.clamp(*range.start(), *range.end()), decimals }
    }
}

impl Display for Fixed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (units, one) = (self.units.unsigned_abs(), 10u64.pow(self.decimals.into()));
        let sign = if self.units < 0 { "-" } else { "" };
        write!(f, "{sign}{}.{:0width$}", units / one, units % one, width = self.decimals.into())
    }
}

/// A field that is empty unless it is known.
struct Known<T>(bool, T);

impl<T: Display> Display for Known<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 { self.1.fmt(f) } else { Ok(()) }
    }
}

fn hdop(fix: &Fix) -> Known<Fixed> {
    Known(fix.valid, Fixed::new(fix.hdop, 2, 0..=9999))
}

/// Milliseconds of the day as `hhmmss.sss`.
struct Time(u32);

impl Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0 % DAY_MS / 1000;
        let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
        write!(f, "{hours:02}{minutes:02}{:02}.{:03}", seconds % 60, self.0 % 1000)
    }
}

/// Day, month and year as `ddmmyy`.
struct Date((u8, u8, u8));

impl Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (day, month, year) = self.0;
        write!(f, "{:02}{:02}{:02}", day.min(99), month.min(99), year.min(99))
    }
}

/// The four fields of a position.
struct Place<'a>(&'a Fix);

impl Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.valid {
            return f.write_str(",,,");
        }
        // In integers, or a minute could be rounded up to 60.
        let units = |degrees: f64, limit: i64| {
            round(degrees * UNITS_PER_DEGREE as f64)
                .clamp(-limit * UNITS_PER_DEGREE, limit * UNITS_PER_DEGREE)
        };
        let (north, east) = (units(self.0.latitude_deg, 90), units(self.0.longitude_deg, 180));
        let parts = |units: i64| {
            let units = units.abs();
            (units / UNITS_PER_DEGREE, units % UNITS_PER_DEGREE / 10_000, units % 10_000)
        };
        let (degrees, minutes, fraction) = parts(north);
        let side = if north < 0 { 'S' } else { 'N' };
        write!(f, "{degrees:02}{minutes:02}.{fraction:04},{side},")?;
        let (degrees, minutes, fraction) = parts(east);
        let side = if east < 0 { 'W' } else { 'E' };
        write!(f, "{degrees:03}{minutes:02}.{fraction:04},{side}")
    }
}

/// The twelve fields of satellites in use.
struct InUse<I>(I);

impl<'a, I: Iterator<Item = &'a Satellite> + Clone> Display for InUse<I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut satellites = self.0.clone();
        for field in 0..12 {
            f.write_str(if field > 0 { "," } else { "" })?;
            if let Some(satellite) = satellites.next() {
                write!(f, "{:02}", satellite.prn.min(99))?;
            }
        }
        Ok(())
    }
}

/// Four fields of each satellite in view, each with a comma in front.
struct InView<I>(I);

impl<'a, I: Iterator<Item = &'a Satellite> + Clone> Display for InView<I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.clone().try_for_each(|satellite| {
            let (prn, elevation) = (satellite.prn.min(99), satellite.elevation_deg.min(90));
            write!(f, ",{prn:02},{elevation:02},{:03},", satellite.azimuth_deg % 360)?;
            if satellite.snr_db == 0 { Ok(()) } else { write!(f, "{:02}", satellite.snr_db.min(99)) }
        })
    }
}

/// A unit is the last digit of a position, a ten-thousandth of a minute.
const UNITS_PER_DEGREE: i64 = 600_000;
