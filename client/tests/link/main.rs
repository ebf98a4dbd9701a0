//! The client against a server that keeps to a script.

mod breaches;
mod certificates;
mod fake;

use std::time::Duration;

use baudbot_client::{Action, Belief, Brain, Error, Signals, Summary, Turn, connect, run, run_fleet};
use baudbot_proto::v1::{self, attach_request::Request, robot_step::Output};
use fake::Act::{Fail, Hear};
use fake::{at, ended, number, serve, serve_at, turn, turn_of, welcome, welcome_to};
use tokio::net::{TcpListener, UnixListener};
use tokio::sync::mpsc::Receiver;
use tokio_stream::wrappers::{TcpListenerStream, UnixListenerStream};
use tonic::{Code, Status};

async fn hear_step(requests: &mut Receiver<Request>) -> v1::Step {
    match requests.recv().await {
        Some(Request::Step(step)) => step,
        other => panic!("no step but {other:?}"),
    }
}

fn step(tick: u64, outputs: &[(u32, Option<Output>)]) -> v1::Step {
    let robot_step = |(robot, output): &(u32, Option<Output>)| v1::RobotStep {
        robot: *robot,
        thinking_ns: None,
        operations: None,
        output: output.clone(),
        until_message: None,
        opened: false,
        ports: Vec::new(),
    };
    v1::Step { turn: number(tick), robots: outputs.iter().map(robot_step).collect() }
}

fn command(left_signal: f64, right_signal: f64) -> Option<Output> {
    Some(Output::Command(v1::Command { left_signal, right_signal, other_signals: Vec::new() }))
}

#[tokio::test]
async fn the_handshake_names_world_robot_and_brain_and_brings_the_body() {
    let (client, mut requests) = serve(vec![Hear, welcome(&["alice"])]).await;
    let robot = client.brain("timid").attach("room", "alice").await.unwrap();
    let hello = v1::Hello {
        world: "room".into(),
        robots: vec!["alice".into()],
        mode: v1::PortMode::Messages.into(),
        brain: "timid".into(),
        memory_bytes: None,
        thinks_as_scenario: false,
        stop_when_gone: false,
        serial_port: false,
    };
    assert_eq!(requests.recv().await, Some(Request::Hello(hello)));
    assert_eq!((robot.step_ns(), robot.lockstep()), (10_000_000, true));
    assert_eq!(robot.body().name, "alice");
    assert_eq!(robot.body().sensor_index("odometer"), Some(1));
    // Two bytes of header, two of signals, four of frame, ten bits each.
    assert_eq!(robot.body().command_ns(), 8_333_334);
}

#[tokio::test]
async fn a_turn_is_answered_once_and_one_that_was_forgotten_is_passed() {
    let script =
        vec![Hear, welcome(&["alice"]), turn(0, &[0.5]), Hear, turn(1, &[]), Hear, turn(2, &[]), Hear];
    let (client, mut requests) = serve(script).await;
    let mut robot = client.attach("room", "alice").await.unwrap();
    requests.recv().await.unwrap();

    let first = robot.turn().await.unwrap().unwrap();
    assert_eq!((first.tick, first.value("ir"), first.value("odometer")), (0, Some(0.5), None));
    assert!(first.has_news());
    robot.drive(Signals { left: 0.25, right: -0.5 }).await.unwrap();
    assert_eq!(hear_step(&mut requests).await, step(0, &[(0, command(0.25, -0.5))]));

    assert_eq!(robot.turn().await.unwrap().unwrap().at_ns, 10_000_000);
    assert_eq!(robot.turn().await.unwrap().unwrap().tick, 2);
    assert_eq!(hear_step(&mut requests).await, step(1, &[]));

    robot.drive_after(Duration::from_micros(3), Signals::default()).await.unwrap();
    let answer = hear_step(&mut requests).await;
    assert_eq!(answer.robots[0].thinking_ns, Some(3_000));
    assert_eq!(robot.turn().await.unwrap(), None);
    assert!(robot.is_closed());
    assert_eq!(robot.turn().await.unwrap(), None);
    robot.pass().await.unwrap();
}

