//! The cable between a robot's UART and a program's: what each reads of what the other sends.
//!
//! Bytes pass as they are if both ends have the same settings. If they differ, each end reads the line as its UART
//! does ([`uart`](crate::uart)). A cable that has no UART at the robot's end (USB, or an ideal link) has no settings
//! that matter.

use std::collections::VecDeque;

use baudbot_board::far_end::{Read, Receiver, Settings};

/// Both directions of a cable. Instants are those of simulated time, in nanoseconds.
#[derive(Debug)]
pub struct Cable {
    /// The settings of the robot's UART; none without a UART.
    robot: Option<Settings>,
    /// The receiver of the program's UART, while its settings differ.
    up: Option<Receiver>,
    /// The receiver of the robot's UART.
    down: Option<Receiver>,
    /// The instant until which the program's bytes take the line.
    busy_until_ns: u64,
}

impl Cable {
    /// A cable to a robot's UART that is set so, with nothing on it.
    pub fn new(robot: Option<Settings>) -> Self {
        Self { robot, up: None, down: None, busy_until_ns: 0 }
    }

    /// Nothing is on the lines.
    pub(crate) fn forget(&mut self) {
        (self.up, self.down, self.busy_until_ns) = (None, None, 0);
    }

    /// The bytes that the program has sent are gone, also those that its UART has not sent yet.
    pub fn forget_sent(&mut self) {
        (self.down, self.busy_until_ns) = (None, 0);
    }

    /// The robot's UART has this rate now.
    pub fn set_baud(&mut self, baud: Option<u32>) {
        if let (Some(robot), Some(baud)) = (&mut self.robot, baud) {
            robot.baud = baud;
        }
    }

    /// The program's settings, where they are not the robot's.
    fn other(&self, program: Option<Settings>) -> Option<(Settings, Settings)> {
        self.robot.zip(program).filter(|(robot, program)| robot != program)
    }

    /// Bytes from the robot, with the instants at which they have arrived at the laptop. What is read does not arrive earlier than
    /// that.
    pub fn up(&mut self, program: Option<Settings>, bytes: &[(u64, u8)], out: &mut VecDeque<Read>) {
        let Some((robot, program)) = self.other(program) else {
            self.up = None;
            out.extend(bytes.iter().map(|&(at_ns, byte)| Read { byte, at_ns, error: None }));
            return;
        };
        let receiver = receiver(&mut self.up, program);
        // Bytes that an adapter has kept arrive at one instant; on the wire they came one behind the other.
        for together in bytes.chunk_by(|a, b| a.0 == b.0) {
            let character_ns = robot.character_ns();
            let first_ns = together[0].0.saturating_sub(together.len() as u64 * character_ns);
            for (i, &(_, byte)) in together.iter().enumerate() {
                receiver.hear(&robot, first_ns + i as u64 * character_ns, byte);
            }
            receiver.idle(together[0].0);
            let arrived_ns = together[0].0;
            out.extend(
                std::iter::from_fn(|| receiver.read())
                    .map(|read| Read { at_ns: read.at_ns.max(arrived_ns), ..read }),
            );
        }
    }

    /// Bytes that the program writes at `now_ns`, and from when on the world's cable may carry what the robot's UART reads of them.
    pub fn down(&mut self, program: Option<Settings>, now_ns: u64, bytes: &[u8], out: &mut VecDeque<Read>) {
        let Some((robot, program)) = self.other(program) else {
            self.down = None;
            let character_ns = self.robot.map_or(0, |robot| robot.character_ns());
            self.busy_until_ns = self.busy_until_ns.max(now_ns) + bytes.len() as u64 * character_ns;
            out.extend(bytes.iter().map(|&byte| Read { byte, at_ns: now_ns, error: None }));
            return;
        };
        let receiver = receiver(&mut self.down, robot);
        for &byte in bytes {
            receiver.hear(&program, now_ns, byte);
        }
        self.busy_until_ns = receiver.free_ns();
        self.hand_down(out);
    }

