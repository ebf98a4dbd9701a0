//! `baudbot state`: what a server keeps is checked, and damaged worlds are recovered.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use baudbot_server::{Checked, RecoverError, Soundness, StateFolder};

use crate::args::{CheckStateArgs, RecoverArgs, StateCommand};
use crate::error::Refused;
use crate::state::refused_folder;
use crate::text;

pub(crate) fn state(command: &StateCommand) -> anyhow::Result<ExitCode> {
    match command {
        StateCommand::Check(args) => check(args),
        StateCommand::Recover(args) => recover(args),
    }
}

fn open(folder: &Path) -> anyhow::Result<StateFolder> {
    StateFolder::open_present(folder).map_err(|error| refused_folder("", error))
}

fn check(args: &CheckStateArgs) -> anyhow::Result<ExitCode> {
    let worlds = open(&args.folder)?.check().map_err(|error| refused_folder("", error))?;
    let mut out = String::new();
    if worlds.is_empty() {
        out += "no worlds\n";
    }
    for Checked { name, soundness } in &worlds {
        match soundness {
            Soundness::Sound { tick, time_s, note } => {
                let note = note.as_ref().map(|note| format!("; {note}")).unwrap_or_default();
                let _ = writeln!(out, "{name}: sound, at tick {tick}, {time_s} s{note}");
            }
            Soundness::Damaged { file, problem, recoverable } => {
                let _ = writeln!(out, "{name}: damaged: {} {problem}", file.display());
                let _ = match recoverable {
                    Some((tick, time_s)) => {
                        let folder = args.folder.display();
                        writeln!(
                            out,
                            "  `baudbot state recover {folder} {name}` recovers it at tick {tick}, {time_s} s"
                        )
                    }
                    None => writeln!(out, "  it has no sound state, and cannot be recovered"),
                };
            }
            Soundness::Unreadable { file, problem } => {
                let _ = writeln!(out, "{name}: {} {problem}", file.display());
            }
        }
    }
    text::print(&out)?;
    let is_sound = |world: &Checked| matches!(world.soundness, Soundness::Sound { .. });
    Ok(ExitCode::from(u8::from(!worlds.iter().all(is_sound))))
}

fn recover(args: &RecoverArgs) -> anyhow::Result<ExitCode> {
    let name = args.name.as_deref().unwrap_or(&args.world);
    // `wander.damaged-2` was `wander`.
    let name = if args.name.is_some() { name } else { name.split('.').next().unwrap_or(name) };
    let recovered = open(&args.folder)?.recover(&args.world, name).map_err(refused)?;
    let mut out = format!(
        "world {} can be continued at tick {}, {} s; {} is unchanged\n",
        recovered.name,
        recovered.tick,
        recovered.time_s,
        recovered.from.display()
    );
    for note in &recovered.notes {
        let _ = writeln!(out, "note: {note}");
    }
    text::print(&out)?;
    Ok(ExitCode::SUCCESS)
}

fn refused(error: RecoverError) -> anyhow::Error {
    match error {
        RecoverError::Absent { .. }
        | RecoverError::Sound(_)
        | RecoverError::Taken(_)
        | RecoverError::Name(_) => Refused::error(error.to_string()),
        RecoverError::Nothing { .. } | RecoverError::State(_) => error.into(),
    }
}
