//! Dead reckoning: where the wheels have taken the robot. Wahde 2016, §2.1, Eqs. (2.5) to (2.9).
//!
//! Between two readings the wheels went l and r metres. With half the track R
//!
//! ```text
//! d = (l + r) / 2    Δφ = (r − l) / 2R    μ = φ + Δφ / 2
//! x' = x + c cos μ   y' = y + c sin μ     φ' = φ + Δφ      c = d sin(Δφ/2) / (Δφ/2)
//! ```
//!
//! The ways' errors are independent, with variances k |l| and k |r|. With F the derivative of the new pose by
//! the old one and G that by the ways, the covariance becomes F Σ Fᵀ + G diag(k |l|, k |r|) Gᵀ.
//!
//! *Deviations.*
//!
//! - The notes leave open how the integrals (2.7) to (2.9) are computed. This is the midpoint rule, but with
//!   the chord c of the arc in place of its length d. So it is exact if the speeds were constant, however
//!   long ago the last reading was.
//! - The notes say that the error grows, not how. G neglects that c differs from d. Only what is independent
//!   from metre to metre is in k: a wheel that is larger than its data sheet says makes an error of another kind,
//!   which grows faster, so take k larger than the wheels' noise. Errors of that kind are measured once and taken out by a
//!   [`Calibration`].
//!
//! The scan of a laser arrives late, and says where the robot was when it was taken. Therefore the last
//! poses are kept: [`Odometry::at`] looks one up and [`Odometry::correct`] corrects it, and all that came after. What came before
//! moves with it, so that another scan, which began earlier, still knows how the robot went.

mod arrivals;
mod step;
#[cfg(test)]
mod tests;
mod track;

use std::collections::VecDeque;
use std::f64::consts::TAU;

use baudbot_brain::{Body, Encoding, SensorKind, Turn};
use baudbot_geometry::{Pose, math};

use crate::awaited::Awaited;
use crate::estimate::Estimate;
use arrivals::Arrivals;
use step::Step;
pub use track::Track;

/// The necessary knowledge of the wheels, and the length of the memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Half the distance between the wheels, R of (2.6), in metres.
    pub half_track_m: f64,
    /// Way of the left and of the right wheel from one count to the next, in metres.
    pub m_per_count: [f64; 2],
    /// Counts after which a counter begins again, a power of 2 on the wire; `None` if it never does.
    pub modulus: Option<f64>,
    /// Variance of the error of a wheel's way, in square metres, for each metre that it goes.
    pub variance_m2_per_m: f64,
    /// The length of the memory of poses, in nanoseconds: those of readings, and those that were corrected.
    pub past_ns: u64,
    /// The robot's calibration: its deviations from the above.
    pub calibration: Calibration,
}

/// The result of a calibration such as UMBmark (Borenstein & Feng 1996): the factors by which a robot differs from
/// its data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// c_l and c_r: diameters of the left and of the right wheel, as multiples of the data sheet's.
    pub wheels: [f64; 2],
    /// E_b: distance between the wheels, as a multiple of the data sheet's.
    pub track: f64,
}

impl Calibration {
    /// A robot without deviations from its data sheet.
    pub const NONE: Self = Self { wheels: [1.0; 2], track: 1.0 };
}

/// The pose of the robot by its wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometry {
    parameters: Parameters,
    /// The newest last; never empty.
    past: VecDeque<Past>,
    /// The instant that was corrected last. No earlier one can be.
    corrected_ns: u64,
    last: Option<Last>,
    arrivals: Arrivals,
}

/// An instant, the pose at it, and the way that led there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Past {
    at_ns: u64,
    step: Step,
    estimate: Estimate,
}

/// An instant of the past.
enum Place<'a> {
    /// The instant of this estimate, or one later than all of them.
    At(&'a Estimate),
    /// An instant between these two.
    Between(&'a Past, &'a Past),
}

/// The last reading, to which the next one is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Last {
    Counts([f64; 2]),
    Odometer(Pose),
}