    /// The bytes that the robot's UART has read. The world's cable carries each character once more, so it gets it
    /// when that begins on the line: the robot then has it when it has been sent, and not before.
    fn hand_down(&mut self, out: &mut VecDeque<Read>) {
        let character_ns = self.robot.map_or(0, |robot| robot.character_ns());
        let Some(receiver) = &mut self.down else { return };
        let reads = std::iter::from_fn(|| receiver.read());
        out.extend(reads.map(|read| Read { at_ns: read.at_ns.saturating_sub(character_ns), ..read }));
    }

    /// A break of this length from the program. A robot without a UART ignores it.
    pub fn send_break(&mut self, now_ns: u64, length_ns: u64, out: &mut VecDeque<Read>) {
        let Some(robot) = self.robot else { return };
        let receiver = receiver(&mut self.down, robot);
        receiver.hear_break(now_ns, length_ns);
        receiver.idle(now_ns + length_ns + robot.character_ns());
        self.hand_down(out);
    }

    /// Both lines are idle at `now_ns` unless something is still on its way: what the UARTs have read by that.
    pub fn idle(&mut self, now_ns: u64, up: &mut VecDeque<Read>, down: &mut VecDeque<Read>) {
        if let Some(receiver) = &mut self.up {
            receiver.idle(now_ns);
            up.extend(std::iter::from_fn(|| receiver.read()));
        }
        if let Some(receiver) = &mut self.down {
            receiver.idle(now_ns);
            self.hand_down(down);
        }
    }

    /// Whether a UART may read something although nothing more is sent.
    pub fn is_listening(&self) -> bool {
        self.up.is_some() || self.down.is_some()
    }

    /// The number of bytes that the program may write at `now_ns`, so that they keep the line busy for no longer than
    /// `window_ns` and a few characters.
    pub(crate) fn room(&self, program: Option<Settings>, now_ns: u64, window_ns: u64) -> usize {
        let Some(robot) = self.robot else { return CHUNK };
        let character_ns = program.unwrap_or(robot).character_ns().max(robot.character_ns()).max(1);
        let window_ns = window_ns + CHARACTERS_AHEAD * character_ns;
        let free_ns = (now_ns + window_ns).saturating_sub(self.busy_until_ns);
        ((free_ns / character_ns) as usize).min(CHUNK)
    }

    /// Bytes of the program that the line has not carried at `now_ns`.
    pub(crate) fn unsent(&self, now_ns: u64) -> usize {
        let character_ns = self.robot.map_or(0, |robot| robot.character_ns());
        let left_ns = self.busy_until_ns.saturating_sub(now_ns);
        left_ns.checked_div(character_ns).unwrap_or(0) as usize
    }

    /// The instant at which there is room for another byte.
    pub(crate) fn has_room_ns(&self, program: Option<Settings>, window_ns: u64) -> u64 {
        let Some(robot) = self.robot else { return 0 };
        let character_ns = program.unwrap_or(robot).character_ns().max(robot.character_ns());
        self.busy_until_ns.saturating_sub(window_ns + (CHARACTERS_AHEAD - 1) * character_ns)
    }
}

/// Bytes that are taken from a program at once.
pub(crate) const CHUNK: usize = 512;

/// Characters that may wait to be sent besides those of the window, as in the FIFO of a UART.
const CHARACTERS_AHEAD: u64 = 16;

