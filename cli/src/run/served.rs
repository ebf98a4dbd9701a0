//! A run over gRPC: a server in this process, and brains that attach to it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use baudbot_access::private_folder;
use baudbot_client::Channel;
use baudbot_client::Client;
use baudbot_plot::quantity::count;
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_run::AttachedBrains;
use baudbot_run::assignment::START_PATIENCE;
use baudbot_run::programs::{Crew, Held, ProcessorClock};
use baudbot_server::{Address, OnTick, Pace, ProcessorTime, Progress, Server, WorldConfig};
use indicatif::ProgressBar;
use tempfile::TempDir;
use tokio::task::JoinSet;

use super::{Outside, Plan, progress};
use crate::args::{DEFAULT_ADDRESS, RunArgs};
use crate::error::{from_builder, from_server};
use crate::text::tell;
use crate::{assignment, connect, record, viewer};

/// Lets brains drive their robots until the run is over, and returns the state of the world then.
pub(super) async fn run(
    plan: &Plan,
    on_tick: Option<OnTick>,
    outside: &mut Outside<'_>,
) -> anyhow::Result<v1::WorldStatus> {
    let progress = Arc::new(Progress::default());
    let private = Private::new(plan)?;
    let mut world = plan.world(outside, on_tick).progress(Arc::clone(&progress));
    if let Some(private) = &private {
        world = world.processor_time(private.processor_time(plan));
    }
    let server = serve(outside.args, plan, world, private.as_ref()).await?;
    let status = Running { plan, server: &server, private, progress, outside }.until_over().await;
    if tokio::time::timeout(PATIENCE, server.shutdown()).await.is_err() {
        tell!("note: a client kept its connection open; it was closed");
    }
    status
}

async fn serve(
    args: &RunArgs,
    plan: &Plan,
    world: WorldConfig,
    private: Option<&Private>,
) -> anyhow::Result<Server> {
    let mut builder = args.listen.builder()?.world(world);
    let default = args.external.filter(|_| args.listen.listen.is_empty()).map(|_| DEFAULT_ADDRESS.parse());
    for address in args.listen.listen.iter().cloned().chain(default.transpose()?) {
        builder = builder.listen(address);
    }
    if let Some(private) = private {
        builder = builder.brains(private.address.clone());
    }
    // A run that is over in a moment has no time for a viewer.
    builder = viewer::add(builder, args.listen.viewer, matches!(plan.pace, Pace::Timed(_)));
    let server = builder.serve().await.map_err(from_builder)?;
    if !args.quiet {
        server.addresses().iter().for_each(|address| tell!("listening on {address}"));
        viewer::link(&server).iter().for_each(|link| tell!("{link}"));
    }
    Ok(server)
}

/// The socket at which the programs of a run attach, and can do nothing else: it is in a folder that only this user
/// may enter.
struct Private {
    address: Address,
    /// The processor time of the brains' programs.
    clock: ProcessorClock,
    _folder: TempDir,
}

impl Private {
    /// None if there are no programs.
    fn new(plan: &Plan) -> anyhow::Result<Option<Self>> {
        if plan.assigned.programs.is_empty() {
            return Ok(None);
        }
        let folder = private_folder().context("cannot make a folder for the socket of programs")?;
        let address = Address::Unix(folder.path().join("socket"));
        Ok(Some(Self { address, clock: ProcessorClock::default(), _folder: folder }))
    }

    fn processor_time(&self, plan: &Plan) -> ProcessorTime {
        let (clock, scenario) = (self.clock.clone(), Arc::clone(&plan.scenario));
        Arc::new(move |robot| clock.read(&scenario.robots.get(robot)?.name))
    }
}

struct Running<'a, 'b> {
    plan: &'a Plan,
    server: &'a Server,
    private: Option<Private>,
    progress: Arc<Progress>,
    outside: &'a mut Outside<'b>,
}

