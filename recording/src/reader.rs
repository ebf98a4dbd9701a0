//! The messages of an MCAP file, one after the other, as far as it goes.

use std::collections::HashMap;
use std::io::Read;
use std::sync::Arc;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::error::RecordingError;

/// Reads messages. It ends where the file ends, or where it is damaged.
pub(crate) struct Reader<R> {
    file: R,
    records: LinearReader,
    topics: HashMap<u16, Arc<str>>,
    /// Why the file ends too early, if it does.
    problem: Option<String>,
    has_begun: bool,
}

/// A message.
pub(crate) struct Message {
    pub(crate) topic: Arc<str>,
    pub(crate) data: Vec<u8>,
}

impl<R: Read> Reader<R> {
    /// `limit`: no record is longer than that.
    pub(crate) fn new(file: R, limit: usize) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(limit.min(MAX_RECORD));
        let records = LinearReader::new_with_options(options);
        Self { file, records, topics: HashMap::new(), problem: None, has_begun: false }
    }

    /// The next message on a topic that `wanted` says yes to; `None` at the end.
    pub(crate) fn next(&mut self, wanted: impl Fn(&str) -> bool) -> Result<Option<Message>, RecordingError> {
        while self.problem.is_none() {
            let Some(event) = self.records.next_event() else { return Ok(None) };
            let record = match event {
                Ok(LinearReadEvent::ReadRequest(n)) => {
                    let n = self.file.read(self.records.insert(n))?;
                    self.records.notify_read(n);
                    continue;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => mcap::parse_record(opcode, data),
                Err(error) => Err(error),
            };
            match record {
                Ok(Record::Channel(channel)) => {
                    self.topics.insert(channel.id, channel.topic.into());
                }
                Ok(Record::Message { header, data }) => {
                    let Some(topic) = self.topics.get(&header.channel_id) else { continue };
                    if wanted(topic) {
                        let (topic, data) = (Arc::clone(topic), data.into_owned());
                        return Ok(Some(Message { topic, data }));
                    }
                }
                Ok(_) => {}
                Err(error) if self.has_begun => self.problem = Some(words(&error)),
                Err(error) => return Err(RecordingError::NotMcap(words(&error))),
            }
            self.has_begun = true;
        }
        Ok(None)
    }

    /// Why the file ends too early, if it does; known at its end.
    pub(crate) fn problem(self) -> Option<String> {
        self.problem
    }
}

fn words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::UnexpectedEof => "the file ends in the middle".to_owned(),
        mcap::McapError::BadMagic => "it does not begin, or not end, as one".to_owned(),
        error => format!("the file is damaged: {error}"),
    }
}

/// Longest record that is read, in bytes.
const MAX_RECORD: usize = 1 << 30;
