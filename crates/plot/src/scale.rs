//! Scales of axes, and their ticks.

/// A scale from numbers to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    from: f64,
    to: f64,
    log: bool,
    pixels: (f64, f64),
}

impl Scale {
    /// A linear scale from one number to another.
    pub fn new(from: f64, to: f64, pixels: (f64, f64)) -> Self {
        Self { from, to, log: false, pixels }
    }

    /// A linear scale from one number to another, with margins.
    pub fn between(from: f64, to: f64, pixels: (f64, f64)) -> Self {
        let margin = 0.04 * (to - from);
        Self::new(from - margin, to + margin, pixels)
    }

    /// A scale over these numbers, with margins. It is logarithmic if they are positive and far apart.
    pub fn of(numbers: &[f64], pixels: (f64, f64)) -> Self {
        let (low, high) = ends(numbers);
        let log = low > 0.0 && high / low > LOG_FROM;
        let margin = |a: f64, b: f64| if a < b { 0.04 * (b - a) } else { 0.5 };
        if log {
            let margin = (margin(low.ln(), high.ln())).exp();
            return Self { from: low / margin, to: high * margin, log, pixels };
        }
        let margin = margin(low, high);
        Self::new(low - margin, high + margin, pixels)
    }

    /// A linear scale from 0, or near the numbers if they are far from it, to a round number.
    pub fn round(numbers: &[f64], pixels: (f64, f64)) -> Self {
        let (low, high) = ends(numbers);
        let is_near = low < 0.6 * high || low == high;
        let low = if low >= 0.0 && is_near { 0.0 } else { low };
        let high = if high > low { high } else { low + 1.0 };
        let step = tick_step(high - low);
        Self::new((low / step).floor() * step, (high / step - SLACK).ceil() * step, pixels)
    }

    /// A scale of shares, from 0 to 1.
    pub fn share(pixels: (f64, f64)) -> Self {
        Self::new(0.0, 1.0, pixels)
    }

    /// The pixel of a number. Numbers beyond the ends are at the ends.
    pub fn px(&self, number: f64) -> f64 {
        self.pixel(self.portion(number).clamp(0.0, 1.0))
    }

    /// The pixel of a number, which may be beyond the ends.
    pub fn px_beyond(&self, number: f64) -> f64 {
        self.pixel(self.portion(number))
    }

    /// About five round numbers along the scale.
    pub fn ticks(&self) -> Vec<f64> {
        if !self.log {
            return self.multiples(tick_step(self.to - self.from)).collect();
        }
        let decades = self.from.log10().floor() as i32..=self.to.log10().ceil() as i32;
        let digits: &[f64] = if decades.clone().count() > 5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let all = decades.flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)));
        all.filter(|tick| (self.from..=self.to).contains(tick)).take(MOST).collect()
    }

    /// The pixels of round numbers that are at least so many pixels apart, with their labels, of a linear scale.
    pub fn labelled_ticks(&self, least_px: f64) -> Vec<(f64, String)> {
        let per_px = (self.to - self.from) / (self.pixels.1 - self.pixels.0).abs();
        let (step, decimals) = round_up((per_px * least_px).max(1e-9));
        self.multiples(step).map(|number| (self.px_beyond(number), label(number, decimals))).collect()
    }

    fn multiples(&self, step: f64) -> impl Iterator<Item = f64> + use<> {
        multiples(self.from - SLACK * step, self.to + SLACK * step, step)
    }

    fn portion(&self, number: f64) -> f64 {
        let f = |x: f64| if self.log { x.max(f64::MIN_POSITIVE).ln() } else { x };
        (f(number) - f(self.from)) / (f(self.to) - f(self.from))
    }

    fn pixel(&self, portion: f64) -> f64 {
        self.pixels.0 + portion * (self.pixels.1 - self.pixels.0)
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not below a positive number, and its decimals.
pub fn round_up(least: f64) -> (f64, usize) {
    let least = least.max(1e-300);
    // One decade early: platforms round logarithms differently, and must agree on the result.
    let mut exponent = least.log10() as i32 - 1;
    loop {
        for digit in [1, 2, 5] {
            let number: f64 = format!("{digit}e{exponent}").parse().expect("a number");
            if number >= least {
                return (number, (-exponent).max(0) as usize);
            }
        }
        exponent += 1;
    }
}

/// The multiples of a step from one number to another, but no more than any axis has room for.
pub fn multiples(from: f64, to: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
    (first..=last).take(MOST).map(move |i| i as f64 * step)
}

/// The label of a tick, with a minus sign as it is printed.
pub fn label(number: f64, decimals: usize) -> String {
    format!("{number:.decimals$}").replace('-', "−")
}

fn tick_step(span: f64) -> f64 {
    round_up(span / TICKS * (1.0 - SLACK)).0
}

fn ends(numbers: &[f64]) -> (f64, f64) {
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

/// A number with about three digits and no trailing zeros.
pub fn number(value: f64) -> String {
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

/// A share in per cent.
pub fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent >= 10.0 { format!("{percent:.0} %") } else { format!("{} %", number(percent)) }
}

/// Numbers whose greatest is more than so many times their least get a logarithmic scale.
const LOG_FROM: f64 = 20.0;
/// The approximate number of ticks of an axis.
const TICKS: f64 = 5.0;
/// No axis has more ticks.
const MOST: usize = 50;
/// Rounding errors that ticks forgive, in steps.
const SLACK: f64 = 1e-9;

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

    #[test]
    fn ticks_are_far_enough_apart_for_their_labels() {
        let ticks = Scale::new(-0.3, 1.2, (220.0, 0.0)).labelled_ticks(26.0);
        let labels: Vec<_> = ticks.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(labels, ["−0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"]);
        assert!(ticks.windows(2).all(|pair| pair[0].0 - pair[1].0 > 26.0), "{ticks:?}");
    }

    #[test]
    fn steps_are_the_round_numbers_that_are_not_below() {
        let steps = [0.41, 0.5, 1e-9, 62_000.0, 1.0, 2.1, 10.0].map(round_up);
        assert_eq!(steps, [(0.5, 1), (0.5, 1), (1e-9, 9), (1e5, 0), (1.0, 0), (5.0, 0), (10.0, 0)]);
    }
}
