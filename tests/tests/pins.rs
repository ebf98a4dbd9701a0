//! The pins of a robot's chip, for observers.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_proto::v1::PinEventKind as Kind;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_sim::{Ending, RobotView, Scenario, World};
use baudbot_tests::system::{operator, serve, serve_on_ports, status};
use baudbot_tests::{WANDER, scenario};
use tonic::Streaming;
use tonic::transport::Channel;

const STEPPED: fn() -> Pace = || Pace::Stepped(Lockstep::default());

/// A robot whose program sends what it sees, and drives its motors by PWM.
fn firmware() -> Scenario {
    of_catalogue(include_str!("../../catalogue/scenarios/firmware.toml"), &[])
}

fn of_catalogue(text: &str, changes: &[&str]) -> Scenario {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios"));
    scenario(&baudbot_import::inline(text, folder).unwrap(), changes)
}

/// The world of a scenario with a robot that drives itself, up to an instant or the end.
fn run(world: &mut World, until_s: f64) -> RobotView<'_> {
    while world.time().as_seconds() < until_s && world.ending().is_none() {
        world.begin();
        world.finish(&[]);
    }
    world.robot(0)
}

/// The program waits for a press, not for the bounces of the contact; then the potentiometer says how fast it follows the line.
#[test]
fn a_person_starts_a_robot_that_follows_a_line_by_modules() {
    let modules = |changes: &[&str]| {
        World::new(Arc::new(of_catalogue(include_str!("../../catalogue/scenarios/modules.toml"), changes)))
    };
    let mut world = modules(&[]);
    let distances_m = [1.0, 3.0, 6.0, 9.0].map(|until_s| run(&mut world, until_s).counters().distance_m);
    assert_eq!(distances_m[0], 0.0);
    let [slow, fast] = [(distances_m[2] - distances_m[1]) / 3.0, (distances_m[3] - distances_m[2]) / 3.0];
    assert!(slow > 0.03 && (1.4..1.8).contains(&(fast / slow)), "{slow} and {fast} m/s");
    run(&mut world, 60.0);
    assert!(matches!(world.ending(), Some(Ending::AllGoals)), "{:?}", world.ending());
    assert_eq!(world.robot(0).counters().collisions, 0);
    // With the screws so low that all is black to the modules it drives straight on, and into the wall.
    let mut blind = modules(&["robots.robot.pins.3.threshold_v=0.1", "robots.robot.pins.4.threshold_v=0.1"]);
    assert!(run(&mut blind, 60.0).counters().collisions > 0);
    let mut unpressed = modules(&["robots.robot.operations=[]"]);
    assert_eq!(run(&mut unpressed, 5.0).counters().distance_m, 0.0);
}

/// Ahead for two seconds, a turn to the left for half a second, ahead again; each motor by its own bits of the register.
#[test]
fn a_motor_shield_obeys_what_its_library_shifts_in() {
    let text = include_str!("../../catalogue/scenarios/motor-shield.toml");
    let poses = |changes: &[&str]| {
        let mut world = World::new(Arc::new(of_catalogue(text, changes)));
        [2.0, 2.6, 4.4, 6.0].map(|until_s| {
            let motion = *run(&mut world, until_s).motion();
            (motion.pose, motion.speed_m_s)
        })
    };
    let [ahead, turned, again, stopped] = poses(&[]);
    let start = ahead.0.position;
    // The left motor is latched a moment before the right one.
    assert!(start.x > -0.7 && (start.y + 0.5).abs() < 1e-3, "{ahead:?}");
    assert!(turned.0.heading > 0.5, "{turned:?}");
    assert!((again.0.position - turned.0.position).norm() > 0.3, "{again:?}");
    assert!(stopped.1.abs() < 1e-3, "{stopped:?}");
    // With both motors' numbers exchanged it turns to the right.
    let exchanged = poses(&["robots.robot.pins.11.channel=2", "robots.robot.pins.3.channel=1"]);
    assert!((exchanged[1].0.heading + turned.0.heading).abs() < 1e-3, "{:?}", exchanged[1]);
}

