//! The attacks on HTTP/2 of the last years, by name, byte for byte. A world in lockstep beside goes on and ends as it
//! must, others are answered meanwhile, what the server holds does not grow, and where an attacker can be distinguished
//! from a client it is disconnected.
//!
//! A program of its own, as it measures what this process holds.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use baudbot_brains::catalogue;
use baudbot_client::{Brain, connect};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Address, Limit, Limits, Lockstep, Pace, Server, Tls, WorldConfig};
use baudbot_tests::system::{lockstep, status};
use baudbot_tests::{InProcess, WANDER, crowd, scenario};
use prost::Message as _;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::sync::{Mutex, MutexGuard};
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

/// Frames of HTTP/2 (RFC 9113).
mod frame {
    pub(super) const DATA: u8 = 0;
    pub(super) const HEADERS: u8 = 1;
    pub(super) const PRIORITY: u8 = 2;
    pub(super) const RST_STREAM: u8 = 3;
    pub(super) const SETTINGS: u8 = 4;
    pub(super) const PING: u8 = 6;
    pub(super) const GOAWAY: u8 = 7;
    pub(super) const WINDOW_UPDATE: u8 = 8;
    pub(super) const CONTINUATION: u8 = 9;

    pub(super) const END_STREAM: u8 = 1;
    pub(super) const ACK: u8 = 1;
    pub(super) const END_HEADERS: u8 = 4;

    /// The first bytes of a client.
    pub(super) const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

    pub(super) fn of(kind: u8, flags: u8, stream: u32, payload: &[u8]) -> Vec<u8> {
        let mut frame = (payload.len() as u32).to_be_bytes()[1..].to_vec();
        frame.extend([kind, flags]);
        frame.extend(stream.to_be_bytes());
        frame.extend(payload);
        frame
    }

    /// The headers of a call (HPACK, RFC 7541): nothing is put into the table.
    pub(super) fn call(path: &str) -> Vec<u8> {
        // POST and http are in the table that all have, as are the names of path and authority.
        let mut block = vec![0x83, 0x86, 0x04, path.len() as u8];
        block.extend(path.as_bytes());
        block.extend([0x01, 1, b'x']);
        for (name, value) in [("content-type", "application/grpc"), ("te", "trailers")] {
            block.extend([0, name.len() as u8]);
            block.extend(name.as_bytes());
            block.push(value.len() as u8);
            block.extend(value.as_bytes());
        }
        block
    }
}

const LIST: &str = "/baudbot.v1.ControlService/ListWorlds";
const WATCH: &str = "/baudbot.v1.ObserveService/Watch";
const REFLECT: &str = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";

/// An empty message of gRPC.
const EMPTY: &[u8] = &[0; 5];

/// The time within which the servers here must answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// The end of the run of the world beside.
const CHANGES: &[&str] = &["end.after_s=5.0"];

/// One at a time: they measure what the process holds.
static ALONE: Mutex<()> = Mutex::const_new(());

/// A server, with a brain and an operator that have nothing to do with the attack.
struct Beside {
    server: Server,
    address: SocketAddr,
    before: Held,
    is_over: Arc<AtomicBool>,
    answered: Arc<AtomicU64>,
    others: Vec<JoinHandle<()>>,
    _alone: MutexGuard<'static, ()>,
}

/// The resources of this process.
#[derive(Clone, Copy, Debug)]
struct Held {
    descriptors: usize,
    threads: usize,
    bytes: usize,
}

impl Held {
    fn now() -> Self {
        let entries = |folder| std::fs::read_dir(folder).unwrap().count();
        let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
        let resident: usize = pages.split(' ').nth(1).unwrap().parse().unwrap();
        Self {
            descriptors: entries("/proc/self/fd"),
            threads: entries("/proc/self/task"),
            bytes: resident * 4096,
        }
    }
}

impl Beside {
    async fn begin() -> Self {
        let alone = ALONE.lock().await;
        let world = WorldConfig::new("w", scenario(WANDER, CHANGES)).pace(lockstep());
        let builder = Server::builder().world(world).first_call_within(PATIENCE);
        let server = builder.listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
        let Address::Tcp(address) = server.addresses()[0] else { panic!("it is a port") };
        let (is_over, answered) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let others = vec![
            tokio::spawn(drive(address, Arc::clone(&is_over))),
            tokio::spawn(ask(address, Arc::clone(&is_over), Arc::clone(&answered))),
        ];
        while answered.load(Ordering::Relaxed) < 3 {
            sleep(Duration::from_millis(10)).await;
        }
        Self { server, address, before: Held::now(), is_over, answered, others, _alone: alone }
    }

    async fn attacker(&self) -> Attacker {
        Attacker::connect(self.address).await
    }

    /// The attack is over. Nothing of it is left, and the world beside ends as it must.
    async fn end(self) {
        self.end_held(48).await;
    }

