//! A server's life: it starts with what the last one has left, does what it is asked, and something befalls it, until it is killed.

use std::collections::BTreeMap;
use std::ops::AddAssign;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Builder, Found, Server, StateFolder, WorldConfig};
use tokio::time::{advance, sleep};
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::Channel;

use super::disk::{Disk, Mounted};
use super::model::{End, Model, Unsure, Within};
use super::tokens::Tokens;
use super::trace::Trace;
use crate::chance::Chance;
use crate::link::{Loss, Network};

/// The coverage of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// Requests that were answered.
    pub(crate) deeds: u64,
    pub(crate) unanswered: u64,
    pub(crate) refused: u64,
    pub(crate) kills: u64,
    pub(crate) power_cuts: u64,
    pub(crate) faults: u64,
}

/// A run of servers on one simulated disk, one after the other.
pub(crate) struct Run {
    seed: u64,
    pub(crate) chance: Chance,
    disk: Disk,
    pub(crate) model: Model,
    pub(crate) tokens: Option<Tokens>,
    pub(crate) trace: Trace,
    /// The time at which the present server has begun.
    began: Duration,
    is_full: bool,
    /// The time at which the disk was last checked for failures.
    looked: Duration,
    pub(crate) seen: Seen,
    /// Worlds that were made.
    pub(crate) made: u64,
}

/// The present server, as the operator reaches it.
pub(crate) struct Life {
    pub(crate) network: Network,
    pub(crate) mounted: Mounted,
    pub(crate) control: Option<ControlServiceClient<Channel>>,
}

/// The end of a server's life.
pub(crate) struct Dead;

impl Run {
    pub(crate) fn new(seed: u64, trace: Trace) -> Self {
        Self {
            seed,
            chance: Chance::of(seed, "operator of worlds that are kept"),
            disk: Disk::new(seed, trace.clone()),
            model: Model::default(),
            tokens: seed.is_multiple_of(4).then(Tokens::new),
            trace,
            began: Duration::ZERO,
            is_full: false,
            looked: Duration::ZERO,
            seen: Seen::default(),
            made: 0,
        }
    }

    /// The number of servers to come.
    pub(crate) fn lives(&mut self) -> u64 {
        2 + self.chance.below(3)
    }

    pub(crate) fn seen(&self) -> Seen {
        self.seen
    }

    pub(crate) fn now(&self) -> Duration {
        self.trace.now()
    }

    /// A server's life.
    pub(crate) async fn live(&mut self, number: u64) {
        self.began = self.now();
        let mounted = self.disk.mount();
        self.trace.note("a server starts");
        if self.chance.one_in(4) {
            // The server may die before its first answer.
            self.disk.kill_in(self.chance.below(20));
        }
        let (network, incoming) = Network::new(self.seed ^ (number << 40));
        let mut life = Life { network, mounted, control: None };
        if let Ok(builder) = self.builder(&life) {
            let builder = builder.incoming(UnboundedReceiverStream::new(incoming));
            let server = builder.in_process().await.unwrap();
            // Dying is what it is about.
            let _ = self.serve(&mut life).await;
            self.end(&life);
            drop(server);
        } else {
            self.end(&life);
        }
    }

    /// A server with the worlds that are there.
    fn builder(&self, life: &Life) -> Result<Builder, Dead> {
        let folder = StateFolder::simulated(Path::new("/srv/lab"), Arc::new(life.mounted.clone()));
        let worlds = folder.and_then(|folder| Ok((folder.worlds()?, folder)));
        let (found, folder) = match worlds {
            Ok(found) => found,
            Err(_) if !life.mounted.is_alive() => return Err(Dead),
            Err(error) => panic!("{error}"),
        };
        let mut builder = Server::builder().without_threads();
        for found in found {
            match found {
                Found::World(world) => {
                    self.trace.note(format!(
                        "  `{}` continues at tick {} {}",
                        world.name,
                        world.tick,
                        world.note.as_deref().unwrap_or_default()
                    ));
                    builder = builder.world(WorldConfig::kept(*world));
                }
                _ if !life.mounted.is_alive() => return Err(Dead),
                Found::SetAside { name, file, problem, .. } => self.check_set_aside(&name, &file, &problem),
                Found::Unreadable { name, problem, .. } => panic!("{name}: {problem}"),
                Found::Ignored { path, problem } => panic!("{} {problem}", path.display()),
            }
        }
        if !life.mounted.is_alive() {
            return Err(Dead);
        }
        let builder = builder.state(folder);
        Ok(match &self.tokens {
            Some(tokens) => builder.tokens(tokens.file.clone()),
            None => builder,
        })
    }

    /// Only a world that was not on the disk when the power failed may be set aside, and the model knows whether it
    /// was.
    fn check_set_aside(&self, name: &str, file: &Path, problem: &str) {
        let what = format!("{name}: {} {problem}", file.display());
        self.trace.note(format!("  set aside: {what}"));
        let is_begun = ["first state", "first line", "beginning", "no journal"];
        assert!(is_begun.iter().any(|words| problem.contains(words)), "{what}");
        // A server that is killed while a world begins to be kept again has written its snapshots, and no journal yet.
        assert!(self.model.has_lost_power() || problem.contains("no journal"), "{what}");
    }

