//! Bad input over the network: each gets a clear error, nothing else is harmed, and the world goes on.

use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::robot_step::Output;
use baudbot_server::{Pace, Server, ServerError, WorldConfig};
use baudbot_tests::system::{lockstep, operator, serve, serve_on_ports, status};
use baudbot_tests::{WANDER, crowd, scenario};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Code, Status, Streaming};

/// A brain's stream, message by message.
pub(super) struct Stream {
    pub(super) requests: mpsc::Sender<v1::AttachRequest>,
    responses: Streaming<v1::AttachResponse>,
}

impl Stream {
    pub(super) async fn open(server: &Server, first: Request) -> Result<Self, Status> {
        let (requests, stream) = mpsc::channel(1000);
        requests.send(v1::AttachRequest { request: Some(first) }).await.unwrap();
        let channel = server.channel().await.unwrap();
        let response = BrainLinkServiceClient::new(channel).attach(ReceiverStream::new(stream)).await?;
        Ok(Self { requests, responses: response.into_inner() })
    }

    pub(super) async fn send(&self, request: Request) {
        self.requests.send(v1::AttachRequest { request: Some(request) }).await.unwrap();
    }

    /// The error that the stream ends with.
    async fn end(&mut self) -> Status {
        loop {
            match self.responses.message().await {
                Err(status) => return status,
                Ok(Some(_)) => {}
                Ok(None) => panic!("the stream should end with an error"),
            }
        }
    }

    async fn turn(&mut self) -> v1::Turn {
        loop {
            let message = self.responses.message().await.unwrap().expect("a stream that goes on");
            if let Some(Response::Turn(turn)) = message.response {
                return turn;
            }
        }
    }
}

pub(super) fn hello(robots: &[&str], mode: v1::PortMode) -> Request {
    let robots = robots.iter().map(|&name| name.to_owned()).collect();
    Request::Hello(v1::Hello {
        world: "w".into(),
        robots,
        mode: mode.into(),
        brain: "test".into(),
        memory_bytes: None,
        thinks_as_scenario: false,
        stop_when_gone: false,
        serial_port: false,
    })
}

pub(super) fn messages() -> Request {
    hello(&["robot"], v1::PortMode::Messages)
}

pub(super) fn step(turn: u64, robot: u32, output: Output) -> Request {
    let robots = vec![v1::RobotStep { robot, output: Some(output), ..Default::default() }];
    Request::Step(v1::Step { turn, robots })
}

pub(super) fn command(left_signal: f64, right_signal: f64) -> Output {
    Output::Command(v1::Command { left_signal, right_signal, other_signals: Vec::new() })
}

#[track_caller]
fn assert_status(status: &Status, code: Code, text: &str) {
    assert_eq!(status.code(), code, "{status:?}");
    assert!(status.message().contains(text), "expected `{text}` in: {}", status.message());
}

#[tokio::test]
async fn a_step_that_makes_no_sense_ends_its_stream_with_the_field_and_the_robot_is_free_again() {
    let too_long = Output::Raw(vec![0; 70_000]);
    let cases = [
        (
            messages(),
            step(0, 0, command(f64::NAN, 0.0)),
            "step.robots[0].command.left_signal: must be a finite number, is NaN",
        ),
        (
            messages(),
            step(0, 0, command(0.0, f64::INFINITY)),
            "step.robots[0].command.right_signal: must be a finite number",
        ),
        (
            messages(),
            step(0, 0, command(0.0, 1.5)),
            "step.robots[0].command.right_signal: must be between -1 and 1, is 1.5",
        ),
        (
            messages(),
            step(0, 7, command(0.0, 0.0)),
            "step.robots[0].robot: is 7, but this stream has 1 robots",
        ),
        (messages(), step(0, 0, Output::Raw(vec![1])), "step.robots[0].raw: the stream is in MESSAGES mode"),
        (
            hello(&["robot"], v1::PortMode::Raw),
            step(0, 0, command(0.0, 0.0)),
            "step.robots[0].output: the stream is in RAW mode",
        ),
        (
            hello(&["robot"], v1::PortMode::Raw),
            step(0, 0, too_long),
            "step.robots[0].raw: has 70000 bytes, the limit is 65536",
        ),
    ];
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    for (hello, bad, text) in cases {
        let mut stream = Stream::open(&server, hello).await.unwrap();
        stream.send(bad).await;
        assert_status(&stream.end().await, Code::InvalidArgument, text);
        // The robot is free, the world goes on, and nothing was obeyed.
        drop(stream);
    }
    let status = status(&server).await;
    assert_eq!(status.state(), v1::WorldState::Running);
    assert_eq!(status.robots[0].commands, 0);
    server.shutdown().await;
}