    /// The same, if the server may hold so many megabytes more than before.
    async fn end_held(self, megabytes: usize) {
        self.check_held(megabytes);
        self.is_over.store(true, Ordering::Relaxed);
        for other in self.others {
            timeout(Duration::from_secs(60), other).await.expect("others are not kept waiting").unwrap();
        }
        let status = status(&self.server).await;
        assert!(!status.ending.is_empty(), "{status:?}");
        let mut local = InProcess::new(scenario(WANDER, CHANGES), "avoid").unwrap();
        local.run(u64::MAX);
        local.world.begin();
        assert_eq!(status.state_hash, local.world.hash(), "the world beside is another one");
        self.server.shutdown().await;
    }

    /// The server's resources have not grown by more than some megabytes.
    fn check_held(&self, megabytes: usize) {
        let (before, now) = (self.before, Held::now());
        assert!(now.bytes < before.bytes + (megabytes << 20), "{before:?}, {now:?}");
        // The threads that block are few.
        assert!(now.threads < before.threads + 24, "{before:?}, {now:?}");
    }
}

/// A brain that drives slowly while the attack lasts.
async fn drive(address: SocketAddr, is_over: Arc<AtomicBool>) {
    let mut robot = connect(&address.to_string()).await.unwrap().attach("w", "robot").await.unwrap();
    let mut brain = catalogue::brain("avoid", 1, robot.body()).unwrap();
    while let Some(turn) = robot.turn().await.unwrap() {
        robot.act(brain.step(&turn)).await.unwrap();
        if !is_over.load(Ordering::Relaxed) {
            // Some ticks are left for after the attack.
            let pause = if turn.tick < 300 { Duration::from_millis(2) } else { Duration::from_millis(100) };
            sleep(pause).await;
        }
    }
}

/// An operator who asks again and again, and wants an answer in time.
async fn ask(address: SocketAddr, is_over: Arc<AtomicBool>, answered: Arc<AtomicU64>) {
    let endpoint = tonic::transport::Endpoint::from_shared(format!("http://{address}")).unwrap();
    let mut operator = ControlServiceClient::new(endpoint.connect().await.unwrap());
    while !is_over.load(Ordering::Relaxed) {
        let answer = timeout(Duration::from_secs(10), operator.list_worlds(v1::ListWorldsRequest {})).await;
        assert_eq!(answer.expect("an answer in time").unwrap().into_inner().worlds.len(), 1);
        answered.fetch_add(1, Ordering::Relaxed);
        sleep(Duration::from_millis(10)).await;
    }
}

/// A connection that breaks the rules.
struct Attacker {
    write: OwnedWriteHalf,
    /// The task that reads what comes, and returns at the end whether there was a GOAWAY.
    reader: Option<JoinHandle<Option<u32>>>,
    sent: u64,
}

impl Attacker {
    async fn connect(address: SocketAddr) -> Self {
        Self::with_settings(address, &[]).await
    }

    /// An attacker that sends these settings, each with its value.
    async fn with_settings(address: SocketAddr, settings: &[(u16, u32)]) -> Self {
        let (read, write) = TcpStream::connect(address).await.unwrap().into_split();
        let mut attacker = Self { write, reader: Some(tokio::spawn(read_to_the_end(read))), sent: 0 };
        let payload: Vec<_> = settings
            .iter()
            .flat_map(|(name, value)| [&name.to_be_bytes()[..], &value.to_be_bytes()].concat())
            .collect();
        let hello = [
            frame::PREFACE,
            &frame::of(frame::SETTINGS, 0, 0, &payload),
            &frame::of(frame::SETTINGS, frame::ACK, 0, &[]),
        ];
        assert!(attacker.say(&hello.concat()).await);
        attacker
    }

    /// Sends this; whether it could be sent.
    async fn say(&mut self, bytes: &[u8]) -> bool {
        self.sent += 1;
        matches!(timeout(Duration::from_secs(20), self.write.write_all(bytes)).await, Ok(Ok(())))
    }

    /// Sends pieces, one after the other, until it is closed or the time is over; whether it was closed.
    async fn flood(&mut self, time: Duration, mut piece: impl FnMut(u32) -> Vec<u8>) -> bool {
        let began = Instant::now();
        for number in 0.. {
            if self.reader.as_ref().is_some_and(JoinHandle::is_finished) || !self.say(&piece(number)).await {
                return true;
            }
            if began.elapsed() > time {
                return false;
            }
        }
        false
    }

    /// Waits until the server closes the connection. Gives the error of its GOAWAY, if one has come.
    async fn closed(&mut self, within: Duration) -> Option<u32> {
        let reader = self.reader.take().expect("it is asked once");
        timeout(within, reader).await.expect("the attacker is not closed").unwrap()
    }
}

/// Reads frames until the connection ends; the error of a GOAWAY.
async fn read_to_the_end(mut read: OwnedReadHalf) -> Option<u32> {
    let mut told = None;
    loop {
        let mut head = [0; 9];
        if read.read_exact(&mut head).await.is_err() {
            return told;
        }
        let mut payload = vec![0; u32::from_be_bytes([0, head[0], head[1], head[2]]) as usize];
        if read.read_exact(&mut payload).await.is_err() {
            return told;
        }
        if head[3] == frame::GOAWAY {
            told = Some(u32::from_be_bytes(payload[4..8].try_into().unwrap()));
        }
    }
}

