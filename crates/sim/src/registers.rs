//! The registers of a Khepera, once a brain has used other commands than `N` and `D`.
//!
//! `microcontroller/khepera.rs` binds them to the robot.

use baudbot_wire::khepera::{Command, Register};
use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// The registers, and the answers that are owed. Pairs are of the left and the right wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Registers {
    /// Letters of commands to be answered, bit 0 that of `A`; then the refusals.
    owed: u32,
    /// The gains are kept, and without an effect: the motors' own regulators are those of the scenario.
    speed_gains: [i32; 3],
    position_gains: [i32; 3],
    pub(crate) target: [i32; 2],
    /// The position counters are the encoders' counts less these.
    zero: [i64; 2],
    pub(crate) profile_speed: [i32; 2],
    pub(crate) profile_acceleration: [i32; 2],
    pub(crate) pulse_width: [i32; 2],
    pub(crate) input: i32,
    led: i32,
    /// Whether each of the two LEDs is lit.
    leds: [bool; 2],
    /// Since when the wheels move to their targets; `None` if their speeds are controlled.
    pub(crate) moving_since: Option<SimTime>,
}

/// The values of the robot's registers after a reset (kMatlab's defaults).
impl Default for Registers {
    fn default() -> Self {
        Self {
            owed: 0,
            speed_gains: [3800, 800, 100],
            position_gains: [3000, 20, 4000],
            target: [0; 2],
            zero: [0; 2],
            profile_speed: [20; 2],
            profile_acceleration: [64; 2],
            pulse_width: [0; 2],
            input: 0,
            led: 0,
            leds: [false; 2],
            moving_since: None,
        }
    }
}

/// The next answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Say {
    /// The confirmation of a command, positions, readings, or several of these.
    Exchange(Owed),
    /// The answer to another command.
    Answer(Command),
    Refusal(Refusal),
}

/// Answers to `D`, `H` and `N` that a robot owes. What is asked for again while the answer waits is answered once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Owed {
    pub(crate) acknowledgement: bool,
    pub(crate) positions: bool,
    pub(crate) readings: bool,
}

impl Owed {
    pub(crate) const ACKNOWLEDGEMENT: Self =
        Self { acknowledgement: true, positions: false, readings: false };
    pub(crate) const POSITIONS: Self = Self { acknowledgement: false, positions: true, readings: false };
    pub(crate) const READINGS: Self = Self { acknowledgement: false, positions: false, readings: true };

    pub(crate) fn add(&mut self, other: Self) {
        self.acknowledgement |= other.acknowledgement;
        self.positions |= other.positions;
        self.readings |= other.readings;
    }
}

/// The reason why a line is not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The line begins with no command.
    NotFound,
    /// The line is malformed, or the robot lacks the device.
    Protocol,
}

impl Registers {
    /// The registers of a robot that owes this.
    pub(crate) fn owing(owed: Owed) -> Self {
        let mut registers = Self::default();
        registers.owe_exchange(owed);
        registers
    }

    pub(crate) fn owe_exchange(&mut self, owed: Owed) {
        self.owed |= (u32::from(owed.acknowledgement) * bit(b'D'))
            | (u32::from(owed.positions) * bit(b'H'))
            | (u32::from(owed.readings) * bit(b'N'));
    }

    pub(crate) fn owe(&mut self, command: Command) {
        self.owed |= bit(command.letter());
    }

    pub(crate) fn refuse(&mut self, refusal: Refusal) {
        self.owed |= match refusal {
            Refusal::NotFound => NOT_FOUND,
            Refusal::Protocol => PROTOCOL,
        };
    }

    pub(crate) fn owes(&self) -> bool {
        self.owed != 0
    }

    /// The first of what is owed, in the order of the alphabet, which is sent now. `D`, `H` and `N` go together.
    pub(crate) fn settle(&mut self) -> Option<Say> {
        let first = self.owed & self.owed.wrapping_neg();
        if first == 0 {
            return None;
        }
        let exchange = bit(b'D') | bit(b'H') | bit(b'N');
        let said = if first & exchange == 0 { first } else { self.owed & exchange };
        self.owed &= !said;
        if said & exchange != 0 {
            let [acknowledgement, positions, readings] =
                [b'D', b'H', b'N'].map(|letter| said & bit(letter) != 0);
            return Some(Say::Exchange(Owed { acknowledgement, positions, readings }));
        }
        let command = Command::ALL.into_iter().find(|command| bit(command.letter()) == said);
        let refusal = if said == NOT_FOUND { Refusal::NotFound } else { Refusal::Protocol };
        Some(command.map_or(Say::Refusal(refusal), Say::Answer))
    }

