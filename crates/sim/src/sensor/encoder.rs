//! Wheel encoders: counts of a digital optical encoder on each wheel (§1.2.2, Fig. 1.6).
//!
//! Two detectors a quarter of a cycle apart tell the direction; a single one counts the same both ways. A count
//! may be lost when a mark passes unseen.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::math;
use serde::{Deserialize, Serialize};

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, LEAST_COUNTER_BITS, NoFields, Place, Sense, counters};
use crate::drive::Wheels;
use crate::random::Stream;
use crate::sound;
use baudbot_fields::number::{Number, Share, Whole};
use baudbot_fields::{FieldError, Path};

/// An encoder on each wheel.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Encoders {
    /// Counts per turn of the wheel.
    #[serde(with = "Number::<Whole<1, 1_000_000, u32>>")]
    pub counts_per_turn: u32,
    /// `true`: the encoder detects the direction, and counts down backwards. `false`: a single detector, which
    /// counts up in both directions.
    #[serde(default = "yes")]
    pub quadrature: bool,
    /// Probability that a mark is missed. Only with noise.
    #[serde(default, with = "Number::<Share>")]
    pub loss: f64,
}

/// The memory of an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Marks that had passed at the last read, with their sign.
    passed: Wheels,
    /// The counts.
    counted: Wheels,
}

impl Seen {
    pub(super) fn is_sound(&self) -> bool {
        sound::wheels(&self.passed) && sound::wheels(&self.counted)
    }
}

fn yes() -> bool {
    true
}

impl Sense for Encoders {
    const NAME: &str = "encoders";
    const PLACE: Place = Place::Inside;
    const LEAST_BITS: u64 = LEAST_COUNTER_BITS;
    const IS_ANALOG: bool = false;
    type Sheet = Self;
    type Memory = Seen;

    fn new(sheet: Self, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        Ok(Built::new(sheet, counters(fit.bits)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("left", "count"), Component::one("right", "count")]
    }

    /// Counts since the start, left and right; whole numbers, negative backwards if the direction is known. A
    /// count is made when a mark passes, so the value is rounded down. The wire wraps it as a counter register
    /// does.
    fn read(&self, at: &Measurement<'_>, seen: &mut Seen, stream: &mut Stream, values: &mut [f64]) -> Effect {
        let wheel_radius_m = at.drive.wheel_radius_m;
        let counts_per_m = f64::from(self.counts_per_turn) / (core::f64::consts::TAU * wheel_radius_m);
        let travel = at.motion.travel_m;
        let passed = Wheels {
            left: math::floor(travel.left * counts_per_m),
            right: math::floor(travel.right * counts_per_m),
        };
        let loss = if at.noise { self.loss } else { 0.0 };
        if self.quadrature && loss == 0.0 {
            values.copy_from_slice(&[passed.left, passed.right]);
            return Effect::NONE;
        }
        seen.counted.left += self.count(passed.left - seen.passed.left, loss, stream);
        seen.counted.right += self.count(passed.right - seen.passed.right, loss, stream);
        seen.passed = passed;
        values.copy_from_slice(&[seen.counted.left, seen.counted.right]);
        Effect::NONE
    }
}

impl Encoders {
    /// The number of the passed marks that are counted.
    fn count(&self, passed: f64, loss: f64, stream: &mut Stream) -> f64 {
        let marks = passed.abs();
        let lost = lost(marks, loss, stream);
        let counted = marks - lost;
        if self.quadrature { counted.copysign(passed) } else { counted }
    }
}

/// The number of lost marks: each by itself, and of very many as many as to be expected.
fn lost(marks: f64, loss: f64, stream: &mut Stream) -> f64 {
    if loss == 0.0 || marks == 0.0 {
        return 0.0;
    }
    if marks > MANY {
        return math::round(marks * loss);
    }
    (0..marks as u32).filter(|_| stream.uniform() < loss).count() as f64
}

/// More marks between two reads than this are not looked at one by one.
const MANY: f64 = 10_000.0;

/// The substitute for encoders on a robot with stepper motors: the steps that its firmware has commanded, made or not.
#[derive(Clone, Debug, PartialEq)]
pub struct StepCounter;

impl Sense for StepCounter {
    const NAME: &str = "steps";
    const PLACE: Place = Place::Inside;
    const LEAST_BITS: u64 = LEAST_COUNTER_BITS;
    const IS_ANALOG: bool = false;
    type Sheet = NoFields;
    type Memory = ();

    fn new(_: NoFields, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        Ok(Built::new(Self, counters(fit.bits)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("left", "count"), Component::one("right", "count")]
    }

    /// Steps since the start, left and right.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let steps = at.motion.steps.unwrap_or_default();
        values[0] = math::floor(steps.left.commanded_steps);
        values[1] = math::floor(steps.right.commanded_steps);
        Effect::NONE
    }
}