/// The number of a client's stream.
fn stream(number: u32) -> u32 {
    2 * number + 1
}

const ENHANCE_YOUR_CALM: u32 = 11;

/// CVE-2023-44487: calls that are reset as soon as they are made.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn rapid_reset() {
    let beside = Beside::begin().await;
    let headers = frame::call(LIST);
    let whole = |number| {
        let head = frame::of(frame::HEADERS, frame::END_HEADERS, stream(number), &headers);
        [head, frame::of(frame::RST_STREAM, 0, stream(number), &8_u32.to_be_bytes())].concat()
    };
    let mut attacker = beside.attacker().await;
    // A hundred in one segment each: they are reset before they are begun.
    let closed =
        attacker.flood(Duration::from_secs(5), |n| (0..100).flat_map(|i| whole(n * 100 + i)).collect()).await;
    assert!(closed, "an attacker who resets {} calls is not closed", attacker.sent * 100);
    assert_eq!(attacker.closed(Duration::from_secs(10)).await, Some(ENHANCE_YOUR_CALM));
    beside.end().await;
}

/// The same with whole requests, which are worked on before they are reset.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn rapid_reset_of_calls_that_have_begun() {
    let beside = Beside::begin().await;
    let headers = frame::call(LIST);
    let mut attacker = beside.attacker().await;
    for number in 0..20_000 {
        let head = frame::of(frame::HEADERS, frame::END_HEADERS, stream(number), &headers);
        let call = [head, frame::of(frame::DATA, frame::END_STREAM, stream(number), EMPTY)].concat();
        let reset = frame::of(frame::RST_STREAM, 0, stream(number), &8_u32.to_be_bytes());
        if !attacker.say(&call).await || !attacker.say(&reset).await {
            break;
        }
    }
    assert!(attacker.sent < 40_000, "an attacker who resets {} calls is not closed", attacker.sent / 2);
    beside.end().await;
}

/// CVE-2024-27316 and its family: headers that never end.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn continuation_flood() {
    for size in [0, 1, 16_000] {
        let beside = Beside::begin().await;
        let mut attacker = beside.attacker().await;
        assert!(attacker.say(&frame::of(frame::HEADERS, 0, 1, &frame::call(LIST))).await);
        // One more field each, of so many bytes.
        let mut field = vec![0, 1, b'a'];
        let length = size as u32;
        if size < 127 {
            field.push(length as u8);
        } else {
            let rest = length - 127;
            field.extend([0x7f, (rest & 0x7f) as u8 | 0x80, (rest >> 7) as u8]);
        }
        field.extend(vec![b'v'; size]);
        let piece = if size == 0 { Vec::new() } else { field };
        let closed = attacker
            .flood(Duration::from_secs(10), |_| frame::of(frame::CONTINUATION, 0, 1, &piece).repeat(20))
            .await;
        assert!(closed, "an attacker with headers of {} frames is not closed", attacker.sent * 20);
        attacker.closed(Duration::from_secs(10)).await;
        beside.end().await;
    }
}

/// CVE-2025-8671: frames that make the server reset its own streams, in place of the client.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn made_you_reset() {
    let of_stream =
        |number| frame::of(frame::HEADERS, frame::END_HEADERS, stream(number), &frame::call(LIST));
    let update = |number, by: u32| frame::of(frame::WINDOW_UPDATE, 0, stream(number), &by.to_be_bytes());
    type Provoke<'a> = &'a dyn Fn(u32) -> Vec<u8>;
    let provocations: [(&str, Provoke<'_>); 4] = [
        ("a window that grows by nothing", &|n| update(n, 0)),
        ("a window that grows too large", &|n| [update(n, 0x7fff_ffff), update(n, 0x7fff_ffff)].concat()),
        ("a stream that depends on itself", &|n| {
            frame::of(frame::PRIORITY, 0, stream(n), &[&stream(n).to_be_bytes()[..], &[0]].concat())
        }),
        ("data after the end", &|n| {
            let last = frame::of(frame::DATA, frame::END_STREAM, stream(n), EMPTY);
            [last, frame::of(frame::DATA, frame::END_STREAM, stream(n), EMPTY)].concat()
        }),
    ];
    for (name, provoke) in provocations {
        let beside = Beside::begin().await;
        let mut attacker = beside.attacker().await;
        let closed = attacker.flood(Duration::from_secs(10), |n| [of_stream(n), provoke(n)].concat()).await;
        assert!(closed, "{name}: an attacker who provokes {} resets is not closed", attacker.sent);
        attacker.closed(Duration::from_secs(10)).await;
        beside.end().await;
    }
}

