//! Connections: silent ones do not keep others out, and those with a call stay.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use baudbot_client::{Client, Error, connect};
use baudbot_proto::v1;
use baudbot_server::{Address, Builder, Pace, Server, WorldConfig};
use baudbot_tests::system::{lockstep, operator};
use baudbot_tests::{WANDER, crowd, scenario};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpStream, UnixStream};
use tonic::Code;

/// A server on a TCP port, a Unix socket and a port for pages.
async fn serve(name: &str, configure: impl FnOnce(Builder) -> Builder) -> Server {
    let socket = std::env::temp_dir().join(format!("baudbot-{name}-{}.sock", std::process::id()));
    let world =
        WorldConfig::new("w", scenario(&crowd(&(0..16).map(|i| format!("r{i}")).collect::<Vec<_>>()), &[]));
    let builder = Server::builder()
        .world(world.pace(Pace::REAL_TIME).paused(true))
        .listen("127.0.0.1:0".parse().unwrap())
        .listen(Address::Unix(socket))
        .viewer(SocketAddr::from(([127, 0, 0, 1], 0)));
    configure(builder).serve().await.unwrap()
}

fn tcp(server: &Server) -> SocketAddr {
    let Address::Tcp(address) = server.addresses()[0] else { panic!("the first address is a port") };
    address
}

fn unix(server: &Server) -> PathBuf {
    let Address::Unix(path) = &server.addresses()[1] else { panic!("the second address is a socket") };
    path.clone()
}

async fn brain(server: &Server) -> Client {
    connect(&tcp(server).to_string()).await.unwrap()
}

/// Waits until the other side has closed the connection, and returns how long that took.
async fn closed(mut io: impl AsyncRead + Unpin, started: Instant) -> Duration {
    let mut rest = Vec::new();
    // Closed with something unread is a reset.
    let _ =
        tokio::time::timeout(Duration::from_secs(20), io.read_to_end(&mut rest)).await.expect("it is closed");
    started.elapsed()
}

/// The first bytes of a client of HTTP/2, and its empty settings.
const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
const SETTINGS: &[u8] = &[0, 0, 0, 4, 0, 0, 0, 0, 0];
/// HEADERS of 100 bytes on stream 1, of which none comes.
const HALF_HEADERS: &[u8] = &[0, 0, 100, 1, 0, 0, 0, 0, 1];

#[tokio::test]
async fn silent_connections_keep_no_brain_no_operator_and_no_page_out() {
    let server = serve("silent", |builder| builder.connections(8)).await;
    let mut silent: Vec<Box<dyn AsyncRead + Unpin>> = Vec::new();
    for _ in 0..20 {
        silent.push(Box::new(TcpStream::connect(tcp(&server)).await.unwrap()));
        silent.push(Box::new(UnixStream::connect(unix(&server)).await.unwrap()));
        silent.push(Box::new(TcpStream::connect(server.viewers()[0]).await.unwrap()));
    }
    // Long before any of them would have been closed.
    brain(&server).await.attach("w", "r0").await.unwrap();
    let answer = get(&server, "/").await;
    assert!(answer.starts_with("HTTP/1.1 200 OK"), "{answer}");
    server.shutdown().await;
}

async fn get(server: &Server, path: &str) -> String {
    let mut page = TcpStream::connect(server.viewers()[0]).await.unwrap();
    page.write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).await.unwrap();
    let mut answer = String::new();
    let read = tokio::time::timeout(Duration::from_secs(20), page.read_to_string(&mut answer));
    read.await.expect("the server closes the connection").unwrap();
    answer
}

