//! The viewer's listener as a browser meets it: its files, its socket, and whom it turns away.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::page_request::Request;
use baudbot_proto::v1::page_response::Response;
use baudbot_server::{Pace, Server, WorldConfig};
use baudbot_tests::system::{lockstep, operator};
use baudbot_tests::{WANDER, scenario};
use futures_util::{SinkExt, StreamExt};
use prost::Message as _;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async, connect_async_with_config};

async fn serve(pace: Pace) -> Server {
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(pace);
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    Server::builder().world(world).viewer(free).serve().await.unwrap()
}

/// A page without a browser.
pub(super) struct Page {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    /// Responses that came while another one was waited for.
    kept: VecDeque<v1::PageResponse>,
}

impl Page {
    pub(super) async fn open(server: &Server) -> Self {
        // Small messages do not wait for acknowledgements, as in browsers.
        let (url, no_delay) = (format!("ws://{}/page", server.viewers()[0]), true);
        let (socket, _) = connect_async_with_config(url, None, no_delay).await.unwrap();
        Self { socket, kept: VecDeque::new() }
    }

    pub(super) async fn ask(&mut self, call: u32, request: Request) {
        let request = v1::PageRequest { call, request: Some(request) };
        self.socket.send(Message::Binary(request.encode_to_vec().into())).await.unwrap();
    }

    /// The next answer to a call.
    async fn answer(&mut self, call: u32) -> Response {
        if let Some(at) = self.kept.iter().position(|response| response.call == call) {
            return self.kept.remove(at).unwrap().response.unwrap();
        }
        loop {
            let message = tokio::time::timeout(Duration::from_secs(20), self.socket.next()).await;
            let Message::Binary(bytes) = message.unwrap().unwrap().unwrap() else { continue };
            let response = v1::PageResponse::decode(bytes).unwrap();
            if response.call == call {
                return response.response.unwrap();
            }
            self.kept.push_back(response);
        }
    }

    /// The next message of the method of a call.
    async fn message<T: prost::Message + Default>(&mut self, call: u32) -> T {
        match self.answer(call).await {
            Response::Message(bytes) => T::decode(&*bytes).unwrap(),
            other => panic!("no message but {other:?}"),
        }
    }

    async fn frame(&mut self, call: u32) -> v1::WatchResponse {
        self.message(call).await
    }

    /// The next response of a brain's stream; that its requests are taken goes without saying.
    async fn attached(&mut self, call: u32) -> v1::attach_response::Response {
        loop {
            match self.answer(call).await {
                Response::Message(bytes) => {
                    return v1::AttachResponse::decode(&*bytes).unwrap().response.unwrap();
                }
                Response::Taken(_) => {}
                other => panic!("nothing of a stream but {other:?}"),
            }
        }
    }

    /// Becomes the robot's brain, whose robot stands when it is gone if `stop_when_gone`.
    async fn drive(&mut self, call: u32, stop_when_gone: bool) {
        let robots = vec!["robot".into()];
        let hello = v1::Hello { world: "w".into(), robots, stop_when_gone, ..Default::default() };
        self.ask(call, attach(hello)).await;
        assert!(matches!(self.attached(call).await, v1::attach_response::Response::Welcome(_)));
    }

    /// Answers the next Turn with these signals.
    async fn steer(&mut self, call: u32, signals: (f64, f64)) {
        let v1::attach_response::Response::Turn(turn) = self.attached(call).await else { panic!() };
        self.ask(call, step(turn.turn, signals)).await;
    }

    /// The failure of a call, if it fails.
    pub(super) async fn failed(&mut self, call: u32) -> Option<(String, String)> {
        match self.answer(call).await {
            Response::Failure(v1::Failure { code, message }) => Some((code, message)),
            Response::Message(_) | Response::Closed(_) | Response::Taken(_) => None,
        }
    }

    async fn failure(&mut self, call: u32, request: Request) -> (String, String) {
        self.ask(call, request).await;
        match self.answer(call).await {
            Response::Failure(v1::Failure { code, message }) => (code, message),
            other => panic!("no failure but {other:?}"),
        }
    }
}

