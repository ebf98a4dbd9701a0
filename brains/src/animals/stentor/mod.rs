//! *Stentor*: five behaviours and no nerves. Wahde 2016, §7.2.1, (7.11)–(7.15), Fig. 7.4; after Staddon 2001.
//!
//! It sits on a rock and feeds (B₁). Against a noxious substance it can turn away (B₂), reverse its cilia (B₃),
//! contract (B₄) and at last detach itself (B₅), each of which costs more. The utility of feeding is constant.
//! Those of the others are leaky integrators (7.12) of the substance's concentration X, and the largest utility
//! decides: (7.13). While it feeds, X tends to X₁/k₁ (7.14), and otherwise to X₂/k₂ (7.15).
//!
//! The notes give no numbers. With these, found by a random search, the order is that of Fig. 7.4: cheap behaviours
//! have quick and weak integrators, and expensive ones slow and strong ones. The first activation of each is at a
//! time that does not depend on the step. Afterwards feeding and detaching take turns ever more quickly the shorter
//! the steps are, as a relay without hysteresis does; only their order means something there.
//!
//! [`StentorBrain`] is a robot that does as it does.

pub(crate) mod brain;

pub use brain::{Parameters as BrainParameters, StentorBrain};

use super::leaky_integrator::LeakyIntegrator;
use crate::decision::utility::greatest;

/// A behaviour of a Stentor, in the order of costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Behaviour {
    /// The behaviour B₁.
    Feed,
    /// The behaviour B₂.
    TurnAway,
    /// The behaviour B₃.
    ReverseCilia,
    /// The behaviour B₄.
    Contract,
    /// The behaviour B₅.
    Detach,
}

/// The constants of a Stentor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// a₂ to a₅ of (7.12), per second.
    pub decay_hz: [f64; 4],
    /// b₂ to b₅ of (7.12), per second.
    pub gain_hz: [f64; 4],
    /// C, the utility of feeding.
    pub feeding: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { decay_hz: [4.0, 1.2, 0.5, 0.24], gain_hz: [17.0, 5.6, 2.55, 1.42], feeding: 0.8 }
    }
}

/// A Stentor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stentor {
    feeding: f64,
    avoidance: [LeakyIntegrator; 4],
}

impl Stentor {
    /// One that has felt nothing yet: all utilities but that of feeding are 0.
    pub fn new(parameters: Parameters) -> Self {
        let Parameters { decay_hz, gain_hz, feeding } = parameters;
        let avoidance = std::array::from_fn(|i| LeakyIntegrator {
            decay_hz: decay_hz[i],
            gain_hz: gain_hz[i],
            value: 0.0,
        });
        Self { feeding, avoidance }
    }

    /// The utilities U₁ to U₅.
    pub fn utilities(&self) -> [f64; 5] {
        let [u2, u3, u4, u5] = self.avoidance.map(|integrator| integrator.value);
        [self.feeding, u2, u3, u4, u5]
    }

    /// Chooses a behaviour, (7.13); of equal utilities the cheapest. Then it feels a concentration for `dt_s`
    /// seconds, by Euler's method.
    pub fn step(&mut self, concentration: f64, dt_s: f64) -> Behaviour {
        let chosen = greatest(self.utilities()).unwrap_or(0);
        self.avoidance.iter_mut().for_each(|integrator| integrator.step(concentration, dt_s));
        BEHAVIOURS[chosen]
    }
}

/// The water around a Stentor: (7.14), (7.15).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// X, the concentration of the noxious substance.
    pub concentration: f64,
    /// k₁, how fast it is lost while the Stentor feeds, per second.
    pub feeding_decay_hz: f64,
    /// X₁, what comes in while it feeds, per second.
    pub feeding_inflow_hz: f64,
    /// k₂, how fast it is lost otherwise, per second.
    pub avoiding_decay_hz: f64,
    /// X₂, what comes in otherwise, per second.
    pub avoiding_inflow_hz: f64,
}

impl Default for Water {
    fn default() -> Self {
        Self {
            concentration: 0.0,
            feeding_decay_hz: 0.67,
            feeding_inflow_hz: 1.2,
            avoiding_decay_hz: 0.26,
            avoiding_inflow_hz: 0.0,
        }
    }
}