/// CVE-2019-9512, CVE-2019-9515: frames that have to be answered, by a client that reads the answers and one that does
/// not.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ping_and_settings_flood() {
    for piece in
        [frame::of(frame::PING, 0, 0, &[7; 8]), frame::of(frame::SETTINGS, 0, 0, &[0, 3, 0, 0, 0, 100])]
    {
        for reads in [true, false] {
            let beside = Beside::begin().await;
            let mut attacker = beside.attacker().await;
            if !reads {
                attacker.reader.take().unwrap().abort();
            }
            let many = piece.repeat(500);
            let began = Instant::now();
            let closed = attacker.flood(4 * PATIENCE, |_| many.clone()).await;
            assert!(closed && began.elapsed() < 4 * PATIENCE, "it asks for nothing, and is not closed");
            beside.check_held(32);
            beside.end().await;
        }
    }
}

/// The same by a client that has asked for something, and so may be silent for as long as it likes, and whatever else
/// costs the server a look and gets nothing done.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn floods_of_frames_that_carry_nothing() {
    const UNKNOWN: u8 = 0x42;
    let floods = [
        ("PING", frame::of(frame::PING, 0, 0, &[7; 8])),
        ("answers to a PING", frame::of(frame::PING, frame::ACK, 0, &[7; 8])),
        ("SETTINGS", frame::of(frame::SETTINGS, 0, 0, &[])),
        ("PRIORITY", frame::of(frame::PRIORITY, 0, 3, &[0; 5])),
        ("WINDOW_UPDATE", frame::of(frame::WINDOW_UPDATE, 0, 0, &1_u32.to_be_bytes())),
        ("a kind that there is not", frame::of(UNKNOWN, 0, 0, &[7; 8])),
    ];
    let beside = Beside::begin().await;
    for (name, piece) in floods {
        let mut attacker = beside.attacker().await;
        attacker.call(0, LIST, &[]).await;
        let many = piece.repeat(500);
        let closed = attacker.flood(Duration::from_secs(20), |_| many.clone()).await;
        assert!(closed, "{name}: an attacker who sends {} frames is not closed", attacker.sent * 500);
    }
    beside.end().await;
}

/// CVE-2019-9517 and its family: answers are asked for, and no window is opened for them.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn zero_window() {
    const INITIAL_WINDOW: u16 = 4;
    // `w`, each tick.
    let watch = [&[0, 0, 0, 0, 5][..], b"\x0a\x01w\x10\x01"].concat();
    let file = b"\x1a\x1fbaudbot.v1.ControlService.Watch";
    let reflect = [&[0, 0, 0, 0, file.len() as u8][..], file].concat();
    let asked = [(WATCH, watch), (REFLECT, reflect), (LIST, EMPTY.to_vec())];
    let beside = Beside::begin().await;
    let mut held = Vec::new();
    for _ in 0..4 {
        let mut attackers = Vec::new();
        for _ in 0..20 {
            let mut attacker = Attacker::with_settings(beside.address, &[(INITIAL_WINDOW, 0)]).await;
            for number in 0..300 {
                let (path, said) = &asked[number as usize % 3];
                let head = frame::of(frame::HEADERS, frame::END_HEADERS, stream(number), &frame::call(path));
                let said = frame::of(frame::DATA, frame::END_STREAM, stream(number), said);
                attacker.say(&[head, said].concat()).await;
            }
            attackers.push(attacker);
        }
        let answered = beside.answered.load(Ordering::Relaxed);
        sleep(Duration::from_secs(2)).await;
        let others = async {
            while beside.answered.load(Ordering::Relaxed) <= answered {
                sleep(Duration::from_millis(10)).await;
            }
        };
        // On a machine that does much else an answer may take longer.
        timeout(Duration::from_secs(60), others).await.expect("others are answered meanwhile");
        held.push(Held::now().bytes.saturating_sub(beside.before.bytes));
        for mut attacker in attackers {
            drop(attacker.write);
            let reader = attacker.reader.take().expect("it reads");
            timeout(Duration::from_secs(20), reader).await.expect("it is closed").unwrap();
        }
    }
    // A connection has so many streams at a time, and no more. What one wave has held is there for the next, but for some gaps.
    assert!(held[0] < 20 * (6 << 20), "{held:?}");
    assert!(held[3] < 2 * held[0], "{held:?}");
    beside.end_held(240).await;
}

/// A metric of a server that wants no token.
async fn metric(server: &Server, name: &str) -> f64 {
    let mut page = TcpStream::connect(server.viewers()[0]).await.unwrap();
    page.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n").await.unwrap();
    let mut answer = Vec::new();
    let _ = page.read_to_end(&mut answer).await;
    let answer = String::from_utf8_lossy(&answer);
    let value = answer.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    value.unwrap_or_else(|| panic!("no {name} in {answer}")).parse().unwrap()
}

const UNREAD: &str = "baudbot_limit_used{limit=\"unread_bytes\"}";