/// A connection to the server's TCP port.
async fn socket(server: &Server) -> Channel {
    let address = format!("http://{}", server.addresses()[1]);
    tonic::transport::Endpoint::from_shared(address).unwrap().connect().await.unwrap()
}

async fn watch(channel: Channel, pins: bool) -> Streaming<v1::WatchResponse> {
    let details = vec!["robot".into()];
    let request =
        v1::WatchRequest { world: "w".into(), every_ticks: 5, details, pins, pins_finest_ns: 1_000_000 };
    ObserveServiceClient::new(channel).watch(request).await.unwrap().into_inner()
}

/// A robot that drives itself needs no brain.
async fn step(server: &Server, ticks: u64) {
    let start = v1::StartWorldRequest { world: "w".into() };
    operator(server).await.start_world(start).await.unwrap();
    let request = v1::StepWorldRequest { world: "w".into(), ticks };
    operator(server).await.step_world(request).await.unwrap();
}

/// The events on pins of the frames up to this tick.
async fn events(frames: &mut Streaming<v1::WatchResponse>, tick: u64) -> Vec<v1::PinEvent> {
    let mut events = Vec::new();
    loop {
        let frame = frames.message().await.unwrap().unwrap();
        let detail = &frame.details[0];
        assert_eq!(detail.missed_pin_events, 0);
        events.extend(detail.pin_events.iter().copied());
        if frame.tick >= tick {
            return events;
        }
    }
}

async fn signals(server: &Server) -> Vec<v1::PinSignal> {
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let world = v1::DescribeWorldRequest { world: "w".into() };
    observer.describe_world(world).await.unwrap().into_inner().robots[0].pins.clone()
}

fn place(signals: &[v1::PinSignal], name: &str) -> u32 {
    signals.iter().position(|signal| signal.signal == name).unwrap() as u32
}

#[tokio::test]
async fn who_asks_for_pins_is_told_what_is_on_them_and_changes_no_bit() {
    let alone = serve(firmware(), STEPPED()).await;
    step(&alone, 80).await;
    let server = serve_on_ports(firmware(), STEPPED()).await;
    let signals = signals(&server).await;
    let mut with = watch(socket(&server).await, true).await;
    let mut without = watch(socket(&server).await, false).await;
    let mut told = Vec::new();
    for tick in (10..=80).step_by(10) {
        step(&server, 10).await;
        // Frames of an observer that does not read are lost. The frame of the last tick comes with the next one.
        told.extend(events(&mut with, tick - 5).await);
        assert!(events(&mut without, tick - 5).await.is_empty());
    }
    assert_eq!(status(&server).await.state_hash, status(&alone).await.state_hash);

    let of = |name: &str| {
        let place = place(&signals, name);
        let all: Vec<_> = told.iter().filter(|event| event.signal == place).collect();
        assert!(all.is_sorted_by_key(|event| event.at_ns), "{name}: {all:?}");
        all
    };
    // Fast PWM with counts of 0.5 µs, 256 in a period: high for 71 of them when it goes ahead.
    let pulses: Vec<_> = of("D9").into_iter().filter(|event| event.kind() == Kind::Pulses).collect();
    let is_ahead = |event: &&&v1::PinEvent| {
        let (long_ns, count) = (event.until_ns - event.at_ns, u64::from(event.pulses));
        event.even && long_ns == count * 128_000 && event.high_ns == count * 71 * 500
    };
    assert!(pulses.iter().filter(is_ahead).count() > 2, "{pulses:?}");
    let numbers =
        |name| of(name).into_iter().filter(|event| event.kind() == Kind::Number).map(|event| event.number);
    let text: String = numbers("uart sent").filter_map(char::from_u32).collect();
    let line = text.lines().next().unwrap();
    let results: Vec<u32> = line.split(' ').map(|number| number.parse().unwrap()).collect();
    assert_eq!(results.len(), 5, "{text}");
    assert!(numbers("adc0").any(|result| result == results[0]), "{line}");
    let led = &signals[place(&signals, "D13") as usize];
    assert_eq!((led.on.as_slice(), led.kind()), (&["leds.builtin".to_owned()][..], v1::PinSignalKind::Pin));
    server.shutdown().await;
}

