//! Lookahead changes how long a run takes and nothing else.

use std::collections::HashSet;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use baudbot_brains::catalogue;
use baudbot_client::{Action, Brain, Client, Error};
use baudbot_proto::v1;
use baudbot_server::{Pace, Server, WatchdogPolicy, WorldConfig};
use baudbot_tests::system::{client, lockstep, operator, serve, status, strict, watched};
use baudbot_tests::{InProcess, WANDER, crowd, scenario};
use tokio::task::JoinSet;
use tonic::Code;

/// Splitmix64: the next of a row of numbers that look random.
fn draw(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mixed = (*state ^ *state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB) >> 8
}

fn names(n: usize) -> Vec<String> {
    (0..n).map(|i| format!("r{i}")).collect()
}

/// A crowd with a cable, a step and thinking drawn at random.
fn drawn(robots: usize, state: &mut u64) -> (String, Vec<String>) {
    let mut pick = |of: &[&str]| of[draw(state) as usize % of.len()].to_owned();
    let mut changes = vec![
        "end.after_s=0.6".to_owned(),
        "substeps=4".to_owned(),
        format!("step_ms={}", pick(&["1.0", "2.5", "10.0"])),
    ];
    let toml = crowd(&names(robots));
    for name in names(robots) {
        let robot = format!("robots.{name}");
        changes.push(format!("{robot}.link.baud={}", pick(&["2400", "9600", "57600"])));
        changes.push(format!("{robot}.link.half_duplex={}", pick(&["false", "false", "false", "true"])));
        changes.push(format!("{robot}.brain.thinking_us={}", pick(&["0.0", "700.0", "15000.0", "40000.0"])));
        changes.push(format!("{robot}.firmware.period_ms={}", pick(&["20.0", "35.0", "90.0"])));
    }
    (toml, changes)
}

/// Each robot's brain over a connection of its own, with delays that are drawn.
async fn drive_apart(server: &Server, robots: usize, seed: u64, delay_us: u64) {
    let mut tasks = JoinSet::new();
    for (i, name) in names(robots).into_iter().enumerate() {
        let client = client(server).await.thinks_as_scenario();
        tasks.spawn(async move {
            let mut robot = client.attach("w", &name).await.unwrap();
            let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
            let mut state = seed + i as u64;
            while let Some(turn) = robot.turn().await.unwrap() {
                if delay_us > 0 && draw(&mut state).is_multiple_of(3) {
                    tokio::time::sleep(Duration::from_micros(draw(&mut state) % delay_us)).await;
                }
                robot.act(brain.step(&turn)).await.unwrap();
            }
        });
    }
    while let Some(result) = tasks.join_next().await {
        result.unwrap();
    }
}

async fn hash_with(toml: &str, changes: &[&str], pace: Pace, robots: usize, seed: u64, delay_us: u64) -> u64 {
    let server = serve(scenario(toml, changes), pace).await;
    drive_apart(&server, robots, seed, delay_us).await;
    let status = status(&server).await;
    assert!(!status.ending.is_empty(), "{status:?}");
    server.shutdown().await;
    status.state_hash
}

#[tokio::test]
async fn random_worlds_and_delays_give_the_bits_of_strict_lockstep() {
    const ROBOTS: usize = 8;
    for seed in 0..12 {
        let mut state = seed;
        let (toml, changes) = drawn(ROBOTS, &mut state);
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let mut local = InProcess::new(scenario(&toml, &changes), "avoid").unwrap();
        local.run(u64::MAX);
        local.world.begin();
        let expected = local.world.hash();
        for (pace, delay_us) in [(strict(), 0), (lockstep(), 0), (lockstep(), 2_000)] {
            let hash = hash_with(&toml, &changes, pace, ROBOTS, seed, delay_us).await;
            assert_eq!(hash, expected, "{pace:?}, delays of {delay_us} µs, {changes:?}");
        }
    }
}

/// All numbers of all ticks, as in a table of a run.
async fn trace(changes: &[&str], pace: Pace) -> Vec<f64> {
    let rows = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&rows);
    let world = WorldConfig::new("w", scenario(WANDER, changes)).pace(pace).on_tick(Box::new(move |world| {
        let mut rows = kept.lock().unwrap();
        for robot in world.robots() {
            let (pose, signals) = (robot.motion().pose, robot.signals());
            let (x, y) = (pose.position.x, pose.position.y);
            rows.extend([x, y, pose.heading, signals.left, signals.right]);
            rows.extend(robot.sensors().flat_map(|sensor| sensor.sample.to_vec()));
        }
    }));
    let server = Server::builder().world(world).in_process().await.unwrap();
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
    baudbot_client::run(&mut robot, &mut brain).await.unwrap();
    server.shutdown().await;
    let rows = rows.lock().unwrap();
    rows.clone()
}