#[tokio::test]
async fn a_stream_attaches_once_and_says_hello_first() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut twice = Stream::open(&server, messages()).await.unwrap();
    twice.send(messages()).await;
    assert_status(&twice.end().await, Code::FailedPrecondition, "hello: this stream is attached already");
    let early = Stream::open(&server, step(0, 0, command(0.0, 0.0))).await.err().unwrap();
    assert_status(&early, Code::FailedPrecondition, "the first request must be a Hello");
    let nobody = Stream::open(&server, hello(&[], v1::PortMode::Raw)).await.err().unwrap();
    assert_status(&nobody, Code::InvalidArgument, "hello.robots: must name at least one");
    let same = Stream::open(&server, hello(&["robot", "robot"], v1::PortMode::Raw)).await.err().unwrap();
    assert_status(&same, Code::InvalidArgument, "hello.robots[1]: `robot` is named twice");
    let unknown = Stream::open(&server, hello(&["bob"], v1::PortMode::Raw)).await.err().unwrap();
    assert_status(
        &unknown,
        Code::NotFound,
        "hello.robots[0]: there is no robot `bob` in world `w`; there are: robot",
    );
    let world =
        Request::Hello(v1::Hello { world: "x".into(), robots: vec!["robot".into()], ..Default::default() });
    let unknown = Stream::open(&server, world).await.err().unwrap();
    assert_status(&unknown, Code::NotFound, "hello.world: there is no world `x`; there are: w");
    server.shutdown().await;
}

#[tokio::test]
async fn a_robot_that_another_brain_holds_is_not_given_away() {
    let server = serve(scenario(&crowd(&["r0".into(), "r1".into()]), &[]), Pace::REAL_TIME).await;
    let mut holder = Stream::open(&server, hello(&["r0"], v1::PortMode::Messages)).await.unwrap();
    // Nor are the others that the same Hello asks for taken.
    let refused = Stream::open(&server, hello(&["r1", "r0"], v1::PortMode::Messages)).await.err().unwrap();
    assert_status(
        &refused,
        Code::AlreadyExists,
        "hello.robots[1]: robot `r0` of world `w` is held by brain `test`",
    );
    let other = Stream::open(&server, hello(&["r1"], v1::PortMode::Messages)).await;
    assert!(other.is_ok());
    holder.turn().await;
    server.shutdown().await;
}

#[tokio::test]
async fn in_lockstep_each_turn_takes_exactly_one_step() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let mut stream = Stream::open(&server, messages()).await.unwrap();
    let turn = stream.turn().await.turn;
    stream.send(step(turn, 0, command(0.1, 0.1))).await;
    stream.send(step(turn, 0, command(0.2, 0.2))).await;
    assert_status(&stream.end().await, Code::FailedPrecondition, "Turn 1 is not the one to answer");
    server.shutdown().await;
}

