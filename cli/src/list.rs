//! `baudbot list` and `baudbot init`: what a program has in it, wherever it is installed.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_import::embedded;
use baudbot_scenario::presets::{Preset, presets};
use serde::Serialize;

use crate::args::{InitArgs, ListArgs};
use crate::error::Refused;
use crate::output_files::STDOUT;
use crate::scenarios;
use crate::text::{self, pairs, print, print_json};

/// A section of the list: its title, what to do with its entries, and these.
type Section = (&'static str, &'static str, Vec<Entry>);

/// An item that can be named.
#[derive(Serialize)]
struct Entry {
    name: &'static str,
    summary: String,
    /// The brains that the comment of a scenario's file shows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    brains: Vec<&'static str>,
}

impl Entry {
    fn new(name: &'static str, summary: impl Into<String>) -> Self {
        Self { name, summary: summary.into(), brains: Vec::new() }
    }

    fn line(&self) -> String {
        let brains: Vec<_> = self.brains.iter().map(|brain| format!("--brain {brain}")).collect();
        if brains.is_empty() {
            self.summary.clone()
        } else {
            format!("{} ({})", self.summary, brains.join(" "))
        }
    }
}

fn sections() -> [Section; 5] {
    let told = |(name, text): (&'static str, &str)| Entry::new(name, embedded::summary(text));
    let scenario = |(name, text)| Entry { brains: embedded::shown_brains(text), ..told((name, text)) };
    let preset = |preset: &'static Preset| Entry::new(preset.name, preset.description);
    let brain = |entry: catalogue::Entry| Entry::new(entry.name, entry.summary);
    [
        ("scenarios", "baudbot run NAME", embedded::scenarios().map(scenario).collect()),
        (
            "experiments",
            "baudbot sweep NAME, those that begin with `tune-` or `worst-` baudbot tune NAME or worst NAME",
            embedded::experiments().map(told).collect(),
        ),
        ("exercises", "baudbot grade NAME", embedded::exercises().map(told).collect()),
        ("brains", "--brain NAME", catalogue::catalogue().into_iter().map(brain).collect()),
        ("presets", "preset = \"NAME\" in a scenario", presets().map(preset).collect()),
    ]
}

pub(crate) fn list(args: &ListArgs) -> anyhow::Result<()> {
    let sections = sections();
    if args.json {
        let by_title: BTreeMap<_, _> = sections.iter().map(|(title, _, entries)| (title, entries)).collect();
        return print_json(&by_title);
    }
    let text = sections.iter().map(|(title, what, entries)| {
        let lines: Vec<_> = entries.iter().map(|entry| (entry.name, entry.line())).collect();
        format!("{title}: {what}\n{}", pairs("  ", &lines))
    });
    print(&text.collect::<Vec<_>>().join("\n"))
}

/// Writes a built-in scenario or experiment into a file, with what it refers to.
pub(crate) fn init(args: &InitArgs) -> anyhow::Result<()> {
    let name = args.name.as_str();
    let text =
        embedded::scenario(name).or_else(|| embedded::experiment(name)).ok_or_else(|| unknown(name))?;
    let last = name.rsplit('/').next().unwrap_or(name);
    let file = args.file.clone().unwrap_or_else(|| PathBuf::from(format!("{last}.toml")));
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let programs = embedded::programs().filter(|(program, _)| text.contains(program));
    let beside: Vec<_> = programs.map(|(program, bytes)| (folder.join(program), bytes)).collect();
    if file == Path::new(STDOUT) {
        return to_stdout(name, text, beside.first().map(|(program, _)| program.as_path()));
    }
    // All or nothing.
    beside.iter().map(|(path, _)| path).chain([&file]).try_for_each(|path| check_free(path))?;
    for (path, bytes) in &beside {
        write(path, bytes)?;
    }
    write(&file, text.as_bytes())?;
    let command = match embedded::experiment(name) {
        Some(_) => ["tune", "worst"].into_iter().find(|&first| last.starts_with(first)).unwrap_or("sweep"),
        None => "run",
    };
    let shown = file.display().to_string();
    let argument = shlex::try_quote(&shown).context("no shell takes the name of the file")?;
    print(&format!("{shown} is written; edit it, and try it with: baudbot {command} {argument}\n"))
}

/// Prints the file alone, if it needs no other one beside it.
fn to_stdout(name: &str, text: &str, program: Option<&Path>) -> anyhow::Result<()> {
    let Some(program) = program else { return text::write(Path::new(STDOUT), text) };
    Err(Refused::error(format!(
        "{name}: refers to {}, which is written beside it and cannot go to stdout; name a file instead of -",
        program.display()
    )))
}

/// Refuses a path where something is.
fn check_free(path: &Path) -> anyhow::Result<()> {
    let shown = path.display();
    if path.exists() {
        return Err(Refused::error(format!("{shown}: is there already; choose another file")));
    }
    if path.is_symlink() {
        return Err(Refused::error(format!(
            "{shown}: is a link that leads nowhere; remove it, or choose another file"
        )));
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let failed = || format!("cannot write {}", path.display());
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder).with_context(failed)?;
    }
    let mut file = fs::File::create_new(path).with_context(failed)?;
    io::Write::write_all(&mut file, bytes).with_context(failed)
}

fn unknown(name: &str) -> anyhow::Error {
    if embedded::exercise(name).is_some() {
        let last = name.rsplit('/').next().unwrap_or(name);
        return Refused::error(format!(
            "{name}: is an exercise, no scenario or experiment; write its file with: baudbot grade {name} --toml > {last}.toml"
        ));
    }
    let near: Vec<_> = embedded::nearest(name).iter().map(|near| format!("`{near}`")).collect();
    let near = match scenarios::brain_or_preset(name) {
        Some(is) => format!(" {is};"),
        None if near.is_empty() => String::new(),
        None => format!(" did you mean {}?", near.join(", ")),
    };
    Refused::error(format!(
        "{name}: there is no scenario and no experiment of this name;{near} `baudbot list` has them all"
    ))
}
