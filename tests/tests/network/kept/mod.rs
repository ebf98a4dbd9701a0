//! State that outlives its server, over a network, on a disk and by a clock that are simulated, as a seed wants it: programs are killed
//! in the middle of writes, the power fails, disks are full, fail, stall and tear what was written, time jumps, connections break.
//!
//! An operator creates, deletes, steps, changes, snapshots and restores worlds ([`operator`]), and tokens are revoked
//! ([`tokens`]), over several lives of a server ([`life`]). The answers to the operator are compared with a [`model`]:
//! nothing that was answered is lost, no world has a state that it never had, and nothing revoked acts. A run that
//! fails prints its seed, all that happened ([`trace`]), and what the model expects.
//!
//! `BAUDBOT_FAULT_SEEDS` says how many seeds are tried, or which (`500..1000`), `BAUDBOT_FAULT_SEED` tries one alone.

mod disk;
mod life;
mod model;
mod operator;
mod power;
mod tokens;
mod trace;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_server::{Found, Lockstep, Pace, Server, StateFolder, WorldConfig};
use baudbot_tests::system::{operator, status};
use baudbot_tests::{WANDER, scenario};
use tokio::runtime::Builder;
use tokio::time::{advance, sleep, timeout};

use crate::seeds;
use disk::Disk;
use life::{Run, Seen};
use power::Tear;
use trace::Trace;

/// So much simulated time is enough for a server's life.
const ENOUGH: Duration = Duration::from_secs(1_000_000);

/// The run of a seed: a few servers' lives, each in a runtime of its own, which ends with all that the server had in memory.
fn run(seed: u64, trace: &Trace) -> Seen {
    let mut run = Run::new(seed, trace.clone());
    for life in 0..run.lives() {
        let runtime = Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
        runtime.block_on(async {
            trace.begin();
            timeout(ENOUGH, run.live(life)).await.expect("the run hangs");
            trace.end();
        });
    }
    run.seen()
}

fn run_all(seeds: impl IntoIterator<Item = u64>) {
    let (mut runs, mut all) = (0_u64, Seen::default());
    let began = std::time::Instant::now();
    for seed in seeds {
        let trace = Trace::default();
        let seen = catch_unwind(AssertUnwindSafe(|| run(seed, &trace))).unwrap_or_else(|_| {
            println!("seed {seed}:\n{}", trace.text());
            panic!("seed {seed} fails, as is said above; again: ./test faults --seed {seed}")
        });
        runs += 1;
        all += seen;
        if runs.is_multiple_of(1000) {
            println!("{runs} seeds in {:.0} s", began.elapsed().as_secs_f64());
        }
    }
    println!("{runs} seeds in {:.0} s; {all:?}", began.elapsed().as_secs_f64());
}

#[test]
fn what_operators_were_told_is_there_after_kills_power_cuts_full_disks_and_time_that_jumps() {
    let named = |variable| std::env::var(variable).ok();
    match named("BAUDBOT_FAULT_SEED") {
        Some(seed) => run_all([seed.parse().expect("a seed")]),
        None => run_all(seeds(named("BAUDBOT_FAULT_SEEDS").as_deref().unwrap_or("100"))),
    }
}

#[test]
fn a_seed_of_faults_is_a_run() {
    let mut fingerprints = std::collections::BTreeSet::new();
    for seed in 0..8 {
        let [first, second] = [(); 2].map(|()| {
            let trace = Trace::default();
            run(seed, &trace);
            trace
        });
        assert_eq!(first.fingerprint(), second.fingerprint(), "{}\n{}", first.text(), second.text());
        fingerprints.insert(first.fingerprint());
    }
    assert_eq!(fingerprints.len(), 8, "each seed is another one");
}

/// A server on this disk, with world `w` if there is none.
async fn serve(disk: &Disk) -> Server {
    let folder = StateFolder::simulated(Path::new("/lab"), Arc::new(disk.mount())).unwrap();
    let world = match folder.worlds().unwrap().pop() {
        None => {
            WorldConfig::new("w", scenario(WANDER, &[])).pace(Pace::Stepped(Lockstep::default())).paused(true)
        }
        Some(Found::World(world)) => WorldConfig::kept(*world),
        Some(_) => panic!("the world cannot be used"),
    };
    Server::builder().world(world).state(folder).without_threads().in_process().await.unwrap()
}

/// Time goes on, past all that is due by then.
async fn wait(time: Duration) {
    sleep(Duration::from_millis(1)).await;
    advance(time).await;
    sleep(Duration::from_millis(1)).await;
}

#[tokio::test(start_paused = true)]
async fn a_disk_that_is_full_and_slow_is_attempted_once_and_then_others_have_their_turn() {
    let trace = Trace::default();
    let disk = Disk::new(0, trace.clone());
    let server = serve(&disk).await;
    disk.set_full(true);
    disk.set_stalls(true);
    let mut operator = operator(&server).await;
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let attempts = || trace.text().matches("FULL").count();
    for _ in 0..20 {
        let before = attempts();
        // Past the next attempt, by the clock of the disk.
        wait(disk.stalled() + Duration::from_secs(3)).await;
        assert_eq!(attempts() - before, 1, "{}", trace.text());
    }
    disk.set_full(false);
    disk.set_stalls(false);
    wait(disk.stalled() + Duration::from_secs(3)).await;
    operator.step_world(v1::StepWorldRequest { world: "w".into(), ticks: 3 }).await.unwrap();
    drop(server);
    disk.kill();
    assert_eq!(status(&serve(&disk).await).await.tick, 3);
}

#[tokio::test(start_paused = true)]
async fn a_snapshot_of_a_server_that_was_killed_is_on_the_disk_soon_after_the_next_one_starts() {
    let disk = Disk::new(0, Trace::default());
    let server = serve(&disk).await;
    let world = || "w".to_owned();
    let request = v1::SnapshotWorldRequest { world: world() };
    let snapshot = operator(&server).await.snapshot_world(request).await.unwrap().into_inner().snapshot;
    disk.kill();
    let next = serve(&disk).await;
    wait(Duration::from_secs(3)).await;
    disk.lose_power_so(Tear::Nothing);
    let last = serve(&disk).await;
    operator(&last).await.restore_world(v1::RestoreWorldRequest { world: world(), snapshot }).await.unwrap();
    drop((server, next));
}

#[tokio::test(start_paused = true)]
async fn a_snapshot_that_the_disk_has_failed_to_take_is_written_anew() {
    for fails_in in 0..8 {
        let trace = Trace::default();
        let disk = Disk::new(0, trace.clone());
        let server = serve(&disk).await;
        wait(Duration::from_secs(3)).await;
        let world = || "w".to_owned();
        let request = v1::SnapshotWorldRequest { world: world() };
        let snapshot = operator(&server).await.snapshot_world(request).await.unwrap().into_inner().snapshot;
        disk.fail_in(fails_in);
        // The world has nothing to do meanwhile.
        sleep(Duration::from_secs(6)).await;
        disk.lose_power_so(Tear::Nothing);
        let last = serve(&disk).await;
        let request = v1::RestoreWorldRequest { world: world(), snapshot };
        let restored = operator(&last).await.restore_world(request).await;
        assert!(restored.is_ok(), "{restored:?}\n{}", trace.text());
        drop(server);
    }
}