/// A server for those who do not read: a world `w` of so many robots, and one `b` that counts coverage.
async fn serve_unread(robots: usize, limits: Limits) -> (Server, SocketAddr, tempfile::TempDir) {
    let names: Vec<_> = (0..robots).map(|i| format!("r{i}")).collect();
    let stepped = Pace::Stepped(Lockstep::default());
    let crowd = WorldConfig::new("w", scenario(&crowd(&names), &[])).pace(stepped);
    let covered = WorldConfig::new("b", scenario(WANDER, &["metrics.cell_m=0.1"])).pace(stepped).paused(true);
    let folder = tempfile::tempdir().unwrap();
    let builder =
        Server::builder().world(crowd).world(covered).limits(limits).recordings(folder.path().to_owned());
    let builder = builder.viewer("127.0.0.1:0".parse().unwrap()).listen("127.0.0.1:0".parse().unwrap());
    let server = builder.serve().await.unwrap();
    let Address::Tcp(address) = server.addresses()[0] else { panic!("it is a port") };
    (server, address, folder)
}

/// The request of each method here, in an order in which all have an answer.
fn asked() -> Vec<(&'static str, Vec<u8>)> {
    fn of(message: &impl prost::Message) -> Vec<u8> {
        message.encode_to_vec()
    }
    let (w, b, made, film) = ("w".to_owned(), "b".to_owned(), "made".to_owned(), "film".to_owned());
    let name = || w.clone();
    let stepped = v1::Pace { kind: Some(v1::pace::Kind::Stepped(v1::Stepped::default())) };
    let cable = v1::PullCable { robot: "r0".into(), pulled: true };
    let pull = v1::intervene_request::Intervention::PullCable(cable);
    let hello = v1::Hello { world: name(), robots: vec!["r0".into()], ..Default::default() };
    let hello = v1::attach_request::Request::Hello(hello);
    let scenario = v1::get_budget_request::Scenario::World(name());
    vec![
        (
            "CreateWorld",
            of(&v1::CreateWorldRequest {
                world: made.clone(),
                scenario_toml: WANDER.into(),
                paused: true,
                ..Default::default()
            }),
        ),
        ("ListWorlds", Vec::new()),
        ("GetWorld", of(&v1::GetWorldRequest { world: name() })),
        ("SetPace", of(&v1::SetPaceRequest { world: name(), pace: Some(stepped) })),
        ("StartWorld", of(&v1::StartWorldRequest { world: name() })),
        ("StepWorld", of(&v1::StepWorldRequest { world: name(), ticks: 3 })),
        ("PauseWorld", of(&v1::PauseWorldRequest { world: name() })),
        ("SnapshotWorld", of(&v1::SnapshotWorldRequest { world: name() })),
        ("RestoreWorld", of(&v1::RestoreWorldRequest { world: name(), snapshot: 1 })),
        ("Intervene", of(&v1::InterveneRequest { world: name(), intervention: Some(pull) })),
        ("SaveWorld", of(&v1::SaveWorldRequest { world: name(), snapshot: 0 })),
        ("CloneWorld", of(&v1::CloneWorldRequest { original: name(), world: "copy".into(), pace: None })),
        ("DeleteWorld", of(&v1::DeleteWorldRequest { world: made })),
        (
            "GetBudget",
            of(&v1::GetBudgetRequest {
                scenario: Some(scenario),
                robots: vec!["r0".into()],
                ..Default::default()
            }),
        ),
        (
            "StartRecording",
            of(&v1::StartRecordingRequest { world: name(), recording: film.clone(), look_hz: 0.0 }),
        ),
        ("StopRecording", of(&v1::StopRecordingRequest { world: name() })),
        ("ListRecordings", Vec::new()),
        ("GetLimits", Vec::new()),
        ("OpenRecording", of(&v1::OpenRecordingRequest { recording: film.clone(), world: film.clone() })),
        ("DescribeReplay", of(&v1::DescribeReplayRequest { world: film.clone() })),
        ("SeekReplay", of(&v1::SeekReplayRequest { world: film.clone(), tick: 0 })),
        ("ForkReplay", of(&v1::ForkReplayRequest { world: film, pace: None })),
        ("ResetWorld", of(&v1::ResetWorldRequest { world: name(), ..Default::default() })),
        ("DescribeWorld", of(&v1::DescribeWorldRequest { world: name() })),
        ("GetCoverage", of(&v1::GetCoverageRequest { world: b })),
        ("Watch", of(&v1::WatchRequest { world: name(), every_ticks: 1, ..Default::default() })),
        (
            "WatchCable",
            of(&v1::WatchCableRequest { world: name(), robot: "r0".into(), sensor: String::new() }),
        ),
        ("Attach", of(&v1::AttachRequest { request: Some(hello) })),
    ]
}

/// The paths of all methods of the contract but those of the trainers' service, which is on a listener of its own behind the same gate.
fn methods() -> Vec<String> {
    let contract = prost_types::FileDescriptorSet::decode(baudbot_proto::DESCRIPTORS).unwrap();
    let mut paths = Vec::new();
    for file in &contract.file {
        for service in file.service.iter().filter(|service| service.name() != "TrainerService") {
            let path = |method: &prost_types::MethodDescriptorProto| {
                format!("/{}.{}/{}", file.package(), service.name(), method.name())
            };
            paths.extend(service.method.iter().map(path));
        }
    }
    paths
}

