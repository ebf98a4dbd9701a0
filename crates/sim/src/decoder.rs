//! The bounds of messages in the bytes of a cable, at either end.

use alloc::boxed::Box;

use baudbot_wire::asercom::Machine;
use baudbot_wire::create::Stream;
use baudbot_wire::khepera::Lines;
use baudbot_wire::{Agreement, BareDecoder, Protocol, Uplink};
use serde::{Deserialize, Serialize};

use crate::open_interface::OpenInterface;
use crate::registers::{Owed, Registers, Say};
use crate::time::SimTime;

/// Finds messages in a stream of bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Decoder {
    Framed(baudbot_wire::Decoder),
    Bare(BareDecoder),
    /// The decoder at the robot's end, with what it owes in answer to the lines that came.
    Khepera {
        lines: Lines,
        owed: Owed,
    },
    /// The successor of `Khepera` with the first line that is neither `D` nor `H` nor `N`.
    Registers {
        lines: Lines,
        registers: Box<Registers>,
    },
    /// A decoder of lines of text, at the laptop's end, with the positions since the last readings.
    Answers {
        lines: Lines,
        positions: Option<[i32; 2]>,
    },
    /// The decoder of a Create, at the robot's end.
    OpenInterface(Box<OpenInterface>),
    /// The decoder of a Create, at the laptop's end.
    Stream(Stream),
    /// The decoder of an e-puck, at the robot's end.
    Asercom(Box<Machine>),
}

/// The message that a byte completed.
pub(crate) enum Found<'a> {
    Nothing,
    Payload(&'a [u8]),
    BadFrame,
}

impl<'a> Found<'a> {
    #[inline]
    fn of<E>(message: Option<Result<&'a [u8], E>>) -> Self {
        match message {
            None => Self::Nothing,
            Some(Ok(payload)) => Self::Payload(payload),
            Some(Err(_)) => Self::BadFrame,
        }
    }
}

impl Decoder {
    /// The decoder at the laptop's end.
    pub(crate) fn of_readings(agreement: &Agreement<'_>) -> Self {
        match agreement.uplink().expect(FITS) {
            Uplink::Framed(framed) => Self::Framed(framed),
            Uplink::Bare(bare) => Self::Bare(bare),
            Uplink::Lines(lines) => Self::Answers { lines, positions: None },
            Uplink::Stream(stream) => Self::Stream(stream),
        }
    }

    /// The decoder at the robot's end.
    pub(crate) fn of_commands(agreement: &Agreement<'_>) -> Self {
        match agreement.protocol {
            Protocol::Framed { .. } => Self::Framed(baudbot_wire::Decoder::new()),
            Protocol::Bare { gap_ns } => {
                let len = agreement.terms.layout.bare_command_len();
                Self::Bare(BareDecoder::new(len, gap_ns).expect(FITS))
            }
            Protocol::Khepera => Self::Khepera { lines: Lines::of_questions(), owed: Owed::default() },
            Protocol::Create(version) => Self::OpenInterface(Box::new(OpenInterface::new(version))),
            Protocol::Asercom => Self::Asercom(Box::default()),
        }
    }

