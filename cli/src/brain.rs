//! `baudbot brain`: a brain of the catalogue as a program of its own.

use std::fmt::Write;

use anyhow::{Context, anyhow, bail};
use baudbot_brains::catalogue::catalogue;
use baudbot_client::{Client, Error, come_back};
use baudbot_plot::quantity::count;
use baudbot_proto::v1;

use crate::args::{BrainArgs, Reconnect};
use crate::assignment::{self, Assignment, AttachedBrains};
use crate::signals::Stop;
use crate::text::tell;
use crate::{connect, error, text};

pub(crate) async fn brain(args: BrainArgs) -> anyhow::Result<()> {
    let Some(brain) = args.brain.clone().filter(|_| !args.list) else { return text::print(&list()) };
    assignment::check_name(&brain)?;
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    tokio::select! {
        driven = drive(brain, args) => driven,
        () = stop.wait() => Ok(()),
    }
}

/// Drives until the run is over, and comes back to a server that it has lost. That a world, and a robot, need no name if there is only one, is for the
/// person at the keyboard; the brain itself sees its cable only.
async fn drive(brain: String, args: BrainArgs) -> anyhow::Result<()> {
    let channel = connect::channel(&args.server.connect).await?;
    let world = connect::world(channel.clone(), &args.server).await?;
    let there: Vec<_> = world.robots.iter().map(|robot| robot.robot.clone()).collect();
    let robots = match args.robots.as_slice() {
        [] => vec![only_robot(&world)?],
        patterns => assignment::named(patterns, &there)?,
    };
    let names = robots.join(", ");
    let assignment = Assignment { brain, robots };
    let mut brains =
        AttachedBrains::attach(Client::from_channel(channel), &world.world, assignment.clone(), args.seed)
            .await?;
    tell!("driving {names} of world {}", world.world);
    let attach = async || {
        let client = Client::from_channel(connect::channel(&args.server.connect).await?);
        AttachedBrains::attach(client, &world.world, assignment.clone(), args.seed).await
    };
    loop {
        let lost = match brains.run(|| tell!("the operator has restarted the brain of {names}")).await {
            Ok(_) if brains.is_closed() => {
                anyhow!("the server closed the connection before the run was over")
            }
            Ok(summary) => {
                let turns = usize::try_from(summary.turns).unwrap_or(usize::MAX);
                return text::print(&format!("the run is over after {}\n", count(turns, "turn")));
            }
            Err(error) if may_pass(&error) => error,
            Err(error) => return Err(error),
        };
        let Reconnect::For(limit) = args.reconnect else { return Err(lost) };
        let limit_s = limit.as_secs();
        tell!("{}; trying to reconnect for {limit_s} s", error::text(&lost));
        let back = come_back(limit, may_pass, &attach).await;
        brains = back.with_context(|| format!("the brain of {names} could not reconnect"))?;
        tell!("reconnected with a restarted brain: driving {names} of world {}", world.world);
    }
}

/// Whether it is the connection that failed, or something else that is not for ever.
fn may_pass(error: &anyhow::Error) -> bool {
    error.downcast_ref::<Error>().is_some_and(Error::may_pass)
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
Set parameters as in: baudbot brain constant:left=0.5,right=-0.5
Brains listed without parameters are described in TOML. Set their parameters by path, or run a description file:
    baudbot brain sweeper:motor.charge.utility.bias=1.5
    baudbot brain my.toml
"
}
