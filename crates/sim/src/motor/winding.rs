//! DC motors whose windings have an inductance: Wahde 2016, Eqs. (1.1)–(1.7).
//!
//! ```text
//! V      = L di/dt + R i + c_e ω                   (1.1), (1.2)
//! I dω/dt = c_t i − c_C sgn(ω) − c_v ω − τ         (1.3), (1.5), (1.7)
//! ```
//!
//! A rotor turns with its wheel, so that its I is a part of the wheel's inertia in (2.26) and (2.30)
//! ([`DcMotor::inertia_at_wheel_kg_m2`]). The speeds of the body and the two currents are left: four equations, which are
//! linear as long as no wheel changes its [`Phase`]. A winding's time constant L / R may be far shorter than a step, so they
//! are solved by the exponential of their matrix, exactly. A step is cut where a phase changes.
//!
//! Deviations. Friction at standstill and the largest torque are those of [`DcMotor`]. The torque limit acts on what the gear
//! gives before the rotor's own inertia is taken off. The voltage is constant during a step: the bridge's PWM is far faster than
//! the winding.

use super::DcMotor;
use super::dc::STANDSTILL;

/// A body and its wheels, as its motors see them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    /// Forward acceleration, in m/s², for each N m on a wheel, and turning acceleration, in rad/s², for each N m of difference.
    pub(crate) gains: [f64; 2],
    /// The share of the forward speed, and of the turn rate, that damping takes away, in 1/s.
    pub(crate) losses: [f64; 2],
    /// The speed of the right wheel, in rad/s, for each m/s of forward speed, and for each rad/s of turn rate; the left wheel's
    /// differs in the sign of the second.
    pub(crate) wheel_rates: [f64; 2],
    /// By how much the wheels turn faster than the body moves, in rad/s, left and right: they do if that slides along something.
    pub(crate) slides_rad_s: [f64; 2],
}

/// The motion that two motors and their load share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flow {
    /// Forward speed, in m/s, and turn rate, in rad/s.
    pub(crate) speeds: [f64; 2],
    /// The currents in the left and the right winding, in A.
    pub(crate) currents_a: [f64; 2],
}

/// The present law of a wheel's torque.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// It turns in this direction, 1 or −1, or is about to.
    Turning(f64),
    /// Friction holds it.
    Standing,
    /// The gear gives the largest torque in this direction, 1 or −1.
    Limited(f64),
}

/// A step is cut into no shorter parts than this share of it: within it friction brings a wheel to a stand from a speed that counts
/// as standing still.
const SHORTEST_PART: f64 = 1.0 / (1 << 24) as f64;

/// Parts of a step. A change of phase takes some fifty to find, so that three are found.
const MOST_PARTS: usize = 160;

impl Load {
    /// The motion after `dt` seconds in which the two motors have these voltages, left and right.
    pub(crate) fn advance(&self, motor: &DcMotor, voltages_v: [f64; 2], flow: Flow, dt: f64) -> Flow {
        let (mut flow, mut rest, mut part) = (flow, dt, dt);
        for _ in 0..MOST_PARTS {
            let phases = self.phases(motor, &flow);
            let next = flow.after(&self.rates(motor, phases, voltages_v), part);
            let changes = self.phases(motor, &next) != phases;
            if changes && part > dt * SHORTEST_PART {
                part *= 0.5;
                continue;
            }
            (flow, rest) = (next, rest - part);
            if rest <= 0.0 {
                return flow;
            }
            part = if changes { rest } else { part.min(rest) };
        }
        flow.after(&self.rates(motor, self.phases(motor, &flow), voltages_v), rest)
    }

    /// The fastest rate, in 1/s, at which anything changes.
    pub(crate) fn fastest_hz(&self, motor: &DcMotor) -> f64 {
        norm(&self.rates(motor, [Phase::Turning(1.0); 2], [0.0; 2]))
    }

    /// The law of each wheel's torque, left and right.
    fn phases(&self, motor: &DcMotor, flow: &Flow) -> [Phase; 2] {
        [0, 1].map(|side| {
            let shaft_rad_s = motor.gear_ratio * self.wheel_rad_s(side, flow.speeds);
            let generated_nm = motor.torque_constant_nm_a * flow.currents_a[side];
            let direction = if shaft_rad_s.abs() >= STANDSTILL { shaft_rad_s } else { generated_nm };
            if shaft_rad_s.abs() < STANDSTILL && generated_nm.abs() <= motor.coulomb_friction_nm {
                return Phase::Standing;
            }
            let direction = 1f64.copysign(direction);
            let lost_nm = motor.coulomb_friction_nm * direction + motor.viscous_friction_nm_s * shaft_rad_s;
            let output_nm = motor.at_wheel_nm(generated_nm - lost_nm);
            if output_nm.abs() >= motor.max_torque_nm {
                return Phase::Limited(1f64.copysign(output_nm));
            }
            Phase::Turning(direction)
        })
    }