#[tokio::test]
async fn scenarios_that_make_no_sense_are_refused_with_the_field() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut operator = operator(&server).await;
    let mut create = async |world: &str, toml: &str, overrides: &[&str]| {
        let request = v1::CreateWorldRequest {
            world: world.into(),
            scenario_toml: toml.into(),
            overrides: overrides.iter().map(|&text| text.to_owned()).collect(),
            pace: None,
            paused: true,
            saved_mcap: Vec::new(),
        };
        operator.create_world(request).await.map(|response| response.into_inner().status.unwrap())
    };
    let refused = create("x", "step = 1", &[]).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "scenario_toml: step: unknown field `step`");
    let refused = create("x", WANDER, &["robots.robot.body.radius_m=-1"]).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "robots[0].body.radius_m: must be positive, is -1");
    let refused = create("x", WANDER, &["seed"]).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "overrides[0]: `seed`: an override is PATH=VALUE");
    let refused = create("w", WANDER, &[]).await.unwrap_err();
    assert_status(&refused, Code::AlreadyExists, "there is a world `w` already");
    let refused = create("a/b", WANDER, &[]).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "world: must be 1 to 64 letters");
    let refused = create("x", &"#".repeat((16 << 20) + 1), &[]).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "the limit is 16777216");
    let refused = create("x", &"#".repeat(20 << 20), &[]).await.unwrap_err();
    assert_eq!(refused.code(), Code::OutOfRange, "{refused:?}");
    assert_eq!(create("", WANDER, &[]).await.unwrap().world, "wander");
    server.shutdown().await;
}

#[tokio::test]
async fn paces_and_orders_that_make_no_sense_are_refused() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut operator = operator(&server).await;
    let w = || "w".to_owned();
    let set = |pace| v1::SetPaceRequest { world: "w".into(), pace };
    let refused = operator.set_pace(set(None)).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "pace: must be set");
    let refused = operator.set_pace(set(Some(v1::Pace { kind: None }))).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "pace.kind: must be set");
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let kind = Some(v1::pace::Kind::Scaled(v1::Scaled { factor, max_lag_ms: 0 }));
        let refused = operator.set_pace(set(Some(v1::Pace { kind }))).await.unwrap_err();
        assert_status(&refused, Code::InvalidArgument, "pace.scaled.factor: must be positive");
    }
    let refused = operator.step_world(v1::StepWorldRequest { world: w(), ticks: 1 }).await.unwrap_err();
    assert_status(&refused, Code::FailedPrecondition, "pace is not stepped");
    let refused =
        operator.restore_world(v1::RestoreWorldRequest { world: w(), snapshot: 9 }).await.unwrap_err();
    assert_status(&refused, Code::NotFound, "keeps no snapshot 9");
    let refused = operator.get_world(v1::GetWorldRequest { world: "x".into() }).await.unwrap_err();
    assert_status(&refused, Code::NotFound, "there is no world `x`; there are: w");
    server.shutdown().await;
}

