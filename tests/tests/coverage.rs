//! The floor's cells as observers get them: what robots have covered and sensed.

use std::path::PathBuf;
use std::time::Duration;

use baudbot_brains::catalogue;
use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_server::{Server, WorldConfig};
use baudbot_tests::system::{client, drive, lockstep, operator, serve, status};
use baudbot_tests::{WANDER, scenario};
use tonic::transport::Channel;
use tonic::{Code, Status};

/// A room of 4 m by 3 m with a niche that is none of it, in cells of 5 cm, and a robot with a laser.
const COVERAGE: &str = include_str!("../../catalogue/scenarios/devices/coverage.toml");

async fn observer(server: &Server) -> ObserveServiceClient<Channel> {
    ObserveServiceClient::new(server.channel().await.unwrap())
}

async fn coverage(server: &Server) -> Result<v1::GetCoverageResponse, Status> {
    let request = v1::GetCoverageRequest { world: "w".into() };
    Ok(observer(server).await.get_coverage(request).await?.into_inner())
}

/// Whether each cell is in the set of the runs, row by row.
fn cells(runs: &[u32]) -> Vec<bool> {
    runs.iter().enumerate().flat_map(|(i, &run)| std::iter::repeat_n(i % 2 == 1, run as usize)).collect()
}

fn share(of: &[u32], all: &[u32]) -> f64 {
    let count = |runs: &[u32]| cells(runs).into_iter().filter(|&is| is).count();
    count(of) as f64 / count(all) as f64
}

/// The fractions covered and sensed, by a map of the floor.
fn shares(map: &v1::GetCoverageResponse) -> (f64, f64) {
    (share(&map.covered, &map.free), share(&map.sensed, &map.free))
}

/// The same by the referee's counters.
fn counted(status: &v1::WorldStatus) -> (f64, f64) {
    let score = status.score.as_ref().unwrap();
    (score.covered.unwrap(), score.sensed.unwrap())
}

#[tokio::test]
async fn a_robot_that_drives_covers_the_cells_that_its_score_counts() {
    let server = serve(scenario(COVERAGE, &["end.after_s=3.0"]), lockstep()).await;
    let before = coverage(&server).await.unwrap();
    let grid = |map: &v1::GetCoverageResponse| (map.cell_m, map.x_m, map.y_m, map.columns, map.rows);
    assert_eq!(grid(&before), (0.05, -2.0, -1.5, 80, 60));
    assert_eq!((before.tick, shares(&before)), (0, (0.0, 0.0)));

    let mut frames = observer(&server).await;
    let watch =
        v1::WatchRequest { world: "w".into(), every_ticks: 300, details: Vec::new(), ..Default::default() };
    let mut frames = frames.watch(watch).await.unwrap().into_inner();
    drive(&client(&server).await, "robot", "avoid", 1).await;
    let mut last = frames.message().await.unwrap().unwrap();
    while last.ending.is_empty() {
        last = frames.message().await.unwrap().unwrap();
    }
    let map = coverage(&server).await.unwrap();
    assert_eq!((grid(&map), map.tick), (grid(&before), 300));
    assert_eq!(shares(&map), counted(&status(&server).await));
    assert_eq!(shares(&map).0, last.score.unwrap().covered.unwrap());
    assert!(shares(&map).0 > 0.05 && shares(&map).1 > 0.5, "{:?}", shares(&map));

    let [free, covered, sensed] = [&map.free, &map.covered, &map.sensed].map(|runs| cells(runs));
    assert_eq!([free.len(), covered.len(), sensed.len()], [80 * 60; 3]);
    let at = |x_m: f64, y_m: f64| {
        let along = |place_m: f64, from_m: f64| ((place_m - from_m) / map.cell_m) as usize;
        along(y_m, map.y_m) * 80 + along(x_m, map.x_m)
    };
    let robot = &last.robots[0];
    assert!(covered[at(robot.x_m, robot.y_m)], "where it is");
    assert!(covered[at(-1.2, -0.5)], "where it began");
    assert!(!free[at(0.0, 1.0)] && free[at(1.5, 1.0)], "the niche is none of the floor");
    let beyond = |set: &[bool]| free.iter().zip(set).any(|(free, is)| *is && !free);
    assert!(!beyond(&covered) && !beyond(&sensed), "only free cells count");
    server.shutdown().await;
}

