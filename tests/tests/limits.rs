//! Limits: each is reached, reported in words and counted; the other clients go on undisturbed, and what is given back
//! can be had again.

use std::net::SocketAddr;
use std::time::{Duration, Instant, SystemTime};

use baudbot_access::{NewGrant, Token, TokenFile};
use baudbot_client::{Channel, Client, Credentials, Error, Robot, connect_with};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_proto::v1::page_request::Request as Asked;
use baudbot_server::{Builder, LIMITS, Limit, Limits, Pace, Server, WorldConfig};
use baudbot_tests::{WANDER, crowd, scenario};
use prost::Message as _;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tonic::{Code, Status};

use super::page::Page;

type Operator = ControlServiceClient<Channel>;

/// A server with these limits, a paused world `w` with robots `r0` to `r15`, a port, and a port for pages.
async fn serve(limits: Limits) -> Server {
    serve_with(limits, |builder| builder).await
}

async fn serve_with(limits: Limits, configure: impl FnOnce(Builder) -> Builder) -> Server {
    let names: Vec<_> = (0..16).map(|i| format!("r{i}")).collect();
    let world = WorldConfig::new("w", scenario(&crowd(&names), &[])).pace(Pace::REAL_TIME).paused(true);
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let builder = Server::builder().limits(limits).world(world).viewer(free);
    configure(builder.listen("127.0.0.1:0".parse().unwrap())).serve().await.unwrap()
}

/// A server with the tokens `alice` and `bob`, which may do everything.
async fn serve_class(limits: Limits) -> (Server, [Token; 2], TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("tokens.toml"));
    let tokens = ["alice", "bob"].map(|name| {
        let rights = ["operate", "drive w/*"].map(|right| right.parse().unwrap()).into();
        file.add(NewGrant { name: name.parse().unwrap(), rights, expires_at: None }, SystemTime::now())
            .unwrap()
    });
    (serve_with(limits, |builder| builder.tokens(file)).await, tokens, folder)
}

/// A new connection over TCP.
async fn connect(server: &Server, token: Option<&Token>) -> Client {
    let token = token.map(|token| token.reveal().parse().unwrap());
    let credentials = token.map_or_else(Credentials::default, |token| Credentials::default().token(token));
    connect_with(&server.addresses()[0].to_string(), &credentials).await.unwrap()
}

/// An operator in this process.
async fn operator(server: &Server) -> Operator {
    ControlServiceClient::new(server.channel().await.unwrap().into())
}

async fn operator_of(server: &Server, token: Option<&Token>) -> Operator {
    ControlServiceClient::new(connect(server, token).await.channel())
}

/// Checks the words of a refusal.
#[track_caller]
fn assert_refused(refused: Result<impl Sized, Error>, code: Code, words: &str) {
    match refused {
        Err(Error::Status { code: found, message }) => assert_eq!((found, &*message), (code, words)),
        Err(error) => panic!("another error: {error}"),
        Ok(_) => panic!("not refused: {words}"),
    }
}

#[track_caller]
fn assert_exhausted(refused: Result<impl Sized, Status>, words: &str) {
    let status = refused.err().unwrap_or_else(|| panic!("not refused: {words}"));
    assert_eq!((status.code(), status.message()), (Code::ResourceExhausted, words));
}

