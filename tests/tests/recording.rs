//! Recordings of operators: made, listed, replayed forwards and backwards, gone on from; states by value.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use baudbot_client::{Client, Error};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::intervene_request::Intervention;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_recording::{RecordedRun, Replay};
use baudbot_server::{Pace, Server, WatchdogPolicy, WorldConfig};
use baudbot_tests::system::{client, drive, lockstep, operator, serve, status, watched};
use baudbot_tests::{WANDER, scenario};
use tonic::Code;
use tonic::transport::Channel;

/// A folder of this test's own.
fn folder() -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let path = std::env::temp_dir().join(format!("baudbot-recordings-{}-{number}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

async fn with_folder(folder: &Path, pace: Pace, changes: &[&str]) -> Server {
    let world = WorldConfig::new("w", scenario(WANDER, changes)).pace(pace);
    Server::builder().world(world).recordings(folder.to_owned()).in_process().await.unwrap()
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

fn named(world: &str) -> v1::StartRecordingRequest {
    v1::StartRecordingRequest { world: world.into(), recording: "run".into(), look_hz: 0.0 }
}

async fn stop(operator: &mut ControlServiceClient<Channel>) -> v1::RecordingStatus {
    let request = v1::StopRecordingRequest { world: "w".into() };
    operator.stop_recording(request).await.unwrap().into_inner().recording.unwrap()
}

#[tokio::test]
async fn an_operator_records_a_part_of_a_run_and_replays_it() {
    let folder = folder();
    let server = with_folder(&folder, lockstep(), &["end.after_s=2.0"]).await;
    let mut operator = operator(&server).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    for _ in 0..50 {
        robot.turn().await.unwrap().unwrap();
        robot.pass().await.unwrap();
    }
    let recording =
        operator.start_recording(named("w")).await.unwrap().into_inner().status.unwrap().recording;
    let recording = recording.unwrap();
    assert_eq!((recording.recording.as_str(), recording.problem.as_str()), ("run", ""));
    let twice = operator.start_recording(named("w")).await.unwrap_err();
    assert_eq!(
        (twice.code(), twice.message()),
        (Code::FailedPrecondition, "world: `w` is being recorded as `run`")
    );
    drop(robot);
    drive(&client(&server).await, "robot", "wander:forward=0.3", 5).await;
    let hash = status(&server).await.state_hash;
    let closed = stop(&mut operator).await;
    assert!(closed.ticks > 100 && closed.bytes > 5000 && closed.problem.is_empty(), "{closed:?}");
    assert_eq!(replayed(&folder.join("run.mcap")), (200, hash));
    let none = operator.stop_recording(v1::StopRecordingRequest { world: "w".into() }).await.unwrap_err();
    assert_eq!((none.code(), none.message()), (Code::FailedPrecondition, "world: `w` is not being recorded"));
    let again = operator.start_recording(named("w")).await.unwrap_err();
    assert_eq!(again.code(), Code::AlreadyExists, "{again:?}");
    let listed =
        operator.list_recordings(v1::ListRecordingsRequest {}).await.unwrap().into_inner().recordings;
    assert_eq!((listed.len(), listed[0].recording.as_str(), listed[0].bytes), (1, "run", closed.bytes));
    server.shutdown().await;
}

/// A server that replays two seconds of `wander`, and the world's fingerprint at each tick.
async fn replaying(folder: &Path) -> Server {
    let first = with_folder(folder, lockstep(), &["end.after_s=2.0"]).await;
    operator(&first).await.start_recording(named("w")).await.unwrap();
    drive(&client(&first).await, "robot", "avoid", 1).await;
    stop(&mut operator(&first).await).await;
    first.shutdown().await;
    let server = Server::builder().recordings(folder.to_owned()).in_process().await.unwrap();
    let open = v1::OpenRecordingRequest { recording: "run".into(), world: "w".into() };
    let opened = operator(&server).await.open_recording(open).await.unwrap().into_inner().status.unwrap();
    assert_eq!((opened.state(), opened.tick), (v1::WorldState::Paused, 0));
    server
}

async fn seek(server: &Server, tick: u64) -> v1::WorldStatus {
    let request = v1::SeekReplayRequest { world: "w".into(), tick };
    operator(server).await.seek_replay(request).await.unwrap().into_inner().status.unwrap()
}

#[tokio::test]
async fn a_replay_is_an_ordinary_world_for_observers_and_goes_both_ways() {
    let folder = folder();
    let server = replaying(&folder).await;
    let mut operator = operator(&server).await;
    let described = v1::DescribeReplayRequest { world: "w".into() };
    let described = operator.describe_replay(described).await.unwrap().into_inner();
    assert_eq!((described.first_tick, described.last_tick, described.cut_off), (0, 200, false));
    let texts: Vec<_> = described.events.iter().map(|event| event.text.as_str()).collect();
    assert!(texts.contains(&"`brain` drives `robot`"), "{texts:?}");
    assert!(texts.contains(&"the run has ended: the scenario's time is over"), "{texts:?}");
    let mut observe = ObserveServiceClient::new(server.channel().await.unwrap());
    let watch = v1::WatchRequest {
        world: "w".into(),
        every_ticks: 10,
        details: vec!["robot".into()],
        ..Default::default()
    };
    let mut frames = observe.watch(watch).await.unwrap().into_inner();
    assert_eq!(frames.message().await.unwrap().unwrap().tick, 0);
    let mut hashes = Vec::new();
    for tick in [150, 37, 200, 37, 36, 150] {
        let status = seek(&server, tick).await;
        let replay = status.replay.unwrap();
        assert_eq!((status.tick, replay.last_tick, replay.differs.as_str()), (tick, 200, ""));
        let frame = frames.message().await.unwrap().unwrap();
        assert_eq!(frame.tick, tick);
        assert!(frame.robots[0].x_m.is_finite() && !frame.details[0].sensors[0].values.is_empty());
        hashes.push(status.state_hash);
    }
    assert_eq!((hashes[0], hashes[1]), (hashes[5], hashes[3]));
    assert_ne!(hashes[3], hashes[4]);
    // The replay makes a step, and runs by the clock to its end.
    let stepped = v1::pace::Kind::Stepped(v1::Stepped::default());
    let pace = |kind| v1::SetPaceRequest { world: "w".into(), pace: Some(v1::Pace { kind: Some(kind) }) };
    operator.set_pace(pace(stepped)).await.unwrap();
    let step = v1::StepWorldRequest { world: "w".into(), ticks: 3 };
    assert_eq!(operator.step_world(step).await.unwrap().into_inner().status.unwrap().tick, 153);
    operator
        .set_pace(pace(v1::pace::Kind::Scaled(v1::Scaled { factor: 10.0, max_lag_ms: 0 })))
        .await
        .unwrap();
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    while let Some(frame) = frames.message().await.unwrap() {
        if !frame.ending.is_empty() {
            assert_eq!(frame.tick, 200);
            break;
        }
    }
    assert_eq!(status(&server).await.state_hash, hashes[2]);
    server.shutdown().await;
}

#[tokio::test]
async fn a_replay_refuses_what_would_change_it_until_it_is_forked() {
    let folder = folder();
    let server = replaying(&folder).await;
    let mut operator = operator(&server).await;
    seek(&server, 100).await;
    let world = || "w".to_owned();
    let refused = client(&server).await.attach("w", "robot").await.err().unwrap().to_string();
    assert!(refused.contains("replays a recording, and can have a brain only after ForkReplay"), "{refused}");
    let pull = Intervention::PullCable(v1::PullCable { robot: "robot".into(), pulled: true });
    let change = v1::InterveneRequest { world: world(), intervention: Some(pull) };
    assert_eq!(operator.intervene(change).await.unwrap_err().code(), Code::FailedPrecondition);
    let reset = operator.reset_world(v1::ResetWorldRequest { world: world(), ..Default::default() }).await;
    assert_eq!(reset.unwrap_err().code(), Code::FailedPrecondition);
    assert_eq!(operator.start_recording(named("w")).await.unwrap_err().code(), Code::FailedPrecondition);
    let before = status(&server).await.state_hash;
    let cloned = v1::CloneWorldRequest { original: world(), ..Default::default() };
    let cloned = operator.clone_world(cloned).await.unwrap().into_inner().status.unwrap();
    assert_eq!((cloned.tick, cloned.state_hash, cloned.replay), (100, before, None), "a live clone");
    let pace = v1::Pace { kind: Some(v1::pace::Kind::Lockstep(v1::Lockstep::default())) };
    let forked = v1::ForkReplayRequest { world: world(), pace: Some(pace) };
    let forked = operator.fork_replay(forked).await.unwrap().into_inner().status.unwrap();
    assert_eq!((forked.tick, forked.state_hash, forked.replay), (100, before, None));
    let live = operator.seek_replay(v1::SeekReplayRequest { world: world(), tick: 3 }).await.unwrap_err();
    assert_eq!((live.code(), live.message()), (Code::FailedPrecondition, "world: `w` is live, not a replay"));
    // The world has a brain from here on, and a recording of its own.
    let request = v1::StartRecordingRequest { recording: "fork".into(), ..named("w") };
    operator.start_recording(request).await.unwrap();
    operator.start_world(v1::StartWorldRequest { world: world() }).await.unwrap();
    drive(&client(&server).await, "robot", "constant:left=0.1,right=0.1", 1).await;
    let hash = status(&server).await.state_hash;
    stop(&mut operator).await;
    assert_eq!(replayed(&folder.join("fork.mcap")), (200, hash));
    server.shutdown().await;
}

#[tokio::test]
async fn a_reset_begins_another_file() {
    let folder = folder();
    let server = with_folder(&folder, lockstep(), &["end.after_s=1.0"]).await;
    let mut operator = operator(&server).await;
    operator.start_recording(named("w")).await.unwrap();
    drive(&client(&server).await, "robot", "avoid", 1).await;
    let first = status(&server).await;
    let world = || "w".to_owned();
    operator.reset_world(v1::ResetWorldRequest { world: world(), ..Default::default() }).await.unwrap();
    assert_eq!(status(&server).await.recording.unwrap().recording, "run-2");
    drive(&client(&server).await, "robot", "wander:forward=0.3", 1).await;
    let second = status(&server).await;
    // A world that is deleted closes its file.
    operator.delete_world(v1::DeleteWorldRequest { world: world() }).await.unwrap();
    server.shutdown().await;
    assert_eq!(replayed(&folder.join("run.mcap")), (100, first.state_hash));
    assert_eq!(replayed(&folder.join("run-2.mcap")), (100, second.state_hash));
    assert_ne!(first.state_hash, second.state_hash);
}

#[tokio::test]
async fn changes_by_hand_are_inputs_and_so_are_late_answers() {
    let folder = folder();
    // The world goes ahead of this brain, whose answers come late: `drive` promises to think as the scenario states.
    let server = with_folder(&folder, lockstep(), &["end.after_s=3.0"]).await;
    let mut operator = operator(&server).await;
    operator.start_recording(named("w")).await.unwrap();
    let (brain, own) = (client(&server).await, operator.clone());
    let hands = async move {
        let mut operator = own;
        for (i, pulled) in [true, false, true, false].into_iter().enumerate() {
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
            let pull = Intervention::PullCable(v1::PullCable { robot: "robot".into(), pulled });
            let baud =
                Intervention::SetBaud(v1::SetBaud { robot: "robot".into(), baud: 4800 + 4800 * i as u32 });
            for change in [pull, baud] {
                // The run may be over.
                let request = v1::InterveneRequest { world: "w".into(), intervention: Some(change) };
                let _ = operator.intervene(request).await;
            }
        }
    };
    tokio::join!(drive(&brain, "robot", "avoid", 3), hands);
    let hash = status(&server).await.state_hash;
    stop(&mut operator).await;
    assert_eq!(replayed(&folder.join("run.mcap")), (300, hash));
    server.shutdown().await;
}

#[tokio::test]
async fn a_change_at_the_first_tick_and_one_that_is_sought_are_made_once() {
    let folder = folder();
    let server = with_folder(&folder, lockstep(), &["end.after_s=4.0"]).await;
    let mut operator = operator(&server).await;
    let world = || "w".to_owned();
    operator.pause_world(v1::PauseWorldRequest { world: world() }).await.unwrap();
    operator.start_recording(named("w")).await.unwrap();
    let place = |x_m: f64| {
        let placed = v1::PlaceRobot { robot: "robot".into(), x_m, y_m: 0.1, heading_rad: 0.5 };
        v1::InterveneRequest { world: world(), intervention: Some(Intervention::PlaceRobot(placed)) }
    };
    operator.intervene(place(0.1)).await.unwrap();
    let kind = v1::pace::Kind::Stepped(v1::Stepped::default());
    let pace = v1::SetPaceRequest { world: world(), pace: Some(v1::Pace { kind: Some(kind) }) };
    operator.set_pace(pace).await.unwrap();
    operator.start_world(v1::StartWorldRequest { world: world() }).await.unwrap();
    let step = |ticks| v1::StepWorldRequest { world: world(), ticks };
    operator.step_world(step(100)).await.unwrap();
    let changed = operator.intervene(place(0.2)).await.unwrap().into_inner().status.unwrap().tick;
    operator.step_world(step(250)).await.unwrap();
    stop(&mut operator).await;
    let (last, _) = replayed(&folder.join("run.mcap"));
    let open = v1::OpenRecordingRequest { recording: "run".into(), world: "again".into() };
    operator.open_recording(open).await.unwrap();
    for tick in
        [changed + 128, changed + 200, changed + 130, changed, changed + 1, changed - 1, changed, 0, last]
    {
        let tick = tick.min(last);
        let sought = v1::SeekReplayRequest { world: "again".into(), tick };
        let status = operator.seek_replay(sought).await.unwrap().into_inner().status.unwrap();
        assert_eq!((status.tick, status.replay.unwrap().differs.as_str()), (tick, ""));
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_is_given_up_while_the_world_is_ahead_is_replayed() {
    let folder = folder();
    let slow = ["end.after_s=3.0", "robots.robot.brain.thinking_us=20000.0", "robots.robot.link.baud=2400"];
    for (i, policy) in [WatchdogPolicy::GoOn, WatchdogPolicy::Detach].into_iter().enumerate() {
        let server = with_folder(&folder, watched(40, policy), &slow).await;
        let mut operator = operator(&server).await;
        let recording = format!("given-up-{i}");
        operator
            .start_recording(v1::StartRecordingRequest { recording: recording.clone(), ..named("w") })
            .await
            .unwrap();
        let client = client(&server).await;
        // The brain answers for a while, and then no more.
        let mut robot = client.attach("w", "robot").await.unwrap();
        let mut brain = baudbot_brains::catalogue::brain("avoid", 1, robot.body()).unwrap();
        let driven = baudbot_client::run(&mut robot, &mut brain);
        let _ = tokio::time::timeout(std::time::Duration::from_millis(3), driven).await;
        tokio::time::sleep(std::time::Duration::from_millis(150)).await;
        drop(robot);
        operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
        while status(&server).await.ending.is_empty() {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        let hash = status(&server).await.state_hash;
        stop(&mut operator).await;
        assert_eq!(replayed(&folder.join(format!("{recording}.mcap"))), (300, hash));
        server.shutdown().await;
    }
}

/// Drives the robot of world `w`, and starts over at the operator's request; returns how often.
async fn drive_and_restart(client: Client) -> u32 {
    let client = client.thinks_as_scenario();
    for restarts in 0.. {
        let mut robot = client.attach("w", "robot").await.unwrap();
        let mut brain = baudbot_brains::catalogue::brain("wander:forward=0.3", 5, robot.body()).unwrap();
        match baudbot_client::run(&mut robot, &mut brain).await {
            Err(Error::Restart) => {}
            done => {
                done.unwrap();
                return restarts;
            }
        }
    }
    unreachable!("a run has an end")
}

/// Records and replays a run of 20 s whose brain is restarted some times: how often that was done, and how often the
/// brain's program has started over.
async fn restarted(folder: &Path, pace: Pace, waits: bool, recording: &str) -> (u32, u32) {
    let slow = ["robots.robot.brain.thinking_us=20000.0", "robots.robot.link.baud=2400"];
    let server =
        with_folder(folder, pace, &[&slow[..], &["end.after_s=20.0", "collision=stop-robot"]].concat()).await;
    let mut operator = operator(&server).await;
    let start = v1::StartRecordingRequest { recording: recording.to_owned(), ..named("w") };
    operator.start_recording(start).await.unwrap();
    let program = tokio::spawn(drive_and_restart(client(&server).await));
    let mut done = 0;
    for tick in [100, 500, 900] {
        while status(&server).await.tick < tick {}
        let restart = v1::DetachBrain { robot: "robot".into(), restart: true };
        let change = Some(Intervention::DetachBrain(restart));
        let asked = v1::InterveneRequest { world: "w".into(), intervention: change };
        // One that has not come back yet cannot be thrown off; a world that waits for it is asked again.
        let mut answer = operator.intervene(asked.clone()).await;
        while let (true, Err(refused)) = (waits, &answer) {
            assert_eq!(refused.code(), Code::FailedPrecondition, "{refused}");
            answer = operator.intervene(asked.clone()).await;
        }
        done += u32::from(answer.is_ok());
    }
    let begun = program.await.unwrap();
    let hash = status(&server).await.state_hash;
    stop(&mut operator).await;
    let file = folder.join(format!("{recording}.mcap"));
    assert_eq!(replayed(&file), (2000, hash));
    let recorded = RecordedRun::open(&file).unwrap();
    let text = "the brain of `robot` is gone: the operator restarts this brain";
    let told = recorded.events().iter().filter(|event| event.text == text).count();
    assert_eq!(told, done as usize, "{:?}", recorded.events());
    server.shutdown().await;
    (done, begun)
}

#[tokio::test]
async fn a_brain_that_is_restarted_is_replayed() {
    let folder = folder();
    // The world goes ahead of its brain, and waits for another.
    assert_eq!(restarted(&folder, lockstep(), true, "waits").await, (3, 3));
    // The world goes on alone: it may be over when the brain is there again, which is no reason to start over.
    let go_on = watched(10_000, WatchdogPolicy::GoOn);
    let (done, begun) = restarted(&folder, go_on, false, "goes-on").await;
    assert!(begun > 0 && begun <= done, "{begun} of {done}");
}

#[tokio::test]
async fn a_state_by_value_goes_on_in_another_server() {
    let first = serve(scenario(WANDER, &["end.after_s=2.0"]), lockstep()).await;
    let mut robot = client(&first).await.attach("w", "robot").await.unwrap();
    for _ in 0..20 {
        robot.turn().await.unwrap().unwrap();
        robot.drive(baudbot_client::Signals { left: 0.3, right: 0.2 }).await.unwrap();
    }
    let request = v1::PauseWorldRequest { world: "w".into() };
    operator(&first).await.pause_world(request).await.unwrap();
    drop(robot);
    let request = v1::SaveWorldRequest { world: "w".into(), snapshot: 0 };
    let saved = operator(&first).await.save_world(request).await.unwrap().into_inner();
    let here = status(&first).await;
    assert_eq!((saved.tick, saved.state_hash), (here.tick, here.state_hash));
    let second = Server::builder().in_process().await.unwrap();
    let pace = v1::Pace { kind: Some(v1::pace::Kind::Lockstep(v1::Lockstep::default())) };
    let request = v1::CreateWorldRequest {
        saved_mcap: saved.saved_mcap.clone(),
        pace: Some(pace),
        paused: true,
        ..Default::default()
    };
    let mut other = operator(&second).await;
    let made = other.create_world(request.clone()).await.unwrap().into_inner().status.unwrap();
    assert_eq!((made.world.as_str(), made.tick, made.state_hash), ("w", here.tick, here.state_hash));
    for server in [&first, &second] {
        // A world in lockstep that is started without a brain goes on without.
        let mut robot = client(server).await.attach("w", "robot").await.unwrap();
        operator(server).await.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
        let mut brain = baudbot_brains::catalogue::brain("avoid", 1, robot.body()).unwrap();
        baudbot_client::run(&mut robot, &mut brain).await.unwrap();
    }
    assert_eq!(status(&second).await.state_hash, status(&first).await.state_hash);
    let both = v1::CreateWorldRequest { scenario_toml: WANDER.into(), world: "x".into(), ..request.clone() };
    let refused = other.create_world(both).await.unwrap_err();
    assert_eq!(
        refused.message(),
        "saved_mcap: has a scenario of its own; leave scenario_toml and overrides empty"
    );
    let mut damaged = request;
    damaged.saved_mcap.truncate(saved.saved_mcap.len() / 3);
    let refused = other.create_world(damaged).await.unwrap_err();
    assert!(
        refused.code() == Code::InvalidArgument && refused.message().starts_with("saved_mcap: "),
        "{refused:?}"
    );
    first.shutdown().await;
    second.shutdown().await;
}

#[tokio::test]
async fn names_and_files_of_strangers_are_refused() {
    let folder = folder();
    std::fs::write(folder.join("junk.mcap"), "junk").unwrap();
    let server = with_folder(&folder, Pace::REAL_TIME, &[]).await;
    let mut operator = operator(&server).await;
    for name in ["../run", "a/b", ".hidden", "x y"] {
        let request = v1::StartRecordingRequest { recording: name.into(), ..named("w") };
        assert_eq!(
            operator.start_recording(request).await.unwrap_err().code(),
            Code::InvalidArgument,
            "{name}"
        );
        let request = v1::OpenRecordingRequest { recording: name.into(), world: "x".into() };
        assert_eq!(
            operator.open_recording(request).await.unwrap_err().code(),
            Code::InvalidArgument,
            "{name}"
        );
    }
    let request = v1::OpenRecordingRequest { recording: "none".into(), world: "x".into() };
    assert_eq!(operator.open_recording(request).await.unwrap_err().code(), Code::NotFound);
    let request = v1::OpenRecordingRequest { recording: "junk".into(), world: "x".into() };
    let refused = operator.open_recording(request).await.unwrap_err();
    assert!(refused.message().starts_with("recording: `junk` is not an MCAP file"), "{refused:?}");
    let request = v1::StartRecordingRequest { look_hz: -1.0, ..named("w") };
    let refused = operator.start_recording(request).await.unwrap_err();
    assert_eq!(refused.message(), "look_hz: must be from 0 to 1000, is -1");
    server.shutdown().await;
    let closed = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let refused = self::operator(&closed).await.start_recording(named("w")).await.unwrap_err();
    assert!(refused.message().contains("start it with --recordings FOLDER"), "{refused:?}");
    closed.shutdown().await;
}
