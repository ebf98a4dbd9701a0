//! Resets with another seed, other starts or other numbers: the same state as CreateWorld makes, brains stay, and what is
//! refused changes nothing.

use std::path::Path;
use std::sync::Arc;

use baudbot_client::{Action, Body, Brain, Client, EachRun, Robot, Signals, Turn, run_fleet};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_recording::{RecordedRun, Replay};
use baudbot_run::AttachedBrains;
use baudbot_run::assignment::Assignment;
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_tests::system::{client, operator, serve};
use baudbot_tests::{WANDER, crowd, scenario};
use tonic::transport::Channel;
use tonic::{Code, Status};

use crate::exchanges::HOMES;

type Operator = ControlServiceClient<Channel>;

/// A server with the world `w`, which is stepped.
async fn serve_stepped(toml: &str, changes: &[&str]) -> (Server, Operator, Client) {
    let server = serve(scenario(toml, changes), Pace::Stepped(Lockstep::default())).await;
    let (operator, client) = (operator(&server).await, client(&server).await);
    (server, operator, client)
}

fn start(robot: &str, x_m: f64, y_m: f64, heading_rad: f64) -> v1::RobotStart {
    v1::RobotStart { robot: robot.into(), x_m, y_m, heading_rad }
}

fn with(overrides: &[&str]) -> v1::ResetWorldRequest {
    let overrides = overrides.iter().map(|text| (*text).to_owned()).collect();
    v1::ResetWorldRequest { world: "w".into(), overrides, ..Default::default() }
}

async fn reset(operator: &mut Operator, request: v1::ResetWorldRequest) -> Result<v1::WorldStatus, Status> {
    Ok(operator.reset_world(request).await?.into_inner().status.unwrap())
}

async fn get(operator: &mut Operator, world: &str) -> v1::WorldStatus {
    let request = v1::GetWorldRequest { world: world.into() };
    operator.get_world(request).await.unwrap().into_inner().status.unwrap()
}

/// A world that CreateWorld makes of the same scenario with these overrides.
async fn create(operator: &mut Operator, world: &str, toml: &str, overrides: &[&str]) -> v1::WorldStatus {
    let stepped = v1::pace::Kind::Stepped(v1::Stepped::default());
    let request = v1::CreateWorldRequest {
        world: world.into(),
        scenario_toml: toml.into(),
        overrides: overrides.iter().map(|text| (*text).to_owned()).collect(),
        pace: Some(v1::Pace { kind: Some(stepped) }),
        ..Default::default()
    };
    operator.create_world(request).await.unwrap().into_inner().status.unwrap()
}

/// Does some ticks with a brain that has no state; the fingerprint after them.
async fn run(operator: &mut Operator, world: &str, robot: &mut Robot, ticks: u64) -> u64 {
    let request = v1::StepWorldRequest { world: world.into(), ticks };
    let stepped = operator.step_world(request);
    let drive = async {
        for _ in 0..ticks {
            let turn = robot.turn().await.unwrap().unwrap();
            let near = turn.value("ir_front").unwrap_or(0.0);
            robot.drive(Signals { left: 0.4, right: 0.4 - near * 0.5 }).await.unwrap();
        }
    };
    let (stepped, ()) = tokio::join!(stepped, drive);
    stepped.unwrap().into_inner().status.unwrap().state_hash
}

