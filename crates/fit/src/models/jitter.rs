//! The jitter behind the boundaries of frames: a uniform part, the clock's noise, and strays.
//!
//! A residue is uniform in a width behind the edge, with normal noise, and with a small probability it is anything
//! within the frame: an echo that was held up. Its likelihood is the probability of the cell of its stamp. Where the
//! uniform number does not describe the residues (Kolmogorov and Smirnov's distance, or noise that is not small), a
//! width of the same scatter is the result instead, with a wide interval; then it is unknown where behind the boundary
//! the edge is.

use super::bus::median;
use crate::estimate::{Estimate, Outcome, Reason, found};
use crate::search::{Best, EDGES, Search, Unknown};
use crate::statistics::Noise;

/// The result, in frames.
pub(super) struct Jitter {
    /// The edge, the ends of its interval, and how much it moves over the log.
    pub(super) edge: [f64; 3],
    pub(super) rate: f64,
    pub(super) span: f64,
    /// Residues of echoes are from the edge to this.
    pub(super) width: f64,
    /// The tolerance beyond the edges.
    pub(super) margin: f64,
    /// The scenario's number.
    pub(super) outcome: Outcome,
    /// Whether it is uniform.
    pub(super) is_uniform: bool,
}

/// Residues by their times.
pub(super) struct Residues {
    pub(super) points: Vec<(f64, f64)>,
    /// All stamps are multiples of this.
    pub(super) step: f64,
    pub(super) frame_s: f64,
}

impl Residues {
    pub(super) fn fit(&self) -> Result<Jitter, Reason> {
        let span = self.points.last().map_or(1.0, |point| point.0).max(1.0);
        let cost = |numbers: &[f64]| self.cost(numbers, span);
        let unknowns = vec![
            Unknown::linear(-0.5, 0.5).rising(EDGES[1]),
            Unknown::log(1e-6, 1.0).rising(EDGES[2]),
            Unknown::log(1e-7, 0.3),
            Unknown::linear(-0.1, 0.1),
        ];
        let search = Search { unknowns, cost: &cost };
        let mut best = search.best(&self.starts(span));
        self.check(&best, span)?;
        let names =
            ["the frames' phase", "`link.adapter.jitter_us`", "noise of the clock", "the clock's rate"];
        let outcome = found(&search, &mut best, (1, &names.map(str::to_owned)), 1e-6 / self.frame_s);
        let edge = search.interval(&mut best, 0);
        let [from, width, sigma, rate] = best.values[..] else { return Err(nothing()) };
        let jitter = Jitter {
            edge: [from, edge.low.min(from - 0.5 * self.step), edge.high.max(from + 0.5 * self.step)],
            rate,
            span,
            width,
            margin: 4.0 * sigma + self.step,
            outcome: self.no_finer(outcome),
            is_uniform: true,
        };
        let inside = self.inside(&jitter);
        let is_uniform = self.is_uniform(&inside, &best);
        Ok(if is_uniform { jitter } else { self.of_the_same_scatter(jitter, inside) })
    }

