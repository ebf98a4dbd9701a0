//! The messages of an MCAP file, one after the other; damaged parts are skipped.
//!
//! No statement of a file about itself is trusted: each length is compared with the bytes that are there before memory is
//! allocated, and an unpacked chunk with its checksum. After an invalid record the reader searches for the next chunk, byte
//! by byte.

mod bytes;
mod chunk;
mod record;

use std::collections::HashMap;
use std::io::Read;
use std::sync::Arc;

use crate::error::RecordingError;
use bytes::Bytes;
use chunk::Unusable;
use record::{BEGINNING, Chunk, HEAD, Record, Statistics};

/// Reads messages.
pub(crate) struct Reader<R> {
    bytes: Bytes<R>,
    /// The most bytes that all chunks together may unpack to.
    limit: usize,
    unpacked: usize,
    /// The chunk that is being read, and where in it.
    chunk: Vec<u8>,
    at: usize,
    topics: HashMap<u16, Arc<str>>,
    seen: Seen,
    has_begun: bool,
    is_over: bool,
}

/// The next part of the file.
pub(crate) enum Item {
    Message(Message),
    /// Something is damaged between the message before it and the one behind it.
    Damage,
}

/// A message.
pub(crate) struct Message {
    pub(crate) topic: Arc<str>,
    pub(crate) data: Vec<u8>,
}

/// Information about a file besides its messages.
#[derive(Clone, Debug, Default)]
struct Seen {
    /// Messages and chunks that are as they were written.
    messages: u64,
    chunks: u32,
    damages: u32,
    /// The place of the first damage.
    first_damage: u64,
    /// The end of the messages was there; whether their checksum is the one of the file, if it has one.
    end: Option<Option<bool>>,
    /// The counts of the whole file, by its own record.
    statistics: Option<Statistics>,
    /// The last record of the file was there.
    has_footer: bool,
    /// Reading was given up.
    given_up: bool,
    /// Bytes that came out of chunks that were not sound.
    wasted: usize,
}

/// The condition of a file; known at its end.
#[derive(Clone, Debug)]
pub(crate) struct Condition {
    /// All messages that were ever in it have been read.
    pub(crate) is_whole: bool,
    /// The problem of the file, if there is one: if the file is whole, one that does not matter.
    pub(crate) problem: Option<String>,
    /// The times of its first and its last message, in nanoseconds, if it has them.
    pub(crate) times_ns: Option<(u64, u64)>,
}

impl<R: Read> Reader<R> {
    /// `limit`: what is in it is not longer than that, in bytes.
    pub(crate) fn new(file: R, limit: usize) -> Self {
        Self {
            bytes: Bytes::new(file),
            limit,
            unpacked: 0,
            chunk: Vec::new(),
            at: 0,
            topics: HashMap::new(),
            seen: Seen::default(),
            has_begun: false,
            is_over: false,
        }
    }

    /// The next message on a topic that `wanted` accepts, or the next damage; `None` at the end.
    pub(crate) fn next(&mut self, wanted: impl Fn(&str) -> bool) -> Result<Option<Item>, RecordingError> {
        if !self.has_begun {
            self.begin()?;
        }
        loop {
            if let Some(message) = self.next_of_chunk(&wanted) {
                return Ok(Some(Item::Message(message)));
            }
            if self.is_over {
                return Ok(None);
            }
            match self.next_record(&wanted)? {
                Next::Message(message) => return Ok(Some(Item::Message(message))),
                Next::Nothing => {}
                Next::Damage => {
                    self.damaged();
                    self.look_for_more()?;
                    return Ok(Some(Item::Damage));
                }
            }
        }
    }