#[tokio::test]
async fn a_reset_makes_the_state_that_create_world_makes_and_brains_stay() {
    let (server, mut operator, client) = serve_stepped(WANDER, &["end.after_s=3.0"]).await;
    let mut robot = client.attach("w", "robot").await.unwrap();
    let first = run(&mut operator, "w", &mut robot, 100).await;

    let request = v1::ResetWorldRequest {
        seed: Some(7),
        starts: vec![start("robot", 0.25, -0.5, 1.0)],
        ..with(&["robots.robot.link.baud=19200", "noise=true"])
    };
    let status = reset(&mut operator, request).await.unwrap();
    let overrides = [
        "end.after_s=3.0",
        "robots.robot.link.baud=19200",
        "noise=true",
        "seed=7",
        "robots.robot.start.x_m=0.25",
        "robots.robot.start.y_m=-0.5",
        "robots.robot.start.heading_rad=1.0",
    ];
    let made = create(&mut operator, "made", WANDER, &overrides).await;
    assert_eq!((status.tick, status.state_hash), (0, made.state_hash));
    assert!(status.robots[0].attached, "the brain is gone");
    let mut other = client.attach("made", "robot").await.unwrap();
    let hash = run(&mut operator, "w", &mut robot, 100).await;
    assert_eq!(hash, run(&mut operator, "made", &mut other, 100).await);
    assert_ne!(hash, first);

    // A missing field is as it was when the world was made, and not as at the last reset.
    reset(&mut operator, with(&[])).await.unwrap();
    assert_eq!(run(&mut operator, "w", &mut robot, 100).await, first);
    server.shutdown().await;
}

/// Drives forwards, and later back.
struct Counts(u32);

impl Brain for Counts {
    fn step(&mut self, _: &Turn) -> Action {
        self.0 += 1;
        let signal = if self.0 <= 25 { 0.2 } else { -0.2 };
        Action::drive(signal, signal)
    }
}

/// Runs, the one after the other on one world: resets come behind a run, at once, and in the middle. All of the length of the first
/// have its fingerprint.
async fn runs_alike(operator: &mut Operator, ticks: u64, name: &str) {
    let mut hashes = Vec::new();
    for ticks in [ticks, ticks, 1, ticks, 37, ticks] {
        let request = v1::StepWorldRequest { world: "w".into(), ticks };
        hashes.push(operator.step_world(request).await.unwrap().into_inner().status.unwrap().state_hash);
        reset(operator, with(&[])).await.unwrap();
    }
    assert_eq!([hashes[1], hashes[3], hashes[5]], [hashes[0]; 3], "{name}");
}

/// The same for brains that are typed into the page is in `viewer/test/page.ts`, for those in Python in `client/python/tests`.
#[tokio::test]
async fn each_run_has_a_new_brain() {
    let (server, mut operator, client) = serve_stepped(WANDER, &["end.after_s=1.0"]).await;
    let mut fleet = client.attach_many("w", &["robot"]).await.unwrap();
    let mut brains = [EachRun::new(Counts(0), |_: &Body| Some(Counts(0)))];
    let driver = tokio::spawn(async move {
        while !fleet.is_closed() && run_fleet(&mut fleet, &mut brains).await.is_ok() {}
    });
    runs_alike(&mut operator, 100, "counts").await;
    server.shutdown().await;
    driver.await.unwrap();
}

/// A reset changes nothing of what a run of the catalogue's brains is: it has the bits of the first one on a new world.
#[tokio::test]
async fn each_run_of_each_brain_of_the_catalogue_has_the_bits_of_the_first() {
    for home in HOMES {
        let scenario = scenario(home.toml, &[]);
        let robots: Vec<_> = scenario.robots.iter().map(|robot| robot.name.clone()).collect();
        let server = serve(scenario, Pace::Stepped(Lockstep::default())).await;
        let (mut operator, client) = (operator(&server).await, client(&server).await);
        let assignment = Assignment { brain: home.brain.to_owned(), robots };
        let mut attached = AttachedBrains::attach(client, "w", assignment, 1).await.unwrap();
        let driver =
            tokio::spawn(async move { while attached.run().await.is_ok_and(|summary| summary.turns > 0) {} });
        runs_alike(&mut operator, 120, home.brain).await;
        server.shutdown().await;
        driver.await.unwrap();
    }
}

