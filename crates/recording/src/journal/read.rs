//! A journal that is read.

use std::io;

use baudbot_proto::v1;
use baudbot_scenario::ScenarioError;
use baudbot_sim::SavedError;
use prost::Message;
use thiserror::Error;

use super::{At, HEAD, JOURNAL_FORMAT, JournalHeader, MAGIC, Ports, Settings, TAIL, head_sum, kind};

/// The reason why a journal cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file is something else.
    #[error("is no journal of baudbot: its first line is missing")]
    Foreign,
    /// The journal is of another version of the format.
    #[error("is of format {0}; this version of baudbot reads formats 1 to {JOURNAL_FORMAT}")]
    Format(String),
    /// The journal ends before the first state: it was begun and never used.
    #[error("ends before the first state")]
    Unfinished,
    /// A checksum does not match, of what was on the disk for good.
    #[error("is damaged at byte {0}")]
    Damaged(usize),
    /// A checksum does not match, and nothing sound is before it.
    #[error("is damaged at byte {0}, in its beginning")]
    DamagedBeginning(usize),
    /// The journal's scenario is not sound.
    #[error("has a scenario that cannot be used: {0}")]
    Scenario(#[from] ScenarioError),
    /// The journal's state cannot be used.
    #[error("has a state (tick {tick}, of baudbot {program}) that {source}")]
    State {
        /// The state's tick.
        tick: u64,
        /// The version of the program that wrote it.
        program: String,
        /// The error of the state.
        source: SavedError,
    },
    /// The inputs do not lead to the state that was reached.
    #[error("does not reproduce its state: {what} at tick {tick} (written by baudbot {program})")]
    Differs {
        /// The tick.
        tick: u64,
        /// The difference.
        what: String,
        /// The version of the program that wrote it.
        program: String,
    },
}

/// A journal in memory.
#[derive(Debug)]
pub struct Journal {
    pub(super) header: JournalHeader,
    pub(super) entries: Vec<Entry>,
    torn: usize,
    length: usize,
}

/// An entry behind the header.
#[derive(Debug)]
pub(super) enum Entry {
    Settings(Settings),
    State(v1::RecordedState),
    Inputs(v1::RecordedInputs),
    Ports(Ports),
    At(At),
}

impl Entry {
    /// The content of an entry; `None` if it is the header, or cannot be read.
    fn read(found: &Found<'_>) -> Option<Self> {
        let body = found.body;
        Some(match found.kind {
            kind::SETTINGS => Self::Settings(Settings::decode(body).ok()?),
            kind::STATE => Self::State(v1::RecordedState::decode(body).ok()?),
            kind::INPUTS => Self::Inputs(v1::RecordedInputs::decode(body).ok()?),
            kind::PORTS => Self::Ports(Ports::decode(body).ok()?),
            kind::AT => Self::At(At::decode(body).ok()?),
            _ => return None,
        })
    }

    /// The tick of which it is.
    fn tick(&self) -> Option<u64> {
        match self {
            Self::State(state) => Some(state.tick),
            Self::Inputs(inputs) => Some(inputs.tick),
            Self::At(at) => Some(at.tick),
            Self::Settings(_) | Self::Ports(_) => None,
        }
    }

    /// The tick at which the world is after it.
    fn tick_after(&self) -> Option<u64> {
        match self {
            Self::Inputs(inputs) if !inputs.inputs.is_empty() => inputs.tick.checked_add(1),
            Self::State(_) | Self::Inputs(_) | Self::At(_) => self.tick(),
            Self::Settings(_) | Self::Ports(_) => None,
        }
    }
}

impl JournalError {
    /// Whether there is no state in it that was written to its end, as when the power fails while a journal begins.
    pub fn has_no_state(&self) -> bool {
        matches!(self, Self::Foreign | Self::Unfinished | Self::DamagedBeginning(_))
    }
}

impl Journal {
    /// Reads a journal, up to its last sound write.
    ///
    /// # Errors
    /// If it is none, has no state, or has lost what was on the disk for good.
    pub fn read(bytes: &[u8]) -> Result<Self, JournalError> {
        let (file, beginning) = Bytes::new(bytes)?;
        let mut reading = Reading::at(beginning);
        reading.go_on(&file);
        if !reading.is_torn(&file) {
            return Err(JournalError::Damaged(reading.at));
        }
        reading.journal(&file)
    }

    /// The journal's header.
    pub fn header(&self) -> &JournalHeader {
        &self.header
    }

    /// Bytes at its end that a write has left undone.
    pub fn torn(&self) -> usize {
        self.torn
    }

    /// Bytes before those.
    pub fn length(&self) -> usize {
        self.length
    }
}

/// The bytes of a journal.
pub(super) struct Bytes<'a> {
    pub(super) bytes: &'a [u8],
    format: u32,
}

/// An entry as it stands in the file.
pub(super) struct Found<'a> {
    pub(super) kind: u8,
    pub(super) body: &'a [u8],
    /// The place at which the next entry begins.
    pub(super) next: usize,
}

/// The progress of reading a journal.
pub(super) struct Reading {
    header: Option<JournalHeader>,
    entries: Vec<Entry>,
    /// The place at which the next entry begins.
    pub(super) at: usize,
    /// Entries and bytes that count: those of whole writes.
    whole: (usize, usize),
    /// A state is among those.
    has_state: bool,
    /// The tick at which the world is.
    tick: u64,
}