impl Attacker {
    /// Makes a call on this stream, and sends nothing more on it.
    async fn call(&mut self, number: u32, path: &str, message: &[u8]) {
        self.call_as(number, path, message, None).await;
    }

    /// The same with a token.
    async fn call_as(&mut self, number: u32, path: &str, message: &[u8], token: Option<&str>) {
        let mut block = frame::call(path);
        if let Some(token) = token {
            let value = format!("Bearer {token}");
            block.extend([0, 13]);
            block.extend(b"authorization");
            block.push(value.len() as u8);
            block.extend(value.as_bytes());
        }
        let head = frame::of(frame::HEADERS, frame::END_HEADERS, stream(number), &block);
        let said = [&[0][..], &(message.len() as u32).to_be_bytes(), message].concat();
        // The stream of a brain goes on.
        let flags = if path.ends_with("/Attach") { 0 } else { frame::END_STREAM };
        assert!(self.say(&[head, frame::of(frame::DATA, flags, stream(number), &said)].concat()).await);
    }
}

/// Whatever is asked of a server, what waits for the answer to be read is counted, and is gone with the connection. A method that is added
/// to the contract is asked here, too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_waits_for_the_reader_of_any_method_is_counted() {
    let _alone = ALONE.lock().await;
    let (server, address, _folder) = serve_unread(16, Limits::default()).await;
    let mut methods = methods();
    for (name, message) in asked() {
        let place = methods.iter().position(|path| path.ends_with(&format!("/{name}")));
        let path = methods.remove(place.unwrap_or_else(|| panic!("the contract has no {name}")));
        let mut attacker = Attacker::with_settings(address, &[(4, 0)]).await;
        attacker.call(0, &path, &message).await;
        let began = Instant::now();
        while metric(&server, UNREAD).await == 0.0 {
            assert!(began.elapsed() < Duration::from_secs(20), "{name}: nobody counts its answer");
        }
        drop(attacker);
        while metric(&server, UNREAD).await > 0.0 {
            assert!(began.elapsed() < Duration::from_secs(20), "{name}: its answer is never gone");
        }
    }
    assert!(methods.is_empty(), "say in `asked` what these are asked: {methods:?}");
    server.shutdown().await;
}

/// A thousand times the same question about a large world, by a client that does not read: one status is made, and no
/// more waits than may.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_thousand_questions_are_answered_by_one_status() {
    const MOST: u64 = 4 << 20;
    const CALLS: u32 = 1000;
    const PIECE: u64 = 16 << 10;
    let _alone = ALONE.lock().await;
    let (server, address, _folder) = serve_unread(
        1000,
        Limits::default().with(Limit::Unread, 2 * MOST).with(Limit::UnreadPerCaller, MOST),
    )
    .await;
    let before = Held::now();
    let get = v1::GetWorldRequest { world: "w".into() };
    let mut attackers = Vec::new();
    for path in ["/baudbot.v1.ControlService/GetWorld", LIST] {
        for _ in 0..4 {
            let mut attacker = Attacker::with_settings(address, &[(4, 0)]).await;
            for number in 0..CALLS / 8 {
                let message = if path == LIST { Vec::new() } else { prost::Message::encode_to_vec(&get) };
                attacker.call(number, path, &message).await;
            }
            attackers.push(attacker);
        }
    }
    let began = Instant::now();
    let ended = "baudbot_limit_refused_total{limit=\"unread_bytes_per_caller\"}";
    while metric(&server, ended).await < 900.0 {
        assert!(began.elapsed() < Duration::from_secs(300), "{}", metric(&server, ended).await);
        let waits = metric(&server, UNREAD).await;
        // The network has a piece of each call, which is counted until it goes.
        assert!(waits <= (MOST + u64::from(CALLS) * PIECE) as f64, "{waits}");
    }
    assert_eq!(metric(&server, "baudbot_world_statuses_made_total{world=\"w\"}").await, 1.0);
    let now = Held::now();
    assert!(
        now.threads < before.threads + 16 && now.bytes < before.bytes + (64 << 20),
        "{before:?}, {now:?}"
    );
    // A server that ends waits for connections that are open, until they count as stalled.
    drop(attackers);
    server.shutdown().await;
}

/// A table is filled once, and then referred to again and again: some bytes become megabytes.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hpack_bomb() {
    let beside = Beside::begin().await;
    let mut attacker = beside.attacker().await;
    // A field of 3,000 bytes that goes into the table, and is the first there from then on.
    let mut block = frame::call(LIST);
    block.extend([0x40, 1, b'a', 0x7f, (3000 - 127) as u8 & 0x7f | 0x80, ((3000 - 127) >> 7) as u8]);
    block.extend([b'v'; 3000]);
    assert!(attacker.say(&frame::of(frame::HEADERS, frame::END_HEADERS, 1, &block)).await);
    let mut bomb = frame::call(LIST);
    bomb.extend([0xbe; 16_000]);
    let piece = |n| frame::of(frame::HEADERS, frame::END_HEADERS, stream(n + 1), &bomb);
    let closed = attacker.flood(Duration::from_secs(3), piece).await;
    assert!(closed, "an attacker who tells of a large field {} times is not closed", attacker.sent * 16_000);
    beside.end().await;
}