    pub(crate) fn push(&mut self, byte: u8, at: SimTime) -> Found<'_> {
        match self {
            Self::Bare(bare) => bare.push(byte, at.as_ns()).map_or(Found::Nothing, Found::Payload),
            Self::Framed(framed) => Found::of(framed.push(byte)),
            Self::Khepera { lines, .. } | Self::Registers { lines, .. } | Self::Answers { lines, .. } => {
                Found::of(lines.push(byte))
            }
            Self::OpenInterface(interface) => interface.push(byte).map_or(Found::Nothing, Found::Payload),
            Self::Stream(stream) => Found::of(stream.push(byte)),
            // The microcontroller gives its bytes to the machine.
            Self::Asercom(_) => Found::Nothing,
        }
    }

    /// Whether it decodes frames and the next byte begins one.
    pub(crate) fn is_between_frames(&self) -> bool {
        matches!(self, Self::Framed(framed) if framed.is_between_frames())
    }

    /// Whether this decoder may have become what `other` is.
    pub(crate) fn may_become(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Framed(_), Self::Framed(_)) => true,
            (Self::Bare(own), Self::Bare(other)) => own.may_become(other),
            (Self::Khepera { lines: own, .. }, Self::Khepera { lines: other, .. })
            | (Self::Answers { lines: own, .. }, Self::Answers { lines: other, .. }) => own.may_become(other),
            (Self::Khepera { lines: own, .. }, Self::Registers { lines: other, registers }) => {
                own.may_become(other) && registers.is_sound()
            }
            (Self::OpenInterface(own), Self::OpenInterface(other)) => own.may_become(other),
            (Self::Stream(own), Self::Stream(other)) => own.may_become(other),
            // Whatever numbers it has are numbers that a program can have set.
            (Self::Asercom(_), Self::Asercom(_)) => true,
            (Self::Framed(_) | Self::Bare(_) | Self::Khepera { .. } | Self::Registers { .. }, _) => false,
            (Self::Answers { .. } | Self::OpenInterface(_) | Self::Stream(_) | Self::Asercom(_), _) => false,
        }
    }

    /// A message that was understood asks for these answers. Where every answer is readings there is nothing to remember.
    pub(crate) fn owe(&mut self, answers: Owed) {
        if let Self::Khepera { owed, .. } = self {
            owed.add(answers);
        } else if let Some(registers) = self.registers_mut() {
            registers.owe_exchange(answers);
        }
    }

    /// The text that is owed and is sent now.
    pub(crate) fn settle(&mut self) -> Option<Say> {
        if let Self::Khepera { owed, .. } = self {
            return Some(Say::Exchange(core::mem::take(owed)));
        }
        self.registers_mut()?.settle()
    }

    /// The registers of a Khepera, if any was used.
    #[inline]
    pub(crate) fn registers(&self) -> Option<&Registers> {
        if let Self::Registers { registers, .. } = self { Some(registers) } else { None }
    }

    /// The registers of a Khepera, if any was used, to be changed.
    #[inline]
    pub(crate) fn registers_mut(&mut self) -> Option<&mut Registers> {
        if let Self::Registers { registers, .. } = self { Some(registers) } else { None }
    }

    /// A register of a Khepera is used, or a line refused. Other firmwares have none, and stay what they are.
    pub(crate) fn use_registers(&mut self) -> Option<&mut Registers> {
        if let Self::Khepera { lines, owed } = self {
            let registers = Box::new(Registers::owing(*owed));
            *self = Self::Registers { lines: lines.clone(), registers };
        }
        self.registers_mut()
    }

    /// Positions, which are kept until its readings come.
    pub(crate) fn keep_positions(&mut self, told: [i32; 2]) {
        if let Self::Answers { positions, .. } = self {
            *positions = Some(told);
        }
    }

    /// The positions that came since the last readings.
    pub(crate) fn take_positions(&mut self) -> Option<[i32; 2]> {
        if let Self::Answers { positions, .. } = self { positions.take() } else { None }
    }

    /// The interface of a Create.
    #[inline]
    pub(crate) fn open_interface(&self) -> Option<&OpenInterface> {
        if let Self::OpenInterface(interface) = self { Some(interface) } else { None }
    }

    /// The interface of a Create, to be changed.
    #[inline]
    pub(crate) fn open_interface_mut(&mut self) -> Option<&mut OpenInterface> {
        if let Self::OpenInterface(interface) = self { Some(interface) } else { None }
    }

    /// The machine of an e-puck, to be changed.
    #[inline]
    pub(crate) fn asercom_mut(&mut self) -> Option<&mut Machine> {
        if let Self::Asercom(machine) = self { Some(machine) } else { None }
    }

    /// Messages that silence cut short so far.
    pub(crate) fn cut_short(&self) -> u64 {
        if let Self::Bare(bare) = self { bare.discarded() } else { 0 }
    }
}

/// The reason that a decoder of bare messages can be made.
const FITS: &str = "scenario files refuse messages that are too long";
