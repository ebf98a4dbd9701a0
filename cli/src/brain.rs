//! `baudbot brain`: a brain of the catalogue as a program of its own.

use std::fmt::Write;

use anyhow::{Context, bail};
use baudbot_brains::catalogue::catalogue;
use baudbot_client::Client;
use baudbot_proto::v1;

use crate::args::BrainArgs;
use crate::crew::{self, Crew, Job};
use crate::signals::Stop;
use crate::{connect, text};

pub(crate) async fn brain(args: BrainArgs) -> anyhow::Result<()> {
    let Some(brain) = args.brain.clone().filter(|_| !args.list) else { return text::print(&list()) };
    crew::check_name(&brain)?;
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    tokio::select! {
        driven = drive(brain, args) => driven,
        () = stop.wait() => Ok(()),
    }
}

/// Drives until the run is over. That a world, and a robot, need no name if there is only one, is for the
/// person at the keyboard; the brain itself sees its cable only.
async fn drive(brain: String, args: BrainArgs) -> anyhow::Result<()> {
    let channel = connect::channel(&args.server.connect).await?;
    let world = connect::world(channel.clone(), &args.server).await?;
    let robots = if args.robots.is_empty() { vec![only_robot(&world)?] } else { args.robots };
    let names = robots.join(", ");
    let job = Job { brain, robots };
    let mut crew = Crew::attach(Client::from_channel(channel), &world.world, job, args.seed).await?;
    eprintln!("driving {names} of world {}", world.world);
    let summary = crew.run(|| eprintln!("the operator has restarted the brain of {names}")).await?;
    if crew.is_closed() {
        bail!("the server closed the connection before the run was over");
    }
    let turns = usize::try_from(summary.turns).unwrap_or(usize::MAX);
    text::print(&format!("the run is over after {}\n", text::count(turns, "turn")))
}

fn only_robot(world: &v1::WorldStatus) -> anyhow::Result<String> {
    match world.robots.as_slice() {
        [] => bail!("world `{}` has no robots", world.world),
        [robot] => Ok(robot.robot.clone()),
        robots => {
            let names: Vec<_> = robots.iter().map(|robot| robot.robot.as_str()).collect();
            bail!("world `{}` has several robots, choose with --robot: {}", world.world, names.join(", "))
        }
    }
}

fn list() -> String {
    let mut text = String::new();
    for entry in catalogue() {
        let _ = writeln!(text, "{}: {}", entry.name, entry.summary);
        let setting = |setting: &baudbot_brains::catalogue::Setting| {
            let range = format!("{} to {}", setting.range.start(), setting.range.end());
            (format!("{}={}", setting.name, setting.default), format!("{} ({range})", setting.meaning))
        };
        let settings: Vec<_> = entry.parameters.iter().map(setting).collect();
        let pairs: Vec<_> = settings.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
        text += &text::pairs("    ", &pairs);
    }
    text + "
A parameter is set as in: baudbot brain constant:left=0.5,right=-0.5
Brains without any here are described in TOML. Their numbers are set by their paths, and a file makes a brain, too:
    baudbot brain sweeper:motor.charge.utility.bias=1.5
    baudbot brain my.toml
"
}
