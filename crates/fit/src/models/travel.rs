//! Odometers, encoders and wheels beside true poses.
//!
//! **Odometer.** Each read adds N(0, σ) to the way of each wheel. So the way along the heading and the heading differ from the
//! true ones by random walks with steps of σ²/2 and σ²/(2 h²) a read, with the half track h; poses are measured with white
//! noise besides. A way is the sum of displacements, each in the direction of its own heading: so of the noise of a position
//! the share by which the direction has turned stays, a random walk as well.
//!
//! **Wheels.** Counted turns φ of the wheels are ways r (φ_l + φ_r) / 2 and turns r (φ_r − φ_l) / (2 h). The rest are a random
//! walk (slip) and white noise (a count, and the pose).
//!
//! **Losses.** Of the marks that pass by the true motion each is lost with the same probability.

use baudbot_sim::sensor::Device;

use super::Case;
use super::compass::fresh;
use super::motion::{Pose, Wheels, along};
use crate::estimate::{Fitted, Outcome, Reason, Residuals, found};
use crate::fields::{BodyField, Field, SensorField};
use crate::log::Quantity;
use crate::search::{Search, Unknown};
use crate::statistics::Walk;

/// Fits the odometer at a place among the robot's sensors.
pub(crate) fn odometer(case: &Case<'_>, sensor: usize) -> Fitted {
    match Odometry::of(case, sensor) {
        Ok(odometry) => odometry.fit(case),
        Err(reason) => Fitted::only(case.none(&reason)),
    }
}

/// The reading of an odometer less the truth, at each of its reads that the log has.
struct Odometry {
    name: String,
    times_s: Vec<f64>,
    /// The differences of the way, in m, and of the heading, in rad.
    differences: [Vec<f64>; 2],
    /// Reads since the row before.
    reads: Vec<f64>,
    /// The robot's turns since the row before, in radians.
    turns: Vec<f64>,
    half_track_m: f64,
}

impl Odometry {
    fn of(case: &Case<'_>, sensor: usize) -> Result<Self, Reason> {
        let spec = &case.robot.model.sensors[sensor];
        let reading = |part: &str| {
            let name = format!("{}.{part}", spec.name);
            let column = case.log.reading(&name);
            column.ok_or_else(|| Reason::Columns { needs: format!("column `{name}`") })
        };
        let (x, y, heading) = (reading("x_m")?, reading("y_m")?, reading("heading_rad")?);
        let time = case.column(Quantity::Time)?;
        let pose = Pose::of(case).ok_or_else(|| Reason::Columns { needs: POSES.into() })?;
        let (truth, told) = (pose.along(), along(&x.values, &y.values, &heading.values));
        let period_s = spec.schedule.period_ns() as f64 * 1e-9;
        let rows = fresh(case, &x.values, spec);
        let rows: Vec<usize> =
            rows.into_iter().filter(|row| truth[*row][0].is_finite() && told[*row][0].is_finite()).collect();
        if rows.len() < LEAST_READS {
            let what = "reads of the odometer with a pose".into();
            return Err(Reason::TooFew { what, rows: rows.len(), least: LEAST_READS });
        }
        let times: Vec<f64> = rows.iter().map(|row| time.values[*row]).collect();
        let reads = times.windows(2).map(|pair| ((pair[1] - pair[0]) / period_s).round().max(1.0));
        Ok(Self {
            name: spec.name.clone(),
            reads: std::iter::once(0.0).chain(reads).collect(),
            differences: std::array::from_fn(|i| {
                rows.iter().map(|row| told[*row][i] - truth[*row][i]).collect()
            }),
            turns: turns(&rows.iter().map(|row| truth[*row][1]).collect::<Vec<_>>()),
            times_s: times,
            half_track_m: case.robot.model.drive.half_track_m,
        })
    }

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let cost = |numbers: &[f64]| self.cost(numbers);
        let unknowns = vec![Unknown::log(1e-9, 1.0), Unknown::log(1e-9, 1.0), Unknown::log(1e-9, 1.0)];
        let search = Search { unknowns, cost: &cost };
        let step = |i: usize| {
            let squares = self.differences[i].windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
            (squares.sum::<f64>() / self.reads.iter().sum::<f64>()).sqrt()
        };
        let sigma = (step(1) * self.half_track_m * 2.0_f64.sqrt()).max(1e-8);
        let starts = [vec![sigma, 1e-8, 1e-8], vec![0.3 * sigma, 0.5 * step(0) + 1e-9, 0.5 * step(1) + 1e-9]];
        let mut best = search.best(&starts);
        let names =
            ["`sigma_m`", "noise of the true position", "noise of the true heading"].map(str::to_owned);
        let outcome = found(&search, &mut best, (0, &names), 1.0);
        let findings = case.wanted.iter().map(|field| case.finding(*field, outcome.clone()));
        Fitted { findings: findings.collect(), residuals: self.residuals(), ..Fitted::default() }
    }

    /// −log L of σ, and the noise of true positions and headings.
    fn cost(&self, numbers: &[f64]) -> f64 {
        let variance = numbers[0] * numbers[0] / 2.0;
        let steps = [variance, variance / (self.half_track_m * self.half_track_m)];
        let noise = [numbers[1] * numbers[1], numbers[2] * numbers[2]];
        let of = |i: usize| {
            let projected = if i == 0 { noise[0] } else { 0.0 };
            let pairs = self.reads.iter().zip(&self.turns);
            let walk: Vec<f64> =
                pairs.map(|(reads, turn)| steps[i] * reads + projected * turn * turn).collect();
            Walk::new(std::iter::once((self.differences[i].as_slice(), walk.as_slice())), noise[i]).cost()
        };
        of(0) + of(1)
    }

    fn residuals(&self) -> Vec<Residuals> {
        let of = |i: usize| Residuals {
            title: format!("{}: {} less the truth", self.name, ["way", "heading"][i]),
            x: "time in s".into(),
            unit: ["m", "rad"][i].into(),
            points: self.times_s.iter().copied().zip(self.differences[i].iter().copied()).collect(),
        };
        (0..2).map(of).collect()
    }
}

