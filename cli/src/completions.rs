//! `baudbot completions`: commands, options, and the names of what is built in, for shells.

use std::fmt::Write;

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_import::embedded;
use baudbot_scenario::presets::presets;
use clap::builder::PossibleValuesParser;
use clap::{Arg, Command};
use clap_complete::Shell;

use crate::args::{self, CompletionsArgs};
use crate::text;

/// Prints a shell's completions. Where a file may stand in place of a name, bash, zsh and fish complete files, too.
pub(crate) fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut with_names(args::command()), "baudbot", &mut script);
    let mut script = String::from_utf8(script).context("a script is text")?;
    // bash completes files by itself if no name fits.
    if args.shell == Shell::Zsh {
        offer_files(&mut script);
    } else if args.shell == Shell::Fish {
        offer_positionals(&mut script);
    }
    text::print(&script)
}

/// The commands, of whose arguments those that take names know which.
fn with_names(command: Command) -> Command {
    let commands: Vec<_> = command.get_subcommands().map(|command| command.get_name().to_owned()).collect();
    commands.into_iter().fold(command, |command, name| {
        command.mut_subcommand(&name, |sub| {
            sub.mut_args(|argument| match names(&name, &argument) {
                Some(names) => argument.value_parser(PossibleValuesParser::new(names)),
                None => argument,
            })
        })
    })
}

/// The built-in names that can stand as this argument of a command.
fn names(command: &str, argument: &Arg) -> Option<Vec<&'static str>> {
    let first = |(name, _): (&'static str, &'static str)| name;
    match (command, argument.get_id().as_str()) {
        (_, "scenario" | "scenarios") => Some(embedded::scenarios().map(first).collect()),
        (_, "experiment") => Some(embedded::experiments().map(first).collect()),
        (_, "exercise") => Some(embedded::exercises().map(first).collect()),
        (_, "brain" | "brains") => Some(catalogue::catalogue().into_iter().map(|entry| entry.name).collect()),
        ("preset", "name") => Some(presets().map(|preset| preset.name).collect()),
        ("init", "name") => Some(embedded::scenarios().chain(embedded::experiments()).map(first).collect()),
        _ => None,
    }
}

/// Lets zsh complete files beside names, except where only names will do.
fn offer_files(script: &mut String) {
    for (command, argument) in named(&args::command()) {
        if !is_name_only(&command) {
            let names = names(&command, &argument).unwrap_or_default().join(" ");
            let with_files = format!(":{{_alternative \"names:name:({names})\" \"files:file:_files\"}}'");
            *script = script.replace(&format!(":({names})'"), &with_files);
        }
    }
}

/// Lets fish complete names where they are no options' values, which its generator leaves out.
fn offer_positionals(script: &mut String) {
    for (command, argument) in named(&args::command()) {
        if argument.is_positional() {
            let files = if is_name_only(&command) { " -f" } else { "" };
            let names = names(&command, &argument).unwrap_or_default().join(" ");
            let _ = writeln!(
                script,
                "complete -c baudbot -n \"__fish_baudbot_using_subcommand {command}\"{files} -a \"{names}\""
            );
        }
    }
}

/// The arguments that take names, each with its command.
fn named(command: &Command) -> Vec<(String, Arg)> {
    let of = |command: &Command| {
        let name = command.get_name().to_owned();
        let arguments = command.get_arguments().filter(|argument| names(&name, argument).is_some());
        arguments.map(|argument| (name.clone(), argument.clone())).collect::<Vec<_>>()
    };
    command.get_subcommands().flat_map(of).collect()
}

/// Whether a file cannot stand in place of a name.
fn is_name_only(command: &str) -> bool {
    matches!(command, "init" | "preset")
}
