//! The parties at the network: brains, observers, an operator, strangers, and the faults that befall them.

use std::time::Duration;

use baudbot_client::{Client, Robot};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::watch;
use tokio::time::{sleep, timeout};
use tonic::Status;
use tonic::transport::{Channel, Endpoint, Error};

use super::chance::Chance;
use super::judge::{Judge, TICKS, act};
use super::link::{Loss, Network};

/// The state that all of them share.
#[derive(Clone)]
pub(crate) struct Stage {
    pub(crate) seed: u64,
    pub(crate) network: Network,
    pub(crate) judge: Judge,
    pub(crate) kind: Kind,
    /// Whether the run is over.
    pub(crate) over: watch::Receiver<bool>,
}

/// The kind of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    /// Brains lose their connections, and others take their place. The operator then does not start the world, as that means not to
    /// wait for a brain that is gone.
    pub(crate) loses_brains: bool,
    /// The world ends ticks ahead of its brains. With another brain it could be another run, so none is lost.
    pub(crate) goes_ahead: bool,
    /// The operator steps the world.
    pub(crate) is_stepped: bool,
    /// The world has an observer; it then does not go ahead.
    pub(crate) is_watched: bool,
}

impl Kind {
    pub(crate) fn of(seed: u64) -> Self {
        let mut chance = Chance::of(seed, "kind");
        let loses_brains = !chance.one_in(4);
        let goes_ahead = !loses_brains && !chance.one_in(4);
        let is_stepped = !goes_ahead && chance.one_in(3);
        Self { loses_brains, goes_ahead, is_stepped, is_watched: !goes_ahead || chance.one_in(4) }
    }
}

/// The interval of the client in Rust.
const KEEPALIVE: Duration = Duration::from_secs(20);

impl Stage {
    pub(crate) fn chance(&self, of: &str) -> Chance {
        Chance::of(self.seed, of)
    }

    async fn channel(&self, host: &str) -> Result<Channel, Error> {
        channel(&self.network, host).await
    }

    /// Does this until the run is over.
    pub(crate) async fn until_over(mut self, work: impl Future<Output = ()>) {
        tokio::select! {
            biased;
            _ = self.over.wait_for(|over| *over) => {}
            () = work => {}
        }
    }
}

/// A connection of a host to the server.
pub(crate) async fn channel(network: &Network, host: &str) -> Result<Channel, Error> {
    let (network, host) = (network.clone(), host.to_owned());
    let connector = tower::service_fn(move |_| {
        let (network, host) = (network.clone(), host.clone());
        async move { network.connect(&host).await.map(TokioIo::new) }
    });
    Endpoint::from_static("http://server")
        .http2_keep_alive_interval(KEEPALIVE)
        .keep_alive_timeout(KEEPALIVE)
        .connect_timeout(Duration::from_secs(5))
        .connect_with_connector(connector)
        .await
}

fn client(stage: &Stage, channel: Channel) -> Client {
    let client = Client::from_channel(channel);
    if stage.kind.goes_ahead { client.thinks_as_scenario() } else { client }
}

/// A brain that comes back.
pub(crate) async fn brain(stage: Stage, robot: &'static str) {
    let mut chance = stage.chance(&format!("brain {robot}"));
    loop {
        let attached = match stage.channel(robot).await {
            Ok(channel) => client(&stage, channel).brain(robot).attach("w", robot).await.ok(),
            Err(_) => None,
        };
        if let Some(mut attached) = attached {
            drive(&stage, &mut attached, &mut chance).await;
            if !stage.kind.loses_brains {
                stage.judge.forgive();
            }
        }
        sleep(chance.ms(20, 3000)).await;
    }
}

