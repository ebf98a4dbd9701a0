//! What was read of a recording: all that makes the run again, in memory.

use std::fs::File;
use std::io::{BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::{Override, SavedError, Scenario, World};
use prost::Message;

use crate::error::RecordingError;
use crate::reader::Reader;
use crate::{FORMAT, topic};

type Result<T> = std::result::Result<T, RecordingError>;

/// A recording. Inputs and states stay encoded, so that it takes no more memory than they do in the file.
#[derive(Debug)]
pub struct Tape {
    header: v1::RecordingHeader,
    scenario: Arc<Scenario>,
    bytes: Vec<u8>,
    /// In the order of ticks, each with its tick.
    inputs: Vec<(u64, Range<usize>)>,
    states: Vec<(u64, Range<usize>)>,
    marks: Vec<v1::RecordedMark>,
    events: Vec<v1::RecordedEvent>,
    problem: Option<String>,
}

impl Tape {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is no recording, or too little is left of it. One that is cut off or damaged behind its beginning is read as
    /// far as it goes, and [`problem`](Self::problem) says why.
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

    /// As [`read`](Self::read), of bytes from somebody who may mean harm: they make no more than this of memory.
    ///
    /// # Errors
    /// Also if it is more.
    pub fn read_at_most(file: impl Read, limit: usize) -> Result<Self> {
        let mut reader = Reader::new(file, limit);
        let header = header(&mut reader)?;
        let overrides: std::result::Result<Vec<_>, _> =
            header.overrides.iter().map(|text| Override::parse(text)).collect();
        let scenario = Scenario::parse_with(&header.scenario_toml, &overrides?)?;
        let mut tape = Self {
            header,
            scenario: scenario.into(),
            bytes: Vec::new(),
            inputs: Vec::new(),
            states: Vec::new(),
            marks: Vec::new(),
            events: Vec::new(),
            problem: None,
        };
        while let Some(message) = reader.next(|topic| WANTED.contains(&topic))? {
            tape.take(&message.topic, &message.data)?;
            if tape.bytes.len() > limit {
                return Err(RecordingError::TooLong { limit });
            }
        }
        tape.problem = reader.problem();
        tape.put_in_order()
    }

    fn take(&mut self, topic: &str, data: &[u8]) -> Result<()> {
        match topic {
            topic::MARKS => self.marks.push(decode(topic, data)?),
            topic::EVENTS => self.events.push(decode(topic, data)?),
            topic::INPUTS => {
                let tick = decode::<v1::RecordedInputs>(topic, data)?.tick;
                let place = self.keep(data);
                self.inputs.push((tick, place));
            }
            topic::STATE => {
                let tick = decode::<v1::RecordedState>(topic, data)?.tick;
                let place = self.keep(data);
                self.states.push((tick, place));
            }
            _ => {}
        }
        Ok(())
    }

    fn keep(&mut self, data: &[u8]) -> Range<usize> {
        let start = self.bytes.len();
        self.bytes.extend(data);
        start..self.bytes.len()
    }

    /// What is behind the last mark may not be all that there was.
    fn put_in_order(mut self) -> Result<Self> {
        let (Some(first), Some(last)) = (self.states.first(), self.marks.last()) else {
            return Err(RecordingError::Empty);
        };
        let ticks = first.0..=last.tick;
        // Beyond that there is no time.
        if ticks.is_empty() || last.tick > u64::MAX / self.scenario.step_ns().max(1) {
            return Err(RecordingError::Empty);
        }
        self.inputs.retain(|(tick, _)| ticks.contains(tick));
        self.events.retain(|event| ticks.contains(&event.tick));
        self.states.retain(|(tick, _)| ticks.contains(tick));
        self.inputs.sort_by_key(|(tick, _)| *tick);
        self.states.sort_by_key(|(tick, _)| *tick);
        self.marks.sort_by_key(|mark| mark.tick);
        // Of two marks that begin at one tick the later knows more: a change by hand may have come between.
        self.marks.reverse();
        self.marks.dedup_by(|earlier, later| later.first_tick <= earlier.first_tick);
        self.marks.reverse();
        Ok(self)
    }

    /// What it begins with.
    pub fn header(&self) -> &v1::RecordingHeader {
        &self.header
    }

    /// The scenario that was recorded.
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The first tick of which something is known.
    pub fn first_tick(&self) -> u64 {
        self.states[0].0
    }

    /// The last tick of which all is known that entered the world before it.
    pub fn last_tick(&self) -> u64 {
        self.marks[self.marks.len() - 1].tick
    }

    /// What happened, in the order of ticks.
    pub fn events(&self) -> &[v1::RecordedEvent] {
        &self.events
    }

    /// Why the file ends too early, if it does.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Ticks in which something entered the world.
    pub fn inputs(&self) -> usize {
        self.inputs.len()
    }

    /// The fingerprint of the state at the last tick.
    pub fn last_hash(&self) -> u64 {
        self.marks[self.marks.len() - 1].state_hash
    }

    /// What entered the world in a tick, from the first of these messages on.
    pub(crate) fn inputs_at(&self, tick: u64) -> Result<Vec<v1::RecordedInputs>> {
        let from = self.inputs.partition_point(|(at, _)| *at < tick);
        let those = self.inputs[from..].iter().take_while(|(at, _)| *at == tick);
        those.map(|(_, place)| decode(topic::INPUTS, &self.bytes[place.clone()])).collect()
    }

    /// The mark that has the digests of this tick.
    pub(crate) fn mark_of(&self, tick: u64) -> Option<&v1::RecordedMark> {
        self.marks.get(self.marks.partition_point(|mark| mark.tick < tick))
    }

    /// The tick of the last state at this tick or before it.
    pub(crate) fn nearest_state(&self, tick: u64) -> u64 {
        let until = self.states.partition_point(|(at, _)| *at <= tick);
        self.states[until.saturating_sub(1)].0
    }

    /// The last state at this tick or before it; of those but the first, one that can be read.
    pub(crate) fn state_before(&self, tick: u64) -> Result<World> {
        let until = self.states.partition_point(|(at, _)| *at <= tick).max(1);
        for (_, place) in self.states[1..until].iter().rev() {
            if let Ok(world) = self.state(place)? {
                return Ok(world);
            }
        }
        self.first_state()
    }

    /// The world as the recording begins.
    ///
    /// # Errors
    /// If its state cannot be used.
    pub fn first_state(&self) -> Result<World> {
        let (tick, place) = &self.states[0];
        match self.state(place)? {
            Ok(world) => Ok(world),
            // A run from its start needs no state: the replay will find what has changed since.
            Err(_) if *tick == 0 && self.header.program_version != crate::PROGRAM_VERSION => {
                Ok(World::new(Arc::clone(&self.scenario)))
            }
            Err(source) => {
                let program = self.header.program_version.clone();
                Err(RecordingError::State { tick: *tick, program, source })
            }
        }
    }

    fn state(&self, place: &Range<usize>) -> Result<std::result::Result<World, SavedError>> {
        let state: v1::RecordedState = decode(topic::STATE, &self.bytes[place.clone()])?;
        let world = World::load(Arc::clone(&self.scenario), &state.state, state.state_hash);
        Ok(world.and_then(|world| {
            let is_it = world.tick() == state.tick;
            if is_it { Ok(world) } else { Err(SavedError::Other("ticks")) }
        }))
    }
}

const WANTED: [&str; 4] = [topic::STATE, topic::INPUTS, topic::MARKS, topic::EVENTS];

fn header(reader: &mut Reader<impl Read>) -> Result<v1::RecordingHeader> {
    let first = reader.next(|_| true)?.ok_or(RecordingError::Empty)?;
    if &*first.topic != topic::HEADER {
        return Err(RecordingError::Foreign);
    }
    let header: v1::RecordingHeader = decode(topic::HEADER, &first.data)?;
    if header.format != FORMAT {
        return Err(RecordingError::Newer { found: header.format, program: header.program_version });
    }
    Ok(header)
}

fn decode<M: Message + Default>(topic: &str, data: &[u8]) -> Result<M> {
    M::decode(data).map_err(|source| RecordingError::Message { topic: topic.to_owned(), source })
}
