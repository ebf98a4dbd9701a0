//! The commands in groups, as `baudbot help` lists them.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Command, CommandFactory, FromArgMatches};
use console::Term;

use super::Cli;
use crate::error;
use crate::failure;
use crate::text::tell;

/// The intentions of users, with the commands for each. `help` is clap's own.
const GROUPS: &[(&str, &[&str])] = &[
    ("Run", &["run", "program", "grade", "diagram", "sweep", "tune", "worst", "replay", "export"]),
    ("Serve and connect", &["serve", "brain", "conform", "watch", "port", "token", "state", "cert"]),
    ("Examine a scenario", &["check", "budget", "plan", "locate", "umbmark"]),
    ("Real robots", &["preset", "evidence", "measure", "fit", "export-brain"]),
    ("Get started", &["list", "init", "new", "schema", "completions", "man", "help"]),
];

/// Columns of the names, and most columns of a line: clap breaks longer ones itself.
const INDENT: usize = 14;
const WIDEST: usize = 100;

/// Headings of options that are about a server's clients.
const OF_SERVERS: [&str; 2] = [super::ACCESS, super::LIMITS];

/// The exit code of a command line that makes no sense.
const USAGE: u8 = 2;

const TEMPLATE: &str =
    "{about-with-newline}\n{usage-heading} {usage}\n\n{before-help}Options:\n{options}{after-help}";

/// The command line, with its commands in groups.
pub(crate) fn command() -> Command {
    let command = Cli::command().mut_subcommand("run", without_server);
    let listed = listed(&command);
    command.help_template(TEMPLATE).before_help(listed)
}

/// A command that starts a server only if it is asked to, without what only a server has, but for where it listens. It takes all the same.
fn without_server(command: Command) -> Command {
    command.mut_args(|argument| {
        let is_of_server = argument.get_help_heading().is_some_and(|heading| OF_SERVERS.contains(&heading));
        argument.hide(is_of_server)
    })
}

/// The command line of this process. If that makes no sense, or asks for help, it is told, and the process ends with this code.
pub(crate) fn parsed() -> Result<Cli, ExitCode> {
    let matches = command().try_get_matches().map_err(|error| told(&error))?;
    Cli::from_arg_matches(&matches).map_err(|error| told(&error))
}

/// Help goes to stdout, a mistake to stderr. clap's own `exit` passes help for told that could not be written.
fn told(error: &clap::Error) -> ExitCode {
    if error.kind() == ErrorKind::ValueValidation {
        tell!("{}", error.render().to_string().trim_end());
        return ExitCode::from(USAGE);
    }
    let written = error.print().and_then(|()| io::stdout().flush());
    if error.use_stderr() {
        return ExitCode::from(USAGE);
    }
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => failure::told(&error::from_output(problem, "stdout")),
    }
}

/// The groups, each command with what it does.
fn listed(command: &Command) -> String {
    let about = |name: &str| match command.find_subcommand(name).and_then(Command::get_about) {
        Some(about) => about.to_string(),
        None => "Shows this help, or a command's options with examples".to_owned(),
    };
    // As wide as clap makes what it writes itself.
    let columns =
        Term::stdout().size_checked().map_or(WIDEST, |(_, columns)| columns.into()).clamp(60, WIDEST);
    let mut text = String::new();
    for (group, names) in GROUPS {
        let _ = writeln!(text, "{group}:");
        for name in *names {
            let _ = write!(text, "  {name:<12}");
            indented(&mut text, &about(name), columns);
        }
        text.push('\n');
    }
    text.trim_end().to_owned()
}

/// Writes words behind the name of a command, in lines below each other.
fn indented(text: &mut String, words: &str, columns: usize) {
    let mut column = INDENT;
    for word in words.split(' ') {
        let length = word.chars().count() + 1;
        if column + length > columns {
            let _ = write!(text, "\n{:INDENT$}", "");
            column = INDENT;
        }
        let _ = write!(text, " {word}");
        column += length;
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// A heading that is put on some options stays on those that follow.
    #[test]
    fn a_heading_has_the_same_options_in_each_command() {
        let command = command();
        let mut options: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
        let headed = command.get_subcommands().flat_map(Command::get_arguments);
        for (heading, id) in headed.filter_map(|arg| Some((arg.get_help_heading()?, arg.get_id().as_str()))) {
            *options.entry(heading).or_default().entry(id).or_default() += 1;
        }
        let of = |heading: &str| options[heading].keys().copied().collect::<Vec<_>>();
        assert_eq!(of("Firmware"), ["gdb", "serial", "vcd"]);
        assert_eq!(of("Recordings"), ["record", "record_hz", "recordings"]);
        assert_eq!(of("Changes to the scenario"), ["firmware", "no_noise", "seed", "sets"]);
        assert_eq!(of("Addresses"), ["listen", "viewer"]);
        assert_eq!(of("Pace"), ["lookahead", "max_lag_ms", "on_timeout", "pace", "watchdog_ms"]);
    }

    #[test]
    fn what_is_wrong_with_a_number_is_told_without_words_of_rust() {
        let told = |words: &[&str]| command().try_get_matches_from(words).unwrap_err().to_string();
        for (words, expected) in [
            (["baudbot", "run", "--seed=abc"], "'--seed <N>': must be a whole number\n"),
            (["baudbot", "run", "--external=0"], "'--external <N>': must be from 1 to 65535, is 0\n"),
            (["baudbot", "run", "--ticks=0"], "'--ticks <N>': must be 1 or more, is 0\n"),
        ] {
            let told = told(&words);
            assert!(told.contains(expected) && told.contains("--help"), "{told}");
        }
    }

    #[test]
    fn the_help_of_run_has_nothing_of_a_server_that_it_does_not_start() {
        let mut run = command().find_subcommand("run").unwrap().clone();
        let help = run.render_long_help().to_string();
        let serve = command().find_subcommand("serve").unwrap().clone();
        let of_server = serve
            .get_arguments()
            .filter(|arg| arg.get_help_heading().is_some_and(|h| OF_SERVERS.contains(&h)));
        let names: Vec<_> = of_server.filter_map(|arg| Some(format!("--{}", arg.get_long()?))).collect();
        assert!(names.len() > 20, "{names:?}");
        for name in &names {
            assert!(
                !help.contains(&format!("{name} ")) && !help.contains(&format!("{name}\n")),
                "{name} is in\n{help}"
            );
        }
        assert!(help.contains("--listen") && help.contains("`baudbot help serve`"), "{help}");
        // They are taken all the same.
        let words = ["baudbot", "run", "--listen", "127.0.0.1:0", "--max-connections", "5"];
        assert!(command().try_get_matches_from(words).is_ok());
    }

    #[test]
    fn each_command_is_in_one_group() {
        let command = Cli::command();
        let mut grouped: Vec<_> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let mut commands: Vec<_> = command.get_subcommands().map(Command::get_name).chain(["help"]).collect();
        grouped.sort_unstable();
        commands.sort_unstable();
        assert_eq!(grouped, commands);
    }
}
