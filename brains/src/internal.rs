//! The internal state of a brain: variables that change slowly by themselves, by what the robot senses, and by what it does.
//! Wahde 2016, §4.3 (hormones), §4.4.1 (warm-up and fatigue of reflexes), §4.4.4 (motivation, lethal boundaries), Fig. 7.2.
//!
//! ```text
//! ḣ = rate − h / τ + Σₖ wₖ zₖ + Σᵦ rᵦ [behaviour β drives],    least ≤ h ≤ most
//! ```
//!
//! The notes name hormones, drives and physiological variables and give no equation. This is the leaky integrator (4.1) with an inflow
//! by itself and by behaviours, integrated by Euler's method with the brain's steps. A variable counts among the state variables, so it
//! shifts the threshold of a utility by a weight there, and it can scale the weights of others: zₖ becomes (1 + gₖ h) zₖ.
//!
//! A robot whose variable comes to a lethal boundary stands still for ever.

/// A variable of the internal state, with its constants.
#[derive(Clone, Debug, PartialEq)]
pub struct InternalVariable {
    /// The variable's name.
    pub name: String,
    /// h at the start.
    pub initial: f64,
    /// The inflow by itself, per second.
    pub rate_hz: f64,
    /// τ: the time in which it falls to 1/e by itself, in seconds; `None` if it does not.
    pub decay_s: Option<f64>,
    /// w: the inflow for each unit of a state variable, per second.
    pub release: Vec<f64>,
    /// r: the inflow while each motor behaviour drives, per second.
    pub during: Vec<f64>,
    /// g: the gain of each state variable's weights for each unit of h.
    pub gain: Vec<f64>,
    /// The range within which it stays.
    pub range: [f64; 2],
    /// The boundaries at which the robot dies.
    pub lethal: [Option<f64>; 2],
}

/// All variables of the internal state as they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InternalState {
    pub(crate) variables: Vec<InternalVariable>,
    values: Vec<f64>,
    dead: Option<usize>,
}

impl InternalState {
    /// The state at the start.
    pub fn new(variables: Vec<InternalVariable>) -> Self {
        let values = variables.iter().map(|variable| variable.initial).collect();
        Self { variables, values, dead: None }
    }

    /// Goes on by `dt_s` seconds, in which these state variables were sensed and these behaviours drove.
    pub fn step(&mut self, sensed: &[f64], driving: &[bool], dt_s: f64) {
        for (place, (variable, value)) in self.variables.iter().zip(&mut self.values).enumerate() {
            // What has no weight does not count, whatever it is.
            let sum = |weights: &[f64]| -> f64 {
                weights.iter().zip(sensed).filter(|(w, _)| **w != 0.0).map(|(w, z)| w * z).sum()
            };
            let during = variable.during.iter().zip(driving).filter(|(_, drives)| **drives);
            let inflow_hz =
                variable.rate_hz + sum(&variable.release) + during.map(|(rate, _)| rate).sum::<f64>();
            let next = match variable.decay_s {
                // After a pause longer than τ it is where it tends to.
                Some(decay_s) if dt_s >= decay_s => decay_s * inflow_hz,
                Some(decay_s) => *value + dt_s * (inflow_hz - *value / decay_s),
                None => *value + dt_s * inflow_hz,
            };
            // A reading that is no number changes nothing.
            if !next.is_nan() {
                let [least, most] = variable.range;
                *value = next.clamp(least, most);
            }
            let [below, above] = variable.lethal;
            if below.is_some_and(|below| *value <= below) || above.is_some_and(|above| *value >= above) {
                self.dead.get_or_insert(place);
            }
        }
    }

    /// Scales the sensed state variables, and puts its own behind them.
    pub fn extend(&self, state: &mut Vec<f64>) {
        for (variable, value) in self.variables.iter().zip(&self.values) {
            for (sensed, gain) in state.iter_mut().zip(&variable.gain) {
                *sensed *= 1.0 + gain * value;
            }
        }
        state.extend(&self.values);
    }