#[tokio::test]
async fn the_end_of_a_run_is_no_turn_and_a_reset_begins_again() {
    let script = vec![Hear, welcome(&["alice"]), turn(7, &[]), ended(7), turn(0, &[]), Hear];
    let (client, mut requests) = serve(script).await;
    let mut robot = client.attach("room", "alice").await.unwrap();
    requests.recv().await.unwrap();
    assert_eq!(robot.turn().await.unwrap().unwrap().tick, 7);
    robot.pass().await.unwrap();
    assert_eq!(robot.turn().await.unwrap(), None);
    assert!(!robot.is_closed());
    assert_eq!(robot.turn().await.unwrap().unwrap().tick, 0);
    // The answer to the last turn of the old run was the only one so far.
    assert_eq!(hear_step(&mut requests).await.turn, number(7));
}

/// A brain that drives by its sensor's reading, and asks if there is none.
struct Mirror;

impl Brain for Mirror {
    fn step(&mut self, turn: &Turn) -> Action {
        turn.value("ir").map_or_else(Action::poll, |value| Action::drive(value, value))
    }
}

#[tokio::test]
async fn a_brain_runs_until_the_end() {
    let script = vec![Hear, welcome(&["alice"]), turn(0, &[]), Hear, turn(3, &[0.5]), Hear, ended(4)];
    let (client, mut requests) = serve(script).await;
    let mut robot = client.attach("room", "alice").await.unwrap();
    let summary = run(&mut robot, &mut Mirror).await.unwrap();
    assert_eq!(summary, Summary { turns: 2, last_tick: 3 });
    requests.recv().await.unwrap();
    assert_eq!(hear_step(&mut requests).await, step(0, &[(0, Some(Output::Poll(v1::Poll {})))]));
    assert_eq!(hear_step(&mut requests).await, step(3, &[(0, command(0.5, 0.5))]));
}

/// A brain that publishes a belief.
struct Believer;

impl Brain for Believer {
    fn step(&mut self, _: &Turn) -> Action {
        Action::poll()
    }

    fn belief(&mut self) -> Option<Belief> {
        Some(Belief { state: "certain".into(), ..Belief::default() })
    }
}

/// In a world that waits it is there at the next tick, and by the wall clock no command waits for it.
#[tokio::test]
async fn a_belief_is_published_before_the_answer_in_lockstep_only() {
    for (lockstep, fleet) in [(true, false), (false, false), (true, true), (false, true)] {
        let script = vec![Hear, welcome_to(lockstep, &["alice"]), turn(0, &[]), Hear, Hear, ended(1)];
        let (client, mut requests) = serve(script).await;
        if fleet {
            let mut fleet = client.attach_many("room", &["alice"]).await.unwrap();
            run_fleet(&mut fleet, &mut [Believer]).await.unwrap();
        } else {
            run(&mut client.attach("room", "alice").await.unwrap(), &mut Believer).await.unwrap();
        }
        requests.recv().await.unwrap();
        let heard = [requests.recv().await.unwrap(), requests.recv().await.unwrap()];
        let is_belief = heard.map(|request| matches!(request, Request::Annotate(_)));
        assert_eq!(is_belief, [lockstep, !lockstep], "in lockstep: {lockstep}, a fleet: {fleet}");
    }
}

#[tokio::test]
async fn a_fleet_answers_a_tick_with_one_message() {
    let reading = v1::Reading { values: vec![0.5], ..v1::Reading::default() };
    let bob = v1::RobotTurn { readings: vec![reading], ..at(0, 1) };
    let script = vec![
        Hear,
        welcome(&["alice", "bob"]),
        turn_of(0, vec![at(0, 0), bob]),
        Hear,
        turn_of(1, vec![at(1, 1)]),
        Hear,
    ];
    let (client, mut requests) = serve(script).await;
    let mut fleet = client.attach_many("room", &["alice", "bob"]).await.unwrap();
    let too_few = run_fleet(&mut fleet, &mut [Mirror]).await.unwrap_err();
    assert_eq!(too_few.to_string(), "1 brains for 2 robots; a fleet needs one each");

    let summary = run_fleet(&mut fleet, &mut [Mirror, Mirror]).await.unwrap();
    assert_eq!(summary, Summary { turns: 3, last_tick: 1 });
    requests.recv().await.unwrap();
    let poll = Some(Output::Poll(v1::Poll {}));
    assert_eq!(hear_step(&mut requests).await, step(0, &[(0, poll.clone()), (1, command(0.5, 0.5))]));
    assert_eq!(hear_step(&mut requests).await, step(1, &[(1, poll)]));
}

