//! Runs on a server.

use std::cell::{Cell, RefCell};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use baudbot_client::{Channel, Client, connect};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_run::AttachedBrains;
use baudbot_run::assignment::{Assigned, Assignment, START_PATIENCE};
use baudbot_run::programs::{Crew, Failure as Broken, Held, Idle, Lifetime, PROGRAM};
use baudbot_server::Server;
use tokio::runtime::Runtime;
use tonic::Code;

use crate::error::Error;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::observed_world::ObservedWorld;
use crate::private_server::PrivateServer;
use crate::run_record::{Ran, Row, RunError, Task};
use crate::setup::{self, Setup};

/// A connection to a server that does runs.
pub(crate) struct Remote {
    runtime: Runtime,
    client: Client,
    /// The server's address, for programs that attach to it.
    address: String,
    name: String,
    /// The time by the wall clock in which a program has to answer; `None`: somebody else looks to that.
    brain_timeout: Option<Duration>,
    /// The server, if it is in this process.
    private: Option<Weak<Server>>,
    /// Programs that have done a run and wait for another.
    idle: Cell<Idle>,
    /// The last run of a process that has done others, unless a new process has done it again.
    unchecked: RefCell<Option<(Task, Ran)>>,
}

/// A run that was done, and how many runs its programs had done before.
struct Done {
    ran: Ran,
    earlier_runs: u64,
}

/// The server that has the worlds.
#[derive(Clone, Copy)]
pub(crate) enum Host<'a> {
    /// The one at this address.
    Address(&'a str),
    Private(&'a PrivateServer),
}

impl Host<'_> {
    /// The address at which programs attach.
    fn brains(&self) -> &str {
        match self {
            Self::Address(address) => address,
            Self::Private(server) => &server.address,
        }
    }

    fn private(&self) -> Option<Weak<Server>> {
        match self {
            Self::Address(_) => None,
            Self::Private(server) => server.server().map(Arc::downgrade),
        }
    }

    async fn operator(&self) -> Result<Client, Error> {
        match self {
            Self::Address(address) => {
                connect(address).await.map_err(|error| Error::Server(error.to_string()))
            }
            Self::Private(server) => server.operator().await,
        }
    }
}

