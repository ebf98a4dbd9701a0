//! The kit: runs a brain through all provocations, and judges what it did.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use baudbot_access::{Token, private_folder};
use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_server::BrainLinkServiceServer;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_run::programs::{Process, Program, Task};
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_sim::Scenario;
use futures_util::stream::{self, StreamExt, TryStreamExt};
use tempfile::TempDir;
use tokio::net::{TcpListener, UnixListener};
use tokio::time::{Instant, sleep, timeout};
use tokio_stream::wrappers::{TcpListenerStream, UnixListenerStream};
use tonic::transport::Server as Transport;

use crate::case::{CASES, Case};
use crate::error::KitError;
use crate::evidence::{Evidence, Verdict};
use crate::provocation::Provocation;
use crate::record::{Event, ProgramEnd, Record};
use crate::scene::{self, WORLD};
use crate::service::Service;
use crate::spy::Spy;

/// The brain that is examined.
#[derive(Clone, Debug)]
pub enum Brain {
    /// A program that the kit starts for each run.
    Program(Program),
    /// A program that somebody starts for each run, which attaches at this address.
    Outside(std::net::SocketAddr),
}

/// What a case has found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The case.
    pub case: &'static Case,
    /// The verdict.
    pub verdict: Verdict,
    /// The lines that the program printed in the run that was judged.
    pub printed: Vec<String>,
}

/// A run that is about to begin.
#[derive(Clone, Debug)]
pub struct NextRun {
    /// Its number, from 1.
    pub number: usize,
    /// The number of all runs.
    pub count: usize,
    /// What happens in it.
    pub provocation: Provocation,
    /// The world, as in `BAUDBOT_WORLD`.
    pub world: &'static str,
    /// The robots, as in `BAUDBOT_ROBOT`.
    pub robots: String,
}

/// Called before each run.
pub type Progress<'a> = &'a mut dyn FnMut(&NextRun);

/// Runs a brain through all provocations in this scenario, and judges it.
///
/// `patience` is the time in which it must answer, attach or end.
///
/// # Errors
/// If the brain cannot be started, or a world not be made.
pub async fn examine(
    brain: &Brain,
    scenario: &Scenario,
    robot: Option<&str>,
    patience: Duration,
    progress: Progress<'_>,
) -> Result<Vec<Finding>, KitError> {
    let alone = scene::alone(scenario, robot)?;
    let two = scene::with_two(&alone)?;
    let count = Provocation::all().count();
    let scenario_of = |provocation: Provocation| if provocation.has_two_robots() { &two } else { &alone };
    let mut next = |number: usize, provocation: Provocation| {
        let robots: Vec<_> = scenario_of(provocation).robots.iter().map(|spec| spec.name.as_str()).collect();
        progress(&NextRun { number, count, provocation, world: WORLD, robots: robots.join(",") });
    };
    let trial = |provocation: Provocation| {
        let scenario = scenario_of(provocation);
        async move {
            let trial = Trial { brain, scenario, provocation, patience, token: Token::random()?.reveal() };
            let record = trial.run().await?;
            Ok::<_, KitError>((provocation, (record, trial.token)))
        }
    };
    next(1, Provocation::Plain);
    let plain = trial(Provocation::Plain).await?;
    // A brain that never attaches, or is dumb in the plainest of runs, has nothing else to show.
    let others = if plain.1.0.answers() { count } else { 1 };
    let others = (1..).zip(Provocation::all()).take(others).skip(1);
    let others = stream::iter(others).map(|(place, provocation)| {
        next(place, provocation);
        trial(provocation)
    });
    // They wait most of the time. At one address there can be one after the other only.
    let at_once = if matches!(brain, Brain::Program(_)) { AT_ONCE } else { 1 };
    let mut records: HashMap<_, _> = others.buffered(at_once).try_collect().await?;
    records.extend([plain]);
    let runs = Runs(records);
    let find = |case: &'static Case| Finding {
        case,
        verdict: runs.verdict(case),
        printed: runs.printed(case.provocation),
    };
    Ok(CASES.iter().map(find).collect())
}

/// The records of all runs, each with the token that the brain was given.
struct Runs(HashMap<Provocation, (Record, String)>);

impl Runs {
    fn verdict(&self, case: &Case) -> Verdict {
        let (Some((record, token)), Some((plain, _))) =
            (self.0.get(&case.provocation), self.0.get(&Provocation::Plain))
        else {
            return Verdict::NotUsed("the brain has not driven in the plainest of runs".to_owned());
        };
        let evidence = Evidence { record, plain, provocation: case.provocation, token };
        (case.judge)(&evidence).unwrap_or_else(|verdict| verdict)
    }

    fn printed(&self, provocation: Provocation) -> Vec<String> {
        let end = self.0.get(&provocation).and_then(|(record, _)| record.end.as_ref());
        end.map(|end| end.printed.clone()).unwrap_or_default()
    }
}

/// A run.
struct Trial<'a> {
    brain: &'a Brain,
    scenario: &'a Scenario,
    provocation: Provocation,
    patience: Duration,
    token: String,
}