    async fn serve(&mut self, life: &mut Life) -> Result<(), Dead> {
        if self.model.has_ended() {
            self.compare(life).await?;
        }
        if self.chance.one_in(2) {
            self.disk.kill_in(self.chance.below(100));
        }
        for _ in 0..5 + self.chance.below(25) {
            if !life.mounted.is_alive() {
                return Err(Dead);
            }
            self.deed(life).await?;
            self.befall(life).await;
        }
        Ok(())
    }

    /// The server dies in a write, or the power fails, or both at once. A program that is killed writes nothing more;
    /// the rest of it goes with the runtime.
    fn end(&mut self, life: &Life) {
        let loses_power = if life.mounted.is_alive() { self.chance.one_in(2) } else { self.chance.one_in(4) };
        let died = self.disk.kill();
        self.note_faults();
        self.model.fault_ends(self.now());
        self.is_full = false;
        let end = if loses_power { End::PowerLost } else { End::Killed };
        match end {
            End::Killed => {
                self.trace.note("the server is killed");
                self.seen.kills += 1;
            }
            End::PowerLost => {
                self.disk.lose_power();
                self.seen.power_cuts += 1;
            }
        }
        self.model.ended(self.began, died, end);
    }

    /// Compares the worlds of a server that has started again.
    async fn compare(&mut self, life: &mut Life) -> Result<(), Dead> {
        let answer = loop {
            let request = self.request(v1::ListWorldsRequest {});
            let answer = self.control(life).await.list_worlds(request).await;
            if !life.mounted.is_alive() {
                return Err(Dead);
            }
            match answer {
                Ok(answer) => break answer.into_inner(),
                Err(status) => self.lost(life, &status).await,
            }
        };
        let found: BTreeMap<_, _> =
            answer.worlds.into_iter().map(|status| (status.world.clone(), status)).collect();
        self.trace.note(format!("  expected:\n{}", self.model.expected()));
        let within = self.model.check(&found, self.now());
        for world in self.model.there() {
            // The operator that made the world may have been killed before it was started.
            let request = self.request(v1::StartWorldRequest { world: world.clone() });
            let answer = self.control(life).await.start_world(request).await;
            let answer = answer.map(|answer| answer.into_inner().status);
            self.done(life, &world, answer, Unsure::Any).await?;
        }
        for Within { world, ticks, hash } in within {
            let request = self.request(v1::StepWorldRequest { world: world.clone(), ticks });
            let answer = self.control(life).await.step_world(request).await;
            if let Ok(answer) = &answer {
                let status = answer.get_ref().status.as_ref().unwrap();
                assert_eq!(status.state_hash, hash, "`{world}` at tick {} goes elsewhere", status.tick);
            }
            let answer = answer.map(|answer| answer.into_inner().status);
            self.done(life, &world, answer, Unsure::Ticks(ticks)).await?;
        }
        Ok(())
    }

    /// The faults of the network, the disk and the clock.
    async fn befall(&mut self, life: &Life) {
        self.catch_up().await;
        match self.chance.below(26) {
            0 => life.network.cut("operator", self.chance.ms(10, 3000)),
            1 => life.network.lose("operator", Loss::Reset),
            2 => life.network.lose("operator", Loss::ServerGone),
            3 if !self.is_full => {
                self.trace.note("the disk is full");
                self.disk.set_full(true);
                self.model.fault_begins(self.now());
                self.is_full = true;
                self.seen.faults += 1;
            }
            3 | 4 if std::mem::take(&mut self.is_full) => {
                self.disk.set_stalls(false);
                self.catch_up().await;
                self.trace.note("the disk is not full any more, and does not stall");
                self.disk.set_full(false);
                self.model.fault_ends(self.now());
            }
            5 => {
                let stalls = self.chance.one_in(2);
                self.trace.note(if stalls { "the disk stalls" } else { "the disk does not stall" });
                self.disk.set_stalls(stalls);
            }
            6 => {
                self.trace.note("the disk is going to fail");
                self.disk.fail_in(self.chance.below(12));
            }
            // A machine was asleep.
            7 => {
                let asleep = self.chance.ms(1000, 3_600_000);
                self.jump(asleep).await;
            }
            8..14 => sleep(self.chance.ms(1, 8000)).await,
            _ => {}
        }
        self.catch_up().await;
        self.note_faults();
    }

    /// The clock of the runtime goes on by the time that the disk has taken, and what was due meanwhile is done, which may take time
    /// again. Worlds that cannot be kept may want more of a disk that is slow than it can give.
    async fn catch_up(&self) {
        for _ in 0..8 {
            let stalled = self.disk.stalled();
            if stalled.is_zero() {
                return sleep(Duration::from_millis(1)).await;
            }
            self.jump(stalled).await;
        }
    }

    async fn jump(&self, by: Duration) {
        self.trace.jump(by);
        advance(by).await;
        sleep(Duration::from_millis(1)).await;
    }

    /// If the disk has failed, it was between the last time that this was asked and now.
    fn note_faults(&mut self) {
        if self.disk.has_failed() {
            self.model.fault(self.looked, self.now());
            self.seen.faults += 1;
        }
        self.looked = self.now();
    }
}

impl AddAssign for Seen {
    fn add_assign(&mut self, other: Self) {
        self.deeds += other.deeds;
        self.unanswered += other.unanswered;
        self.refused += other.refused;
        self.kills += other.kills;
        self.power_cuts += other.power_cuts;
        self.faults += other.faults;
    }
}
