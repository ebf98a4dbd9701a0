//! A log from a file, from stdin, or from a recording, which is made a table of first.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use baudbot_fit::log::{self, Log, Options};
use baudbot_import::opened;
use indicatif::{ProgressBar, ProgressStyle};

use super::subject::Subject;
use crate::args::FitArgs;
use crate::csv::Table;
use crate::error::Refused;
use crate::output_files;
use crate::replay::{open, recorded_run, refused};

pub(super) fn read(args: &FitArgs, path: &Path, subject: &Subject) -> anyhow::Result<Log> {
    let options = Options {
        robot: args.robot.clone(),
        renamed: args.columns.iter().map(|pair| renamed(pair)).collect::<anyhow::Result<_>>()?,
        readings: baudbot_fit::readings(subject.robot().model),
    };
    let name = path.display().to_string();
    let cannot_read = |error: std::io::Error| Refused::error(format!("{name}: cannot be read: {error}"));
    if path == Path::new(output_files::STDOUT) {
        return parsed("stdin", BufReader::new(std::io::stdin()), &options, &ProgressBar::hidden());
    }
    let bytes = path.metadata().map_or(0, |metadata| metadata.len());
    let mut input = BufReader::new(opened::any(path).map_err(cannot_read)?);
    if input.fill_buf().map_err(cannot_read)?.starts_with(MCAP) {
        let table = table(path)?;
        let bytes = table.metadata().map_or(0, |metadata| metadata.len());
        return parsed(&name, BufReader::new(table), &options, &progress(bytes, args.quiet));
    }
    parsed(&name, input, &options, &progress(bytes, args.quiet))
}

fn parsed(
    name: &str,
    input: BufReader<impl Read>,
    options: &Options,
    bar: &ProgressBar,
) -> anyhow::Result<Log> {
    let read = log::read(name, input, options, &mut |bytes| bar.set_position(bytes));
    bar.finish_and_clear();
    read.map_err(|error| Refused::error(error.to_string()))
}

/// Ours and that of the file, of `OURS=THEIRS`.
fn renamed(pair: &str) -> anyhow::Result<(String, String)> {
    let parts = pair.split_once('=').map(|(ours, theirs)| (ours.trim().to_owned(), theirs.trim().to_owned()));
    parts.filter(|(ours, theirs)| !ours.is_empty() && !theirs.is_empty()).ok_or_else(|| {
        Refused::error(format!("--columns: must be NAME=COLUMN, such as time_s=stamp, is `{pair}`"))
    })
}

/// The table that `baudbot export --csv` writes of a recording, in a file without a name.
fn table(path: &Path) -> anyhow::Result<File> {
    let recorded = Arc::new(recorded_run(path).map_err(|error| refused(path, &error))?);
    let (mut replay, mut world) = open(path)?;
    let mut file = tempfile::tempfile().context("cannot make a temporary file")?;
    let out = Box::new(file.try_clone().context("cannot write a temporary file")?);
    let (mut table, mut outcome) = Table::new(out, &recorded.scenario().robots);
    loop {
        table.write(&world);
        if !replay.step(&mut world).with_context(|| format!("{}: tick {}", path.display(), world.tick()))? {
            break;
        }
    }
    drop(table);
    if let Ok(Err(error)) = outcome.try_recv() {
        return Err(error).context("cannot write a temporary file");
    }
    file.seek(SeekFrom::Start(0)).context("cannot read a temporary file")?;
    Ok(file)
}

/// A bar for large files, for people who look.
fn progress(bytes: u64, quiet: bool) -> ProgressBar {
    if quiet || bytes < LARGE_BYTES || !console::user_attended_stderr() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {bytes}/{total_bytes}, {eta} to go");
    ProgressBar::new(bytes).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The first bytes of a recording.
const MCAP: &[u8] = b"\x89MCAP0";

const LARGE_BYTES: u64 = 16 << 20;
