//! Lorenz' psychohydraulic model of motivation: Wahde 2016, §4.4.4, which names it; after K. Lorenz, *The comparative method in studying
//! innate behaviour patterns*, 1950.
//!
//! Each behaviour has a reservoir, into which action-specific energy flows at a constant rate. A valve with a spring closes it. The weight
//! on the valve is the energy's pressure and the releaser, a state variable; what is above the spring's force opens it, and the
//! behaviour runs as strongly as energy flows out.
//!
//! ```text
//! ė = fill − outflow · max(0, e + releaser − spring),    0 ≤ e ≤ capacity
//! ```
//!
//! A releaser counts if it is positive. An empty reservoir lets flow what flows in.
//!
//! So a behaviour that has not been shown for long needs a weaker releaser, a reservoir that has run empty needs a stronger one, and one
//! whose capacity exceeds the spring overflows: the behaviour runs *in vacuo*, without any releaser. The notes give no equations; these are
//! the picture's, with pressure and releaser in units of energy. Euler's method integrates them, in parts where a brain steps seldom.
//! The behaviour with the greatest flow has the motors, of equal ones the first; without a flow it is the one below all.

use baudbot_geometry::math;

use super::utility::greatest;

/// A reservoir, with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reservoir {
    /// The place of the behaviour whose energy it holds.
    pub behavior: usize,
    /// The place of the state variable that releases it, if one does.
    pub releaser: Option<usize>,
    /// The inflow, per second.
    pub fill_hz: f64,
    /// The largest energy.
    pub capacity: f64,
    /// The outflow for each unit of weight above the spring's force, per second.
    pub outflow_hz: f64,
    /// The force of the spring.
    pub spring: f64,
    /// The energy now.
    pub energy: f64,
}

impl Reservoir {
    /// Goes on by `dt_s` seconds, above 0, with these state variables; the flow at their end, per second.
    fn step(&mut self, state: &[f64], dt_s: f64) -> f64 {
        let releaser = self.releaser.and_then(|place| state.get(place)).copied().unwrap_or(0.0).max(0.0);
        let parts = math::ceil(dt_s * self.outflow_hz / LONGEST_PART).clamp(1.0, MOST_PARTS);
        let part_s = dt_s / parts;
        let mut flow_hz = 0.0;
        for _ in 0..parts as u32 {
            let opening = (self.energy + releaser - self.spring).max(0.0);
            let there = self.energy + part_s * self.fill_hz;
            // No more flows out than there is.
            let out = (part_s * self.outflow_hz * opening).min(there);
            self.energy = (there - out).min(self.capacity);
            flow_hz = out / part_s;
        }
        flow_hz
    }
}

/// A decision by reservoirs.
#[derive(Clone, Debug, PartialEq)]
pub struct Hydraulic {
    pub(crate) reservoirs: Vec<Reservoir>,
    /// The behaviour that is active while all valves are closed.
    pub(crate) base: usize,
    /// The one that is active now.
    active: usize,
}

impl Hydraulic {
    /// Reservoirs, and the behaviour that is active while all valves are closed.
    pub fn new(reservoirs: Vec<Reservoir>, base: usize) -> Self {
        Self { reservoirs, base, active: base }
    }

    /// The active behaviour after `dt_s` seconds with these state variables.
    pub fn step(&mut self, state: &[f64], dt_s: f64) -> usize {
        if dt_s > 0.0 {
            let flows_hz = self.reservoirs.iter_mut().map(|reservoir| reservoir.step(state, dt_s));
            let flows_hz: Vec<_> = flows_hz.collect();
            let strongest = greatest(flows_hz.iter().copied()).filter(|place| flows_hz[*place] > 0.0);
            self.active = strongest.map_or(self.base, |place| self.reservoirs[place].behavior);
        }
        self.active
    }

    /// The energy of each reservoir.
    pub fn energies(&self) -> impl Iterator<Item = f64> {
        self.reservoirs.iter().map(|reservoir| reservoir.energy)
    }
}

/// A part of a step lets so much of what is above the spring flow out.
const LONGEST_PART: f64 = 0.25;
/// A step is not divided into more parts.
const MOST_PARTS: f64 = 1000.0;

