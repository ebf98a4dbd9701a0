//! Trainers: they drive as brains do, and get the truth, which brains do not, of many worlds in a stream.

use std::collections::BTreeSet;

use baudbot_client::Signals;
use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_proto::v1::train_request::Request;
use baudbot_proto::v1::trainer_service_client::TrainerServiceClient;
use baudbot_proto::v1::world_action::Action;
use baudbot_proto::v1::world_result::Outcome;
use baudbot_server::{Address, Pace, Server, ServerError, WatchdogPolicy, WorldConfig};
use baudbot_tests::system::{client, lockstep, operator, strict, watched};
use baudbot_tests::{WANDER, crowd, scenario};
use tokio::sync::mpsc;
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::Channel;
use tonic::{Code, Status, Streaming};
use tonic_reflection::pb::v1 as reflection;

/// A server with these worlds that takes trainers, without ports.
async fn serve(worlds: impl IntoIterator<Item = WorldConfig>) -> Server {
    let builder = Server::builder().trainer("127.0.0.1:0".parse().unwrap());
    worlds.into_iter().fold(builder, |builder, world| builder.world(world)).in_process().await.unwrap()
}

fn world(name: &str, pace: Pace, changes: &[&str]) -> WorldConfig {
    WorldConfig::new(name, scenario(WANDER, changes)).pace(pace)
}

fn hello(world: &str) -> v1::Hello {
    v1::Hello { world: world.into(), brain: "trainer".into(), thinks_as_scenario: true, ..Default::default() }
}

/// A trainer's stream.
struct Trainer {
    requests: mpsc::UnboundedSender<v1::TrainRequest>,
    responses: Streaming<v1::TrainResponse>,
}

impl Trainer {
    async fn try_open(server: &Server, worlds: Vec<v1::Hello>) -> Result<Self, Status> {
        let mut service = TrainerServiceClient::new(server.trainers_channel().await.unwrap());
        let (requests, stream) = mpsc::unbounded_channel();
        let open = Request::Open(v1::OpenTraining { worlds });
        requests.send(v1::TrainRequest { request: Some(open) }).unwrap();
        let responses = service.train(UnboundedReceiverStream::new(stream)).await?.into_inner();
        Ok(Self { requests, responses })
    }

    /// Opens a stream. Gives the first response, too.
    async fn open(server: &Server, worlds: &[&str]) -> (Self, Vec<v1::WorldResult>) {
        let hellos = worlds.iter().map(|world| hello(world)).collect();
        let mut trainer = Self::try_open(server, hellos).await.unwrap();
        let first = trainer.response().await.unwrap();
        (trainer, first)
    }

    async fn response(&mut self) -> Result<Vec<v1::WorldResult>, Status> {
        Ok(self.responses.message().await?.expect("the stream has ended").worlds)
    }

    async fn cycle(&mut self, actions: Vec<(u32, Action)>) -> Result<Vec<v1::WorldResult>, Status> {
        let action = |(world, action)| v1::WorldAction { world, action: Some(action) };
        let cycle = v1::TrainingCycle { worlds: actions.into_iter().map(action).collect() };
        self.requests.send(v1::TrainRequest { request: Some(Request::Cycle(cycle)) }).unwrap();
        self.response().await
    }

    /// Drives by a stateless brain, until all runs have ended. Gives the truths of all worlds, cycle by cycle.
    async fn drive(&mut self, mut results: Vec<v1::WorldResult>) -> Vec<Vec<v1::WorldResult>> {
        let mut places: Vec<_> = (0..results.len() as u32).collect();
        let mut seen = Vec::new();
        while !results.is_empty() {
            let answers =
                places.iter().zip(&results).filter_map(|(&place, result)| Some((place, answer(result)?)));
            let answers: Vec<_> = answers.collect();
            places = answers.iter().map(|(place, _)| *place).collect();
            seen.push(std::mem::take(&mut results));
            if !answers.is_empty() {
                results = self.cycle(answers).await.unwrap();
            }
        }
        seen
    }
}

