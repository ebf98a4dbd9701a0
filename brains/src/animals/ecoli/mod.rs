//! *E. coli*: chemotaxis without a spatial gradient. Wahde 2016, §4.4.2, (4.1), Figs. 4.1 and 4.2.
//!
//! A bacterium is too small to feel a difference between its sides. It remembers instead: a leaky integrator V
//! follows the concentration X, and U = X − V says whether it gets better. If U > T it swims straight on (B₁), else
//! it tumbles (B₂). So it is a choice by utility, in which tumbling has the fixed utility T.
//!
//! [`EColi`] is the bacterium, and [`EColiBrain`] a robot that does as it does.

pub(crate) mod brain;

pub use brain::{EColiBrain, Parameters as BrainParameters};

use super::leaky_integrator::LeakyIntegrator;

/// The constants of a bacterium; the defaults are those of Figs. 4.1 and 4.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// a of (4.1), per second.
    pub decay_hz: f64,
    /// b of (4.1), per second. If it is above a, the bacterium tumbles in a constant concentration.
    pub gain_hz: f64,
    /// T, in the unit of the concentration.
    pub threshold: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { decay_hz: 1.0, gain_hz: 1.0, threshold: 0.0 }
    }
}

/// The behaviour of a bacterium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Behaviour {
    /// B₁: straight on.
    Swim,
    /// B₂: into a new direction, at random.
    Tumble,
}

/// A bacterium's memory, and what it makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EColi {
    memory: LeakyIntegrator,
    threshold: f64,
}

impl EColi {
    /// A bacterium that remembers the concentration `remembered`, V(0).
    pub fn new(parameters: Parameters, remembered: f64) -> Self {
        let Parameters { decay_hz, gain_hz, threshold } = parameters;
        Self { memory: LeakyIntegrator { decay_hz, gain_hz, value: remembered }, threshold }
    }

    /// U = X − V, the utility of swimming on in this concentration.
    pub fn utility(&self, concentration: f64) -> f64 {
        concentration - self.memory.value
    }

    /// Chooses by what it feels now, and then remembers it for `dt_s` seconds, by Euler's method.
    pub fn step(&mut self, concentration: f64, dt_s: f64) -> Behaviour {
        let swims = self.utility(concentration) > self.threshold;
        self.memory.step(concentration, dt_s);
        if swims { Behaviour::Swim } else { Behaviour::Tumble }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The attractant of Fig. 4.1: there from 1 s to 3 s.
    fn pulse(step: u32) -> f64 {
        f64::from((100..300).contains(&step))
    }

    /// (4.1) and Fig. 4.1, by the exact solution.
    #[test]
    fn figure_4_1_exactly() {
        let mut memory = LeakyIntegrator { decay_hz: 1.0, gain_hz: 1.0, value: 0.0 };
        memory.hold(0.0, 1.0);
        assert_eq!(1.0 - memory.value, 1.0);
        memory.hold(1.0, 2.0);
        assert!((1.0 - memory.value - (-2.0_f64).exp()).abs() < 1e-15);
        assert!((-memory.value - -0.864_665).abs() < 5e-7);
        memory.hold(0.0, 2.0);
        assert!((-memory.value - -0.117_020).abs() < 5e-7);
    }

    #[test]
    fn figure_4_1_in_steps_of_a_hundredth_second() {
        let mut cell = EColi::new(Parameters::default(), 0.0);
        let mut swum = Vec::new();
        let mut utilities = Vec::new();
        for step in 0..=500 {
            utilities.push(cell.utility(pulse(step)));
            if cell.step(pulse(step), 0.01) == Behaviour::Swim {
                swum.push(step);
            }
        }
        for (step, figure) in [(100, 1.0), (299, 0.135_333), (300, -0.866_020), (500, -0.116_029)] {
            assert!((utilities[step] - figure).abs() < 5e-7, "{step}: {}", utilities[step]);
        }
        assert_eq!(swum, Vec::from_iter(100..300), "it swims from 1 s to 3 s, 200 steps");
    }

    #[test]
    fn a_cell_that_takes_in_more_than_it_forgets_tumbles_in_the_end() {
        let mut cell = EColi::new(Parameters { gain_hz: 1.2, ..Parameters::default() }, 0.0);
        let swum = (0..100_000).take_while(|_| cell.step(1.0, 1e-4) == Behaviour::Swim).count();
        let figure_s = 6.0_f64.ln();
        assert!((swum as f64 * 1e-4 - figure_s).abs() < 5e-4, "{swum} steps, not {figure_s} s");
    }
}
