//! `baudbot serve`: worlds for brains in other processes.

use std::fs::DirBuilder;
use std::io::ErrorKind;
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use baudbot_server::WorldConfig;

use crate::announcement::Announcement;
use crate::args::{PaceName, ServeArgs};
use crate::assignment;
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::run::overrides;
use crate::scenarios::{self, Source};
use crate::serving::{Serving, Viewing};
use crate::state::{self, Kept};
use crate::text::tell;
use crate::{record, replay};

pub(crate) async fn serve(args: &ServeArgs) -> anyhow::Result<()> {
    check_outputs(args)?;
    let mut serving = Serving::new(&args.listen)?;
    serving.stop_within(Duration::from_secs(args.stop_within.into()));
    serving.announce(Announcement { port_file: args.port_file.clone(), json: args.json })?;
    let kept = state::go_on(args, &mut serving)?;
    if let Some(folder) = &args.recordings {
        make_folder(folder)?;
        serving.keep_recordings(folder);
    }
    if let Some(address) = &args.trainer {
        serving.take_trainers(address.clone());
    }
    match &args.resume {
        Some(file) => resume(args, file, &kept, &mut serving)?,
        None => worlds(args, &kept, &mut serving)?,
    }
    serving.open_ports(&args.ports)?;
    serving.until_stopped(Viewing::IfOpen).await
}

/// Refuses an audit log or a port file that would be written over what is read.
fn check_outputs(args: &ServeArgs) -> anyhow::Result<()> {
    let inputs = Inputs::default().firmware(&args.changes.firmware);
    let inputs = args.scenarios.iter().fold(inputs, |all, name| all.scenario(name));
    let inputs = args.resume.iter().fold(inputs, |all, recording| all.file("recording", recording));
    let audit = args.listen.access.audit.iter().map(|path| ("--audit", path.as_path()));
    inputs.check(audit.chain(args.port_file.iter().map(|path| ("--port-file", path.as_path()))))
}

/// The worlds of scenarios.
fn worlds(args: &ServeArgs, kept: &Kept, serving: &mut Serving<'_>) -> anyhow::Result<()> {
    let pace = args.watchdog.apply(args.pace.unwrap_or(PaceName::Timed(1.0)).pace())?;
    let overrides = overrides(&args.changes)?;
    let default = [scenarios::DEFAULT.to_owned()];
    let names = if args.scenarios.is_empty() && kept.is_empty() { &default[..] } else { &args.scenarios };
    if names.len() > 1 && args.record.record.is_some() {
        return Err(Refused::error(
            "--record: takes a single world, and there are several; use --recordings FOLDER",
        ));
    }
    for name in names {
        let source = Source::find(name)?;
        let scenario = source.parse(&overrides)?;
        let world = source.world_name(&scenario);
        if kept.has(&world) {
            tell!(
                "note: world {world} continues from its stored state; scenario {name} is not started again"
            );
            continue;
        }
        scenarios::warn(&source, &scenario);
        let scenario = Arc::new(scenario);
        let config = WorldConfig::new(world.clone(), Arc::clone(&scenario)).pace(pace).paused(args.paused);
        serving.add(&world, &scenario, record::add(config, &args.record));
        if let [brain] = *source.shown_brains()
            && assignment::is_for_all(brain)
            && brain != assignment::NONE
        {
            serving.suggest(brain);
        }
    }
    Ok(())
}

/// The world of a recording, from its end on.
fn resume(args: &ServeArgs, file: &Path, kept: &Kept, serving: &mut Serving<'_>) -> anyhow::Result<()> {
    if args.record.record.as_deref().is_some_and(|record| crate::output_files::is_same_file(record, file)) {
        let file = file.display();
        return Err(Refused::error(format!(
            "--record {file}: is the recording that is resumed; record into another file"
        )));
    }
    let (mut replay, mut world) = replay::open(file)?;
    let recorded = Arc::clone(replay.recorded());
    let pace = replay::pace(args.pace, &args.watchdog, &recorded)?;
    replay.seek(&mut world, recorded.last_tick()).context("the recording cannot be replayed")?;
    if let Some(difference) = replay.difference() {
        return Err(anyhow::anyhow!("{}: does not replay as it was recorded: {difference}", file.display()));
    }
    if let Some(problem) = recorded.problem() {
        tell!(
            "note: {}: {problem}; the world continues from the end of the part that is left",
            file.display()
        );
    }
    let (name, scenario) = (recorded.header().world.clone(), Arc::clone(world.scenario()));
    if kept.has(&name) {
        let file = file.display();
        return Err(Refused::error(format!(
            "--resume {file}: a world {name} is in the folder of --state already; start the server without --resume to continue it"
        )));
    }
    tell!("world {name} continues at tick {}, {} s", world.tick(), world.time().as_seconds());
    let config = WorldConfig::from_state(name.clone(), world).pace(pace).paused(args.paused);
    serving.add(&name, &scenario, record::add(config, &args.record));
    Ok(())
}

/// Makes the folder, if it is not there. Recordings hold the truth, so it is its owner's alone.
fn make_folder(folder: &Path) -> anyhow::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let refused = |why: &str| Refused::error(format!("--recordings {}: {why}", folder.display()));
    DirBuilder::new().mode(0o700).create(folder).map_err(|error| {
        if error.kind() == ErrorKind::AlreadyExists {
            refused("is a file, not a folder; choose another")
        } else if error.kind() == ErrorKind::NotFound {
            refused("its parent folder does not exist; create it with mkdir -p")
        } else {
            refused(&format!("cannot be created: {error}"))
        }
    })
}
