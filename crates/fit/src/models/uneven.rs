//! The unevenness of motors: the factor on each wheel's signal that is drawn once a tick.
//!
//! A wheel that gets the signal s for a tick Δt rolls V s Δt (1 + σ ε). Over a window of many lags the ways of the two wheels
//! differ from those of the model by independent normal numbers with the variance (V Δt σ)² (1 − τ / T) Σ s² + 2 r², where r is
//! the noise of the measured place, T the window, and τ the lag, which takes what happens at the end of a window to the next.
//! The numbers of the response were fitted to the same log, so the differences are too small; the likelihood has as many
//! degrees of freedom less.

use baudbot_sim::motor::Motors;

use super::motion::{Kind, Segment};
use super::response::Response;
use crate::estimate::{Outcome, Reason, found};
use crate::search::{Search, Unknown};

/// The standard deviation of the factor.
pub(super) fn sigma(response: &Response<'_>, values: &[f64]) -> Outcome {
    let Motors::Velocity(motor) = &response.drive(values).motor else {
        let what =
            "only of motors of kind \"velocity\" the speed follows from the signal in a known way".into();
        return Outcome::CannotTell(Reason::Excitation { what });
    };
    let windows = windows(response, values, motor.full_speed_m_s, motor.gain_n_s);
    let driven = windows.iter().filter(|(_, scale)| *scale > 0.0).count();
    if driven < LEAST_WINDOWS {
        let what = "stretches of twenty lags with a wheel that is driven".into();
        return Outcome::CannotTell(Reason::TooFew { what, rows: driven, least: LEAST_WINDOWS });
    }
    let lost = (values.len() as f64 / windows.len() as f64).min(0.5);
    let cost = |numbers: &[f64]| {
        let each = windows.iter().map(|(difference, scale)| {
            let variance = scale * numbers[0] * numbers[0] + 2.0 * numbers[1] * numbers[1];
            0.5 * variance.ln() + 0.5 * difference * difference / (variance * (1.0 - lost))
        });
        each.sum::<f64>() * (1.0 - lost)
    };
    let search = Search { unknowns: vec![Unknown::log(1e-5, 2.0), Unknown::log(1e-9, 1.0)], cost: &cost };
    let squares: f64 =
        windows.iter().map(|(difference, scale)| difference * difference / scale.max(1e-12)).sum();
    let sigma = (squares / windows.len() as f64).sqrt().clamp(2e-5, 1.0);
    let mut best = search.best(&[vec![sigma, 1e-7], vec![0.3 * sigma, 1e-3], vec![1e-4, 1e-2]]);
    let names = ["`motors.noise_sigma`".to_owned(), "noise of the measured place".to_owned()];
    found(&search, &mut best, (0, &names), 1.0)
}

/// The difference of ways, in m, and (V Δt)² Σ s², of each window and wheel.
fn windows(response: &Response<'_>, values: &[f64], full_speed_m_s: f64, gain_n_s: f64) -> Vec<(f64, f64)> {
    let drive = response.drive(values);
    let lag_s = drive.mass_kg / (2.0 * drive.forward_gain * gain_n_s);
    let width_s = (LAGS * lag_s).max(0.2);
    let tick_s = response.robot.tick_s;
    let mut windows = Vec::new();
    for (segment, modelled) in response.motion.segments.iter().zip(response.modelled(values)) {
        let places = places(response.motion.kind, segment, &modelled);
        let begin = response.compared_from(segment);
        let mut from = segment.times_s.partition_point(|time| *time < begin);
        for row in from + 1..segment.times_s.len() {
            let span = segment.times_s[row] - segment.times_s[from];
            if span < width_s {
                continue;
            }
            let way: [f64; 2] = std::array::from_fn(|i| places[row][i] - places[from][i]);
            let rims = [way[0] - drive.half_track_m * way[1], way[0] + drive.half_track_m * way[1]];
            for (side, rim) in rims.into_iter().enumerate() {
                let rows = from..row;
                let squares = rows.map(|row| {
                    let dt = segment.times_s[row + 1] - segment.times_s[row];
                    segment.signals[row][side].powi(2) * dt
                });
                let kept = 1.0 - lag_s / span;
                let scale = full_speed_m_s * full_speed_m_s * tick_s * kept * squares.sum::<f64>();
                if rim.is_finite() {
                    windows.push((rim, scale));
                }
            }
            from = row;
        }
    }
    windows
}

/// The distance of the measured place from the model's at each row.
fn places(kind: Kind, segment: &Segment, modelled: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut place = [0.0; 2];
    let of = |row: usize| {
        let difference: [f64; 2] = std::array::from_fn(|i| segment.measured[row][i] - modelled[row][i]);
        match kind {
            Kind::Places => difference,
            Kind::Speeds => {
                if let Some(before) = row.checked_sub(1) {
                    let dt = segment.times_s[row] - segment.times_s[before];
                    for (place, difference) in place.iter_mut().zip(difference) {
                        *place += if difference.is_finite() { difference * dt } else { 0.0 };
                    }
                }
                place
            }
        }
    };
    (0..segment.times_s.len()).map(of).collect()
}

/// A window is so many lags long, so that what crosses its ends does not matter.
const LAGS: f64 = 20.0;

const LEAST_WINDOWS: usize = 10;