#[tokio::test]
async fn the_end_of_the_run_is_part_of_what_a_reset_changes() {
    let (server, mut operator, client) = serve_stepped(WANDER, &["end.after_s=3.0"]).await;
    let mut robot = client.attach("w", "robot").await.unwrap();
    reset(&mut operator, with(&["end.after_s=0.5"])).await.unwrap();
    run(&mut operator, "w", &mut robot, 50).await;
    let status = get(&mut operator, "w").await;
    assert_eq!((status.tick, status.ending_kind()), (50, v1::EndingKind::TimeIsOver));
    server.shutdown().await;
}

#[tokio::test]
async fn a_reset_that_is_refused_names_its_field_and_changes_nothing() {
    let names: Vec<_> = (0..2).map(|i| format!("r{i}")).collect();
    let (server, mut operator, _) = serve_stepped(&crowd(&names), &[]).await;
    let before = get(&mut operator, "w").await.state_hash;
    let starts = |starts: Vec<v1::RobotStart>| v1::ResetWorldRequest { starts, ..with(&[]) };
    let seed = |seed| v1::ResetWorldRequest { seed: Some(seed), ..with(&[]) };
    let (invalid, promised) = (Code::InvalidArgument, Code::FailedPrecondition);
    let cases = [
        (
            starts(vec![start("bob", 0.0, 0.0, 0.0)]),
            Code::NotFound,
            "starts[0].robot: there is no robot `bob`",
        ),
        (starts(vec![start("r0", 4.0, 0.0, 0.0)]), invalid, "starts: robots[0].start: at (4, 0) a robot of"),
        (
            starts(vec![start("r0", 0.0, 0.0, 0.0), start("r1", 0.1, 0.0, 0.0)]),
            invalid,
            "starts: robots[1].start: stands in",
        ),
        (
            starts(vec![start("r0", f64::NAN, 0.0, 0.0)]),
            invalid,
            "starts[0].x_m: must be a finite number, is NaN",
        ),
        (starts(vec![start("r0", 0.0, 1e9, 0.0)]), invalid, "starts: robots[0].start.y_m: must be between"),
        (
            starts(vec![start("r0", 0.0, 0.0, 0.0), start("r0", 1.0, 0.0, 0.0)]),
            invalid,
            "starts[1].robot: `r0` is named twice",
        ),
        (seed(u64::MAX), invalid, "seed: must be 0 to 2^63 - 1, is 18446744073709551615"),
        (with(&["robots.r0.start"]), invalid, "overrides[0]: `robots.r0.start`: an override is PATH=VALUE"),
        (with(&["robots.r0.strat.x_m=1"]), invalid, "overrides: robots[0].strat: unknown field"),
        (with(&["robots.r0.start.x_m=4"]), invalid, "overrides: robots[0].start: at (4, "),
        (with(&["step_ms=20"]), promised, "overrides: step_ms: brains get this only when they attach"),
        (
            with(&["robots.r1.name=carol"]),
            promised,
            "overrides: robots: brains get this only when they attach",
        ),
        (
            with(&["robots.r1.body.radius_m=0.11"]),
            promised,
            "overrides: robots.r1.body: brains get this only when they attach",
        ),
        (
            with(&["robots.r1.sensors.ir_front.range_m=0.9"]),
            promised,
            "overrides: robots.r1.sensors.ir_front: brains get this only when they attach, so a reset cannot change \
             it; make another world with CreateWorld",
        ),
        (
            v1::ResetWorldRequest { world: "x".into(), ..seed(1) },
            Code::NotFound,
            "world: there is no world `x`",
        ),
    ];
    for (request, code, text) in cases {
        let refused = reset(&mut operator, request.clone()).await.unwrap_err();
        assert_eq!(refused.code(), code, "{request:?}: {refused:?}");
        assert!(refused.message().starts_with(text), "{request:?}: expected `{text}` in: {refused:?}");
    }
    assert_eq!(get(&mut operator, "w").await.state_hash, before);
    // None of the worlds is affected by a reset of another.
    create(&mut operator, "other", WANDER, &[]).await;
    reset(&mut operator, seed(9)).await.unwrap();
    assert_eq!(
        get(&mut operator, "other").await.state_hash,
        create(&mut operator, "third", WANDER, &[]).await.state_hash
    );
    server.shutdown().await;
}