/// The place of `ir_front` in the data sheet of `wander`'s robot.
fn ir_front() -> u32 {
    let scenario = scenario(WANDER, &[]);
    scenario.robots[0].sensors.iter().position(|sensor| sensor.name == "ir_front").unwrap() as u32
}

fn turn(result: &v1::WorldResult) -> Option<&v1::Turn> {
    if let Some(Outcome::Turn(turn)) = &result.outcome { Some(turn) } else { None }
}

fn signals(left_signal: f64, right_signal: f64) -> v1::robot_step::Output {
    v1::robot_step::Output::Command(v1::Command { left_signal, right_signal, other_signals: Vec::new() })
}

/// The answer to a Turn, of a brain without a state.
fn answer(result: &v1::WorldResult) -> Option<Action> {
    let turn = turn(result)?;
    let step = |part: &v1::RobotTurn| {
        let reading = part.readings.iter().find(|reading| reading.sensor == ir_front());
        let near = reading.map_or(0.0, |reading| reading.values[0]);
        v1::RobotStep {
            robot: part.robot,
            output: Some(signals(0.4, 0.4 - near * 0.5)),
            ..Default::default()
        }
    };
    Some(Action::Step(v1::Step { turn: turn.turn, robots: turn.robots.iter().map(step).collect() }))
}

fn reset(seed: u64) -> Action {
    Action::Reset(v1::ResetWorldRequest { seed: Some(seed), ..Default::default() })
}

fn problem(result: &v1::WorldResult) -> (Code, &str) {
    match &result.outcome {
        Some(Outcome::Refused(problem) | Outcome::Closed(problem)) => {
            (Code::from_i32(problem.code as i32), &problem.message)
        }
        other => panic!("no problem but {other:?}"),
    }
}

async fn status(server: &Server, world: &str) -> v1::WorldStatus {
    let request = v1::GetWorldRequest { world: world.into() };
    operator(server).await.get_world(request).await.unwrap().into_inner().status.unwrap()
}

#[tokio::test]
async fn a_trainer_and_a_brain_that_do_the_same_make_the_same_run() {
    let changes = ["end.after_s=4.0"];
    let server = serve([
        world("brain", lockstep(), &changes),
        world("trained", lockstep(), &changes),
        world("strict", strict(), &changes),
    ])
    .await;
    let mut robot = client(&server).await.attach("brain", "robot").await.unwrap();
    while let Some(turn) = robot.turn().await.unwrap() {
        let near = turn.value("ir_front").unwrap_or(0.0);
        robot.drive(Signals { left: 0.4, right: 0.4 - near * 0.5 }).await.unwrap();
    }
    let expected = status(&server, "brain").await;
    assert_eq!((expected.tick, expected.robots[0].commands > 100), (400, true));

    let (mut trainer, first) = Trainer::open(&server, &["trained", "strict"]).await;
    trainer.drive(first).await;
    assert_eq!(status(&server, "trained").await.state_hash, expected.state_hash);
    assert_eq!(status(&server, "strict").await.state_hash, expected.state_hash);
    // Again, from a reset of its own.
    let again = trainer.cycle(vec![(0, reset(1)), (1, reset(2))]).await.unwrap();
    trainer.drive(again).await;
    assert_eq!(status(&server, "trained").await.state_hash, expected.state_hash);
    assert_ne!(status(&server, "strict").await.state_hash, expected.state_hash, "another seed");
    server.shutdown().await;
}