    /// The condition of the file, once there is nothing more to be read.
    pub(crate) fn condition(self) -> Condition {
        let Seen { messages, chunks, end, damages, has_footer, .. } = self.seen;
        let statistics = self.seen.statistics.filter(|_| has_footer);
        let found = (messages, chunks);
        let all = statistics.map(|statistics| (statistics.messages, statistics.chunks) == found);
        let is_whole = match (end, all) {
            // A file that is cut off anywhere is not complete.
            _ if !has_footer => false,
            (None, _) => false,
            (Some(Some(true)), _) | (_, Some(true)) => true,
            (Some(None), None) => damages == 0,
            (Some(Some(false) | None), Some(false) | None) => false,
        };
        let times_ns = statistics.map(|statistics| (statistics.first_ns, statistics.last_ns));
        Condition { is_whole, problem: self.seen.problem(is_whole), times_ns }
    }

    fn begin(&mut self) -> Result<(), RecordingError> {
        self.has_begun = true;
        if self.bytes.peek(MAGIC.len())? != MAGIC {
            return Err(RecordingError::NotMcap("its header is missing".to_owned()));
        }
        self.bytes.take(MAGIC.len());
        Ok(())
    }

    fn next_of_chunk(&mut self, wanted: impl Fn(&str) -> bool) -> Option<Message> {
        while self.at < self.chunk.len() {
            let (record, next) = chunk::record(&self.chunk, self.at)?;
            self.at = next;
            if let Some(message) = self.seen.note(&mut self.topics, record, &wanted) {
                return Some(message);
            }
        }
        None
    }

    fn next_record(&mut self, wanted: impl Fn(&str) -> bool) -> Result<Next, RecordingError> {
        let head = self.bytes.peek(HEAD)?;
        if head.is_empty() {
            self.is_over = true;
            return Ok(Next::Nothing);
        }
        let Some((kind, length)) = kind_and_length(head) else { return Ok(Next::Damage) };
        let bytes = self.bytes.peek(length)?;
        let record = bytes.get(HEAD..length).and_then(|body| record::parse(kind, body));
        let mut next = Next::Nothing;
        match record {
            None => return Ok(Next::Damage),
            Some(Record::Chunk(packed)) => {
                let room = self.limit - self.unpacked;
                let chunk = &mut self.chunk;
                (self.at, next) = (0, self.seen.chunk(&packed, chunk, (room, self.limit))?);
                self.unpacked += chunk.len();
            }
            Some(Record::DataEnd { checksum }) => {
                self.end_messages(checksum, length);
                return Ok(next);
            }
            Some(Record::Footer { checksum }) => {
                self.end(checksum, length);
                return Ok(next);
            }
            Some(Record::Statistics(statistics)) => self.seen.statistics = Some(statistics),
            // A file with packed messages has all messages packed: this was something else.
            Some(Record::Message { .. }) if self.seen.chunks > 0 => return Ok(Next::Damage),
            Some(record @ (Record::Channel { .. } | Record::Message { .. } | Record::Other)) => {
                next = self.seen.note(&mut self.topics, record, &wanted).map_or(next, Next::Message);
            }
        }
        if !matches!(next, Next::Damage) {
            self.bytes.take(length);
        }
        Ok(next)
    }

    /// A record of so many bytes ends the messages, and has the checksum of the file so far.
    fn end_messages(&mut self, checksum: u32, length: usize) {
        let found = self.bytes.checksum();
        self.seen.end = Some((checksum != 0).then_some(checksum == found));
        self.bytes.take(length);
        // The rest of the file has a checksum of its own.
        self.bytes.checksum();
    }

    /// The last record, of so many bytes, ends with the checksum of the file's summary section.
    fn end(&mut self, checksum: u32, length: usize) {
        self.bytes.take(length - size_of_val(&checksum));
        if checksum != 0 && checksum != self.bytes.checksum() {
            self.seen.statistics = None;
        }
        (self.seen.has_footer, self.is_over) = (true, true);
    }

    fn damaged(&mut self) {
        if self.seen.damages == 0 {
            self.seen.first_damage = self.bytes.place();
        }
        self.seen.damages = self.seen.damages.saturating_add(1);
    }