#[tokio::test]
async fn the_table_of_a_run_is_the_same() {
    for thinking in ["0.0", "12000.0"] {
        let thinking = format!("robots.robot.brain.thinking_us={thinking}");
        let changes = ["end.after_s=3.0", "step_ms=1.0", "substeps=1", thinking.as_str()];
        let (off, on) = (trace(&changes, strict()).await, trace(&changes, lockstep()).await);
        assert!(off.len() > 3_000, "{} and {} numbers", off.len(), on.len());
        assert!(off.iter().zip(&on).all(|(a, b)| a.to_bits() == b.to_bits()) && off.len() == on.len());
    }
}

#[tokio::test]
async fn a_brain_that_waits_for_a_message_is_asked_when_one_comes_or_when_its_time_is_over() {
    let changes = ["end.after_s=1.0", "step_ms=1.0", "substeps=1"];
    for (pace, until_ns) in [(lockstep(), None), (strict(), None), (lockstep(), Some(500_000_000))] {
        let server = serve(scenario(WANDER, &changes), pace).await;
        let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
        let (mut asked, mut silent) = (0, Vec::new());
        while let Some(turn) = robot.turn().await.unwrap() {
            asked += 1;
            if !turn.has_news() {
                silent.push(turn.at_ns);
            }
            let action = Action::wait();
            let action = match until_ns.filter(|&until_ns| turn.at_ns < until_ns) {
                None => action.until_message(),
                Some(until_ns) => action.until_message_or(until_ns),
            };
            robot.act(action).await.unwrap();
        }
        // 50 messages a second; the first step has none.
        assert!((45..55).contains(&asked), "{asked} of 1000 steps");
        let expected = [Some(1_000_000), until_ns].into_iter().flatten().collect::<Vec<_>>();
        assert_eq!(silent, expected);
        server.shutdown().await;
    }
}

/// Ten robots, whose cables are slow and whose brains think long.
fn slow() -> (String, Vec<String>) {
    let mut changes = vec!["end.after_s=2.0".to_owned(), "substeps=4".to_owned()];
    for name in names(10) {
        changes.push(format!("robots.{name}.link.baud=1200"));
        changes.push(format!("robots.{name}.brain.thinking_us=60000.0"));
    }
    (crowd(&names(10)), changes)
}

async fn serve_slow(pace: Pace) -> Server {
    let (toml, changes) = slow();
    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
    serve(scenario(&toml, &changes), pace).await
}

async fn attach_all(client: &Client) -> baudbot_client::Fleet {
    let names = names(10);
    client.attach_many("w", &names.iter().map(String::as_str).collect::<Vec<_>>()).await.unwrap()
}

const CONSTANT: &str = "constant:left=0.2,right=0.3";

/// The fingerprints of all states that the world of [`slow`] goes through in strict lockstep.
fn all_states() -> HashSet<u64> {
    let (toml, changes) = slow();
    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
    let mut local = InProcess::new(scenario(&toml, &changes), CONSTANT).unwrap();
    let mut states = HashSet::new();
    while local.world.ending().is_none() {
        states.insert(local.world.hash());
        local.tick(|world| {
            states.insert(world.hash());
        });
    }
    local.world.begin();
    states.insert(local.world.hash());
    states
}