#[tokio::test]
async fn a_raw_robot_reads_and_writes_bytes() {
    let bytes = v1::RobotTurn { raw: vec![1, 2, 0], ..at(0, 0) };
    let script = vec![Hear, welcome(&["alice"]), turn_of(0, vec![bytes]), Hear];
    let (client, mut requests) = serve(script).await;
    let mut robot = client.attach_raw("room", "alice").await.unwrap();
    let Some(Request::Hello(hello)) = requests.recv().await else { panic!("no hello") };
    assert_eq!(hello.mode(), v1::PortMode::Raw);
    assert_eq!(robot.turn().await.unwrap().unwrap().bytes, [1, 2, 0]);
    robot.write(&[9, 0]).await.unwrap();
    assert_eq!(hear_step(&mut requests).await, step(0, &[(0, Some(Output::Raw(vec![9, 0])))]));
}

#[tokio::test]
async fn a_refusal_keeps_its_code_and_words() {
    let script = vec![Hear, Fail(Status::not_found("no world `room`; there are: yard"))];
    let (client, _requests) = serve(script).await;
    let error = client.attach("room", "alice").await.unwrap_err();
    assert_eq!(error.to_string(), "the server says: no world `room`; there are: yard (NotFound)");

    let script = vec![Hear, welcome(&["alice"]), turn(0, &[]), Fail(Status::deadline_exceeded("too slow"))];
    let (client, _requests) = serve(script).await;
    let mut robot = client.attach("room", "alice").await.unwrap();
    assert!(robot.turn().await.unwrap().is_some());
    let error = run(&mut robot, &mut Mirror).await.unwrap_err();
    assert!(matches!(error, Error::Status { code: Code::DeadlineExceeded, .. }), "{error}");
}

#[tokio::test]
async fn a_brain_that_is_to_begin_anew_is_told_apart_from_one_that_is_thrown_off() {
    let ending = async |status: Status| {
        let script = vec![Hear, welcome(&["alice"]), turn(0, &[]), Fail(status)];
        let (client, _requests) = serve(script).await;
        let mut robot = client.attach("room", "alice").await.unwrap();
        run(&mut robot, &mut Mirror).await.unwrap_err()
    };
    let with_reason = |reason: &'static str| {
        let mut status = Status::aborted("by hand");
        status.metadata_mut().insert("baudbot-reason", reason.parse().unwrap());
        status
    };
    assert!(matches!(ending(with_reason("restart")).await, Error::Restart));
    // Servers to come may have other reasons.
    for status in [Status::aborted("by hand"), with_reason("tea")] {
        let error = ending(status).await;
        assert!(matches!(error, Error::Status { code: Code::Aborted, .. }), "{error}");
    }
}

#[tokio::test]
async fn a_server_is_reached_over_tcp_and_over_a_unix_socket() {
    let script = vec![Hear, welcome(&["alice"]), turn(0, &[0.5]), Hear, ended(0)];
    let tcp = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = tcp.local_addr().unwrap().port();
    let path = std::env::temp_dir().join(format!("baudbot-client-{}.sock", std::process::id()));
    let _ = std::fs::remove_file(&path); // of a process that was killed
    let unix = UnixListener::bind(&path).unwrap();
    let _over_tcp = serve_at(script.clone(), TcpListenerStream::new(tcp));
    let _over_unix = serve_at(script, UnixListenerStream::new(unix));
    let unix = format!("unix:{}", path.display());
    for address in [format!("127.0.0.1:{port}"), format!("http://localhost:{port}"), unix] {
        let client = connect(&address).await.unwrap();
        let mut robot = client.attach("room", "alice").await.unwrap();
        assert_eq!(run(&mut robot, &mut Mirror).await.unwrap().turns, 1, "{address}");
    }
    std::fs::remove_file(path).unwrap();
}
