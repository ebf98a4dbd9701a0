//! Entries as they are written.

use baudbot_proto::v1;
use baudbot_sim::World;
use prost::Message;

use super::{At, JOURNAL_FORMAT, JournalHeader, MAGIC, Ports, ScenarioText, Settings, head_sum, kind};
use crate::{PROGRAM_VERSION, saved};

/// Entries in the bytes that go into the file, one write after the other: what is taken out stands before what is added then.
#[derive(Clone, Debug, Default)]
pub struct Entries {
    bytes: Vec<u8>,
    /// Bytes of the file before these.
    before: u64,
}

impl Entries {
    /// The beginning of the journal of a world: what it is, and its state. `made`: the scenario with which it was made.
    pub fn beginning(
        name: &str,
        world: &World,
        made: &baudbot_sim::Scenario,
        settings: &Settings,
        ports: &Ports,
    ) -> Self {
        let mut entries = Self { bytes: format!("{MAGIC}{JOURNAL_FORMAT}\n").into_bytes(), before: 0 };
        let [origin, made] = [world.origin(), made].map(|scenario| ScenarioText {
            toml: scenario.source.toml.to_string(),
            overrides: scenario.source.overrides.clone(),
        });
        let header = JournalHeader {
            program_version: PROGRAM_VERSION.to_owned(),
            world: name.to_owned(),
            made: (made != origin).then_some(made),
            origin: Some(origin),
        };
        entries.add(kind::HEADER, &header);
        entries.settings(settings);
        entries.state(world);
        entries.ports(ports);
        entries.at(At { tick: world.tick(), begun: world.is_begun(), ..At::default() });
        entries
    }

    /// The whole state.
    pub fn state(&mut self, world: &World) {
        self.add(kind::STATE, &saved::state(world));
    }

    /// Adds the settings of the world from now on.
    pub fn settings(&mut self, settings: &Settings) {
        self.add(kind::SETTINGS, settings);
    }

    /// Adds the inputs of a tick or, if there are only changes, of before it.
    pub fn inputs(&mut self, inputs: &v1::RecordedInputs) {
        self.add(kind::INPUTS, inputs);
    }

    /// The writing ends of ports.
    pub fn ports(&mut self, ports: &Ports) {
        if !ports.ports.is_empty() {
            self.add(kind::PORTS, ports);
        }
    }

    /// Adds the present tick, which ends a write.
    pub fn at(&mut self, at: At) {
        self.add(kind::AT, &at);
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The number of bytes.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// All was written: forgets it, and keeps the room for what follows.
    pub fn clear(&mut self) {
        self.before += self.bytes.len() as u64;
        self.bytes.clear();
    }

    /// Takes the bytes, to be written.
    pub fn take(&mut self) -> Vec<u8> {
        self.before += self.bytes.len() as u64;
        std::mem::take(&mut self.bytes)
    }

    fn add(&mut self, kind: u8, message: &impl Message) {
        let start = self.bytes.len();
        self.bytes.push(kind);
        let length = u32::try_from(message.encoded_len()).expect("no message of a world has 4 GiB");
        self.bytes.extend(length.to_le_bytes());
        let place = self.before + start as u64;
        self.bytes.extend(head_sum(Some(place), &self.bytes[start..]).to_le_bytes());
        let body = self.bytes.len();
        message.encode(&mut self.bytes).expect("a vector has room");
        self.bytes.extend(crc32fast::hash(&self.bytes[body..]).to_le_bytes());
    }
}