/// Drives until the connection is lost, or the brain has had enough.
async fn drive(stage: &Stage, robot: &mut Robot, chance: &mut Chance) {
    loop {
        let turn = match robot.turn().await {
            Ok(Some(turn)) => turn,
            Ok(None) if !robot.is_closed() => continue,
            Ok(None) | Err(_) => return,
        };
        stage.judge.note_turn();
        if chance.one_in(30) {
            sleep(chance.ms(1, 500)).await;
        }
        if stage.kind.loses_brains && chance.one_in(150) {
            return;
        }
        if robot.act(act(&turn)).await.is_err() {
            return;
        }
    }
}

/// An observer of each tick that comes back; now and then it stops reading.
pub(crate) async fn observer(stage: Stage, host: &'static str) {
    let mut chance = stage.chance(host);
    loop {
        if let Ok(channel) = stage.channel(host).await {
            let request = v1::WatchRequest { world: "w".into(), every_ticks: 1, ..Default::default() };
            if let Ok(frames) = ObserveServiceClient::new(channel).watch(request).await {
                let mut frames = frames.into_inner();
                while let Ok(Some(frame)) = frames.message().await {
                    stage.judge.check_frame(&frame);
                    if chance.one_in(80) {
                        sleep(chance.ms(10, 60_000)).await;
                    }
                }
            }
        }
        sleep(chance.ms(20, 5000)).await;
    }
}

/// A client that connects and requests nothing, or sends bytes that are no HTTP/2.
pub(crate) async fn stranger(stage: Stage) {
    let mut chance = stage.chance("stranger");
    loop {
        sleep(chance.ms(100, 10_000)).await;
        let Ok(mut connection) = stage.network.connect("stranger").await else { continue };
        let words: &[u8] = match chance.below(4) {
            0 => b"",
            1 => b"PRI * HTTP/2.0\r\n\r\nSM\r\n",
            2 => b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0\0\0\x64\x01\0\0\0\0\x01",
            _ => b"GET / HTTP/1.1\r\n\r\n",
        };
        let _ = connection.write_all(words).await;
        let mut answer = Vec::new();
        let closed = timeout(Duration::from_secs(120), connection.read_to_end(&mut answer)).await;
        // Nothing befalls this host.
        assert!(closed.is_ok(), "who asks for nothing is not closed: {words:?}");
    }
}

/// The faults of the connections of these hosts, for some minutes.
pub(crate) async fn faults(stage: Stage, brains: &[&str], others: &[&str]) {
    let mut chance = stage.chance("faults");
    for _ in 0..chance.below(40) {
        sleep(chance.ms(20, 3000)).await;
        let is_brain = chance.one_in(2);
        let hosts = if is_brain { brains } else { others };
        let host = hosts[chance.below(hosts.len() as u64) as usize];
        let is_gentle = is_brain && !stage.kind.loses_brains;
        match chance.below(8) {
            0..3 => stage.network.cut(host, chance.ms(10, 8000)),
            3 if is_gentle => stage.network.cut(host, chance.ms(10, 2000)),
            3 => stage.network.cut(host, chance.ms(20_000, 100_000)),
            _ if is_gentle => {}
            4 => stage.network.lose(host, Loss::Reset),
            5 => stage.network.lose(host, Loss::ClientGone),
            6 => stage.network.lose(host, Loss::ServerGone),
            _ => stage.network.lose(host, Loss::Silent),
        }
    }
}

type Control = ControlServiceClient<Channel>;

/// An operator who pauses, starts, steps and resets the world, and goes back to earlier states of it, until it has ended.
pub(crate) struct Operator {
    stage: Stage,
    chance: Chance,
    /// The number of deeds before the world is only run to its end.
    deeds: u64,
    resets: u64,
    snapshot: Option<u64>,
}

impl Operator {
    pub(crate) fn new(stage: Stage) -> Self {
        let mut chance = stage.chance("operator");
        let (deeds, resets) = (chance.below(40), chance.below(3));
        Self { stage, chance, deeds, resets, snapshot: None }
    }