/// The beginning of a call of a method such as `ControlService/GetWorld`.
fn begin(method: &str, request: &impl prost::Message) -> Request {
    let (method, request) = (format!("baudbot.v1.{method}"), request.encode_to_vec());
    Request::Begin(v1::BeginCall { method, request })
}

fn attach(hello: v1::Hello) -> Request {
    let request = Some(v1::attach_request::Request::Hello(hello));
    begin("BrainLinkService/Attach", &v1::AttachRequest { request })
}

/// A further request on the stream of a brain.
fn further(request: v1::attach_request::Request) -> Request {
    Request::Next(v1::AttachRequest { request: Some(request) }.encode_to_vec())
}

fn step(turn: u64, (left_signal, right_signal): (f64, f64)) -> Request {
    let command = v1::Command { left_signal, right_signal, other_signals: vec![] };
    let output = Some(v1::robot_step::Output::Command(command));
    let robots = vec![v1::RobotStep { robot: 0, output, ..Default::default() }];
    further(v1::attach_request::Request::Step(v1::Step { turn, robots }))
}

fn get_world(world: &str) -> Request {
    begin("ControlService/GetWorld", &v1::GetWorldRequest { world: world.into() })
}

fn pause_world() -> Request {
    begin("ControlService/PauseWorld", &v1::PauseWorldRequest { world: "w".into() })
}

fn watch(details: &[&str]) -> Request {
    let details = details.iter().map(ToString::to_string).collect();
    begin(
        "ObserveService/Watch",
        &v1::WatchRequest { world: "w".into(), every_ticks: 2, details, ..Default::default() },
    )
}