#[tokio::test]
async fn who_looks_sees_only_what_strict_lockstep_would_show() {
    let states = all_states();
    let server = serve_slow(lockstep()).await;
    let mut fleet = attach_all(&client(&server).await.thinks_as_scenario()).await;
    let brain = |body: &_| catalogue::brain(CONSTANT, 1, body).unwrap();
    let mut brains: Vec<_> = fleet.bodies().iter().map(|body| brain(body)).collect();
    let mut ticks = HashSet::new();
    while let Some(turns) = fleet.turns().await.unwrap() {
        // The world has the time to go ahead; an observer that asks then waits for the answer.
        tokio::time::sleep(Duration::from_millis(3)).await;
        let actions: Vec<_> = turns
            .iter()
            .map(|(robot, turn)| (*robot, Action { until: None, ..brains[*robot].step(turn) }))
            .collect();
        let act = async {
            tokio::time::sleep(Duration::from_millis(2)).await;
            fleet.act(&actions).await.unwrap();
        };
        let (status, ()) = tokio::join!(status(&server), act);
        assert!(states.contains(&status.state_hash), "tick {}", status.tick);
        ticks.insert(status.tick - turns[0].1.tick);
    }
    assert!(states.contains(&status(&server).await.state_hash));
    assert!(ticks.iter().any(|&ahead| ahead > 1), "the world never went ahead: {ticks:?}");
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_is_silent_for_long_hides_the_world_only_until_the_watchdog_looks() {
    let server = serve_slow(watched(50, WatchdogPolicy::Wait)).await;
    let mut fleet = attach_all(&client(&server).await.thinks_as_scenario()).await;
    fleet.turns().await.unwrap().unwrap();
    tokio::time::sleep(Duration::from_millis(20)).await;
    let seen = tokio::time::timeout(Duration::from_secs(5), status(&server)).await.expect("an answer");
    assert!(seen.tick < 20, "{}", seen.tick);
    server.shutdown().await;
}

/// The server may not know yet that the last brain is gone.
async fn attach_patiently(server: &Server) -> baudbot_client::Fleet {
    let names = names(10);
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    loop {
        match client(server).await.thinks_as_scenario().attach_many("w", &names).await {
            Ok(fleet) => return fleet,
            Err(_) => tokio::time::sleep(Duration::from_millis(5)).await,
        }
    }
}

#[tokio::test]
async fn a_brain_that_goes_while_the_world_is_ahead_leaves_its_robots_to_another() {
    for policy in [WatchdogPolicy::Wait, WatchdogPolicy::GoOn, WatchdogPolicy::Detach] {
        let server = serve_slow(watched(10_000, policy)).await;
        for _ in 0..5 {
            let mut fleet = attach_patiently(&server).await;
            for _ in 0..3 {
                // The run may be over if the world does not wait for a brain that is gone.
                let Some(turns) = fleet.turns().await.unwrap() else { break };
                let actions: Vec<_> = turns.iter().map(|(robot, _)| (*robot, Action::wait())).collect();
                fleet.act(&actions).await.unwrap();
            }
            // The world has the time to go ahead of the last Turn, which is not answered.
            let _ = tokio::time::timeout(Duration::from_millis(20), fleet.turns()).await;
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        let mut fleet = attach_patiently(&server).await;
        while let Some(turns) = fleet.turns().await.unwrap() {
            let actions: Vec<_> = turns.iter().map(|(robot, _)| (*robot, Action::drive(0.2, 0.2))).collect();
            fleet.act(&actions).await.unwrap();
        }
        assert!(!status(&server).await.ending.is_empty());
        server.shutdown().await;
    }
}

#[tokio::test]
async fn a_reset_while_the_world_is_ahead_begins_the_same_run_anew() {
    let expected = {
        let server = serve_slow(strict()).await;
        let mut fleet = attach_all(&client(&server).await.thinks_as_scenario()).await;
        drive(&mut fleet).await;
        status(&server).await.state_hash
    };
    let server = serve_slow(lockstep()).await;
    let mut fleet = attach_all(&client(&server).await.thinks_as_scenario()).await;
    for _ in 0..3 {
        fleet.turns().await.unwrap().unwrap();
        tokio::time::sleep(Duration::from_millis(10)).await;
        let reset = v1::ResetWorldRequest { world: "w".into(), ..Default::default() };
        operator(&server).await.reset_world(reset).await.unwrap();
    }
    drive(&mut fleet).await;
    assert_eq!(status(&server).await.state_hash, expected);
    server.shutdown().await;
}

async fn drive(fleet: &mut baudbot_client::Fleet) {
    while let Some(turns) = fleet.turns().await.unwrap() {
        let actions: Vec<_> = turns.iter().map(|(robot, _)| (*robot, Action::drive(0.2, 0.3))).collect();
        fleet.act(&actions).await.unwrap();
    }
}

#[tokio::test]
async fn a_promise_that_is_broken_ends_the_stream_and_names_the_field() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let mut robot = client(&server).await.thinks_as_scenario().attach("w", "robot").await.unwrap();
    robot.turn().await.unwrap().unwrap();
    robot.act(Action::wait().after(Duration::from_millis(1))).await.unwrap();
    match robot.turn().await {
        Err(Error::Status { code: Code::FailedPrecondition, message }) => {
            assert!(message.starts_with("step.robots[0].thinking_ns: "), "{message}");
        }
        other => panic!("{other:?}"),
    }
    server.shutdown().await;
}
