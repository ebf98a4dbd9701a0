//! `--state`: worlds that a server has left go on.

use std::sync::Arc;

use baudbot_server::{Found, StateError, StateFolder, WorldConfig};

use crate::args::ServeArgs;
use crate::error::Refused;
use crate::serving::Serving;
use crate::text::tell;

/// The names of the worlds that go on.
#[derive(Default)]
pub(crate) struct Kept(Vec<String>);

impl Kept {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn has(&self, world: &str) -> bool {
        self.0.iter().any(|name| name == world)
    }
}

/// Adds the worlds that are in the folder of `--state`, where this server keeps its worlds from now on.
pub(crate) fn go_on(args: &ServeArgs, serving: &mut Serving<'_>) -> anyhow::Result<Kept> {
    let Some(path) = &args.state else { return Ok(Kept::default()) };
    let folder = StateFolder::open(path).map_err(refused)?;
    let mut kept = Kept::default();
    for found in folder.worlds().map_err(refused)? {
        match found {
            Found::World(world) => {
                let (name, scenario) = (world.name.clone(), Arc::clone(&world.scenario));
                tell!("world {name} continues at tick {}, {} s", world.tick, world.time_s);
                if let Some(note) = &world.note {
                    tell!("note: world {name}: {note}");
                }
                serving.add(&name, &scenario, WorldConfig::kept(*world));
                kept.0.push(name);
            }
            Found::SetAside { name, file, problem, to } => {
                let (file, to) = (file.display(), to.display());
                tell!(
                    "warning: world {name} does not continue: {file} {problem}; its folder is set aside as {to}"
                );
            }
        }
    }
    if args.recordings.is_none() {
        serving.keep_recordings(&folder.recordings());
    }
    serving.keep_state(folder);
    Ok(kept)
}

fn refused(error: StateError) -> anyhow::Error {
    match error {
        StateError::InUse(_) | StateError::Foreign(_) | StateError::Layout { .. } => {
            Refused::error(format!("--state {error}"))
        }
        StateError::Io { .. } => anyhow::Error::from(error).context("--state"),
    }
}
