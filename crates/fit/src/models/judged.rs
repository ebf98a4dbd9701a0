//! The judgement of a response by its log: the fraction that it explains, and whether both motions ask for the same lag.

use super::motion::{Kind, Segment};
use super::response::Response;
use crate::estimate::{Estimate, Outcome, Reason, Remark, digits};
use crate::fields::{Field, MotorField};
use crate::search::{Best, Search};

/// The remarks on a fit, and the reason for telling nothing if it is too bad.
pub(super) struct Judged {
    pub(super) remarks: Vec<Remark>,
    pub(super) reason: Option<Reason>,
}

/// Lags that do not agree.
pub(super) struct Apart {
    pub(super) remark: Remark,
    /// The two lags of the search.
    lags: [f64; 2],
}

impl Response<'_> {
    /// The fraction of the motion that the model explains, by speeds over [`WINDOW_S`].
    pub(super) fn judge(&self, values: &[f64]) -> Judged {
        let modelled = self.modelled(values);
        let mut judged = Judged { remarks: Vec::new(), reason: None };
        for (channel, (of, unit)) in
            [("forward speed", "m/s"), ("turn rate", "rad/s")].into_iter().enumerate()
        {
            let asked = self.asked(channel);
            let pairs = self.motion.segments.iter().zip(&modelled);
            let speeds: Vec<[f64; 2]> =
                pairs.flat_map(|(segment, modelled)| self.speeds(segment, modelled, channel)).collect();
            if speeds.len() < LEAST_WINDOWS || asked.is_none() {
                continue;
            }
            let n = speeds.len() as f64;
            // If the command hardly changes, all the motion is to be explained; else its difference from its mean.
            let varies = asked == Some(true);
            let mean = if varies { speeds.iter().map(|speed| speed[0]).sum::<f64>() / n } else { 0.0 };
            let all = speeds.iter().map(|speed| (speed[0] - mean).powi(2)).sum::<f64>();
            let rest = speeds.iter().map(|speed| (speed[0] - speed[1]).powi(2)).sum::<f64>();
            let explained = if all > 0.0 { 1.0 - rest / all } else { 0.0 };
            judged.remarks.push(Remark::Rest {
                of,
                rms: (rest / n).sqrt(),
                unit,
                explained: explained.max(0.0),
            });
            if explained < LEAST_EXPLAINED {
                let share = digits(100.0 * explained.max(0.0), 2);
                let what = format!(
                    "commands explain {share} % of the {of}'s variance; are units, signs and clocks right?"
                );
                judged.reason = judged.reason.or(Some(Reason::Misfit { what }));
            }
        }
        judged
    }

    /// Whether commands ask for a motion that varies; nothing if they ask for none.
    fn asked(&self, channel: usize) -> Option<bool> {
        let of =
            |[left, right]: &[f64; 2]| if channel == 0 { 0.5 * (left + right) } else { 0.5 * (right - left) };
        let asked: Vec<f64> =
            self.motion.segments.iter().flat_map(|segment| segment.signals.iter().map(of)).collect();
        let n = asked.len() as f64;
        let mean = asked.iter().sum::<f64>() / n;
        let square = asked.iter().map(|one| one * one).sum::<f64>() / n;
        let spread = (square - mean * mean).max(0.0).sqrt();
        (square.sqrt() > LEAST_ASKED).then_some(spread > 0.1 * square.sqrt())
    }

    /// Mean speeds over windows: measured and of the model.
    fn speeds(&self, segment: &Segment, modelled: &[[f64; 2]], channel: usize) -> Vec<[f64; 2]> {
        let from = self.compared_from(segment);
        let mut speeds = Vec::new();
        let (mut start, mut sums, mut count) = (None::<(f64, [f64; 2])>, [0.0; 2], 0.0);
        for ((&time, measured), modelled) in segment.times_s.iter().zip(&segment.measured).zip(modelled) {
            let now = [measured[channel], modelled[channel]];
            if time < from || !now[0].is_finite() {
                continue;
            }
            let Some((begin, first)) = start else {
                start = Some((time, now));
                continue;
            };
            sums = [sums[0] + now[0], sums[1] + now[1]];
            count += 1.0;
            let span = time - begin;
            if span >= WINDOW_S {
                speeds.push(match self.motion.kind {
                    Kind::Speeds => sums.map(|sum| sum / count),
                    Kind::Places => [0, 1].map(|i| (now[i] - first[i]) / span),
                });
                (start, sums, count) = (Some((time, now)), [0.0; 2], 0.0);
            }
        }
        speeds
    }

    /// The lags that the motion ahead and the turning ask for on their own, if they do not agree.
    pub(super) fn apart(&self, search: &Search<'_>, best: &Best, place: usize) -> Option<Apart> {
        let unknown = &search.unknowns[place];
        let at = unknown.share(best.values[place]);
        let alone = |channel: usize| {
            let cost = |share: f64| {
                let mut values = best.values.clone();
                values[place] = unknown.at(share);
                self.channel_cost(&self.modelled(&values), channel, &values)
            };
            let (share, least) = least(&cost, (at - REACH).max(0.0), (at + REACH).min(1.0));
            (unknown.at(share), cost(at) - least)
        };
        let [(ahead, gain_ahead), (turning, gain_turning)] = [alone(0), alone(1)];
        let ratio = ahead / turning;
        let is_apart =
            gain_ahead + gain_turning > LEAST_GAIN && !(1.0 / MOST_RATIO..MOST_RATIO).contains(&ratio);
        is_apart.then(|| Apart {
            remark: Remark::Lags { ahead_ms: self.lag_ms(ahead), turning_ms: self.lag_ms(turning) },
            lags: [ahead, turning],
        })
    }
}

