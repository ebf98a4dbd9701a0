//! The rights: each call of each service with each kind of token, robots of others, and tokens that end.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::{Duration, SystemTime};

use baudbot_access::{NewGrant, Token, TokenFile};
use baudbot_client::{Channel, Client, Credentials, Error, connect_with};
use baudbot_server::{Builder, Server, WorldConfig};
use baudbot_tests::system::lockstep;
use baudbot_tests::{WANDER, crowd, scenario};
use prost::Message as _;
use prost_types::FileDescriptorSet;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tonic::client::Grpc;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{Code, Request, Status};
use tonic_prost::ProstCodec;

/// A server with the robots `alice` and `bob` in the world `w`, its tokens, and their file.
struct Class {
    server: Server,
    file: TokenFile,
    tokens: BTreeMap<&'static str, Token>,
    _folder: TempDir,
}

/// The rights of the tokens of a class.
const HOLDERS: [(&str, &[&str]); 6] = [
    ("observer", &["observe"]),
    ("operator", &["operate"]),
    ("trainer", &["train"]),
    ("alice", &["drive w/alice"]),
    ("tutor", &["drive w/*", "observe"]),
    ("stranger", &["drive elsewhere/*"]),
];

impl Class {
    async fn begin() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = TokenFile::at(folder.path().join("tokens.toml"));
        let add = |(name, rights): (&'static str, &[&str])| {
            let rights = rights.iter().map(|right| right.parse().unwrap()).collect();
            let new = NewGrant { name: name.parse().unwrap(), rights, expires_at: None };
            (name, file.add(new, SystemTime::now()).unwrap())
        };
        let tokens = HOLDERS.into_iter().map(add).collect();
        let robots = crowd(&["r0".to_owned(), "r1".to_owned()])
            .replace("\"r0\"", "\"alice\"")
            .replace("\"r1\"", "\"bob\"");
        let robots = scenario(&robots, &[]);
        let world = WorldConfig::new("w", robots).pace(lockstep()).paused(true);
        let free = SocketAddr::from(([127, 0, 0, 1], 0));
        let builder = Server::builder().world(world).tokens(file.clone()).viewer(free);
        let local = "127.0.0.1:0".parse().unwrap();
        let builder = builder.listen("127.0.0.1:0".parse().unwrap()).trainer(local);
        Self { server: builder.serve().await.unwrap(), file, tokens, _folder: folder }
    }

    async fn client(&self, holder: &str) -> Client {
        // Not `clone`: a token is given on as its text.
        let token = self.tokens[holder].reveal().parse().unwrap();
        let address = self.server.addresses()[0].to_string();
        connect_with(&address, &Credentials::default().token(token)).await.unwrap()
    }

    /// A connection to where trainers are.
    async fn trainers(&self, token: Option<Token>) -> Channel {
        let credentials =
            token.map_or_else(Credentials::default, |token| Credentials::default().token(token));
        connect_with(&self.server.trainers()[0].to_string(), &credentials).await.unwrap().channel()
    }

    fn token(&self, holder: &str) -> Token {
        self.tokens[holder].reveal().parse().unwrap()
    }
}

