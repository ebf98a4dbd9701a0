//! Stepper motor: it turns by one step a pulse, if it can follow.
//!
//! The signal sets the rate v of the pulses at once, and that is what firmware counts. Firmware that makes its pulses with
//! a timer of the rate f makes one every n = ⌊f / |v|⌋ ticks, so f / n pulses a second (e-puck: library/motor_led of
//! gctronic/e-puck-library; f = 10 kHz, and 950 steps/s become 1000). The rotor's rate moves
//! towards it by no more than an acceleration allows. Above the pull-out rate there is no torque left: the
//! rotor stands still at once. Pulses that the rotor did not follow are lost, and nothing tells the
//! firmware.
//!
//! Deviations. The notes have no stepper motors. A real rotor that cannot follow falls back by four steps
//! at a time or stalls altogether; here the difference is spread evenly, and a rotor that runs on when the
//! pulses stop counts as fewer lost steps. The rotor has the speed of its wheel, so that a robot which is
//! held back by a wall loses steps. A timer's speeds are whole numbers of steps/s within the full rate, as in the e-puck's
//! firmware. Coils that are switched off between two steps hold as well as others, and those of the e-puck are on all the
//! time from 601 steps/s on, where a hold of 1/650 s gives 92 to 100 % of it.

use core::f64::consts::TAU;

use baudbot_fields::number::{Between, NotNegative, Number, Thousandths, UpTo};
use baudbot_geometry::math;
use serde::{Deserialize, Serialize};

use crate::wheels::Wheels;

/// The model of a stepper motor and its gear box. The defaults are the e-puck's (e-puck.org, mechanics); acceleration and power are
/// guesses.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Stepper {
    /// Steps per turn of the wheel, including the gear box.
    #[serde(with = "Number::<Between<1, 1_000_000_000>>")]
    pub steps_per_turn: f64,
    /// Pulses per second at signal 1.
    #[serde(with = "Number::<Rate>")]
    pub full_rate_steps_s: f64,
    /// Pulse rate above which the rotor stalls. Default: `full_rate_steps_s`.
    pub max_rate_steps_s: Option<Number<Rate>>,
    /// Largest acceleration that the rotor follows.
    #[serde(with = "Number::<Rate>")]
    pub max_acceleration_steps_s2: f64,
    /// Electrical power of the coils while they are on, whether the motor turns or not.
    #[serde(with = "Number::<NotNegative>")]
    pub holding_w: f64,
    /// Frequency of the timer that makes the pulses. The commanded speed is rounded to whole steps per second, v, and
    /// a pulse comes every ⌊timer_hz / v⌋ ticks of the timer: with 10,000, 950 steps/s become 1000 and 800 become
    /// 833.3. Without it any rate is possible.
    pub timer_hz: Option<Number<Rate>>,
    /// Time after a step at which the coils are switched off, which saves power below 1 / `hold_ms` steps/s. Without
    /// it they are always on.
    #[serde(rename = "hold_ms")]
    pub hold_s: Option<Number<Thousandths<Between<0, 1_000_000>>>>,
}

/// Steps or ticks a second.
type Rate = UpTo<1_000_000_000>;

impl Default for Stepper {
    fn default() -> Self {
        Self {
            steps_per_turn: 1000.0,
            full_rate_steps_s: 1000.0,
            max_rate_steps_s: None,
            max_acceleration_steps_s2: 4000.0,
            holding_w: 0.5,
            timer_hz: None,
            hold_s: None,
        }
    }
}

/// The steps of one motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepperState {
    /// Steps commanded since the start, backwards taken off: what firmware counts.
    pub commanded_steps: f64,
    /// Steps commanded and not made. The wheel's true way is `commanded_steps - lost_steps`; negative if it
    /// ran on.
    pub lost_steps: f64,
}

/// The steps of a robot's two motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Steps {
    /// Of the left wheel.
    pub left: StepperState,
    /// Of the right wheel.
    pub right: StepperState,
}

