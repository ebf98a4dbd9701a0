//! The same scenario, seed and inputs give the same bits, whatever carries them.

use std::time::Duration;

use baudbot_brains::catalogue;
use baudbot_client::{Brain, Client, RawCommands, RawReadings, connect, run_fleet};
use baudbot_server::Server;
use baudbot_tests::system::{client, drive, lockstep, serve, serve_on_ports, status};
use baudbot_tests::{InProcess, WANDER, crowd, scenario};
use tokio::task::JoinSet;

const TWO_SECONDS: &[&str] = &["end.after_s=2.0"];

fn in_process_hash(toml: &str, changes: &[&str], brain: &str) -> u64 {
    let mut local = InProcess::new(scenario(toml, changes), brain).unwrap();
    local.run(u64::MAX);
    local.world.begin();
    local.world.hash()
}

/// The hash at the end of the run, and the server's end.
async fn hash_of(server: Server) -> u64 {
    let status = status(&server).await;
    assert!(!status.ending.is_empty(), "the run should be over: {status:?}");
    server.shutdown().await;
    status.state_hash
}

#[tokio::test]
async fn in_process_pipe_tcp_and_unix_socket_give_the_same_hash() {
    let expected = in_process_hash(WANDER, TWO_SECONDS, "avoid");

    let server = serve(scenario(WANDER, TWO_SECONDS), lockstep()).await;
    drive(&client(&server).await, "robot", "avoid", 1).await;
    assert_eq!(hash_of(server).await, expected, "in-process pipe");

    for (i, kind) in ["Unix socket", "TCP"].into_iter().enumerate() {
        let server = serve_on_ports(scenario(WANDER, TWO_SECONDS), lockstep()).await;
        let address = server.addresses()[i].to_string();
        drive(&connect(&address).await.unwrap(), "robot", "avoid", 1).await;
        assert_eq!(hash_of(server).await, expected, "{kind}");
    }
}

fn names(n: usize) -> Vec<String> {
    (0..n).map(|i| format!("r{i}")).collect()
}

/// Each robot's brain in a task of its own, over a connection of its own, with delays of up to `delay_us`.
async fn drive_apart(server: &Server, names: &[String], delay_us: u64) {
    let mut tasks = JoinSet::new();
    for (i, name) in names.iter().enumerate() {
        let (client, name) = (client(server).await, name.clone());
        tasks.spawn(async move {
            let mut robot = client.attach("w", &name).await.unwrap();
            let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
            let mut chance = i as u64;
            while let Some(turn) = robot.turn().await.unwrap() {
                chance =
                    chance.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if delay_us > 0 && chance >> 62 == 0 {
                    tokio::time::sleep(Duration::from_micros((chance >> 33) % delay_us)).await;
                }
                robot.act(brain.step(&turn)).await.unwrap();
            }
        });
    }
    while let Some(result) = tasks.join_next().await {
        result.unwrap();
    }
}

/// All robots over one stream.
async fn drive_together(client: &Client, names: &[String]) {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut fleet = client.attach_many("w", &names).await.unwrap();
    let bodies = fleet.bodies().to_vec();
    let mut brains: Vec<Box<dyn Brain + Send>> =
        bodies.iter().map(|body| catalogue::brain("avoid", 1, body).unwrap()).collect();
    run_fleet(&mut fleet, &mut brains).await.unwrap();
}

#[tokio::test]
async fn ten_robots_on_one_stream_or_ten_with_delays_and_permuted_give_the_same_hash() {
    let toml = crowd(&names(10));
    let expected = in_process_hash(&toml, TWO_SECONDS, "avoid");

    let server = serve(scenario(&toml, TWO_SECONDS), lockstep()).await;
    drive_together(&client(&server).await, &names(10)).await;
    assert_eq!(hash_of(server).await, expected, "one stream");

    let server = serve(scenario(&toml, TWO_SECONDS), lockstep()).await;
    drive_apart(&server, &names(10), 3000).await;
    assert_eq!(hash_of(server).await, expected, "ten streams with random delays");

    let mut permuted = names(10);
    permuted.reverse();
    permuted.swap(2, 7);
    let server = serve(scenario(&crowd(&permuted), TWO_SECONDS), lockstep()).await;
    drive_apart(&server, &names(10), 0).await;
    assert_eq!(hash_of(server).await, expected, "robots permuted in the file");
}