impl Running<'_, '_> {
    async fn until_over(&mut self) -> anyhow::Result<v1::WorldStatus> {
        let channel = Channel::from(self.server.channel().await?);
        let mut control = connect::control(channel.clone());
        let mut brains = JoinSet::new();
        for assignment in &self.plan.assigned.brains {
            let client = record::publishing(Client::from_channel(channel.clone()), self.plan.frame);
            let Plan { world, seed, .. } = self.plan;
            let attached = AttachedBrains::attach(client, world, assignment.clone(), *seed).await;
            // The brains hold their robots until all is over.
            brains.spawn(assignment::drive(attached.map_err(assignment::refused)?));
        }
        let mut crew = self.crew(&mut control).await?;
        self.external(&mut control).await?;
        if !self.outside.interrupted {
            let request = v1::StartWorldRequest { world: self.plan.world.clone() };
            control.start_world(request).await.map_err(|status| from_server(&status))?;
        }
        let bar = progress(self.plan.ticks(), self.outside.args.quiet || self.outside.args.show_output);
        // A finished brain holds its robots, too, until the status is there: its last words go with it.
        let mut done = Vec::new();
        let waited = self.wait(&mut brains, &mut done, &mut crew, &bar).await;
        bar.finish_and_clear();
        waited?;
        let status = self.pause(control).await?;
        if self.outside.interrupted {
            crew.stop().await;
        } else {
            let printed = crew.end().await?;
            self.outside.unseen_lines = if self.outside.args.show_output { 0 } else { printed };
        }
        if status.recording.is_none() {
            return Ok(status);
        }
        // A tick that was under way may have ended since the pause: the summary is of the recording's end.
        let closed = self.server.stop_recording(&self.plan.world).await;
        closed.map_err(|status| from_server(&status))
    }

    /// The programs, which hold their robots.
    async fn crew(&mut self, control: &mut ControlServiceClient<Channel>) -> anyhow::Result<Crew> {
        let Some(private) = &self.private else { return Ok(Crew::default()) };
        let Plan { assigned, world, seed, .. } = self.plan;
        let crew = Crew::start(&assigned.programs, &private.address.to_string(), world, *seed)?;
        let mut crew = crew.timed_by(private.clock.clone());
        tokio::select! {
            attached = crew.attached(START_PATIENCE, async || held(self.plan, control).await) => attached?,
            () = self.outside.stop.wait() => self.outside.interrupted = true,
        }
        Ok(crew)
    }

    /// Waits until programs from elsewhere hold as many robots as `--external` asks for.
    async fn external(&mut self, control: &mut ControlServiceClient<Channel>) -> anyhow::Result<()> {
        let Some(wanted) = self.outside.args.external else { return Ok(()) };
        if !self.outside.args.quiet {
            tell!("waiting for programs to attach to {}", count(wanted.into(), "robot"));
        }
        let mut look = tokio::time::interval(LOOK);
        while !self.outside.interrupted {
            let robots = held(self.plan, control).await?;
            if robots.iter().filter(|robot| robot.held && !robot.expected).count() >= wanted.into() {
                break;
            }
            tokio::select! {
                _ = look.tick() => {}
                () = self.outside.stop.wait() => self.outside.interrupted = true,
            }
        }
        Ok(())
    }

    /// The world's last state; a run that has ended is not changed by a pause.
    async fn pause(&self, mut control: ControlServiceClient<Channel>) -> anyhow::Result<v1::WorldStatus> {
        let request = v1::PauseWorldRequest { world: self.plan.world.clone() };
        let answer = control.pause_world(request).await.map_err(|status| from_server(&status))?;
        answer.into_inner().status.ok_or_else(|| anyhow!("the server answered without a status"))
    }

