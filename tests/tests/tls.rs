//! Servers that show a certificate, and clients that check it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use baudbot_access::Token;
use baudbot_access::certificates::{Authority, Host, Role};
use baudbot_client::{Credentials, Error, connect_with};
use baudbot_server::{Address, Server, Tls, WorldConfig};
use baudbot_tests::system::lockstep;
use baudbot_tests::{WANDER, scenario};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// An authority and what it has issued.
struct Lab {
    folder: TempDir,
    authority: Authority,
}

impl Lab {
    fn new() -> Self {
        let authority =
            Authority::new(&"lab".parse().unwrap(), "1w".parse().unwrap(), SystemTime::now()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        authority.write(folder.path()).unwrap();
        Self { folder, authority }
    }

    fn ca(&self) -> PathBuf {
        self.folder.path().join("ca.pem")
    }

    /// The certificate of this role and its key.
    fn issue(&self, role: &Role) -> (PathBuf, PathBuf) {
        let issued = self.authority.issue(role, "1d".parse().unwrap(), SystemTime::now()).unwrap();
        let paths = issued.write(self.folder.path(), role).unwrap();
        (paths.certificate, paths.key)
    }

    fn server(&self, name: &str) -> (PathBuf, PathBuf) {
        self.issue(&Role::Server(vec![name.parse::<Host>().unwrap()]))
    }
}

async fn serve((certificate, key): &(PathBuf, PathBuf), clients: Option<&Path>) -> Server {
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep()).paused(true);
    let tls = Tls::read(certificate, key, clients).unwrap();
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let builder = Server::builder().world(world).tls(tls).viewer(free).listen("127.0.0.1:0".parse().unwrap());
    builder.serve().await.unwrap()
}

fn port(server: &Server) -> u16 {
    let Address::Tcp(address) = server.addresses()[0] else { panic!("it is a port") };
    address.port()
}

async fn attaches(server: &Server, credentials: &Credentials) -> Result<(), Error> {
    let client = connect_with(&format!("https://127.0.0.1:{}", port(server)), credentials).await?;
    client.attach("w", "robot").await.map(drop)
}

fn trusting(ca: PathBuf) -> Credentials {
    Credentials::default().authorities(ca)
}

#[test]
fn a_server_with_a_certificate_that_no_client_takes_does_not_start() {
    let lab = Lab::new();
    let (certificate, key) = lab.server("127.0.0.1");
    let (_, strange) = lab.server("robots.lab");
    let refused = |certificate: &Path, key: &Path| Tls::read(certificate, key, None).unwrap_err().to_string();
    let text = refused(&key, &certificate);
    assert!(text.contains("127.0.0.1-key.pem: has no certificate"), "{text}");
    let text = refused(&certificate, &certificate);
    assert!(text.ends_with("the certificate comes first, then its key"), "{text}");
    let text = refused(&certificate, &strange);
    assert!(text.contains("robots.lab-key.pem: is not the key of the certificate in "), "{text}");
    let role = Role::Server(vec!["old.lab".parse().unwrap()]);
    let three_days_ago = SystemTime::now() - Duration::from_secs(3 * 24 * 60 * 60);
    let issued = lab.authority.issue(&role, "1d".parse().unwrap(), three_days_ago).unwrap();
    let paths = issued.write(lab.folder.path(), &role).unwrap();
    let text = refused(&paths.certificate, &paths.key);
    assert!(text.contains("old.lab.pem: the certificate expired on "), "{text}");
}

#[tokio::test]
async fn a_client_speaks_only_with_a_server_that_it_can_trust() {
    let (lab, others) = (Lab::new(), Lab::new());
    let server = serve(&lab.server("127.0.0.1"), None).await;
    attaches(&server, &trusting(lab.ca())).await.unwrap();
    let refused = |result: Result<(), Error>| result.unwrap_err().to_string();
    let text = refused(attaches(&server, &trusting(others.ca())).await);
    assert!(text.contains("is not trusted"), "{text}");
    let text = refused(attaches(&server, &Credentials::default()).await);
    assert!(text.contains("is not trusted"), "{text}");
    let elsewhere = serve(&lab.server("robots.lab"), None).await;
    let text = refused(attaches(&elsewhere, &trusting(lab.ca())).await);
    assert!(text.contains("is not valid for the name"), "{text}");
    server.shutdown().await;
    elsewhere.shutdown().await;
}