/// A request as a browser would write it; the answer with its headers.
async fn get(server: &Server, request: &str) -> String {
    let mut stream = TcpStream::connect(server.viewers()[0]).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    let _ = tokio::time::timeout(Duration::from_secs(20), stream.read_to_end(&mut answer)).await.unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn the_page_comes_with_the_program_and_takes_no_script_from_elsewhere() {
    let server = serve(lockstep()).await;
    for (path, kind) in [("/", "text/html"), ("/viewer.js", "text/javascript"), ("/viewer.css", "text/css")] {
        let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
        let answer = get(&server, &request).await;
        assert!(answer.starts_with("HTTP/1.1 200 OK"), "{path}: {answer:.200}");
        assert!(answer.contains(&format!("content-type: {kind}")), "{path}");
        assert!(answer.contains("content-security-policy: default-src 'none'; script-src 'self'"), "{path}");
    }
    let nothing = "GET /etc/passwd HTTP/1.1\r\nHost: 127.0.0.1:1\r\nConnection: close\r\n\r\n";
    assert!(get(&server, nothing).await.starts_with("HTTP/1.1 404"));
    server.shutdown().await;
}

#[tokio::test]
async fn strangers_are_turned_away() {
    let server = serve(lockstep()).await;
    let rebound = "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
    assert!(get(&server, rebound).await.starts_with("HTTP/1.1 403"));
    let url = format!("ws://{}/page", server.viewers()[0]);
    let mut request = url.as_str().into_client_request().unwrap();
    request.headers_mut().insert("origin", "http://evil.example".parse().unwrap());
    match connect_async(request).await {
        Err(Error::Http(response)) => assert_eq!(response.status(), 403),
        other => panic!("{other:?}"),
    }
    let mut request = url.as_str().into_client_request().unwrap();
    let own = format!("http://{}", server.viewers()[0]);
    request.headers_mut().insert("origin", own.parse().unwrap());
    connect_async(request).await.unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn a_program_at_the_pages_address_is_told_of_the_right_one() {
    let server = serve(lockstep()).await;
    let url = format!("http://{}", server.viewers()[0]);
    let channel = tonic::transport::Channel::from_shared(url).unwrap().connect().await.unwrap();
    let request = v1::GetWorldRequest { world: "w".into() };
    let refused = ControlServiceClient::new(channel).get_world(request).await.unwrap_err();
    assert_eq!(refused.code(), tonic::Code::Unimplemented);
    assert!(refused.message().starts_with("the viewer's page is at this address; "), "{refused}");
}

#[tokio::test]
async fn a_page_operates_a_world_and_sees_it_move() {
    let server = serve(Pace::REAL_TIME).await;
    let mut page = Page::open(&server).await;
    let request = v1::DescribeWorldRequest { world: "w".into() };
    page.ask(1, begin("ObserveService/DescribeWorld", &request)).await;
    let description: v1::DescribeWorldResponse = page.message(1).await;
    let sheet = description.robots[0].description.as_ref().unwrap();
    assert!(sheet.sensors.len() > 2 && description.robots[0].deadline_ns == description.step_ns);
    page.ask(2, watch(&["robot"])).await;
    let first = page.frame(2).await;
    let mut frame = page.frame(2).await;
    while frame.tick < first.tick + 20 {
        frame = page.frame(2).await;
    }
    let detail = &frame.details[0];
    assert_eq!(detail.sensors.len(), sheet.sensors.len());
    assert!(
        detail.sensors.iter().any(|sensor| sensor.rays.as_ref().is_some_and(|r| !r.lengths_m.is_empty()))
    );
    assert!(detail.sensors.iter().all(|sensor| sensor.samples > 0));
    let acquired = |event: &v1::TimelineEvent| event.kind() == v1::TimelineKind::Acquire;
    assert!(detail.events.iter().any(acquired), "{:?}", detail.events);
    // Events come once.
    let ends = page.frame(2).await.details[0].events.iter().map(|event| event.end_ns).min();
    assert!(ends.unwrap() >= first.time_ns);

    page.ask(3, pause_world()).await;
    let paused: v1::PauseWorldResponse = page.message(3).await;
    assert_eq!(paused.status.unwrap().state(), v1::WorldState::Paused);
    let place = v1::PlaceRobot { robot: "robot".into(), x_m: 0.0, y_m: 0.0, heading_rad: 1.0 };
    let intervention = v1::intervene_request::Intervention::PlaceRobot(place);
    let request = v1::InterveneRequest { world: "w".into(), intervention: Some(intervention) };
    page.ask(4, begin("ControlService/Intervene", &request)).await;
    page.message::<v1::InterveneResponse>(4).await;
    // A world that stands shows it all the same.
    while page.frame(2).await.robots[0].heading_rad != 1.0 {}

    page.ask(2, Request::Close(v1::CloseCall {})).await;
    while !matches!(page.answer(2).await, Response::Closed(_)) {}
    server.shutdown().await;
}

#[tokio::test]
async fn a_page_gets_the_map_of_a_floor_that_is_counted() {
    let server = serve(lockstep()).await;
    let mut page = Page::open(&server).await;
    let ask =
        |world: &str| begin("ObserveService/GetCoverage", &v1::GetCoverageRequest { world: world.into() });
    let (code, message) = page.failure(1, ask("w")).await;
    assert_eq!(code, "FAILED_PRECONDITION");
    assert!(message.contains("metrics.cell_m"), "{message}");
    let counted = v1::CreateWorldRequest {
        world: "counted".into(),
        scenario_toml: WANDER.into(),
        overrides: vec!["metrics.cell_m=0.1".into()],
        paused: true,
        ..Default::default()
    };
    page.ask(2, begin("ControlService/CreateWorld", &counted)).await;
    page.message::<v1::CreateWorldResponse>(2).await;
    page.ask(3, ask("counted")).await;
    let map: v1::GetCoverageResponse = page.message(3).await;
    assert_eq!(map.free.iter().sum::<u32>(), map.columns * map.rows);
    server.shutdown().await;
}

#[tokio::test]
async fn calls_that_fail_say_why_and_the_page_goes_on() {
    let server = serve(lockstep()).await;
    let mut page = Page::open(&server).await;
    let (code, message) = page.failure(1, get_world("nowhere")).await;
    assert_eq!(code, "NOT_FOUND");
    assert!(message.contains("there is no world `nowhere`"), "{message}");
    let wrong = v1::CreateWorldRequest { scenario_toml: "step_ms = -1".into(), ..Default::default() };
    let (code, message) = page.failure(2, begin("ControlService/CreateWorld", &wrong)).await;
    assert_eq!((code.as_str(), message.contains("step_ms")), ("INVALID_ARGUMENT", true), "{message}");
    let (code, message) = page.failure(3, watch(&["robot", "nobody"])).await;
    assert_eq!((code.as_str(), message.as_str()), ("NOT_FOUND", "details[1]: there is no robot `nobody`"));
    page.ask(4, watch(&[])).await;
    page.frame(4).await;
    let (code, _) = page.failure(4, get_world("w")).await;
    assert_eq!(code, "ALREADY_EXISTS");
    page.ask(5, get_world("w")).await;
    page.message::<v1::GetWorldResponse>(5).await;
    // A message that is no request ends the socket, and nothing else.
    page.socket.send(Message::Binary(vec![0xff; 100].into())).await.unwrap();
    while let Some(Ok(_)) = page.socket.next().await {}
    let mut other = Page::open(&server).await;
    other.ask(1, get_world("w")).await;
    other.message::<v1::GetWorldResponse>(1).await;
    server.shutdown().await;
}

#[tokio::test]
async fn only_methods_of_the_three_services_are_forwarded_and_each_call_has_one_beginning() {
    let server = serve(lockstep()).await;
    let mut page = Page::open(&server).await;
    for method in ["ControlService/Nothing", "TrainerService/Train", "Health/Check", ""] {
        let (code, message) = page.failure(1, begin(method, &v1::ListWorldsRequest {})).await;
        assert_eq!(code, "UNIMPLEMENTED");
        let expected = format!("method: there is no method `baudbot.v1.{method}`; services are ");
        assert!(message.starts_with(&expected), "{message}");
    }
    let garbled =
        v1::BeginCall { method: "baudbot.v1.ControlService/GetWorld".into(), request: vec![0xff; 9] };
    let (code, _) = page.failure(2, Request::Begin(garbled)).await;
    assert_eq!(code, "INTERNAL");
    let (code, message) = page.failure(3, step(0, (0.0, 0.0))).await;
    assert_eq!((code.as_str(), message.as_str()), ("FAILED_PRECONDITION", "next: the call is not under way"));
    // Neither is a stream open to further requests whose method takes a single one.
    page.ask(4, watch(&[])).await;
    page.frame(4).await;
    let (code, _) = page.failure(4, step(0, (0.0, 0.0))).await;
    assert_eq!(code, "ALREADY_EXISTS");
    server.shutdown().await;
}

#[tokio::test]
async fn a_page_drives_a_robot_through_its_link_and_shows_what_it_believes() {
    let server = serve(lockstep()).await;
    let (mut page, mut other) = (Page::open(&server).await, Page::open(&server).await);
    page.drive(7, false).await;
    other.ask(1, watch(&["robot"])).await;
    let mut believed = None;
    for _ in 0..100 {
        let v1::attach_response::Response::Turn(turn) = page.attached(7).await else { panic!() };
        let belief = v1::Belief { state: format!("turn {}", turn.turn), ..Default::default() };
        let annotate = v1::Annotate { robot: 0, belief: Some(belief) };
        page.ask(7, further(v1::attach_request::Request::Annotate(annotate))).await;
        page.ask(7, step(turn.turn, (0.2, 0.2))).await;
    }
    while believed.is_none() {
        let frame = other.frame(1).await;
        assert!(frame.details[0].attached);
        believed = frame.annotations.into_iter().next();
    }
    let believed = believed.unwrap();
    assert!(believed.robot == 0 && believed.belief.unwrap().state.starts_with("turn "));
    // The page is closed, and with it the brain is gone.
    drop(page);
    let request = || v1::GetWorldRequest { world: "w".into() };
    let mut operator = operator(&server).await;
    loop {
        let status = operator.get_world(request()).await.unwrap().into_inner().status.unwrap();
        if !status.robots[0].attached {
            assert!(status.robots[0].distance_m > 0.01);
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    server.shutdown().await;
}

/// The robot turns on the spot, so that it runs into nothing.
const SPIN: (f64, f64) = (0.4, -0.4);

/// Drives until the robot's motors turn it; what they get is seen by `other`, whose Watch has this number.
async fn spin(page: &mut Page, call: u32, other: &mut Page, watch: u32) {
    while other.frame(watch).await.robots[0].left_signal < 0.3 {
        page.steer(call, SPIN).await;
    }
}

async fn until_it_stands(other: &mut Page, watch: u32) {
    while other.frame(watch).await.robots[0].left_signal != 0.0 {}
}

#[tokio::test]
async fn a_robot_stands_when_the_page_that_drives_it_is_gone_however_it_goes() {
    let server = serve(Pace::REAL_TIME).await;
    let mut operator = operator(&server).await;
    let mut other = Page::open(&server).await;
    other.ask(1, watch(&[])).await;
    for way in ["it lets go", "it is closed", "the operator throws it off", "it says nonsense"] {
        let mut page = Page::open(&server).await;
        page.drive(7, true).await;
        spin(&mut page, 7, &mut other, 1).await;
        match way {
            "it lets go" => page.ask(7, Request::Close(v1::CloseCall {})).await,
            "it is closed" => drop(page),
            "the operator throws it off" => {
                let detach = v1::DetachBrain { robot: "robot".into(), restart: false };
                let intervention = Some(v1::intervene_request::Intervention::DetachBrain(detach));
                let request = v1::InterveneRequest { world: "w".into(), intervention };
                operator.intervene(request).await.unwrap();
            }
            _ => page.ask(7, step(0, (9.0, f64::NAN))).await,
        }
        until_it_stands(&mut other, 1).await;
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_robot_goes_on_when_its_brain_is_gone_and_wanted_no_last_word() {
    let server = serve(Pace::REAL_TIME).await;
    let (mut page, mut other) = (Page::open(&server).await, Page::open(&server).await);
    other.ask(1, watch(&["robot"])).await;
    page.drive(7, false).await;
    spin(&mut page, 7, &mut other, 1).await;
    drop(page);
    while other.frame(1).await.details[0].attached {}
    for _ in 0..10 {
        assert!(other.frame(1).await.robots[0].left_signal > 0.3);
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_that_waits_for_its_brains_stops_the_robot_of_a_page_that_is_gone() {
    let server = serve(lockstep()).await;
    let (mut page, mut other) = (Page::open(&server).await, Page::open(&server).await);
    page.drive(7, true).await;
    other.ask(1, watch(&[])).await;
    for _ in 0..50 {
        page.steer(7, SPIN).await;
    }
    while other.frame(1).await.robots[0].left_signal < 0.3 {}
    drop(page);
    let mut operator = operator(&server).await;
    let request = || v1::GetWorldRequest { world: "w".into() };
    while operator.get_world(request()).await.unwrap().into_inner().status.unwrap().robots[0].attached {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    // The world waits for another brain, and the operator lets it go on without.
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    until_it_stands(&mut other, 1).await;
    server.shutdown().await;
}

#[tokio::test]
async fn a_robot_stands_while_the_page_that_drives_it_says_nothing() {
    let server = serve(Pace::REAL_TIME).await;
    let (mut page, mut other) = (Page::open(&server).await, Page::open(&server).await);
    other.ask(1, watch(&["robot"])).await;
    page.drive(7, true).await;
    spin(&mut page, 7, &mut other, 1).await;
    until_it_stands(&mut other, 1).await;
    let frame = other.frame(1).await;
    assert!(frame.tick > 100 && frame.details[0].attached, "{}", frame.tick);
    // A word of it, and it is driven again.
    page.ask(7, step(0, SPIN)).await;
    while other.frame(1).await.robots[0].left_signal < 0.3 {}
    server.shutdown().await;
}

#[tokio::test]
async fn a_page_that_says_more_than_its_world_takes_is_not_thrown_off() {
    let server = serve(Pace::REAL_TIME).await;
    let mut page = Page::open(&server).await;
    page.ask(1, pause_world()).await;
    page.message::<v1::PauseWorldResponse>(1).await;
    page.drive(7, true).await;
    for _ in 0..3000 {
        page.ask(7, step(0, SPIN)).await;
    }
    let mut taken = 0;
    while taken < 3000 {
        match page.answer(7).await {
            Response::Taken(_) => taken += 1,
            Response::Message(_) => {}
            other => panic!("after {taken}: {other:?}"),
        }
    }
    page.ask(2, get_world("w")).await;
    let answer: v1::GetWorldResponse = page.message(2).await;
    assert!(answer.status.unwrap().robots[0].attached);
    server.shutdown().await;
}

#[tokio::test]
async fn raw_bytes_have_no_last_word() {
    let server = serve(lockstep()).await;
    let hello = v1::Hello {
        world: "w".into(),
        robots: vec!["robot".into()],
        mode: v1::PortMode::Raw.into(),
        stop_when_gone: true,
        ..Default::default()
    };
    let (code, message) = Page::open(&server).await.failure(1, attach(hello)).await;
    assert_eq!((code.as_str(), message.contains("MESSAGES")), ("INVALID_ARGUMENT", true), "{message}");
    server.shutdown().await;
}

#[tokio::test]
async fn a_page_that_does_not_read_misses_frames_and_slows_nobody() {
    let server = serve(Pace::Free).await;
    let mut stalled = Page::open(&server).await;
    stalled.ask(1, watch(&["robot"])).await;
    let mut operator = operator(&server).await;
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let mut ticks = async || {
        let request = v1::GetWorldRequest { world: "w".into() };
        operator.get_world(request).await.unwrap().into_inner().status.unwrap().tick
    };
    let begun = ticks().await;
    while ticks().await < begun + 20_000 {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    // The page reads again: all that is left of the missed frames is their number.
    let mut frame = stalled.frame(1).await;
    while frame.missed_frames == 0 {
        frame = stalled.frame(1).await;
    }
    server.shutdown().await;
}

fn post(path: &str, origin: &str, body: &str) -> String {
    let length = body.len();
    format!(
        "POST {path} HTTP/1.1\r\nHost: localhost:1\r\nOrigin: http://{origin}\r\nContent-Length: {length}\r\n\
         Connection: close\r\n\r\n{body}"
    )
}

#[tokio::test]
async fn a_page_hands_in_films_where_somebody_wants_them() {
    let (films, mut made) = tokio::sync::mpsc::channel(2);
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep());
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::builder().world(world).viewer(free).films(films).serve().await.unwrap();
    assert!(get(&server, &post("/film", "localhost:1", "GIF89a")).await.starts_with("HTTP/1.1 204"));
    assert_eq!(made.try_recv().unwrap(), Ok(b"GIF89a".to_vec()));
    let failed = post("/film?failed=1", "localhost:1", "no encoder");
    assert!(get(&server, &failed).await.starts_with("HTTP/1.1 204"));
    assert_eq!(made.try_recv().unwrap().unwrap_err().to_string(), "no encoder");
    // Larger than what other requests may have.
    let long = "x".repeat(5 << 20);
    assert!(get(&server, &post("/film", "localhost:1", &long)).await.starts_with("HTTP/1.1 204"));
    assert_eq!(made.try_recv().unwrap().unwrap().len(), long.len());
    let stranger = get(&server, &post("/film", "evil.example", "GIF89a")).await;
    assert!(stranger.starts_with("HTTP/1.1 403"), "{stranger}");
    assert!(made.try_recv().is_err());
    drop(made);
    assert!(get(&server, &post("/film", "localhost:1", "GIF89a")).await.starts_with("HTTP/1.1 410"));
    server.shutdown().await;
    let server = serve(lockstep()).await;
    let unasked = get(&server, &post("/film", "localhost:1", "GIF89a")).await;
    assert!(unasked.starts_with("HTTP/1.1 405") || unasked.starts_with("HTTP/1.1 404"), "{unasked}");
}
