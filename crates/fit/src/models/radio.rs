//! Echoes over a radio: latency, spread and bursts.
//!
//! A byte that is sent when nothing is on its way takes the radio once down and once up; a longer message takes it twice
//! upwards, as an idle radio goes with the first byte. Each time takes latency + U(±spread), and with the probability p the
//! burst more. So the echo less its time on the wires is a sum of two or three uniform numbers and some bursts.

use baudbot_sim::link::{Bluetooth, Uart};

use super::Case;
use super::echo::Echoes;
use crate::estimate::{Fitted, Outcome, Reason, Residuals, found};
use crate::fields::{AdapterField, Field};
use crate::search::{Best, Search, Unknown};

/// Fits a radio.
pub(crate) fn fit(case: &Case<'_>, uart: &Uart, radio: &Bluetooth) -> Fitted {
    match Echoes::of(case, uart) {
        Ok(echoes) => {
            Radio { passes: if echoes.bytes > 1.0 { 3 } else { 2 }, echoes, radio: *radio }.fit(case)
        }
        Err(reason) => Fitted::only(case.none(&reason)),
    }
}

const FIELDS: [AdapterField; 4] =
    [AdapterField::Latency, AdapterField::Spread, AdapterField::BurstProbability, AdapterField::Burst];

struct Radio {
    echoes: Echoes,
    radio: Bluetooth,
    /// The number of times that an echo passes the radio.
    passes: u32,
}

impl Radio {
    fn cost(&self, numbers: &[f64]) -> f64 {
        let [latency, spread, probability, burst] = numbers else { return f64::INFINITY };
        if spread > latency {
            return f64::INFINITY;
        }
        let n = self.passes;
        let mean = f64::from(n) * latency;
        let shares: Vec<f64> = (0..=n)
            .map(|k| binomial(n, k) * probability.powi(k as i32) * (1.0 - probability).powi((n - k) as i32))
            .collect();
        let likelihood = |time: f64| {
            let bursts = shares.iter().enumerate();
            bursts.map(|(k, share)| share * density(time - mean - k as f64 * burst, *spread, n)).sum::<f64>()
        };
        self.echoes.rounds_s().map(|time| -((1.0 - STRAY) * likelihood(time) + STRAY / STRAY_S).ln()).sum()
    }

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let cost = |numbers: &[f64]| self.cost(numbers);
        let search = Search {
            unknowns: vec![
                Unknown::positive(1e-4, 2.0),
                Unknown::log(1e-6, 1.0),
                Unknown::log(1e-6, 0.9),
                Unknown::positive(1e-4, 5.0),
            ],
            cost: &cost,
        };
        let mut best = search.best(&self.starts());
        let names = FIELDS.map(|field| format!("`link.adapter.{}`", field.name()));
        let mut findings = Vec::new();
        for field in case.wanted {
            let Field::Adapter(adapter) = field else { continue };
            let outcome = match FIELDS.iter().position(|known| known == adapter) {
                Some(place) => self.outcome(&search, &mut best, place, &names),
                None => Outcome::CannotTell(Reason::Columns { needs: "USB adapter".into() }),
            };
            findings.push(case.finding(*field, outcome));
        }
        let mean = f64::from(self.passes) * best.values[0];
        let points = self.echoes.rounds_s().enumerate().map(|(i, time)| (i as f64, (time - mean) * 1e3));
        let residuals = Residuals {
            title: "echoes less their mean without bursts".into(),
            x: "echo".into(),
            unit: "ms".into(),
            points: points.collect(),
        };
        Fitted { findings, residuals: vec![residuals], remarks: self.echoes.remarks.clone() }
    }

    fn outcome(&self, search: &Search<'_>, best: &mut Best, place: usize, names: &[String]) -> Outcome {
        let unit = if FIELDS[place] == AdapterField::BurstProbability { 1.0 } else { 1e-3 };
        let is_late = |time: f64| time > f64::from(self.passes) * (best.values[0] + best.values[1]);
        let late = self.echoes.rounds_s().filter(|time| is_late(*time)).count();
        if FIELDS[place] == AdapterField::Burst && late == 0 {
            return Outcome::CannotTell(Reason::Excitation { what: "no echo is held up by a burst".into() });
        }
        found(search, best, (place, names), unit)
    }

    /// Numbers to begin with: by quantiles, with bursts like the scenario's or the longest echoes.
    fn starts(&self) -> Vec<Vec<f64>> {
        let mut times: Vec<f64> = self.echoes.rounds_s().collect();
        times.sort_by(f64::total_cmp);
        let n = f64::from(self.passes);
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
        let latency = at(0.45) / n;
        let spread = ((at(0.45) - times[0]) / n * 1.1).clamp(1e-5, 0.9 * latency);
        let burst = (at(1.0) - at(0.5)).max(2e-4);
        let scenario = (self.radio.burst_ns as f64 * 1e-9).max(2e-4);
        let starts = [burst, 0.5 * burst, scenario].map(|burst| vec![latency, spread, 0.02, burst]);
        starts.into()
    }
}

/// The density of the sum of two or three numbers that are uniform in ±`spread`: Irwin and Hall's.
fn density(x: f64, spread: f64, n: u32) -> f64 {
    let width = 2.0 * spread;
    let u = x / width + 0.5 * f64::from(n);
    if u <= 0.0 || u >= f64::from(n) {
        return 0.0;
    }
    let order = n as i32 - 1;
    let terms = (0..=u as u32).map(|k| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sign * binomial(n, k) * (u - f64::from(k)).powi(order)
    });
    terms.sum::<f64>().max(0.0) / (if n == 3 { 2.0 } else { 1.0 }) / width
}

fn binomial(n: u32, k: u32) -> f64 {
    (0..k).map(|i| f64::from(n - i) / f64::from(i + 1)).product()
}

/// An echo in so many is taken for one that no radio explains, …
const STRAY: f64 = 1e-4;

/// … and may take up to this long.
const STRAY_S: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::density;

    #[test]
    fn densities_integrate_to_1() {
        for n in [2, 3] {
            let sum: f64 = (-4000..4000).map(|i| density(f64::from(i) * 1e-3, 0.7, n) * 1e-3).sum();
            assert!((sum - 1.0).abs() < 1e-4, "{n}: {sum}");
        }
    }
}