impl Parameters {
    /// The `Parameters` of a body with the encoders of this name, or with the odometer; `None` if there is no such
    /// sensor, or its data sheet does not state what it counts, as that of a step counter. No data sheet states how
    /// good the wheels are: here they err by a centimetre after a metre.
    #[must_use]
    pub fn of(body: &Body, sensor: &str) -> Option<Self> {
        let sensor = body.sensor(sensor)?;
        let counts = if sensor.kind == SensorKind::Odometer { 1 } else { sensor.counts_per_turn? };
        let modulus = match sensor.components.first()?.encoding {
            Encoding::Counter { bits } => Some((1_u64 << bits.min(32)) as f64),
            Encoding::Float64 | Encoding::Level { .. } | Encoding::Signed { .. } => None,
        };
        Some(Self {
            half_track_m: body.half_track_m,
            m_per_count: [TAU * body.wheel_radius_m / f64::from(counts); 2],
            modulus,
            variance_m2_per_m: 1e-4,
            past_ns: PAST_NS,
            calibration: Calibration::NONE,
        })
    }
}

impl Odometry {
    /// Starts with this estimate. Readings are compared with the first one to come.
    #[must_use]
    pub fn new(parameters: Parameters, at_ns: u64, start: Estimate) -> Self {
        let past = VecDeque::from([Past { at_ns, step: Step::default(), estimate: start }]);
        Self { parameters, past, corrected_ns: at_ns, last: None, arrivals: Arrivals::default() }
    }

    /// Starts when this sensor, encoders or an odometer, has its first reading: at a pose that is known, or at the
    /// odometer's pose. `None` before that, and if the pose is unknown.
    #[must_use]
    pub fn starting(
        parameters: Parameters,
        turn: &Turn,
        sensor: &str,
        world_from_robot: Option<Pose>,
    ) -> Option<Self> {
        let reading = turn.reading(sensor).filter(|reading| reading.readable)?;
        if !reading.values.iter().all(|value| value.is_finite()) {
            return None;
        }
        let said = match *reading.values.as_slice() {
            [x, y, heading, ..] => Some(Pose::new(x, y, heading)),
            _ => None,
        };
        let at_ns = reading.sampled_at_ns.unwrap_or(turn.at_ns);
        Some(Self::new(parameters, at_ns, Estimate::exact(world_from_robot.or(said)?)))
    }

    /// Takes the reading of this sensor, encoders or an odometer, if the turn brought a new one. Its instant is that of
    /// its sample, or of the turn if the protocol does not give it. Returns whether there was one.
    pub fn read(&mut self, turn: &Turn, sensor: &str) -> bool {
        let Some(reading) = turn.reading(sensor).filter(|reading| reading.readable) else { return false };
        let at_ns = reading.sampled_at_ns.unwrap_or(turn.at_ns);
        let is_odometer = turn.body.sensor(sensor).is_some_and(|sensor| sensor.kind == SensorKind::Odometer);
        if !reading.values.iter().all(|value| value.is_finite()) {
            return false;
        }
        match *reading.values.as_slice() {
            [x, y, heading, ..] if is_odometer => self.odometer(at_ns, Pose::new(x, y, heading)),
            [left, right, ..] if !is_odometer => self.encoders(at_ns, [left, right]),
            _ => return false,
        }
        self.arrivals.note(sensor, at_ns, turn.at_ns);
        true
    }

    /// Whether at this instant of the laptop's clock nothing has come for longer than `least_ns`, in nanoseconds, and longer than
    /// [usual](Self::patience_ns).
    #[must_use]
    pub fn is_overdue(&self, now_ns: u64, least_ns: u64) -> bool {
        now_ns.saturating_sub(self.arrivals.heard_ns()) > least_ns.max(self.patience_ns())
    }

    /// The time after its last reading before which the next is not overdue, in nanoseconds: some times as long as usual.
    #[must_use]
    pub fn patience_ns(&self) -> u64 {
        self.arrivals.patience_ns()
    }

    /// The sensor as one that is waited for, and since when.
    #[must_use]
    pub fn awaited(&self) -> Awaited {
        self.arrivals.awaited()
    }

    /// The part of its speed at which a robot may drive by it whose commands take so long on the cable, in nanoseconds:
    /// 1, unless its readings are so old that it would be too far on its way, or too far round, before it could heed
    /// them.
    #[must_use]
    pub fn haste(&self, command_ns: u64) -> f64 {
        let blind_ns = self.arrivals.lag_ns().saturating_add(command_ns).max(1);
        (CALM_NS / blind_ns as f64).min(1.0)
    }

