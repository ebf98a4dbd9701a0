//! The world of a journal: its last state, and all that has happened since once more.

use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_scenario::Override;
use baudbot_sim::{Scenario, World};

use super::read::Entry;
use super::{At, Journal, JournalError, PortState, ScenarioText, Settings};
use crate::{change, replay};

/// A world as its journal ends with it.
#[derive(Debug)]
pub struct Restored {
    /// The world, within a tick if it was.
    pub world: World,
    /// The scenario with which it was made.
    pub made: Arc<Scenario>,
    /// The settings with which the world was run.
    pub settings: Settings,
    /// The writing ends of the robots' ports, as far as they are known.
    pub ports: Vec<PortState>,
    /// Ticks that were done once more.
    pub replayed: u64,
}

type Result<T> = std::result::Result<T, JournalError>;

impl Journal {
    /// The world, its settings, and the ports of its robots.
    ///
    /// # Errors
    /// If its scenario or its state cannot be used, or what has happened since does not lead where it led.
    pub fn restore(&self) -> Result<Restored> {
        self.restore_first(self.entries.len()).map_err(|(_, error)| error)
    }

    /// The world after so many entries; which entry cannot be gone on with, if there is one.
    pub(super) fn restore_first(&self, count: usize) -> std::result::Result<Restored, (usize, JournalError)> {
        let begin = |error| (0, error);
        let origin = scenario(self.header.origin.as_ref()).map_err(begin)?;
        let made = match &self.header.made {
            Some(made) => scenario(Some(made)).map_err(begin)?,
            None => Arc::clone(&origin),
        };
        let mut restored: Option<Restored> = None;
        let mut settings = Settings::default();
        for (place, entry) in self.entries[..count].iter().enumerate() {
            let here = |error| (place, error);
            match (entry, &mut restored) {
                (Entry::Settings(now), _) => settings = now.clone(),
                (Entry::State(state), _) => {
                    let (world, made) = (self.load(&origin, state).map_err(here)?, Arc::clone(&made));
                    let (settings, ports) = (Settings::default(), Vec::new());
                    restored = Some(Restored { world, made, settings, ports, replayed: 0 });
                }
                (entry, Some(restored)) => restored.go_on(entry, self).map_err(here)?,
                (_, None) => return Err(here(JournalError::Unfinished)),
            }
        }
        let restored = restored.ok_or((count, JournalError::Unfinished))?;
        Ok(Restored { settings, ..restored })
    }

    fn load(&self, origin: &Arc<Scenario>, state: &v1::RecordedState) -> Result<World> {
        let world = World::load(Arc::clone(origin), &state.state, state.state_hash);
        world.map_err(|source| {
            let program = self.header.program_version.clone();
            JournalError::State { tick: state.tick, program, source }
        })
    }

    fn differs(&self, tick: u64, what: impl Into<String>) -> JournalError {
        let (what, program) = (what.into(), self.header.program_version.clone());
        JournalError::Differs { tick, what, program }
    }
}

impl Restored {
    fn go_on(&mut self, entry: &Entry, journal: &Journal) -> Result<()> {
        match entry {
            Entry::Settings(_) | Entry::State(_) => Ok(()),
            Entry::Ports(ports) => {
                for port in &ports.ports {
                    self.ports.retain(|old| old.robot != port.robot);
                    self.ports.push(port.clone());
                }
                Ok(())
            }
            Entry::At(At { tick, begun, state_hash, on_disk: _ }) => {
                self.advance(*tick, journal)?;
                if *begun {
                    self.world.begin();
                }
                if state_hash.is_some_and(|hash| hash != self.world.hash()) {
                    return Err(journal.differs(*tick, "the state's fingerprint"));
                }
                Ok(())
            }
            Entry::Inputs(inputs) => self.enter(inputs, journal),
        }
    }

    /// Puts recorded inputs into the world again.
    fn enter(&mut self, inputs: &v1::RecordedInputs, journal: &Journal) -> Result<()> {
        self.advance(inputs.tick, journal)?;
        for change in inputs.changes.iter().filter_map(|recorded| recorded.change.clone()) {
            let changed = self.world.intervene(&change::intervention(change));
            changed.map_err(|error| {
                journal.differs(inputs.tick, format!("a manual change is not possible ({error})"))
            })?;
        }
        if !inputs.inputs.is_empty() {
            self.world.begin();
            replay::finish(&mut self.world, &inputs.inputs);
            self.replayed += 1;
        }
        Ok(())
    }

    /// Goes on to the beginning of a tick, with nothing that enters the world.
    fn advance(&mut self, tick: u64, journal: &Journal) -> Result<()> {
        let now = self.world.tick();
        if tick < now || tick - now > MOST_TICKS {
            return Err(journal.differs(now, format!("an entry is of tick {tick}, which cannot be")));
        }
        while self.world.tick() < tick {
            if self.world.ending().is_some() {
                return Err(journal.differs(self.world.tick(), "the run has ended"));
            }
            self.world.begin();
            self.world.finish(&[]);
            self.replayed += 1;
        }
        Ok(())
    }
}

fn scenario(text: Option<&ScenarioText>) -> Result<Arc<Scenario>> {
    let text = text.ok_or(JournalError::Unfinished)?;
    let overrides: std::result::Result<Vec<_>, _> =
        text.overrides.iter().map(|text| Override::parse(text)).collect();
    Ok(baudbot_scenario::parse_with(&text.toml, &overrides?)?.into())
}

/// More ticks in a row than any server does without writing a state.
const MOST_TICKS: u64 = 1_000_000;
