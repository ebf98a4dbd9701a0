//! Worlds whose brains are in another process.
//!
//! The server runs here, as in `baudbot serve`: its services on one thread, its world on another. The brains run in a
//! process of their own ([`brains`]), which also takes the time where the world waits for them. [`crowd`] is for real
//! time, where worlds do not wait, [`worlds`] for many worlds without brains. [`ping`] is what the path is compared
//! with.

mod brains;
mod crowd;
mod guards;
mod heartbeat;
mod ping;
mod server;
mod worlds;

use std::process::Command;

use baudbot_server::{Lockstep, Pace, WorldConfig};
use serde::{Deserialize, Serialize};

use crate::child::{Brains, Child, ChildError, Streams, Task};
use crate::in_process::Unfit;
use crate::measure::{Effort, Sample};
use crate::outcome::Beside;
use crate::plan::Plan;
use crate::process;
use crate::scenario::{Cable, Infrared, parse, plans};
use guards::Guards;
use server::{Running, WORLD};

pub(crate) use brains::perform;
pub(crate) use worlds::Worlds;

/// A world behind a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Network {
    /// One brain in lockstep, steps of 1 ms, a reading and a command in each, beside a bare ping-pong; over TLS with a token, or
    /// without both.
    Alone { guarded: bool },
    /// The same at 9600 baud.
    Serial { lookahead: bool },
    /// 22 brains in lockstep, beside a bare barrier.
    Team(Streams),
    /// 1,000 robots in real time, on 10 streams.
    Crowd,
}

/// The findings of the process with the brains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Found {
    pub(crate) samples: Vec<Sample>,
    /// A ping-pong of the same messages.
    pub(crate) beside: Option<Beside>,
    pub(crate) usage: Option<process::Usage>,
}

/// The reason why a workload with a server could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// The world is not what it should be.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The process with the brains.
    #[error("the brains: {0}")]
    Brains(#[from] ChildError),
    /// The server.
    #[error("the server: {0}")]
    Server(String),
}

impl Network {
    /// Measures it; `command` begins a process with the brains.
    pub(crate) fn run(
        self,
        effort: Effort,
        mut command: Command,
        progress: impl FnMut(u32),
    ) -> Result<(Found, Vec<String>), NetworkError> {
        let lookahead = self == Self::Serial { lookahead: true };
        let scenario = self.scenario()?;
        let scenario = parse(&scenario).map_err(Unfit::from)?;
        let robots = scenario.robots.iter().map(|spec| spec.name.clone()).collect();
        if self == Self::Crowd {
            return crowd::run(scenario, robots, effort, command, progress);
        }
        let streams = if let Self::Team(streams) = self { streams } else { Streams::Connections };
        let world = WorldConfig::new(WORLD, scenario).pace(pace(lookahead));
        let guards = if self == (Self::Alone { guarded: true }) { Some(Guards::new()?) } else { None };
        if let Some(guards) = &guards {
            guards.give_to(&mut command);
        }
        let server = Running::start(vec![world], guards.as_ref())?;
        let pings = match self {
            Self::Alone { .. } | Self::Team(Streams::OneStream) => Some(1),
            Self::Team(Streams::Connections | Streams::OneConnection) => Some(TEAM),
            Self::Serial { .. } | Self::Crowd => None,
        };
        let ping = pings.map(|streams| server.ping(streams)).transpose()?;
        let what = Brains::Lockstep { robots, streams, ping, lookahead, effort };
        let child = Child::start(command, &Task::Brains { address: server.address(), what })?;
        let mut found: Found = child.end(progress)?;
        let status = server.status()?;
        server.end();
        check(&status, found.samples.len())?;
        let usage = process::usage();
        let mut notes: Vec<_> = found.usage.iter().map(|brains| format!("brains {brains}")).collect();
        notes.insert(0, format!("server {usage}"));
        found.usage = Some(usage);
        Ok((found, notes))
    }

    fn scenario(self) -> Result<String, Unfit> {
        let plan = |text: &str, robots| {
            let mut plan: Plan = text.parse()?;
            plan.robots.truncate(robots);
            Ok::<_, Unfit>(plan)
        };
        let alone = |cable| Infrared { step_ms: 1.0, sensors: 1, ..Infrared::new(cable) };
        Ok(match self {
            Self::Alone { .. } => alone(Cable::Ideal).scenario(&plan(plans::IR_1, 1)?),
            Self::Serial { .. } => alone(Cable::Uart9600).scenario(&plan(plans::IR_1, 1)?),
            Self::Team(_) => Infrared { encoders: true, ..Infrared::new(Cable::Ideal) }
                .scenario(&plan(plans::IR_100, TEAM)?),
            Self::Crowd => Infrared::new(Cable::Ideal).scenario(&plan(plans::IR_1000, 1000)?),
        })
    }
}

/// The pace of a world that waits for its brains.
fn pace(lookahead: bool) -> Pace {
    Pace::Lockstep(Lockstep { lookahead, ..Lockstep::default() })
}

/// Whether every robot was driven.
fn check(status: &baudbot_proto::v1::WorldStatus, repeats: usize) -> Result<(), Unfit> {
    for robot in &status.robots {
        let name = &robot.robot;
        if robot.distance_m.is_nan() || robot.distance_m <= 0.0 || robot.commands == 0 {
            return Err(Unfit::NotReal(format!(
                "robot `{name}` obeyed {} commands and has driven {} m in {} ticks",
                robot.commands, robot.distance_m, status.tick
            )));
        }
    }
    if repeats == 0 { Err(Unfit::NotReal("nothing was measured".to_owned())) } else { Ok(()) }
}

/// Players of two football teams.
const TEAM: usize = 22;