    /// A reading of both encoders, which must know the direction, sampled at this instant. Counts that
    /// were missed are in the next reading; but between two of them a wheel must not make half the modulus.
    pub fn encoders(&mut self, at_ns: u64, counts: [f64; 2]) {
        if let Some(Last::Counts(before)) = self.last.replace(Last::Counts(counts)) {
            let Parameters { m_per_count, modulus, .. } = self.parameters;
            let ways_m = [0, 1].map(|i| m_per_count[i] * unwrapped(counts[i] - before[i], modulus));
            self.advance(at_ns, self.rolled(ways_m));
        }
    }

    /// A reading of an odometer, which has its own idea of a world, sampled at this instant. Only its changes
    /// count.
    pub fn odometer(&mut self, at_ns: u64, odometer_from_robot: Pose) {
        if let Some(Last::Odometer(before)) = self.last.replace(Last::Odometer(odometer_from_robot)) {
            let step =
                Step::of_motion(before.inverse().compose(&odometer_from_robot), self.parameters.half_track_m);
            let is_as_told = self.parameters.calibration == Calibration::NONE;
            self.advance(at_ns, if is_as_told { step } else { self.rolled(step.ways_m) });
        }
    }

    /// The pose at the last reading.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        self.newest().estimate
    }

    /// The instant at which the last reading was sampled.
    #[must_use]
    pub fn at_ns(&self) -> u64 {
        self.newest().at_ns
    }

    /// The pose at an earlier instant; `None` if that is forgotten, or if the robot moved while no reading came for
    /// so long that the instants of its motion are unknown. It is taken to have gone evenly between readings, and to
    /// stand since the last one.
    #[must_use]
    pub fn at(&self, at_ns: u64) -> Option<Estimate> {
        let (from, step) = self.step_to(at_ns)?;
        Some(step.map_or(*from, |step| self.stepped(from, &step)))
    }

    /// The poses of [`at`](Self::at), world from robot, without the work for their covariances.
    #[must_use]
    pub fn track(&self) -> Track<'_> {
        Track { odometry: self, leg: None }
    }

    /// The estimate from which the robot went to where it was at an instant, and its step from there; no step if it was there.
    fn step_to(&self, at_ns: u64) -> Option<(&Estimate, Option<Step>)> {
        Some(match self.place(at_ns)? {
            Place::At(estimate) => (estimate, None),
            Place::Between(before, next) => {
                (&before.estimate, Some(next.step.part(fraction(before.at_ns, at_ns, next.at_ns))))
            }
        })
    }

    /// The place of an instant in the past.
    fn place(&self, at_ns: u64) -> Option<Place<'_>> {
        let after = self.past.partition_point(|past| past.at_ns < at_ns);
        let Some(next) = self.past.get(after) else { return Some(Place::At(&self.newest().estimate)) };
        if next.at_ns == at_ns {
            return Some(Place::At(&next.estimate));
        }
        let before = &self.past[after.checked_sub(1)?];
        let is_even = next.at_ns.saturating_sub(before.at_ns) <= EVEN_NS || next.step.is_small();
        is_even.then_some(Place::Between(before, next))
    }

    /// The same, if nothing later was corrected: only then it can be [corrected](Self::correct).
    #[must_use]
    pub fn correctable(&self, at_ns: u64) -> Option<Estimate> {
        self.at(at_ns).filter(|_| at_ns >= self.corrected_ns)
    }

    /// Replaces the estimate by a better one, and forgets the old.
    pub fn reset(&mut self, estimate: Estimate) {
        let at_ns = self.at_ns();
        self.past.clear();
        self.past.push_back(Past { at_ns, step: Step::default(), estimate });
        self.corrected_ns = at_ns;
    }

    /// Replaces the estimate of an earlier instant by a better one, and goes again all the way from there. The way that led
    /// there keeps its shape, and is as unsure as it was. Returns false, and changes nothing, if that instant is forgotten,
    /// or a later one was corrected.
    pub fn correct(&mut self, at_ns: u64, estimate: Estimate) -> bool {
        let after = self.past.partition_point(|past| past.at_ns <= at_ns);
        let (Some(before), Some(old)) = (after.checked_sub(1), self.correctable(at_ns)) else { return false };
        let mut again = self.past.split_off(after);
        let before = self.past[before];
        let mut step = if before.at_ns == at_ns { before.step } else { Step::default() };
        if let Some(first) = again.front_mut() {
            let fraction = fraction(before.at_ns, at_ns, first.at_ns);
            if before.at_ns < at_ns {
                step = first.step.part(fraction);
            }
            first.step = first.step.rest(fraction);
        }
        self.past.retain(|past| past.at_ns < at_ns);
        let new_from_old = estimate.world_from_robot.compose(&old.world_from_robot.inverse());
        self.past.iter_mut().for_each(|past| past.estimate = past.estimate.moved(&new_from_old));
        self.remember(Past { at_ns, step, estimate });
        self.corrected_ns = at_ns;
        again.into_iter().for_each(|past| self.advance(past.at_ns, past.step));
        true
    }

    /// The step that wheels make which count these ways, in metres of the data sheet's wheels.
    fn rolled(&self, [left, right]: [f64; 2]) -> Step {
        let [left_factor, right_factor] = self.parameters.calibration.wheels;
        Step::of_wheels([left_factor * left, right_factor * right], self.half_track_m())
    }

    /// Half the distance between this robot's wheels, in metres.
    fn half_track_m(&self) -> f64 {
        self.parameters.calibration.track * self.parameters.half_track_m
    }

    fn newest(&self) -> &Past {
        self.past.back().expect("the past begins with the start and is never emptied")
    }

    /// Goes one step. One that is not newer than the last moves the robot, but not time.
    fn advance(&mut self, at_ns: u64, step: Step) {
        let newest = *self.newest();
        let estimate = self.stepped(&newest.estimate, &step);
        if at_ns <= newest.at_ns {
            let last = self.past.len() - 1;
            let step = newest.step.then(&step);
            self.past[last] = Past { at_ns: newest.at_ns, step, estimate };
            return;
        }
        self.remember(Past { at_ns, step, estimate });
    }

    /// Forgets what is so long ago that what is left reaches far enough without it.
    fn remember(&mut self, past: Past) {
        let since_ns = past.at_ns.saturating_sub(self.parameters.past_ns);
        while self.past.len() >= MOST_POSES || self.past.get(1).is_some_and(|next| next.at_ns <= since_ns) {
            self.past.pop_front();
        }
        self.past.push_back(past);
    }

    fn stepped(&self, estimate: &Estimate, step: &Step) -> Estimate {
        step.apply(estimate, self.half_track_m(), self.parameters.variance_m2_per_m)
    }
}