/// The tokens with which each call may be made, besides `-`, which needs no token, and `any`, which needs one.
const CALLS: &[(&str, &[(&str, &str)])] = &[
    (
        "baudbot.v1.ControlService",
        &[
            ("CreateWorld", "operator"),
            ("ListWorlds", "observer operator trainer tutor"),
            ("GetWorld", "observer operator trainer tutor"),
            ("StartWorld", "operator"),
            ("PauseWorld", "operator"),
            ("StepWorld", "operator"),
            ("SetPace", "operator"),
            ("ResetWorld", "operator"),
            ("SnapshotWorld", "operator"),
            ("RestoreWorld", "operator"),
            ("Intervene", "operator"),
            ("GetBudget", "observer operator trainer tutor"),
            ("SaveWorld", "operator"),
            ("CloneWorld", "operator"),
            ("StartRecording", "operator"),
            ("StopRecording", "operator"),
            ("ListRecordings", "observer operator trainer tutor"),
            ("OpenRecording", "operator"),
            ("DescribeReplay", "observer operator trainer tutor"),
            ("SeekReplay", "operator"),
            ("ForkReplay", "operator"),
            ("DeleteWorld", "operator"),
            ("GetLimits", "observer operator trainer tutor"),
        ],
    ),
    (
        "baudbot.v1.ObserveService",
        &[
            ("DescribeWorld", "observer operator trainer tutor"),
            ("Watch", "observer operator trainer tutor"),
            ("GetCoverage", "observer operator trainer tutor"),
            ("WatchCable", "observer operator trainer tutor"),
        ],
    ),
    ("baudbot.v1.BrainLinkService", &[("Attach", "alice tutor stranger")]),
    ("baudbot.v1.TrainerService", &[("Train", "trainer")]),
    ("grpc.health.v1.Health", &[("Check", "-"), ("Watch", "any")]),
    ("grpc.reflection.v1.ServerReflection", &[("ServerReflectionInfo", "any")]),
    ("grpc.reflection.v1alpha.ServerReflection", &[("ServerReflectionInfo", "any")]),
];

/// The services of these descriptors, with their calls.
fn services(descriptors: &[u8]) -> Vec<(String, Vec<String>)> {
    let set = FileDescriptorSet::decode(descriptors).unwrap();
    let of_file = |file: &prost_types::FileDescriptorProto| {
        let package = file.package().to_owned();
        let service = move |service: &prost_types::ServiceDescriptorProto| {
            let calls = service.method.iter().map(|method| method.name().to_owned()).collect();
            (format!("{package}.{}", service.name()), calls)
        };
        file.service.iter().map(service).collect::<Vec<_>>()
    };
    set.file.iter().flat_map(of_file).collect()
}

/// The end of a call without content, or its first answer.
async fn call(channel: Channel, path: &str) -> Result<(), Status> {
    let mut client = Grpc::new(channel);
    client.ready().await.map_err(|error| Status::unknown(error.to_string()))?;
    let path = PathAndQuery::try_from(path).unwrap();
    // One message, which is what unary calls take; streams take it, too.
    let requests = Request::new(tokio_stream::once(()));
    let mut answers = client.streaming(requests, path, ProstCodec::<(), ()>::default()).await?.into_inner();
    tokio::time::timeout(Duration::from_secs(2), answers.message()).await.unwrap_or(Ok(None)).map(|_| ())
}

/// All services that are anywhere, with their calls.
fn all_services() -> Vec<(String, Vec<String>)> {
    let sets = [
        baudbot_proto::DESCRIPTORS,
        tonic_health::pb::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1alpha::FILE_DESCRIPTOR_SET,
    ];
    sets.into_iter().flat_map(services).collect()
}

/// A call that is added to the contract has no line above, and fails here.
#[tokio::test]
async fn each_call_may_be_made_by_those_who_have_the_right_to_it_and_by_nobody_else() {
    let class = Class::begin().await;
    let mut tried = 0;
    for (service, calls) in all_services() {
        let (_, expected) = CALLS.iter().find(|(name, _)| *name == service).expect(&service);
        assert_eq!(expected.len(), calls.len(), "{service}");
        for name in calls {
            let (_, may) = expected.iter().find(|(call, _)| *call == name).expect(&name);
            let path = format!("/{service}/{name}");
            let by_none = call(class.trainers(None).await, &path).await;
            let unknown = call(class.trainers(Some(Token::random().unwrap())).await, &path).await;
            for answer in [by_none, unknown] {
                let is_refused = answer.is_err_and(|status| status.code() == Code::Unauthenticated);
                assert_eq!(is_refused, *may != "-", "{path} without a token, or with a wrong one");
            }
            for (holder, _) in HOLDERS {
                let channel = match service.contains("Trainer") {
                    true => class.trainers(Some(class.token(holder))).await,
                    false => class.client(holder).await.channel(),
                };
                let answer = call(channel, &path).await;
                let code = answer.as_ref().map_or_else(|status| status.code(), |()| Code::Ok);
                let is_let = !matches!(code, Code::Unauthenticated | Code::PermissionDenied);
                let expected = matches!(*may, "-" | "any") || may.split(' ').any(|may| may == holder);
                assert_eq!(is_let, expected, "{path} by {holder}: {answer:?}");
                tried += 1;
            }
        }
    }
    assert!(tried > 150, "{tried}");
    class.server.shutdown().await;
}

