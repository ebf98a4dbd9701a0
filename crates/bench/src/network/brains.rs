//! The process with the brains.

use std::io;

use baudbot_client::{Action, Client, Error, Fleet, Robot, Signals, Turn, connect};
use tokio::runtime::Runtime;
use tokio::task::JoinSet;
use tonic::Status;

use super::Found;
use super::ping::{self, Players};
use super::server::WORLD;
use crate::child::{Brains, Streams};
use crate::driver::by_infrared;
use crate::measure::{self, Effort};
use crate::outcome::Beside;
use crate::process::{self, Clock};

/// A reason why the brains did not do their task.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BrainsError {
    #[error("cannot start the runtime: {0}")]
    Runtime(io::Error),
    #[error(transparent)]
    Client(#[from] Error),
    #[error("the ping-pong: {}", .0.message())]
    NoPing(Status),
    #[error("{}", .0.message())]
    Ping(Status),
}

/// Does what the server's process asks for.
///
/// # Errors
/// If the server cannot be reached, or ends before the brains are done.
pub(crate) fn perform(address: &str, what: &Brains, progress: impl FnMut(u32)) -> Result<Found, BrainsError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(BrainsError::Runtime)?;
    let mut found = match what {
        Brains::Lockstep { robots, streams, ping, lookahead, effort } => {
            let mut brains = runtime.block_on(AttachedBrains::attach(address, robots, *streams))?;
            brains.waits = *lookahead;
            let connect = |address| runtime.block_on(Players::connect(address, robots.len(), *streams));
            let ping = ping.as_deref().map(connect).transpose().map_err(BrainsError::NoPing)?;
            let mut found = lockstep(&runtime, brains, ping, *effort, progress)?;
            if let Some(beside) = &mut found.beside {
                beside.what = told(robots.len(), *streams);
            }
            found
        }
        Brains::RealTime { robots, streams } => {
            runtime.block_on(real_time(address, robots, *streams))?;
            Found::default()
        }
    };
    found.usage = Some(process::usage());
    Ok(found)
}

/// Repeats of the ping-pong and of the world by turns, so that both see the same machine.
fn lockstep(
    runtime: &Runtime,
    mut brains: AttachedBrains,
    mut ping: Option<Players>,
    effort: Effort,
    mut progress: impl FnMut(u32),
) -> Result<Found, BrainsError> {
    let beside = ping.is_some().then(|| Beside { what: String::new(), samples: Vec::new() });
    let mut found = Found { beside, ..Found::default() };
    let once = Effort { repeats: 1, ..effort };
    for repeat in 1..=effort.repeats {
        progress(repeat);
        if let Some((players, beside)) = ping.as_mut().zip(found.beside.as_mut()) {
            let play = |times| runtime.block_on(players.play(times));
            let samples = measure::rate(once, Clock::Wall, |_| {}, play).map_err(BrainsError::Ping)?;
            beside.samples.extend(samples);
        }
        let work = |ticks| runtime.block_on(brains.drive(ticks));
        found.samples.extend(measure::rate(once, Clock::Wall, |_| {}, work)?);
    }
    Ok(found)
}

/// The description of a ping-pong with streams like those of so many robots.
fn told(robots: usize, streams: Streams) -> String {
    let bytes = ping::BYTES;
    if robots == 1 {
        return format!("a bare ping-pong of {bytes} bytes");
    }
    match streams {
        Streams::Connections => format!("a bare barrier of {robots} connections, {bytes} bytes each"),
        Streams::OneConnection => format!("a bare barrier of {robots} streams, {bytes} bytes each"),
        Streams::OneStream => format!("a bare ping-pong of {} bytes", bytes * robots),
    }
}

/// Brains that hold their robots.
struct AttachedBrains {
    held: Held,
    /// Whether they need not be asked before there is news.
    waits: bool,
}

enum Held {
    Streams(Vec<Robot>),
    Fleet(Box<Fleet>),
}

impl AttachedBrains {
    async fn attach(address: &str, robots: &[String], streams: Streams) -> Result<Self, Error> {
        let first = client(address).await?;
        if streams == Streams::OneStream {
            let names: Vec<_> = robots.iter().map(String::as_str).collect();
            let fleet = first.attach_many(WORLD, &names).await?;
            return Ok(Self { held: Held::Fleet(Box::new(fleet)), waits: false });
        }
        let mut held = Vec::new();
        for (i, robot) in robots.iter().enumerate() {
            let alone = streams == Streams::Connections && i > 0;
            let own = if alone { client(address).await? } else { first.clone() };
            held.push(own.attach(WORLD, robot).await?);
        }
        Ok(Self { held: Held::Streams(held), waits: false })
    }

    /// Drives all robots for so many ticks, each in a task of its own, as programs of their own would.
    async fn drive(&mut self, ticks: u64) -> Result<(), Error> {
        let waits = self.waits;
        match &mut self.held {
            Held::Fleet(fleet) => drive_fleet(fleet, ticks).await,
            Held::Streams(robots) => {
                let mut tasks = JoinSet::new();
                for mut robot in std::mem::take(robots) {
                    tasks.spawn(async move { drive(&mut robot, ticks, waits).await.map(|()| robot) });
                }
                while let Some(done) = tasks.join_next().await {
                    robots.push(done.expect("a brain does not panic")?);
                }
                Ok(())
            }
        }
    }
}

async fn client(address: &str) -> Result<Client, Error> {
    Ok(connect(address).await?.brain("bench"))
}

/// Through so many ticks of the world, whether or not the brain is asked in each.
async fn drive(robot: &mut Robot, ticks: u64, waits: bool) -> Result<(), Error> {
    let mut last = None;
    while let Some(turn) = robot.turn().await? {
        let action = step(&turn);
        robot.act(if waits { action.until_message() } else { action }).await?;
        if turn.tick >= *last.get_or_insert_with(|| turn.tick + ticks.saturating_sub(1)) {
            break;
        }
    }
    Ok(())
}

async fn drive_fleet(fleet: &mut Fleet, ticks: u64) -> Result<(), Error> {
    for _ in 0..ticks {
        let Some(turns) = fleet.turns().await? else { return Ok(()) };
        let actions: Vec<_> = turns.iter().map(|(robot, turn)| (*robot, step(turn))).collect();
        fleet.act(&actions).await?;
    }
    Ok(())
}

/// A command for each new reading, and nothing for none.
fn step(turn: &Turn) -> Action {
    if !turn.has_news() {
        return Action::wait();
    }
    let infrared = turn.readings.iter().flatten().filter_map(|reading| reading.values.first().copied());
    let [left, right] = by_infrared(infrared);
    Action { signals: Some(Signals { left, right }), ..Action::wait() }
}

/// Drives all robots, divided among the streams, each with a connection, until the server ends.
async fn real_time(address: &str, robots: &[String], streams: usize) -> Result<(), Error> {
    let mut tasks = JoinSet::new();
    for names in robots.chunks(robots.len().div_ceil(streams)) {
        let names: Vec<_> = names.iter().map(String::as_str).collect();
        let mut fleet = client(address).await?.attach_many(WORLD, &names).await?;
        tasks.spawn(async move { drive_fleet(&mut fleet, u64::MAX).await });
    }
    // However a stream ended: the world is deleted when there is enough of it.
    while tasks.join_next().await.is_some() {}
    Ok(())
}