/// Fits radius and half track of wheels that are counted.
pub(crate) fn wheels(case: &Case<'_>) -> Fitted {
    let Some((pose, wheels)) = Pose::of(case).zip(Wheels::of(case)) else {
        let needs = format!("{POSES} beside counts of the wheels");
        return Fitted::only(case.none(&Reason::Columns { needs }));
    };
    let rolled = Rolled::new(case, &pose.along(), &wheels);
    match rolled.enough() {
        Ok(()) => rolled.fit(case),
        Err(reason) => Fitted::only(case.none(&reason)),
    }
}

/// Ways and headings beside turns of the wheels, by segment.
struct Rolled {
    segments: Vec<RolledSegment>,
    radius_m: f64,
    half_track_m: f64,
}

#[derive(Default)]
struct RolledSegment {
    times_s: Vec<f64>,
    spans_s: Vec<f64>,
    /// The true way and heading.
    truth: [Vec<f64>; 2],
    /// (φ_l + φ_r) / 2 and (φ_r − φ_l) / 2.
    turned: [Vec<f64>; 2],
}

impl RolledSegment {
    /// Variances of the walk's steps, in units of that of the noise.
    fn steps(&self, i: usize, ratio: f64) -> Vec<f64> {
        let projected = if i == 0 { 1.0 } else { 0.0 };
        let turns = turns(&self.truth[1]);
        self.spans_s.iter().zip(turns).map(|(span, turn)| ratio * span + projected * turn * turn).collect()
    }
}

impl Rolled {
    fn new(case: &Case<'_>, truth: &[[f64; 2]], wheels: &Wheels) -> Self {
        let times = case.log.column(Quantity::Time).map(|column| column.values.as_slice());
        let of = |range: &std::ops::Range<usize>| {
            let mut segment = RolledSegment::default();
            for row in range.clone() {
                let [left, right] = wheels.turned_rad[row];
                if truth[row][0].is_nan() || left.is_nan() || right.is_nan() {
                    continue;
                }
                let time = times.map_or(row as f64, |times| times[row]);
                segment.spans_s.push(segment.times_s.last().map_or(0.0, |last| time - last));
                segment.times_s.push(time);
                for (i, turned) in [0.5 * (left + right), 0.5 * (right - left)].into_iter().enumerate() {
                    segment.truth[i].push(truth[row][i]);
                    segment.turned[i].push(turned);
                }
            }
            segment
        };
        let drive = &case.robot.model.drive;
        Self {
            segments: case.log.segments.iter().map(of).filter(|segment| segment.times_s.len() > 1).collect(),
            radius_m: drive.wheel_radius_m,
            half_track_m: drive.half_track_m,
        }
    }

