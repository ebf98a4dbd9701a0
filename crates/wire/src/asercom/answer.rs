//! The robot's answers.

use super::machine::Reply;
use super::{FLOOR, Machine, SENSORS};
use crate::lines::Writer;

/// The readings in an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// The counters of steps.
    pub steps: bool,
    /// The proximity sensors.
    pub proximity: bool,
}

/// The answer to a line that begins with no command.
pub const NOT_FOUND: &[u8] = b"z,Command not found\r\n";

/// The text of a robot that has started.
pub const WELCOME: &[u8] =
    b"\x0c\x07WELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";

impl Machine {
    /// Writes the answer that is owed, which is owed no more, to the front of `out`. Returns its length, and which readings are in it; 512
    /// bytes are enough, and what does not fit is left out. `code` gives the code of the last sample of a sensor's component, by the
    /// sensor's name, if the robot has it.
    pub fn answer(&mut self, code: impl Fn(&str, usize) -> Option<i16>, out: &mut [u8]) -> (usize, Content) {
        let (mut content, room) = (Content::default(), out.len());
        let mut line = Writer { out, len: 0 };
        match core::mem::replace(&mut self.owed, Reply::Nothing) {
            Reply::Nothing => {}
            Reply::Text(letter) => {
                content.note(letter);
                self.write_text(letter, &code, &mut line);
            }
            Reply::Binary => {
                for &letter in self.asked.used() {
                    content.note(letter);
                    self.write_binary(letter, &code, &mut line);
                }
            }
        }
        (line.len.min(room), content)
    }

    /// The counters of steps are these from now on.
    pub fn set_steps(&mut self, code: impl Fn(&str, usize) -> Option<i16>, to: [i16; 2]) {
        let [left, right] = [0, 1].map(|side| count(&code, side));
        self.first_steps = [left.wrapping_sub(to[0]), right.wrapping_sub(to[1])];
    }

    /// The values that the proximity sensors have now are 0 from now on.
    pub fn calibrate(&mut self, code: impl Fn(&str, usize) -> Option<i16>) {
        self.residual = INFRARED.map(|name| code(name, 0).unwrap_or(0));
    }

    /// The counters of steps, of 16 bits.
    fn steps(&self, code: &impl Fn(&str, usize) -> Option<i16>) -> [i16; 2] {
        let [left, right] = self.first_steps;
        [count(code, 0).wrapping_sub(left), count(code, 1).wrapping_sub(right)]
    }

    /// Calls `each` for the numbers in the answer to a line that begins with this letter, if there are any.
    fn numbers(&self, letter: u8, code: &impl Fn(&str, usize) -> Option<i16>, each: &mut impl FnMut(i16)) {
        let mut all = |numbers: &[i16]| numbers.iter().for_each(|number| each(*number));
        match letter {
            b'A' => all(&STANDING),
            b'b' => all(&[1]),
            b'C' => all(&[SELECTOR]),
            b'E' => all(&self.speeds),
            b'g' | b'U' => all(&[0; 3]),
            b'I' => {
                all(&self.camera);
                all(&[self.image_len()]);
            }
            b'M' => {
                all(&FLOORS.map(|name| code(name, 0).unwrap_or(0)));
                all(&[0; FLOOR[1]]);
            }
            b'N' => {
                for (name, residual) in INFRARED.iter().zip(self.residual) {
                    all(&[code(name, 0).unwrap_or(0).saturating_sub(residual).max(0)]);
                }
            }
            b'O' => all(&LIGHTS.map(|name| code(name, 0).unwrap_or(DARK))),
            b'Q' => all(&self.steps(code)),
            _ => {}
        }
    }

    fn write_text(&self, letter: u8, code: &impl Fn(&str, usize) -> Option<i16>, line: &mut Writer<'_>) {
        let said: &[&[u8]] = match letter {
            b'G' => &[b"g IR check : 0x0, address : 0x0, data : 0x0\r\n"],
            b'H' => &[HELP],
            b'K' => &[CALIBRATION],
            b'R' => &[b"r\r\n", WELCOME],
            b'V' => &[b"v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n"],
            b'A'..=b'F' | b'I' | b'J' | b'L'..=b'Q' | b'S'..=b'U' | b'W' | b'b' | b'g' => {
                line.put(letter.to_ascii_lowercase());
                self.numbers(letter, code, &mut |number| {
                    line.put(b',');
                    line.number(number.into());
                });
                &[b"\r\n"]
            }
            _ => &[NOT_FOUND],
        };
        said.iter().copied().flatten().for_each(|&byte| line.put(byte));
    }

    fn write_binary(&self, letter: u8, code: &impl Fn(&str, usize) -> Option<i16>, line: &mut Writer<'_>) {
        let mut put = |bytes: &[u8]| bytes.iter().for_each(|&byte| line.put(byte));
        let asked = match letter {
            b'A' => return SPHERICAL.iter().for_each(|number| put(&number.to_le_bytes())),
            b't' => return put(&[0]),
            b'a' => b'A',
            b'u' => b'U',
            _ => letter,
        };
        self.numbers(asked, code, &mut |number| put(&number.to_le_bytes()));
    }
}

impl Content {
    fn note(&mut self, letter: u8) {
        self.steps |= letter == b'Q';
        self.proximity |= letter == b'N';
    }
}

/// The count of the left or the right wheel since the start, by the robot's own counter.
fn count(code: &impl Fn(&str, usize) -> Option<i16>, side: usize) -> i16 {
    COUNTERS.iter().find_map(|name| code(name, side)).unwrap_or(0)
}

/// The names of the sensors that the letters tell.
pub(super) const INFRARED: [&str; SENSORS] = ["ir_0", "ir_1", "ir_2", "ir_3", "ir_4", "ir_5", "ir_6", "ir_7"];
const LIGHTS: [&str; SENSORS] =
    ["light_0", "light_1", "light_2", "light_3", "light_4", "light_5", "light_6", "light_7"];
const FLOORS: [&str; FLOOR[0]] = ["floor_0", "floor_1", "floor_2"];
pub(super) const COUNTERS: [&str; 2] = ["steps", "encoders"];

/// The position of the selector at which the firmware speaks asercom over Bluetooth.
const SELECTOR: i16 = 3;

/// The accelerometer of a robot that stands: 2048 is no acceleration, and 768 is 1 g.
const STANDING: [i16; 3] = [2048, 2048, 2048 + 768];

/// The same as strength, orientation and inclination in degrees.
const SPHERICAL: [f32; 3] = [768.0, 0.0, 0.0];

/// The value of a light sensor that sees none; a guess.
const DARK: i16 = 4000;

const CALIBRATION: &[u8] =
    b"k, Starting calibration - Remove any object in sensors range\r\nk, Calibration finished\r\n";

const HELP: &[u8] = b"\nA acceleration\r\nB,# body LED\r\nb battery\r\nC selector\r\nD,#,# set speeds\r\nE speeds\r\nF,# front LED\r\n\
    G IR receiver\r\ng gyro\r\nH help\r\nI camera\r\nJ,#,#,#,# set camera: mode,width,height,zoom\r\nK calibrate\r\nL,#,# LED\r\n\
    M floor\r\nN proximity\r\nO light\r\nP,#,# set steps\r\nQ steps\r\nR reset\r\nS stop\r\nT,# sound\r\nU microphones\r\nV version\r\n\
    W,#,#,# write I2C\r\n";
