//! All that a server's clients do at once.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use baudbot_client::{Channel, Client, Credentials, Signals, connect_with};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use super::server::{ROBOTS, WORLDS};

/// Brains, of which as many drive at a time as there are robots.
const BRAINS: usize = 1000;

/// Viewers that read, and one that does not.
const VIEWERS: usize = 49;

/// The world that the stalled viewer watches, and its likes.
const STALLED: &str = "w0";

/// The deeds so far.
#[derive(Default)]
pub(crate) struct Done {
    attaches: AtomicU64,
    frames: AtomicU64,
    worlds: AtomicU64,
    recordings: AtomicU64,
    failures: AtomicU64,
}

/// The same at an instant: attaches, frames, worlds, recordings, failures.
pub(crate) type Counts = [u64; 5];

/// All clients. They are gone when it is dropped.
pub(crate) struct Crowd {
    door: Door,
    done: Arc<Done>,
    _clients: JoinSet<()>,
}

/// The server's address, and the credentials that it wants.
#[derive(Clone)]
struct Door {
    address: Arc<str>,
    folder: PathBuf,
}

impl Door {
    async fn enter(&self, holder: &str) -> Result<Client, baudbot_client::Error> {
        let token = std::fs::read_to_string(self.folder.join(format!("{holder}.token"))).expect("its token");
        let token = token.trim().parse().expect("a token");
        let credentials = Credentials::default().authorities(self.folder.join("ca.pem")).token(token);
        connect_with(&self.address, &credentials).await
    }
}

impl Crowd {
    pub(crate) async fn start(address: &str, folder: &Path) -> Self {
        let door = Door { address: address.into(), folder: folder.to_owned() };
        let (done, mut clients) = (Arc::new(Done::default()), JoinSet::new());
        clients.spawn(stalled_viewer(door.clone()));
        for number in 0..VIEWERS {
            clients.spawn(viewer(door.clone(), Arc::clone(&done), format!("w{}", number % WORLDS)));
        }
        for number in 0..BRAINS {
            clients.spawn(brain(door.clone(), Arc::clone(&done), number));
        }
        clients.spawn(recorder(door.clone(), Arc::clone(&done)));
        clients.spawn(maker(door.clone(), Arc::clone(&done)));
        Self { door, done, _clients: clients }
    }

    pub(crate) fn counts(&self) -> Counts {
        let Done { attaches, frames, worlds, recordings, failures } = &*self.done;
        [attaches, frames, worlds, recordings, failures].map(|count| count.load(Ordering::Relaxed))
    }

    /// The lateness of ticks.
    pub(crate) async fn lag(&self) -> Lag {
        let channel = self.door.enter("operator").await.expect("the server answers").channel();
        let mut operator = ControlServiceClient::new(channel);
        let mut of = Vec::new();
        for i in 0..WORLDS {
            let request = v1::GetWorldRequest { world: format!("w{i}") };
            let status =
                operator.get_world(request).await.expect("a world").into_inner().status.expect("its status");
            let pacing = status.pacing.unwrap_or_default();
            of.push([
                status.tick,
                pacing.late_ticks,
                pacing.lateness_max_wall_ns / 1_000_000,
                pacing.let_go_wall_ns / 1_000_000,
            ]);
        }
        Lag(of)
    }
}

/// The lag of each world: ticks, those that were late, the largest lateness and the time that was skipped, in
/// milliseconds.
pub(crate) struct Lag(Vec<[u64; 4]>);

impl Lag {
    /// The world with the stalled viewer lags no more than the others.
    pub(crate) fn judge(&self) -> bool {
        println!("\nworld      ticks  late ticks  most ms  let go ms");
        for (i, [ticks, late, most, let_go]) in self.0.iter().enumerate() {
            println!("w{i:<5} {ticks:9} {late:11} {most:8} {let_go:10}");
        }
        let share = |[ticks, late, ..]: &[u64; 4]| *late as f64 / *ticks as f64;
        let others = self.0[1..].iter().map(share).fold(0.0, f64::max);
        let is_good = share(&self.0[0]) <= others + 0.01;
        println!(
            "{STALLED}, which the stalled viewer watches, lags {}",
            if is_good { "no more than others" } else { "MORE THAN OTHERS" }
        );
        is_good
    }
}