#[tokio::test]
async fn a_raw_brain_and_a_brain_of_messages_give_the_same_hash() {
    for changes in [
        &["end.after_s=2.0"][..],
        &["end.after_s=2.0", "robots.robot.link.byte_error_rate=0.01"],
        &[
            "end.after_s=2.0",
            "robots.robot.firmware={ protocol = \"bare\", mode = \"stream\", period_ms = 20.0 }",
        ],
        &["end.after_s=2.0", "robots.robot.firmware={ protocol = \"bare\", mode = \"poll\" }"],
        &["end.after_s=2.0", "robots.robot.firmware={ mode = \"poll\" }"],
        &["end.after_s=2.0", "robots.robot.firmware={ protocol = \"khepera\" }"],
        &[
            "end.after_s=2.0",
            "robots.robot.firmware={ protocol = \"khepera\" }",
            "robots.robot.link.byte_error_rate=0.01",
        ],
    ] {
        let expected = in_process_hash(WANDER, changes, "avoid");
        let server = serve(scenario(WANDER, changes), lockstep()).await;
        let mut robot = client(&server).await.attach_raw("w", "robot").await.unwrap();
        let body = robot.body().clone();
        let mut brain = catalogue::brain("avoid", 1, &body).unwrap();
        let (mut readings, mut commands) =
            (RawReadings::new(body.clone()).unwrap(), RawCommands::new(&body).unwrap());
        while let Some(raw) = robot.turn().await.unwrap() {
            let action = brain.step(&readings.turn(&raw));
            let bytes = match (action.signals, action.poll) {
                (Some(signals), _) => commands.command(signals),
                (None, true) => commands.poll().unwrap(),
                (None, false) => Vec::new(),
            };
            robot.write(&bytes).await.unwrap();
        }
        drop(robot);
        assert_eq!(hash_of(server).await, expected, "{changes:?}");
    }
}

#[tokio::test]
async fn a_restored_snapshot_has_the_same_future() {
    use baudbot_proto::v1::{ResetWorldRequest, RestoreWorldRequest, SnapshotWorldRequest, StepWorldRequest};
    let pace = baudbot_server::Pace::Stepped(baudbot_server::Lockstep::default());
    let server = serve(scenario(WANDER, &[]), pace).await;
    let mut operator = baudbot_tests::system::operator(&server).await;
    let brain = client(&server).await;
    let brain = tokio::spawn(async move {
        let mut robot = brain.attach("w", "robot").await.unwrap();
        // A brain without a state: otherwise it would not know that time went back.
        while let Ok(Some(turn)) = robot.turn().await {
            let near = turn.value("ir_front").unwrap_or(0.0);
            robot.drive(baudbot_client::Signals { left: 0.4, right: 0.4 - near * 0.5 }).await.unwrap();
        }
    });
    while !status(&server).await.robots[0].attached {
        tokio::task::yield_now().await;
    }
    let w = || "w".to_owned();
    let mut step = async |ticks| {
        let response = operator.step_world(StepWorldRequest { world: w(), ticks }).await.unwrap();
        response.into_inner().status.unwrap()
    };
    let at_100 = step(100).await;
    assert_eq!(at_100.tick, 100);
    let snapshot = {
        let mut operator = baudbot_tests::system::operator(&server).await;
        operator.snapshot_world(SnapshotWorldRequest { world: w() }).await.unwrap().into_inner()
    };
    assert_eq!(snapshot.status.unwrap().state_hash, at_100.state_hash);
    let at_250 = step(150).await;
    assert_ne!(at_250.state_hash, at_100.state_hash);
    let mut other = baudbot_tests::system::operator(&server).await;
    let restore = RestoreWorldRequest { world: w(), snapshot: snapshot.snapshot };
    let restored = other.restore_world(restore).await.unwrap().into_inner().status.unwrap();
    assert_eq!((restored.tick, restored.state_hash), (100, at_100.state_hash));
    assert_eq!(step(150).await.state_hash, at_250.state_hash, "the same future");
    let reset = other
        .reset_world(ResetWorldRequest { world: w(), ..Default::default() })
        .await
        .unwrap()
        .into_inner()
        .status
        .unwrap();
    assert_eq!(reset.tick, 0);
    assert_eq!(step(100).await.state_hash, at_100.state_hash, "the same past");
    server.shutdown().await;
    brain.abort();
}
