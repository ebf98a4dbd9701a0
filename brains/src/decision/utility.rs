//! The utility function method: Wahde 2016, Section 8.2, Eqs. (8.4) to (8.6).
//!
//! ```text
//! τᵢ u̇ᵢ + uᵢ = tanh(cᵢ (Σₖ wᵢₖ zₖ + bᵢ + Γᵢ))        (8.4), (8.5)
//! τᵢᴳ Γ̇ᵢ = −Γᵢ                                       (8.6)
//! ```
//!
//! Utilities stay within [-1, 1]. Of the motor behaviours the one with the greatest utility is active; of the cognitive
//! processes each with a positive one is. Both equations are integrated as the notes do, by Euler's method, the utility with
//! the Γ of before the step. Where a brain steps more seldom than a quarter of its least time constant, a step is done in
//! parts: Euler's method would otherwise overshoot.

use baudbot_geometry::math;

/// The utility function of one brain process: constants of (8.4) to (8.6).
#[derive(Clone, Debug, PartialEq)]
pub struct UtilityFunction {
    /// τ, in seconds: how quickly the utility follows.
    pub tau_s: f64,
    /// b: what the utility is about if all else is 0.
    pub bias: f64,
    /// c: how steep tanh is.
    pub slope: f64,
    /// w: one for each state variable.
    pub weights: Vec<f64>,
    /// τᴳ, in seconds: how quickly Γ falls off.
    pub gamma_tau_s: f64,
}

/// A utility as it changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Utility {
    function: UtilityFunction,
    value: f64,
    gamma: f64,
}

impl UtilityFunction {
    /// The value that the utility tends to: the right side of (8.4).
    ///
    /// State variables that are not there count as 0.
    pub fn target(&self, state: &[f64], gamma: f64) -> f64 {
        let sum: f64 = self.weights.iter().zip(state).map(|(weight, z)| weight * z).sum();
        math::tanh(self.slope * (sum + self.bias + gamma))
    }
}

impl Utility {
    /// A utility that begins where it would be if all state variables had always been 0.
    pub fn new(function: UtilityFunction) -> Self {
        let value = function.target(&[], 0.0);
        Self { function, value, gamma: 0.0 }
    }

    /// The constants.
    pub(crate) fn function(&self) -> &UtilityFunction {
        &self.function
    }

    /// u, in [-1, 1].
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Begins at this value instead, which is kept within [-1, 1].
    pub fn set_value(&mut self, value: f64) {
        self.value = value.clamp(-1.0, 1.0);
    }

    /// Γ, which a process sets to activate another or to stop it, and which falls off by itself.
    pub fn set_gamma(&mut self, gamma: f64) {
        self.gamma = if gamma.is_finite() { gamma } else { 0.0 };
    }

    /// Γ as it is.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Goes on by so many seconds, in which the state variables stay as they are.
    pub fn step(&mut self, state: &[f64], dt_s: f64) {
        let least = self.function.tau_s.min(self.function.gamma_tau_s);
        let parts = math::ceil(dt_s / (least / 4.0)).clamp(1.0, MOST_PARTS);
        let part_s = dt_s / parts;
        for _ in 0..parts as u32 {
            let target = self.function.target(state, self.gamma);
            // A reading that is no number changes nothing.
            let target = if target.is_finite() { target } else { self.value };
            // After a pause of minutes even the parts are too long; then it is simply where it tends to.
            self.value += (target - self.value) * (part_s / self.function.tau_s).min(1.0);
            self.gamma -= self.gamma * (part_s / self.function.gamma_tau_s).min(1.0);
        }
    }
}

/// The place of the greatest of these utilities, of equal ones the first: what a rational agent does (§7.2), and (7.13).
/// `None` if there is none; what is not a number is never chosen.
///
/// ```
/// use baudbot_brains::decision::utility::greatest;
/// assert_eq!(greatest([0.1, 0.7, 0.7, -2.0]), Some(1));
/// assert_eq!(greatest([]), None);
/// ```
pub fn greatest(utilities: impl IntoIterator<Item = f64>) -> Option<usize> {
    let mut best = None;
    for (place, value) in utilities.into_iter().enumerate() {
        if !value.is_nan() && best.is_none_or(|(_, greatest)| value > greatest) {
            best = Some((place, value));
        }
    }
    best.map(|(place, _)| place)
}