impl Stepper {
    /// Commands `dt_s` of pulses at this rate, in steps/s, to the motor of a wheel that turns at this speed, in rad/s,
    /// and gives back the wheel's speed during that time.
    pub fn step(&self, state: &mut StepperState, wheel_speed_rad_s: f64, commanded: f64, dt_s: f64) -> f64 {
        let rate = self.rate_steps_s(wheel_speed_rad_s * self.steps_per_turn / TAU, commanded, dt_s);
        state.commanded_steps += commanded * dt_s;
        state.lost_steps += (commanded - rate) * dt_s;
        rate * TAU / self.steps_per_turn
    }

    /// Pulses a second that two motors get at these signals, negative backwards.
    #[inline]
    pub(crate) fn pulses(&self, signals: Wheels) -> Wheels {
        if self.timer_hz.is_some() {
            return self.timed_pulses(signals);
        }
        let Wheels { left, right } = signals;
        Wheels { left: self.full_rate_steps_s * left, right: self.full_rate_steps_s * right }
    }

    #[cold]
    #[inline(never)]
    fn timed_pulses(&self, Wheels { left, right }: Wheels) -> Wheels {
        Wheels { left: self.pulses_per_s(left), right: self.pulses_per_s(right) }
    }

    /// Pulses a second at this signal, negative backwards.
    pub fn pulses_per_s(&self, signal: f64) -> f64 {
        let asked = self.full_rate_steps_s * signal;
        let Some(timer_hz) = self.timer_hz else { return asked };
        let whole = math::round(asked.clamp(-self.full_rate_steps_s, self.full_rate_steps_s));
        if whole == 0.0 {
            return 0.0;
        }
        let timer_hz = timer_hz.get();
        let ticks = math::floor(timer_hz / whole.abs()).max(1.0);
        (timer_hz / ticks).copysign(whole)
    }

    /// Electrical power that it takes at this signal, in W: the coils' current does not depend on what the rotor does.
    pub fn power_w(&self, signal: f64) -> f64 {
        let share = self.hold_s.map_or(1.0, |hold| (hold.get() * self.pulses_per_s(signal).abs()).min(1.0));
        share * self.holding_w
    }