#[tokio::test]
async fn the_truth_is_that_of_the_world_at_the_start_of_the_turns_tick() {
    let changes = ["end.after_s=6.0", "collision=\"stop-robot\"", "robots.robot.start.x_m=0.6"];
    let server = serve([world("strict", strict(), &changes), world("ahead", lockstep(), &changes)]).await;
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let watch = || v1::WatchRequest {
        world: "strict".into(),
        every_ticks: 1,
        details: Vec::new(),
        ..Default::default()
    };
    let (mut trainer, mut results) = Trainer::open(&server, &["strict", "ahead"]).await;
    assert_eq!(results[0].welcome.as_ref().unwrap().robots[0].robot, "robot");
    let (mut ticks, mut collided) = (0, 0);
    loop {
        assert_eq!(results[0].tick, results[1].tick);
        assert_eq!(results[0].truths, results[1].truths, "lookahead makes a difference");
        let [truth] = &results[0].truths[..] else { panic!("one robot") };
        // The world stands, so that an observer who comes now sees this instant.
        let frame = observer.watch(watch()).await.unwrap().into_inner().message().await.unwrap().unwrap();
        let seen = &frame.robots[0];
        assert_eq!((frame.tick, frame.time_ns), (results[0].tick, results[0].time_ns));
        let pose = (truth.x_m, truth.y_m, truth.heading_rad);
        assert_eq!((pose, truth.speed_m_s), ((seen.x_m, seen.y_m, seen.heading_rad), seen.speed_m_s));
        let status = status(&server, "strict").await;
        assert_eq!(truth.collisions, status.robots[0].collisions);
        assert_eq!(truth.distance_m, status.robots[0].distance_m);
        collided += u64::from(truth.collided);
        let Some(turn) = turn(&results[0]) else { break };
        assert_eq!((turn.tick, results[0].welcome.is_some()), (results[0].tick, ticks == 0));
        assert!((results[0].time_ns..=results[0].time_ns + 10_000_000).contains(&turn.robots[0].at_ns));
        ticks += 1;
        // Straight ahead, into the wall.
        let ahead = |result: &v1::WorldResult| {
            let part = v1::RobotStep { output: Some(signals(0.5, 0.5)), ..Default::default() };
            Action::Step(v1::Step { turn: self::turn(result).unwrap().turn, robots: vec![part] })
        };
        results = trainer.cycle(vec![(0, ahead(&results[0])), (1, ahead(&results[1]))]).await.unwrap();
    }
    let Some(Outcome::Ended(ended)) = &results[0].outcome else { panic!("{results:?}") };
    assert_eq!((ended.kind(), results[0].tick), (v1::EndingKind::TimeIsOver, 600));
    let collisions = results[0].truths[0].collisions;
    assert!(ticks == 600 && collided > 0 && collided <= collisions, "{ticks} {collided} {collisions}");
    // Nothing has been hit after a reset.
    let fresh = trainer.cycle(vec![(0, reset(1))]).await.unwrap();
    assert_eq!((fresh[0].tick, fresh[0].truths[0].collisions, fresh[0].truths[0].collided), (0, 0, false));
    server.shutdown().await;
}

#[tokio::test]
async fn sixty_four_worlds_take_one_request_a_cycle_each_and_are_answered_in_its_order() {
    let names: Vec<_> = (0..64).map(|i| format!("w{i}")).collect();
    let changes = |i: usize| [format!("seed={i}"), "end.after_s=0.5".to_owned()];
    let worlds = names.iter().enumerate().map(|(i, name)| {
        let changes = changes(i);
        world(name, lockstep(), &changes.each_ref().map(String::as_str))
    });
    let server = serve(worlds).await;
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let (mut trainer, first) = Trainer::open(&server, &names).await;
    assert_eq!(first.len(), 64);
    let seen = trainer.drive(first).await;
    assert_eq!(seen.len(), 51, "fifty Turns and an end");
    assert!(
        seen[50].iter().all(|result| matches!(result.outcome, Some(Outcome::Ended(_)))),
        "{:?}",
        seen[50]
    );

    // In the order of the request: each world begins somewhere else.
    let at = |place: u32| f64::from(place) * 0.01 - 0.3;
    let order: Vec<_> = (0..64).rev().filter(|place| place % 3 == 0).collect();
    let moved = |place: u32| {
        let start = v1::RobotStart { robot: "robot".into(), x_m: at(place), y_m: 0.0, heading_rad: 0.0 };
        (place, Action::Reset(v1::ResetWorldRequest { starts: vec![start], ..Default::default() }))
    };
    let results = trainer.cycle(order.iter().map(|&place| moved(place)).collect()).await.unwrap();
    let starts: Vec<_> = results.iter().map(|result| (result.tick, result.truths[0].x_m)).collect();
    assert_eq!(starts, order.iter().map(|&place| (0, at(place))).collect::<Vec<_>>());
    server.shutdown().await;
}

