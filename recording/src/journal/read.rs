//! A journal that is read.

use std::io;

use baudbot_proto::v1;
use baudbot_scenario::ScenarioError;
use baudbot_sim::SavedError;
use prost::Message;
use thiserror::Error;

use super::{At, HEAD, JOURNAL_FORMAT, JournalHeader, MAGIC, Ports, Settings, TAIL, kind};

/// Why a journal cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is something else.
    #[error("is no journal of baudbot: its first line is missing")]
    Foreign,
    /// It is of another version of the format.
    #[error("is of format {0}; this version of baudbot reads format {JOURNAL_FORMAT}")]
    Format(String),
    /// It ends before the first state: it was begun and never used.
    #[error("ends before the first state")]
    Unfinished,
    /// A checksum does not match.
    #[error("is damaged at byte {0}")]
    Damaged(usize),
    /// Its scenario is not sound.
    #[error("has a scenario that cannot be used: {0}")]
    Scenario(#[from] ScenarioError),
    /// Its state cannot be used.
    #[error("has a state (tick {tick}, of baudbot {program}) that {source}")]
    State {
        /// Its tick.
        tick: u64,
        /// The version of the program that wrote it.
        program: String,
        /// Why.
        source: SavedError,
    },
    /// What has happened does not lead where it led.
    #[error(
        "does not lead to the state that it led to: {what} at tick {tick} (written by baudbot {program})"
    )]
    Differs {
        /// The tick.
        tick: u64,
        /// What differs.
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

impl Journal {
    /// Reads a journal.
    ///
    /// # Errors
    /// If it is none, or is damaged before its end.
    pub fn read(bytes: &[u8]) -> Result<Self, JournalError> {
        let mut at = beginning(bytes)?;
        let mut header = None;
        let mut entries = Vec::new();
        while let Some((kind, body, next)) = entry(bytes, at)? {
            let damaged = |_| JournalError::Damaged(at);
            match (kind, &header) {
                (kind::HEADER, None) => header = Some(JournalHeader::decode(body).map_err(damaged)?),
                (_, None) | (kind::HEADER, Some(_)) => return Err(JournalError::Damaged(at)),
                (kind::SETTINGS, _) => entries.push(Entry::Settings(decode(body, at)?)),
                (kind::STATE, _) => {
                    // A state has all that was before it.
                    entries.retain(|entry| matches!(entry, Entry::Settings(_)));
                    entries.push(Entry::State(decode(body, at)?));
                }
                (kind::INPUTS, _) => entries.push(Entry::Inputs(decode(body, at)?)),
                (kind::PORTS, _) => entries.push(Entry::Ports(decode(body, at)?)),
                (kind::AT, _) => entries.push(Entry::At(decode(body, at)?)),
                (_, Some(_)) => return Err(JournalError::Damaged(at)),
            }
            at = next;
        }
        let has_state = entries.iter().any(|entry| matches!(entry, Entry::State(_)));
        let Some(header) = header.filter(|_| has_state) else { return Err(JournalError::Unfinished) };
        Ok(Self { header, entries, torn: bytes.len() - at, length: at })
    }

    /// What it begins with.
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

/// Where the entries begin.
fn beginning(bytes: &[u8]) -> Result<usize, JournalError> {
    let expected = format!("{MAGIC}{JOURNAL_FORMAT}\n");
    if bytes.starts_with(expected.as_bytes()) {
        return Ok(expected.len());
    }
    if expected.as_bytes().starts_with(bytes) {
        return Err(JournalError::Unfinished);
    }
    let Some(version) = bytes.strip_prefix(MAGIC.as_bytes()) else { return Err(JournalError::Foreign) };
    let line = version.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let digits = line.iter().take(8).take_while(|byte| byte.is_ascii_digit());
    Err(JournalError::Format(digits.map(|digit| char::from(*digit)).collect()))
}

/// The kind and the body of an entry, and where the next one begins.
type Found<'a> = (u8, &'a [u8], usize);

/// The kind and the body of the entry that begins here, and where the next one does; `None` if a write ends here, whole or not.
fn entry(bytes: &[u8], at: usize) -> Result<Option<Found<'_>>, JournalError> {
    let rest = &bytes[at..];
    // What was never written is zeros, where a file got its length before its bytes.
    if rest.len() < HEAD || rest.iter().all(|byte| *byte == 0) {
        return Ok(None);
    }
    let number = |from: usize| rest.get(from..from.checked_add(4)?)?.try_into().ok().map(u32::from_le_bytes);
    if number(5) != Some(crc32fast::hash(&rest[..5])) {
        return Err(JournalError::Damaged(at));
    }
    let length =
        number(1).and_then(|length| usize::try_from(length).ok()).ok_or(JournalError::Damaged(at))?;
    let Some(end) = HEAD.checked_add(length).filter(|end| end + TAIL <= rest.len()) else { return Ok(None) };
    let body = &rest[HEAD..end];
    if number(end) != Some(crc32fast::hash(body)) {
        return Err(JournalError::Damaged(at));
    }
    Ok(Some((rest[0], body, at + end + TAIL)))
}

fn decode<M: Message + Default>(body: &[u8], at: usize) -> Result<M, JournalError> {
    M::decode(body).map_err(|_| JournalError::Damaged(at))
}
