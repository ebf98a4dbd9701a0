//! The robot's end: it finds commands among bytes, and has what they leave behind.

use serde::{Deserialize, Serialize};

use super::{FLOOR, SENSORS};
use crate::buffer::Buffer;

/// The most bytes of a line, its end not counted.
pub const MOST_COLLECTED: usize = 64;

/// The most binary letters that are answered together: of the longest answers as many as a message has room for.
pub const MOST_ASKED: usize = 32;

/// The effect of a command on the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// The left and the right wheel turn at these speeds, in steps a second; beyond [`FULL_STEPS_S`](super::FULL_STEPS_S) as fast as
    /// they can.
    Drive([i16; 2]),
    /// The counters of steps [are set](Machine::set_steps) to these.
    SetSteps([i16; 2]),
    /// The proximity sensors [are calibrated](Machine::calibrate).
    Calibrate,
    /// The robot starts again, as the machine has done.
    Reset,
    /// The robot has only to answer.
    Answer,
    /// The line is no command, which the robot says.
    Unknown,
}

/// The firmware's state: part of a command, an answer that is owed, and all that commands set. Pairs are of the left and the right wheel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    input: Input,
    /// The line so far; of a binary command the letter and its data.
    collected: Buffer<MOST_COLLECTED>,
    pub(super) owed: Reply,
    /// Binary letters that ask for something.
    pub(super) asked: Buffer<MOST_ASKED>,
    /// As they were last asked for.
    pub(super) speeds: [i16; 2],
    steps: [i16; 2],
    /// Mode, width, height and zoom.
    pub(super) camera: [i16; 4],
    /// The counters of steps are the robot's counts less these.
    pub(super) first_steps: [i16; 2],
    /// The values of the proximity sensors with nothing near.
    pub(super) residual: [i16; SENSORS],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Input {
    Between,
    Line,
    Binary,
}

/// The answer that is to be sent now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Reply {
    Nothing,
    /// The answer to a line that begins with this letter.
    Text(u8),
    /// The answers to the binary letters.
    Binary,
}

impl Default for Machine {
    fn default() -> Self {
        Self::new()
    }
}

impl Machine {
    /// The state of a robot that has been switched on.
    pub const fn new() -> Self {
        Self {
            input: Input::Between,
            collected: Buffer::new(),
            owed: Reply::Nothing,
            asked: Buffer::new(),
            speeds: [0; 2],
            steps: [0; 2],
            camera: CAMERA,
            first_steps: [0; 2],
            residual: [0; SENSORS],
        }
    }

    /// Takes the next byte from the wire. Gives the effect of the command that it ends. What [is owed](Self::owes) then is to be
    /// answered before the next byte.
    pub fn push(&mut self, byte: u8) -> Option<Deed> {
        if self.input == Input::Between {
            self.input = match byte {
                0 => return None,
                1..=127 => Input::Line,
                128.. => Input::Binary,
            };
            self.collected.clear();
            self.asked.clear();
        }
        if self.input == Input::Line { self.push_line(byte) } else { self.push_binary(byte) }
    }

    /// Whether an answer is to be sent.
    pub fn owes(&self) -> bool {
        self.owed != Reply::Nothing
    }

    /// Ends of lines before a line are passed over, and begin it: the robot takes what follows for text, binary letters too.
    fn push_line(&mut self, byte: u8) -> Option<Deed> {
        if !is_end(byte) {
            self.collected.push(byte);
            return None;
        }
        let line = core::mem::take(&mut self.collected);
        let (&first, text) = line.used().split_first()?;
        self.input = Input::Between;
        // `b` and `g` are letters of their own.
        let letter = if matches!(first, b'b' | b'g') { first } else { first.to_ascii_uppercase() };
        self.owed = Reply::Text(letter);
        Some(match letter {
            b'D' => {
                scan(text, &mut self.speeds);
                Deed::Drive(self.speeds)
            }
            // The speeds that `E` tells stay what they were.
            b'S' => Deed::Drive([0; 2]),
            b'P' => {
                scan(text, &mut self.steps);
                Deed::SetSteps(self.steps)
            }
            b'J' => {
                self.set_camera(text);
                Deed::Answer
            }
            b'K' => Deed::Calibrate,
            b'R' => {
                *self = Self { owed: self.owed, ..Self::new() };
                Deed::Reset
            }
            b'A' | b'b' | b'B' | b'C' | b'E' | b'F' | b'g' | b'G' | b'H' | b'I' | b'L' => Deed::Answer,
            b'M' | b'N' | b'O' | b'Q' | b'T' | b'U' | b'V' | b'W' => Deed::Answer,
            _ => Deed::Unknown,
        })
    }

