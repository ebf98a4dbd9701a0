//! A battery: charge that is taken out, and a voltage that sinks with it.
//!
//! The voltage at the terminals is that of the open circuit, which depends on the charge left, less what
//! the internal resistance takes: V = V₀(q) − R I. A consumer of the power P draws the smaller current that
//! solves P = V I. No battery gives more than V₀² / (4 R). What a battery gives before it is empty falls with the
//! current: a current I takes I / c(I) of the charge, where c is the share of the capacity that a constant current of
//! this size gets out of it.
//!
//! Deviations. The notes speak of batteries that run low (§7.2.2, §8.2) and have no model of one. Over a
//! step the open-circuit voltage is taken as it is at its start. There is no self-discharge, no ageing and
//! no temperature. A real battery gives some of what a large current left in it to a smaller one afterwards; here that is
//! lost. Polarisation builds up over minutes; here it is a part of R, which is therefore several times what a meter finds at
//! 1 kHz.

use alloc::vec::Vec;

use baudbot_fields::number::{Between, NotNegative, Number, Positive, Share};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::math;
use serde::{Deserialize, Serialize};

use crate::curve::{self, LeastShare};

baudbot_fields::rules! {
    /// The voltage of a battery, in volts.
    Voltage: Positive, 1e-3, 1e6;
}

/// What a battery is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Battery {
    /// Nominal voltage.
    #[serde(with = "Number::<Voltage>")]
    pub nominal_v: f64,
    /// Charge when full, in mAh.
    #[serde(with = "Number::<Positive>")]
    pub capacity_mah: f64,
    /// Internal resistance, which lowers the voltage under load.
    #[serde(default, with = "Number::<NotNegative>")]
    pub internal_resistance_ohm: f64,
    /// Voltage without load, relative to the nominal voltage, over the remaining fraction of the charge: linear
    /// between the points, constant beyond the ends. Type: list of `[charge, voltage]`. Default: one for NiMH cells.
    /// Range: at least 1 point; charges 0 to 1, increasing; voltages 0 to 10.
    #[cfg_attr(feature = "schema", schemars(with = "curve::Points<Share, Between<0, 10>>", length(min = 1)))]
    #[serde(rename = "curve_share_v", default = "Battery::nimh_curve")]
    pub curve: Vec<(f64, f64)>,
    /// Fraction of the capacity that a constant current in A draws from the full battery: linear between the points,
    /// constant beyond the ends. Without it every current draws all of it. Type: list of `[current, share]`. Default:
    /// none. Range: currents 0 to 10^6, increasing; shares 0.001 to 1.
    #[cfg_attr(feature = "schema", schemars(with = "curve::Points<Current, LeastShare>"))]
    #[serde(rename = "capacity_a_share", default)]
    pub yields: Vec<(f64, f64)>,
    /// Constant power of the robot's electronics.
    #[serde(default, with = "Number::<NotNegative>")]
    pub idle_w: f64,
    /// Fraction of the charge that is left at the start.
    #[serde(default = "full", with = "Number::<Share>")]
    pub charge: f64,
}

/// A current, in A.
type Current = Between<0, 1_000_000>;

fn full() -> f64 {
    1.0
}

/// The state of a battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatteryState {
    /// Charge left, in C: from 0 to the battery's capacity.
    pub charge_c: f64,
    /// Current of the last step, in A, negative while charging.
    pub current_a: f64,
    /// Energy that was drawn from the terminals since the start, in J.
    pub used_j: f64,
    /// Energy that was put into the terminals since the start, in J.
    pub charged_j: f64,
}

impl Battery {
    /// The battery whose table stands at `path`, if its curves are some.
    ///
    /// # Errors
    /// Names the first point that is out of place.
    pub fn checked(self, path: &Path) -> Result<Self, FieldError> {
        let at = path.field("curve_share_v");
        curve::check::<Share, Between<0, 10>>(&at, &self.curve, ["share", "voltage"])?;
        if self.curve.is_empty() {
            return Err(
                at.error("needs at least one pair of charge left and fraction of the nominal voltage")
            );
        }
        let at = path.field("capacity_a_share");
        curve::check::<Current, LeastShare>(&at, &self.yields, ["current", "share"])?;
        Ok(self)
    }

    /// Charge when full, in C.
    pub fn capacity_c(&self) -> f64 {
        self.capacity_mah * 3.6
    }

    /// A curve for cells of nickel-metal hydride, such as four AA cells of 4.8 V together: flat for most of
    /// its length, with a knee at 1.0 V a cell. A guess after the look of data sheets, not a measurement.
    pub fn nimh_curve() -> Vec<(f64, f64)> {
        [(0.0, 0.0), (0.02, KNEE), (0.15, 0.95), (0.5, 1.0), (1.0, 1.1)].into()
    }