/// The difference of two counts, the shorter way around.
fn unwrapped(difference: f64, modulus: Option<f64>) -> f64 {
    modulus.map_or(difference, |modulus| math::remainder(difference, modulus))
}

/// The fraction of the time between two instants that has gone at a third.
fn fraction(from_ns: u64, at_ns: u64, to_ns: u64) -> f64 {
    at_ns.saturating_sub(from_ns) as f64 / to_ns.saturating_sub(from_ns).max(1) as f64
}

/// Odometry of which nothing has come for so long is overdue, if it is not always so slow, in nanoseconds.
pub(crate) const OVERDUE_NS: u64 = 500_000_000;
/// The time from a reading's sample until a command that heeds it is obeyed, at full speed, in nanoseconds. At 0.4 m/s
/// and 0.9 rad/s that is 0.1 m and 0.22 rad, and controllers with a gain of 2 a second do not overshoot.
const CALM_NS: f64 = 250e6;
/// The distance of two readings, in nanoseconds, beyond which a robot has not gone evenly: it may have stopped when the
/// cable was pulled.
const EVEN_NS: u64 = 600_000_000;
/// The length of the memory of poses, in nanoseconds. A scan of a laser with a slow cable of its own is two seconds
/// old when it comes, and odometry may be as late as that.
const PAST_NS: u64 = 10_000_000_000;
/// The most poses that are kept: those of ten seconds at 500 Hz.
const MOST_POSES: usize = 5_000;