#[tokio::test]
async fn one_who_comes_later_is_told_what_holds() {
    let server = serve_on_ports(firmware(), STEPPED()).await;
    let signals = signals(&server).await;
    step(&server, 30).await;
    let mut frames = watch(socket(&server).await, true).await;
    let told = events(&mut frames, 30).await;
    let first = told.iter().filter(|event| event.signal == place(&signals, "D9")).count();
    assert_eq!(first, 1, "nobody has looked before: {told:?}");
    let before = told.len();
    step(&server, 10).await;
    let told: Vec<_> = told.into_iter().chain(events(&mut frames, 35).await).collect();
    let is_pin = |kind| [v1::PinSignalKind::Pin, v1::PinSignalKind::UartPin].contains(&kind);
    // The signals that change just then come a little later.
    for (place, signal) in signals.iter().enumerate().filter(|(_, signal)| is_pin(signal.kind())) {
        assert!(told.iter().any(|event| event.signal as usize == place), "{signal:?}");
    }
    // Another one has what is kept by now.
    let mut frames = watch(socket(&server).await, true).await;
    assert!(events(&mut frames, 40).await.len() > before);
    server.shutdown().await;
}

#[tokio::test]
async fn a_robot_without_a_program_has_no_pins() {
    let server = serve(scenario(WANDER, &[]), STEPPED()).await;
    assert!(signals(&server).await.is_empty());
    let mut frames = watch(server.channel().await.unwrap(), true).await;
    assert!(frames.message().await.unwrap().unwrap().details[0].pin_events.is_empty());
    server.shutdown().await;
}

fn folder() -> PathBuf {
    let path = std::env::temp_dir().join(format!("baudbot-pins-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

#[tokio::test]
async fn behind_a_jump_in_a_replay_the_time_before_is_told() {
    let folder = folder();
    let world = WorldConfig::new("w", firmware()).pace(STEPPED());
    let first = Server::builder().world(world).recordings(folder.clone()).in_process().await.unwrap();
    let request = v1::StartRecordingRequest { world: "w".into(), recording: "run".into(), look_hz: 0.0 };
    operator(&first).await.start_recording(request).await.unwrap();
    step(&first, 400).await;
    let stop = v1::StopRecordingRequest { world: "w".into() };
    operator(&first).await.stop_recording(stop).await.unwrap();
    first.shutdown().await;

    let server = Server::builder().recordings(folder).in_process().await.unwrap();
    let open = v1::OpenRecordingRequest { recording: "run".into(), world: "w".into() };
    operator(&server).await.open_recording(open).await.unwrap();
    let signals = signals(&server).await;
    let mut frames = watch(server.channel().await.unwrap(), true).await;
    events(&mut frames, 0).await;
    for tick in [350, 150] {
        let seek = v1::SeekReplayRequest { world: "w".into(), tick };
        let status = operator(&server).await.seek_replay(seek).await.unwrap().into_inner().status.unwrap();
        assert_eq!(status.replay.unwrap().differs, "");
        let told = loop {
            let frame = frames.message().await.unwrap().unwrap();
            if frame.tick == tick {
                break frame.details[0].pin_events.clone();
            }
        };
        let step_ns = 10_000_000;
        let sent: Vec<_> = told.iter().filter(|event| event.signal == place(&signals, "uart sent")).collect();
        let from = sent.first().unwrap().at_ns;
        assert!(from < (tick - 15) * step_ns && sent.last().unwrap().at_ns > (tick - 10) * step_ns, "{from}");
    }
    server.shutdown().await;
}