/// The receiver, made anew when its settings have changed.
fn receiver(at: &mut Option<Receiver>, settings: Settings) -> &mut Receiver {
    match at {
        Some(receiver) if *receiver.settings() == settings => {}
        _ => *at = Some(Receiver::new(settings)),
    }
    at.get_or_insert_with(|| Receiver::new(settings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use baudbot_board::far_end::LineError;

    const SLOW: Settings = Settings::new_8n1(9600);
    const FAST: Settings = Settings::new_8n1(38_400);

    fn up(program: Settings, bytes: &[(u64, u8)]) -> Vec<Read> {
        let (mut cable, mut out) = (Cable::new(Some(SLOW)), VecDeque::new());
        cable.up(Some(program), bytes, &mut out);
        cable.idle(1_000_000_000, &mut out, &mut VecDeque::new());
        out.into()
    }

    #[test]
    fn ends_that_are_set_alike_pass_bytes_as_they_are() {
        assert_eq!(
            up(SLOW, &[(5, 0), (9, 255)]),
            [(5, 0), (9, 255)].map(|(at_ns, byte)| Read { byte, at_ns, error: None })
        );
        let mut usb = (Cable::new(None), VecDeque::new());
        usb.0.up(Some(FAST), &[(5, 7)], &mut usb.1);
        assert_eq!(usb.1[0].byte, 7, "USB has no baud rate");
    }

    #[test]
    fn another_rate_reads_other_bytes_and_never_earlier() {
        let at = 20_000_000;
        let read = up(FAST, &[(at, b'n'), (at, b',')]);
        assert!(!read.is_empty() && read.iter().all(|read| read.at_ns >= at), "{read:?}");
        assert!(read.iter().any(|read| read.error == Some(LineError::Framing)), "{read:?}");
        assert_ne!(read.iter().map(|read| read.byte).collect::<Vec<_>>(), b"n,");
        assert_eq!(read, up(FAST, &[(at, b'n'), (at, b',')]), "computed, not random");
    }

    #[test]
    fn a_program_writes_no_faster_than_the_cable_takes() {
        let (mut cable, mut out) = (Cable::new(Some(SLOW)), VecDeque::new());
        let mut written = 0;
        for ms in 0..1000 {
            let now = ms * 1_000_000;
            let room = cable.room(Some(SLOW), now, 2_000_000);
            cable.down(Some(SLOW), now, &vec![0; room], &mut out);
            written += room;
        }
        assert!((950..990).contains(&written), "{written} of 960 a second");
        assert_eq!(cable.room(Some(SLOW), 999_000_000, 2_000_000), 0);
        assert!(cable.has_room_ns(Some(SLOW), 2_000_000) < 1_001_000_000);
        // A FIFO, and what the line carries in two milliseconds; if the world has come to a second less, those of that second, too.
        assert!((16..=18).contains(&cable.unsent(999_000_000)));
        assert!((950..990).contains(&cable.unsent(0)), "{}", cable.unsent(0));
        assert_eq!(Cable::new(None).unsent(0), 0, "USB has no baud rate");
    }

    #[test]
    fn what_a_slower_program_writes_enters_the_cable_no_earlier_than_its_uart_sends_it() {
        let (mut cable, mut out) = (Cable::new(Some(FAST)), VecDeque::new());
        let program = Settings { stop_bits: 2, ..FAST };
        cable.down(Some(program), 1_000_000, b"D,5,5\r", &mut out);
        cable.idle(1_000_000_000, &mut VecDeque::new(), &mut out);
        let begins = |i: u64| 1_000_000 + i * program.character_ns();
        for (i, (read, sent)) in out.iter().zip(b"D,5,5\r").enumerate() {
            let at = begins(i as u64);
            assert_eq!((read.byte, read.error), (*sent, None));
            assert!(read.at_ns.abs_diff(at) < 10, "{i}: {} is not {at}", read.at_ns);
        }
        assert_eq!(out.len(), 6);
    }

    #[test]
    fn a_break_is_a_0_at_the_robot() {
        let (mut cable, mut out) = (Cable::new(Some(SLOW)), VecDeque::new());
        cable.send_break(0, 250_000_000, &mut out);
        assert_eq!(
            out.iter().map(|read| (read.byte, read.error)).collect::<Vec<_>>(),
            [(0, Some(LineError::Framing))]
        );
    }
}
