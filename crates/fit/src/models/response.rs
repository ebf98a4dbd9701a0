//! A robot's response to its commands: dead time, lag and full speed.
//!
//! The motion is that of the simulator's own drive ([`Drive::step`]), in its Euler steps, with each command obeyed the dead
//! time after its row. Within a step the signals are the mean of those that are in force. Left and right motor may differ by
//! a factor, and the half track may be another than the scenario's; both are searched besides.
//!
//! Measured speeds differ from the model's by noise that is correlated from row to row (autoregressive, of first order);
//! measured places by a random walk and white noise. The sizes of both are the most likely ones.
//!
//! *Deviation.* Another half track changes B of (2.30) in proportion, as if the wheels had no inertia.

use baudbot_geometry::Pose;
use baudbot_sim::drive::{Drive, Wheels};
use baudbot_sim::motor::Motors;

use super::commands::Commands;
use super::motion::{Kind, Motion, Segment};
use super::{Case, Robot};
use crate::estimate::{Estimate, Finding, Fitted, Outcome, Reason, Residuals, found};
use crate::fields::{BodyField, Field, MotorField};
use crate::search::{Best, Search, Unknown};
use crate::statistics::{Walk, autoregressive};

/// The numbers of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    /// The regulator's gain, or the servo's lag.
    Lag,
    DeadTime,
    FullSpeed,
    /// The difference of the right motor's speed to the mean.
    Asymmetry,
    HalfTrack,
    /// Variance of the random walk's step in a second over that of the noise, along the way and of the heading.
    Walk(usize),
}

/// Fits motors, and the half track where only commands determine it.
pub(crate) fn fit(case: &Case<'_>) -> Fitted {
    match Motion::of(case) {
        Ok(motion) if !motion.is_driven() => {
            let reason = Reason::Excitation { what: "all commands are 0".into() };
            Fitted::only(case.none(&reason))
        }
        Ok(motion) => Response::new(case, motion).fit(case),
        Err(reason) => Fitted::only(case.none(&reason)),
    }
}

/// A motion and the model of it.
pub(super) struct Response<'a> {
    pub(super) robot: Robot<'a>,
    pub(super) motion: Motion,
    numbers: Vec<Number>,
}

impl<'a> Response<'a> {
    fn new(case: &Case<'a>, motion: Motion) -> Self {
        let mut numbers = vec![Number::DeadTime, Number::Asymmetry, Number::HalfTrack];
        match &case.robot.model.drive.motor {
            Motors::Velocity(_) => numbers.extend([Number::Lag, Number::FullSpeed]),
            Motors::Servo(_) => numbers.push(Number::Lag),
            Motors::Dc(_) | Motors::Stepper(_) => {}
        }
        if motion.kind == Kind::Places {
            numbers.extend([Number::Walk(0), Number::Walk(1)]);
        }
        Self { robot: case.robot, motion, numbers }
    }

    fn value(&self, values: &[f64], number: Number) -> Option<f64> {
        Some(values[self.numbers.iter().position(|known| *known == number)?])
    }

    /// The drive with these numbers.
    pub(super) fn drive(&self, values: &[f64]) -> Drive {
        let mut drive = self.robot.model.drive.clone();
        if let Some(half_track_m) = self.value(values, Number::HalfTrack) {
            drive.turn_gain *= half_track_m / drive.half_track_m;
            drive.half_track_m = half_track_m;
        }
        let (lag, full) = (self.value(values, Number::Lag), self.value(values, Number::FullSpeed));
        match &mut drive.motor {
            Motors::Velocity(motor) => {
                motor.gain_n_s = lag.unwrap_or(motor.gain_n_s);
                motor.full_speed_m_s = full.unwrap_or(motor.full_speed_m_s);
            }
            Motors::Servo(servo) => servo.lag_s = lag.unwrap_or(servo.lag_s),
            Motors::Dc(_) | Motors::Stepper(_) => {}
        }
        drive
    }

    /// The model's motion in place of the measured one, segment by segment.
    pub(super) fn modelled(&self, values: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let drive = self.drive(values);
        let dead_s = self.value(values, Number::DeadTime).unwrap_or_default();
        let asymmetry = self.value(values, Number::Asymmetry).unwrap_or_default();
        let of = |segment: &Segment| self.run(&drive, segment, dead_s, asymmetry);
        self.motion.segments.iter().map(of).collect()
    }