    /// A line sets a register, on a robot whose encoders have counted so far.
    pub(crate) fn set(&mut self, register: Register, value: i32, counts: [i64; 2]) {
        match register {
            Register::SpeedGain(gain) => self.speed_gains[gain as usize] = value,
            Register::PositionGain(gain) => self.position_gains[gain as usize] = value,
            Register::Target(side) => self.target[side as usize] = value,
            Register::Position(side) => {
                self.zero[side as usize] = counts[side as usize].wrapping_sub(value.into());
            }
            Register::InputNumber => self.input = value,
            Register::ProfileSpeed(side) => self.profile_speed[side as usize] = value,
            Register::ProfileAcceleration(side) => self.profile_acceleration[side as usize] = value,
            Register::LedNumber => self.led = value,
            Register::LedAction => {
                if let Some(led) = self.leds.get_mut(self.led as usize) {
                    *led = if value == 2 { !*led } else { value == 1 };
                }
            }
            Register::PulseWidth(side) => self.pulse_width[side as usize] = value,
            // Nothing is plugged in.
            Register::BusAddress | Register::BusByte | Register::Turret => {}
            // No line sets these.
            Register::Speed(_) | Register::Input | Register::Ambient(_) => {}
            Register::Reached(_) | Register::Mode(_) | Register::Error(_) => {}
        }
    }

    /// The position counters, of 32 bits, when the encoders have counted so far.
    pub(crate) fn positions(&self, counts: [i64; 2]) -> [i32; 2] {
        let [left, right] = [0, 1].map(|side| counts[side].wrapping_sub(self.zero[side]));
        [left as i32, right as i32]
    }

    /// The number of pulses that are missing to the targets.
    pub(crate) fn missing(&self, counts: [i64; 2]) -> [i32; 2] {
        let positions = self.positions(counts);
        [0, 1].map(|side| self.target[side].saturating_sub(positions[side]))
    }

    pub(crate) fn is_sound(&self) -> bool {
        let profile = self.profile_speed.iter().chain(&self.profile_acceleration);
        self.zero.iter().all(|zero| zero.unsigned_abs() < 1 << 60)
            && profile.into_iter().all(|value| (1..=255).contains(value))
            && self.owed < 2 * PROTOCOL
    }
}

/// The bit of a capital letter.
fn bit(letter: u8) -> u32 {
    1 << (letter - b'A')
}

const NOT_FOUND: u32 = 1 << 26;
const PROTOCOL: u32 = 1 << 27;

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use baudbot_wire::khepera::Access;

    use super::*;

    fn after(lines: &[&str]) -> Registers {
        let mut registers = Registers::default();
        for line in lines {
            for (register, value) in Access::parse(line.as_bytes()).unwrap().settings() {
                registers.set(register, value, [1000, -1000]);
            }
        }
        registers
    }

    #[test]
    fn an_led_is_switched_off_on_and_over() {
        for (lines, leds) in [
            (&["L,0,1"][..], [true, false]),
            (&["L,0,1", "L,1,2"], [true, true]),
            (&["L,1,2", "L,1,2"], [false, false]),
            (&["L,1,1", "L,1,1", "L,0,0"], [false, true]),
        ] {
            assert_eq!(after(lines).leds, leds, "{lines:?}");
        }
    }

    #[test]
    fn gains_and_profiles_are_kept() {
        let registers = after(&["A,1,2,3", "F,4,5,6", "J,7,8,9,10"]);
        assert_eq!((registers.speed_gains, registers.position_gains), ([1, 2, 3], [4, 5, 6]));
        assert_eq!((registers.profile_speed, registers.profile_acceleration), ([7, 9], [8, 10]));
    }

    #[test]
    fn positions_are_counted_from_what_they_were_set_to_and_wrap_at_32_bits() {
        let registers = after(&["G,5,2147483647", "C,10,-10"]);
        assert_eq!(registers.positions([1000, -1000]), [5, i32::MAX]);
        assert_eq!(registers.positions([993, -999]), [-2, i32::MIN]);
        assert_eq!(registers.missing([1000, -1000]), [5, i32::MIN]);
        assert!(registers.is_sound());
    }

    #[test]
    fn counts_and_speeds_of_any_size_are_no_panic() {
        let mut registers = after(&["G,-1,1"]);
        registers.set(Register::Position(baudbot_wire::khepera::Side::Left), i32::MIN, [i64::MAX, i64::MIN]);
        assert_eq!(registers.positions([i64::MAX, i64::MIN])[0], i32::MIN);
        assert_eq!(registers.positions([i64::MIN, i64::MAX]), [-i32::MAX, 1000]);
    }

    #[test]
    fn what_is_owed_is_said_in_the_order_of_the_alphabet_and_readings_go_with_an_acknowledgement() {
        let mut exchange = Owed::ACKNOWLEDGEMENT;
        exchange.add(Owed::POSITIONS);
        exchange.add(Owed::READINGS);
        let mut registers = Registers::owing(exchange);
        registers.refuse(Refusal::Protocol);
        registers.refuse(Refusal::NotFound);
        registers.owe(Command::WriteBus);
        registers.owe(Command::Version);
        registers.owe(Command::Version);
        let said: Vec<_> = core::iter::from_fn(|| registers.settle()).collect();
        assert_eq!(
            said,
            [
                Say::Answer(Command::Version),
                Say::Exchange(exchange),
                Say::Answer(Command::WriteBus),
                Say::Refusal(Refusal::NotFound),
                Say::Refusal(Refusal::Protocol),
            ]
        );
    }
}