impl Remote {
    pub(crate) fn connect(
        host: Host<'_>,
        name: &str,
        brain_timeout: Option<Duration>,
    ) -> Result<Self, Error> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| Error::Server(error.to_string()))?;
        let client = runtime.block_on(host.operator())?;
        Ok(Self {
            runtime,
            client,
            address: host.brains().to_owned(),
            name: name.to_owned(),
            brain_timeout,
            private: host.private(),
            idle: Cell::default(),
            unchecked: RefCell::default(),
        })
    }

    /// Does a run in a world of its own, which is there only for it. One in [`CHECKED`] of the runs that a process does after
    /// others is done again by a new one.
    ///
    /// # Errors
    /// If the server has failed, or a process that has done other runs does not do this one as a new one does it.
    pub(crate) fn run(&self, experiment: &Experiment, task: &Task) -> Result<Row, Error> {
        let row = |outcome| Ok(Row { run: task.run, outcome });
        let Done { ran, earlier_runs } = match self.once(experiment, task, experiment.lifetime)? {
            Ok(done) => done,
            Err(problem) => return row(Err(problem)),
        };
        if earlier_runs % CHECKED == 1 {
            self.check(experiment, task, &ran)?;
        }
        let is_unchecked = earlier_runs > 0 && earlier_runs % CHECKED != 1;
        *self.unchecked.borrow_mut() = is_unchecked.then(|| (task.clone(), ran.clone()));
        row(Ok(ran))
    }

    /// There are no more runs: what a process may have gathered in all of them shows in the last.
    ///
    /// # Errors
    /// If a new process does that run in another way.
    pub(crate) fn check_last(&self, experiment: &Experiment) -> Result<(), Error> {
        let last = self.unchecked.borrow_mut().take();
        last.map_or(Ok(()), |(task, ran)| self.check(experiment, &task, &ran))
    }

    /// Does a run again by a new process.
    fn check(&self, experiment: &Experiment, task: &Task, ran: &Ran) -> Result<(), Error> {
        let again = self.once(experiment, task, Lifetime::Run)?.map(|done| done.ran);
        if again.as_ref() == Ok(ran) { Ok(()) } else { Err(differs(task, ran, &again)) }
    }

    /// Does a run, or returns the reason why it could not be done.
    fn once(
        &self,
        experiment: &Experiment,
        task: &Task,
        lifetime: Lifetime,
    ) -> Result<Result<Done, RunError>, Error> {
        match self.runtime.block_on(self.world(experiment, task, lifetime)) {
            Ok(done) => Ok(Ok(done)),
            // A table has a line for it.
            Err(Failure::Run(problem)) => Ok(Err(RunError::new(problem.replace('\n', " | ")))),
            Err(Failure::Server(error)) => Err(error),
        }
    }

    /// Does a run in a world that is there, and stands until its brains hold their robots. It is given up, and its programs
    /// are ended, once `stop` is ready.
    pub(crate) fn run_world(&self, world: &str, setup: Setup, stop: impl Future) -> Result<(), Error> {
        let mut control = self.control();
        let driven = self.runtime.block_on(async {
            tokio::select! {
                driven = self.drive(&mut control, world, setup) => driven.map(|_| ()),
                _ = stop => Ok(()),
            }
        });
        driven.map_err(|failure| match failure {
            Failure::Run(problem) => Error::Refused(problem),
            Failure::Server(error) => error,
        })
    }

    fn control(&self) -> ControlServiceClient<Channel> {
        ControlServiceClient::new(self.client.channel()).max_decoding_message_size(MAX_MESSAGE_BYTES)
    }

    async fn world(&self, experiment: &Experiment, task: &Task, lifetime: Lifetime) -> Result<Done, Failure> {
        // The errors of the run are reported here, in the same words as for one in this process.
        let mut setup = Setup::new(experiment, task).map_err(|error| Failure::Run(error.to_string()))?;
        if let Some(task) = setup.assigned.at_ports.first() {
            return Err(Failure::Run(format!(
                "`{PROGRAM}{}` runs in simulated time, on the thread of its world, not with a server or with brains that attach to one",
                task.program
            )));
        }
        setup.assigned.programs.iter_mut().for_each(|task| task.lifetime = lifetime);
        let mut control = self.control();
        let world = format!("{}-{}", self.name, task.run);
        let server = self.private.as_ref().filter(|_| experiment.is_observed()).and_then(Weak::upgrade);
        let observed = match server {
            Some(server) => {
                let made = ObservedWorld::create(&server, &world, setup.scenario.clone(), experiment);
                Some(made.map_err(|status| Failure::of(&status))?)
            }
            None => {
                create(&mut control, experiment, task, &world).await?;
                None
            }
        };
        let ran = self.drive(&mut control, &world, setup).await;
        let deleted = control.delete_world(v1::DeleteWorldRequest { world }).await;
        let mut done = ran?;
        deleted.map_err(|status| Failure::of(&status))?;
        if let Some(observed) = observed {
            done.ran = observed.tell(done.ran).map_err(|error| Failure::Run(error.to_string()))?;
        }
        Ok(done)
    }

    async fn drive(
        &self,
        control: &mut ControlServiceClient<Channel>,
        world: &str,
        setup: Setup,
    ) -> Result<Done, Failure> {
        let (seed, wanted) = (setup.scenario.seed, setup.assigned.clone());
        let attached = self.attach(world, setup.assigned.brains, seed).await?;
        let programs = &setup.assigned.programs;
        let mut crew = self
            .with_idle(async |idle| Crew::start_or_reuse(programs, idle, &self.address, world, seed).await)
            .await?;
        crew.attached(START_PATIENCE, async || held(control, world, &wanted).await).await?;
        let start = v1::StartWorldRequest { world: world.to_owned() };
        control.start_world(start).await.map_err(|status| Failure::of(&status))?;
        let mut driving = tokio::task::JoinSet::new();
        for mut brains in attached {
            // Brains hold their robots until all is over.
            driving.spawn(async move { brains.run().await.map(|_| brains) });
        }
        let (mut over, looks) = (control.clone(), control.clone());
        // A world whose program has gone waits for brains; that the program has gone is soon known.
        let may_wait = !setup.assigned.programs.is_empty();
        let status = tokio::select! {
            biased;
            status = async {
                for driven in driving.join_all().await {
                    driven.map_err(Failure::of_client)?;
                }
                ended(&mut over, world, may_wait).await
            } => status?,
            failure = crew.failed() => {
                let status = status_of(control, world).await?;
                // A program ends with its run, and may be quicker than the look at the world.
                if status.state() != v1::WorldState::Ended {
                    return Err(failure.into());
                }
                status
            }
            failure = silence(looks, world, self.brain_timeout.filter(|_| may_wait)) => return Err(failure),
        };
        let earlier_runs = crew.earlier_runs();
        self.with_idle(async |idle| crew.release(idle).await).await?;
        Ok(Done { ran: Ran::of(&status), earlier_runs })
    }

    async fn attach(
        &self,
        world: &str,
        assignments: Vec<Assignment>,
        seed: u64,
    ) -> Result<Vec<AttachedBrains>, Failure> {
        let mut attached = Vec::new();
        for assignment in assignments {
            let brains = AttachedBrains::attach(self.client.clone(), world, assignment, seed).await;
            attached.push(brains.map_err(Failure::of_attach)?);
        }
        Ok(attached)
    }

    async fn with_idle<T>(&self, act: impl AsyncFnOnce(&mut Idle) -> Result<T, Broken>) -> Result<T, Broken> {
        let mut idle = self.idle.take();
        let done = act(&mut idle).await;
        self.idle.set(idle);
        done
    }
}