/// Fingerprint of a run in which the map is requested at every so many Turns, or never.
async fn hash_of_a_run(every: Option<u64>) -> u64 {
    let server = serve(scenario(COVERAGE, &["end.after_s=2.0"]), lockstep()).await;
    let channel = server.channel().await.unwrap();
    // The world goes ahead of this brain, unless there is an observer.
    let client = client(&server).await.thinks_as_scenario();
    let mut robot = client.attach("w", "robot").await.unwrap();
    let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
    let (mut turns, mut ticks) = (0, Vec::new());
    while let Some(turn) = robot.turn().await.unwrap() {
        turns += 1;
        let due = every.is_some_and(|every| turns % every == 0);
        let mut observer = ObserveServiceClient::new(channel.clone());
        let request = v1::GetCoverageRequest { world: "w".into() };
        // A world that is ahead gives no map before its brain has answered.
        let asked = due.then(|| tokio::spawn(async move { observer.get_coverage(request).await }));
        tokio::task::yield_now().await;
        robot.act(brain.step(&turn)).await.unwrap();
        if let Some(asked) = asked {
            let map = tokio::time::timeout(Duration::from_secs(20), asked).await.expect("an answer");
            ticks.push(map.unwrap().unwrap().get_ref().tick);
        }
    }
    assert!(every.is_none() || ticks.len() > 20 && ticks.is_sorted(), "{turns} turns, {ticks:?}");
    let hash = status(&server).await.state_hash;
    server.shutdown().await;
    hash
}

#[tokio::test]
async fn who_asks_for_the_map_changes_no_bit_of_the_run() {
    let unseen = hash_of_a_run(None).await;
    for every in [1, 3] {
        assert_eq!(hash_of_a_run(Some(every)).await, unseen, "a map every {every} turns");
    }
}

#[tokio::test]
async fn a_replay_has_the_map_of_each_of_its_ticks() {
    let folder = std::env::temp_dir().join(format!("baudbot-coverage-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let server = recorded(folder.clone()).await;
    let mut operator = operator(&server).await;
    let mut maps = Vec::new();
    for tick in [150, 30, 150] {
        let seek = v1::SeekReplayRequest { world: "w".into(), tick };
        let status = operator.seek_replay(seek).await.unwrap().into_inner().status.unwrap();
        let map = coverage(&server).await.unwrap();
        assert_eq!((map.tick, shares(&map)), (tick, counted(&status)));
        maps.push(map);
    }
    assert_eq!(maps[0], maps[2]);
    assert!(shares(&maps[1]).0 < shares(&maps[0]).0, "going back takes cells away");
    server.shutdown().await;
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A server that replays two seconds.
async fn recorded(folder: PathBuf) -> Server {
    let world = WorldConfig::new("live", scenario(COVERAGE, &["end.after_s=2.0"])).pace(lockstep());
    let server = Server::builder().world(world).recordings(folder).in_process().await.unwrap();
    let mut operator = operator(&server).await;
    let live = || "live".to_owned();
    let start = v1::StartRecordingRequest { world: live(), recording: "run".into(), look_hz: 0.0 };
    operator.start_recording(start).await.unwrap();
    let mut robot = client(&server).await.attach("live", "robot").await.unwrap();
    let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
    baudbot_client::run(&mut robot, &mut brain).await.unwrap();
    operator.stop_recording(v1::StopRecordingRequest { world: live() }).await.unwrap();
    let open = v1::OpenRecordingRequest { recording: "run".into(), world: "w".into() };
    operator.open_recording(open).await.unwrap();
    server
}

#[tokio::test]
async fn a_world_that_counts_nothing_says_what_would_switch_it_on() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let refused = coverage(&server).await.unwrap_err();
    let text = "world: `w` does not measure coverage; set metrics.cell_m in its scenario";
    assert_eq!((refused.code(), refused.message()), (Code::FailedPrecondition, text));
    let unknown = v1::GetCoverageRequest { world: "x".into() };
    let unknown = observer(&server).await.get_coverage(unknown).await.unwrap_err();
    assert_eq!(unknown.code(), Code::NotFound);
    server.shutdown().await;

    let server = serve(scenario(WANDER, &["metrics.cell_m=0.1"]), lockstep()).await;
    let map = coverage(&server).await.unwrap();
    assert!(map.sensed.is_empty(), "no sensor is chosen whose rays count");
    assert_eq!(map.covered, [map.columns * map.rows]);
    server.shutdown().await;
}