    fn run(&self, drive: &Drive, segment: &Segment, dead_s: f64, asymmetry: f64) -> Vec<[f64; 2]> {
        let [speed, turn] = self.start(segment);
        let mut motion = drive.place(Pose::default(), speed, turn);
        let first =
            segment.measured.iter().find(|measured| measured[0].is_finite()).copied().unwrap_or_default();
        let mut place = first;
        let mut commands = Commands::new(segment);
        let mut modelled = Vec::with_capacity(segment.times_s.len());
        for (row, &time) in segment.times_s.iter().enumerate() {
            modelled.push(match self.motion.kind {
                Kind::Speeds => [motion.speed_m_s, motion.turn_rate_rad_s],
                Kind::Places => place,
            });
            let Some(next) = segment.times_s.get(row + 1) else { break };
            let steps = ((next - time) / self.robot.substep_s).round().max(1.0);
            let dt = (next - time) / steps;
            for step in 0..steps as u32 {
                let from = time + f64::from(step) * dt - dead_s;
                let [left, right] = commands.mean(from, from + dt);
                let signals = Wheels { left: left * (1.0 - asymmetry), right: right * (1.0 + asymmetry) };
                motion = drive.step(&motion, signals, None, dt);
                place[0] += motion.speed_m_s * dt;
                place[1] += motion.turn_rate_rad_s * dt;
            }
        }
        modelled
    }

    /// The speeds at the start of a segment: as measured, or the mean ones of the first moments.
    fn start(&self, segment: &Segment) -> [f64; 2] {
        let mut known = segment.measured.iter().zip(&segment.times_s).filter(|(m, _)| m[0].is_finite());
        let Some((first, from)) = known.next() else { return [0.0; 2] };
        match self.motion.kind {
            Kind::Speeds => *first,
            Kind::Places if segment.signals[0] == [0.0; 2] => [0.0; 2],
            Kind::Places => match known.find(|(_, time)| **time - from >= START_S) {
                Some((last, to)) => [0, 1].map(|i| (last[i] - first[i]) / (to - from)),
                None => [0.0; 2],
            },
        }
    }

    /// The instant from which on the motion is compared: errors of the first speeds do not matter then.
    pub(super) fn compared_from(&self, segment: &Segment) -> f64 {
        let (Some(first), Some(last)) = (segment.times_s.first(), segment.times_s.last()) else { return 0.0 };
        let settles = last - first > 5.0 * SETTLED_S;
        if settles { first + SETTLED_S } else { *first }
    }

    fn cost(&self, values: &[f64]) -> f64 {
        let modelled = self.modelled(values);
        (0..2).map(|channel| self.channel_cost(&modelled, channel, values)).sum()
    }

    pub(super) fn channel_cost(&self, modelled: &[Vec<[f64; 2]>], channel: usize, values: &[f64]) -> f64 {
        let of = |(segment, modelled): (&Segment, &Vec<[f64; 2]>)| {
            let (mut times, mut turns) = (Vec::with_capacity(modelled.len()), Vec::new());
            let mut heading = f64::NAN;
            let mut differences = Vec::with_capacity(modelled.len());
            let from = self.compared_from(segment);
            for (row, measured) in segment.measured.iter().enumerate() {
                if measured[channel].is_finite() && segment.times_s[row] >= from {
                    times.push(segment.times_s[row]);
                    // A way is projected on headings: as these turn, some of a position's noise stays.
                    let turn = if channel == 0 && !heading.is_nan() { measured[1] - heading } else { 0.0 };
                    turns.push(turn * turn);
                    heading = measured[1];
                    differences.push(measured[channel] - modelled[row][channel]);
                }
            }
            (times, turns, differences)
        };
        let parts: Vec<_> = self.motion.segments.iter().zip(modelled).map(of).collect();
        match self.value(values, Number::Walk(channel)) {
            Some(ratio) => {
                let steps: Vec<Vec<f64>> =
                    parts.iter().map(|(times, turns, _)| steps(times, turns, ratio)).collect();
                let parts = parts.iter().zip(&steps).map(|((_, _, d), s)| (d.as_slice(), s.as_slice()));
                Walk::new(parts, 1.0).scaled_cost()
            }
            None => autoregressive(parts.iter().map(|(_, _, differences)| differences.as_slice())),
        }
    }

    fn fit(&self, case: &Case<'_>) -> Fitted {
        let cost = |values: &[f64]| self.cost(values);
        let unknowns: Vec<_> = self.numbers.iter().map(|number| self.unknown(*number)).collect();
        let search = Search { unknowns, cost: &cost };
        let mut best = search.best(&self.starts(&search));
        let names: Vec<_> = self.numbers.iter().map(|number| self.name(*number)).collect();
        let judged = self.judge(&best.values);
        if let Some(reason) = judged.reason {
            let residuals = self.residuals(&best.values);
            return Fitted { findings: case.none(&reason), residuals, remarks: judged.remarks };
        }
        let mut fitted = Fitted { remarks: judged.remarks, ..Fitted::default() };
        let place = self.numbers.iter().position(|number| *number == Number::Lag);
        let apart = place.and_then(|place| self.apart(&search, &best, place));
        fitted.remarks.extend(apart.as_ref().map(|apart| apart.remark.clone()));
        for field in case.wanted {
            let mut outcome = self.outcome(case, *field, &search, &mut best, &names);
            if let Some(apart) = &apart {
                outcome = apart.widened(*field, outcome);
            }
            if let (Field::Motors(MotorField::Gain), Outcome::Estimate(gain)) = (field, &outcome) {
                fitted.findings.push(self.lag(gain));
            }
            fitted.findings.push(case.finding(*field, outcome));
        }
        fitted.residuals = self.residuals(&best.values);
        fitted
    }