    fn wheel_rad_s(&self, side: usize, [forward, turn]: [f64; 2]) -> f64 {
        let [of_forward, of_turn] = self.wheel_rates;
        of_forward * forward + SIGNS[side] * of_turn * turn + self.slides_rad_s[side]
    }

    /// The matrix of the rates of change of forward speed, turn rate, and sum and difference of the currents; its last column holds
    /// what does not depend on them. Of wheels in one phase, sum and difference do not touch each other, to the bit.
    fn rates(&self, motor: &DcMotor, phases: [Phase; 2], voltages_v: [f64; 2]) -> Matrix {
        let mut rates = [[0.0; SIZE]; SIZE];
        for (mode, loss) in self.losses.into_iter().enumerate() {
            rates[mode][mode] -= loss;
        }
        for (side, phase) in phases.into_iter().enumerate() {
            // The shaft's speed by forward speed and turn rate, and what comes to that by sliding.
            let sign = SIGNS[side];
            let [of_forward, of_turn] = self.wheel_rates.map(|rate| motor.gear_ratio * rate);
            let shaft = [of_forward, sign * of_turn, motor.gear_ratio * self.slides_rad_s[side]];
            let mut torque = [0.0; SIZE];
            match phase {
                Phase::Standing => {}
                Phase::Limited(direction) => torque[CONSTANT] = direction * motor.max_torque_nm,
                Phase::Turning(direction) => {
                    let lost = shaft.map(|speed| motor.at_wheel_nm(motor.viscous_friction_nm_s * speed));
                    (torque[0], torque[1]) = (-lost[0], -lost[1]);
                    let of_current = 0.5 * motor.at_wheel_nm(motor.torque_constant_nm_a);
                    (torque[2], torque[3]) = (of_current, sign * of_current);
                    torque[CONSTANT] = -lost[2] - motor.at_wheel_nm(motor.coulomb_friction_nm * direction);
                }
            }
            let emf = shaft.map(|speed| motor.emf_constant_v_s * speed / motor.inductance_h);
            let decay = -0.5 * motor.resistance_ohm / motor.inductance_h;
            let constant = voltages_v[side] / motor.inductance_h - emf[2];
            let current = [-emf[0], -emf[1], decay, sign * decay, constant];
            for column in 0..SIZE {
                rates[0][column] += self.gains[0] * torque[column];
                rates[1][column] += sign * self.gains[1] * torque[column];
                rates[2][column] += current[column];
                rates[3][column] += sign * current[column];
            }
        }
        rates
    }
}

impl Flow {
    /// The motion `dt` seconds later under these rates.
    fn after(&self, rates: &Matrix, dt: f64) -> Self {
        let [forward, turn] = self.speeds;
        let [left, right] = self.currents_a;
        let state = [forward, turn, left + right, right - left, 1.0];
        let matrix = exponential(rates.map(|row| row.map(|rate| rate * dt)));
        let [forward, turn, sum, difference, _] =
            matrix.map(|row| row.iter().zip(&state).map(|(factor, value)| factor * value).sum());
        Self { speeds: [forward, turn], currents_a: [0.5 * (sum - difference), 0.5 * (sum + difference)] }
    }
}

/// The sign with which the turn rate is a part of the left and the right wheel's speed.
const SIGNS: [f64; 2] = [-1.0, 1.0];

/// Four quantities, and the constant 1.
const SIZE: usize = 5;
const CONSTANT: usize = SIZE - 1;
type Matrix = [[f64; SIZE]; SIZE];

/// Of the Taylor series of a matrix with a norm of a half, so many terms give all bits.
const TERMS: u32 = 14;

/// A matrix that changes its vector by more than a factor of 2^64 has no use.
const MOST_SQUARINGS: u32 = 64;

/// The exponential of a matrix, by scaling and squaring: Moler & Van Loan 2003, method 3. Its arithmetic has one order on every
/// machine, which libraries of linear algebra do not promise.
fn exponential(matrix: Matrix) -> Matrix {
    let (mut squarings, mut scale) = (0, 1.0);
    while scale * norm(&matrix) > 0.5 && squarings < MOST_SQUARINGS {
        (scale, squarings) = (0.5 * scale, squarings + 1);
    }
    let scaled = matrix.map(|row| row.map(|value| value * scale));
    let mut sum = identity();
    for term in (1..=TERMS).rev() {
        let product = times(&scaled, &sum).map(|row| row.map(|value| value / f64::from(term)));
        sum = identity();
        for (row, added) in sum.iter_mut().zip(product) {
            row.iter_mut().zip(added).for_each(|(value, added)| *value += added);
        }
    }
    (0..squarings).fold(sum, |power, _| times(&power, &power))
}

