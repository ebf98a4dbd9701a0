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
        tell_of(&found);
        if let Found::World(world) = found {
            let (name, scenario) = (world.name.clone(), Arc::clone(&world.scenario));
            let config = WorldConfig::kept(*world);
            // One that was paused stays so in any case.
            let config = if args.paused { config.paused(true) } else { config };
            serving.add(&name, &scenario, config);
            kept.0.push(name);
        }
    }
    if args.recordings.is_none() {
        serving.keep_recordings(&folder.recordings());
    }
    serving.keep_state(folder);
    Ok(kept)
}

fn tell_of(found: &Found) {
    match found {
        Found::World(world) => {
            let name = &world.name;
            tell!("world {name} continues at tick {}, {} s", world.tick, world.time_s);
            if let Some(note) = &world.note {
                tell!("note: world {name}: {note}");
            }
        }
        Found::SetAside { name, file, problem, to } => {
            let (file, to) = (file.display(), to.display());
            tell!(
                "warning: world {name} does not continue: {file} {problem}; its folder is set aside as {to}"
            );
            tell!(
                "note: `baudbot state recover FOLDER {name}`, while no server runs, recovers its intact part"
            );
        }
        Found::Unreadable { name, file, problem } => {
            let file = file.display();
            tell!(
                "warning: world {name} does not continue: {file} {problem}; it is left unchanged, and a new world {name} is not stored: give \
                 this user read and write access to its folder, and start the server again"
            );
        }
        Found::Ignored { path, problem } => {
            let path = path.display();
            tell!(
                "warning: {path} {problem} and is ignored; move it to a place outside the folder of --state"
            );
        }
    }
}

fn refused(error: StateError) -> anyhow::Error {
    refused_folder("--state ", error)
}

/// The reason why a folder cannot be used, after the name of the option that it was given by.
pub(crate) fn refused_folder(option: &str, error: StateError) -> anyhow::Error {
    match error {
        StateError::InUse(_) | StateError::Absent(_) | StateError::Foreign(_) | StateError::Layout { .. } => {
            Refused::error(format!("{option}{error}"))
        }
        StateError::Io { .. } if option.is_empty() => error.into(),
        StateError::Io { .. } => anyhow::Error::from(error).context("--state"),
    }
}