    /// This battery as it is at the start.
    pub fn at_start(&self) -> BatteryState {
        self.charged_to(self.charge)
    }

    /// This battery, full.
    pub fn full(&self) -> BatteryState {
        self.charged_to(1.0)
    }

    /// This battery with so much of its charge, from 0 to 1.
    pub fn charged_to(&self, share: f64) -> BatteryState {
        BatteryState { charge_c: share * self.capacity_c(), current_a: 0.0, used_j: 0.0, charged_j: 0.0 }
    }

    /// Voltage without a current, in V, when this share of the charge is left.
    pub fn open_circuit_v(&self, share: f64) -> f64 {
        self.nominal_v * curve::value(&self.curve, share)
    }

    /// Share of the capacity that a constant current of so many A gets out of it.
    pub fn yield_at(&self, current_a: f64) -> f64 {
        if self.yields.is_empty() { 1.0 } else { curve::value(&self.yields, current_a) }
    }

    /// The current at which a source of `source_v` gives `power_w`, or, if it cannot, as much as it can.
    fn discharging_a(&self, source_v: f64, power_w: f64) -> f64 {
        let resistance = self.internal_resistance_ohm;
        let rest = source_v * source_v - 4.0 * resistance * power_w;
        // Of the two solutions the smaller one, in the form that stays exact without a resistance.
        if rest > 0.0 { 2.0 * power_w / (source_v + math::sqrt(rest)) } else { source_v / (2.0 * resistance) }
    }

    /// The current with which a charger of `power_w` feeds a source of `source_v`.
    fn charging_a(&self, source_v: f64, power_w: f64) -> f64 {
        let resistance = self.internal_resistance_ohm;
        2.0 * power_w / (source_v + math::sqrt(source_v * source_v + 4.0 * resistance * power_w))
    }
}

impl BatteryState {
    pub(crate) fn is_sound(&self, battery: &Battery) -> bool {
        crate::sound::numbers([self.current_a, self.used_j, self.charged_j])
            && (0.0..=battery.capacity_c()).contains(&self.charge_c)
    }

    /// Draws this power for `dt_s`, or what the battery can give, and says how much energy that was, in J.
    /// An empty battery gives nothing.
    pub fn draw(&mut self, battery: &Battery, power_w: f64, dt_s: f64) -> f64 {
        self.current_a = 0.0;
        let source_v = battery.open_circuit_v(self.share(battery));
        if self.is_empty(battery) || power_w <= 0.0 || source_v <= 0.0 || dt_s <= 0.0 {
            return 0.0;
        }
        let current_a = battery.discharging_a(source_v, power_w);
        let share = battery.yield_at(current_a);
        self.current_a = current_a.min(share * self.charge_c / dt_s);
        let energy = (source_v - battery.internal_resistance_ohm * self.current_a) * self.current_a * dt_s;
        self.charge_c = (self.charge_c - self.current_a * dt_s / share).max(0.0);
        self.used_j += energy;
        energy
    }

    /// Charges with this power for `dt_s`, or with as much as there is room for, and says how much energy
    /// that was, in J. A flat battery takes current as if it were at its knee, or a charger of constant
    /// power would burn it.
    pub fn charge(&mut self, battery: &Battery, power_w: f64, dt_s: f64) -> f64 {
        self.current_a = 0.0;
        if power_w <= 0.0 || dt_s <= 0.0 {
            return 0.0;
        }
        let source_v = battery.open_circuit_v(self.share(battery)).max(KNEE * battery.nominal_v);
        let room_c = battery.capacity_c() - self.charge_c;
        let current_a = battery.charging_a(source_v, power_w).min(room_c / dt_s);
        let energy = (source_v + battery.internal_resistance_ohm * current_a) * current_a * dt_s;
        self.charge_c = (self.charge_c + current_a * dt_s).min(battery.capacity_c());
        self.current_a = -current_a;
        self.charged_j += energy;
        energy
    }

    /// Share of the capacity that is left, from 0 to 1.
    pub fn share(&self, battery: &Battery) -> f64 {
        self.charge_c / battery.capacity_c()
    }

    /// Voltage at the terminals, in V, at this current in A, negative while charging.
    pub fn voltage_v(&self, battery: &Battery, current_a: f64) -> f64 {
        battery.open_circuit_v(self.share(battery)) - battery.internal_resistance_ohm * current_a
    }

    /// Voltage at the terminals, in V, at the current of the last step.
    pub fn terminal_v(&self, battery: &Battery) -> f64 {
        self.voltage_v(battery, self.current_a).max(0.0)
    }