/// Tries until it goes well.
async fn until_ok<T, E: std::fmt::Display>(mut attempt: impl AsyncFnMut() -> Result<T, E>) -> T {
    let started = Instant::now();
    loop {
        match attempt().await {
            Ok(done) => return done,
            Err(error) => assert!(started.elapsed() < Duration::from_secs(20), "{error}"),
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

/// The answer to a request for this path; what is left of it, if the connection is closed before.
async fn answers(server: &Server, path: &str) -> String {
    let mut page = TcpStream::connect(server.viewers()[0]).await.unwrap();
    page.write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    let _ = page.read_to_end(&mut answer).await;
    String::from_utf8_lossy(&answer).into_owned()
}

/// A metric of a limit.
async fn metric(server: &Server, family: &str, limit: &str) -> f64 {
    let answer = answers(server, "/metrics").await;
    let start = format!("{family}{{limit=\"{limit}\"}} ");
    let line = answer.lines().find_map(|line| line.strip_prefix(&start));
    line.unwrap_or_else(|| panic!("no {start} in {answer}")).parse().unwrap()
}

async fn refusals(server: &Server, limit: &str) -> f64 {
    metric(server, "baudbot_limit_refused_total", limit).await
}

async fn used(server: &Server, limit: &str) -> f64 {
    metric(server, "baudbot_limit_used", limit).await
}

fn create(name: &str, toml: &str) -> v1::CreateWorldRequest {
    let (world, scenario_toml) = (name.to_owned(), toml.to_owned());
    v1::CreateWorldRequest { world, scenario_toml, paused: true, ..Default::default() }
}

async fn delete(operator: &mut Operator, world: &str) {
    operator.delete_world(v1::DeleteWorldRequest { world: world.into() }).await.unwrap();
}

async fn snapshot(
    operator: &mut Operator,
    world: &str,
) -> Result<tonic::Response<v1::SnapshotWorldResponse>, Status> {
    operator.snapshot_world(v1::SnapshotWorldRequest { world: world.into() }).await
}

/// Shows that a brain goes on: its world makes ticks, and it answers.
async fn goes_on(server: &Server, robot: &mut Robot) {
    let start = v1::StartWorldRequest { world: "w".into() };
    operator(server).await.start_world(start).await.unwrap();
    let turn = timeout(Duration::from_secs(20), robot.turn()).await.expect("a turn");
    assert!(turn.unwrap().is_some());
}

#[tokio::test]
async fn an_address_has_so_many_connections_and_gets_another_when_one_goes() {
    let server = serve(Limits::default().with(Limit::ConnectionsPerAddress, 3)).await;
    let mut robots = Vec::new();
    for i in 0..3 {
        robots.push(connect(&server, None).await.attach("w", &format!("r{i}")).await.unwrap());
    }
    let words = "the address 127.0.0.1 has 3 connections, which is its limit; close one, or start the server with a larger \
                 --max-connections-per-address";
    for _ in 0..3 {
        assert_refused(connect(&server, None).await.attach("w", "r3").await, Code::ResourceExhausted, words);
    }
    // A page is no better.
    let answer = answers(&server, "/").await;
    assert!(answer.starts_with("HTTP/1.1 503") && answer.contains(words), "{answer}");
    drop(robots.pop());
    let mut third = until_ok(async || connect(&server, None).await.attach("w", "r3").await).await;
    goes_on(&server, &mut third).await;
    drop(third);
    // The metrics need a connection, too.
    until_ok(async || match answers(&server, "/metrics").await.starts_with("HTTP/1.1 200") {
        true => Ok(()),
        false => Err("no metrics"),
    })
    .await;
    assert!(refusals(&server, "connections_per_address").await >= 4.0);
    server.shutdown().await;
}

#[tokio::test]
async fn a_token_has_so_many_connections_and_another_token_its_own() {
    let (server, [alice, bob], _folder) =
        serve_class(Limits::default().with(Limit::ConnectionsPerToken, 2)).await;
    let first = connect(&server, Some(&alice)).await.attach("w", "r0").await.unwrap();
    let _second = connect(&server, Some(&alice)).await.attach("w", "r1").await.unwrap();
    let words = "the token `alice` has 2 connections, which is its limit; close one, or start the server with a larger \
                 --max-connections-per-token";
    let third = connect(&server, Some(&alice)).await;
    assert_refused(third.attach("w", "r2").await, Code::ResourceExhausted, words);
    connect(&server, Some(&bob)).await.attach("w", "r2").await.unwrap();
    drop(first);
    // The connection that was refused is there still, and may be used by now.
    until_ok(async || third.attach("w", "r3").await).await;
    server.shutdown().await;
}

#[tokio::test]
async fn calls_without_a_token_keep_nobody_out_who_has_one() {
    let (server, [alice, bob], _folder) = serve_class(Limits::default().with(Limit::Connections, 4)).await;
    let _alice = connect(&server, Some(&alice)).await.attach("w", "r0").await.unwrap();
    let mut strangers = Vec::new();
    for _ in 0..20 {
        let stranger = connect(&server, None).await;
        assert!(stranger.attach("w", "r1").await.is_err());
        strangers.push(stranger);
    }
    let bob = connect(&server, Some(&bob)).await;
    let _bob = bob.attach("w", "r1").await.unwrap();
    assert!(bob.attach("w", "r0").await.is_err(), "alice has it still");
    server.shutdown().await;
}

#[tokio::test]
async fn a_connection_has_so_many_open_calls_and_the_next_are_refused_in_words() {
    let server = serve(Limits::default().with(Limit::StreamsPerConnection, 3)).await;
    let client = connect(&server, None).await;
    let mut robots = Vec::new();
    for i in 0..3 {
        robots.push(client.attach("w", &format!("r{i}")).await.unwrap());
    }
    let words = "this connection has 3 open calls, which is its limit; end one, or connect again, or start the server with a larger \
                 --max-streams-per-connection";
    assert_refused(client.attach("w", "r3").await, Code::ResourceExhausted, words);
    connect(&server, None).await.attach("w", "r3").await.unwrap();
    drop(robots.pop());
    let mut another = until_ok(async || client.attach("w", "r4").await).await;
    goes_on(&server, &mut another).await;
    assert!(refusals(&server, "streams_per_connection").await >= 1.0);
    server.shutdown().await;
}

#[tokio::test]
async fn a_caller_has_so_many_open_calls_over_all_its_connections() {
    let (server, [alice, bob], _folder) =
        serve_class(Limits::default().with(Limit::StreamsPerCaller, 2)).await;
    let first = connect(&server, Some(&alice)).await.attach("w", "r0").await.unwrap();
    let _second = connect(&server, Some(&alice)).await.attach("w", "r1").await.unwrap();
    let third = connect(&server, Some(&alice)).await;
    let words = "the token `alice` has 2 open calls, which is its limit; end one, or start the server with a larger \
                 --max-streams-per-caller";
    assert_refused(third.attach("w", "r2").await, Code::ResourceExhausted, words);
    connect(&server, Some(&bob)).await.attach("w", "r2").await.unwrap();
    drop(first);
    until_ok(async || third.attach("w", "r3").await).await;
    server.shutdown().await;
}

#[tokio::test]
async fn a_caller_makes_so_many_requests_a_second_and_steps_of_a_brain_are_none() {
    let server = serve(Limits::default().with(Limit::RequestsPerS, 50)).await;
    let client = connect(&server, None).await;
    let mut robot = client.attach("w", "r0").await.unwrap();
    let mut control = ControlServiceClient::new(client.channel());
    let started = Instant::now();
    let refused = loop {
        assert!(started.elapsed() < Duration::from_secs(20), "no limit is met");
        if let Err(status) = control.list_worlds(v1::ListWorldsRequest {}).await {
            break status;
        }
    };
    assert_eq!(refused.code(), Code::ResourceExhausted);
    let (words, rest) = refused.message().split_once("; try again in ").unwrap();
    assert_eq!(words, "the address 127.0.0.1 has made 50 requests in a second, which is its limit");
    assert!(rest.ends_with(" ms, or start the server with a larger --max-requests-per-s"), "{rest}");
    let after: u64 =
        refused.metadata().get("grpc-retry-pushback-ms").unwrap().to_str().unwrap().parse().unwrap();
    assert!((1..=20).contains(&after), "{after}");
    // This process is not limited, and a stream that is open is not, either.
    goes_on(&server, &mut robot).await;
    for _ in 0..200 {
        operator(&server).await.list_worlds(v1::ListWorldsRequest {}).await.unwrap();
    }
    until_ok(async || control.list_worlds(v1::ListWorldsRequest {}).await).await;
    server.shutdown().await;
}

#[tokio::test]
async fn what_a_page_asks_for_over_its_socket_are_requests() {
    let server = serve(Limits::default().with(Limit::RequestsPerS, 20)).await;
    let mut page = Page::open(&server).await;
    let list = || {
        let request = v1::ListWorldsRequest {}.encode_to_vec();
        Asked::Begin(v1::BeginCall { method: "baudbot.v1.ControlService/ListWorlds".into(), request })
    };
    for call in 1..200 {
        page.ask(call, list()).await;
        if let Some((code, message)) = page.failed(call).await {
            assert_eq!(code, "RESOURCE_EXHAUSTED");
            assert!(
                message.starts_with("the address 127.0.0.1 has made 20 requests in a second"),
                "{message}"
            );
            assert!(call > 30, "{call}");
            server.shutdown().await;
            return;
        }
    }
    panic!("no limit is met");
}

#[tokio::test]
async fn requests_to_the_page_over_http_are_limited_too() {
    let server = serve(Limits::default().with(Limit::RequestsPerS, 10)).await;
    for i in 0..100 {
        let answer = answers(&server, "/").await;
        if answer.starts_with("HTTP/1.1 429") {
            assert!(answer.contains("retry-after: 1\r\n") && i >= 20, "{i}: {answer}");
            return server.shutdown().await;
        }
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
    panic!("no limit is met");
}

#[tokio::test]
async fn worlds_and_robots_have_a_limit_for_each_caller_and_for_all() {
    let limits = Limits::default()
        .with(Limit::Worlds, 4)
        .with(Limit::WorldsPerCaller, 2)
        .with(Limit::Robots, 19)
        .with(Limit::RobotsPerWorld, 16);
    let (server, [alice, bob], _folder) = serve_class(limits).await;
    let [mut alice, mut bob] =
        [operator_of(&server, Some(&alice)).await, operator_of(&server, Some(&bob)).await];
    for name in ["a1", "a2"] {
        alice.create_world(create(name, WANDER)).await.unwrap();
    }
    let words = "the token `alice` has 2 worlds, which is its limit; delete one, or start the server with a larger \
                 --max-worlds-per-caller";
    assert_exhausted(alice.create_world(create("a3", WANDER)).await, words);
    let clone = v1::CloneWorldRequest { original: "a1".into(), ..Default::default() };
    assert_exhausted(alice.clone_world(clone).await, words);
    let many: Vec<_> = (0..17).map(|i| format!("r{i}")).collect();
    assert_exhausted(
        bob.create_world(create("b", &crowd(&many))).await,
        "the world would have 17 robots, more than 16, which is its limit; make several worlds, or start the server with a larger \
         --max-robots-per-world",
    );
    assert_exhausted(
        bob.create_world(create("b", &crowd(&many[..2]))).await,
        "with 2 more robots the server would have more than 19, which is its limit; delete a world, or start the server with a larger \
         --max-robots",
    );
    bob.create_world(create("b1", WANDER)).await.unwrap();
    assert_exhausted(
        bob.create_world(create("b2", WANDER)).await,
        "the server has 4 worlds, which is its limit; delete one, or start the server with a larger --max-worlds",
    );
    delete(&mut bob, "a1").await;
    alice.create_world(create("a3", WANDER)).await.unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn the_oldest_snapshot_of_a_world_goes_and_its_caller_is_told() {
    let limits = Limits::default().with(Limit::SnapshotsPerWorld, 2).with(Limit::Snapshots, 3);
    let server = serve(limits).await;
    let mut control = operator(&server).await;
    control.create_world(create("v", WANDER)).await.unwrap();
    for number in 1..=2 {
        let response = snapshot(&mut control, "w").await.unwrap();
        assert!(response.metadata().get("baudbot-note").is_none());
        assert_eq!(response.into_inner().snapshot, number);
    }
    snapshot(&mut control, "v").await.unwrap();
    let words = "the server has 3 snapshots, which is its limit; delete a world that has some, or start the server with a larger \
                 --max-snapshots";
    assert_exhausted(snapshot(&mut control, "v").await, words);
    // A world that has all of its own needs no place.
    let third = snapshot(&mut control, "w").await.unwrap();
    let note = third.metadata().get("baudbot-note").unwrap();
    assert_eq!(note, "snapshot 1 has gone, as a world keeps 2 (--max-snapshots-per-world)");
    let restore = |snapshot| v1::RestoreWorldRequest { world: "w".into(), snapshot };
    assert_eq!(control.restore_world(restore(1)).await.unwrap_err().code(), Code::NotFound);
    control.restore_world(restore(2)).await.unwrap();
    assert_eq!(refusals(&server, "snapshots").await, 1.0);
    assert_eq!(refusals(&server, "snapshots_per_world").await, 1.0);
    assert_eq!(used(&server, "snapshots").await, 3.0);
    delete(&mut control, "w").await;
    until_ok(async || snapshot(&mut control, "v").await).await;
    server.shutdown().await;
}

/// The memory that a server holds.
async fn held(server: &Server) -> u64 {
    used(server, "memory_bytes").await as u64
}

#[tokio::test]
async fn memory_is_refused_before_it_is_taken_and_given_back() {
    const MB: u64 = 1_000_000;
    let server = serve(Limits::default().with(Limit::Memory, 3 * MB)).await;
    let mut control = operator(&server).await;
    let empty = held(&server).await;
    assert!((30_000..1_000_000).contains(&empty), "{empty}");
    // The text alone is enough for a refusal.
    let walls: String = (0..2000)
        .map(|i| format!("[[arena.circles]]\nname = \"p{i}\"\nx_m = {i}.0\ny_m = 0.0\nradius_m = 0.1\n"))
        .collect();
    let refused = control.create_world(create("large", &walls)).await.unwrap_err();
    assert_eq!(refused.code(), Code::ResourceExhausted);
    let (words, rest) = refused.message().split_once(" MB, and ").unwrap();
    assert!(words.starts_with("this takes "), "{words}");
    assert!(rest.ends_with("free of the server's 3.0 MB, which is its limit; delete a world, or start the server with a larger --max-memory"), "{rest}");
    assert_eq!(held(&server).await, empty);
    // Each of these takes a state until there is no room for another.
    let mut taken = 0;
    let refused = loop {
        match snapshot(&mut control, "w").await {
            Ok(_) => taken += 1,
            Err(status) => break status,
        }
        if taken % 64 == 0 {
            let clone = v1::CloneWorldRequest { original: "w".into(), ..Default::default() };
            if let Err(status) = control.clone_world(clone).await {
                break status;
            }
        }
        assert!(taken < 10_000, "no limit is met");
    };
    assert!(refused.message().starts_with("this takes "), "{refused}");
    assert!(held(&server).await <= 3 * MB);
    let world = || "w".to_owned();
    let clone = v1::CloneWorldRequest { original: world(), ..Default::default() };
    let restore = v1::RestoreWorldRequest { world: world(), snapshot: taken };
    let reset = v1::ResetWorldRequest { world: world(), ..Default::default() };
    for refused in [
        control.clone_world(clone).await.err(),
        control.restore_world(restore).await.err(),
        control.reset_world(reset).await.err(),
        control
            .create_world(create("more", &crowd(&["r0", "r1", "r2", "r3"].map(str::to_owned))))
            .await
            .err(),
    ] {
        let refused = refused.expect("there is no room");
        assert_eq!(refused.code(), Code::ResourceExhausted);
        assert!(refused.message().contains("--max-memory"), "{refused}");
    }
    assert!(refusals(&server, "memory_bytes").await >= 6.0);
    let worlds = control.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    for world in worlds {
        delete(&mut control, &world.world).await;
    }
    until_ok(async || match held(&server).await {
        0 => Ok(()),
        bytes => Err(format!("{bytes} bytes are held by nobody")),
    })
    .await;
    control.create_world(create("w", WANDER)).await.unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn clones_share_their_scenario() {
    let server = serve(Limits::default()).await;
    let mut control = operator(&server).await;
    let walls: String = (0..2000)
        .map(|i| format!("[[arena.circles]]\nname = \"p{i}\"\nx_m = {i}.0\ny_m = 0.0\nradius_m = 0.1\n"))
        .collect();
    let before = held(&server).await;
    control.create_world(create("walls", &walls)).await.unwrap();
    let one = held(&server).await - before;
    assert!(one as usize > walls.len(), "{one}");
    for _ in 0..4 {
        let clone = v1::CloneWorldRequest { original: "walls".into(), ..Default::default() };
        control.clone_world(clone).await.unwrap();
    }
    let five = held(&server).await - before;
    assert!(five < one + one / 10, "{five} bytes for five, {one} for one");
    server.shutdown().await;
}

/// A text that takes a while to read.
fn long() -> String {
    let wall = |i: usize| {
        let (x, y) = (i % 200, i / 200);
        format!(
            "[[arena.polygons]]\nname = \"p{i}\"\npoints_m = [[{x}.0, {y}.0], [{x}.5, {y}.0], [{x}.5, {y}.5]]\n"
        )
    };
    (0..20_000).map(wall).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn scenarios_wait_until_they_are_read_and_those_of_clients_who_have_gone_are_dropped() {
    let server = serve(Limits::default().with(Limit::Parsing, 1).with(Limit::Waiting, 2)).await;
    let text = long();
    let mut control = operator(&server).await;
    let begin = |name: &str| {
        let (request, mut control) = (create(name, &text), control.clone());
        tokio::spawn(async move { control.create_world(request).await })
    };
    let first = begin("first");
    tokio::time::sleep(Duration::from_millis(50)).await;
    let (second, gone) = (begin("second"), begin("gone"));
    until_ok(async || match used(&server, "waiting").await {
        2.0 => Ok(()),
        n => Err(format!("{n} wait")),
    })
    .await;
    let words = "2 requests wait to be parsed, which is its limit; try again in 1000 ms, or start the server with a larger \
                 --max-waiting";
    assert_exhausted(begin("refused").await.unwrap(), words);
    // Calls that have nothing to read do not wait.
    control.list_worlds(v1::ListWorldsRequest {}).await.unwrap();
    gone.abort();
    assert!(gone.await.is_err());
    first.await.unwrap().unwrap();
    second.await.unwrap().unwrap();
    until_ok(async || match used(&server, "waiting").await {
        0.0 => Ok(()),
        n => Err(format!("{n} wait")),
    })
    .await;
    control.create_world(create("another", WANDER)).await.unwrap();
    let worlds = control.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    let names: Vec<_> = worlds.iter().map(|world| &*world.world).collect();
    assert_eq!(names, ["another", "first", "second", "w"]);
    assert_eq!(refusals(&server, "waiting").await, 1.0);
    server.shutdown().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn where_worlds_lag_no_more_are_started_but_in_lockstep() {
    // None of them has too much to do, but all together have: three million ticks a second.
    let busy = (0..600).fold(Server::builder(), |builder, i| {
        let world = WorldConfig::new(format!("w{i}"), scenario(WANDER, &[]));
        builder.world(world.pace(Pace::scaled(50.0)))
    });
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let limits = Limits::default().with(Limit::OverloadAfter, 2);
    let server = busy.limits(limits).viewer(free).serve().await.unwrap();
    let mut control = operator(&server).await;
    let new = |i: usize| v1::CreateWorldRequest { paused: false, ..create(&format!("new-{i}"), WANDER) };
    let mut n = 0;
    let refused = until_ok(async || {
        n += 1;
        tokio::time::sleep(Duration::from_millis(200)).await;
        match control.create_world(new(n)).await {
            Ok(_) => Err("the processors have time for that"),
            Err(status) => Ok(status),
        }
    })
    .await;
    assert_eq!(refused.code(), Code::ResourceExhausted);
    assert!(refused.message().starts_with("worlds in real time have lagged for "), "{refused}");
    assert!(
        refused.message().ends_with(
            " s, 2 s or more, which is its limit; pause a world, or try again later, or start the server with a larger --overload-after"
        ),
        "{refused}"
    );
    control.create_world(create("paused", WANDER)).await.unwrap();
    let start = || v1::StartWorldRequest { world: "paused".into() };
    assert!(control.start_world(start()).await.unwrap_err().message().contains("--overload-after"));
    let pace = Some(v1::Pace { kind: Some(v1::pace::Kind::Lockstep(v1::Lockstep::default())) });
    control.create_world(v1::CreateWorldRequest { pace, ..new(0) }).await.unwrap();
    let worlds = control.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    for world in worlds.into_iter().filter(|world| world.world.starts_with('w')) {
        control.pause_world(v1::PauseWorldRequest { world: world.world }).await.unwrap();
    }
    until_ok(async || control.start_world(start()).await).await;
    assert!(refusals(&server, "overload_after_s").await >= 2.0);
    server.shutdown().await;
}

#[tokio::test]
async fn all_limits_are_told_with_their_values() {
    let server = serve(Limits::default().with(Limit::Worlds, 7)).await;
    assert_eq!(metric(&server, "baudbot_limit", "worlds").await, 7.0);
    assert_eq!(metric(&server, "baudbot_limit", "robots_per_world").await, 10_000.0);
    assert_eq!((used(&server, "worlds").await, used(&server, "robots").await), (1.0, 16.0));
    let page = include_str!("../../docs/reference/limits.md");
    let metrics = answers(&server, "/metrics").await;
    let labels =
        metrics.lines().filter_map(|line| line.strip_prefix("baudbot_limit{limit=\"")?.split('"').next());
    let labels: Vec<_> = labels.collect();
    assert_eq!(labels.len(), LIMITS.len(), "{labels:?}");
    for label in labels {
        assert!(page.contains(&format!("| `{label}` |")), "docs/reference/limits.md lacks {label}");
    }
    server.shutdown().await;
}

/// The limits in the response to this operator.
async fn limits_of(operator: &mut Operator) -> Vec<v1::ServerLimit> {
    operator.get_limits(v1::GetLimitsRequest {}).await.unwrap().into_inner().limits
}

/// The value of a limit, what is used of it, and the number of refusals.
fn standing(limits: &[v1::ServerLimit], limit: Limit) -> (Option<u64>, Option<u64>, u64) {
    let limit = limits.iter().find(|found| found.name == limit.info().name).unwrap();
    (limit.value, limit.used, limit.refused)
}

#[tokio::test]
async fn each_caller_is_told_the_limits_that_hold_for_it() {
    let limits = Limits::default().with(Limit::Worlds, 5).with(Limit::WorldsPerCaller, 2);
    let (server, [alice, bob], _folder) = serve_class(limits.clone()).await;
    let mut alice = operator_of(&server, Some(&alice)).await;
    for name in ["a", "b"] {
        alice.create_world(create(name, WANDER)).await.unwrap();
    }
    let refused = alice.create_world(create("c", WANDER)).await.unwrap_err();
    assert_eq!(refused.code(), Code::ResourceExhausted);
    let (to_alice, to_bob) =
        (limits_of(&mut alice).await, limits_of(&mut operator_of(&server, Some(&bob)).await).await);
    let to_this_process = limits_of(&mut operator(&server).await).await;
    assert_eq!(standing(&to_alice, Limit::WorldsPerCaller), (Some(2), Some(2), 1));
    assert_eq!(standing(&to_bob, Limit::WorldsPerCaller), (Some(2), Some(0), 1));
    assert_eq!(standing(&to_this_process, Limit::WorldsPerCaller).0, None);
    for told in [&to_alice, &to_bob, &to_this_process] {
        assert_eq!(standing(told, Limit::Worlds), (Some(5), Some(3), 0));
        assert_eq!(standing(told, Limit::RobotsPerWorld), (Some(10_000), None, 0));
        assert!(
            told.iter().all(|limit| !limit.meaning.is_empty() && limit.unit() != v1::LimitUnit::Unspecified)
        );
    }
    assert_eq!(to_bob.len(), LIMITS.len());
    for (limit, info) in to_bob.iter().zip(&LIMITS) {
        assert_eq!((&*limit.name, &*limit.option), (info.name, info.option));
        assert_eq!(limit.value, Some(limits.value(info.limit)), "{}", info.name);
    }
    server.shutdown().await;
}

/// The experience of operators and a world in real time beside so many worlds in free pace: the median and the
/// longest time of GetWorld, and the fraction of the real-time world's ticks that ended late by a tick or more.
async fn beside_free_worlds(count: usize) -> (Duration, Duration, f64) {
    let free = (0..count).fold(Server::builder(), |builder, i| {
        builder.world(WorldConfig::new(format!("free-{i}"), scenario(WANDER, &[])).pace(Pace::Free))
    });
    let neighbour = WorldConfig::new("w", scenario(WANDER, &[])).pace(Pace::REAL_TIME);
    let builder = free.world(neighbour).listen("127.0.0.1:0".parse().unwrap());
    let server = builder.limits(Limits::default()).serve().await.unwrap();
    let mut control = operator_of(&server, None).await;
    let mut took = Vec::new();
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(10) {
        let world = if took.len() % 2 == 0 { "w".to_owned() } else { format!("free-{}", took.len() % count) };
        let asked = Instant::now();
        control.get_world(v1::GetWorldRequest { world }).await.unwrap();
        took.push(asked.elapsed());
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    took.sort();
    let request = v1::GetWorldRequest { world: "w".into() };
    let status = control.get_world(request).await.unwrap().into_inner().status.unwrap();
    let late = status.pacing.unwrap_or_default().late_ticks as f64 / status.tick as f64;
    server.shutdown().await;
    (took[took.len() / 2], took[took.len() - 1], late)
}

#[tokio::test]
#[ignore = "measures time"]
async fn many_worlds_in_free_pace_starve_nobody() {
    for count in [1, 32, 200] {
        let (median, longest, late) = beside_free_worlds(count).await;
        println!(
            "{count} worlds in free pace: GetWorld {median:?}, at most {longest:?}; {late:.4} of the ticks late"
        );
        assert!(median < Duration::from_millis(50), "{count} worlds: {median:?}");
    }
}

/// An observer who asks for frames and does not read them, forty times.
#[tokio::test]
async fn the_slowest_streams_of_a_caller_who_does_not_read_end_by_name_and_no_more_waits_than_it_may() {
    const MOST: u64 = 1 << 20;
    let server = serve(Limits::default().with(Limit::UnreadPerCaller, MOST)).await;
    let mut operator = operator(&server).await;
    let pace = v1::Pace { kind: Some(v1::pace::Kind::Stepped(v1::Stepped::default())) };
    operator.set_pace(v1::SetPaceRequest { world: "w".into(), pace: Some(pace) }).await.unwrap();
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let details: Vec<_> = (0..16).map(|i| format!("r{i}")).collect();
    let request = v1::WatchRequest { world: "w".into(), every_ticks: 1, details, ..Default::default() };
    let mut observer = ObserveServiceClient::new(connect(&server, None).await.channel());
    let mut streams = Vec::new();
    for _ in 0..40 {
        streams.push(observer.watch(request.clone()).await.unwrap().into_inner());
    }
    // On a connection of its own: that of the others is full.
    let mut quick = ObserveServiceClient::new(connect(&server, None).await.channel());
    let mut quick = quick.watch(request).await.unwrap().into_inner();
    for _ in 0..40 {
        operator.step_world(v1::StepWorldRequest { world: "w".into(), ticks: 1 }).await.unwrap();
        let waits = used(&server, "unread_bytes_per_caller").await;
        assert!(waits <= MOST as f64, "{waits}");
        while let Ok(frame) = timeout(Duration::from_millis(5), quick.message()).await {
            frame.expect("a stream that is read goes on").expect("a frame");
        }
    }
    let ended = refusals(&server, "unread_bytes_per_caller").await;
    // The world's and the network's parts of a stream are ended one by one.
    assert!((1.0..=80.0).contains(&ended), "{ended}");
    let mut by_name = 0.0;
    for mut stream in streams {
        while let Ok(frame) = timeout(Duration::from_millis(20), stream.message()).await {
            let Err(status) = frame else { continue };
            let words = status.message().replace(" of `w`", "");
            let expected = "the stream Watch ends, as it is the slowest of the address 127.0.0.1 and it leaves 1 MB unread, which is its \
                            limit; read what you ask for, or start the server with a larger --max-unread-per-caller";
            assert_eq!((status.code(), &*words), (Code::ResourceExhausted, expected));
            by_name += 1.0;
            break;
        }
    }
    assert!(by_name > 0.0 && by_name <= ended, "{by_name} of {ended}");
    server.shutdown().await;
}
