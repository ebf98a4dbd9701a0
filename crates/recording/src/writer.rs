//! Writes a recording.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use baudbot_proto::v1;
use baudbot_sim::Scenario;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use prost::Message;

use crate::error::WriteError;
use crate::file::RecordingFile;
use crate::foxglove::{FoxgloveEncoder, FoxgloveMessage, MessageSchema};
use crate::{FORMAT, PROGRAM_VERSION, schema, topic};

type Result<T> = std::result::Result<T, WriteError>;

/// Writes a recording into a file. What has been written up to a [mark](Self::mark) is whole, whatever happens then.
pub struct Writer<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    channels: Channels,
    step_ns: u64,
    sequence: u32,
    buffer: Vec<u8>,
    /// The description of the world, once it is known.
    shown: Option<Shown>,
}

/// The channels of our own messages.
struct Channels {
    header: u16,
    state: u16,
    inputs: u16,
    marks: u16,
    events: u16,
}

#[cfg(feature = "lz4")]
const COMPRESSION: Option<Compression> = Some(Compression::Lz4);
#[cfg(not(feature = "lz4"))]
const COMPRESSION: Option<Compression> = None;

/// Data for other programs.
struct Shown {
    encoder: FoxgloveEncoder,
    channels: BTreeMap<Arc<str>, u16>,
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a recording.
    ///
    /// # Errors
    /// If that cannot be written.
    pub fn new(out: W, header: &v1::RecordingHeader) -> Result<Self> {
        let options = WriteOptions::new()
            .compression(COMPRESSION)
            // A chunk is written at once, when it is whole.
            .disable_seeking(true)
            .chunk_size(Some(CHUNK))
            .profile("baudbot")
            .library(format!("baudbot {PROGRAM_VERSION}"));
        let mut mcap = options.create(out)?;
        let channels = Channels {
            header: channel(&mut mcap, topic::HEADER, "RecordingHeader")?,
            state: channel(&mut mcap, topic::STATE, "RecordedState")?,
            inputs: channel(&mut mcap, topic::INPUTS, "RecordedInputs")?,
            marks: channel(&mut mcap, topic::MARKS, "RecordedMark")?,
            events: channel(&mut mcap, topic::EVENTS, "RecordedEvent")?,
        };
        let (step_ns, buffer) = (header.step_ns, Vec::new());
        let mut writer = Self { mcap, channels, step_ns, sequence: 0, buffer, shown: None };
        writer.write(writer.channels.header, 0, header)?;
        // The header is in a chunk of its own, so that later damage does not affect it.
        writer.mcap.flush()?;
        Ok(writer)
    }

    /// A state.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn state(&mut self, state: &v1::RecordedState) -> Result<()> {
        self.write(self.channels.state, state.tick * self.step_ns, state)
    }

    /// Writes the inputs of the world in a tick.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn inputs(&mut self, inputs: &v1::RecordedInputs) -> Result<()> {
        self.write(self.channels.inputs, inputs.tick * self.step_ns, inputs)
    }

    /// All that entered the world before this mark's tick has been written: it goes into the file now.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn mark(&mut self, mark: &v1::RecordedMark) -> Result<()> {
        self.write(self.channels.marks, mark.tick * self.step_ns, mark)?;
        Ok(self.mcap.flush()?)
    }

    /// Something that happened.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn event(&mut self, event: &v1::RecordedEvent) -> Result<()> {
        let time_ns = event.tick * self.step_ns;
        self.write(self.channels.events, time_ns, event)?;
        let shown = self.shown.as_ref();
        let message = shown.map(|shown| shown.encoder.event(time_ns, event.kind(), &event.text));
        self.message(message)
    }

    /// Writes the times that brains took to answer until now.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn thinking(&mut self, thinking: &v1::RecordedThinking) -> Result<()> {
        let channel = channel(&mut self.mcap, topic::THINKING, "RecordedThinking")?;
        self.write(channel, thinking.tick * self.step_ns, thinking)
    }

    /// The parts of the world that stand still, and the robots' descriptions. From now on the file has data for other programs.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn world(&mut self, time_ns: u64, world: &v1::DescribeWorldResponse) -> Result<()> {
        let own = channel(&mut self.mcap, topic::WORLD, "DescribeWorldResponse")?;
        self.write(own, time_ns, world)?;
        let encoder = FoxgloveEncoder::new(world);
        let opening = encoder.opening(time_ns);
        self.shown = Some(Shown { encoder, channels: BTreeMap::new() });
        self.message(opening)
    }

    /// Writes the frame of an observer; nothing is written before the description of the [world](Self::world).
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn frame(&mut self, frame: &v1::WatchResponse) -> Result<()> {
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let messages = shown.encoder.frame(frame);
        self.message([FoxgloveMessage::of_frame(frame)].into_iter().chain(messages))
    }

    fn message(&mut self, messages: impl IntoIterator<Item = FoxgloveMessage>) -> Result<()> {
        let Some(Shown { channels, .. }) = &mut self.shown else { return Ok(()) };
        for message in messages {
            let channel_id = match channels.get(&message.topic) {
                Some(&channel) => channel,
                None => {
                    let MessageSchema { name, encoding, data } = message.schema;
                    let schema = self.mcap.add_schema(name, encoding, data)?;
                    let channel =
                        self.mcap.add_channel(schema, &message.topic, encoding, &BTreeMap::new())?;
                    channels.insert(Arc::clone(&message.topic), channel);
                    channel
                }
            };
            self.sequence = self.sequence.wrapping_add(1);
            let (sequence, log_time) = (self.sequence, message.time_ns);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            self.mcap.write_to_known_channel(&header, &message.data)?;
        }
        Ok(())
    }

    /// Ends the file with an index, for programs that search for single messages.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<W> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }

    fn write(&mut self, channel_id: u16, time_ns: u64, message: &impl Message) -> Result<()> {
        self.buffer.clear();
        message.encode(&mut self.buffer).expect("a vector has room");
        self.sequence = self.sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: time_ns, publish_time: time_ns };
        Ok(self.mcap.write_to_known_channel(&header, &self.buffer)?)
    }
}

fn channel<W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &str, message: &str) -> Result<u16> {
    let name = format!("{}.{message}", schema::PACKAGE);
    let schema = mcap.add_schema(&name, "protobuf", &schema::of(message))?;
    Ok(mcap.add_channel(schema, topic, "protobuf", &BTreeMap::new())?)
}

/// Chunks are no longer than that, in bytes before they are compressed.
const CHUNK: u64 = 4 << 20;

/// The header of a recording of this world that begins now.
pub fn header(world: &str, scenario: &Scenario, pace: Option<v1::Pace>) -> v1::RecordingHeader {
    let source = &scenario.source;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    v1::RecordingHeader {
        format: FORMAT,
        program_version: PROGRAM_VERSION.to_owned(),
        world: world.to_owned(),
        scenario_toml: source.toml.to_string(),
        overrides: source.overrides.clone(),
        seed: scenario.seed,
        step_ns: scenario.step_ns,
        pace,
        started_unix_ns: u64::try_from(now.as_nanos()).unwrap_or(u64::MAX),
        robots: scenario.robots.iter().map(|robot| robot.name.clone()).collect(),
    }
}

/// The checksum of an input.
pub fn checksum(after_ns: i64, data: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&after_ns.to_le_bytes());
    hasher.update(data);
    hasher.finalize() & 0xFFFF
}

impl Writer<RecordingFile> {
    /// Leaves the file as it is: something is missing in it from here on, and what is not in it yet stays away.
    pub fn abandon(self) {
        self.mcap.into_inner().close();
    }
}