    /// Does so until the run has ended.
    pub(crate) async fn run(mut self) {
        loop {
            if let Ok(channel) = self.stage.channel("operator").await {
                let mut control = ControlServiceClient::new(channel);
                while let Ok(Ok(status)) = timeout(Duration::from_secs(60), self.next(&mut control)).await {
                    self.stage.judge.check_status(&status);
                    if status.tick == TICKS && self.resets == 0 {
                        assert_eq!(status.state(), v1::WorldState::Ended);
                        return;
                    }
                    sleep(self.chance.ms(10, 1500)).await;
                }
            }
            sleep(self.chance.ms(20, 3000)).await;
        }
    }

    /// The next deed, and how the world is after it.
    async fn next(&mut self, control: &mut Control) -> Result<v1::WorldStatus, Status> {
        let world = || "w".to_owned();
        let deed = if self.deeds == 0 { Deed::GoOn } else { *self.chance.one(&Deed::ALL) };
        self.deeds = self.deeds.saturating_sub(1);
        let status = match deed {
            Deed::Pause if !self.stage.kind.loses_brains => {
                control.pause_world(v1::PauseWorldRequest { world: world() }).await?.into_inner().status
            }
            Deed::Snapshot => {
                let answer = control.snapshot_world(v1::SnapshotWorldRequest { world: world() }).await?;
                let v1::SnapshotWorldResponse { snapshot, status } = answer.into_inner();
                self.snapshot = Some(snapshot);
                status
            }
            Deed::Restore if let Some(snapshot) = self.snapshot => {
                let request = v1::RestoreWorldRequest { world: world(), snapshot };
                control.restore_world(request).await?.into_inner().status
            }
            Deed::Reset if self.resets > 0 => self.reset(control).await?,
            Deed::GoOn | Deed::Pause => return self.go_on(control).await,
            Deed::Look | Deed::Restore | Deed::Reset => self.look(control).await?,
        };
        Ok(status.expect("a status"))
    }

    async fn look(&self, control: &mut Control) -> Result<Option<v1::WorldStatus>, Status> {
        Ok(control.get_world(v1::GetWorldRequest { world: "w".into() }).await?.into_inner().status)
    }

    async fn reset(&mut self, control: &mut Control) -> Result<Option<v1::WorldStatus>, Status> {
        let request = v1::ResetWorldRequest { world: "w".into(), ..Default::default() };
        let status = control.reset_world(request).await?.into_inner().status;
        self.resets -= 1;
        Ok(status)
    }

    /// Lets the world run.
    async fn go_on(&mut self, control: &mut Control) -> Result<v1::WorldStatus, Status> {
        let status = self.look(control).await?.expect("a status");
        self.stage.judge.check_status(&status);
        let world = "w".to_owned();
        if status.state() == v1::WorldState::Ended && self.resets > 0 {
            return Ok(self.reset(control).await?.expect("a status"));
        }
        if status.state() == v1::WorldState::Ended || !status.robots.iter().all(|robot| robot.attached) {
            return Ok(status);
        }
        if self.stage.kind.is_stepped {
            let request = v1::StepWorldRequest { world, ticks: 1 + self.chance.below(60) };
            return Ok(control.step_world(request).await?.into_inner().status.expect("a status"));
        }
        if self.stage.kind.loses_brains {
            return Ok(status);
        }
        let started = control.start_world(v1::StartWorldRequest { world }).await?;
        Ok(started.into_inner().status.expect("a status"))
    }
}

/// A deed of an operator.
#[derive(Clone, Copy)]
enum Deed {
    Pause,
    Snapshot,
    Restore,
    Reset,
    Look,
    GoOn,
}

impl Deed {
    const ALL: [Self; 8] = [
        Self::Pause,
        Self::Snapshot,
        Self::Restore,
        Self::Reset,
        Self::Look,
        Self::GoOn,
        Self::GoOn,
        Self::GoOn,
    ];
}