    /// Goes on to the next place where a chunk may begin, or the end of the messages.
    fn look_for_more(&mut self) -> Result<(), RecordingError> {
        if self.seen.wasted > MAX_WASTED || self.seen.damages > MAX_DAMAGES {
            (self.seen.given_up, self.is_over) = (true, true);
            return Ok(());
        }
        self.bytes.take(1);
        loop {
            let ahead = self.bytes.ahead()?;
            if ahead.is_empty() {
                self.is_over = true;
                return Ok(());
            }
            match record::first_of_interest(ahead) {
                None => {
                    let all = ahead.len();
                    self.bytes.take(all);
                }
                Some(place) => {
                    self.bytes.take(place);
                    if record::may_begin(self.bytes.peek(BEGINNING)?) {
                        return Ok(());
                    }
                    self.bytes.take(1);
                }
            }
        }
    }
}

impl Seen {
    /// Unpacks a chunk, unless it is not sound; then nothing of it is left. `room`: how many bytes it may have, and how
    /// many all chunks together.
    fn chunk(
        &mut self,
        packed: &Chunk<'_>,
        chunk: &mut Vec<u8>,
        (room, limit): (usize, usize),
    ) -> Result<Next, RecordingError> {
        if packed.size > room as u64 {
            return Err(RecordingError::TooLong { limit });
        }
        match chunk::unpack(packed, chunk) {
            Ok(()) => {
                self.chunks += 1;
                Ok(Next::Nothing)
            }
            Err(Unusable::Packed(packing)) => Err(RecordingError::Packed(packing)),
            Err(Unusable::Damaged) => {
                // The work on a damaged chunk counts against the limit.
                self.wasted += packed.data.len() + chunk.len();
                chunk.clear();
                Ok(Next::Damage)
            }
        }
    }

    /// Notes a channel; gives a message that is wanted.
    fn note(
        &mut self,
        topics: &mut HashMap<u16, Arc<str>>,
        record: Record<'_>,
        wanted: impl Fn(&str) -> bool,
    ) -> Option<Message> {
        match record {
            Record::Channel { id, topic } => {
                topics.insert(id, topic.into());
                None
            }
            Record::Message { channel, data } => {
                self.messages += 1;
                let topic = topics.get(&channel).filter(|topic| wanted(topic))?;
                Some(Message { topic: Arc::clone(topic), data: data.to_vec() })
            }
            Record::Chunk(_)
            | Record::DataEnd { .. }
            | Record::Footer { .. }
            | Record::Statistics(_)
            | Record::Other => None,
        }
    }

    fn problem(&self, is_whole: bool) -> Option<String> {
        let at = self.first_damage;
        let cut_off = || (!is_whole).then(|| "the file is cut off".to_owned());
        let end = self.end.filter(|_| self.has_footer);
        match (self.damages, end) {
            _ if self.given_up => Some(format!("the file is damaged from byte {at} on")),
            (0, None) => cut_off(),
            (0, Some(_)) => (!is_whole).then(|| "chunks of the file are missing".to_owned()),
            // A cut within a record looks like damage at the end.
            (1, None) => Some(format!("the file is cut off or damaged at byte {at}")),
            (1, Some(_)) => Some(format!("the file is damaged at byte {at}")),
            (n, Some(_)) => {
                Some(format!("the file is damaged in {n} places, the first of them at byte {at}"))
            }
            (n, None) => Some(format!(
                "the file is damaged in {n} places, the first of them at byte {at}, and its end is missing"
            )),
        }
    }
}

/// The kind of the record that begins with these bytes, and how many it has; `None` if no record does.
fn kind_and_length(head: &[u8]) -> Option<(u8, usize)> {
    let (kind, length) = record::head(head)?;
    let length = usize::try_from(length).ok().filter(|length| *length <= MAX_RECORD)?;
    Some((kind, HEAD + length))
}

/// The result of reading a record of the file.
enum Next {
    Nothing,
    Message(Message),
    Damage,
}

/// The bytes with which an MCAP file begins.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Longest record that is read, in bytes.
const MAX_RECORD: usize = 1 << 30;

/// The most bytes that may come out of chunks that then turn out not to be sound, before the rest is given up: each
/// byte of a file could be made to look like the beginning of one.
const MAX_WASTED: usize = 1 << 30;

/// The number of damaged places beyond which reading is given up.
const MAX_DAMAGES: u32 = 1000;
