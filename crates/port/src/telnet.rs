//! RFC 2217: Telnet with the COM port option, by which a program sets the UART of a terminal server.
//!
//! Known are the baud rate, data bits, parity, stop bits, DTR, RTS, break, purging and the masks of notifications. Flow
//! control is acknowledged as it is asked for, and does nothing. The state of the modem lines is always that of a cable
//! that is plugged in: CTS, DSR and CD. It is sent as soon as the option is agreed to, as clients wait for it, and when
//! it is asked for.
//!
//! A program's request is obeyed when it comes, also if data before it have not gone yet, as terminal servers do.

use baudbot_board::far_end::{LineError, Parity, Read, Settings};

const IAC: u8 = 255;
const DONT: u8 = 254;
const DO: u8 = 253;
const WONT: u8 = 252;
const WILL: u8 = 251;
const SB: u8 = 250;
const SE: u8 = 240;

const BINARY: u8 = 0;
const ECHO: u8 = 1;
const SUPPRESS_GO_AHEAD: u8 = 3;
const COM_PORT: u8 = 44;

/// Answers have the command's number and this.
const ANSWER: u8 = 100;

/// Longest subnegotiation; of longer ones the rest is passed over.
const MAX_COMMAND: usize = 80;

/// Commands that report the state of the modem lines, and of the line.
const NOTIFY_MODEMSTATE: u8 = 7;
const NOTIFY_LINESTATE: u8 = 6;

/// SET-CONTROL: no flow control.
const NO_FLOW_OUT: u8 = 1;
const NO_FLOW_IN: u8 = 14;

/// CTS, DSR and CD are on.
const MODEM_LINES: u8 = 0x10 | 0x20 | 0x80;

/// A program's request besides data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// DTR is switched.
    Dtr(bool),
    /// A break begins or ends.
    Break(bool),
    /// Bytes that wait to be given to the program are thrown away.
    PurgeReceived,
    /// Bytes that the program has sent before and that are not on the cable yet are thrown away.
    PurgeSent,
}

/// One connection's side of the protocol.
#[derive(Clone, Debug)]
pub(crate) struct Telnet {
    state: State,
    command: Vec<u8>,
    settings: Settings,
    dtr: bool,
    rts: bool,
    breaks: bool,
    /// The settings of flow control, outbound and inbound, by their numbers in SET-CONTROL. They do nothing. It does
    /// nothing.
    flow: [u8; 2],
    /// The states of the line to report.
    line_mask: u8,
    /// Options that were agreed to, so that an answer is never answered: ours, then the program's.
    agreed: [Vec<u8>; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Data,
    Command,
    Option(u8),
    Sub,
    SubCommand,
}

/// The result of reading some bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Heard {
    /// Bytes for the robot, those behind the last [`Event::PurgeSent`].
    pub(crate) data: Vec<u8>,
    /// Bytes back to the program.
    pub(crate) replies: Vec<u8>,
    pub(crate) events: Vec<Event>,
}

impl Telnet {
    /// A connection whose UART is set so.
    pub(crate) fn new(settings: Settings) -> Self {
        Self {
            state: State::Data,
            command: Vec::new(),
            settings,
            dtr: true,
            rts: true,
            breaks: false,
            flow: [NO_FLOW_OUT, NO_FLOW_IN],
            line_mask: 0,
            agreed: [Vec::new(), Vec::new()],
        }
    }

    /// The program's settings of the UART.
    pub(crate) fn settings(&self) -> Settings {
        self.settings
    }

    /// Bytes have come from the program.
    pub(crate) fn hear(&mut self, bytes: &[u8]) -> Heard {
        let mut heard = Heard::default();
        for &byte in bytes {
            self.state = self.next(byte, &mut heard);
        }
        heard
    }

