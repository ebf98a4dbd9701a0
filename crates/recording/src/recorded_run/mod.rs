//! A recorded run: everything that a replay needs, read into memory.

mod stretch;

use std::fs::File;
use std::io::{BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_scenario::Override;
use baudbot_sim::{SavedError, Scenario, World};
use prost::Message;
use prost::encoding::{DecodeContext, decode_key, skip_field};

use crate::digest::{FIELDS, Mark};
use crate::error::RecordingError;
use crate::reader::{Condition, Item, Reader};
use crate::{FORMAT, topic};
pub use stretch::{Coverage, Stretch};

type Result<T> = std::result::Result<T, RecordingError>;

/// A recording. Inputs and states stay encoded, so that it takes no more memory than they do in the file.
#[derive(Debug)]
pub struct RecordedRun {
    header: v1::RecordingHeader,
    scenario: Arc<Scenario>,
    bytes: Vec<u8>,
    /// In the order of ticks.
    inputs: Vec<Kept>,
    states: Vec<Kept>,
    marks: Vec<(u32, Mark)>,
    events: Vec<v1::RecordedEvent>,
    thinking: Vec<v1::RobotThinking>,
    /// The stretches that can be run again, in the order of ticks; at least one.
    stretches: Vec<Stretch>,
    condition: Condition,
    /// While it is read: how often something was missing so far.
    part: u32,
    /// The numbers of inputs and states at the last mark.
    marked: (usize, usize),
}

/// A message that is kept as it came.
#[derive(Debug)]
struct Kept {
    tick: u64,
    /// The number of gaps before it.
    part: u32,
    place: Range<usize>,
}

impl RecordedRun {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is no recording, or too little is left of it. Of one that is cut off or damaged behind its beginning all
    /// is read that can be done again, and [`problem`](Self::problem) has the fault.
    pub fn open(path: &Path) -> Result<Self> {
        Self::read(BufReader::with_capacity(1 << 20, File::open(path)?))
    }

    /// Reads what a file has in it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn read(file: impl Read) -> Result<Self> {
        Self::read_at_most(file, usize::MAX)
    }

    /// The same as [`read`](Self::read), for bytes from an untrusted source: they unpack to no more bytes than this.
    ///
    /// # Errors
    /// Also if it is more.
    pub fn read_at_most(file: impl Read, limit: usize) -> Result<Self> {
        let mut reader = Reader::new(file, limit);
        let Ok(header) = header(&mut reader)? else {
            let problem = reader.condition().problem.unwrap_or_default();
            return Err(RecordingError::Headless(problem));
        };
        let overrides: std::result::Result<Vec<_>, _> =
            header.overrides.iter().map(|text| Override::parse(text)).collect();
        let scenario = baudbot_scenario::parse_with(&header.scenario_toml, &overrides?)?;
        if header.step_ns != scenario.step_ns {
            let (found, step_ns) = (header.step_ns, scenario.step_ns);
            return Err(RecordingError::Step { found, step_ns });
        }
        let mut recorded = Self {
            header,
            scenario: scenario.into(),
            bytes: Vec::new(),
            inputs: Vec::new(),
            states: Vec::new(),
            marks: Vec::new(),
            events: Vec::new(),
            thinking: Vec::new(),
            stretches: Vec::new(),
            condition: Condition { is_whole: true, problem: None, times_ns: None },
            part: 0,
            marked: (0, 0),
        };
        while let Some(item) = reader.next(|topic| WANTED.contains(&topic))? {
            match item {
                Item::Message(message) => recorded.take(&message.topic, &message.data)?,
                Item::Damage => recorded.part += 1,
            }
        }
        recorded.condition = reader.condition();
        recorded.put_in_order()
    }

    /// The bytes that it takes in memory, without the scenario. Texts of events are counted as if they were of a usual length.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        const TEXT: usize = 64;
        let kept = (self.inputs.capacity() + self.states.capacity()) * size_of::<Kept>();
        let marks: usize = self.marks.iter().map(|(_, mark)| size_of_val(mark) + mark.heap_bytes()).sum();
        let events = self.events.capacity() * (size_of::<v1::RecordedEvent>() + TEXT);
        size_of::<Self>() + self.bytes.capacity() + kept + marks + events + self.header.scenario_toml.len()
    }

    fn take(&mut self, topic: &str, data: &[u8]) -> Result<()> {
        match topic {
            topic::MARKS
                // A text of no letters is two bytes in the file, and more in memory.
                if occurrences(data, MARKS_FIELDS).is_none_or(|fields| fields <= 4 * FIELDS.len()) => {
                    self.mark(decode::<v1::RecordedMark>(topic, data)?.into());
                }
            topic::EVENTS => self.events.push(decode(topic, data)?),
            topic::THINKING => {
                at_most(topic, data, THINKING_ROBOTS, self.scenario.robots.len())?;
                self.thinking = decode::<v1::RecordedThinking>(topic, data)?.robots;
            }
            topic::INPUTS => {
                let robots = self.scenario.robots.len();
                at_most(topic, data, INPUTS_CHANGES, MOST_BY_HAND)?;
                at_most(topic, data, INPUTS_INPUTS, MOST_BY_HAND.max(MOST_A_ROBOT * robots))?;
                let kept = self.keep(topic, data)?;
                self.inputs.push(kept);
            }
            topic::STATE => {
                let kept = self.keep(topic, data)?;
                self.states.push(kept);
            }
            _ => {}
        }
        Ok(())
    }

    /// The ticks of a mark follow on those of the one before it, or something is missing between them.
    fn mark(&mut self, mark: Mark) {
        if let Some((part, before)) = self.marks.last()
            && *part == self.part
            && mark.first_tick > before.tick.saturating_add(1)
        {
            self.part += 1;
            let (inputs, states) = self.marked;
            let since = self.inputs[inputs..].iter_mut().chain(&mut self.states[states..]);
            since.for_each(|kept| kept.part = self.part);
        }
        self.marks.push((self.part, mark));
        self.marked = (self.inputs.len(), self.states.len());
    }

    fn keep(&mut self, topic: &str, data: &[u8]) -> Result<Kept> {
        let OfTick { tick } = decode(topic, data)?;
        let start = self.bytes.len();
        self.bytes.extend(data);
        Ok(Kept { tick, part: self.part, place: start..self.bytes.len() })
    }

    /// The recording's header.
    pub fn header(&self) -> &v1::RecordingHeader {
        &self.header
    }

    /// The scenario that was recorded.
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The first tick of which something is known.
    pub fn first_tick(&self) -> u64 {
        self.stretches[0].first_tick
    }

    /// The last tick of which all is known that entered the world before it.
    pub fn last_tick(&self) -> u64 {
        self.stretches[self.stretches.len() - 1].last_tick
    }

    /// The times that the brains of robots took to answer, of those for which they were measured.
    pub fn thinking(&self) -> &[v1::RobotThinking] {
        &self.thinking
    }

    /// The events, in the order of ticks.
    pub fn events(&self) -> &[v1::RecordedEvent] {
        &self.events
    }

    /// The reason why there is less in the file than was recorded, if there is.
    pub fn problem(&self) -> Option<&str> {
        self.condition.problem.as_deref().filter(|_| !self.is_whole())
    }

    /// The problem of a file from which the run can be made again all the same, if there is one.
    pub fn scratch(&self) -> Option<&str> {
        self.condition.problem.as_deref().filter(|_| self.is_whole())
    }

    /// Whether all is there that was recorded.
    pub fn is_whole(&self) -> bool {
        self.condition.is_whole
    }

    /// Ticks in which something entered the world.
    pub fn inputs(&self) -> usize {
        self.inputs.len()
    }

    /// The fingerprint of the state at the last tick.
    pub fn last_hash(&self) -> u64 {
        self.marks[self.marks.len() - 1].1.state_hash
    }

    /// The inputs of the world in a tick, from the first of these messages on.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn inputs_at(&self, tick: u64) -> Result<Vec<v1::RecordedInputs>> {
        let from = self.inputs.partition_point(|kept| kept.tick < tick);
        let those = self.inputs[from..].iter().take_while(|kept| kept.tick == tick);
        those.map(|kept| decode(topic::INPUTS, &self.bytes[kept.place.clone()])).collect()
    }

    /// The mark that has the digests of this tick.
    pub(crate) fn mark_of(&self, tick: u64) -> Option<&Mark> {
        let place = self.marks.partition_point(|(_, mark)| mark.tick < tick);
        self.marks.get(place).map(|(_, mark)| mark)
    }

    /// The tick of the last state at this tick or before it.
    pub(crate) fn nearest_state(&self, tick: u64) -> u64 {
        let until = self.states.partition_point(|kept| kept.tick <= tick);
        self.states[until.saturating_sub(1)].tick
    }

    /// The last state at this tick or before it in its stretch; of those but the first, one that can be read.
    pub(crate) fn state_before(&self, tick: u64) -> Result<World> {
        let stretch = self.stretch_of(tick);
        let first = self.states.partition_point(|kept| kept.tick < stretch.first_tick);
        let until = self.states.partition_point(|kept| kept.tick <= tick);
        for kept in self.states.get(first + 1..until).unwrap_or_default().iter().rev() {
            if let Ok(world) = self.state(kept)? {
                return Ok(world);
            }
        }
        self.state_at_start(first)
    }

    /// The world as the recording begins.
    ///
    /// # Errors
    /// If its state cannot be used.
    pub fn first_state(&self) -> Result<World> {
        self.state_at_start(0)
    }

    fn state_at_start(&self, place: usize) -> Result<World> {
        let kept = &self.states[place];
        match self.state(kept)? {
            Ok(world) => Ok(world),
            // A run from its start needs no state: the replay will find what has changed since.
            Err(_) if kept.tick == 0 && self.header.program_version != crate::PROGRAM_VERSION => {
                Ok(World::new(Arc::clone(&self.scenario)))
            }
            Err(source) => {
                let program = self.header.program_version.clone();
                Err(RecordingError::State { tick: kept.tick, program, source })
            }
        }
    }

    fn state(&self, kept: &Kept) -> Result<std::result::Result<World, SavedError>> {
        let state: v1::RecordedState = decode(topic::STATE, &self.bytes[kept.place.clone()])?;
        let world = World::load(Arc::clone(&self.scenario), &state.state, state.state_hash);
        Ok(world.and_then(|world| {
            let is_it = world.tick() == state.tick;
            if is_it { Ok(world) } else { Err(SavedError::Other("ticks")) }
        }))
    }
}

