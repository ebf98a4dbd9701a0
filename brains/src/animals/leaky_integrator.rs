//! The leaky integrator: (4.1), and (7.11), which is the same.

use baudbot_geometry::math;

/// A value V that follows an input X and forgets it: dV/dt + a V = b X.
///
/// It is a low-pass filter with the time constant 1/a. Under a constant input V tends to X b/a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeakyIntegrator {
    /// a, how fast it forgets, per second.
    pub decay_hz: f64,
    /// b, how fast it takes in, per second.
    pub gain_hz: f64,
    /// V, in the unit of the input.
    pub value: f64,
}

impl LeakyIntegrator {
    /// One step by Euler's method, V + Δt (b X − a V), as the notes' simulations do. It needs steps shorter than
    /// 2/a, or it grows without end; shorter than 1/a it does not overshoot.
    pub fn step(&mut self, input: f64, dt_s: f64) {
        self.value += dt_s * (self.gain_hz * input - self.decay_hz * self.value);
    }

    /// The exact solution after `dt_s` seconds of a constant input, however long.
    pub fn hold(&mut self, input: f64, dt_s: f64) {
        let settled = input * self.gain_hz / self.decay_hz;
        self.value = settled + (self.value - settled) * math::exp(-self.decay_hz * dt_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (4.1), (7.11), beside their solution for a constant stimulus.
    #[test]
    fn small_steps_come_near_the_exact_solution() {
        let start = LeakyIntegrator { decay_hz: 2.0, gain_hz: 3.0, value: 0.5 };
        let (mut exact, mut euler) = (start, start);
        exact.hold(0.7, 1.5);
        (0..15_000).for_each(|_| euler.step(0.7, 1e-4));
        assert!((exact.value - (1.05 + (0.5 - 1.05) * (-3.0_f64).exp())).abs() < 1e-15);
        assert!((exact.value - euler.value).abs() < 1e-4, "{} {}", exact.value, euler.value);
    }

    #[test]
    fn an_exact_step_may_be_of_any_length() {
        let start = LeakyIntegrator { decay_hz: 1.0, gain_hz: 1.0, value: 0.0 };
        let (mut once, mut often) = (start, start);
        once.hold(1.0, 10.0);
        (0..10).for_each(|_| often.hold(1.0, 1.0));
        assert!((once.value - often.value).abs() < 1e-14);
    }
}
