//! The far side of a program's serial ports: what the caller has.

/// The far side of the ports, at the instant for which the session runs. Ports have the order that they have in
/// [`Program::ports`](crate::Program::ports).
pub trait Cables {
    /// Bytes enter the UART of the port now.
    fn write(&mut self, port: usize, bytes: &[u8]);
    /// Appends all bytes that have reached the program's end of the cable since the last call.
    fn take(&mut self, port: usize, into: &mut Vec<u8>);
    /// The instant at which the last byte that was written has left the UART, in nanoseconds; at most now if none is left.
    fn sent_at_ns(&self, port: usize) -> u64;
    /// Bytes written that have not left the UART.
    fn unsent(&self, port: usize) -> usize;
    /// The program has set its UART, or has opened the port.
    fn configure(&mut self, port: usize, settings: LineSettings);
    /// The program has set its output lines, or the system has at opening and closing.
    fn set_outputs(&mut self, port: usize, outputs: ModemOutputs);
    /// The input lines as they are now.
    fn inputs(&self, port: usize) -> ModemInputs;
    /// A break begins or ends.
    fn send_break(&mut self, port: usize, is_on: bool);
    /// The bytes that have not left the UART are thrown away.
    fn discard_unsent(&mut self, port: usize);
}

/// The settings of a UART.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LineSettings {
    /// Bits a second; never 0.
    pub baud: u32,
    /// 5 to 8.
    pub data_bits: u8,
    /// The parity bit.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
}

impl LineSettings {
    /// The time that so many bytes take, in nanoseconds, rounded down.
    pub fn bytes_ns(&self, count: u64) -> u64 {
        let parity = u64::from(self.parity != Parity::None);
        let bits = 1 + u64::from(self.data_bits) + parity + u64::from(self.stop_bits);
        count * bits * 1_000_000_000 / u64::from(self.baud)
    }
}

/// The parity bit of a byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Parity {
    /// There is none.
    None,
    /// It makes the number of ones even.
    Even,
    /// It makes the number of ones odd.
    Odd,
    /// It is 1.
    Mark,
    /// It is 0.
    Space,
}

/// The lines that a program drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ModemOutputs {
    /// Data terminal ready.
    pub dtr: bool,
    /// Request to send.
    pub rts: bool,
}

/// The lines that a program reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ModemInputs {
    /// Clear to send.
    pub cts: bool,
    /// Data set ready.
    pub dsr: bool,
    /// Data carrier detect.
    pub dcd: bool,
    /// Ring indicator.
    pub ri: bool,
}