const WANTED: [&str; 5] = [topic::STATE, topic::INPUTS, topic::MARKS, topic::EVENTS, topic::THINKING];

/// The number of `robots` in a `RecordedThinking`.
const THINKING_ROBOTS: u32 = 2;

/// The number of `fields` in a `RecordedMark`.
const MARKS_FIELDS: u32 = 4;

/// The numbers of `overrides` and `robots` in a `RecordingHeader`, ...
const HEADERS_OVERRIDES: u32 = 5;
const HEADERS_ROBOTS: u32 = 10;

/// ... and those of `changes` and `inputs` in `RecordedInputs`.
const INPUTS_CHANGES: u32 = 2;
const INPUTS_INPUTS: u32 = 3;

/// Overrides and robots of a header: an empty one is two bytes in the file, and more in memory.
const MOST_TEXTS: usize = 100_000;

/// Changes by hand in a tick, and inputs where there are few robots.
const MOST_BY_HAND: usize = 10_000;

/// Inputs of a robot in a tick: the server takes 64 Steps of a brain. With more, a small file could ask for much memory.
const MOST_A_ROBOT: usize = 256;

/// The numbers of an input or a state that have to be known to keep it.
#[derive(Clone, Copy, PartialEq, Message)]
struct OfTick {
    #[prost(uint64, tag = "1")]
    tick: u64,
}

