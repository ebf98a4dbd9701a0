//! The record of a port: its acts, and their lateness.

use std::fmt;
use std::time::Duration;

/// The record of a port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The number of times that a program has opened it.
    pub opened: u64,
    /// Bytes that a program was given.
    pub given: u64,
    /// Bytes that came while no program had it open.
    pub unheard: u64,
    /// Bytes that a program did not read in time, and lost.
    pub overrun: u64,
    /// Bytes that a program wrote, as the robot's UART read them.
    pub taken: u64,
    /// Characters that a UART could not read as they were sent, since the ends are set differently.
    pub line_errors: u64,
    /// The lateness of bytes that were given to the program: the number of those that were less than 2^i microseconds
    /// late, by i.
    pub lateness_us_log2: [u64; 32],
    /// The latest byte.
    pub latest: Duration,
}

impl Report {
    /// Notes bytes that were given so long after their instant.
    pub(crate) fn note(&mut self, bytes: u64, late: Duration) {
        self.given += bytes;
        let bits = u64::BITS - (late.as_micros() as u64).leading_zeros();
        self.lateness_us_log2[(bits as usize).min(self.lateness_us_log2.len() - 1)] += bytes;
        self.latest = self.latest.max(late);
    }

    /// The lateness that this share of all bytes did not exceed, to a power of two of microseconds.
    pub fn quantile(&self, share: f64) -> Option<Duration> {
        let mut left = (share * self.given as f64).ceil() as u64;
        if self.given == 0 {
            return None;
        }
        let i = self.lateness_us_log2.iter().position(|&count| {
            left = left.saturating_sub(count);
            left == 0
        })?;
        Some(Duration::from_micros(1 << i).min(self.latest))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { opened, given, unheard, overrun, taken, line_errors, latest, .. } = self;
        write!(f, "opened {opened} times, {given} bytes to programs, {taken} from them")?;
        if let (Some(most), Some(nearly_all)) = (self.quantile(0.5), self.quantile(0.99)) {
            let ms = |time: Duration| time.as_secs_f64() * 1e3;
            write!(
                f,
                "; late by less than {:.3} ms (median), {:.3} ms (99th percentile), {:.3} ms (maximum)",
                ms(most),
                ms(nearly_all),
                ms(*latest)
            )?;
        }
        for (count, what) in [
            (unheard, "came while no program had it open"),
            (overrun, "lost, as no program read them"),
            (line_errors, "characters misread, as the two ends have different settings"),
        ] {
            if *count > 0 {
                write!(f, "; {count} {what}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_says_how_late_bytes_were() {
        let mut report = Report { opened: 1, taken: 3, ..Report::default() };
        report.note(98, Duration::from_micros(70));
        report.note(2, Duration::from_millis(3));
        assert_eq!(report.quantile(0.5), Some(Duration::from_micros(128)));
        let text = report.to_string();
        assert_eq!(
            text,
            "opened 1 times, 100 bytes to programs, 3 from them; late by less than 0.128 ms (median), 3.000 ms (99th percentile), 3.000 ms (maximum)"
        );
    }
}
