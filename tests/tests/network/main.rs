//! The network as a simulation: a server and its clients on one thread, with a clock that does not wait, over connections that are
//! slow, cut off, reset and lost, other ones for each seed. Whatever happens the world is, at each tick, what it is without a network.
//!
//! In [`kept`] the disk and the clock break, too, and servers are killed.
//!
//! `BAUDBOT_NETWORK_SEEDS` says how many seeds are tried, or which (`500..1000`), `BAUDBOT_NETWORK_SEED` tries one alone.

mod actors;
mod chance;
mod clock;
mod judge;
mod kept;
mod link;

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_tests::system::status;
use tokio::runtime::{Builder, Handle};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout};
use tokio_stream::wrappers::UnboundedReceiverStream;

use actors::{Kind, Operator, Stage, brain, faults, observer, stranger};
use judge::{Judge, ROBOTS, Seen, room};
use link::Network;

/// The result of a run.
#[derive(Clone, Copy, Debug)]
struct Report {
    trace: u64,
    seen: Seen,
    took: Duration,
    was_forgiven: bool,
}

/// Panics of any thread.
static PANICS: AtomicU64 = AtomicU64::new(0);

/// So much simulated time is enough for a run.
const ENOUGH: Duration = Duration::from_secs(4 * 3600);

/// The run of a seed.
fn run(seed: u64, judges: &[Judge; 2]) -> Report {
    let runtime = Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
    let judge = judges[usize::from(Kind::of(seed).loses_brains)].again();
    let before = PANICS.load(Ordering::SeqCst);
    let report =
        runtime.block_on(async { timeout(ENOUGH, simulate(seed, judge)).await.expect("the run hangs") });
    assert_eq!(PANICS.load(Ordering::SeqCst), before, "something has panicked");
    report
}

async fn simulate(seed: u64, judge: Judge) -> Report {
    let (began, kind) = (Instant::now(), Kind::of(seed));
    let (network, incoming) = Network::new(seed);
    let mut lockstep = Lockstep { lookahead: kind.goes_ahead, ..Lockstep::default() };
    if kind.goes_ahead {
        // Once it acts, an operator is shown a world that is ahead of its brains, and lacks what they will do.
        lockstep.watchdog.timeout = ENOUGH;
    }
    let pace = if kind.is_stepped { Pace::Stepped(lockstep) } else { Pace::Lockstep(lockstep) };
    let server =
        Server::builder().world(WorldConfig::new("w", room(kind.loses_brains)).pace(pace)).without_threads();
    let server = server.incoming(UnboundedReceiverStream::new(incoming)).in_process().await.unwrap();
    sleep(Duration::from_secs(1)).await;
    let tasks = Handle::current().metrics().num_alive_tasks();

    let (end, over) = watch::channel(false);
    let stage = Stage { seed, network: network.clone(), judge: judge.clone(), kind, over };
    let mut actors = JoinSet::new();
    for robot in ROBOTS {
        actors.spawn(stage.clone().until_over(brain(stage.clone(), robot)));
    }
    for host in ["eye 1", "eye 2"].into_iter().filter(|_| kind.is_watched) {
        actors.spawn(stage.clone().until_over(observer(stage.clone(), host)));
    }
    actors.spawn(stage.clone().until_over(stranger(stage.clone())));
    let befalls = stage.clone();
    actors.spawn(
        stage
            .clone()
            .until_over(async move { faults(befalls, &ROBOTS, &["eye 1", "eye 2", "operator"]).await }),
    );
    let operator = tokio::spawn(Operator::new(stage).run());
    operator.await.unwrap();
    let _ = end.send(true);
    while let Some(ended) = actors.join_next().await {
        ended.unwrap();
    }
    nothing_is_left(&server, &network, tasks).await;
    server.shutdown().await;
    Report {
        trace: network.trace(),
        seen: judge.seen(),
        took: began.elapsed(),
        was_forgiven: judge.is_forgiven(),
    }
}

/// All clients are gone. The server notices that of each in time, and keeps nothing of it.
async fn nothing_is_left(server: &Server, network: &Network, tasks: usize) {
    let gone = Instant::now();
    while network.open() > 0 || Handle::current().metrics().num_alive_tasks() != tasks {
        assert!(
            gone.elapsed() < Duration::from_secs(200),
            "{} connections and {} tasks are left; there were {tasks}",
            network.open(),
            Handle::current().metrics().num_alive_tasks()
        );
        sleep(Duration::from_secs(1)).await;
    }
    let v1::WorldStatus { robots, .. } = status(server).await;
    assert!(robots.iter().all(|robot| !robot.attached && robot.brain.is_empty()), "{robots:?}");
}

/// Runs of all these seeds. The failure of the first has the command that repeats it.
fn run_all(seeds: impl IntoIterator<Item = u64>) {
    let usual = take_hook();
    set_hook(Box::new(move |info| {
        PANICS.fetch_add(1, Ordering::SeqCst);
        usual(info);
    }));
    let judges = [false, true].map(Judge::new);
    let (mut runs, mut simulated, mut seen, mut forgiven) = (0_u64, Duration::ZERO, Seen::default(), 0);
    let began = std::time::Instant::now();
    for seed in seeds {
        let report = catch_unwind(AssertUnwindSafe(|| run(seed, &judges))).unwrap_or_else(|_| {
            panic!("seed {seed} fails ({:?}); again: ./test network --seed {seed}", Kind::of(seed))
        });
        assert!(report.seen.turns >= 4 * judge::TICKS, "{report:?}");
        runs += 1;
        simulated += report.took;
        seen += report.seen;
        forgiven += u64::from(report.was_forgiven);
        if runs.is_multiple_of(1000) {
            println!("{runs} seeds in {:.0} s", began.elapsed().as_secs_f64());
        }
    }
    println!(
        "{runs} seeds, {:.1} simulated hours in {:.0} s; {seen:?}; runs ahead that lost a brain, and were not compared from then on: {forgiven}",
        simulated.as_secs_f64() / 3600.0,
        began.elapsed().as_secs_f64()
    );
}

/// The seeds that a text names: `7`, those below 7, or `5..7`.
fn seeds(text: &str) -> std::ops::Range<u64> {
    let number = |text: &str| text.parse().expect("a number of seeds, or a range of them");
    text.split_once("..").map_or_else(|| 0..number(text), |(from, to)| number(from)..number(to))
}

#[test]
fn a_network_that_breaks_in_any_way_changes_no_world() {
    let named = |variable| std::env::var(variable).ok();
    match named("BAUDBOT_NETWORK_SEED") {
        Some(seed) => run_all([seed.parse().expect("a seed")]),
        None => run_all(seeds(named("BAUDBOT_NETWORK_SEEDS").as_deref().unwrap_or("60"))),
    }
}

#[test]
fn a_seed_is_a_run() {
    let judges = [false, true].map(Judge::new);
    let mut traces = std::collections::BTreeSet::new();
    for seed in 0..8 {
        let [first, second] = [(); 2].map(|()| run(seed, &judges));
        assert_eq!((first.trace, first.took), (second.trace, second.took), "seed {seed}");
        traces.insert(first.trace);
    }
    assert_eq!(traces.len(), 8, "each seed is another one");
}