    async fn wait(
        &mut self,
        brains: &mut JoinSet<anyhow::Result<AttachedBrains>>,
        done: &mut Vec<AttachedBrains>,
        crew: &mut Crew,
        bar: &ProgressBar,
    ) -> anyhow::Result<()> {
        let mut redraw = tokio::time::interval(REDRAW);
        let mut silence = Silence::new(self.plan, self.outside.args);
        // The report of a failure takes a moment: one that has begun is not begun again at each redraw.
        let failed = crew.failed();
        tokio::pin!(failed);
        while !self.outside.interrupted {
            tokio::select! {
                // The run is over when its world is, because an operator deleted it.
                () = self.progress.ended() => return Ok(()),
                () = self.outside.stop.wait() => {
                    self.outside.interrupted = true;
                    return Ok(());
                }
                error = self.outside.files.failure() => return Err(error),
                failure = &mut failed => {
                    // A program ends with its run, and may be quicker than the news of it.
                    let over = tokio::time::timeout(NEWS, self.progress.ended()).await;
                    return over.map_err(|_| failure.into());
                }
                Some(brain) = brains.join_next() => done.push(brain.context("a brain panicked")??),
                _ = redraw.tick() => {
                    let tick = self.progress.tick();
                    bar.set_position(tick);
                    match silence.look(tick, Instant::now()) {
                        Silent::No => {}
                        Silent::Tell(time_s) => bar.suspend(|| tell!("note: at t = {time_s} s no answer of a brain has come; {ADVICE}; Ctrl-C ends the run, and --brain-timeout S would")),
                        Silent::End(time_s, limit_s) => {
                            return Err(anyhow!("at t = {time_s} s no answer of a brain has come within the {limit_s} s of --brain-timeout; {ADVICE}"));
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The robots of the world, each held or not.
async fn held(plan: &Plan, control: &mut ControlServiceClient<Channel>) -> anyhow::Result<Vec<Held>> {
    let request = v1::GetWorldRequest { world: plan.world.clone() };
    let answer = control.get_world(request).await.map_err(|status| from_server(&status))?;
    Ok(plan.assigned.held(&answer.into_inner().status.unwrap_or_default()))
}

/// The advice if nothing goes on. Grading uses the same words.
const ADVICE: &str = "look for an endless loop, or for a wait that never ends";

/// The watch on a world that waits for its brains: whether it goes on.
struct Silence {
    /// The tick that was seen last, and since when.
    last: Option<(u64, Instant)>,
    step_s: f64,
    /// Whether it is to be ended, and after how long.
    limit: Option<Duration>,
    /// Whether a message may be printed, as there was none yet.
    tells: bool,
}

/// The case of brains that do not answer, with the time of the world.
#[derive(Debug, PartialEq)]
enum Silent {
    No,
    Tell(f64),
    /// The run has to end, and after how many seconds that was to be.
    End(f64, f64),
}

impl Silence {
    fn new(plan: &Plan, args: &RunArgs) -> Self {
        // A world under a debugger stands for as long as its user thinks.
        let waits = matches!(plan.pace, Pace::Lockstep(_)) && args.chips.gdb.is_empty();
        let limit = args.brain_timeout.filter(|_| waits).map(Duration::from_secs_f64);
        Self { last: None, step_s: plan.scenario.step_ns as f64 / 1e9, limit, tells: waits && !args.quiet }
    }

    fn look(&mut self, tick: u64, now: Instant) -> Silent {
        let since = match self.last {
            Some((last, since)) if last == tick => since,
            Some(_) | None => {
                self.last = Some((tick, now));
                return Silent::No;
            }
        };
        let (silent, time_s) = (now.saturating_duration_since(since), tick as f64 * self.step_s);
        match self.limit {
            Some(limit) if silent >= limit => Silent::End(time_s, limit.as_secs_f64()),
            Some(_) => Silent::No,
            None if self.tells && silent >= TOLD_AFTER => {
                // Once is enough: the log goes on about it.
                self.tells = false;
                Silent::Tell(time_s)
            }
            None => Silent::No,
        }
    }
}

/// The wait of the watchdog before its message in the log.
const TOLD_AFTER: Duration = Duration::from_secs(10);

/// The interval at which the holders of robots are looked up.
const LOOK: Duration = Duration::from_millis(20);

const REDRAW: Duration = Duration::from_millis(100);

/// The time that the news of a run's end may take within this process.
const NEWS: Duration = Duration::from_millis(200);

/// The time that connections have to close.
const PATIENCE: Duration = Duration::from_secs(3);

#[cfg(test)]
mod tests {
    use super::*;

    fn silence(limit_s: Option<u64>) -> Silence {
        Silence { last: None, step_s: 0.01, limit: limit_s.map(Duration::from_secs), tells: true }
    }

    #[test]
    fn a_world_that_does_not_go_on_is_told_of_once() {
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let mut silence = silence(None);
        for (seconds, tick, expected) in [
            (0, 7, Silent::No),
            (9, 7, Silent::No),
            (10, 7, Silent::Tell(0.07)),
            (50, 7, Silent::No),
            (51, 8, Silent::No),
        ] {
            assert_eq!(silence.look(tick, at(seconds)), expected, "{seconds}");
        }
    }

    #[test]
    fn a_limit_ends_it() {
        let start = Instant::now();
        let mut silence = silence(Some(3));
        assert_eq!(silence.look(0, start), Silent::No);
        assert_eq!(silence.look(1, start + Duration::from_secs(5)), Silent::No, "it goes on");
        assert_eq!(silence.look(1, start + Duration::from_secs(8)), Silent::End(0.01, 3.0));
    }
}