    fn next(&mut self, byte: u8, heard: &mut Heard) -> State {
        match (self.state, byte) {
            (State::Data, IAC) => State::Command,
            (State::Data, _) => {
                heard.data.push(byte);
                State::Data
            }
            (State::Command, IAC) => {
                heard.data.push(IAC);
                State::Data
            }
            (State::Command, WILL | WONT | DO | DONT) => State::Option(byte),
            (State::Command, SB) => {
                self.command.clear();
                State::Sub
            }
            (State::Command, _) => State::Data,
            (State::Option(verb), option) => {
                self.negotiate(verb, option, heard);
                State::Data
            }
            (State::Sub, IAC) => State::SubCommand,
            (State::Sub, _) => {
                self.note(byte);
                State::Sub
            }
            (State::SubCommand, IAC) => {
                self.note(IAC);
                State::Sub
            }
            (State::SubCommand, SE) => {
                self.obey(heard);
                State::Data
            }
            // Not allowed there; the subnegotiation is over.
            (State::SubCommand, _) => State::Data,
        }
    }

    fn note(&mut self, byte: u8) {
        if self.command.len() < MAX_COMMAND {
            self.command.push(byte);
        }
    }

    /// Agrees to what a serial port needs, and to nothing else. What has been agreed to is not answered again.
    fn negotiate(&mut self, verb: u8, option: u8, heard: &mut Heard) {
        let known = match verb {
            DO => [BINARY, ECHO, SUPPRESS_GO_AHEAD, COM_PORT].contains(&option),
            WILL => [BINARY, SUPPRESS_GO_AHEAD, COM_PORT].contains(&option),
            _ => false,
        };
        let (side, yes, no) = match verb {
            DO | DONT => (0, WILL, WONT),
            _ => (1, DO, DONT),
        };
        let was_agreed = self.agreed[side].contains(&option);
        let is_asked = verb == DO || verb == WILL;
        if is_asked && known {
            if !was_agreed {
                let is_new = !self.agreed.iter().any(|agreed| agreed.contains(&option));
                self.agreed[side].push(option);
                heard.replies.extend([IAC, yes, option]);
                if option == COM_PORT && is_new {
                    reply(heard, NOTIFY_MODEMSTATE + ANSWER, &[MODEM_LINES]);
                }
            }
        } else if is_asked || was_agreed {
            self.agreed[side].retain(|agreed| *agreed != option);
            heard.replies.extend([IAC, no, option]);
        }
    }

    fn obey(&mut self, heard: &mut Heard) {
        let [COM_PORT, command, value @ ..] = &*std::mem::take(&mut self.command) else { return };
        let answer: Vec<u8> = match (*command, value) {
            (0, _) => b"baudbot".to_vec(),
            (1, &[a, b, c, d]) => self.set_baud(u32::from_be_bytes([a, b, c, d])).to_be_bytes().to_vec(),
            (2, &[bits]) => vec![self.set_data_bits(bits)],
            (3, &[parity]) => vec![self.set_parity(parity)],
            (4, &[stop]) => vec![self.set_stop_bits(stop)],
            (5, &[control]) => vec![self.control(control, heard)],
            (6, _) => vec![0],
            (7, _) => vec![MODEM_LINES],
            (10, &[mask]) => {
                self.line_mask = mask;
                vec![mask]
            }
            (11, &[mask]) => {
                reply(heard, command + ANSWER, &[mask]);
                return reply(heard, NOTIFY_MODEMSTATE + ANSWER, &[MODEM_LINES]);
            }
            (12, &[what]) => {
                heard.events.extend([1, 3].contains(&what).then_some(Event::PurgeReceived));
                if [2, 3].contains(&what) {
                    heard.data.clear();
                    heard.events.push(Event::PurgeSent);
                }
                vec![what]
            }
            // Suspend and resume have no answer; the rest is not known.
            _ => return,
        };
        reply(heard, command + ANSWER, &answer);
    }

    /// 0 asks for the rate.
    fn set_baud(&mut self, baud: u32) -> u32 {
        if baud > 0 {
            self.settings.baud = baud;
        }
        self.settings.baud
    }

    fn set_data_bits(&mut self, bits: u8) -> u8 {
        if (5..=8).contains(&bits) {
            self.settings.data_bits = bits;
        }
        self.settings.data_bits
    }