    fn outcome(
        &self,
        case: &Case<'_>,
        field: Field,
        search: &Search<'_>,
        best: &mut Best,
        names: &[String],
    ) -> Outcome {
        let (number, unit) = match field {
            Field::Motors(MotorField::DeadTime) => (Number::DeadTime, 1e-3),
            Field::Motors(MotorField::Gain) => (Number::Lag, 1.0),
            Field::Motors(MotorField::Lag) => (Number::Lag, 1e-3),
            Field::Motors(MotorField::FullSpeed) => (Number::FullSpeed, 1.0),
            Field::Body(BodyField::HalfTrack) => (Number::HalfTrack, 1.0),
            Field::Motors(MotorField::NoiseSigma) => return super::uneven::sigma(self, &best.values),
            Field::Motors(MotorField::NoiseSpread) => {
                return Outcome::CannotTell(Reason::Specimens { there_are: 1 });
            }
            Field::Body(BodyField::WheelRadius) => {
                let with = "`motors.full_speed_m_s`: commands and motion alone determine only the rim's speed; log counts of the wheels";
                return Outcome::CannotTell(Reason::Confounded { with: with.into() });
            }
            Field::Adapter(_) | Field::Sensor(..) => {
                return Outcome::CannotTell(Reason::Columns { needs: "model".into() });
            }
        };
        let Some(place) = self.numbers.iter().position(|known| *known == number) else {
            let needs = format!("`{}` that these motors have", field.path(case.robot.model));
            return Outcome::CannotTell(Reason::Columns { needs });
        };
        if self.motion.changes() == 0 && matches!(number, Number::DeadTime | Number::Lag) {
            return Outcome::CannotTell(Reason::Excitation { what: "the command never changes".into() });
        }
        let outcome = found(search, best, (place, names), unit);
        // The robot obeys at ticks: a dead time is no finer than that.
        let half = if number == Number::DeadTime { 0.5 * self.robot.tick_s / unit } else { 0.0 };
        outcome.wider(half)
    }

    fn unknown(&self, number: Number) -> Unknown {
        let drive = &self.robot.model.drive;
        match (number, &drive.motor) {
            (Number::Lag, Motors::Velocity(motor)) => {
                Unknown::positive(motor.gain_n_s / 100.0, motor.gain_n_s * self.most_gain())
            }
            (Number::Lag, _) => Unknown::positive(1e-3, 2.0),
            (Number::DeadTime, _) => Unknown::linear(0.0, LONGEST_DEAD_S),
            (Number::FullSpeed, Motors::Velocity(motor)) => {
                Unknown::positive(motor.full_speed_m_s / 10.0, motor.full_speed_m_s * 10.0)
            }
            (Number::FullSpeed, _) => Unknown::positive(1e-3, 10.0),
            (Number::Asymmetry, _) => Unknown::linear(-0.5, 0.5),
            (Number::HalfTrack, _) => Unknown::positive(drive.half_track_m / 4.0, drive.half_track_m * 4.0),
            (Number::Walk(_), _) => Unknown::log(1e-9, 1e9),
        }
    }

    /// The largest factor on the scenario's gain before Euler's steps swing: 2 A K Δt / M < 1.
    fn most_gain(&self) -> f64 {
        let drive = &self.robot.model.drive;
        let share = |gain: f64| 2.0 * drive.forward_gain * gain * self.robot.substep_s / drive.mass_kg;
        match &drive.motor {
            Motors::Velocity(motor) => (1.0 / share(motor.gain_n_s)).clamp(1.5, 100.0),
            Motors::Dc(_) | Motors::Servo(_) | Motors::Stepper(_) => 100.0,
        }
    }

    fn name(&self, number: Number) -> String {
        let text = match (number, &self.robot.model.drive.motor) {
            (Number::Lag, Motors::Servo(_)) => "`motors.lag_ms`",
            (Number::Lag, _) => "`motors.gain_n_s`",
            (Number::DeadTime, _) => "`motors.dead_time_ms`",
            (Number::FullSpeed, _) => "`motors.full_speed_m_s`",
            (Number::Asymmetry, _) => "a difference of the motors",
            (Number::HalfTrack, _) => "`body.half_track_m`",
            (Number::Walk(_), _) => "noise of the motion",
        };
        text.to_owned()
    }