/// CVE-2019-9518: frames with nothing in them.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn empty_frames() {
    let beside = Beside::begin().await;
    for path in [LIST, WATCH, REFLECT] {
        let mut attacker = beside.attacker().await;
        assert!(attacker.say(&frame::of(frame::HEADERS, frame::END_HEADERS, 1, &frame::call(path))).await);
        let many = frame::of(frame::DATA, 0, 1, &[]).repeat(1000);
        let closed = attacker.flood(Duration::from_secs(10), |_| many.clone()).await;
        assert!(closed, "{path}: an attacker who sends {} empty frames is not closed", attacker.sent * 1000);
        beside.check_held(32);
    }
    beside.end().await;
}

/// Bytes that come one by one, in the preface, in headers and in the handshake of TLS.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn slowloris() {
    let beside = Beside::begin().await;
    let folder = tempfile::tempdir().unwrap();
    let (certificate, key) = identity(folder.path());
    let tls = Server::builder().tls(Tls::read(&certificate, &key, None).unwrap()).first_call_within(PATIENCE);
    let tls = tls.listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
    let Address::Tcp(encrypted) = tls.addresses()[0] else { panic!("it is a port") };
    // The beginning of a ClientHello of 500 bytes.
    let handshake = [&[22, 3, 1, 1, 244, 1, 0, 1, 240, 3, 3][..], &[7; 480]].concat();
    let headers = frame::of(frame::HEADERS, 0, 1, &frame::call(LIST));
    let headers = [frame::PREFACE, &frame::of(frame::SETTINGS, 0, 0, &[]), &headers].concat();
    let mut slow = tokio::task::JoinSet::new();
    for (name, address, words) in [("TLS", encrypted, handshake), ("headers", beside.address, headers)] {
        for _ in 0..50 {
            let words = words.clone();
            slow.spawn(async move {
                let began = Instant::now();
                let (mut read, mut write) = TcpStream::connect(address).await.unwrap().into_split();
                let says = async {
                    for byte in words.chunks(4) {
                        if write.write_all(byte).await.is_err() {
                            return;
                        }
                        sleep(Duration::from_millis(100)).await;
                    }
                };
                let mut answer = Vec::new();
                let closed = async { drop(read.read_to_end(&mut answer).await) };
                let is_closed =
                    timeout(3 * PATIENCE + Duration::from_secs(10), async { tokio::join!(says, closed) })
                        .await;
                assert!(is_closed.is_ok(), "{name}: it is not closed");
                assert!(began.elapsed() > PATIENCE / 2);
            });
        }
    }
    while let Some(one) = slow.join_next().await {
        one.unwrap();
    }
    tls.shutdown().await;
    beside.end().await;
}

fn identity(folder: &std::path::Path) -> (std::path::PathBuf, std::path::PathBuf) {
    use baudbot_access::certificates::{Authority, Role};
    let now = std::time::SystemTime::now();
    let authority = Authority::new(&"lab".parse().unwrap(), "1w".parse().unwrap(), now).unwrap();
    let role = Role::Server(vec!["127.0.0.1".parse().unwrap()]);
    let paths = authority.issue(&role, "1d".parse().unwrap(), now).unwrap().write(folder, &role).unwrap();
    (paths.certificate, paths.key)
}

/// Connections that are made and left, in good order and by a reset, as a scan of ports does; and some that stay and
/// send nothing.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn half_open_connections() {
    let beside = Beside::begin().await;
    let mut silent = Vec::new();
    for number in 0..600 {
        let connection = TcpStream::connect(beside.address).await.unwrap();
        match number % 3 {
            0 => connection.set_zero_linger().unwrap(),
            1 => {}
            _ => {
                silent.push(connection);
                continue;
            }
        }
        drop(connection);
    }
    for mut connection in silent {
        let mut answer = Vec::new();
        let closed = timeout(3 * PATIENCE, connection.read_to_end(&mut answer)).await;
        assert!(closed.is_ok(), "a connection that says nothing is kept");
    }
    let (before, mut now) = (beside.before, Held::now());
    for _ in 0..100 {
        if now.descriptors <= before.descriptors + 4 {
            break;
        }
        sleep(Duration::from_millis(50)).await;
        now = Held::now();
    }
    assert!(now.descriptors <= before.descriptors + 4, "{before:?}, {now:?}");
    beside.end().await;
}

/// Robots that stand and sense nothing, so many.
fn standing(count: usize) -> String {
    let robot = |i| {
        format!(
            "[[robots]]\nname = \"r{i}\"\nstart = {{ x_m = {i}.0 }}\nbody = {{ radius_m = 0.2, mass_kg = 3.0, \
             inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n"
        )
    };
    let robots: String = (0..count).map(robot).collect();
    format!("name = \"big\"\nstep_ms = 10.0\n[end]\nafter_s = 100000.0\n{robots}")
}