    /// Whether it gives no more power.
    pub fn is_empty(&self, battery: &Battery) -> bool {
        self.share(battery) < EMPTY
    }
}

/// Voltage at the knee of the curve, as a share of the nominal one: 1.0 V of 1.2 V.
const KNEE: f64 = 0.83;

/// Share of the charge below which a battery is empty. What is left sinks by ever smaller currents and
/// would never be gone.
const EMPTY: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::{Battery, BatteryState};

    /// Four AA cells.
    fn cells() -> Battery {
        Battery {
            nominal_v: 4.8,
            capacity_mah: 2000.0,
            internal_resistance_ohm: 0.1,
            curve: Battery::nimh_curve(),
            yields: Vec::new(),
            idle_w: 0.1,
            charge: 1.0,
        }
    }

    /// Draws or charges until nothing more comes of it: seconds, energy from ∫ V I dt, charge from ∫ I dt.
    fn until_it_ends(
        battery: &Battery,
        state: &mut BatteryState,
        step: impl Fn(&mut BatteryState) -> f64,
    ) -> (u32, f64, f64) {
        let (mut seconds, mut energy, mut charge) = (0, 0.0, 0.0);
        loop {
            let before = *state;
            if step(state) <= 0.0 {
                return (seconds, energy, charge);
            }
            seconds += 1;
            energy += before.voltage_v(battery, state.current_a) * state.current_a;
            charge += state.current_a;
            assert!((0.0..=battery.capacity_c()).contains(&state.charge_c), "{state:?}");
            assert!(seconds < 100_000, "{state:?}");
        }
    }

    #[test]
    fn the_energy_drawn_is_voltage_times_current_over_time_and_the_charge_is_the_current() {
        let battery = cells();
        let mut state = battery.full();
        let (seconds, energy, charge) =
            until_it_ends(&battery, &mut state, |state| state.draw(&battery, 5.0, 1.0));
        assert!((energy - state.used_j).abs() < 1e-6, "{energy} and {state:?}");
        assert!((battery.capacity_c() - charge - state.charge_c).abs() < 1e-6, "{charge} and {state:?}");
        // Nominally 34.6 kJ, 6912 s at 5 W; the resistance takes about 2 %.
        assert!((6600..7000).contains(&seconds), "{seconds}");
        assert!(energy < 4.8 * 7200.0, "{energy}");
    }

    #[test]
    fn a_load_gets_the_power_that_it_asks_for_while_there_is_some() {
        let battery = cells();
        let mut state = battery.full();
        let open = state.voltage_v(&battery, 0.0);
        assert!((open - 1.1 * 4.8).abs() < 1e-12, "{open}");
        assert!((state.draw(&battery, 10.0, 0.01) - 0.1).abs() < 1e-12);
        let current = state.current_a;
        assert!(((open - 0.1 * current) * current - 10.0).abs() < 1e-9, "{current}");
        assert!((state.terminal_v(&battery) - (open - 0.1 * current)).abs() < 1e-5);
        // A short circuit gets no more than V² / 4R.
        let most = battery.full().draw(&battery, 1e9, 1e-3) / 1e-3;
        assert!((most - open * open / 0.4).abs() < 1e-9, "{most}");
    }

    #[test]
    fn an_empty_battery_gives_nothing_and_can_be_charged_up_to_its_capacity() {
        let battery = cells();
        let mut state = battery.full();
        until_it_ends(&battery, &mut state, |state| state.draw(&battery, 20.0, 1.0));
        assert!(state.is_empty(&battery) && state.charge_c >= 0.0, "{state:?}");
        let used = state.used_j;
        assert_eq!((state.draw(&battery, 1.0, 1.0), state.used_j), (0.0, used));
        until_it_ends(&battery, &mut state, |state| state.charge(&battery, 10.0, 1.0));
        assert_eq!((state.charge_c, state.share(&battery)), (battery.capacity_c(), 1.0));
        assert!(!state.is_empty(&battery) && state.charged_j > used, "{state:?}");
    }

    #[test]
    fn an_ideal_battery_can_be_used_up_and_filled_too() {
        let battery = Battery { internal_resistance_ohm: 0.0, ..cells() };
        let mut state = battery.full();
        until_it_ends(&battery, &mut state, |state| state.draw(&battery, 50.0, 1.0));
        assert!(state.is_empty(&battery), "{state:?}");
        until_it_ends(&battery, &mut state, |state| state.charge(&battery, 50.0, 1.0));
        assert_eq!(state.charge_c, battery.capacity_c());
    }
}