    fn enough(&self) -> Result<(), Reason> {
        let rows: usize = self.segments.iter().map(|segment| segment.times_s.len()).sum();
        if rows < LEAST_READS {
            let what = "rows with a pose and counts".into();
            return Err(Reason::TooFew { what, rows, least: LEAST_READS });
        }
        Ok(())
    }

    /// The angle by which the wheels turned together, or against each other, in radians.
    fn turned(&self, i: usize) -> f64 {
        let steps =
            |segment: &RolledSegment| segment.turned[i].windows(2).map(|p| (p[1] - p[0]).abs()).sum::<f64>();
        self.segments.iter().map(steps).sum()
    }

    fn differences(&self, i: usize, factor: f64) -> Vec<Vec<f64>> {
        let of = |segment: &RolledSegment| {
            segment.truth[i]
                .iter()
                .zip(&segment.turned[i])
                .map(|(truth, turned)| truth - factor * turned)
                .collect()
        };
        self.segments.iter().map(of).collect()
    }

    fn channel(&self, i: usize, factor: f64, ratio: f64) -> f64 {
        let differences = self.differences(i, factor);
        let steps: Vec<Vec<f64>> = self.segments.iter().map(|segment| segment.steps(i, ratio)).collect();
        let parts = differences.iter().zip(&steps).map(|(d, s)| (d.as_slice(), s.as_slice()));
        Walk::new(parts, 1.0).scaled_cost()
    }

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let wants = |field| case.wants(Field::Body(field));
        let (radius_m, half_track_m) = (self.radius_m, self.half_track_m);
        let cost = |numbers: &[f64]| {
            let [radius, half_track, way, heading] = numbers else { return f64::INFINITY };
            self.channel(0, *radius, *way) + self.channel(1, radius / half_track, *heading)
        };
        let unknowns = vec![
            Unknown::positive(radius_m / 3.0, radius_m * 3.0),
            Unknown::positive(half_track_m / 3.0, half_track_m * 3.0),
            Unknown::log(1e-9, 1e9),
            Unknown::log(1e-9, 1e9),
        ];
        let search = Search { unknowns, cost: &cost };
        let (radius, ratio) = (self.slope(0), self.slope(1));
        let starts = [1e-3, 1.0, 1e3].map(|walk| vec![radius, radius / ratio, walk, walk]);
        let mut best = search.best(&starts);
        let names = ["`body.wheel_radius_m`", "`body.half_track_m`", "slip", "slip"].map(str::to_owned);
        let mut findings = Vec::new();
        for (i, field) in [BodyField::WheelRadius, BodyField::HalfTrack].into_iter().enumerate() {
            if !wants(field) {
                continue;
            }
            let what = ["the wheels do not roll forwards", "the robot does not turn"][i];
            let outcome = if self.turned(i) < LEAST_TURN_RAD || self.turned(0) < LEAST_TURN_RAD {
                Outcome::CannotTell(Reason::Excitation { what: what.into() })
            } else {
                found(&search, &mut best, (i, &names), 1.0)
            };
            findings.push(case.finding(Field::Body(field), outcome));
        }
        let factors = [best.values[0], best.values[0] / best.values[1]];
        Fitted { findings, residuals: self.residuals(factors), ..Fitted::default() }
    }

    /// The slope of the truth over the turns, by ordinary least squares of their steps over many rows.
    fn slope(&self, i: usize) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        for segment in &self.segments {
            let width = (segment.times_s.len() / 20).max(1);
            for from in (0..segment.times_s.len().saturating_sub(width)).step_by(width) {
                let turned = segment.turned[i][from + width] - segment.turned[i][from];
                product += turned * (segment.truth[i][from + width] - segment.truth[i][from]);
                square += turned * turned;
            }
        }
        let nominal = [self.radius_m, self.radius_m / self.half_track_m][i];
        let slope = product / square;
        if slope.is_finite() && slope > 0.0 { slope } else { nominal }
    }

    fn residuals(&self, factors: [f64; 2]) -> Vec<Residuals> {
        let of = |i: usize| {
            let differences = self.differences(i, factors[i]);
            let points = self.segments.iter().zip(differences).flat_map(|(segment, differences)| {
                let first = differences.first().copied().unwrap_or_default();
                let points = segment.times_s.iter().copied().zip(differences);
                points.map(move |(time, difference)| (time, difference - first)).collect::<Vec<_>>()
            });
            Residuals {
                title: format!("true {} less that of the wheels", ["way", "heading"][i]),
                x: "time in s".into(),
                unit: ["m", "rad"][i].into(),
                points: points.collect(),
            }
        };
        (0..2).map(of).collect()
    }
}