#[cfg(test)]
mod tests {
    use super::*;

    const DISPLAY: Reservoir = Reservoir {
        behavior: 1,
        releaser: Some(0),
        fill_hz: 0.1,
        capacity: 1.0,
        outflow_hz: 2.0,
        spring: 0.8,
        energy: 0.0,
    };

    /// The seconds until the behaviour runs with a constant releaser, within a minute.
    fn waits_s(reservoir: Reservoir, releaser: f64) -> Option<f64> {
        let mut decision = Hydraulic::new(vec![reservoir], 0);
        let mut runs = |step: &u32| decision.step(&[releaser], if *step == 0 { 0.0 } else { 0.01 }) == 1;
        (0..6000).find(|step| runs(step)).map(|step| f64::from(step) * 0.01)
    }

    /// The hydraulic model of §4.4.4 is known for this.
    #[test]
    fn the_longer_it_was_not_shown_the_weaker_a_releaser_suffices() {
        for releaser in [0.1, 0.3, 0.5, 0.7] {
            let waits_s = waits_s(DISPLAY, releaser).unwrap();
            assert!((waits_s - (0.8 - releaser) / 0.1).abs() < 0.03, "{releaser}: {waits_s}");
        }
    }

    #[test]
    fn a_full_reservoir_overflows_without_a_releaser_and_a_small_one_never_does() {
        let waits_s = |capacity| waits_s(Reservoir { capacity, ..DISPLAY }, 0.0);
        assert!((waits_s(1.0).unwrap() - 8.0).abs() < 0.03);
        assert_eq!(waits_s(0.79), None);
    }

    #[test]
    fn a_releaser_exhausts_the_energy_and_a_stronger_one_brings_it_back() {
        let mut decision = Hydraulic::new(vec![Reservoir { energy: 1.0, ..DISPLAY }], 0);
        (0..1000).for_each(|_| _ = decision.step(&[0.4], 0.01));
        // Inflow and outflow are equal at e + 0.4 − 0.8 = 0.05.
        assert!((decision.energies().next().unwrap() - 0.45).abs() < 1e-3);
        assert_eq!(decision.step(&[0.2], 0.01), 0, "the weaker one is not enough any more");
        assert_eq!(decision.step(&[0.7], 0.01), 1);
    }

    #[test]
    fn an_empty_reservoir_shows_nothing_however_strong_the_releaser() {
        let empty = Reservoir { fill_hz: 0.0, ..DISPLAY };
        assert_eq!(waits_s(empty, 100.0), None);
    }

    #[test]
    fn what_flows_into_an_empty_reservoir_flows_out_without_a_pause() {
        let mut decision = Hydraulic::new(vec![DISPLAY], 0);
        let active: Vec<_> = (0..6000).map(|_| decision.step(&[1.5], 0.01)).collect();
        assert!(active.iter().all(|active| *active == 1), "it changes");
        assert!(decision.energies().all(|energy| energy < 1e-9));
    }

    #[test]
    fn huge_constants_make_no_energy_that_is_no_number() {
        let huge = Reservoir { outflow_hz: 1e300, capacity: 1e9, energy: 1e9, spring: 0.0, ..DISPLAY };
        let mut decision = Hydraulic::new(vec![huge], 0);
        for dt_s in [0.0, 0.01, 1e9] {
            decision.step(&[1e300], dt_s);
            assert!(decision.energies().all(|energy| (0.0..=1e9).contains(&energy)), "{decision:?}");
        }
    }

    #[test]
    fn steps_of_any_length_keep_the_energy_within_its_bounds() {
        for dt_s in [0.0, 0.001, 0.3, 5.0, 1e6] {
            let mut decision = Hydraulic::new(vec![Reservoir { outflow_hz: 50.0, ..DISPLAY }], 0);
            for step in 0..100 {
                decision.step(&[f64::from(step % 2)], dt_s);
                assert!(decision.energies().all(|energy| (0.0..=1.0).contains(&energy)), "{dt_s}");
            }
        }
    }
}