#[tokio::test]
async fn a_trainer_drives_a_crowd_and_is_asked_when_a_message_has_come() {
    let names: Vec<_> = (0..3).map(|i| format!("r{i}")).collect();
    let crowd = scenario(&crowd(&names), &["end.after_s=1.0"]);
    let server = serve([WorldConfig::new("w", crowd).pace(lockstep())]).await;
    let (mut trainer, mut results) = Trainer::open(&server, &["w"]).await;
    let mut asked = 0;
    while let Some(turn) = turn(&results[0]) {
        assert_eq!(results[0].truths.len(), 3);
        asked += 1;
        let wait = |part: &v1::RobotTurn| v1::RobotStep {
            robot: part.robot,
            until_message: Some(v1::UntilMessage { at_latest_ns: None }),
            ..Default::default()
        };
        let step = v1::Step { turn: turn.turn, robots: turn.robots.iter().map(wait).collect() };
        results = trainer.cycle(vec![(0, Action::Step(step))]).await.unwrap();
    }
    assert!(asked > 5 && asked < 100, "{asked} Turns in 100 ticks");
    server.shutdown().await;
}

/// A brain on the other robot, which has promised to think as long as the scenario states.
async fn drive_other(server: &Server, world: &str) -> tokio::task::JoinHandle<()> {
    let client = client(server).await.thinks_as_scenario();
    let mut robot = client.attach(world, "r1").await.unwrap();
    tokio::spawn(async move {
        while let Ok(Some(_)) = robot.turn().await {
            // The world may go on meanwhile.
            tokio::task::yield_now().await;
            robot.drive(Signals { left: 0.2, right: 0.5 }).await.unwrap();
        }
    })
}

#[tokio::test]
async fn the_truth_is_the_same_while_the_world_is_ahead_of_other_brains() {
    let names: Vec<_> = (0..2).map(|i| format!("r{i}")).collect();
    let crowd = || scenario(&crowd(&names), &["end.after_s=1.5"]);
    let worlds = [("strict", strict()), ("ahead", lockstep())];
    let server = serve(worlds.map(|(name, pace)| WorldConfig::new(name, crowd()).pace(pace))).await;
    let others = [drive_other(&server, "strict").await, drive_other(&server, "ahead").await];
    let own = |world: &str| v1::Hello { robots: vec!["r0".into()], ..hello(world) };
    let mut trainer = Trainer::try_open(&server, vec![own("strict"), own("ahead")]).await.unwrap();
    let first = trainer.response().await.unwrap();
    let seen = trainer.drive(first).await;
    assert_eq!(seen.len(), 151);
    for results in seen {
        assert_eq!((results[0].tick, &results[0].truths), (results[1].tick, &results[1].truths));
    }
    for other in others {
        other.abort();
    }
    assert_eq!(status(&server, "strict").await.state_hash, status(&server, "ahead").await.state_hash);
    server.shutdown().await;
}