    fn set_parity(&mut self, parity: u8) -> u8 {
        const ALL: [Parity; 5] = [Parity::None, Parity::Odd, Parity::Even, Parity::Mark, Parity::Space];
        if let Some(wanted) = usize::from(parity).checked_sub(1).and_then(|i| ALL.get(i)) {
            self.settings.parity = *wanted;
        }
        ALL.iter().position(|known| *known == self.settings.parity).map_or(1, |i| i as u8 + 1)
    }

    /// 3 are one and a half, which no UART with 8 data bits has; it is taken for 2.
    fn set_stop_bits(&mut self, stop: u8) -> u8 {
        match stop {
            1 => self.settings.stop_bits = 1,
            2 | 3 => self.settings.stop_bits = 2,
            _ => {}
        }
        self.settings.stop_bits
    }

    fn control(&mut self, control: u8, heard: &mut Heard) -> u8 {
        match control {
            5 | 6 => {
                self.breaks = control == 5;
                heard.events.push(Event::Break(self.breaks));
            }
            8 | 9 => {
                let was_on = std::mem::replace(&mut self.dtr, control == 8);
                heard.events.extend((was_on != self.dtr).then_some(Event::Dtr(self.dtr)));
            }
            11 | 12 => self.rts = control == 11,
            // Asked for.
            4 => return if self.breaks { 5 } else { 6 },
            7 => return if self.dtr { 8 } else { 9 },
            10 => return if self.rts { 11 } else { 12 },
            1..=3 | 17 | 19 => self.flow[0] = control,
            14..=16 | 18 => self.flow[1] = control,
            13 => return self.flow[1],
            // 0 asks; the rest is not known.
            _ => return self.flow[0],
        }
        control
    }
}

impl Telnet {
    /// Data as it goes to the program, with what is wrong with it if the program wants to know that.
    pub(crate) fn told(&self, read: &Read) -> Vec<u8> {
        let state = match read.error {
            None => 0,
            // Break-detect, and framing error.
            Some(LineError::Framing) if read.byte == 0 => 0x10 | 0x08,
            Some(LineError::Framing) => 0x08,
            Some(LineError::Parity) => 0x04,
        } & self.line_mask;
        let mut heard = Heard::default();
        if state != 0 {
            reply(&mut heard, NOTIFY_LINESTATE + ANSWER, &[state]);
        }
        heard.replies.extend(escaped(&[read.byte]));
        heard.replies
    }
}

/// Data, escaped.
fn escaped(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().flat_map(|&byte| std::iter::repeat_n(byte, if byte == IAC { 2 } else { 1 })).collect()
}

