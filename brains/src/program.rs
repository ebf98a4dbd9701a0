//! A program that runs a brain: its command line, and its robot.
//!
//! [`described`] runs a brain that is [described](crate::description) in a file, and may name kinds of processes that the
//! program adds to the [`Registry`]. Brains of the catalogue need no program of their own: `baudbot brain NAME` runs them.

use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;

use baudbot_brain::{Body, Brain};
use baudbot_client::{Error, connect, run};
use clap::{Arg, ArgMatches, Command, value_parser};

use crate::catalogue::{shown_name, text_of};
use crate::description::Description;
use crate::registry::Registry;
use crate::restarting::Restarting;

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
    let arguments = command().get_matches();
    let file = text(&arguments, "file");
    match block_on(run_file(file, &arguments, registry)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{file}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn block_on(driving: impl Future<Output = anyhow::Result<()>>) -> anyhow::Result<()> {
    tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(driving)
}

async fn run_file(file: &str, arguments: &ArgMatches, registry: &Registry) -> anyhow::Result<()> {
    let description = Description::parse(&text_of(Path::new(file))?)?;
    let seed = arguments.get_one("seed").copied().unwrap_or_default();
    let make = |body: &Body| {
        let description = description.clone();
        Ok(Restarting::new(move |body: &Body| description.brain(seed, body, registry), body)?)
    };
    drive(&name_of(file), arguments, make).await
}

/// Attaches, and drives until the run is over.
async fn drive<B: Brain>(
    name: &str,
    arguments: &ArgMatches,
    make: impl Fn(&Body) -> anyhow::Result<B>,
) -> anyhow::Result<()> {
    let [address, world, robot_name] = ["connect", "world", "robot"].map(|id| text(arguments, id));
    let client = connect(address).await?.brain(name).thinks_as_scenario();
    let summary = loop {
        let mut robot = client.clone().attach(world, robot_name).await?;
        let mut brain = make(robot.body())?;
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

/// The name that people see of the brain in a file: without the folders that it is in.
fn name_of(file: &str) -> String {
    shown_name(Path::new(file).file_name().and_then(OsStr::to_str).unwrap_or(file))
}

fn text<'a>(arguments: &'a ArgMatches, id: &str) -> &'a str {
    arguments.get_one(id).map_or("", String::as_str)
}

fn command() -> Command {
    let file = Arg::new("file").value_name("FILE").help("The brain's description, in TOML").required(true);
    let connect = option("connect", "ADDRESS", "The server: HOST:PORT, http://HOST:PORT or unix:/PATH");
    let seed = option("seed", "SEED", "Chooses the brain's random numbers");
    Command::new("brain")
        .about("A brain that a file describes")
        .arg(file)
        .arg(connect.default_value("127.0.0.1:7400"))
        .arg(option("world", "WORLD", "Name of the world").required(true))
        .arg(option("robot", "ROBOT", "Name of the robot").default_value("robot"))
        .arg(seed.default_value("1").value_parser(value_parser!(u64)))
}

fn option(name: &'static str, value: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).value_name(value).help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_go_by_their_name() {
        assert_eq!(name_of(&format!("/{}/brain.toml", "folder/".repeat(20))), "brain.toml");
        assert_eq!(name_of(&"b".repeat(99)).len(), 64);
    }

    #[test]
    fn the_command_line_is_sound() {
        command().debug_assert();
        let arguments = command().get_matches_from(["brain", "brain.toml", "--world", "w"]);
        assert_eq!(text(&arguments, "connect"), "127.0.0.1:7400");
        assert_eq!(text(&arguments, "robot"), "robot");
    }
}