#[tokio::test]
async fn who_speaks_without_tls_where_it_is_wanted_is_told() {
    let lab = Lab::new();
    let server = serve(&lab.server("127.0.0.1"), None).await;
    for (address, says) in [
        (SocketAddr::from(([127, 0, 0, 1], port(&server))), "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
        (server.viewers()[0], "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
    ] {
        let mut plain = TcpStream::connect(address).await.unwrap();
        plain.write_all(says.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        let read = tokio::time::timeout(Duration::from_secs(20), plain.read_to_end(&mut answer)).await;
        // Unread bytes make the end a reset.
        let _ = read.expect("the server closes the connection");
        let answer = String::from_utf8_lossy(&answer);
        assert!(answer.contains("this server speaks TLS: use https://"), "{answer}");
    }
    let began = Instant::now();
    let address = format!("127.0.0.1:{}", port(&server));
    let text = connect_with(&address, &Credentials::default()).await.expect_err("refused").to_string();
    assert!(text.contains("this server speaks TLS: use https://"), "{text}");
    assert!(began.elapsed() < Duration::from_secs(20), "it does not hang");
    server.shutdown().await;
}

#[tokio::test]
async fn a_server_may_ask_clients_for_certificates() {
    let (lab, others) = (Lab::new(), Lab::new());
    let server = serve(&lab.server("127.0.0.1"), Some(&lab.ca())).await;
    let client = |lab: &Lab| lab.issue(&Role::Client("alice".parse().unwrap()));
    let ((certificate, key), (strange, its_key)) = (client(&lab), client(&others));
    attaches(&server, &trusting(lab.ca()).certificate(certificate, key)).await.unwrap();
    assert!(attaches(&server, &trusting(lab.ca())).await.is_err(), "none is shown");
    let stranger = trusting(lab.ca()).certificate(strange, its_key);
    assert!(attaches(&server, &stranger).await.is_err(), "one of another authority");
    server.shutdown().await;
}

#[tokio::test]
async fn files_that_cannot_be_used_are_named() {
    let lab = Lab::new();
    let (certificate, key) = lab.server("127.0.0.1");
    let (_, other_key) = lab.server("robots.lab");
    let missing = lab.folder.path().join("missing.pem");
    for (certificate, key, named) in [
        (&missing, &key, "missing.pem"),
        (&certificate, &missing, "missing.pem"),
        (&key, &key, "127.0.0.1-key.pem: has no certificate"),
        (&certificate, &other_key, "robots.lab-key.pem"),
    ] {
        let text = Tls::read(certificate, key, None).unwrap_err().to_string();
        assert!(text.contains(named), "{text}");
    }
    let text = match connect_with("https://127.0.0.1:1", &trusting(missing)).await {
        Err(error) => error.to_string(),
        Ok(_) => panic!("there is no authority"),
    };
    assert!(text.contains("missing.pem"), "{text}");
}

#[tokio::test]
async fn a_token_is_shown_over_tls() {
    let lab = Lab::new();
    let (certificate, key) = lab.server("127.0.0.1");
    let token = Token::random().unwrap();
    let text = token.reveal();
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep()).paused(true);
    let builder = Server::builder().world(world).tls(Tls::read(&certificate, &key, None).unwrap());
    let tokens = baudbot_access::TokenFile::at(lab.folder.path().join("tokens.toml"));
    let new = baudbot_access::NewGrant {
        name: "alice".parse().unwrap(),
        rights: vec!["drive w/robot".parse().unwrap()],
        expires_at: None,
    };
    let alice = tokens.add(new, SystemTime::now()).unwrap();
    let server = builder.tokens(tokens).listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
    attaches(&server, &trusting(lab.ca()).token(alice)).await.unwrap();
    let error = attaches(&server, &trusting(lab.ca()).token(text.parse().unwrap())).await.unwrap_err();
    assert!(error.to_string().contains("the token is not valid on this server"), "{error}");
    server.shutdown().await;
}
