//! The conversation with a Create: its answers mean what was asked before.

use super::packets::{self, PacketName};
use super::text::{Ascii, Count};
use super::{Cut, Meaning, commands};
use crate::buffer::Buffer;
use crate::create::{Commands, HEADER, Version, group, listed_len};

/// The time after which a question is not answered any more, in nanoseconds: the interface was off, or its answer was
/// lost.
pub const PATIENCE_NS: u64 = 500_000_000;

/// Most bytes of questions that wait for their answers. Of what is asked beyond them the answers are not understood.
const MOST_ASKED: usize = 512;

/// The last requests, and the stream that is under way.
#[derive(Clone, Debug, Default)]
pub(super) struct Conversation {
    /// Finds the commands of the robot that was last listened to.
    commands: Option<(Version, Commands)>,
    asked: Asked,
    /// The packets and groups of the stream; none if there is no stream.
    streamed: Buffer<255>,
    is_paused: bool,
}

impl Conversation {
    /// The command that is under way is cut off.
    pub(super) fn forget_command(&mut self) {
        self.commands = None;
    }

    /// Cuts the bytes to the robot, the last of which is this.
    pub(super) fn cut_command(&mut self, version: Version, byte: u8) -> Cut {
        let fits = self.commands.as_ref().is_some_and(|(of, _)| *of == version);
        if !fits {
            self.commands = None;
        }
        let (_, commands) = self.commands.get_or_insert_with(|| (version, Commands::new(version)));
        if commands.push(byte).is_some() { Cut::After } else { Cut::Wait }
    }

    /// A command whose last byte came at `at_ns`.
    pub(super) fn read_command(&mut self, version: Version, at_ns: u64, bytes: &[u8]) -> Meaning {
        match *bytes {
            [142, id] => self.asked.push(at_ns, &[id]),
            [149, _, ref ids @ ..] => self.asked.push(at_ns, ids),
            [148, _, ref ids @ ..] => {
                self.streamed.clear();
                ids.iter().for_each(|&id| _ = self.streamed.push(id));
                self.is_paused = false;
            }
            [150, resumes] => self.is_paused = resumes == 0,
            // Reset and Stop end a stream.
            [7 | 173] => *self = Self::default(),
            _ => {}
        }
        commands::read(version, bytes)
    }

    /// Cuts the robot's bytes, the last of which came at `at_ns`.
    pub(super) fn cut_answer(&mut self, version: Version, at_ns: u64, bytes: &[u8]) -> Cut {
        let is_complete = |len: usize| if bytes.len() >= len { Cut::After } else { Cut::Wait };
        if bytes.len() == 1 {
            self.asked.forget(at_ns);
        }
        match self.kind(version, bytes) {
            Kind::Undecided => Cut::Wait,
            Kind::Stream(len) | Kind::Answer(len) => is_complete(len),
            Kind::Text => match bytes {
                [.., HEADER] if bytes.len() > 1 && self.is_streaming() => Cut::Before,
                [.., b'\n'] => Cut::After,
                _ => Cut::Wait,
            },
        }
    }

    /// The kind of message that begins with these bytes.
    fn kind(&self, version: Version, bytes: &[u8]) -> Kind {
        let answer = self.asked.first().map(|ids| listed_len(version, ids));
        let streamed = if self.is_streaming() { self.streamed.used() } else { &[] };
        let streamed_len = (!streamed.is_empty()).then(|| streamed.len() + listed_len(version, streamed));
        match (bytes, streamed_len, answer) {
            ([HEADER], Some(_), None | Some(2..)) => Kind::Undecided,
            ([HEADER, len, ..], Some(expected), _) if usize::from(*len) == expected => {
                Kind::Stream(expected + 3)
            }
            (_, _, Some(len)) if len > 0 => Kind::Answer(len),
            _ => Kind::Text,
        }
    }

    fn is_streaming(&self) -> bool {
        !self.is_paused && !self.streamed.used().is_empty()
    }

