//! Servers and clients that do not trust each other's certificates, and the client's errors then.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use baudbot_access::certificates::{Authority, Host, Role};
use baudbot_client::{Client, Credentials, Error, connect_with};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{RootCertStore, ServerConfig, crypto, version};

/// An authority in a folder of its own.
struct Lab {
    folder: PathBuf,
    authority: Authority,
}

/// A certificate and its key.
type Pair = (PathBuf, PathBuf);

impl Lab {
    fn new(name: &str) -> Self {
        // Some of the authority's certificates are issued in the past, too.
        let (validity, then) = ("8w".parse().unwrap(), SystemTime::now() - 4 * WEEK);
        let authority = Authority::new(&"lab".parse().unwrap(), validity, then).unwrap();
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&folder);
        authority.write(&folder).unwrap();
        Self { folder, authority }
    }

    fn ca(&self) -> PathBuf {
        self.folder.join("ca.pem")
    }

    /// One that is valid for a week from then on.
    fn issue(&self, role: &Role, then: SystemTime) -> Pair {
        let issued = self.authority.issue(role, "1w".parse().unwrap(), then).unwrap();
        let paths = issued.write(&self.folder, role).unwrap();
        (paths.certificate, paths.key)
    }

    fn server(&self, name: &str, then: SystemTime) -> Pair {
        self.issue(&Role::Server(vec![name.parse::<Host>().unwrap()]), then)
    }

    fn client(&self) -> Pair {
        self.issue(&Role::Client("alice".parse().unwrap()), SystemTime::now())
    }
}

const WEEK: Duration = Duration::from_secs(7 * 24 * 60 * 60);

/// A server's acts after the handshake.
#[derive(Clone, Copy)]
enum Then {
    /// The peer sends the first bytes of HTTP/2, and receives to the end.
    Speaks,
    HangsUp,
}

/// The address of a server, which may ask for certificates of an authority.
async fn serve(pair: &Pair, clients: Option<&Path>, then: Then) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = format!("https://{}", listener.local_addr().unwrap());
    let acceptor = TlsAcceptor::from(Arc::new(config(pair, clients)));
    tokio::spawn(async move {
        loop {
            let (stream, _) = listener.accept().await.unwrap();
            let Ok(mut stream) = acceptor.accept(stream).await else { continue };
            match then {
                Then::HangsUp => continue,
                Then::Speaks => {}
            }
            tokio::spawn(async move {
                // Settings that change nothing.
                let _ = stream.write_all(&[0, 0, 0, 4, 0, 0, 0, 0, 0]).await;
                let _ = stream.read_to_end(&mut Vec::new()).await;
            });
        }
    });
    address
}

fn config((certificate, key): &Pair, clients: Option<&Path>) -> ServerConfig {
    let provider = Arc::new(crypto::ring::default_provider());
    let builder = ServerConfig::builder_with_provider(Arc::clone(&provider));
    let builder = builder.with_protocol_versions(&[&version::TLS13]).unwrap();
    let builder = match clients {
        None => builder.with_no_client_auth(),
        Some(ca) => {
            let mut roots = RootCertStore::empty();
            roots.add(CertificateDer::from_pem_file(ca).unwrap()).unwrap();
            let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider);
            builder.with_client_cert_verifier(verifier.build().unwrap())
        }
    };
    let chain = vec![CertificateDer::from_pem_file(certificate).unwrap()];
    let mut config = builder.with_single_cert(chain, PrivateKeyDer::from_pem_file(key).unwrap()).unwrap();
    config.alpn_protocols = vec![b"h2".to_vec()];
    config
}

fn trusting(ca: PathBuf) -> Credentials {
    Credentials::default().authorities(ca)
}

/// The error of a client that is refused, without the address; it does not try again.
async fn refusal(address: &str, credentials: &Credentials) -> String {
    let result: Result<Client, Error> = connect_with(address, credentials).await;
    let error = result.expect_err("it is refused");
    let is_final = matches!(error, Error::ServerCertificate { .. } | Error::ClientCertificate { .. });
    assert_eq!(error.may_pass(), !is_final, "{error}");
    error.to_string().replace(address, "ADDRESS")
}

#[tokio::test]
async fn a_certificate_of_a_server_that_is_not_trusted_is_told_with_the_remedy() {
    let (lab, others) = (Lab::new("certificates-lab"), Lab::new("certificates-others"));
    let now = SystemTime::now();
    let address = serve(&lab.server("127.0.0.1", now), None, Then::Speaks).await;
    connect_with(&address, &trusting(lab.ca())).await.unwrap();
    let of = "the certificate of the server at ADDRESS";
    assert_eq!(
        refusal(&address, &Credentials::default()).await,
        format!("{of} is not trusted: name the authority that signed it with --ca FILE or BAUDBOT_CA")
    );
    let ca = others.ca();
    let signed = format!("the authority in {} has not signed it", ca.display());
    assert_eq!(
        refusal(&address, &trusting(ca)).await,
        format!("{of} is not trusted: {signed}; name the one that has with --ca FILE or BAUDBOT_CA")
    );
    let elsewhere = serve(&lab.server("robots.lab", now), None, Then::Speaks).await;
    let name = "is not valid for the name `127.0.0.1`: connect by a name that it has, or give the server one for this name";
    assert_eq!(refusal(&elsewhere, &trusting(lab.ca())).await, format!("{of} {name}"));
}

#[tokio::test]
async fn a_certificate_of_a_server_has_its_time() {
    for (name, then, problem) in [
        ("past", SystemTime::now() - 2 * WEEK, "has expired: the server needs a new one"),
        ("future", SystemTime::now() + WEEK, "is not valid yet: is the clock of this machine right?"),
    ] {
        let lab = Lab::new(&format!("certificates-{name}"));
        let address = serve(&lab.server("127.0.0.1", then), None, Then::Speaks).await;
        let told = refusal(&address, &trusting(lab.ca())).await;
        assert_eq!(told, format!("the certificate of the server at ADDRESS {problem}"));
    }
}

#[tokio::test]
async fn a_server_that_wants_a_client_certificate_says_so_after_the_handshake() {
    let (lab, others) = (Lab::new("certificates-wanting"), Lab::new("certificates-strange"));
    let pair = lab.server("127.0.0.1", SystemTime::now());
    let address = serve(&pair, Some(&lab.ca()), Then::Speaks).await;
    let (certificate, key) = lab.client();
    connect_with(&address, &trusting(lab.ca()).certificate(certificate, key)).await.unwrap();
    assert_eq!(
        refusal(&address, &trusting(lab.ca())).await,
        "the server at ADDRESS asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
    );
    let (strange, key) = others.client();
    let start =
        format!("the server at ADDRESS does not accept the client certificate in {}", strange.display());
    let told = refusal(&address, &trusting(lab.ca()).certificate(strange, key)).await;
    assert!(told.starts_with(&start), "{told}");
    assert!(told.contains("the server does not trust the authority that signed it"), "{told}");
}

#[tokio::test]
async fn a_server_that_hangs_up_may_want_a_client_certificate() {
    let lab = Lab::new("certificates-closing");
    let pair = lab.server("127.0.0.1", SystemTime::now());
    let address = serve(&pair, None, Then::HangsUp).await;
    let told = refusal(&address, &trusting(lab.ca())).await;
    assert!(told.starts_with("no server answers at ADDRESS ("), "{told}");
    let hint = "a server there may ask for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY";
    assert!(told.contains(hint), "{told}");
}