    /// The rotor's next rate. A change that it can follow gives the commanded rate itself, so that no step
    /// is lost to rounding.
    fn rate_steps_s(&self, rate: f64, commanded: f64, dt_s: f64) -> f64 {
        if commanded.abs() > self.max_rate_steps_s.map_or(self.full_rate_steps_s, Number::get) {
            return 0.0;
        }
        let (change, reach) = (commanded - rate, self.max_acceleration_steps_s2 * dt_s);
        if change.abs() <= reach { commanded } else { rate + reach.copysign(change) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Stepper, StepperState};
    use baudbot_fields::number::Number;

    /// The e-puck's: 20 steps a turn and a gear box of 50 : 1, at most 1000 steps/s (e-puck.org,
    /// mechanics).
    fn epuck() -> Stepper {
        Stepper { max_rate_steps_s: Some(Number::of(1000.0)), ..Stepper::default() }
    }

    /// With what its firmware does: a timer of 10 kHz, and coils that are on for 1/650 s after a step.
    fn epuck_firmware() -> Stepper {
        Stepper { timer_hz: Some(Number::of(10_000.0)), hold_s: Some(Number::of(1000.0 / 650.0)), ..epuck() }
    }

    /// The wheel's speed after these steps of 1 ms.
    fn run(motor: &Stepper, state: &mut StepperState, speed: f64, signal: f64, steps: u32) -> f64 {
        (0..steps).fold(speed, |speed, _| motor.step(state, speed, motor.pulses_per_s(signal), 0.001))
    }

    #[test]
    fn an_epuck_drives_at_12_88_cm_a_second() {
        let mut state = StepperState::default();
        let speed = 0.0205 * run(&epuck(), &mut state, 0.0, 1.0, 1000);
        assert!((speed - 0.1288).abs() < 5e-5, "{speed}");
    }

    #[test]
    fn a_timer_of_10_khz_makes_the_rates_of_an_epucks_firmware() {
        let motor = epuck_firmware();
        let rates = [1000, 950, 900, 800, 700, 600, 500, 400, 300];
        let found = rates.map(|asked| motor.pulses_per_s(f64::from(asked) / 1000.0));
        let ticks = [10.0, 10.0, 11.0, 12.0, 14.0, 16.0, 20.0, 25.0, 33.0];
        assert_eq!(found, ticks.map(|ticks| 10_000.0 / ticks));
        let back = rates.map(|asked| -motor.pulses_per_s(f64::from(-asked) / 1000.0));
        assert_eq!(back, found);
        // Of a signal of 11 bits the whole speed counts: 512 of 1023 is 500.5 steps/s.
        assert_eq!(motor.pulses_per_s(512.0 / 1023.0), 500.0);
        // Firmware asks for nothing beyond its full rate, and for nothing below a step a second.
        assert_eq!(
            [1.2, -1.2, 0.0004, 0.0].map(|signal| motor.pulses_per_s(signal)),
            [1000.0, -1000.0, 0.0, 0.0]
        );
        let slow = Stepper { timer_hz: Some(Number::of(300.0)), ..motor };
        assert_eq!(slow.pulses_per_s(1.0), 300.0);
    }

    #[test]
    fn the_steps_of_a_timer_are_those_that_are_counted_and_made() {
        let (motor, mut state) = (epuck_firmware(), StepperState::default());
        let speed = run(&motor, &mut state, 0.0, 0.95, 2000);
        assert!((speed - core::f64::consts::TAU).abs() < 1e-12, "{speed}");
        assert!((state.commanded_steps - 2000.0).abs() < 1e-9, "{state:?}");
    }

    #[test]
    fn coils_that_are_switched_off_after_a_step_take_less_power_at_low_rates() {
        let motor = epuck_firmware();
        assert_eq!([0.0, 1.0, -0.7].map(|signal| motor.power_w(signal)), [0.0, 0.5, 0.5]);
        // 300 becomes 303 steps/s: on for 303/650 of the time.
        let found = motor.power_w(0.3);
        assert!((found - 0.5 * (10_000.0 / 33.0) / 650.0).abs() < 1e-12, "{found}");
        assert_eq!([0.0, 0.3, 1.0].map(|signal| epuck().power_w(signal)), [0.5; 3]);
    }

    #[test]
    fn a_jump_of_the_rate_loses_steps_until_the_rotor_has_caught_up() {
        let (motor, mut state) = (epuck(), StepperState::default());
        let speed = run(&motor, &mut state, 0.0, 1.0, 250);
        // 250 ms at 4000 steps/s²: the mean of 250 rates from 4 to 1000 steps/s.
        assert!((state.commanded_steps - 250.0).abs() < 1e-9, "{state:?}");
        assert!((state.lost_steps - (250.0 - 0.25 * 502.0)).abs() < 1e-9, "{state:?}");
        let lost = state.lost_steps;
        run(&motor, &mut state, speed, 1.0, 100);
        assert!((state.lost_steps - lost).abs() < 1e-9, "{state:?}");
        assert!((state.commanded_steps - 350.0).abs() < 1e-9, "{state:?}");
    }

    #[test]
    fn a_rate_that_rises_slowly_loses_nothing() {
        let (motor, mut state) = (epuck(), StepperState::default());
        (0..=500).fold(0.0, |speed, i| motor.step(&mut state, speed, f64::from(2 * i), 0.001));
        assert_eq!(state.lost_steps, 0.0);
        assert!((state.commanded_steps - 250.5).abs() < 1e-9, "{state:?}");
    }

    #[test]
    fn above_the_pull_out_rate_the_rotor_stands_still_and_every_step_is_lost() {
        let motor = Stepper { full_rate_steps_s: 1200.0, ..epuck() };
        let mut state = StepperState::default();
        assert_eq!(run(&motor, &mut state, 6.0, 1.0, 100), 0.0);
        assert!((state.lost_steps - 120.0).abs() < 1e-9, "{state:?}");
        assert_eq!(state.commanded_steps, state.lost_steps);
    }

    #[test]
    fn a_rotor_that_runs_on_makes_more_steps_than_were_commanded() {
        let (motor, mut state) = (epuck(), StepperState::default());
        let speed = run(&motor, &mut state, core::f64::consts::TAU, 0.0, 300);
        assert_eq!((speed, state.commanded_steps), (0.0, 0.0));
        assert!((state.lost_steps + 0.25 * 498.0).abs() < 1e-9, "{state:?}");
    }
}