#[tokio::test]
async fn addresses_that_others_reach_are_refused_and_a_taken_port_says_so() {
    let open = Server::builder().listen("0.0.0.0:0".parse().unwrap()).serve().await;
    let Err(error @ ServerError::NotLoopback { .. }) = open else { panic!("it should be refused") };
    assert!(error.to_string().contains("0.0.0.0:0 can be reached from other machines"), "{error}");
    let server = serve_on_ports(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    for taken in server.addresses() {
        let again = Server::builder().listen(taken.clone()).serve().await;
        let Err(error @ ServerError::Bind { .. }) = again else { panic!("{taken} should be taken") };
        assert!(error.to_string().contains(&format!("cannot listen on {taken}")), "{error}");
    }
    server.shutdown().await;
}

#[tokio::test]
async fn what_ended_a_run_is_not_a_brains_to_know() {
    let wall = ["robots.robot.start.x_m=1.5"];
    let server = serve(scenario(WANDER, &wall), lockstep()).await;
    let mut stream = Stream::open(&server, messages()).await.unwrap();
    let ended = loop {
        match stream.responses.message().await.unwrap().unwrap().response.unwrap() {
            Response::Turn(turn) => stream.send(step(turn.turn, 0, command(0.5, 0.5))).await,
            Response::Ended(ended) => break ended,
            Response::Welcome(_) => {}
        }
    };
    let status = status(&server).await;
    assert_eq!(status.ending, "`robot` ran into `wall_right`");
    assert_eq!(ended, v1::Ended { tick: status.tick });
    server.shutdown().await;
}

#[tokio::test]
async fn errors_stay_short_however_long_the_list_or_the_line() {
    let names: Vec<String> = (0..16).map(|i| format!("r{i}")).collect();
    let mut toml = crowd(&names);
    for i in 0..3000 {
        toml += &format!(
            "[[robots]]\nname = \"x{i}\"\nstart = {{ x_m = {} }}\nbody = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n",
            10 + i
        );
    }
    let server = serve(scenario(&toml, &[]), lockstep()).await;
    let unknown = Stream::open(&server, hello(&["bob"], v1::PortMode::Raw)).await.err().unwrap();
    assert_status(&unknown, Code::NotFound, "and 2996 more");
    let request = v1::CreateWorldRequest { scenario_toml: "x".repeat(100_000), ..Default::default() };
    let refused = operator(&server).await.create_world(request).await.unwrap_err();
    assert_status(&refused, Code::InvalidArgument, "scenario_toml: ");
    assert!(refused.message().len() < 2000);
    server.shutdown().await;
}

#[tokio::test]
async fn a_step_names_each_robot_once() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut stream = Stream::open(&server, messages()).await.unwrap();
    let robots = vec![v1::RobotStep::default(); 100_000];
    stream.send(Request::Step(v1::Step { turn: 0, robots })).await;
    assert_status(&stream.end().await, Code::InvalidArgument, "step.robots[1].robot: 0 is named twice");
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_on_board_has_no_bytes() {
    let server =
        serve(scenario(WANDER, &["robots.robot.link={ kind = \"onboard\" }"]), Pace::REAL_TIME).await;
    let raw = Stream::open(&server, hello(&["robot"], v1::PortMode::Raw)).await.err().unwrap();
    assert_status(&raw, Code::InvalidArgument, "hello.mode: the brain of robot `robot` is on board");
    Stream::open(&server, messages()).await.expect("with messages it may attach");
    server.shutdown().await;
}

#[tokio::test]
async fn a_message_that_is_too_long_ends_its_stream_with_a_reason() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut stream = Stream::open(&server, hello(&["robot"], v1::PortMode::Raw)).await.unwrap();
    stream.send(step(0, 0, Output::Raw(vec![0; 5 << 20]))).await;
    let status = stream.end().await;
    assert_status(&status, Code::OutOfRange, "request: ");
    assert_status(&status, Code::OutOfRange, "the limit is: 4194304 bytes");
    server.shutdown().await;
}

#[tokio::test]
async fn a_mode_that_there_is_not_and_a_belief_that_cannot_be_drawn_are_refused_with_the_field() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let Request::Hello(sound) = messages() else { panic!("a Hello") };
    let odd = Request::Hello(v1::Hello { mode: 77, ..sound });
    let refused = Stream::open(&server, odd).await.err().unwrap();
    assert_status(&refused, Code::InvalidArgument, "hello.mode: must be 0 to 2 (see PortMode), is 77");
    for (covariance_m2, x_m, text) in [
        (vec![], f64::NAN, "annotate.belief.pose.x_m: must be a finite number, is NaN"),
        (
            vec![1.0, 2.0],
            0.0,
            "annotate.belief.pose.covariance_m2: must have 3 entries (xx, xy, yy) or none, has 2",
        ),
    ] {
        let mut stream = Stream::open(&server, messages()).await.unwrap();
        let pose = Some(v1::BelievedPose { x_m, covariance_m2, ..Default::default() });
        let belief = Some(v1::Belief { pose, ..Default::default() });
        stream.send(Request::Annotate(v1::Annotate { robot: 0, belief })).await;
        assert_status(&stream.end().await, Code::InvalidArgument, text);
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_stream_without_a_hello_is_ended() {
    let builder = Server::builder().first_call_within(Duration::from_millis(100));
    let server = builder.world(WorldConfig::new("w", scenario(WANDER, &[]))).in_process().await.unwrap();
    let (_requests, stream) = mpsc::channel(1);
    let channel = server.channel().await.unwrap();
    let refused = BrainLinkServiceClient::new(channel).attach(ReceiverStream::new(stream)).await.unwrap_err();
    assert_status(&refused, Code::DeadlineExceeded, "request: no Hello has come within 100ms");
    server.shutdown().await;
}