/// The error that a process keeps something from run to run.
fn differs(task: &Task, ran: &Ran, again: &Result<Ran, RunError>) -> Error {
    let again = match again {
        Ok(again) => format!("ends with the state {:016x}", again.hash),
        Err(problem) => format!("fails: {problem}"),
    };
    Error::Refused(format!(
        "run {} with seed {} ends with the state {:016x}; done again by a new process it {again}. The program keeps state \
         from one run to the next: begin each run afresh, or leave out `reuse = true`; do the sweep again with --fresh",
        task.run, task.seed, ran.hash
    ))
}

impl Drop for Remote {
    fn drop(&mut self) {
        self.runtime.block_on(self.idle.take().end());
    }
}

/// Makes the world of a task, in lockstep, which stands until its brains are there. One of that name is of this sweep
/// before it was killed: its id is known to no other.
async fn create(
    control: &mut ControlServiceClient<Channel>,
    experiment: &Experiment,
    task: &Task,
    world: &str,
) -> Result<(), Failure> {
    let mut overrides = setup::overrides(experiment, setup::settings(task));
    overrides.push(format!("seed={}", task.seed));
    let request = v1::CreateWorldRequest {
        world: world.to_owned(),
        scenario_toml: experiment.text.clone(),
        overrides,
        pace: Some(v1::Pace { kind: Some(v1::pace::Kind::Lockstep(v1::Lockstep::default())) }),
        paused: true,
        saved_mcap: Vec::new(),
    };
    let mut answer = control.create_world(request.clone()).await;
    if answer.as_ref().is_err_and(|status| status.code() == Code::AlreadyExists) {
        let delete = v1::DeleteWorldRequest { world: world.to_owned() };
        control.delete_world(delete).await.map_err(|status| Failure::of(&status))?;
        answer = control.create_world(request).await;
    }
    answer.map(|_| ()).map_err(|status| Failure::of(&status))
}

/// Waits for the end of the run, which no stream reports if the run has no brains of this process.
async fn ended(
    control: &mut ControlServiceClient<Channel>,
    world: &str,
    may_wait: bool,
) -> Result<v1::WorldStatus, Failure> {
    let mut pause = Duration::from_millis(1);
    loop {
        let status = status_of(control, world).await?;
        match status.state() {
            v1::WorldState::Ended => return Ok(status),
            v1::WorldState::Running => {}
            v1::WorldState::WaitingForBrains if may_wait => {}
            v1::WorldState::Unspecified | v1::WorldState::WaitingForBrains | v1::WorldState::Paused => {
                return Err(Failure::Server(Error::Server(format!(
                    "world `{world}` was stopped on the server"
                ))));
            }
        }
        tokio::time::sleep(pause).await;
        pause = (2 * pause).min(LONGEST_PAUSE);
    }
}

/// Waits until a world has not gone on for as long as its brains have to answer.
async fn silence(
    mut control: ControlServiceClient<Channel>,
    world: &str,
    limit: Option<Duration>,
) -> Failure {
    let Some(limit) = limit else { return std::future::pending().await };
    let (mut tick, mut since) = (0, Instant::now());
    loop {
        tokio::time::sleep(limit.min(SILENCE_LOOK)).await;
        let status = match status_of(&mut control, world).await {
            Ok(status) => status,
            Err(failure) => return failure,
        };
        if status.tick != tick {
            (tick, since) = (status.tick, Instant::now());
        } else if since.elapsed() >= limit {
            return Failure::Run(format!(
                "at t = {} s no answer of a brain has come within the {} s of --brain-timeout; look for an endless loop, or for a wait that \
                 never ends",
                status.time_ns as f64 / 1e9,
                limit.as_secs_f64()
            ));
        }
    }
}

async fn status_of(
    control: &mut ControlServiceClient<Channel>,
    world: &str,
) -> Result<v1::WorldStatus, Failure> {
    let answer = control.get_world(v1::GetWorldRequest { world: world.to_owned() }).await;
    Ok(answer.map_err(|status| Failure::of(&status))?.into_inner().status.unwrap_or_default())
}

/// The robots that are held.
async fn held(
    control: &mut ControlServiceClient<Channel>,
    world: &str,
    wanted: &Assigned,
) -> Result<Vec<Held>, Failure> {
    Ok(wanted.held(&status_of(control, world).await?))
}

/// Worlds are described in messages that are about as long as their scenarios, which may have 16 MiB.
const MAX_MESSAGE_BYTES: usize = 64 << 20;

/// One in so many runs of a process that has done others is done again by a new process, the first of them and the last, too.
const CHECKED: u64 = 20;

/// The interval at which it is checked whether a world goes on.
const SILENCE_LOOK: Duration = Duration::from_millis(500);

const LONGEST_PAUSE: Duration = Duration::from_millis(100);
