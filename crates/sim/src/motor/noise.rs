//! Noise of the actuators: a factor on each wheel's signal, as (3.1) has it for sensors.
//!
//! Deviation. The notes have noise on sensors only. No two motors of a type are alike (`spread`), and none
//! runs evenly (`sigma`).

use serde::{Deserialize, Serialize};

use crate::random::Stream;
use crate::wheels::Wheels;

/// The unevenness of a robot's motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorNoise {
    /// Standard deviation of a factor with mean 1 on each wheel's signal, drawn once a tick.
    pub sigma: f64,
    /// Standard deviation of a factor with mean 1 on each wheel's signal, drawn once a run.
    pub spread: f64,
}

/// The factors of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NoiseState {
    pub(crate) stream: Stream,
    specimen: Wheels,
    /// Of this tick, the specimen's included.
    factor: Wheels,
}

impl NoiseState {
    /// Motors that have not run yet. Until the first [`tick`](Self::tick) they are without noise.
    pub(crate) fn new(noise: &MotorNoise, mut stream: Stream) -> Self {
        let specimen = pair(noise.spread, &mut stream);
        Self { stream, specimen, factor: Wheels { left: 1.0, right: 1.0 } }
    }

    pub(crate) fn is_sound(&self) -> bool {
        crate::sound::wheels(&self.specimen) && crate::sound::wheels(&self.factor) && self.stream.is_sound()
    }

    /// Draws the factors of the next tick.
    pub(crate) fn tick(&mut self, noise: &MotorNoise) {
        let Wheels { left, right } = pair(noise.sigma, &mut self.stream);
        self.factor = Wheels { left: self.specimen.left * left, right: self.specimen.right * right };
    }

    /// The signals that the motors get in place of these.
    pub(crate) fn apply(&self, signals: Wheels) -> Wheels {
        Wheels { left: signals.left * self.factor.left, right: signals.right * self.factor.right }
    }
}

/// Two factors, never negative: noise makes no motor turn the other way. Without noise nothing is drawn.
fn pair(sigma: f64, stream: &mut Stream) -> Wheels {
    let mut factor = || if sigma > 0.0 { (1.0 + sigma * stream.normal()).max(0.0) } else { 1.0 };
    let left = factor();
    Wheels { left, right: factor() }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::{MotorNoise, NoiseState};
    use crate::random::Stream;
    use crate::statistics::{SAMPLES, assert_distributed, correlation, normal};
    use crate::wheels::Wheels;

    const SIGNALS: Wheels = Wheels { left: 0.5, right: -0.25 };

    fn factors(noise: MotorNoise, seed: u64, ticks: u32) -> Vec<f64> {
        let mut state = NoiseState::new(&noise, Stream::new(seed, "test"));
        let ticks = (0..ticks).flat_map(|_| {
            state.tick(&noise);
            let Wheels { left, right } = state.apply(SIGNALS);
            [left / SIGNALS.left, right / SIGNALS.right]
        });
        ticks.collect()
    }

    #[test]
    fn motors_without_noise_get_their_signals_to_the_bit() {
        assert_eq!(factors(MotorNoise::default(), 1, 5), [1.0; 10]);
        let never_ticked = NoiseState::new(&MotorNoise { sigma: 0.1, spread: 0.1 }, Stream::new(1, "test"));
        assert_eq!(never_ticked.apply(SIGNALS), SIGNALS);
    }

    #[test]
    fn sigma_is_a_normal_factor_a_tick_on_each_wheel_by_itself() {
        let mut sigma = factors(MotorNoise { sigma: 0.05, spread: 0.0 }, 1, SAMPLES as u32 / 2);
        let wheels: Vec<_> = sigma.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        assert!(correlation(&wheels).abs() < 0.015, "{}", correlation(&wheels));
        assert_distributed(&mut sigma, |scale| normal(1.0, 0.05 * scale));
    }

    #[test]
    fn spread_is_a_normal_factor_a_run_and_stays() {
        let noise = MotorNoise { sigma: 0.0, spread: 0.05 };
        let one = factors(noise, 1, 3);
        assert!(one[0] != one[1] && one[..2] == one[2..4] && one[..2] == one[4..], "{one:?}");
        let mut many: Vec<f64> = (0..SAMPLES as u64 / 2).flat_map(|seed| factors(noise, seed, 1)).collect();
        assert_distributed(&mut many, |scale| normal(1.0, 0.05 * scale));
    }

    #[test]
    fn noise_never_turns_a_motor_round() {
        let wild = factors(MotorNoise { sigma: 1.0, spread: 0.0 }, 1, 1000);
        assert!(wild.iter().all(|&factor| factor >= 0.0) && wild.contains(&0.0), "{wild:?}");
    }
}