fn reply(heard: &mut Heard, command: u8, value: &[u8]) {
    heard.replies.extend([IAC, SB, COM_PORT, command]);
    heard.replies.extend(escaped(value));
    heard.replies.extend([IAC, SE]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn telnet() -> Telnet {
        Telnet::new(Settings::new_8n1(9600))
    }

    #[test]
    fn data_goes_through_and_255_is_doubled() {
        let mut telnet = telnet();
        assert_eq!(telnet.hear(&[1, IAC]).data, [1]);
        assert_eq!(telnet.hear(&[IAC, 2]).data, [IAC, 2]);
        assert_eq!(escaped(&[1, 255, 2]), [1, 255, 255, 2]);
    }

    #[test]
    fn the_options_of_a_serial_port_are_agreed_to_once_and_others_refused() {
        let mut telnet = telnet();
        let asked = [IAC, DO, COM_PORT, IAC, WILL, COM_PORT, IAC, WILL, BINARY, IAC, DO, 24, IAC, WILL, 31];
        let lines = [IAC, SB, COM_PORT, 107, MODEM_LINES, IAC, SE];
        let answer = [IAC, DO, COM_PORT, IAC, DO, BINARY, IAC, WONT, 24, IAC, DONT, 31];
        assert_eq!(telnet.hear(&asked).replies, [&[IAC, WILL, COM_PORT][..], &lines, &answer].concat());
        assert_eq!(telnet.hear(&asked[..9]).replies, [0_u8; 0], "no answer to what is agreed");
        assert_eq!(telnet.hear(&[IAC, DONT, COM_PORT]).replies, [IAC, WONT, COM_PORT]);
    }

    #[test]
    fn the_uart_is_set_and_the_setting_acknowledged() {
        let mut telnet = telnet();
        let set = |telnet: &mut Telnet, command: u8, value: &[u8]| {
            let mut bytes = vec![IAC, SB, COM_PORT, command];
            bytes.extend(escaped(value));
            bytes.extend([IAC, SE]);
            let heard = telnet.hear(&bytes);
            let answer = heard.replies;
            assert_eq!(answer[..4], [IAC, SB, COM_PORT, command + 100]);
            (answer[4..answer.len() - 2].to_vec(), heard.events)
        };
        assert_eq!(set(&mut telnet, 1, &57_600_u32.to_be_bytes()).0, 57_600_u32.to_be_bytes());
        assert_eq!(set(&mut telnet, 1, &[0; 4]).0, 57_600_u32.to_be_bytes(), "0 asks");
        assert_eq!(set(&mut telnet, 1, &65_535_u32.to_be_bytes()).0, [0, 0, 255, 255, 255, 255]);
        assert_eq!(set(&mut telnet, 2, &[7]).0, [7]);
        assert_eq!(set(&mut telnet, 3, &[3]).0, [3]);
        assert_eq!(set(&mut telnet, 4, &[2]).0, [2]);
        let wanted = Settings { baud: 65_535, data_bits: 7, parity: Parity::Even, stop_bits: 2 };
        assert_eq!(telnet.settings(), wanted);
        assert_eq!(set(&mut telnet, 5, &[9]), (vec![9], vec![Event::Dtr(false)]));
        assert_eq!(set(&mut telnet, 5, &[7]), (vec![9], vec![]), "asked for");
        assert_eq!(set(&mut telnet, 5, &[5]), (vec![5], vec![Event::Break(true)]));
        assert_eq!(set(&mut telnet, 12, &[1]), (vec![1], vec![Event::PurgeReceived]));
        assert_eq!(set(&mut telnet, 12, &[3]), (vec![3], vec![Event::PurgeReceived, Event::PurgeSent]));
    }

    #[test]
    fn flow_control_is_acknowledged_as_it_is_asked_for() {
        let mut telnet = telnet();
        for (control, answer) in
            [(0, 1), (2, 2), (0, 2), (3, 3), (1, 1), (13, 14), (15, 15), (16, 16), (13, 16)]
        {
            let asked = [IAC, SB, COM_PORT, 5, control, IAC, SE];
            assert_eq!(telnet.hear(&asked).replies, [IAC, SB, COM_PORT, 105, answer, IAC, SE], "{control}");
        }
    }

    #[test]
    fn errors_on_the_line_are_told_to_a_program_that_asks_for_them() {
        let mut telnet = telnet();
        let broken = Read { byte: 0, at_ns: 0, error: Some(LineError::Framing) };
        let odd = Read { byte: 7, at_ns: 0, error: Some(LineError::Parity) };
        assert_eq!(telnet.told(&broken), [0]);
        telnet.hear(&[IAC, SB, COM_PORT, 10, 0x14, IAC, SE]);
        assert_eq!(telnet.told(&broken), [IAC, SB, COM_PORT, 106, 0x10, IAC, SE, 0]);
        assert_eq!(telnet.told(&odd), [IAC, SB, COM_PORT, 106, 0x04, IAC, SE, 7]);
        assert_eq!(telnet.told(&Read { byte: IAC, at_ns: 0, error: None }), [IAC, IAC]);
    }

    #[test]
    fn no_bytes_make_it_panic_or_grow() {
        let (mut telnet, mut random) = (telnet(), 1_u32);
        for _ in 0..1_000_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let byte = if random >> 30 == 0 { IAC } else { (random >> 22) as u8 };
            telnet.hear(&[byte]);
            assert!(telnet.command.len() <= MAX_COMMAND && telnet.agreed[0].len() <= 4);
        }
        telnet.hear(&[0, IAC, SE]);
        assert_eq!(telnet.hear(b"a").data.last(), Some(&b'a'));
    }
}