    /// Of an image that is too large only the zoom is taken.
    fn set_camera(&mut self, text: &[u8]) {
        scan(text, &mut self.camera);
        if self.image_len() > IMAGE_ROOM {
            let ([.., zoom], [mode, width, height, _]) = (self.camera, CAMERA);
            self.camera = [mode, width, height, zoom];
        }
    }

    fn push_binary(&mut self, byte: u8) -> Option<Deed> {
        if self.collected.len() == 0 && byte == 0 {
            self.input = Input::Between;
            self.owed = if self.asked.len() > 0 { Reply::Binary } else { Reply::Nothing };
            return self.owes().then_some(Deed::Answer);
        }
        self.collected.push(byte);
        let (letter, data) = commands(self.collected.used()).next()?;
        let deed = match (letter, data) {
            (b'D', &[a, b, c, d]) => {
                self.speeds = pair([a, b, c, d]);
                Some(Deed::Drive(self.speeds))
            }
            (b'P', &[a, b, c, d]) => {
                self.steps = pair([a, b, c, d]);
                Some(Deed::SetSteps(self.steps))
            }
            _ => {
                if answer_len(letter) > 0 {
                    self.asked.push(letter);
                }
                None
            }
        };
        self.collected.clear();
        deed
    }

    /// Bytes of an image. The firmware's numbers have 16 bits.
    pub(super) fn image_len(&self) -> i16 {
        let [mode, width, height, _] = self.camera;
        let pixels = width.wrapping_mul(height);
        if mode == GREY { pixels } else { pixels.wrapping_mul(2) }
    }
}

/// Reads `,1,2` as C's `scanf` reads `,%d,%d`: up to the first text that is no number. Numbers that are missing stay as they were.
fn scan(mut text: &[u8], numbers: &mut [i16]) {
    for number in numbers {
        let Some(rest) = text.strip_prefix(b",").map(<[u8]>::trim_ascii_start) else { return };
        let (sign, rest) = match rest {
            [b'-', rest @ ..] => (-1, rest),
            [b'+', rest @ ..] => (1, rest),
            _ => (1, rest),
        };
        let len = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let (digits, behind) = rest.split_at(len);
        if digits.is_empty() {
            return;
        }
        let digit = |number: i16, byte: &u8| number.wrapping_mul(10).wrapping_add(i16::from(byte - b'0'));
        *number = digits.iter().fold(0, digit).wrapping_mul(sign);
        text = behind;
    }
}

/// Whether these bytes are a whole command: a line with its end, or binary letters with the 0 behind them.
pub(crate) fn is_whole(bytes: &[u8]) -> bool {
    match bytes {
        [] => false,
        [0, ..] => true,
        [1..=127, ..] => bytes.last().copied().is_some_and(is_end),
        [128..=255, ..] => commands(bytes).last().is_some_and(|(letter, _)| letter == 0),
    }
}

/// The binary commands in these bytes: the letter of each, with its sign changed back, and its data; 0 is the end of all. One
/// that lacks data is left out.
pub(crate) fn commands(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes;
    core::iter::from_fn(move || {
        let (&first, behind) = rest.split_first()?;
        let letter = first.wrapping_neg();
        let (data, behind) = behind.split_at_checked(data_len(letter))?;
        rest = behind;
        Some((letter, data))
    })
}

/// Bytes behind a binary letter.
const fn data_len(letter: u8) -> usize {
    match letter {
        b'D' | b'P' => 4,
        b'L' => 2,
        b'W' => 3,
        b'w' => 35,
        _ => 0,
    }
}

/// Bytes of the answer to a binary letter.
pub(crate) const fn answer_len(letter: u8) -> usize {
    match letter {
        b'A' => 12,
        b'N' | b'O' => 2 * SENSORS,
        b'M' => 2 * (FLOOR[0] + FLOOR[1]),
        b'a' | b'g' | b'u' => 6,
        b'E' | b'Q' => 4,
        b'b' => 2,
        b't' => 1,
        _ => 0,
    }
}

const fn is_end(byte: u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}

/// Two numbers, the low byte first.
const fn pair([a, b, c, d]: [u8; 4]) -> [i16; 2] {
    [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])]
}

/// The first parameters of the camera: colours, 40 × 40 pixels, a zoom of 8.
const CAMERA: [i16; 4] = [1, 40, 40, 8];

/// The mode of the camera with one byte a pixel.
const GREY: i16 = 0;

/// Bytes of the longest image.
const IMAGE_ROOM: i16 = 3456;
