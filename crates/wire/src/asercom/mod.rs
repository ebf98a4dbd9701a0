//! Asercom, the protocol of the e-puck's standard firmware ("advanced sercom"): a letter in a line of text, or letters in bytes. The
//! robot answers each, and sends nothing by itself.
//!
//! | to the robot | answer | meaning |
//! |---|---|---|
//! | `N` CR | `n,v0,…,v7` CR LF | the eight proximity sensors |
//! | `Q` CR | `q,l,r` CR LF | the steps of the left and the right wheel, 16 bits |
//! | `D,l,r` CR | `d` CR LF | speeds of the left and the right wheel, in steps a second |
//! | −`D` l l r r −`N` −`Q` 0 | 20 bytes | the same in bytes, the low byte of a number first |
//!
//! A line begins with a byte from 1 to 127 and ends with CR or LF. All letters but `b` and `g` may be small. Bytes from 128 on are letters
//! whose sign is changed, with their data behind them, until a 0 comes; then all of their answers are sent together. There is no
//! checksum and no time. An unknown line is answered with [`NOT_FOUND`], an unknown byte not at all.
//!
//! [`Machine`] is the robot's end. What a program of messages says that wants all readings is `Q`, if the robot counts steps, and `N`,
//! whose answer is the last. [`place`] says which sensor of ours is in these two.
//!
//! | letter | here |
//! |---|---|
//! | `A`, binary `a` and `A` | the values of a robot that stands on its wheels: no sensor of ours feels its weight |
//! | `B`, `F`, `L`, `T`, `W`, binary `L`, `W`, `w` | lamps, sounds and writing on the I²C bus are confirmed, without an effect |
//! | `C`, `b`, `g`, `G`, `U`, binary `b`, `g`, `t`, `u` | position 3 of the selector, a good battery, no turn, no signal, silence, 0 °C |
//! | `D`, `E`, `P`, `Q`, `S`, binary `D`, `E`, `P`, `Q` | as on the robot |
//! | `H` | a list of the letters, in other words |
//! | `I`, `J` | the parameters of the camera are told and set; binary `I` sends no image, as there is none |
//! | `K` | the sensors' values are 0 from now on; at once, by one sample, and not in a second by a hundred |
//! | `M`, binary `M` | sensors `floor_0` to `floor_2`; the two of cliffs are 0 |
//! | `N`, binary `N` | sensors `ir_0` to `ir_7` |
//! | `O`, binary `O` | sensors `light_0` to `light_7`; dark without |
//! | `R` | the wheels stand, all is as at the start; it takes no time |
//! | binary `U` | no microphone's buffer is sent |
//! | `V` | as on the robot |
//! | `Y`, `Z` | unknown: nothing is on the I²C bus |
//!
//! Sources. All of it is the firmware's: gctronic/e-puck-library on GitHub, program/DemoGCtronic-complete/Asercom.c (version 1.2.2, of
//! a robot before hardware 1.3, over Bluetooth), with e_prox.c, e_motors.c and memory.h beside it.
//!
//! # Deviations
//!
//! Besides the table: a sensor that the robot has not tells 0. Longer lines than [`MOST_COLLECTED`] lose their ends, and binary letters
//! beyond [`MOST_ASKED`] in one go have no answer, where the real one overflows. Numbers of a binary answer are those of the instant at
//! which it is sent, and not of the letter's.

mod answer;
mod machine;
mod readings;

pub use answer::{Content, NOT_FOUND, WELCOME};
pub use machine::{Deed, MOST_ASKED, MOST_COLLECTED, Machine};
pub(crate) use machine::{answer_len, commands, is_whole};
pub use readings::{SPEED, place};
pub(crate) use readings::{
    check, command_len, positions_len, question, read, read_positions, readings_len, write_exchange,
};

/// The greatest speed of a wheel, in steps a second; signal 1.
pub const FULL_STEPS_S: f64 = 1000.0;

/// The number of proximity sensors, and of those of light.
const SENSORS: usize = 8;

/// The number of sensors of the floor, and of cliffs beside them.
const FLOOR: [usize; 2] = [3, 2];

#[cfg(test)]
mod tests;