#[tokio::test]
async fn a_robot_of_a_table_with_several_starts_goes_by_its_name() {
    let text = WANDER.replace(
        "start = { x_m = -0.2, y_m = 0.0, heading_rad = 0.0 }",
        "starts = [{ x_m = -0.2 }, { x_m = 0.3 }]",
    );
    let (server, mut operator, _) = serve_stepped(&text, &[]).await;
    let request = v1::ResetWorldRequest { starts: vec![start("robot-2", 0.25, 0.5, 0.0)], ..with(&[]) };
    let status = reset(&mut operator, request).await.unwrap();
    let overrides = ["robots[0].starts[1].x_m=0.25", "robots[0].starts[1].y_m=0.5"];
    assert_eq!(status.state_hash, create(&mut operator, "made", &text, &overrides).await.state_hash);
    server.shutdown().await;
}

/// Replays a file to its end, where it must be as it was recorded; the last tick and the fingerprint there.
fn replayed(path: &Path) -> (u64, u64) {
    let recorded = RecordedRun::open(path).unwrap();
    assert_eq!(recorded.problem(), None);
    let (mut replay, mut world) = Replay::start(Arc::new(recorded)).unwrap();
    while replay.step(&mut world).unwrap() {}
    assert_eq!(replay.difference(), None, "{}", path.display());
    (world.tick(), world.hash())
}

#[tokio::test]
async fn the_recording_of_a_run_that_began_with_other_numbers_replays() {
    let folder = std::env::temp_dir().join(format!("baudbot-resetting-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(Pace::Stepped(Lockstep::default()));
    let server = Server::builder().world(world).recordings(folder.clone()).in_process().await.unwrap();
    let (mut operator, client) = (operator(&server).await, client(&server).await);
    let mut robot = client.attach("w", "robot").await.unwrap();
    let record = v1::StartRecordingRequest { world: "w".into(), recording: "run".into(), look_hz: 0.0 };
    operator.start_recording(record).await.unwrap();
    run(&mut operator, "w", &mut robot, 20).await;
    let request = v1::ResetWorldRequest {
        seed: Some(5),
        starts: vec![start("robot", 0.3, 0.2, 2.0)],
        ..with(&["robots.robot.link.baud=2400", "end.after_s=0.3"])
    };
    reset(&mut operator, request).await.unwrap();
    let hash = run(&mut operator, "w", &mut robot, 30).await;
    operator.stop_recording(v1::StopRecordingRequest { world: "w".into() }).await.unwrap();
    assert_eq!(replayed(&folder.join("run-2.mcap")), (30, hash));

    // A world that replays is not reset.
    let open = v1::OpenRecordingRequest { recording: "run-2".into(), world: "again".into() };
    operator.open_recording(open).await.unwrap();
    let refused = v1::ResetWorldRequest { world: "again".into(), seed: Some(1), ..Default::default() };
    let refused = reset(&mut operator, refused).await.unwrap_err();
    assert_eq!(refused.code(), Code::FailedPrecondition);
    assert!(
        refused.message().contains("replays a recording, and can have a reset only after ForkReplay"),
        "{refused:?}"
    );
    server.shutdown().await;
    std::fs::remove_dir_all(folder).unwrap();
}

#[tokio::test]
async fn a_clone_goes_back_to_the_run_that_it_was_cloned_from() {
    let (server, mut operator, _) = serve_stepped(WANDER, &[]).await;
    let started = reset(&mut operator, v1::ResetWorldRequest { seed: Some(3), ..with(&[]) }).await.unwrap();
    let cloned = v1::CloneWorldRequest { original: "w".into(), world: "clone".into(), pace: None };
    operator.clone_world(cloned).await.unwrap();
    let request = v1::ResetWorldRequest { world: "clone".into(), ..Default::default() };
    assert_eq!(reset(&mut operator, request).await.unwrap().state_hash, started.state_hash);
    server.shutdown().await;
}