impl Trial<'_> {
    async fn run(&self) -> Result<Record, KitError> {
        let pace = match self.provocation.is_timed() {
            true => Pace::scaled(10.0),
            false => Pace::Lockstep(Lockstep::default()),
        };
        // A world that does not wait for a brain begins once that is there.
        let world = WorldConfig::new(WORLD, Arc::new(self.scenario.clone()))
            .pace(pace)
            .paused(self.provocation.is_timed());
        let server = Server::builder().world(world).in_process().await?;
        let spy = Spy::new(self.provocation, server.channel().await?);
        let door = Door::of(self.brain)?;
        let delay = self.provocation.server_comes_after();
        let early = if delay.is_none() { Some(door.open(spy.clone()).await?) } else { None };
        let mut process = self.start(&door)?;
        let listening = match early {
            Some(listening) => listening,
            None => {
                sleep(delay.unwrap_or_default()).await;
                door.open(spy.clone()).await?
            }
        };
        self.watch(&spy, &mut process).await;
        let mut record = spy.record().clone();
        record.robots = self.robots();
        if let Some(process) = process {
            record.end = Some(self.end(process, &record).await);
        }
        record.state_hash = hash(&spy).await;
        listening.abort();
        server.shutdown().await;
        Ok(record)
    }

    fn robots(&self) -> Vec<String> {
        self.scenario.robots.iter().map(|spec| spec.name.clone()).collect()
    }

    fn start(&self, door: &Door) -> Result<Option<Process>, KitError> {
        let Brain::Program(program) = self.brain else { return Ok(None) };
        let mut task = Task::new(program.clone(), self.robots());
        let patience = self.patience.as_secs().max(1);
        let variables =
            [("BAUDBOT_TOKEN", self.token.clone()), ("BAUDBOT_RECONNECT_S", patience.to_string())];
        task.variables = variables.map(|(name, value)| (name.to_owned(), value)).into();
        Ok(Some(Process::start(&task, &door.address(), WORLD, 1)?))
    }

    /// Waits until there is nothing more to see, or the brain has been silent for too long.
    async fn watch(&self, spy: &Spy, process: &mut Option<Process>) {
        let (mut last, mut seen) = (Instant::now(), 0);
        loop {
            tokio::select! {
                () = spy.done() => return,
                () = spy.news() => {}
                () = sleep(LOOK) => {}
            }
            if process.as_mut().is_some_and(|process| !matches!(process.exited(), Ok(None))) {
                // What it said last is under way.
                sleep(SETTLE).await;
                return;
            }
            let said = {
                let record = spy.record();
                record.streams.len() + record.streams.iter().map(|stream| stream.events.len()).sum::<usize>()
            };
            if said != seen {
                (last, seen) = (Instant::now(), said);
            }
            if last.elapsed() > self.patience {
                return;
            }
            // Who tries again and again has been understood.
            let is_refused = self.provocation.refusal().is_some() || self.provocation == Provocation::Deleted;
            if is_refused && spy.record().streams.len() > MOST_ATTEMPTS {
                return;
            }
        }
    }

    /// The end of the program: one whose run is over has time to come to its end.
    async fn end(&self, mut process: Process, record: &Record) -> ProgramEnd {
        let leaves = record
            .streams
            .last()
            .is_some_and(|stream| stream.events.iter().any(|event| matches!(event, Event::Closed)));
        let patience = if leaves { self.patience } else { SETTLE };
        let waits = async {
            while matches!(process.exited(), Ok(None)) {
                sleep(LOOK).await;
            }
        };
        let _ = timeout(patience, waits).await;
        let status = process.exited().ok().flatten();
        process.end(Duration::ZERO).await;
        ProgramEnd { status, printed: process.lines() }
    }
}

/// The place at which the brain attaches.
enum Door {
    /// The folder of a socket, which only this user may enter.
    Private(TempDir),
    Open(std::net::SocketAddr),
}

impl Door {
    fn of(brain: &Brain) -> Result<Self, KitError> {
        match brain {
            Brain::Outside(address) => Ok(Self::Open(*address)),
            Brain::Program(_) => {
                let failed = |source| KitError::Place { place: "a folder for a socket".to_owned(), source };
                Ok(Self::Private(private_folder().map_err(failed)?))
            }
        }
    }

    fn address(&self) -> String {
        match self {
            Self::Private(folder) => format!("unix:{}", folder.path().join(SOCKET).display()),
            Self::Open(address) => address.to_string(),
        }
    }

    /// Serves the spy until the task is aborted.
    async fn open(&self, spy: Spy) -> Result<tokio::task::JoinHandle<()>, KitError> {
        let failed = |source| KitError::Place { place: self.address(), source };
        let services = Transport::builder().add_service(BrainLinkServiceServer::new(Service(spy)));
        Ok(match self {
            Self::Private(folder) => {
                let socket = UnixListener::bind(folder.path().join(SOCKET)).map_err(failed)?;
                let incoming = UnixListenerStream::new(socket);
                tokio::spawn(async move { drop(services.serve_with_incoming(incoming).await) })
            }
            Self::Open(address) => {
                let incoming = TcpListenerStream::new(TcpListener::bind(address).await.map_err(failed)?);
                tokio::spawn(async move { drop(services.serve_with_incoming(incoming).await) })
            }
        })
    }
}

/// The hash of the world's state, if it is still there.
async fn hash(spy: &Spy) -> Option<String> {
    let request = v1::GetWorldRequest { world: WORLD.to_owned() };
    let answer = ControlServiceClient::new(spy.world.clone()).get_world(request).await.ok()?;
    Some(answer.into_inner().status?.state_hash.to_string())
}

/// The runs that go on side by side.
const AT_ONCE: usize = 4;

/// The name of the socket in its folder.
const SOCKET: &str = "socket";

/// The interval at which it is looked whether the program is there.
const LOOK: Duration = Duration::from_millis(20);

/// The time for what is under way.
const SETTLE: Duration = Duration::from_millis(100);

/// The attempts after which a brain that is refused has shown that it goes on.
const MOST_ATTEMPTS: usize = 3;
