//! The frames of a recording: what an observer saw of the run.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use baudbot_proto::v1::WatchResponse;
use prost::Message;

use crate::error::RecordingError;
use crate::reader::{Item, Reader};
use crate::topic;

/// The frames of a recording, one after the other. There are as many a simulated second as were asked for when it was
/// made, and none if none were.
pub struct Frames<R>(Reader<R>);

impl Frames<BufReader<File>> {
    /// The frames of a file.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Ok(Self::read(BufReader::with_capacity(1 << 20, File::open(path)?)))
    }
}

impl<R: Read> Frames<R> {
    /// The frames of the bytes of a file.
    pub fn read(file: R) -> Self {
        Self(Reader::new(file, usize::MAX))
    }
}

impl<R: Read> Iterator for Frames<R> {
    type Item = Result<WatchResponse, RecordingError>;

    /// The next frame, past what is damaged.
    fn next(&mut self) -> Option<Self::Item> {
        let item = loop {
            match self.0.next(|topic| topic == topic::FRAMES).transpose()? {
                Ok(Item::Message(message)) => break Ok(message),
                Ok(Item::Damage) => {}
                Err(error) => break Err(error),
            }
        };
        Some(item.and_then(|message| {
            let decoded = WatchResponse::decode(message.data.as_slice());
            decoded.map_err(|source| RecordingError::Message { topic: topic::FRAMES.to_owned(), source })
        }))
    }
}
