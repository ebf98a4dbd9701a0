//! The axis of time, in milliseconds.

use crate::text::width;

/// An axis of time. Instants are integers of nanoseconds, and exact however late they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) from_ns: u64,
    pub(super) until_ns: u64,
    /// Left end, in pixels.
    pub(super) left: f64,
    /// In pixels.
    pub(super) width: f64,
}

impl Axis {
    /// The place of an instant, which may be outside of the window.
    pub(super) fn x(&self, at_ns: u64) -> f64 {
        let off = match at_ns.checked_sub(self.from_ns) {
            Some(after) => after as f64,
            None => -((self.from_ns - at_ns) as f64),
        };
        self.left + off / self.span_ns() as f64 * self.width
    }

    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    /// The length of the axis, at least 1.
    fn span_ns(&self) -> u64 {
        self.until_ns.saturating_sub(self.from_ns).max(1)
    }

    /// Multiples of `step_ns` in the window, if there are not more than `most`.
    pub(super) fn multiples(&self, step_ns: u64, most: usize) -> Vec<u64> {
        let first = self.from_ns.checked_next_multiple_of(step_ns);
        let all = std::iter::successors(first, |at| at.checked_add(step_ns));
        let all: Vec<_> = all.take_while(|at| *at <= self.until_ns).take(most + 1).collect();
        if all.len() > most { Vec::new() } else { all }
    }

    /// Round instants that are far enough apart for their labels, with these.
    pub(super) fn ticks(&self) -> Vec<(u64, String)> {
        let (step_ns, decimals) = self.step();
        let ticks = self.multiples(step_ns, MOST).into_iter();
        ticks.map(|at| (at, ms(at, decimals))).collect()
    }

    /// The shortest round step that leaves room for labels, and their decimals of a millisecond.
    fn step(&self) -> (u64, usize) {
        for exponent in 0..19_u32 {
            let decimals = 6_usize.saturating_sub(exponent as usize);
            let room = (width(&ms(self.until_ns, decimals), SIZE) + 22.0).max(LEAST_PX);
            for digit in [1, 2, 5] {
                let step_ns = digit * 10_u64.pow(exponent);
                if step_ns as f64 / self.span_ns() as f64 * self.width >= room {
                    return (step_ns, decimals);
                }
            }
        }
        (10_u64.pow(19), 0)
    }
}

/// An instant or a span in milliseconds, truncated to a number of decimals, which is at most 6.
pub fn ms(ns: u64, decimals: usize) -> String {
    let whole = (ns / 1_000_000).to_string();
    let part = format!("{:06}", ns % 1_000_000);
    match part.get(..decimals.min(6)) {
        None | Some("") => whole,
        Some(part) => format!("{whole}.{part}"),
    }
}

/// The size of the ticks' texts, in pixels.
pub(super) const SIZE: f64 = 11.0;
/// The least distance of ticks, in pixels.
const LEAST_PX: f64 = 58.0;
/// The most ticks.
const MOST: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(from_ns: u64, until_ns: u64) -> Vec<String> {
        let axis = Axis { from_ns, until_ns, left: 0.0, width: 600.0 };
        let ticks = axis.ticks();
        let places: Vec<_> = ticks.iter().map(|(at, _)| axis.x(*at)).collect();
        assert!(places.iter().all(|x| (0.0..=600.0).contains(x)), "{places:?}");
        let texts: Vec<_> = ticks.into_iter().map(|(_, text)| text).collect();
        let far = places.windows(2).all(|pair| pair[1] - pair[0] > 40.0);
        assert!(far && texts.len() <= 11, "{texts:?} at {places:?}");
        texts
    }

    #[test]
    fn ticks_are_at_round_numbers_of_milliseconds() {
        assert_eq!(ticks(0, 30_000_000), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(ticks(19_999_999, 26_000_001), ["20", "21", "22", "23", "24", "25", "26"]);
        assert_eq!(
            ticks(0, 5_000_000),
            ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0", "3.5", "4.0", "4.5", "5.0"]
        );
    }

    #[test]
    fn late_in_a_long_run_ticks_are_as_exact_as_at_its_start() {
        let year_ns = 365 * 86_400 * 1_000_000_000;
        let expected = ["31536000000.000", "31536000000.001", "31536000000.002", "31536000000.003"];
        assert_eq!(ticks(year_ns, year_ns + 3500), expected);
    }

    #[test]
    fn no_window_is_too_short_or_too_long() {
        for (from, until) in
            [(0, 0), (5, 5), (0, 1), (9, 3), (0, u64::MAX), (u64::MAX - 10, u64::MAX), (u64::MAX, 0)]
        {
            ticks(from, until);
        }
    }

    #[test]
    fn numbers_are_cut_not_rounded() {
        assert_eq!(
            [ms(1_999_999, 0), ms(1_999_999, 3), ms(50, 6), ms(7, 9)],
            ["1", "1.999", "0.000050", "0.000007"]
        );
    }

    #[test]
    fn of_too_many_boundaries_there_are_none() {
        let axis = Axis { from_ns: 5, until_ns: 35, left: 0.0, width: 1.0 };
        assert_eq!(axis.multiples(10, 3), [10, 20, 30]);
        assert!(axis.multiples(10, 2).is_empty());
        assert!(axis.multiples(0, 9).is_empty());
    }
}