async fn frames_of(
    channel: Channel,
    world: &str,
) -> Result<tonic::Streaming<v1::WatchResponse>, tonic::Status> {
    let request = v1::WatchRequest { world: world.to_owned(), every_ticks: 1, ..Default::default() };
    Ok(ObserveServiceClient::new(channel).watch(request).await?.into_inner())
}

/// Opens a stream and never reads it.
async fn stalled_viewer(door: Door) {
    let channel = door.enter("viewer").await.expect("the server answers").channel();
    let _frames = frames_of(channel, STALLED).await.expect("a stream");
    std::future::pending::<()>().await;
}

async fn viewer(door: Door, done: Arc<Done>, world: String) {
    loop {
        let watched = async {
            let channel = door.enter("viewer").await.ok()?.channel();
            let mut frames = frames_of(channel, &world).await.ok()?;
            while frames.message().await.ok()?.is_some() {
                done.frames.fetch_add(1, Ordering::Relaxed);
            }
            Some(())
        };
        watched.await;
        done.failures.fetch_add(1, Ordering::Relaxed);
        sleep(Duration::from_secs(1)).await;
    }
}

/// Numbers that are as good as chance (Vigna's SplitMix64).
fn chance(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Comes to a robot, drives it for some seconds and goes; now and then without a word.
async fn brain(door: Door, done: Arc<Done>, number: usize) {
    let mut state = number as u64;
    loop {
        sleep(Duration::from_millis(chance(&mut state) % 60_000)).await;
        let (world, robot) = (number % WORLDS, chance(&mut state) as usize % ROBOTS);
        let Ok(client) = timeout(Duration::from_secs(30), door.enter("brain")).await else {
            done.failures.fetch_add(1, Ordering::Relaxed);
            continue;
        };
        let Ok(client) = client else {
            done.failures.fetch_add(1, Ordering::Relaxed);
            continue;
        };
        // Another brain may hold it.
        let Ok(mut robot) = client.attach(&format!("w{world}"), &format!("r{robot}")).await else { continue };
        done.attaches.fetch_add(1, Ordering::Relaxed);
        for _ in 0..chance(&mut state) % 200 {
            if !matches!(robot.turn().await, Ok(Some(_))) {
                done.failures.fetch_add(1, Ordering::Relaxed);
                break;
            }
            let _ = robot.drive(Signals { left: 0.3, right: 0.25 }).await;
        }
    }
}

async fn operator(door: &Door) -> Option<ControlServiceClient<Channel>> {
    Some(ControlServiceClient::new(door.enter("operator").await.ok()?.channel()))
}

/// Records a world again and again, and keeps the last files only.
async fn recorder(door: Door, done: Arc<Done>) {
    for number in 0_u64.. {
        let recorded = async {
            let (mut operator, world) = (operator(&door).await?, "w1".to_owned());
            let recording = format!("{number}.mcap");
            let start = v1::StartRecordingRequest { world: world.clone(), recording, look_hz: 10.0 };
            operator.start_recording(start).await.ok()?;
            sleep(Duration::from_secs(8)).await;
            operator.stop_recording(v1::StopRecordingRequest { world }).await.ok()
        };
        let count = if recorded.await.is_some() { &done.recordings } else { &done.failures };
        count.fetch_add(1, Ordering::Relaxed);
        if let Some(old) = number.checked_sub(3) {
            let _ = std::fs::remove_file(door.folder.join(format!("recordings/{old}.mcap")));
        }
        sleep(Duration::from_secs(1)).await;
    }
}

/// Makes a world, runs it for a moment and deletes it.
async fn maker(door: Door, done: Arc<Done>) {
    loop {
        let made = async {
            let (mut operator, world) = (operator(&door).await?, "made".to_owned());
            let scenario_toml = baudbot_tests::KHEPERA.to_owned();
            let new = v1::CreateWorldRequest { world: world.clone(), scenario_toml, ..Default::default() };
            operator.create_world(new).await.ok()?;
            sleep(Duration::from_secs(1)).await;
            operator.delete_world(v1::DeleteWorldRequest { world }).await.ok()
        };
        let count = if made.await.is_some() { &done.worlds } else { &done.failures };
        count.fetch_add(1, Ordering::Relaxed);
        sleep(Duration::from_millis(500)).await;
    }
}