    /// The two best of a grid of dead times and lags.
    fn starts(&self, search: &Search<'_>) -> Vec<Vec<f64>> {
        let mut starts = Vec::new();
        for dead_s in [0.005, 0.03, 0.07, 0.12, 0.2, 0.3, 0.5] {
            for lag in [0.25, 0.5, 1.0, 3.0] {
                let of = |number: &Number| match (number, &self.robot.model.drive.motor) {
                    (Number::DeadTime, _) => dead_s,
                    (Number::Lag, Motors::Velocity(motor)) => motor.gain_n_s * lag,
                    (Number::Lag, _) => 0.05 / lag,
                    (Number::FullSpeed, Motors::Velocity(motor)) => motor.full_speed_m_s * self.speed_ratio(),
                    (Number::HalfTrack, _) => self.robot.model.drive.half_track_m,
                    (Number::Asymmetry | Number::FullSpeed, _) => 0.0,
                    (Number::Walk(_), _) => 1.0,
                };
                let start: Vec<f64> = self.numbers.iter().map(of).collect();
                starts.push(((search.cost)(&start), start));
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.into_iter().take(2).map(|(_, start)| start).collect()
    }

    /// The ratio of the driven way to the commanded one, by the scenario.
    fn speed_ratio(&self) -> f64 {
        let Motors::Velocity(motor) = &self.robot.model.drive.motor else { return 1.0 };
        let (mut driven, mut asked) = (0.0, 0.0);
        for segment in &self.motion.segments {
            for (row, span) in segment.times_s.windows(2).enumerate() {
                let way = match self.motion.kind {
                    Kind::Speeds => segment.measured[row][0] * (span[1] - span[0]),
                    Kind::Places => segment.measured[row + 1][0] - segment.measured[row][0],
                };
                let signals = segment.signals[row];
                let share = 0.5 * (signals[0] + signals[1]);
                driven += if way.is_finite() { way * share } else { 0.0 };
                asked += motor.full_speed_m_s * share * share * (span[1] - span[0]);
            }
        }
        let ratio = driven / asked;
        if ratio.is_finite() { ratio.clamp(0.11, 9.0) } else { 1.0 }
    }

    /// The lag in ms of a gain, or of a servo's lag.
    pub(super) fn lag_ms(&self, number: f64) -> f64 {
        let drive = &self.robot.model.drive;
        match &drive.motor {
            Motors::Servo(_) => 1e3 * number,
            Motors::Velocity(_) | Motors::Dc(_) | Motors::Stepper(_) => {
                1e3 * drive.mass_kg / (2.0 * drive.forward_gain * number)
            }
        }
    }

    /// M / (2 A K), which shrinks as the gain grows.
    fn lag(&self, gain: &Estimate) -> Finding {
        let [value, low, high] = [gain.value, gain.high, gain.low].map(|gain| self.lag_ms(gain));
        let lag = Estimate { value, low, high, whole: false };
        Finding { path: "lag of the motors, in ms".into(), is_field: false, outcome: Outcome::Estimate(lag) }
    }

    fn residuals(&self, values: &[f64]) -> Vec<Residuals> {
        let modelled = self.modelled(values);
        let (units, names) = match self.motion.kind {
            Kind::Speeds => (["m/s", "rad/s"], ["forward speed", "turn rate"]),
            Kind::Places => (["m", "rad"], ["way", "heading"]),
        };
        let of = |channel: usize| {
            let pairs = self.motion.segments.iter().zip(&modelled).flat_map(|(segment, modelled)| {
                let rows = segment.measured.iter().zip(modelled).zip(&segment.times_s);
                rows.map(|((measured, modelled), time)| (*time, measured[channel] - modelled[channel]))
            });
            Residuals {
                title: format!("{}: measured less the model", names[channel]),
                x: "time in s".into(),
                unit: units[channel].into(),
                points: pairs.filter(|(_, difference)| difference.is_finite()).collect(),
            }
        };
        (0..2).map(of).collect()
    }
}

/// Variances of a walk's steps, in units of that of the noise.
fn steps(times: &[f64], turns: &[f64], ratio: f64) -> Vec<f64> {
    let spans = std::iter::once(0.0).chain(times.windows(2).map(|pair| pair[1] - pair[0]));
    spans.zip(turns).map(|(span, turn)| ratio * span + turn).collect()
}

const LONGEST_DEAD_S: f64 = 1.0;

/// The time over which the first speeds are measured.
const START_S: f64 = 0.2;

/// The time after which they do not matter.
const SETTLED_S: f64 = 1.0;
