//! A scale with its ticks.

/// From numbers to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    log: bool,
    pixels: (f64, f64),
}

impl Scale {
    /// A scale over these numbers, and a little more; logarithmic if they are positive and far apart.
    pub(super) fn of(numbers: &[f64], pixels: (f64, f64)) -> Self {
        let (low, high) = ends(numbers);
        let log = low > 0.0 && high / low > LOG_FROM;
        let margin = |a: f64, b: f64| if a < b { 0.04 * (b - a) } else { 0.5 };
        if log {
            let margin = (margin(low.ln(), high.ln())).exp();
            return Self { from: low / margin, to: high * margin, log, pixels };
        }
        let margin = margin(low, high);
        Self { from: low - margin, to: high + margin, log, pixels }
    }

    /// A scale from one number to another, and a little more.
    pub(super) fn between(from: f64, to: f64, pixels: (f64, f64)) -> Self {
        let margin = 0.04 * (to - from);
        Self { from: from - margin, to: to + margin, log: false, pixels }
    }

    /// A scale from 0, or near the numbers if they are far from it, to a round number.
    pub(super) fn round(numbers: &[f64], pixels: (f64, f64)) -> Self {
        let (low, high) = ends(numbers);
        let is_near = low < 0.6 * high || low == high;
        let low = if low >= 0.0 && is_near { 0.0 } else { low };
        let high = if high > low { high } else { low + 1.0 };
        let step = step((high - low) / TICKS);
        Self { from: (low / step).floor() * step, to: (high / step - 1e-9).ceil() * step, log: false, pixels }
    }

    /// Shares, from 0 to 1.
    pub(super) fn share(pixels: (f64, f64)) -> Self {
        Self { from: 0.0, to: 1.0, log: false, pixels }
    }

    /// Where a number is; what is beyond the ends is at them.
    pub(super) fn px(&self, number: f64) -> f64 {
        let f = |x: f64| if self.log { x.max(f64::MIN_POSITIVE).ln() } else { x };
        let share = (f(number) - f(self.from)) / (f(self.to) - f(self.from));
        self.pixels.0 + share.clamp(0.0, 1.0) * (self.pixels.1 - self.pixels.0)
    }

    /// Round numbers along it.
    pub(super) fn ticks(&self) -> Vec<f64> {
        if !self.log {
            let step = step((self.to - self.from) / TICKS);
            let (first, last) =
                ((self.from / step - 1e-9).ceil() as i64, (self.to / step + 1e-9).floor() as i64);
            return (first..=last).take(MOST).map(|i| i as f64 * step).collect();
        }
        let decades = self.from.log10().floor() as i32..=self.to.log10().ceil() as i32;
        let digits: &[f64] = if decades.clone().count() > 5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let all = decades.flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)));
        all.filter(|tick| (self.from..=self.to).contains(tick)).take(MOST).collect()
    }
}

fn ends(numbers: &[f64]) -> (f64, f64) {
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

/// The round number that is not below.
fn step(least: f64) -> f64 {
    let decade = 10_f64.powi(least.max(1e-300).log10().floor() as i32);
    let digit = [1.0, 2.0, 5.0, 10.0].into_iter().find(|digit| digit * decade >= least * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * decade
}

/// A number with three digits or so, and no zeros at its end.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        return format!("{value:.1e}").replace('-', "−");
    }
    let decimals =
        if size >= 100.0 || size == 0.0 { 0 } else { (2 - size.log10().floor() as i32).max(0) as usize };
    let text = format!("{value:.decimals$}");
    let text = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}

/// A share as people say it.
pub(super) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent >= 10.0 { format!("{percent:.0} %") } else { format!("{} %", number(percent)) }
}

/// Numbers whose largest is more than so many times their least are drawn on a logarithmic scale.
const LOG_FROM: f64 = 20.0;

/// Ticks of an axis, about.
const TICKS: f64 = 5.0;

/// More ticks than any axis has.
const MOST: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let scale = Scale::round(&[0.3, 42.0], (0.0, 100.0));
        assert_eq!(scale.ticks(), [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]);
        assert_eq!(
            (scale.px(0.0), scale.px(50.0), scale.px(25.0), scale.px(99.0)),
            (0.0, 100.0, 50.0, 100.0)
        );
        let near = Scale::round(&[90.0, 100.0], (0.0, 1.0)).ticks();
        assert_eq!(near, [90.0, 92.0, 94.0, 96.0, 98.0, 100.0]);
        assert_eq!(Scale::round(&[0.0, 0.0], (0.0, 1.0)).ticks().first(), Some(&0.0));
        assert!(Scale::round(&[], (0.0, 1.0)).ticks().len() > 2);
    }

    #[test]
    fn numbers_far_apart_have_a_logarithmic_scale() {
        let scale = Scale::of(&[1200.0, 115_200.0], (0.0, 100.0));
        assert_eq!(scale.ticks(), [1000.0, 2000.0, 5000.0, 10_000.0, 20_000.0, 50_000.0, 100_000.0]);
        assert!((scale.px((1200.0 * 115_200.0_f64).sqrt()) - 50.0).abs() < 1e-9);
        assert!(!Scale::of(&[1.0, 16.0], (0.0, 1.0)).log && !Scale::of(&[0.0, 160.0], (0.0, 1.0)).log);
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 1.0, 0.5, 0.125, 12.3456, 1234.5, 115_200.0, -2.0, 1e-9, 0.012_34].map(number);
        assert_eq!(texts, ["0", "1", "0.5", "0.125", "12.3", "1234", "115200", "−2", "1.0e−9", "0.0123"]);
        assert_eq!([percent(0.705), percent(0.0123), percent(0.0)], ["70 %", "1.23 %", "0 %"]);
    }
}