/// The largest sum of a row.
fn norm(matrix: &Matrix) -> f64 {
    matrix.iter().map(|row| row.iter().map(|value| value.abs()).sum()).fold(0.0, f64::max)
}

fn identity() -> Matrix {
    let mut identity = [[0.0; SIZE]; SIZE];
    (0..SIZE).for_each(|i| identity[i][i] = 1.0);
    identity
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let mut product = [[0.0; SIZE]; SIZE];
    for (row, factors) in product.iter_mut().zip(a) {
        for (factor, b_row) in factors.iter().zip(b) {
            row.iter_mut().zip(b_row).for_each(|(value, other)| *value += factor * other);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::math;

    use super::{DcMotor, Flow, Load};

    /// ARSim's body with ARSim's motors, which have so much inductance.
    fn load() -> Load {
        Load { gains: [3.3, 50.0], losses: [0.1, 0.2], wheel_rates: [10.0, 2.0], slides_rad_s: [0.0; 2] }
    }

    fn motor(inductance_h: f64) -> DcMotor {
        DcMotor { inductance_h, max_torque_nm: 1e3, ..DcMotor::default() }
    }

    const AT_REST: Flow = Flow { speeds: [0.0; 2], currents_a: [0.0; 2] };

    /// (1.1)–(1.7) by the classical method of Runge and Kutta in steps of a microsecond. No wheel changes its direction.
    fn by_small_steps(load: &Load, motor: &DcMotor, voltages_v: [f64; 2], start: Flow, dt: f64) -> Flow {
        let rate = |x: [f64; 4]| {
            let shaft = |sign: f64| {
                motor.gear_ratio * (load.wheel_rates[0] * x[0] + sign * load.wheel_rates[1] * x[1])
            };
            let torque = |omega: f64, i: f64| {
                let net = motor.torque_constant_nm_a * i
                    - motor.coulomb_friction_nm * omega.signum()
                    - motor.viscous_friction_nm_s * omega;
                motor.gear_efficiency * motor.gear_ratio * net
            };
            let current = |v: f64, omega: f64, i: f64| {
                (v - motor.resistance_ohm * i - motor.emf_constant_v_s * omega) / motor.inductance_h
            };
            let [left, right] = [shaft(-1.0), shaft(1.0)];
            let [left_nm, right_nm] = [torque(left, x[2]), torque(right, x[3])];
            [
                load.gains[0] * (left_nm + right_nm) - load.losses[0] * x[0],
                load.gains[1] * (right_nm - left_nm) - load.losses[1] * x[1],
                current(voltages_v[0], left, x[2]),
                current(voltages_v[1], right, x[3]),
            ]
        };
        let along = |x: [f64; 4], k: [f64; 4], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
        let mut x = [start.speeds[0], start.speeds[1], start.currents_a[0], start.currents_a[1]];
        let h = 1e-6;
        for _ in 0..math::round(dt / h) as usize {
            let k1 = rate(x);
            let k2 = rate(along(x, k1, 0.5 * h));
            let k3 = rate(along(x, k2, 0.5 * h));
            let k4 = rate(along(x, k3, h));
            x = core::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        Flow { speeds: [x[0], x[1]], currents_a: [x[2], x[3]] }
    }

    fn assert_close(found: Flow, expected: Flow, tolerance: f64) {
        let all = |flow: Flow| [flow.speeds, flow.currents_a].concat();
        for (a, b) in all(found).into_iter().zip(all(expected)) {
            assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn moving_motors_follow_the_equations_as_small_steps_do() {
        // From inductances whose time constant is 16 µs to such that swing with the body.
        for inductance_h in [1e-5, 1e-3, 0.1, 2.0] {
            let (load, motor) = (load(), motor(inductance_h));
            let start = Flow { speeds: [0.4, 0.3], currents_a: [1.0, -0.5] };
            let expected = by_small_steps(&load, &motor, [6.0, 5.0], start, 0.05);
            let once = load.advance(&motor, [6.0, 5.0], start, 0.05);
            assert_close(once, expected, 1e-9);
            let often = (0..50).fold(start, |flow, _| load.advance(&motor, [6.0, 5.0], flow, 1e-3));
            assert_close(often, expected, 1e-9);
        }
    }

    #[test]
    fn a_locked_winding_takes_the_current_of_its_time_constant() {
        // Friction holds the wheels: i = V/R (1 − e^(−t R/L)), until c_t i is c_C.
        let motor = motor(0.01);
        let flow = load().advance(&motor, [0.12, -0.12], AT_REST, 0.01);
        let expected = 0.12 / 0.62 * (1.0 - math::exp(-0.01 * 62.0));
        assert_close(flow, Flow { speeds: [0.0; 2], currents_a: [expected, -expected] }, 1e-12);
    }

    #[test]
    fn a_wheel_breaks_away_when_its_current_has_overcome_friction() {
        // c_C / c_t = 0.24024 A are reached after −L/R ln(1 − 0.24024 R/V) = 0.2014 ms.
        let (load, motor) = (load(), motor(0.01));
        let at = -0.01 / 0.62 * math::ln(1.0 - 0.008 / 0.0333 * 0.62 / 12.0);
        assert_eq!(load.advance(&motor, [12.0; 2], AT_REST, at - 1e-7).speeds, [0.0; 2]);
        let away = load.advance(&motor, [12.0; 2], AT_REST, at + 1e-3);
        let turning = Flow { speeds: [1e-12, 0.0], currents_a: [0.008 / 0.0333; 2] };
        let expected = by_small_steps(&load, &motor, [12.0; 2], turning, 1e-3);
        assert_close(away, expected, 1e-6);
    }

    #[test]
    fn without_inductance_the_current_is_the_stationary_one_of_1_8() {
        // Time constants of a microsecond and less: the current lags behind the stationary one by as much time.
        for inductance_h in [6.2e-7, 6.2e-8, 6.2e-9] {
            let motor = motor(inductance_h);
            let flow = load().advance(&motor, [6.0, 5.0], Flow { speeds: [0.4, 0.3], ..AT_REST }, 0.01);
            let [forward, turn] = flow.speeds;
            for (side, sign, voltage_v) in [(0, -1.0, 6.0), (1, 1.0, 5.0)] {
                let wheel_rad_s = 10.0 * forward + sign * 2.0 * turn;
                let stationary_a = (voltage_v - 0.0333 * 2.0 * wheel_rad_s) / 0.62;
                let expected_nm = motor.torque_nm(voltage_v / 12.0, wheel_rad_s);
                let shaft_rad_s = 2.0 * wheel_rad_s;
                let torque_nm = 2.0 * (0.0333 * flow.currents_a[side] - 0.008 - 0.02 * shaft_rad_s);
                let lag_a = inductance_h / 0.62 * 0.0333 * 20.0 * 50.0 / 0.62;
                assert!((flow.currents_a[side] - stationary_a).abs() < lag_a, "{flow:?} {stationary_a}");
                assert!((torque_nm - expected_nm).abs() < lag_a * 0.0666, "{torque_nm} {expected_nm}");
            }
        }
    }

    #[test]
    fn a_robot_that_coasts_comes_to_a_stand_and_stays() {
        let (load, motor) = (load(), motor(1e-3));
        let mut flow = Flow { speeds: [0.5, 0.0], currents_a: [0.0; 2] };
        for _ in 0..200 {
            flow = load.advance(&motor, [0.0; 2], flow, 0.01);
        }
        let stands = load.advance(&motor, [0.0; 2], flow, 0.01);
        assert!(flow.speeds[0].abs() < 1e-7, "{flow:?}");
        assert!((stands.speeds[0] - flow.speeds[0]).abs() < 1e-9, "{flow:?} {stands:?}");
    }

    #[test]
    fn a_robot_whose_motors_are_alike_drives_straight_on_to_the_bit() {
        let (load, motor) = (load(), motor(1e-3));
        let mut flow = AT_REST;
        for _ in 0..100 {
            flow = load.advance(&motor, [7.3; 2], flow, 1e-3);
            let [left_a, right_a] = flow.currents_a;
            assert!(flow.speeds[1] == 0.0 && left_a == right_a, "{flow:?}");
        }
    }

    #[test]
    fn the_gear_gives_no_more_than_its_largest_torque() {
        let motor = DcMotor { max_torque_nm: 0.01, ..motor(1e-3) };
        let load = Load { losses: [0.0; 2], ..load() };
        let start = Flow { speeds: [0.1, 0.0], currents_a: [5.0; 2] };
        let flow = load.advance(&motor, [12.0; 2], start, 0.01);
        // 3.3 · 2 · 0.01 N m for 0.01 s.
        assert!((flow.speeds[0] - 0.1 - 3.3 * 2.0 * 0.01 * 0.01).abs() < 1e-12, "{flow:?}");
    }
}