/// Turns since the heading before.
fn turns(headings: &[f64]) -> Vec<f64> {
    std::iter::once(0.0).chain(headings.windows(2).map(|pair| pair[1] - pair[0])).collect()
}

/// Fits the share of marks that encoders lose.
pub(crate) fn losses(case: &Case<'_>, sensor: usize) -> Fitted {
    Fitted::only(case.none_or(loss(case, sensor)))
}

fn loss(case: &Case<'_>, sensor: usize) -> Result<Outcome, Reason> {
    let spec = &case.robot.model.sensors[sensor];
    let Device::Encoders(_) = &spec.device else { return Err(Reason::Columns { needs: "encoders".into() }) };
    let pose = Pose::of(case).ok_or_else(|| Reason::Columns { needs: POSES.into() })?;
    let wheels = Wheels::of(case).filter(|wheels| wheels.sensor == sensor);
    let wheels = wheels
        .ok_or_else(|| Reason::Columns { needs: format!("columns `{0}.left` and `{0}.right`", spec.name) })?;
    let drive = &case.robot.model.drive;
    let truth = pose.along();
    let rows: Vec<usize> = (0..truth.len())
        .filter(|row| truth[*row][0].is_finite() && wheels.turned_rad[*row][0].is_finite())
        .collect();
    // True marks and counted ones of both wheels.
    let (mut passed, mut counted) = (0.0, 0.0);
    for pair in rows.windows(2) {
        let step: [f64; 2] = std::array::from_fn(|i| truth[pair[1]][i] - truth[pair[0]][i]);
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let way = step[0] + sign * drive.half_track_m * step[1];
            passed += way.abs() / (drive.wheel_radius_m * wheels.count_rad);
            let turned = wheels.turned_rad[pair[1]][side] - wheels.turned_rad[pair[0]][side];
            counted += turned.abs() / wheels.count_rad;
        }
    }
    if passed < LEAST_MARKS {
        let what = "marks that pass by the true motion".into();
        return Err(Reason::TooFew { what, rows: passed as usize, least: LEAST_MARKS as usize });
    }
    let lost = passed - counted;
    let cost = |numbers: &[f64]| {
        let p = numbers[0];
        // Binomial, and a mark at each end of each wheel's way.
        let variance = passed * p * (1.0 - p) + 4.0 / 12.0;
        0.5 * variance.ln() + 0.5 * (lost - passed * p).powi(2) / variance
    };
    let search = Search { unknowns: vec![Unknown::log(1e-9, 0.9)], cost: &cost };
    let mut best = search.best(&[vec![(lost / passed).clamp(1e-8, 0.8)]]);
    Ok(found(&search, &mut best, (0, &["`loss`".to_owned()]), 1.0))
}

impl Case<'_> {
    /// The same outcome of all wanted fields.
    fn none_or(&self, outcome: Result<Outcome, Reason>) -> Vec<crate::estimate::Finding> {
        let outcome = outcome.unwrap_or_else(Outcome::CannotTell);
        self.wanted.iter().map(|field| self.finding(*field, outcome.clone())).collect()
    }
}

/// The field for the number of marks that encoders lose.
pub(crate) const LOSS: SensorField = SensorField::Loss;

const POSES: &str = "true poses: columns `x_m`, `y_m` and `heading_rad`";

const LEAST_READS: usize = 30;

/// The least turn of wheels for a result, in radians.
const LEAST_TURN_RAD: f64 = 1.0;

const LEAST_MARKS: f64 = 200.0;