/// Programs that a run starts are of the user who may do everything; by the address that they are given they only drive.
#[tokio::test]
async fn where_there_are_brains_only_nothing_else_is_served() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("unix:{}", folder.path().join("socket").display());
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep()).paused(true);
    let server = Server::builder().world(world).brains(address.parse().unwrap()).serve().await.unwrap();
    assert!(server.addresses().is_empty());
    let brain = connect_with(&address, &Credentials::default()).await.unwrap();
    for (service, calls) in all_services() {
        for name in calls {
            let path = format!("/{service}/{name}");
            let refused =
                call(brain.channel(), &path).await.is_err_and(|status| status.code() == Code::Unimplemented);
            assert_eq!(refused, name != "Attach", "{path}");
        }
    }
    brain.attach("w", "robot").await.unwrap();
    server.shutdown().await;
}

/// The words of a refusal.
async fn refusal(client: &Client, world: &str, robot: &str) -> String {
    match client.attach(world, robot).await.map(|_| ()) {
        Err(Error::Status { code, message }) => format!("{code:?}: {message}"),
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn a_driver_learns_nothing_of_other_robots() {
    let class = Class::begin().await;
    let alice = class.client("alice").await;
    let words = |robot: &str| {
        format!("PermissionDenied: the token `alice` has no right to drive {robot}; it has `drive w/alice`")
    };
    assert_eq!(refusal(&alice, "w", "bob").await, words("w/bob"), "there is one");
    assert_eq!(refusal(&alice, "w", "eve").await, words("w/eve"), "there is none");
    assert_eq!(refusal(&alice, "other", "alice").await, words("other/alice"), "there is no such world");
    // A robot that it may drive and that is not there is named without the others.
    let stranger = class.client("stranger").await;
    let text = refusal(&stranger, "elsewhere", "alice").await;
    assert_eq!(text, "NotFound: hello: there is no robot `alice` in a world `elsewhere`");
    let tutor = class.client("tutor").await;
    let text = refusal(&tutor, "w", "eve").await;
    assert!(text.contains("there are: alice, bob"), "who may observe is helped: {text}");
    alice.attach("w", "alice").await.unwrap();
    class.server.shutdown().await;
}

#[tokio::test]
async fn a_stream_ends_when_its_token_is_revoked() {
    let class = Class::begin().await;
    let alice = class.client("alice").await;
    let mut robot = alice.attach("w", "alice").await.unwrap();
    let waits = tokio::spawn(async move { robot.turn().await.map(|_| ()) });
    class.file.revoke(&"alice".parse().unwrap()).unwrap();
    let ended = tokio::time::timeout(Duration::from_secs(20), waits).await.expect("it ends").unwrap();
    let text = ended.unwrap_err().to_string();
    assert!(text.contains("the token is not valid on this server"), "{text}");
    // The robot is free, for those who may.
    class.client("tutor").await.attach("w", "alice").await.unwrap();
    class.server.shutdown().await;
}

/// The answer to a request of HTTP/1.1.
async fn ask(address: SocketAddr, request: &str) -> String {
    let mut page = TcpStream::connect(address).await.unwrap();
    page.write_all(format!("{request}\r\nHost: localhost\r\n\r\n").as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    // An upgraded connection stays open.
    let read = tokio::time::timeout(Duration::from_secs(2), page.read_to_end(&mut answer)).await;
    assert!(read.is_ok() || answer.starts_with(b"HTTP/1.1 101"), "the server closes the connection");
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn a_page_shows_its_token_once_and_its_cookie_from_then_on() {
    let class = Class::begin().await;
    let page = class.server.viewers()[0];
    const SOCKET: &str = "GET /page HTTP/1.1\r\nConnection: upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
        Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
    let begins = |answer: &str, with: &str| assert!(answer.starts_with(with), "{answer}");
    begins(&ask(page, "GET / HTTP/1.1").await, "HTTP/1.1 200");
    begins(&ask(page, SOCKET).await, "HTTP/1.1 401");
    begins(&ask(page, "GET /session HTTP/1.1").await, "HTTP/1.1 401");
    begins(&ask(page, "GET /metrics HTTP/1.1").await, "HTTP/1.1 401");
    let bearer = |holder| format!("Authorization: Bearer {}", class.tokens[holder].reveal());
    begins(&ask(page, &format!("GET /metrics HTTP/1.1\r\n{}", bearer("alice"))).await, "HTTP/1.1 403");
    begins(&ask(page, &format!("GET /metrics HTTP/1.1\r\n{}", bearer("observer"))).await, "HTTP/1.1 200");
    let entered =
        ask(page, &format!("POST /session HTTP/1.1\r\nContent-Length: 0\r\n{}", bearer("observer"))).await;
    begins(&entered, "HTTP/1.1 204");
    let cookie = entered.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    let cookie = format!("Cookie: {}", cookie.split(';').next().unwrap());
    begins(&ask(page, &format!("GET /session HTTP/1.1\r\n{cookie}")).await, "HTTP/1.1 204");
    begins(&ask(page, &format!("{SOCKET}\r\n{cookie}")).await, "HTTP/1.1 101");
    let strange = format!("{SOCKET}\r\n{cookie}\r\nOrigin: http://evil.example");
    begins(&ask(page, &strange).await, "HTTP/1.1 403");
    class.file.revoke(&"observer".parse().unwrap()).unwrap();
    tokio::time::sleep(Duration::from_millis(1100)).await;
    begins(&ask(page, &format!("GET /session HTTP/1.1\r\n{cookie}")).await, "HTTP/1.1 401");
    class.server.shutdown().await;
}

#[tokio::test]
async fn other_machines_reach_a_server_only_with_tokens_and_tls() {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("tokens.toml"));
    let new =
        NewGrant { name: "a".parse().unwrap(), rights: vec!["observe".parse().unwrap()], expires_at: None };
    file.add(new, SystemTime::now()).unwrap();
    let world = || WorldConfig::new("w", scenario(WANDER, &[])).paused(true);
    let everywhere = || Server::builder().world(world()).listen("0.0.0.0:0".parse().unwrap());
    let local = || Token::random().unwrap();
    for refused in [
        everywhere(),
        everywhere().tokens(file.clone()),
        everywhere().behind_proxy(true).local_token(local()),
    ] {
        let text = refused.serve().await.err().expect("it does not start").to_string();
        assert!(text.contains("--tokens FILE") && text.contains("--tls CERTIFICATE,KEY"), "{text}");
    }
    let page = Server::builder().world(world()).viewer(SocketAddr::from(([0, 0, 0, 0], 0)));
    assert!(page.serve().await.is_err());
    let shown = async |builder: Builder| {
        let page = builder.world(world()).tokens(file.clone()).behind_proxy(true);
        let server = page.viewer(SocketAddr::from(([0, 0, 0, 0], 0))).serve().await.unwrap();
        let (port, link) = (server.viewers()[0].port(), server.viewer_links().remove(0));
        server.shutdown().await;
        link.replace(&port.to_string(), "PORT")
    };
    assert_eq!(
        shown(Server::builder()).await,
        "http://127.0.0.1:PORT/",
        "a browser is let in under this name"
    );
    assert_eq!(shown(Server::builder().host("robots.lab")).await, "http://robots.lab:PORT/");
    assert_eq!(
        shown(Server::builder().local_token(local())).await,
        "http://127.0.0.1:PORT/",
        "what a service prints is in logs, where no token is to be"
    );
    everywhere().tokens(file).behind_proxy(true).serve().await.unwrap().shutdown().await;
}