    /// An answer, a message of the stream, or a line of text.
    pub(super) fn read_answer(&mut self, version: Version, bytes: &[u8]) -> Meaning {
        match self.kind(version, bytes) {
            Kind::Stream(len) if len == bytes.len() => stream(version, bytes),
            Kind::Answer(len) if len == bytes.len() => {
                let mut meaning = answer(version, self.asked.first().unwrap_or_default(), bytes);
                self.asked.pop();
                meaning.is_understood = true;
                meaning
            }
            Kind::Text | Kind::Undecided | Kind::Stream(_) | Kind::Answer(_) => line(bytes),
        }
    }
}

/// A kind of message of the robot's.
enum Kind {
    /// The next byte tells.
    Undecided,
    /// A message of a stream, of so many bytes.
    Stream(usize),
    /// The answer to the oldest question, of so many bytes.
    Answer(usize),
    /// Nothing that was asked for. The robot writes lines of text when it starts.
    Text,
}

/// The packets of an answer.
fn answer(version: Version, ids: &[u8], bytes: &[u8]) -> Meaning {
    let mut meaning = Meaning::of("answer");
    let mut rest = bytes;
    for &id in ids {
        rest = packets::add(&mut meaning, version, id, rest);
    }
    meaning
}

/// A message of a stream.
fn stream(version: Version, bytes: &[u8]) -> Meaning {
    let sum = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    let is_right = sum == 0;
    let mut meaning = Meaning::of(if is_right { "stream, checksum right" } else { "stream, checksum wrong" });
    meaning.is_understood = is_right;
    let mut rest = bytes.get(2..bytes.len().saturating_sub(1)).unwrap_or_default();
    while let Some((&id, behind)) = rest.split_first() {
        if group(version, id).is_none() {
            meaning.is_understood = false;
            meaning.add(format_args!("; there is no packet {id}"));
            break;
        }
        rest = packets::add(&mut meaning, version, id, behind);
    }
    meaning
}

fn line(bytes: &[u8]) -> Meaning {
    let text = bytes.trim_ascii();
    if !text.is_empty() && text.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\t')) {
        return Meaning::of(format_args!("text: {}", Ascii(text)));
    }
    Meaning::not_understood(bytes, "not requested")
}

/// The ids of a list of packets and groups, by their names.
pub(super) fn add_list(meaning: &mut Meaning, version: Version, ids: &[u8]) {
    meaning.add(format_args!(" {}:", Count(ids.len(), "packet")));
    for (i, &id) in ids.iter().enumerate() {
        let mark = if i == 0 { "" } else { "," };
        meaning.add(format_args!("{mark} {}", PacketName { version, id }));
    }
}

/// Questions that wait for their answers, the oldest first: of each how many packets and groups, and their numbers.
#[derive(Clone, Debug, Default)]
struct Asked {
    questions: Buffer<MOST_ASKED>,
    /// The instant at which the last one came.
    at_ns: u64,
}

impl Asked {
    fn push(&mut self, at_ns: u64, ids: &[u8]) {
        self.forget(at_ns);
        self.at_ns = at_ns;
        let has_room = self.questions.len() + 1 + ids.len() <= MOST_ASKED;
        if let Ok(count) = u8::try_from(ids.len())
            && count > 0
            && has_room
        {
            self.questions.push(count);
            ids.iter().for_each(|&id| _ = self.questions.push(id));
        }
    }

    /// The questions that were asked too long ago are dropped: no answer will come.
    fn forget(&mut self, at_ns: u64) {
        if at_ns.saturating_sub(self.at_ns) > PATIENCE_NS {
            self.questions.clear();
        }
    }

    fn first(&self) -> Option<&[u8]> {
        let (&count, rest) = self.questions.used().split_first()?;
        rest.get(..usize::from(count))
    }

    fn pop(&mut self) {
        let taken = self.first().map_or(0, |ids| 1 + ids.len());
        let mut rest = Buffer::new();
        let behind = self.questions.used().get(taken..).unwrap_or_default();
        behind.iter().for_each(|&byte| _ = rest.push(byte));
        self.questions = rest;
    }
}
