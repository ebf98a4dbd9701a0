//! The settings of a port: `struct termios2` of the kernel, of which `struct termios` is the beginning.

use crate::cables::{LineSettings, Parity};

/// Speed that c_ospeed has, rather than bits of c_cflag (asm-generic/termbits.h).
const BOTHER: u32 = 0o010000;
const CBAUD: u32 = 0o010017;
/// Mark and space in place of odd and even.
const CMSPAR: u32 = 0o10000000000;
/// Speeds by their bits in c_cflag.
const SPEEDS: [(u32, u32); 31] = [
    (0, 0),
    (1, 50),
    (2, 75),
    (3, 110),
    (4, 134),
    (5, 150),
    (6, 200),
    (7, 300),
    (8, 600),
    (9, 1200),
    (10, 1800),
    (11, 2400),
    (12, 4800),
    (13, 9600),
    (14, 19_200),
    (15, 38_400),
    (0o10001, 57_600),
    (0o10002, 115_200),
    (0o10003, 230_400),
    (0o10004, 460_800),
    (0o10005, 500_000),
    (0o10006, 576_000),
    (0o10007, 921_600),
    (0o10010, 1_000_000),
    (0o10011, 1_152_000),
    (0o10012, 1_500_000),
    (0o10013, 2_000_000),
    (0o10014, 2_500_000),
    (0o10015, 3_000_000),
    (0o10016, 3_500_000),
    (0o10017, 4_000_000),
];
/// Bytes of `struct termios` and of `struct termios2`.
pub(crate) const SIZE: usize = 36;
pub(crate) const SIZE2: usize = 44;
const CONTROL_AT: usize = 17;
/// The places in c_cc that the system uses.
const CONTROLS: usize = 17;

/// The settings of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Termios {
    pub(crate) input: u32,
    pub(crate) output: u32,
    pub(crate) control: u32,
    pub(crate) local: u32,
    line: u8,
    characters: [u8; 19],
    input_baud: u32,
    output_baud: u32,
}

impl Default for Termios {
    /// As the system sets a USB adapter.
    fn default() -> Self {
        let mut characters = [0; 19];
        characters[..CONTROLS]
            .copy_from_slice(&[3, 28, 127, 21, 4, 0, 1, 0, 17, 19, 26, 0, 18, 15, 23, 22, 0]);
        Self {
            input: libc::ICRNL | libc::IXON,
            output: libc::OPOST | libc::ONLCR,
            control: libc::B9600 | libc::CS8 | libc::CREAD | libc::HUPCL | libc::CLOCAL,
            local: libc::ISIG
                | libc::ICANON
                | libc::ECHO
                | libc::ECHOE
                | libc::ECHOK
                | libc::ECHOCTL
                | libc::ECHOKE
                | libc::IEXTEN,
            line: 0,
            characters,
            input_baud: 9600,
            output_baud: 9600,
        }
    }
}

impl Termios {
    /// As programs read it: the first 36 bytes are a `struct termios`.
    pub(crate) fn to_bytes(&self) -> [u8; SIZE2] {
        let mut bytes = [0; SIZE2];
        for (place, flags) in [self.input, self.output, self.control, self.local].into_iter().enumerate() {
            bytes[4 * place..4 * place + 4].copy_from_slice(&flags.to_ne_bytes());
        }
        bytes[CONTROL_AT - 1] = self.line;
        bytes[CONTROL_AT..SIZE].copy_from_slice(&self.characters);
        bytes[SIZE..SIZE + 4].copy_from_slice(&self.input_baud.to_ne_bytes());
        bytes[SIZE + 4..].copy_from_slice(&self.output_baud.to_ne_bytes());
        bytes
    }

    /// As a program has written it over `bytes` of `to_bytes`. A speed that is no number of the table stays.
    pub(crate) fn from_bytes(bytes: &[u8; SIZE2]) -> Self {
        let number = |place: usize| {
            u32::from_ne_bytes([bytes[place], bytes[place + 1], bytes[place + 2], bytes[place + 3]])
        };
        let mut characters = [0; 19];
        characters.copy_from_slice(&bytes[CONTROL_AT..SIZE]);
        let control = number(8);
        let named = SPEEDS.iter().find(|(bits, _)| *bits == control & CBAUD).map(|(_, baud)| *baud);
        Self {
            input: number(0),
            output: number(4),
            control,
            local: number(12),
            line: bytes[CONTROL_AT - 1],
            characters,
            input_baud: named.unwrap_or_else(|| number(SIZE)),
            output_baud: named.unwrap_or_else(|| number(SIZE + 4)),
        }
    }

    /// The UART's settings; none at the speed 0, which hangs up.
    pub(crate) fn line_settings(&self) -> Option<LineSettings> {
        debug_assert!(SPEEDS.iter().all(|(bits, _)| *bits != BOTHER));
        let data_bits = match self.control & libc::CSIZE {
            libc::CS5 => 5,
            libc::CS6 => 6,
            libc::CS7 => 7,
            _ => 8,
        };
        let is = |flag| self.control & flag != 0;
        let parity = match (is(libc::PARENB), is(CMSPAR), is(libc::PARODD)) {
            (false, _, _) => Parity::None,
            (true, false, false) => Parity::Even,
            (true, false, true) => Parity::Odd,
            (true, true, false) => Parity::Space,
            (true, true, true) => Parity::Mark,
        };
        let stop_bits = if is(libc::CSTOPB) { 2 } else { 1 };
        (self.output_baud > 0).then_some(LineSettings {
            baud: self.output_baud,
            data_bits,
            parity,
            stop_bits,
        })
    }

    /// Whether input is made of lines.
    pub(crate) fn is_canonical(&self) -> bool {
        self.local & libc::ICANON != 0
    }

    /// Whether the receiver is on.
    pub(crate) fn receives(&self) -> bool {
        self.control & libc::CREAD != 0
    }

    /// Whether the lines fall when the last program closes the port.
    pub(crate) fn hangs_up(&self) -> bool {
        self.control & libc::HUPCL != 0
    }

    /// Bytes that a read waits for (VMIN).
    pub(crate) fn least(&self) -> usize {
        self.characters[libc::VMIN].into()
    }

    /// The time-out of a read in nanoseconds (VTIME, in tenths of a second).
    pub(crate) fn timeout_ns(&self) -> u64 {
        u64::from(self.characters[libc::VTIME]) * 100_000_000
    }

    /// Whether a byte is the special character at this place of c_cc. 0 disables one.
    pub(crate) fn is_special(&self, byte: u8, place: usize) -> bool {
        byte != 0 && self.characters[place] == byte
    }
}