impl Water {
    /// Changes its state by `dt_s` seconds of a behaviour, by Euler's method.
    pub fn step(&mut self, behaviour: Behaviour, dt_s: f64) {
        let (decay_hz, inflow_hz) = match behaviour {
            Behaviour::Feed => (self.feeding_decay_hz, self.feeding_inflow_hz),
            Behaviour::TurnAway | Behaviour::ReverseCilia | Behaviour::Contract | Behaviour::Detach => {
                (self.avoiding_decay_hz, self.avoiding_inflow_hz)
            }
        };
        self.concentration += dt_s * (inflow_hz - decay_hz * self.concentration);
    }
}

const BEHAVIOURS: [Behaviour; 5] =
    [Behaviour::Feed, Behaviour::TurnAway, Behaviour::ReverseCilia, Behaviour::Contract, Behaviour::Detach];

#[cfg(test)]
mod tests {
    use super::Behaviour::*;
    use super::*;

    /// The behaviours of some seconds one after the other, when each began, and the largest concentration.
    fn run(parameters: Parameters, dt_s: f64, seconds: f64) -> (Vec<Behaviour>, Vec<f64>, f64) {
        let (mut stentor, mut water) = (Stentor::new(parameters), Water::default());
        let (mut behaviours, mut times, mut largest): (Vec<_>, _, f64) = (Vec::new(), Vec::new(), 0.0);
        for step in 0..(seconds / dt_s) as u32 {
            let behaviour = stentor.step(water.concentration, dt_s);
            water.step(behaviour, dt_s);
            largest = largest.max(water.concentration);
            if behaviours.last() != Some(&behaviour) {
                behaviours.push(behaviour);
                times.push(f64::from(step) * dt_s);
            }
        }
        (behaviours, times, largest)
    }

    /// The order of Fig. 7.4, by (7.11)–(7.15).
    #[test]
    fn avoidance_escalates_as_in_figure_7_4() {
        for dt_s in [0.01, 0.005, 0.001] {
            let (behaviours, times, _) = run(Parameters::default(), dt_s, 15.0);
            assert_eq!(behaviours[..5], [Feed, TurnAway, ReverseCilia, Contract, Detach], "{dt_s}");
            for (time, figure) in times[1..].iter().zip([0.37, 1.71, 3.35, 5.13]) {
                assert!((time - figure).abs() < 0.02, "{dt_s}: {time} instead of {figure}");
            }
            // The mild behaviours are skipped after the first four.
            let rest = &behaviours[4..];
            assert!(rest.len() > 6, "{rest:?}");
            assert!(
                rest.iter().enumerate().all(|(i, &b)| b == if i % 2 == 0 { Detach } else { Feed }),
                "{rest:?}"
            );
        }
    }

    #[test]
    fn times_in_steps_of_a_hundredth_second() {
        let (_, times, largest) = run(Parameters::default(), 0.01, 12.0);
        let figures = [0.0, 0.37, 1.71, 3.35, 5.13, 5.99, 6.09, 9.03, 9.12, 11.76, 11.84];
        assert_eq!(times.len(), figures.len(), "{times:?}");
        assert!(times.iter().zip(figures).all(|(time, figure)| (time - figure).abs() < 1e-9), "{times:?}");
        assert!((largest - 0.3944).abs() < 5e-5, "{largest}");
    }

    #[test]
    fn a_weak_behaviour_is_skipped() {
        let mut parameters = Parameters::default();
        parameters.gain_hz[1] *= 0.55;
        let (behaviours, times, _) = run(parameters, 0.01, 9.0);
        assert_eq!(behaviours[..6], [Feed, TurnAway, Contract, Detach, Feed, Detach]);
        let figures = [0.37, 2.51, 5.13];
        assert!(times[1..4].iter().zip(figures).all(|(t, f)| (t - f).abs() < 0.02), "{times:?}");
    }

    #[test]
    fn in_clean_water_it_feeds() {
        let mut stentor = Stentor::new(Parameters::default());
        assert!((0..1000).all(|_| stentor.step(0.0, 0.01) == Feed));
        // U₂ tends to X b₂/a₂ = 4.25 X, and U₅ to 5.92 X: the least X that troubles it is 0.8 / 5.92 = 0.1352.
        assert!((0..5000).all(|_| stentor.step(0.134, 0.01) == Feed));
        assert!((0..5000).any(|_| stentor.step(0.137, 0.01) == Detach));
    }
}
