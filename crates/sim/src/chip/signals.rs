//! The signals that a logic analyser on a chip's pins shows, and what they are called.
//!
//! All pins of an Arduino are there, as a program may move one on which no wire is.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_board::{Net, Role, Seen, Terminal, Wiring};

use super::ChipSpec;

/// The source of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// The rounds of the program's main loop.
    MainLoop,
    /// A wire with its level.
    Wire(Net),
    /// The results of a channel of the ADC.
    Adc(u8),
    /// The characters on TXD.
    Sent,
    /// The characters on RXD.
    Received,
}

impl Line {
    /// The one on which something is seen.
    pub const fn of(seen: Seen) -> Option<Self> {
        match seen {
            Seen::Level { pin, .. } => Some(Self::Wire(Net::Pin(pin))),
            Seen::Converted { channel, .. } => Some(Self::Adc(channel)),
            Seen::Sends(_) => Some(Self::Sent),
            Seen::Receives(_) => Some(Self::Received),
            Seen::Round(_) => Some(Self::MainLoop),
            // The edges of a shape are drawn.
            Seen::Shape { .. } => None,
        }
    }
}

/// A signal with its names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The source.
    pub line: Line,
    /// The terminals on its wire, such as `motors.left.pwm`.
    pub on: Vec<String>,
}

impl Signal {
    /// The signal's short name: `main loop`, `D9` and `A0` as on an Arduino, `PB6`, `adc0`, `uart sent`.
    pub fn name(&self) -> String {
        match self.line {
            Line::MainLoop => "main loop".to_string(),
            Line::Wire(net) => printed(net),
            Line::Adc(channel) => format!("adc{channel}"),
            Line::Sent => "uart sent".to_string(),
            Line::Received => "uart received".to_string(),
        }
    }

    /// The signal's name with what is on it: `D9 motors.left.pwm`.
    pub fn label(&self) -> String {
        let mut label = self.name();
        label.extend(self.on.iter().map(|terminal| format!(" {terminal}")));
        label
    }

    /// All its names in one word: `D9_PB1_motors_left_pwm`, `D1_PD1_txd`, `adc0_sensors_ir_left`, `uart_sent`.
    pub fn identifier(&self) -> String {
        let mut word = identifier(&self.name());
        if let Line::Wire(net) = self.line {
            let port = net.to_string();
            if port != word {
                word += &format!("_{port}");
            }
            let uart = [(0, "_rxd"), (1, "_txd")];
            word.extend(
                uart.iter().filter(|(pin, _)| Net::arduino(*pin) == Some(net)).map(|(_, name)| *name),
            );
        }
        word.extend(self.on.iter().map(|terminal| format!("_{}", identifier(terminal))));
        word
    }
}

impl ChipSpec {
    /// All signals: the main loop, the pins of an Arduino in the order of their numbers, other pins with wires, the channels of the ADC on which
    /// something is, and the characters on TXD and RXD.
    pub fn signals(&self) -> Vec<Signal> {
        let wiring = self.board().wiring();
        let mut nets: Vec<Net> = (0..PRINTED).filter_map(Net::arduino).collect();
        for net in wiring.wires().map(|(_, net)| net).filter(|net| net.pin().is_some()) {
            if !nets.contains(&net) {
                nets.push(net);
            }
        }
        let wires = nets.into_iter().map(|net| {
            let on = terminals(wiring, |other| other == net);
            Signal { line: Line::Wire(net), on }
        });
        let channels = (0..CHANNELS).filter_map(|channel| {
            let on = terminals(wiring, |net| net.adc_channel() == Some(channel));
            (!on.is_empty()).then_some(Signal { line: Line::Adc(channel), on })
        });
        let uart = [Line::Sent, Line::Received].map(|line| Signal { line, on: Vec::new() });
        let main_loop = Signal { line: Line::MainLoop, on: Vec::new() };
        core::iter::once(main_loop).chain(wires).chain(channels).chain(uart).collect()
    }
}

/// A pin as it is printed on an Arduino, with a letter before its number.
fn printed(net: Net) -> String {
    let printed = net.printed();
    if printed.starts_with(|first: char| first.is_ascii_digit()) { format!("D{printed}") } else { printed }
}

/// The terminals on some wires.
fn terminals(wiring: &Wiring, is_meant: impl Fn(Net) -> bool) -> Vec<String> {
    let meant = wiring.wires().filter(|(_, net)| is_meant(*net));
    meant.map(|(terminal, _)| terminal_name(wiring, terminal)).collect()
}

fn terminal_name(wiring: &Wiring, Terminal { part, role }: Terminal) -> String {
    let part = wiring.name(part);
    if role == Role::Signal { part.to_string() } else { format!("{part}.{role}") }
}

/// A name without what would end it in a file, or mean something to other programs.
pub fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// Pins with numbers on an Arduino: 0 to 13, and A0 to A5.
const PRINTED: u8 = 20;

/// The channels of the ADC: data sheet, chapter *Analog-to-Digital Converter*.
const CHANNELS: u8 = 8;