#[tokio::test]
async fn what_makes_no_sense_ends_the_stream_with_its_field_before_anything_is_done() {
    let server = serve([world("a", strict(), &[]), world("b", strict(), &[])]).await;
    let step = |turn: u64, output| {
        let part = v1::RobotStep { output: Some(output), ..Default::default() };
        Action::Step(v1::Step { turn, robots: vec![part] })
    };
    let good = || (0, step(1, signals(0.1, 0.1)));
    let named = v1::ResetWorldRequest { world: "b".into(), ..Default::default() };
    let cases = [
        (
            vec![good(), (1, step(1, signals(f64::NAN, 0.0)))],
            "worlds[1].step.robots[0].command.left_signal: must be a finite",
        ),
        (
            vec![good(), (1, step(7, signals(0.0, 0.0)))],
            "worlds[1].step.turn: must be 1, the number of the world's last Turn, is 7",
        ),
        (vec![good(), (2, reset(1))], "worlds[1].world: is 2, but this stream has 2 worlds"),
        (vec![good(), (0, reset(1))], "worlds[1].world: 0 is named twice"),
        (vec![good(), (1, Action::Reset(named))], "worlds[1].reset.world: must be empty"),
    ];
    for (actions, text) in cases {
        let (mut trainer, _) = Trainer::open(&server, &["a", "b"]).await;
        let refused = trainer.cycle(actions).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument, "{refused:?}");
        assert!(refused.message().starts_with(text), "expected `{text}` in: {refused:?}");
        released(&server, "a").await;
        released(&server, "b").await;
        assert_eq!(status(&server, "a").await.tick, 0, "a part was done of a request that was refused");
        for world in ["a", "b"] {
            operator(&server)
                .await
                .reset_world(v1::ResetWorldRequest { world: world.into(), ..Default::default() })
                .await
                .unwrap();
        }
    }
    let (mut trainer, _) = Trainer::open(&server, &["a"]).await;
    let again = v1::TrainRequest { request: Some(Request::Open(v1::OpenTraining::default())) };
    trainer.requests.send(again).unwrap();
    let refused = trainer.response().await.unwrap_err();
    assert_eq!(
        (refused.code(), refused.message()),
        (Code::FailedPrecondition, "open: this stream is open already; open another one")
    );
    server.shutdown().await;
}

