//! The rest of a program that runs one brain: its command line, and its robot.

use std::process::ExitCode;

use anyhow::Context;
use baudbot_client::{connect, run};
use clap::{Arg, ArgMatches, Command, value_parser};

use crate::catalogue::{self, Entry, catalogue};

/// Runs the brain called `name` as a program: attaches it to a robot and lets it drive until the run is over.
pub fn main(name: &str) -> ExitCode {
    match start(name) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{name}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn start(name: &str) -> anyhow::Result<()> {
    let entry = catalogue().into_iter().find(|entry| entry.name == name).context("no such brain")?;
    let arguments = command(&entry).get_matches();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(drive(&entry, &arguments))
}

async fn drive(entry: &Entry, arguments: &ArgMatches) -> anyhow::Result<()> {
    let [address, world, name] = ["connect", "world", "robot"].map(|id| text(arguments, id));
    let seed = arguments.get_one("seed").copied().unwrap_or_default();
    let client = connect(address).await?.brain(entry.name).thinks_as_scenario();
    let mut robot = client.attach(world, name).await?;
    let mut brain = catalogue::brain(&description(entry, arguments), seed, robot.body())?;
    println!("{}: drives `{name}` of `{world}` at {address}", entry.name);
    let summary = run(&mut robot, &mut brain).await?;
    println!("{}: the run is over after {} turns, at tick {}", entry.name, summary.turns, summary.last_tick);
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
    let option = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).help(help)
    };
    Command::new(entry.name)
        .about(format!("A brain that {}", entry.summary))
        .arg(
            option("connect", "ADDRESS", "The server: HOST:PORT, http://HOST:PORT or unix:/PATH")
                .default_value("127.0.0.1:7400"),
        )
        .arg(option("world", "WORLD", "Name of the world").required(true))
        .arg(option("robot", "ROBOT", "Name of the robot").default_value("robot"))
        .arg(
            option("seed", "SEED", "Chooses the brain's random numbers")
                .default_value("1")
                .value_parser(value_parser!(u64)),
        )
        .arg(
            option("param", "NAME=NUMBER", "Sets a parameter; may be given several times")
                .action(clap::ArgAction::Append),
        )
        .after_help(settings(entry))
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
    fn the_command_lines_of_all_brains_are_sound() {
        for entry in catalogue() {
            command(&entry).debug_assert();
            assert!(settings(&entry).lines().count() > entry.parameters.len());
        }
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
