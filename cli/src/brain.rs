//! `baudbot brain`: a brain of the catalogue as a program of its own.

use std::fmt::Write;

use anyhow::{Context, bail};
use baudbot_brains::catalogue;
use baudbot_client::{Attachment, AttachmentError, Body, Channel};
use baudbot_plot::quantity::count;
use baudbot_proto::v1;
use serde_json::{Value, json};
use tonic::Code;

use crate::args::BrainArgs;
use crate::assignment;
use crate::error::Refused;
use crate::signals::Stop;
use crate::text::tell;
use crate::{connect, natural, text};

pub(crate) async fn brain(args: BrainArgs) -> anyhow::Result<()> {
    let Some(brain) = args.brain.clone().filter(|_| !args.list) else {
        return if args.json { text::print_json(&entries()) } else { text::print(&list()) };
    };
    assignment::check_name(&brain)?;
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    tokio::select! {
        driven = drive(brain, args) => driven,
        () = stop.wait() => Ok(()),
    }
}

/// Drives until the run is over, and comes back to a server that it has lost. That a world, and a robot, need no name if there
/// is only one, is for the person at the keyboard; the brain itself sees its cable only.
async fn drive(brain: String, args: BrainArgs) -> anyhow::Result<()> {
    let credentials = args.server.credentials.read()?;
    let (world, robots) = match named(&args) {
        // A token to drive need not be one to look.
        Some(named) => named,
        None => found(&args).await?,
    };
    let attachment = Attachment {
        connect: args.server.connect,
        credentials: Some(credentials),
        world,
        robots,
        brain: catalogue::shown_name(&brain),
        // The brains of the catalogue do not state a thinking time.
        thinks_as_scenario: true,
        reconnect: args.reconnect,
    };
    let make = |body: &Body| catalogue::brain(&brain, args.seed, body);
    let summary = attachment.drive(make, |line| tell!("{line}")).await.map_err(|error| match error {
        AttachmentError::Brain(error) => Refused::error(error.to_string()),
        AttachmentError::Client(_) | AttachmentError::Closed | AttachmentError::NotBack { .. } => {
            error.into()
        }
    })?;
    let turns = usize::try_from(summary.turns).unwrap_or(usize::MAX);
    // The run was over before the brain attached.
    let again =
        if turns == 0 { "; the server's operator can reset the world (Reset on the page)" } else { "" };
    text::print(&format!("the run is over after {}{again}\n", count(turns, "turn")))
}

/// The world and the robots, if the arguments name them in full.
fn named(args: &BrainArgs) -> Option<(String, Vec<String>)> {
    let are_names = !args.robots.is_empty() && args.robots.iter().all(|robot| !robot.contains('*'));
    Some((args.server.world.clone().filter(|_| are_names)?, args.robots.clone()))
}

/// The world and the robots by the server.
async fn found(args: &BrainArgs) -> anyhow::Result<(String, Vec<String>)> {
    let channel = connect::channel(&args.server).await?;
    let world = match connect::world(channel.clone(), &args.server).await {
        Ok(world) => world,
        Err(error) => {
            let remedy =
                "this token cannot list worlds and robots, so name both in full with --world and --robot";
            return Err(if may_list(channel).await { error } else { error.context(remedy) });
        }
    };
    let there: Vec<_> = world.robots.iter().map(|robot| robot.robot.clone()).collect();
    let robots = match args.robots.as_slice() {
        [] => vec![only_robot(&world)?],
        patterns => assignment::named(patterns, &there)?,
    };
    Ok((world.world, robots))
}

/// Whether the token can list worlds, or that cannot be known.
async fn may_list(channel: Channel) -> bool {
    let listed = connect::control(channel).list_worlds(v1::ListWorldsRequest {}).await;
    listed.map_or_else(|status| status.code() != Code::PermissionDenied, |_| true)
}

fn only_robot(world: &v1::WorldStatus) -> anyhow::Result<String> {
    match world.robots.as_slice() {
        [] => bail!("world `{}` has no robots", world.world),
        [robot] => Ok(robot.robot.clone()),
        robots => {
            let names = natural::sorted(robots.iter().map(|robot| robot.robot.as_str()), |name| name);
            bail!("world `{}` has several robots; choose one with --robot: {}", world.world, names.join(", "))
        }
    }
}

/// The brains with their parameters, for programs.
fn entries() -> Vec<Value> {
    let parameter = |setting: &catalogue::Setting| {
        let catalogue::Setting { name, meaning, default, range } = setting;
        json!({ "name": name, "default": default, "min": range.start(), "max": range.end(), "meaning": meaning })
    };
    let entry = |entry: catalogue::Entry| {
        let parameters: Vec<_> = entry.parameters.iter().map(parameter).collect();
        json!({ "name": entry.name, "summary": entry.summary, "writes": entry.writes.to_string(), "parameters": parameters })
    };
    catalogue::catalogue().into_iter().map(entry).collect()
}

fn list() -> String {
    let mut text = String::new();
    for entry in catalogue::catalogue() {
        let _ = writeln!(text, "{}: {}", entry.name, entry.summary);
        let setting = |setting: &catalogue::Setting| {
            let range = format!("{} to {}", setting.range.start(), setting.range.end());
            (format!("{}={}", setting.name, setting.default), format!("{} ({range})", setting.meaning))
        };
        let settings: Vec<_> = entry.parameters.iter().map(setting).collect();
        let pairs: Vec<_> = settings.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
        text += &text::pairs("    ", &pairs);
    }
    text + "
Set parameters as in: baudbot brain constant:left=0.5,right=-0.5
Brains listed without parameters are described in TOML. Set their parameters by path, or run a description file:
    baudbot brain sweeper:motor.charge.utility.bias=1.5
    baudbot brain my.toml
"
}