/// The world knows that its robots have no brain.
async fn released(server: &Server, world: &str) {
    while status(server, world).await.robots.iter().any(|robot| robot.attached) {
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn worlds_that_cannot_be_trained_are_refused_and_all_robots_released() {
    let server = serve([world("a", lockstep(), &[]), world("timed", Pace::REAL_TIME, &[])]).await;
    let robots = |robots: &[&str]| {
        let robots = robots.iter().map(|robot| (*robot).to_owned()).collect();
        v1::Hello { robots, ..hello("a") }
    };
    let many: Vec<_> = (0..1025).map(|i| hello(&i.to_string())).collect();
    let cases = [
        (vec![], Code::InvalidArgument, "open.worlds: must name at least one world"),
        (
            many,
            Code::ResourceExhausted,
            "open.worlds: there are 1025, more than 1024, which is its limit; open several streams, or start the server with a larger --max-worlds-per-trainer",
        ),
        (vec![hello("a"), hello("x")], Code::NotFound, "open.worlds[1].world: there is no world `x`"),
        (vec![hello("a"), hello("a")], Code::InvalidArgument, "open.worlds[1].world: `a` is named twice"),
        (
            vec![hello("a"), hello("timed")],
            Code::FailedPrecondition,
            "open.worlds[1].world: `timed` is not in lockstep",
        ),
        (vec![robots(&["bob"])], Code::NotFound, "open.worlds[0].hello.robots[0]: there is no robot `bob`"),
    ];
    for (hellos, code, text) in cases {
        let refused = Trainer::try_open(&server, hellos).await.err().expect("refused");
        assert_eq!(refused.code(), code, "{refused:?}");
        assert!(refused.message().starts_with(text), "expected `{text}` in: {refused:?}");
        released(&server, "a").await;
    }
    let brain = client(&server).await.attach("a", "robot").await.unwrap();
    let taken = Trainer::try_open(&server, vec![hello("a")]).await.err().expect("refused");
    assert_eq!(taken.code(), Code::AlreadyExists, "{taken:?}");
    drop(brain);
    server.shutdown().await;
}

#[tokio::test]
async fn a_request_before_the_response_is_refused_and_the_stream_that_ends_releases_its_robots() {
    // The other robot's brain never comes, so that no response does.
    let names: Vec<_> = (0..2).map(|i| format!("r{i}")).collect();
    let server = serve([WorldConfig::new("w", scenario(&crowd(&names), &[])).pace(lockstep())]).await;
    let one = || v1::Hello { robots: vec!["r0".into()], ..hello("w") };
    let mut trainer = Trainer::try_open(&server, vec![one()]).await.unwrap();
    assert!(status(&server, "w").await.robots[0].attached);
    let cycle = Some(Request::Cycle(v1::TrainingCycle::default()));
    trainer.requests.send(v1::TrainRequest { request: cycle }).unwrap();
    let refused = trainer.response().await.unwrap_err();
    assert_eq!(refused.code(), Code::FailedPrecondition);
    assert!(
        refused.message().starts_with("request: the previous request has not been answered yet"),
        "{refused:?}"
    );
    released(&server, "w").await;

    let mut trainer = Trainer::try_open(&server, vec![one()]).await.unwrap();
    assert!(status(&server, "w").await.robots[0].attached);
    drop(trainer.requests);
    assert!(trainer.responses.message().await.unwrap().is_none(), "the server ends its side, too");
    released(&server, "w").await;

    let trainer = Trainer::try_open(&server, vec![one()]).await.unwrap();
    assert!(status(&server, "w").await.robots[0].attached);
    drop(trainer);
    released(&server, "w").await;
    server.shutdown().await;
}

#[tokio::test]
async fn what_happens_to_one_world_is_told_in_its_place_and_the_others_go_on() {
    let names = ["deleted", "detached", "refused", "timed", "good"];
    let server = serve(names.map(|name| world(name, strict(), &["end.after_s=5.0"]))).await;
    let (mut trainer, first) = Trainer::open(&server, &names).await;
    let mut operator = operator(&server).await;
    operator.delete_world(v1::DeleteWorldRequest { world: "deleted".into() }).await.unwrap();
    let detach = v1::DetachBrain { robot: "robot".into(), restart: false };
    let detach = Some(v1::intervene_request::Intervention::DetachBrain(detach));
    operator
        .intervene(v1::InterveneRequest { world: "detached".into(), intervention: detach })
        .await
        .unwrap();
    let real_time = Some(v1::Pace { kind: Some(v1::pace::Kind::RealTime(v1::RealTime::default())) });
    operator.set_pace(v1::SetPaceRequest { world: "timed".into(), pace: real_time }).await.unwrap();

    let in_the_wall = v1::RobotStart { robot: "robot".into(), x_m: 99.0, ..Default::default() };
    let mut actions: Vec<_> = (0..5).map(|i| (i, answer(&first[i as usize]).unwrap())).collect();
    actions[2].1 = Action::Reset(v1::ResetWorldRequest {
        starts: vec![in_the_wall.clone(), in_the_wall],
        ..Default::default()
    });
    let results = trainer.cycle(actions).await.unwrap();
    assert_eq!(problem(&results[0]), (Code::Aborted, "world `deleted` was deleted"));
    assert_eq!(problem(&results[1]), (Code::Aborted, "the operator has detached this brain"));
    assert_eq!(problem(&results[2]), (Code::InvalidArgument, "starts[1].robot: `robot` is named twice"));
    let (code, text) = problem(&results[3]);
    assert_eq!(code, Code::FailedPrecondition);
    assert!(text.starts_with("world: `timed` is not in lockstep any more; set its pace"), "{text}");
    assert_eq!(results[4].tick, 1);
    released(&server, "timed").await;

    // A closed world stays so; a refused one stands as before; the others go on.
    let actions = vec![
        (0, reset(1)),
        (1, reset(1)),
        (2, answer(&first[2]).unwrap()),
        (4, answer(&results[4]).unwrap()),
    ];
    let again = trainer.cycle(actions).await.unwrap();
    assert!(matches!(again[0].outcome, Some(Outcome::Closed(_))) && again[1].outcome == results[1].outcome);
    assert_eq!((again[2].tick, again[3].tick), (1, 2));
    server.shutdown().await;
}

#[tokio::test]
async fn a_run_that_has_ended_takes_no_step_and_a_reset_by_an_operator_is_seen() {
    let server = serve([world("w", lockstep(), &["end.after_s=0.1"])]).await;
    let (mut trainer, first) = Trainer::open(&server, &["w"]).await;
    let last = answer(&first[0]).unwrap();
    let seen = trainer.drive(first).await;
    assert_eq!(seen.last().unwrap()[0].tick, 10);
    let refused = trainer.cycle(vec![(0, last)]).await.unwrap();
    assert_eq!(problem(&refused[0]), (Code::FailedPrecondition, "step: the run has ended; reset the world"));
    let fresh = trainer.cycle(vec![(0, reset(1))]).await.unwrap();
    let later = trainer.cycle(vec![(0, answer(&fresh[0]).unwrap())]).await.unwrap();
    assert_eq!((fresh[0].tick, later[0].tick), (0, 1));
    let by_hand = v1::ResetWorldRequest { world: "w".into(), ..Default::default() };
    operator(&server).await.reset_world(by_hand).await.unwrap();
    let back = trainer.cycle(vec![(0, answer(&later[0]).unwrap())]).await.unwrap();
    assert_eq!((back[0].tick, turn(&back[0]).is_some()), (0, true));
    server.shutdown().await;
}

#[tokio::test]
async fn collisions_before_a_state_that_an_operator_restores_are_not_news() {
    let changes = ["collision=\"stop-robot\"", "robots.robot.start.x_m=1.5"];
    let server = serve([world("w", strict(), &changes)]).await;
    let (mut trainer, mut results) = Trainer::open(&server, &["w"]).await;
    // Into the wall, and then it stands.
    for i in 0..300 {
        let signal = if i < 200 { 0.5 } else { 0.0 };
        let part = v1::RobotStep { output: Some(signals(signal, signal)), ..Default::default() };
        let step = v1::Step { turn: turn(&results[0]).unwrap().turn, robots: vec![part] };
        results = trainer.cycle(vec![(0, Action::Step(step))]).await.unwrap();
    }
    let told = |results: &[v1::WorldResult]| {
        let truth = &results[0].truths[0];
        (results[0].tick, truth.collisions, truth.collided)
    };
    let (tick, collisions, _) = told(&results);
    assert_eq!((tick, collisions > 0, results[0].truths[0].collided), (300, true, false));
    let mut operator = operator(&server).await;
    let snapshot = operator.snapshot_world(v1::SnapshotWorldRequest { world: "w".into() }).await.unwrap();
    let snapshot = snapshot.into_inner().snapshot;
    operator.restore_world(v1::RestoreWorldRequest { world: "w".into(), snapshot }).await.unwrap();
    let again = trainer.cycle(vec![(0, answer(&results[0]).unwrap())]).await.unwrap();
    assert_eq!(told(&again), (300, collisions, false));
    server.shutdown().await;
}

#[tokio::test]
async fn a_watchdog_detaches_a_trainer_that_does_not_answer_as_any_brain() {
    let server = serve([world("w", watched(50, WatchdogPolicy::Detach), &[])]).await;
    let (mut trainer, first) = Trainer::open(&server, &["w"]).await;
    released(&server, "w").await;
    let late = trainer.cycle(vec![(0, answer(&first[0]).unwrap())]).await.unwrap();
    assert_eq!(problem(&late[0]).0, Code::DeadlineExceeded);
    server.shutdown().await;
}

/// The services that reflection lists, and whether it knows this symbol.
async fn reflected(channel: Channel, symbol: &str) -> (BTreeSet<String>, bool) {
    use reflection::server_reflection_request::MessageRequest;
    use reflection::server_reflection_response::MessageResponse;
    let mut client = reflection::server_reflection_client::ServerReflectionClient::new(channel);
    let asked =
        [MessageRequest::ListServices(String::new()), MessageRequest::FileContainingSymbol(symbol.into())];
    let mut found = (BTreeSet::new(), false);
    for message_request in asked {
        let request = reflection::ServerReflectionRequest {
            host: String::new(),
            message_request: Some(message_request),
        };
        let answers = client.server_reflection_info(tokio_stream::once(request)).await;
        let Ok(Some(answer)) = answers.unwrap().into_inner().message().await else { continue };
        match answer.message_response {
            Some(MessageResponse::ListServicesResponse(list)) => {
                found.0 = list.service.into_iter().map(|service| service.name).collect();
            }
            Some(MessageResponse::FileDescriptorResponse(_)) => found.1 = true,
            _ => {}
        }
    }
    found
}

#[tokio::test]
async fn truth_is_on_a_listener_of_its_own_only() {
    let builder = Server::builder().world(world("w", lockstep(), &[])).listen("127.0.0.1:0".parse().unwrap());
    let server = builder.trainer("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
    let connect = |address: &Address| {
        tonic::transport::Endpoint::from_shared(format!("http://{address}")).unwrap().connect_lazy()
    };
    let (ordinary, trainers) = (connect(&server.addresses()[0]), connect(&server.trainers()[0]));
    for channel in [ordinary.clone(), server.channel().await.unwrap()] {
        let nothing = tokio_stream::empty::<v1::TrainRequest>();
        let refused = TrainerServiceClient::new(channel.clone()).train(nothing).await.unwrap_err();
        assert_eq!(refused.code(), Code::Unimplemented, "{refused:?}");
        let (services, knows) = reflected(channel.clone(), "baudbot.v1.Truth").await;
        assert!(!services.iter().any(|name| name.contains("Trainer")) && !knows, "{services:?}");
        assert!(services.contains("baudbot.v1.BrainLinkService"), "{services:?}");
        assert!(reflected(channel, "baudbot.v1.Turn").await.1, "reflection knows the contract otherwise");
    }
    let attach = tokio_stream::empty::<v1::AttachRequest>();
    let refused = BrainLinkServiceClient::new(trainers.clone()).attach(attach).await.unwrap_err();
    assert_eq!(refused.code(), Code::Unimplemented, "{refused:?}");
    let (services, knows) = reflected(trainers.clone(), "baudbot.v1.Truth").await;
    assert!(services.contains("baudbot.v1.TrainerService") && knows, "{services:?}");
    // The operator's service is there, so that a trainer can make worlds.
    let mut operator = ControlServiceClient::new(trainers);
    let worlds = operator.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    assert_eq!(worlds.len(), 1);
    server.shutdown().await;
}

#[tokio::test]
async fn trainers_are_of_this_machine_and_only_where_they_are_asked_for() {
    let elsewhere = Server::builder().trainer("0.0.0.0:0".parse().unwrap());
    let refused = elsewhere.serve().await.err().expect("refused");
    assert!(matches!(refused, ServerError::TrainerNotLocal { .. }), "{refused}");
    assert_eq!(
        refused.to_string(),
        "0.0.0.0:0: a trainer's address must be on this machine, as it gives access to the truth about robots; use 127.0.0.1:PORT or \
         unix:/PATH"
    );
    let without = Server::builder().in_process().await.unwrap();
    assert!(matches!(without.trainers_channel().await, Err(ServerError::NoTrainers)));
    without.shutdown().await;
}