impl<'a> Bytes<'a> {
    /// The bytes of a journal, and the place at which its entries begin.
    pub(super) fn new(bytes: &'a [u8]) -> Result<(Self, usize), JournalError> {
        for format in 1..=JOURNAL_FORMAT {
            let expected = format!("{MAGIC}{format}\n");
            if bytes.starts_with(expected.as_bytes()) {
                return Ok((Self { bytes, format }, expected.len()));
            }
            if expected.as_bytes().starts_with(bytes) {
                return Err(JournalError::Unfinished);
            }
        }
        let Some(version) = bytes.strip_prefix(MAGIC.as_bytes()) else { return Err(JournalError::Foreign) };
        let line = version.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let digits = line.iter().take(8).take_while(|byte| byte.is_ascii_digit());
        Err(JournalError::Format(digits.map(|digit| char::from(*digit)).collect()))
    }

    fn number(&self, at: usize) -> Option<u32> {
        self.bytes.get(at..at.checked_add(4)?)?.try_into().ok().map(u32::from_le_bytes)
    }

    /// The end of the entry at this place, by its head, which is sound.
    fn end_of(&self, at: usize) -> Option<usize> {
        let head = self.bytes.get(at..at.checked_add(5)?)?;
        let place = (self.format > 1).then_some(at as u64);
        if self.number(at + 5)? != head_sum(place, head) {
            return None;
        }
        at.checked_add(HEAD)?.checked_add(usize::try_from(self.number(at + 1)?).ok()?)
    }

    /// The entry at this place, if it is sound.
    pub(super) fn entry(&self, at: usize) -> Option<Found<'a>> {
        let end = self.end_of(at)?;
        let body = self.bytes.get(at + HEAD..end)?;
        let is_sound = self.number(end)? == crc32fast::hash(body);
        is_sound.then(|| Found { kind: self.bytes[at], body, next: end + TAIL })
    }

    /// Whether the file ends in the middle of what is here: there is less than an entry, or what was never written, which is zeros
    /// where a file got its length before its bytes.
    fn is_cut_at(&self, at: usize) -> bool {
        let rest = &self.bytes[at..];
        let is_longer = |end: usize| end + TAIL > self.bytes.len();
        rest.len() < HEAD || rest.iter().all(|byte| *byte == 0) || self.end_of(at).is_some_and(is_longer)
    }

    /// Sound entries from this place on, wherever they begin.
    pub(super) fn behind(&self, at: usize) -> impl Iterator<Item = (usize, Found<'a>)> + '_ {
        (at + 1..self.bytes.len()).filter_map(|at| Some((at, self.entry(at)?)))
    }
}

impl Reading {
    /// Nothing yet.
    pub(super) fn at(beginning: usize) -> Self {
        Self {
            header: None,
            entries: Vec::new(),
            at: beginning,
            whole: (0, beginning),
            has_state: false,
            tick: 0,
        }
    }

    /// Reads on to the first entry that is not sound.
    pub(super) fn go_on(&mut self, file: &Bytes<'_>) {
        while let Some(found) = file.entry(self.at) {
            if self.take(file, &found).is_none() {
                return;
            }
        }
    }

    /// Takes an entry, unless it cannot be there.
    fn take(&mut self, file: &Bytes<'_>, found: &Found<'_>) -> Option<()> {
        if self.header.is_none() {
            let header = JournalHeader::decode(found.body).ok();
            self.header = Some(header.filter(|_| found.kind == kind::HEADER)?);
            self.at = found.next;
            return Some(());
        }
        let entry = Entry::read(found)?;
        // Time never goes back. In format 1 this alone detects a block that stands twice.
        if entry.tick().is_some_and(|tick| tick < self.tick) {
            return None;
        }
        self.tick = entry.tick_after().unwrap_or(self.tick);
        self.entries.push(entry);
        self.at = found.next;
        if file.format == 1 || found.kind == kind::AT {
            self.count();
        }
        Some(())
    }

    /// Accepts all that was read until now.
    fn count(&mut self) {
        let new = &self.entries[self.whole.0..];
        if let Some(state) = new.iter().rposition(|entry| matches!(entry, Entry::State(_))) {
            // A state has all that was before it.
            let (mut place, state) = (0, self.whole.0 + state);
            self.entries.retain(|entry| {
                place += 1;
                place > state || matches!(entry, Entry::Settings(_))
            });
            self.has_state = true;
        }
        self.whole = (self.entries.len(), self.at);
    }

    /// Drops the entries of a write that does not count, and goes on reading there.
    pub(super) fn skip_to(&mut self, at: usize) {
        self.entries.truncate(self.whole.0);
        self.at = at;
    }

    /// Whether the rest is an unfinished write, and nothing proves that it was on the disk for good.
    fn is_torn(&self, file: &Bytes<'_>) -> bool {
        if !self.has_state || file.is_cut_at(self.at) {
            return true;
        }
        let was_on_disk = |found: &Found<'_>| match found.kind {
            kind::AT => At::decode(found.body).is_ok_and(|at| at.on_disk > self.at as u64),
            _ => false,
        };
        let goes_on = |found: &Found<'_>| Entry::read(found).and_then(|entry| entry.tick()) > Some(self.tick);
        let is_later = |found: &Found<'_>| if file.format == 1 { goes_on(found) } else { was_on_disk(found) };
        !file.behind(self.at).any(|(_, found)| is_later(&found))
    }

    /// The journal that has been read.
    pub(super) fn journal(mut self, file: &Bytes<'_>) -> Result<Journal, JournalError> {
        let (count, length) = self.whole;
        let Some(header) = self.header.filter(|_| self.has_state) else {
            let is_cut = file.is_cut_at(self.at);
            return Err(if is_cut {
                JournalError::Unfinished
            } else {
                JournalError::DamagedBeginning(self.at)
            });
        };
        self.entries.truncate(count);
        Ok(Journal { header, entries: self.entries, torn: file.bytes.len() - length, length })
    }
}