    fn differences<'a>(&'a self, span: f64, rate: f64) -> impl Iterator<Item = f64> + 'a {
        self.points.iter().map(move |(time, residue)| residue - rate * (time / span - 0.5))
    }

    /// −log L, with the share of strays that is most likely.
    fn cost(&self, numbers: &[f64], span: f64) -> f64 {
        let (likelihoods, share) = self.mixture(numbers, span);
        likelihoods.iter().map(|likelihood| -((1.0 - share) * likelihood + share).ln()).sum()
    }

    /// The probability of each residue, and the fraction of strays, by a few steps of expectation and maximisation.
    fn mixture(&self, numbers: &[f64], span: f64) -> (Vec<f64>, f64) {
        let [edge, width, sigma, rate] = numbers else { return (Vec::new(), 1.0) };
        let noise = Noise { sigma: *sigma, half_width: 0.5 * width, step: self.step };
        let middle = edge + 0.5 * width;
        let each = self.differences(span, *rate).map(|difference| (-noise.cost(difference - middle)).exp());
        let likelihoods: Vec<f64> = each.collect();
        let n = likelihoods.len() as f64;
        let mut share = 0.02;
        for _ in 0..6 {
            let strays: f64 = likelihoods.iter().map(|one| share / ((1.0 - share) * one + share)).sum();
            share = ((strays + 0.1) / (n + 0.2)).clamp(1e-6, 1.0);
        }
        (likelihoods, share)
    }

    /// The best of a grid: edges of a uniform number are walls, which a search does not climb.
    fn starts(&self, span: f64) -> Vec<Vec<f64>> {
        let mut sorted: Vec<f64> = self.points.iter().map(|point| point.1).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        // The middle four fifths are not moved by strays.
        let (low, high) = (at(0.1), at(0.9));
        let width = (1.25 * (high - low)).max(2e-6);
        let mut starts = Vec::new();
        for share in [1.2, 1.1, 1.05, 1.0, 0.9, 0.3] {
            for noise in [0.003, 0.01, 0.04, 0.12, 0.3] {
                for aside in [-0.05, 0.0, 0.05] {
                    for rate in [0.0, self.slope(span, 0.5 * (low + high), width)] {
                        let edge = 0.5 * (low + high) + (aside - 0.5 * share) * width;
                        let start = vec![edge, share * width, noise * width, rate];
                        starts.push((self.cost(&start, span), start));
                    }
                }
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.into_iter().step_by(2).take(4).map(|(_, start)| start).collect()
    }

    /// The drift over the log of residues near the middle, by least squares.
    fn slope(&self, span: f64, middle: f64, width: f64) -> f64 {
        let near = self.points.iter().filter(|point| (point.1 - middle).abs() < width);
        let (mut n, mut time, mut residue) = (0.0, 0.0, 0.0);
        for point in near.clone() {
            (n, time, residue) = (n + 1.0, time + point.0 / span, residue + point.1);
        }
        let (time, residue) = (time / n, residue / n);
        let product: f64 = near.clone().map(|point| (point.0 / span - time) * (point.1 - residue)).sum();
        let square: f64 = near.map(|point| (point.0 / span - time).powi(2)).sum();
        if square > 0.0 { (product / square).clamp(-0.09, 0.09) } else { 0.0 }
    }

    /// Whether there are frames at all.
    fn check(&self, best: &Best, span: f64) -> Result<(), Reason> {
        let (_, share) = self.mixture(&best.values, span);
        let filled = best.values[1] + 3.5 * best.values[2];
        let gain = -best.cost / self.points.len() as f64;
        if filled > MOST_FILLED || gain < LEAST_GAIN {
            return Err(nothing());
        }
        if share > MOST_STRAYS {
            let what = format!("{:.0} % of the echoes are received at no boundary", 100.0 * share);
            return Err(Reason::NoFrames { what });
        }
        Ok(())
    }

    /// No interval is narrower than the step of the stamps.
    fn no_finer(&self, outcome: Outcome) -> Outcome {
        match outcome {
            Outcome::Estimate(Estimate { value, low, high, whole }) => {
                let half = 0.5 * self.step * self.frame_s * 1e6;
                let (low, high) = (low.min(value - half).max(0.0), high.max(value + half));
                Outcome::Estimate(Estimate { value, low, high, whole })
            }
            Outcome::CannotTell(reason) => Outcome::CannotTell(reason),
        }
    }

    /// Residues that are no strays, less the edge, in order.
    fn inside(&self, jitter: &Jitter) -> Vec<f64> {
        let (edge, margin) = (jitter.edge[0], jitter.margin.max(0.02));
        let inside = self.differences(jitter.span, jitter.rate).map(|one| one - edge);
        let mut inside: Vec<f64> =
            inside.filter(|one| *one > -margin && *one < jitter.width + margin).collect();
        inside.sort_by(f64::total_cmp);
        inside
    }

    fn is_uniform(&self, inside: &[f64], best: &Best) -> bool {
        let (width, sigma) = (best.values[1], best.values[2]);
        let scatter = width.max(3.5 * sigma);
        if scatter < SHARP.max(3.0 * self.step) {
            return true;
        }
        if sigma > MOST_NOISE * width {
            return false;
        }
        let noise = Noise { sigma, half_width: 0.5 * width, step: 0.0 };
        let n = inside.len() as f64;
        let distances = inside
            .iter()
            .enumerate()
            .map(|(i, one)| ((i as f64 + 0.5) / n - noise.distribution(one - 0.5 * width)).abs());
        distances.fold(0.0, f64::max) < 2.0 / n.sqrt() + 0.01 + 0.5 * self.step / scatter
    }

    /// A uniform number with the scatter of these.
    fn of_the_same_scatter(&self, jitter: Jitter, inside: Vec<f64>) -> Jitter {
        let n = inside.len() as f64;
        let mean = inside.iter().sum::<f64>() / n;
        let sd = (inside.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / n).sqrt();
        let at = |share: f64| inside[((inside.len() - 1) as f64 * share) as usize];
        let width = 12.0_f64.sqrt() * sd;
        let slack = 2.0 / n.sqrt();
        let low = (2.0 * (at(0.75) - at(0.25))).min(width) * (1.0 - slack).max(0.0);
        let high = (at(0.995) - at(0.005)).max(width) * (1.0 + slack);
        let to_us = self.frame_s * 1e6;
        let middle = jitter.edge[0] + mean;
        Jitter {
            edge: [middle - 0.5 * width, middle - 4.0 * sd, middle - sd],
            width,
            margin: 3.0 * sd,
            outcome: Outcome::Estimate(Estimate {
                value: width * to_us,
                low: low * to_us,
                high: high * to_us,
                whole: false,
            }),
            is_uniform: false,
            ..jitter
        }
    }
}

impl Jitter {
    /// A time of the bus less the edge there.
    pub(super) fn past_edge(&self, time: f64, log_time: f64) -> f64 {
        time - self.edge[0] - self.rate * (log_time / self.span - 0.5)
    }

    /// The boundary before a received time and what is left, if the echo is no stray.
    pub(super) fn boundary(&self, time: f64) -> Option<f64> {
        let middle = 0.5 * self.width;
        let boundary = (time - middle + 0.5).floor();
        let residue = time - boundary;
        let margin = self.margin.max(0.01);
        (residue > -margin && residue < self.width + margin).then_some(boundary)
    }
}

/// Residues about their middle, which is 0 on the circle of a frame.
pub(super) fn centred(points: &mut [(f64, f64)]) -> f64 {
    let mut residues: Vec<f64> = points.iter().map(|point| point.1).collect();
    let middle = median(&mut residues);
    for point in points {
        point.1 = super::bus::wrapped(point.1 - middle);
    }
    middle
}

fn nothing() -> Reason {
    let what = "the times at which echoes are received are spread over the whole frame".into();
    Reason::NoFrames { what }
}

/// A jitter that fills more of a frame may come from times without frames.
const MOST_FILLED: f64 = 0.75;

/// The gain in likelihood over an echo that may come at any time that one must have, as a logarithm.
const LEAST_GAIN: f64 = 0.25;

/// The fraction of strays beyond which there are no frames.
const MOST_STRAYS: f64 = 0.25;

/// Noise that is a larger share of the width hides the uniform number's edges.
const MOST_NOISE: f64 = 0.12;

/// Residues within so much of a frame have no shape.
const SHARP: f64 = 2e-3;