impl Apart {
    /// An outcome that spans both.
    pub(super) fn widened(&self, field: Field, outcome: Outcome) -> Outcome {
        let unit = match field {
            Field::Motors(MotorField::Gain) => 1.0,
            Field::Motors(MotorField::Lag) => 1e-3,
            Field::Motors(_) | Field::Adapter(_) | Field::Sensor(..) | Field::Body(_) => return outcome,
        };
        match outcome {
            Outcome::Estimate(one) => Outcome::Estimate(Estimate {
                low: self.lags.iter().fold(one.low, |low, lag| low.min(lag / unit)),
                high: self.lags.iter().fold(one.high, |high, lag| high.max(lag / unit)),
                ..one
            }),
            Outcome::CannotTell(reason) => Outcome::CannotTell(reason),
        }
    }
}

/// The place between two numbers at which a cost is least, by golden sections, and the least cost.
fn least(cost: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    let golden = 0.618_033_988_749_895;
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut cost_a, mut cost_b) = (cost(a), cost(b));
    for _ in 0..14 {
        if cost_a < cost_b {
            (high, b, cost_b) = (b, a, cost_a);
            a = high - golden * (high - low);
            cost_a = cost(a);
        } else {
            (low, a, cost_a) = (a, b, cost_b);
            b = low + golden * (high - low);
            cost_b = cost(b);
        }
    }
    if cost_a < cost_b { (a, cost_a) } else { (b, cost_b) }
}

/// Noise of a place hardly shows in a speed over this time, and a robot's lag does.
const WINDOW_S: f64 = 0.5;

const LEAST_WINDOWS: usize = 10;

/// A motion of which commands ask less than this share of the full signal is not judged.
const LEAST_ASKED: f64 = 0.01;

/// A model must explain so much of a motion.
const LEAST_EXPLAINED: f64 = 0.5;

/// The reach, as a fraction of the range, of the search for a motion's own lag.
const REACH: f64 = 0.3;

/// Lags disagree if they are so many times apart, …
const MOST_RATIO: f64 = 1.25;

/// … and explain the log so much better, as a logarithm.
const LEAST_GAIN: f64 = 10.0;