/// The header that a recording begins with, unless that is damaged.
fn header(reader: &mut Reader<impl Read>) -> Result<std::result::Result<v1::RecordingHeader, ()>> {
    let first = match reader.next(|_| true)?.ok_or(RecordingError::Empty)? {
        Item::Damage => {
            while reader.next(|_| false)?.is_some() {}
            return Ok(Err(()));
        }
        Item::Message(first) => first,
    };
    if &*first.topic != topic::HEADER {
        return Err(RecordingError::Foreign);
    }
    for field in [HEADERS_OVERRIDES, HEADERS_ROBOTS] {
        at_most(topic::HEADER, &first.data, field, MOST_TEXTS)?;
    }
    let header: v1::RecordingHeader = decode(topic::HEADER, &first.data)?;
    if header.format != FORMAT {
        return Err(RecordingError::Newer { found: header.format, program: header.program_version });
    }
    Ok(Ok(header))
}

fn decode<M: Message + Default>(topic: &str, data: &[u8]) -> Result<M> {
    M::decode(data).map_err(|source| RecordingError::Message { topic: topic.to_owned(), source })
}

/// Refuses a message with more entries in a field.
fn at_most(topic: &str, data: &[u8], field: u32, limit: usize) -> Result<()> {
    // The error of one that cannot be read comes when it is decoded.
    match occurrences(data, field) {
        Some(found) if found > limit => {
            Err(RecordingError::Crowded { topic: topic.to_owned(), field, found, limit })
        }
        Some(_) | None => Ok(()),
    }
}

/// The number of times that a message has the field of this number; `None` if it cannot be read.
fn occurrences(mut data: &[u8], wanted: u32) -> Option<usize> {
    let mut n = 0;
    while !data.is_empty() {
        let (field, wire) = decode_key(&mut data).ok()?;
        n += usize::from(field == wanted);
        skip_field(wire, field, &mut data, DecodeContext::default()).ok()?;
    }
    Some(n)
}
