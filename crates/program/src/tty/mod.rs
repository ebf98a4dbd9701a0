//! A serial port as Linux shows it to programs: termios(3), with the line discipline between program and UART. No time passes here, and
//! no call is seen: bytes come in, and answers go out.

pub(crate) mod discipline;
pub(crate) mod flag;
pub(crate) mod termios;

use std::io;

use crate::cables::ModemOutputs;
use discipline::Input;
use flag::Flag;
use termios::Termios;

/// A serial port.
#[derive(Debug)]
pub(crate) struct Tty {
    /// The path under which programs open it.
    pub(crate) path: String,
    /// Its settings. They outlive its being closed, as those of USB adapters do.
    pub(crate) termios: Termios,
    /// The bytes that have come in and have not been read.
    pub(crate) input: Input,
    /// Whether any program has it open.
    pub(crate) is_open: bool,
    /// TIOCEXCL: nobody else may open it.
    pub(crate) is_exclusive: bool,
    /// The lines that it drives.
    pub(crate) outputs: ModemOutputs,
    /// The flags of TIOCSSERIAL, such as `low_latency`.
    pub(crate) serial_flags: u32,
    /// The file that programs hold as its descriptor.
    pub(crate) flag: Flag,
}

impl Tty {
    /// A port that nobody has opened yet.
    pub(crate) fn new(path: &str) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            termios: Termios::default(),
            input: Input::default(),
            is_open: false,
            is_exclusive: false,
            outputs: ModemOutputs::default(),
            serial_flags: 0,
            flag: Flag::new()?,
        })
    }

    /// Bytes have come from the UART. Returns what is echoed.
    pub(crate) fn receive(&mut self, bytes: &[u8], now_ns: u64) -> Vec<u8> {
        let mut echo = Vec::new();
        if self.is_open && self.termios.receives() {
            for byte in bytes {
                self.input.receive(&self.termios, *byte, &mut echo);
            }
            self.input.last_ns = now_ns;
            self.flag.poke();
        }
        self.show();
        echo
    }

    /// Makes the descriptor readable if there is something to read.
    pub(crate) fn show(&mut self) {
        self.flag.set(self.input.is_ready(&self.termios));
    }
}
