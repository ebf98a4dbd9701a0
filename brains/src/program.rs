//! The rest of a program that runs one brain: its command line, and its robot.
//!
//! [`main`] runs one of the catalogue. [`described`] runs those that are [described](crate::description) in a file, and may
//! name kinds of processes that the program adds to the [`Registry`].

use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use baudbot_client::{Body, Brain, Error, connect, run};
use clap::{Arg, ArgMatches, Command, value_parser};

use crate::anew::Anew;
use crate::catalogue::{self, Entry, catalogue, text_of};
use crate::description::Description;
use crate::registry::Registry;

/// Runs the brain called `name` as a program: attaches it to a robot and lets it drive until the run is over.
pub fn main(name: &str) -> ExitCode {
    ended(name, start(name))
}

/// Runs a brain that the file describes which the command line names, with these kinds of processes.
///
/// ```no_run
/// use baudbot_brains::program;
/// use baudbot_brains::registry::Registry;
///
/// fn main() -> std::process::ExitCode {
///     let mut registry = Registry::standard();
///     // registry.motor("spin", |parameters: SpinParameters, _| Ok(Spin::new(parameters)));
///     program::described(&registry)
/// }
/// ```
pub fn described(registry: &Registry) -> ExitCode {
    let arguments = description_command().get_matches();
    let file = text(&arguments, "file");
    ended(
        file,
        read(file).and_then(|description| {
            let make = |seed, body: &Body| {
                let description = description.clone();
                Ok(Anew::new(move |body: &Body| description.brain(seed, body, registry), body)?)
            };
            block_on(drive(&name_of(file), &arguments, make))
        }),
    )
}

/// The name that people see of what describes a brain; the contract allows 64 bytes.
pub fn shown_name(description: &str) -> String {
    let mut end = description.len().min(64);
    while !description.is_char_boundary(end) {
        end -= 1;
    }
    description[..end].to_owned()
}

/// That of a file: without the folders that it is in.
fn name_of(file: &str) -> String {
    shown_name(Path::new(file).file_name().and_then(OsStr::to_str).unwrap_or(file))
}

fn read(file: &str) -> anyhow::Result<Description> {
    Ok(Description::parse(&text_of(Path::new(file))?)?)
}

fn ended(name: &str, result: anyhow::Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{name}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn block_on(driving: impl Future<Output = anyhow::Result<()>>) -> anyhow::Result<()> {
    tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(driving)
}

fn start(name: &str) -> anyhow::Result<()> {
    let entry = catalogue().into_iter().find(|entry| entry.name == name).context("no such brain")?;
    let arguments = command(&entry).get_matches();
    let make = |seed, body: &Body| Ok(catalogue::brain(&description(&entry, &arguments), seed, body)?);
    block_on(drive(entry.name, &arguments, make))
}

/// Attaches, and drives until the run is over.
async fn drive<B: Brain>(
    name: &str,
    arguments: &ArgMatches,
    make: impl Fn(u64, &Body) -> anyhow::Result<B>,
) -> anyhow::Result<()> {
    let [address, world, robot_name] = ["connect", "world", "robot"].map(|id| text(arguments, id));
    let seed = arguments.get_one("seed").copied().unwrap_or_default();
    let client = connect(address).await?.brain(name).thinks_as_scenario();
    let summary = loop {
        let mut robot = client.clone().attach(world, robot_name).await?;
        let mut brain = make(seed, robot.body())?;
        println!("{name}: drives `{robot_name}` of `{world}` at {address}");
        match run(&mut robot, &mut brain).await {
            Err(Error::Restart) => println!("{name}: the operator has restarted this brain"),
            Ok(_) if robot.is_closed() => {
                anyhow::bail!("the server closed the connection before the run was over")
            }
            ended => break ended?,
        }
    };
    println!("{name}: the run is over after {} turns, at tick {}", summary.turns, summary.last_tick);
    Ok(())
}

/// The brain as the catalogue wants it described.
fn description(entry: &Entry, arguments: &ArgMatches) -> String {
    let settings: Vec<_> = arguments.get_many("param").into_iter().flatten().map(String::as_str).collect();
    format!("{}:{}", entry.name, settings.join(","))
}

fn text<'a>(arguments: &'a ArgMatches, id: &str) -> &'a str {
    arguments.get_one(id).map_or("", String::as_str)
}

fn command(entry: &Entry) -> Command {
    let setting = option("param", "NAME=NUMBER", "Sets a parameter; may be given several times");
    let command = Command::new(entry.name).about(format!("A brain that {}", entry.summary));
    with_robot(command).arg(setting.action(clap::ArgAction::Append)).after_help(settings(entry))
}

fn description_command() -> Command {
    let file = Arg::new("file").value_name("FILE").help("The brain's description, in TOML").required(true);
    with_robot(Command::new("brain").about("A brain that a file describes").arg(file))
}

fn option(name: &'static str, value: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).value_name(value).help(help)
}

/// Which robot it drives.
fn with_robot(command: Command) -> Command {
    let connect = option("connect", "ADDRESS", "The server: HOST:PORT, http://HOST:PORT or unix:/PATH");
    let seed = option("seed", "SEED", "Chooses the brain's random numbers");
    command
        .arg(connect.default_value("127.0.0.1:7400"))
        .arg(option("world", "WORLD", "Name of the world").required(true))
        .arg(option("robot", "ROBOT", "Name of the robot").default_value("robot"))
        .arg(seed.default_value("1").value_parser(value_parser!(u64)))
}

/// What can be set, a line each.
fn settings(entry: &Entry) -> String {
    let width = entry.parameters.iter().map(|setting| setting.name.len()).max().unwrap_or(0);
    let line = |setting: &catalogue::Setting| {
        format!("\n  {:width$}  {} [{}]", setting.name, setting.meaning, setting.default)
    };
    format!("Parameters:{}", entry.parameters.iter().map(line).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_files_go_by_their_name() {
        assert_eq!(shown_name(&"ä".repeat(40)), "ä".repeat(32));
        assert_eq!(shown_name(&format!("a{}", "ä".repeat(40))).len(), 63);
        assert_eq!(name_of(&format!("/{}/brain.toml", "folder/".repeat(20))), "brain.toml");
        assert_eq!(name_of(&"b".repeat(99)).len(), 64);
    }

    #[test]
    fn the_command_lines_of_all_brains_are_sound() {
        for entry in catalogue() {
            command(&entry).debug_assert();
            assert!(settings(&entry).lines().count() > entry.parameters.len());
        }
    }

    #[test]
    fn the_command_line_of_described_brains_is_sound() {
        description_command().debug_assert();
    }

    #[test]
    fn parameters_become_a_description() {
        let entry = catalogue().into_iter().find(|entry| entry.name == "constant").unwrap();
        let line = ["constant", "--world", "w", "--param", "left=0.5", "--param", "right=-0.5"];
        let arguments = command(&entry).get_matches_from(line);
        assert_eq!(description(&entry, &arguments), "constant:left=0.5,right=-0.5");
        assert_eq!(text(&arguments, "connect"), "127.0.0.1:7400");
        assert_eq!(text(&arguments, "robot"), "robot");
    }
}