/// A step is not divided into more parts.
const MOST_PARTS: f64 = 1000.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// The utility function of Fig. 8.2.
    fn figure_8_2() -> UtilityFunction {
        UtilityFunction { tau_s: 0.3, bias: 1.0, slope: 1.0, weights: vec![0.5], gamma_tau_s: 0.3 }
    }

    /// Utility before the state variable is lost for 0.15 s, and at the end of that.
    fn dip(function: &UtilityFunction, z: f64) -> (f64, f64) {
        let mut utility = Utility::new(function.clone());
        utility.set_value(function.target(&[z], 0.0));
        let before = utility.value();
        (0..15).for_each(|_| utility.step(&[0.0], 0.01));
        (before, utility.value())
    }

    /// (8.4), (8.5) in Fig. 8.2.
    #[test]
    fn a_signal_that_is_lost_for_a_moment_makes_a_small_dip() {
        for (z, before, euler) in [
            (0.5, 0.848284, 0.034556),
            (0.8, 0.885352, 0.049332),
            (1.0, 0.905148, 0.057223),
            (2.0, 0.964028, 0.080693),
        ] {
            let (u, after) = dip(&figure_8_2(), z);
            assert!((u - before).abs() < 1e-6, "{z}: {u}");
            assert!((u - after - euler).abs() < 1e-6, "{z}: {}", u - after);
        }
    }

    #[test]
    fn how_much_of_a_loss_comes_through_depends_on_its_length_only() {
        let function = figure_8_2();
        for z in [0.3, 1.0, 1.7] {
            let (before, after) = dip(&function, z);
            let unfiltered = before - function.target(&[0.0], 0.0);
            assert!(((before - after) / unfiltered - 0.398617).abs() < 1e-6);
        }
        // And with ever smaller steps it is 1 - exp(-0.5).
        let mut utility = Utility::new(function.clone());
        utility.set_value(function.target(&[1.0], 0.0));
        let before = utility.value();
        (0..150_000).for_each(|_| utility.step(&[0.0], 1e-6));
        let part = (before - utility.value()) / (before - function.target(&[0.0], 0.0));
        assert!((part - 0.393469).abs() < 1e-5, "{part}");
    }

    /// (8.6).
    #[test]
    fn gamma_falls_off_exponentially() {
        let mut utility = Utility::new(figure_8_2());
        utility.set_gamma(1.0);
        (0..100).for_each(|_| utility.step(&[0.0], 0.01));
        assert!((utility.gamma() - 0.033703).abs() < 1e-6, "{}", utility.gamma());
    }

    /// A process that gamma wakes: active from 0.02 s to 2.4 s, most at 0.34 s.
    #[test]
    fn a_kick_of_gamma_activates_a_process_for_a_while() {
        let function =
            UtilityFunction { tau_s: 0.1, bias: -0.2, slope: 1.0, weights: Vec::new(), gamma_tau_s: 1.0 };
        let mut utility = Utility::new(function);
        utility.set_gamma(2.0);
        let mut course = vec![utility.value()];
        for _ in 0..400 {
            utility.step(&[], 0.01);
            course.push(utility.value());
        }
        let active: Vec<_> = (0..course.len()).filter(|&i| course[i] > 0.0).collect();
        assert_eq!((active[0], active.last().map(|last| last + 1)), (2, Some(240)));
        let peak = greatest(course.iter().copied()).unwrap();
        assert_eq!(peak, 34);
        assert!((course[peak] - 0.84391).abs() < 1e-5);
    }

    #[test]
    fn a_rival_is_overtaken_after_a_time_that_the_step_and_tau_say() {
        // From -0.5 towards 0.8, past a rival at 0.3: 0.9555 τ.
        let slope = 1.0;
        let function = UtilityFunction {
            tau_s: 1.0,
            bias: 1.0986122886681098,
            slope,
            weights: vec![],
            gamma_tau_s: 1.0,
        };
        assert!((function.target(&[], 0.0) - 0.8).abs() < 1e-12);
        let mut utility = Utility::new(function);
        utility.set_value(-0.5);
        let mut steps = 0;
        while utility.value() <= 0.3 {
            utility.step(&[], 1e-4);
            steps += 1;
        }
        assert!((f64::from(steps) * 1e-4 - 0.9555).abs() < 2e-4, "{steps}");
    }

    #[test]
    fn utilities_stay_within_bounds_however_seldom_a_brain_steps() {
        let function =
            UtilityFunction { tau_s: 0.1, bias: 3.0, slope: 2.0, weights: vec![-9.0], gamma_tau_s: 0.05 };
        for dt_s in [0.0, 0.01, 0.09, 0.19, 0.3, 2.0, 1e4] {
            let mut utility = Utility::new(function.clone());
            utility.set_gamma(-5.0);
            for i in 0..100 {
                utility.step(&[f64::from(i % 2)], dt_s);
                assert!(utility.value().abs() <= 1.0 && utility.gamma() <= 0.0, "{dt_s}: {utility:?}");
            }
        }
    }

    #[test]
    fn without_weights_a_utility_is_that_of_its_bias() {
        let mut function = figure_8_2();
        function.weights = vec![0.0];
        let mut utility = Utility::new(function);
        (0..1000).for_each(|_| utility.step(&[7.0], 0.01));
        assert!((utility.value() - 0.761594).abs() < 1e-6, "tanh(1)");
    }

    #[test]
    fn of_equal_utilities_the_first_is_the_greatest() {
        assert_eq!(greatest([0.1, 0.5, 0.5, -1.0]), Some(1));
        assert_eq!(greatest([]), None);
    }

    #[test]
    fn the_first_of_the_best_is_chosen() {
        assert_eq!(greatest([f64::NAN, -3.0, -2.0, f64::NAN, -2.0]), Some(2));
        assert_eq!(greatest([f64::NAN]), None);
        assert_eq!(greatest([f64::NEG_INFINITY]), Some(0));
    }
}