/// A brain that answers each Turn, and counts them.
async fn count_turns(address: SocketAddr, token: String, turns: Arc<AtomicU64>) {
    let credentials = baudbot_client::Credentials::default().token(token.parse().unwrap());
    let client = baudbot_client::connect_with(&address.to_string(), &credentials).await.unwrap();
    let mut robot = client.attach("w", "robot").await.unwrap();
    while robot.turn().await.unwrap().is_some() {
        robot.drive(baudbot_client::Signals { left: 0.1, right: 0.12 }).await.unwrap();
        turns.fetch_add(1, Ordering::Relaxed);
    }
}

/// The experience of a brain and a newcomer beside an observer who asks a thousand times and reads nothing, and the
/// server's resources then:
///
/// ```sh
/// cargo test --release -p baudbot-tests --test http2_attacks -- --ignored --nocapture a_thousand_unread
/// ```
#[test]
#[ignore = "half a minute by the wall clock, on a machine that does nothing else"]
fn a_thousand_unread() {
    use baudbot_access::{NewGrant, TokenFile};

    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("tokens.toml"));
    let token = |name: &str, rights: &[&str]| {
        let rights = rights.iter().map(|right| right.parse().unwrap()).collect();
        let new = NewGrant { name: name.parse().unwrap(), rights, expires_at: None };
        file.add(new, std::time::SystemTime::now()).unwrap().reveal().to_string()
    };
    let (looker, operator) = (token("looker", &["observe"]), token("op", &["operate", "drive */*"]));
    let (started, address) = std::sync::mpsc::channel();
    // The runtime is like the program's: all of the network is on one thread.
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let endless = ["end.after_s=100000.0", "collision=\"stop-robot\""];
            let wander = WorldConfig::new("w", scenario(WANDER, &endless)).pace(Pace::REAL_TIME);
            let big = baudbot_scenario::parse(&standing(2000)).unwrap();
            let big = WorldConfig::new("big", big).pace(Pace::REAL_TIME);
            let builder = Server::builder().world(wander).world(big).tokens(file);
            let server = builder.listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
            let Address::Tcp(address) = server.addresses()[0] else { panic!("it is a port") };
            started.send(address).unwrap();
            std::future::pending::<()>().await;
        });
    });
    let address = address.recv().unwrap();
    let watch = v1::WatchRequest {
        world: "big".into(),
        every_ticks: 1,
        details: (0..64).map(|i| format!("r{i}")).collect(),
        ..Default::default()
    };
    let get = v1::GetWorldRequest { world: "big".into() };
    let asked = [
        ("GetWorld", "/baudbot.v1.ControlService/GetWorld", get.encode_to_vec()),
        ("Watch", WATCH, watch.encode_to_vec()),
    ];
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let turns = Arc::new(AtomicU64::new(0));
        tokio::spawn(count_turns(address, operator.clone(), Arc::clone(&turns)));
        let rate = async |time: Duration| {
            let before = (turns.load(Ordering::Relaxed), Instant::now());
            sleep(time).await;
            (turns.load(Ordering::Relaxed) - before.0) as f64 / before.1.elapsed().as_secs_f64()
        };
        sleep(Duration::from_secs(1)).await;
        for (name, path, message) in asked {
            let (usual, before) = (rate(Duration::from_secs(4)).await, Held::now());
            let mut attackers = Vec::new();
            for _ in 0..4 {
                // A window of a byte: the server tries each.
                let mut attacker = Attacker::with_settings(address, &[(4, 1)]).await;
                for number in 0..250 {
                    attacker.call_as(number, path, &message, Some(&looker)).await;
                }
                attackers.push(attacker);
            }
            let (mut slowest, mut most, mut rates) = (Duration::ZERO, before.bytes, Vec::new());
            for _ in 0..20 {
                rates.push(rate(Duration::from_millis(450)).await);
                let asked = Instant::now();
                let credentials = baudbot_client::Credentials::default().token(operator.parse().unwrap());
                let client = baudbot_client::connect_with(&address.to_string(), &credentials).await.unwrap();
                let mut control = ControlServiceClient::new(client.channel());
                control.get_world(v1::GetWorldRequest { world: "w".into() }).await.unwrap();
                slowest = slowest.max(asked.elapsed());
                most = most.max(Held::now().bytes);
            }
            let kept = rates.iter().sum::<f64>() / rates.len() as f64 / usual;
            println!(
                "1,000 unread {name}: the brain has {:.1} % of its {usual:.0} turns/s, the server holds {} MB more, the slowest of 20 new \
                 connections is answered in {:.1} ms",
                100.0 * kept,
                most.saturating_sub(before.bytes) >> 20,
                slowest.as_secs_f64() * 1e3
            );
            drop(attackers);
            sleep(Duration::from_secs(1)).await;
        }
    });
}
