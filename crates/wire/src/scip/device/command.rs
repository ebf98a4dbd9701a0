//! Lines as commands.

use serde::{Deserialize, Serialize};

use super::{Description, Model, RATES};
use crate::buffer::Buffer;

/// The most bytes of a line that are kept: twice the longest command. Of a longer one the rest is passed over.
pub(super) const MAX_LINE: usize = 64;

/// Collects a line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commands {
    line: Buffer<MAX_LINE>,
    is_too_long: bool,
}

impl Commands {
    /// Takes a byte; whether it ends a line that has anything in it.
    pub(super) fn push(&mut self, byte: u8) -> bool {
        if byte == b'\n' || byte == b'\r' {
            return self.line.len() > 0;
        }
        self.is_too_long |= !self.line.push(byte);
        false
    }

    /// The line without its end.
    pub(super) fn line(&self) -> &[u8] {
        self.line.used()
    }

    /// The meaning of the line to a device of this description.
    pub(super) fn parse(&self, facts: &Description) -> Result<Command, Status> {
        if self.is_too_long {
            return Err(*b"0B");
        }
        let line = self.line();
        let (command, text) = match line.iter().position(|&byte| byte == b';') {
            Some(at) => (line.get(..at).unwrap_or_default(), line.get(at + 1..)),
            None => (line, None),
        };
        let (kind, parameters) = Kind::of(command, facts.model)?;
        if let Some(text) = text {
            check_text(text, facts.model)?;
        }
        if parameters.len() < kind.parameters() {
            return Err(match facts.model {
                Model::Urg04lx => *b"0C",
                Model::Ust10lx => *b"0H",
            });
        }
        if parameters.len() > kind.parameters() {
            return Err(*b"0D");
        }
        Command::read(kind, parameters, facts)
    }
}

/// Two characters.
pub(super) type Status = [u8; 2];

/// Checks that a text has at most 16 letters, digits and some signs.
fn check_text(text: &[u8], model: Model) -> Result<(), Status> {
    if text.len() > 16 {
        return Err(*b"0G");
    }
    let is_allowed = |byte: &u8| byte.is_ascii_alphanumeric() || b" ._+@".contains(byte);
    match model {
        Model::Urg04lx if !text.iter().all(is_allowed) => Err(*b"0H"),
        Model::Urg04lx | Model::Ust10lx => Ok(()),
    }
}

/// The kind of command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "they are the letters of the protocol, explained at the head of the module")]
pub enum Kind {
    Vv,
    Pp,
    Ii,
    Bm,
    Qt,
    Rs,
    Rt,
    Rb,
    Tm,
    Ss,
    St,
    Sl,
    /// `GD`, `GS` or `GE`.
    Get(Scans),
    /// `MD`, `MS` or `ME`.
    Measure(Scans),
}

/// The values of the scans to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scans {
    /// Distances in three characters.
    Three,
    /// Distances in two characters.
    Two,
    /// Distances and intensities, in three characters each.
    Intensities,
}

impl Kind {
    /// The command that begins the line, and what follows it.
    fn of(command: &[u8], model: Model) -> Result<(Self, &[u8]), Status> {
        let (kind, is_of_ust) = match command.first_chunk::<2>().ok_or(*b"0E")? {
            b"VV" => (Self::Vv, false),
            b"PP" => (Self::Pp, false),
            b"II" => (Self::Ii, false),
            b"BM" => (Self::Bm, false),
            b"QT" => (Self::Qt, false),
            b"RS" => (Self::Rs, false),
            b"TM" => (Self::Tm, false),
            b"GD" => (Self::Get(Scans::Three), false),
            b"GS" => (Self::Get(Scans::Two), false),
            b"MD" => (Self::Measure(Scans::Three), false),
            b"MS" => (Self::Measure(Scans::Two), false),
            b"GE" => (Self::Get(Scans::Intensities), true),
            b"ME" => (Self::Measure(Scans::Intensities), true),
            b"RT" => (Self::Rt, true),
            b"RB" => (Self::Rb, true),
            b"SS" => match model {
                Model::Urg04lx => (Self::Ss, false),
                Model::Ust10lx => return Err(*b"0F"),
            },
            b"%S" => match command.get(2) {
                Some(b'T') => (Self::St, true),
                Some(b'L') => (Self::Sl, true),
                Some(_) | None => return Err(*b"0E"),
            },
            _ => return Err(*b"0E"),
        };
        if is_of_ust && model != Model::Ust10lx {
            return Err(*b"0E");
        }
        let letters = if matches!(kind, Self::St | Self::Sl) { 3 } else { 2 };
        Ok((kind, command.get(letters..).unwrap_or_default()))
    }

    /// Characters of its parameters.
    const fn parameters(self) -> usize {
        match self {
            Self::Vv | Self::Pp | Self::Ii | Self::Bm | Self::Qt => 0,
            Self::Rs | Self::Rt | Self::Rb | Self::St | Self::Sl => 0,
            Self::Tm => 1,
            Self::Ss => 6,
            Self::Get(_) => 10,
            Self::Measure(_) => 13,
        }
    }
}

/// A command with parameters that it may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Command {
    pub(super) kind: Kind,
    /// The steps of a scan.
    pub(super) steps: Steps,
    /// Scans that are left out between two; of `SS` the rate; of `TM` the digit.
    pub(super) number: u32,
    /// The number of scans, 0 without an end.
    pub(super) scans: u8,
}

/// The part of a scan that is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Steps {
    pub(super) first: u16,
    pub(super) last: u16,
    /// Neighbouring steps that give one value; 0 means 1.
    pub(super) cluster: u8,
}

impl Command {
    fn read(kind: Kind, parameters: &[u8], facts: &Description) -> Result<Self, Status> {
        let mut command = Self { kind, steps: Steps::default(), number: 0, scans: 0 };
        match kind {
            Kind::Get(_) => command.steps = steps(parameters, facts)?,
            Kind::Measure(_) => {
                command.steps = steps(parameters, facts)?;
                command.number = number(parameters, 10, 1).ok_or(*b"06")?;
                command.scans = number(parameters, 11, 2).ok_or(*b"07")? as u8;
            }
            Kind::Tm => command.number = number(parameters, 0, 1).filter(|&n| n < 3).ok_or(*b"01")?,
            Kind::Ss => {
                command.number = number(parameters, 0, 6).ok_or(*b"01")?;
                if !RATES.contains(&command.number) {
                    return Err(*b"02");
                }
            }
            Kind::Vv | Kind::Pp | Kind::Ii | Kind::Bm | Kind::Qt => {}
            Kind::Rs | Kind::Rt | Kind::Rb | Kind::St | Kind::Sl => {}
        }
        Ok(command)
    }
}

fn steps(parameters: &[u8], facts: &Description) -> Result<Steps, Status> {
    let first = number(parameters, 0, 4).ok_or(*b"01")? as u16;
    let last = number(parameters, 4, 4).ok_or(*b"02")? as u16;
    let cluster = number(parameters, 8, 2).ok_or(*b"03")? as u8;
    if last > facts.end_step() {
        return Err(*b"04");
    }
    if last < first {
        return Err(*b"05");
    }
    Ok(Steps { first, last, cluster })
}

/// The number in `len` decimal digits.
fn number(parameters: &[u8], from: usize, len: usize) -> Option<u32> {
    let digits = parameters.get(from..from + len)?;
    digits
        .iter()
        .try_fold(0, |number, byte| byte.is_ascii_digit().then(|| number * 10 + u32::from(byte - b'0')))
}