#[tokio::test]
async fn when_all_who_are_there_have_asked_the_next_is_refused_until_one_goes() {
    let server = serve("full", |builder| builder.connections(3)).await;
    let mut robots = Vec::new();
    for i in 0..3 {
        robots.push(brain(&server).await.attach("w", &format!("r{i}")).await.unwrap());
    }
    for _ in 0..3 {
        let refused = brain(&server).await.attach("w", "r3").await.unwrap_err();
        let Error::Status { code, message } = refused else { panic!("{refused}") };
        assert_eq!(code, Code::Unavailable);
        assert!(message.starts_with("the server has 3 connections, which is its limit"), "{message}");
    }
    let answer = get(&server, "/").await;
    assert!(answer.starts_with("HTTP/1.1 503"), "{answer}");
    assert!(answer.contains("the server has 3 connections"), "{answer}");
    // Pipes in memory take no place.
    let request = v1::ListWorldsRequest {};
    assert_eq!(operator(&server).await.list_worlds(request).await.unwrap().into_inner().worlds.len(), 1);
    drop(robots.pop());
    let started = Instant::now();
    while let Err(error) = brain(&server).await.attach("w", "r3").await {
        assert!(started.elapsed() < Duration::from_secs(20), "{error}");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    server.shutdown().await;
}

#[tokio::test]
async fn who_has_asked_for_nothing_is_closed_in_time_however_far_it_came() {
    let patience = Duration::from_millis(400);
    let server = serve("patience", |builder| builder.first_call_within(patience)).await;
    let mut took = tokio::task::JoinSet::new();
    for words in [
        vec![],
        PREFACE[..10].to_vec(),
        PREFACE.to_vec(),
        [PREFACE, SETTINGS].concat(),
        [PREFACE, SETTINGS, HALF_HEADERS].concat(),
    ] {
        let started = Instant::now();
        let (port, socket) =
            (TcpStream::connect(tcp(&server)).await, UnixStream::connect(unix(&server)).await);
        let (port, socket) = (port.unwrap(), socket.unwrap());
        for mut io in [Box::new(port) as Box<dyn Duplex>, Box::new(socket)] {
            let _ = io.write_all(&words).await;
            took.spawn(closed(io, started));
        }
    }
    for words in ["", "GET / HT", "GET / HTTP/1.1\r\nHost: localhost\r\nX: "] {
        let started = Instant::now();
        let mut page = TcpStream::connect(server.viewers()[0]).await.unwrap();
        // On a busy machine it may be closed already.
        let _ = page.write_all(words.as_bytes()).await;
        took.spawn(closed(page, started));
    }
    // One byte after the other is no better.
    let mut slow = TcpStream::connect(server.viewers()[0]).await.unwrap();
    let started = Instant::now();
    while slow.write_all(b"G").await.is_ok() {
        assert!(started.elapsed() < Duration::from_secs(20), "it is not closed");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    while let Some(took) = took.join_next().await {
        assert!(took.unwrap() > patience / 2, "closed too early");
    }
    server.shutdown().await;
}

/// A connection for bytes both ways.
trait Duplex: AsyncRead + AsyncWrite + Unpin + Send {}

impl<IO: AsyncRead + AsyncWrite + Unpin + Send> Duplex for IO {}

#[tokio::test]
async fn a_brain_that_is_attached_may_be_silent_for_as_long_as_it_likes() {
    let server = serve("patient", |builder| builder.first_call_within(Duration::from_secs(2))).await;
    let client = brain(&server).await;
    let mut robot = client.attach("w", "r0").await.unwrap();
    // The world stands, so neither side sends anything.
    tokio::time::sleep(Duration::from_secs(3)).await;
    let mut operator = operator(&server).await;
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    for _ in 0..3 {
        robot.turn().await.unwrap().unwrap();
    }
    server.shutdown().await;
}

#[tokio::test]
async fn places_are_free_again_after_many_brains_have_come_and_gone() {
    let server = serve("many", |builder| builder.connections(4)).await;
    for i in 0..300 {
        let started = Instant::now();
        // The place, and the robot, of the one before may take a moment.
        while let Err(error) = brain(&server).await.attach("w", &format!("r{}", i % 16)).await {
            assert!(started.elapsed() < Duration::from_secs(20), "{i}: {error}");
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_without_ports_takes_no_place() {
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep());
    let server = Server::builder().world(world).connections(1).in_process().await.unwrap();
    for _ in 0..3 {
        operator(&server).await.list_worlds(v1::ListWorldsRequest {}).await.unwrap();
    }
    server.shutdown().await;
}
