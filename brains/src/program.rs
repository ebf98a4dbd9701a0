//! A program that runs a brain: its command line, and its robots.
//!
//! [`brain`] runs a brain of one's own. [`described`] runs one that is [described](crate::description) in a file, and may name
//! kinds of processes that the program adds to the [`Registry`]. Brains of the catalogue need no program of their own:
//! `baudbot brain NAME` runs them.
//!
//! Arguments that the command line leaves out are taken from the environment, which `baudbot run --brain 'exec:…'`
//! sets for the programs that it starts: `BAUDBOT_CONNECT`, `BAUDBOT_WORLD`, `BAUDBOT_ROBOT` (names with commas
//! between them), `BAUDBOT_SEED`, `BAUDBOT_PARAMETERS` and `BAUDBOT_RECONNECT_S`. A program that loses its server
//! tries to come back, and says so on stderr.

use std::ffi::OsStr;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use baudbot_brain::{Body, Brain};
use baudbot_client::{Attachment, Reconnect};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use crate::catalogue::{shown_name, text_of};
use crate::description::Description;
pub use crate::given::Given;
use crate::registry::Registry;

/// Runs a brain of one's own, under this name. `make` makes it for a robot, from its data sheet and what the program was
/// [given]: the seed of the brain's own random numbers, and its parameters. It is called for each robot, and again when the brain starts over: when the operator wants that, after a lost
/// connection, and when the world's time goes back.
///
/// ```no_run
/// use baudbot_brains::program;
/// use baudbot_client::{Action, Brain, Turn};
///
/// /// Drives straight on.
/// struct Straight {
///     speed: f64,
/// }
///
/// impl Brain for Straight {
///     fn step(&mut self, _: &Turn) -> Action {
///         Action::drive(self.speed, self.speed)
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     program::brain("straight", |_body, given| Ok(Straight { speed: given.number("speed", 0.5) }))
/// }
/// ```
///
/// [given]: Given
pub fn brain<B: Brain>(name: &'static str, make: impl Fn(&Body, &Given) -> anyhow::Result<B>) -> ExitCode {
    let arguments = match given_to(command(name).about("A brain for robots of baudbot")) {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    let attachment = Attachment { thinks_as_scenario: false, ..attachment(shown_name(name), &arguments) };
    let driven = Given::of_environment(seed(&arguments)).and_then(|given| {
        drive(&attachment, |body| {
            let brain = make(body, &given)?;
            given.check()?;
            anyhow::Ok(brain)
        })
    });
    ended(name, driven)
}

/// Runs a brain that the file describes which the command line names, with these kinds of processes. Parameters of the
/// environment are paths in that file.
///
/// ```no_run
/// use baudbot_brains::program;
/// use baudbot_brains::registry::Registry;
///
/// fn main() -> std::process::ExitCode {
///     let mut registry = Registry::standard();
///     // registry.motors.add("spin", |parameters: SpinParameters, _| Ok(Spin::new(parameters)));
///     program::described(&registry)
/// }
/// ```
pub fn described(registry: &Registry) -> ExitCode {
    let arguments = match given_to(command_for_files()) {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    let file = text(&arguments, "file");
    ended(file, run_file(file, &arguments, registry))
}

/// The arguments of this process. If they are invalid, or ask for help, a message is printed and the process ends with
/// this code.
fn given_to(command: Command) -> Result<ArgMatches, ExitCode> {
    command.try_get_matches().map_err(|error| {
        let written = error.print().and_then(|()| io::stdout().flush());
        match written {
            Ok(()) if !error.use_stderr() => ExitCode::SUCCESS,
            Err(failure) if !error.use_stderr() => {
                let _ = writeln!(io::stderr(), "error: cannot write stdout: {failure}");
                ExitCode::FAILURE
            }
            Ok(()) | Err(_) => ExitCode::from(USAGE),
        }
    })
}

/// The exit code of an invalid command line.
const USAGE: u8 = 2;

/// Prints the result of a run, and gives the exit code.
fn ended(name: &str, driven: anyhow::Result<()>) -> ExitCode {
    match driven {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{name}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run_file(file: &str, arguments: &ArgMatches, registry: &Registry) -> anyhow::Result<()> {
    let given = Given::of_environment(seed(arguments))?;
    let description = Description::with_settings(&text_of(Path::new(file))?, &given.settings())?;
    drive(&attachment(name_of(file), arguments), |body| description.any_brain(given.seed, body, registry))
}

/// Attaches, and drives until the run is over.
fn drive<B: Brain, E: Display>(
    attachment: &Attachment,
    make: impl Fn(&Body) -> Result<B, E>,
) -> anyhow::Result<()> {
    let driving = attachment.drive(make, |line| eprintln!("{line}"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let summary = runtime.block_on(driving).map_err(|error| anyhow::anyhow!("{error}"))?;
    // The run is over even if stdout is closed.
    let _ = writeln!(
        io::stdout(),
        "the run is over after {} turns, at tick {}",
        summary.turns,
        summary.last_tick
    );
    Ok(())
}

/// The attachment of a brain of processes, none of which has a thinking time.
fn attachment(brain: String, arguments: &ArgMatches) -> Attachment {
    let robots = arguments.get_many("robot").unwrap_or_default();
    Attachment {
        credentials: None,
        connect: text(arguments, "connect").to_owned(),
        world: text(arguments, "world").to_owned(),
        robots: robots.cloned().collect(),
        brain,
        thinks_as_scenario: true,
        reconnect: arguments.get_one("reconnect").copied().unwrap_or_default(),
    }
}

fn seed(arguments: &ArgMatches) -> u64 {
    arguments.get_one("seed").copied().unwrap_or_default()
}

/// The name that people see of the brain in a file: without the folders that it is in.
fn name_of(file: &str) -> String {
    shown_name(Path::new(file).file_name().and_then(OsStr::to_str).unwrap_or(file))
}

fn text<'a>(arguments: &'a ArgMatches, id: &str) -> &'a str {
    arguments.get_one(id).map_or("", String::as_str)
}

fn command_for_files() -> Command {
    let file = Arg::new("file").value_name("FILE").help("The brain's description, in TOML").required(true);
    command("brain").about("A brain described by a file").arg(file)
}

/// The command with the arguments for attaching.
fn command(name: &'static str) -> Command {
    let connect = option("connect", "ADDRESS", "The server: HOST:PORT, http://HOST:PORT or unix:/PATH");
    let world = option("world", "WORLD", "Name of the world");
    let robot = option("robot", "ROBOT", "Name of the robot; may be given several times");
    let seed = option("seed", "SEED", "Seed of the brain's random numbers");
    let reconnect_help =
        "After a lost connection, try to reconnect for this time, in seconds; `off` disables reconnection";
    let reconnect =
        option("reconnect", "S|off", reconnect_help).env("BAUDBOT_RECONNECT_S").default_value("600");
    Command::new(name)
        .arg(connect.env("BAUDBOT_CONNECT").default_value("127.0.0.1:7400"))
        .arg(world.env("BAUDBOT_WORLD").required(true))
        .arg(robot.env("BAUDBOT_ROBOT").default_value("robot").action(ArgAction::Append).value_delimiter(','))
        .arg(seed.env("BAUDBOT_SEED").default_value("1").value_parser(value_parser!(u64)))
        .arg(reconnect.value_parser(value_parser!(Reconnect)))
}

fn option(name: &'static str, value: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).value_name(value).help(help)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn files_go_by_their_name() {
        assert_eq!(name_of(&format!("/{}/brain.toml", "folder/".repeat(20))), "brain.toml");
        assert_eq!(name_of(&"b".repeat(99)).len(), 64);
    }

    #[test]
    fn the_command_line_says_where_the_brain_attaches() {
        command("weaver").debug_assert();
        command_for_files().debug_assert();
        let least = command_for_files().get_matches_from(["brain", "brain.toml", "--world", "w"]);
        let least = attachment("weaver".to_owned(), &least);
        assert_eq!((least.connect.as_str(), least.world.as_str()), ("127.0.0.1:7400", "w"));
        assert_eq!((least.robots, least.reconnect), (vec!["robot".to_owned()], Reconnect::default()));
        let robots = ["--robot", "a,b", "--robot", "c", "--reconnect", "90", "--seed", "7"];
        let all = command("weaver").get_matches_from([&["weaver", "--world", "w"], &robots[..]].concat());
        assert_eq!(seed(&all), 7);
        let all = attachment("weaver".to_owned(), &all);
        assert_eq!(all.robots, ["a", "b", "c"]);
        assert_eq!(all.reconnect, Reconnect::For(Duration::from_secs(90)));
    }
}