    /// The name of the variable by which the robot died, if it did.
    pub fn dead(&self) -> Option<&str> {
        self.dead.and_then(|place| self.variables.get(place)).map(|variable| variable.name.as_str())
    }

    /// The variables' values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable() -> InternalVariable {
        InternalVariable {
            name: "h".to_owned(),
            initial: 0.0,
            rate_hz: 0.0,
            decay_s: None,
            release: vec![0.0],
            during: vec![0.0],
            gain: vec![0.0],
            range: [0.0, 1.0],
            lethal: [None, None],
        }
    }

    /// The values after each second, with a stimulus for some of them.
    fn course(variable: InternalVariable, seconds: u32, sensed: impl Fn(f64) -> (f64, bool)) -> Vec<f64> {
        let mut state = InternalState::new(vec![variable]);
        let step = |step: u32| {
            let (z, drives) = sensed(f64::from(step) * 0.01);
            state.step(&[z], &[drives], 0.01);
            state.values()[0]
        };
        (0..100 * seconds).map(step).skip(99).step_by(100).collect()
    }

    /// The hormones of §4.3.
    #[test]
    fn a_hormone_is_released_by_a_stimulus_and_outlasts_it() {
        let hormone = InternalVariable { release: vec![0.5], decay_s: Some(2.0), ..variable() };
        let values = course(hormone, 8, |at_s| (f64::from(at_s < 2.0), false));
        // 1 − exp(−t/2) while it is released, and exp(−t/2) of that afterwards.
        for (value, second) in values.iter().zip(1..) {
            let at_s = f64::from(second);
            let exact = (1.0 - (-at_s.min(2.0) / 2.0).exp()) * (-(at_s - 2.0).max(0.0) / 2.0).exp();
            assert!((value - exact).abs() < 2e-3, "{second} s: {value} is not {exact}");
        }
    }

    #[test]
    fn hunger_grows_and_falls_while_the_robot_eats() {
        let hunger = InternalVariable { rate_hz: 0.1, during: vec![-0.4], ..variable() };
        let values = course(hunger, 6, |at_s| (0.0, at_s >= 4.0));
        for (value, exact) in values.iter().zip([0.1, 0.2, 0.3, 0.4, 0.1, 0.0]) {
            assert!((value - exact).abs() < 1e-9, "{values:?}");
        }
    }

    #[test]
    fn it_scales_the_weights_of_what_is_sensed_and_counts_beside_it() {
        let state =
            InternalState::new(vec![InternalVariable { initial: 0.5, gain: vec![2.0], ..variable() }]);
        let mut variables = vec![0.3];
        state.extend(&mut variables);
        assert_eq!(variables, [0.6, 0.5]);
    }

    /// The lethal boundaries of §4.4.4, as in Fig. 7.2.
    #[test]
    fn who_comes_to_a_lethal_boundary_is_dead_also_if_it_comes_back() {
        let thirst =
            InternalVariable { rate_hz: 0.3, release: vec![-1.0], lethal: [None, Some(0.9)], ..variable() };
        let mut state = InternalState::new(vec![thirst]);
        for step in 0..400 {
            state.step(&[f64::from(u8::from(step > 350))], &[false], 0.01);
            // The sum of many steps may be off by one of them.
            if step != 299 {
                assert_eq!(state.dead(), (step >= 300).then_some("h"), "{step}");
            }
        }
        assert!(state.values()[0] < 0.9);
    }

    #[test]
    fn a_pause_and_a_reading_that_is_no_number_leave_it_in_its_range() {
        let fast = InternalVariable { rate_hz: 1.0, decay_s: Some(0.1), ..variable() };
        let mut state = InternalState::new(vec![fast]);
        state.step(&[0.0], &[false], 1e4);
        assert!((state.values()[0] - 0.1).abs() < 1e-9, "{state:?}");
        let released = InternalVariable { release: vec![1.0], ..variable() };
        let mut state = InternalState::new(vec![released]);
        state.step(&[f64::NAN], &[false], 0.1);
        assert_eq!(state.values(), [0.0]);
    }
}
