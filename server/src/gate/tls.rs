//! TLS: the certificate of a server, and a connection that may be encrypted by it.
//!
//! The handshake is a part of reading the connection, so that a peer that is slow at it delays no other, and has no
//! longer for it than for its first call. A peer without TLS where it is wanted gets an answer in words.

use std::io::{self, IoSlice};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::{Arc, LazyLock};
use std::task::{Context, Poll, ready};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use baudbot_access::date;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{self, InconsistentKeys, RootCertStore, ServerConfig};
use tokio_rustls::server::TlsStream;
use tokio_rustls::{Accept, TlsAcceptor};
use x509_parser::error::X509Error;
use x509_parser::time::ASN1Time;

use crate::log::Throttle;
use crate::system::everybody_can_read;

/// The certificate by which a server shows its identity and encrypts.
#[derive(Clone, Debug)]
pub struct Tls {
    config: Arc<ServerConfig>,
}

/// A reason why a server has no TLS.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file cannot be read, or is no PEM.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the file.
        source: pem::Error,
    },
    /// A file without certificates.
    #[error("{}: has no certificate (-----BEGIN CERTIFICATE-----)", path.display())]
    NoCertificate {
        /// The file.
        path: PathBuf,
    },
    /// A file without a key.
    #[error("{}: has no key (-----BEGIN PRIVATE KEY-----); the certificate comes first, then its key", path.display())]
    NoKey {
        /// The file.
        path: PathBuf,
    },
    /// The bytes between the lines of a PEM are no certificate.
    #[error("{}: its certificate is damaged ({source})", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The error in it.
        source: X509Error,
    },
    /// A certificate that clients refuse.
    #[error("{}: the certificate expired on {}; replace it", path.display(), date::print(*at))]
    Expired {
        /// The file.
        path: PathBuf,
        /// The end of the certificate's validity.
        at: SystemTime,
    },
    /// A certificate that cannot be trusted as an authority's.
    #[error("{}: {source}", path.display())]
    Authority {
        /// The file.
        path: PathBuf,
        /// The error of TLS.
        source: rustls::Error,
    },
    /// An authority by which no client can be checked.
    #[error("{}: {source}", path.display())]
    Clients {
        /// The file.
        path: PathBuf,
        /// The error of the verifier.
        source: rustls::server::VerifierBuilderError,
    },
    /// The key is that of another certificate.
    #[error("{}: is not the key of the certificate in {}", key.display(), certificate.display())]
    Strange {
        /// The certificate's file.
        certificate: PathBuf,
        /// The key's file.
        key: PathBuf,
    },
    /// The key is of an unknown kind.
    #[error("{} and {}: {source}", certificate.display(), key.display())]
    Pair {
        /// The certificate's file.
        certificate: PathBuf,
        /// The key's file.
        key: PathBuf,
        /// The error of TLS.
        source: rustls::Error,
    },
}

impl TlsError {
    /// Whether it is this file that cannot be used.
    pub fn concerns(&self, file: &Path) -> bool {
        match self {
            Self::File { path, .. }
            | Self::NoCertificate { path }
            | Self::NoKey { path }
            | Self::Damaged { path, .. }
            | Self::Expired { path, .. }
            | Self::Authority { path, .. }
            | Self::Clients { path, .. } => path == file,
            Self::Strange { certificate, key } | Self::Pair { certificate, key, .. } => {
                certificate == file || key == file
            }
        }
    }
}

impl Tls {
    /// Reads a chain of certificates, the server's own first, and its key, both in PEM. With `clients`, the certificates of
    /// authorities, only clients connect that show a certificate of one of these.
    ///
    /// # Errors
    /// If a file cannot be read or does not have what it should, or key and certificate do not fit.
    pub fn read(certificate: &Path, key: &Path, clients: Option<&Path>) -> Result<Self, TlsError> {
        let chain = certificates(certificate)?;
        check_dates(certificate, &chain[0], SystemTime::now())?;
        let secret = PrivateKeyDer::from_pem_file(key).map_err(|source| {
            let path = key.to_owned();
            if matches!(source, pem::Error::NoItemsFound) {
                TlsError::NoKey { path }
            } else {
                TlsError::File { path, source }
            }
        })?;
        if everybody_can_read(key) {
            let key = key.display();
            tracing::warn!(
                "all users of this machine can read the key {key}; fix that with: chmod 600 {key}"
            );
        }
        let builder = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_safe_default_protocol_versions();
        let pair = |source| {
            let (certificate, key) = (certificate.to_owned(), key.to_owned());
            if source == rustls::Error::InconsistentKeys(InconsistentKeys::KeyMismatch) {
                TlsError::Strange { certificate, key }
            } else {
                TlsError::Pair { certificate, key, source }
            }
        };
        let builder = builder.map_err(pair)?;
        let builder = match clients {
            Some(path) => builder.with_client_cert_verifier(verifier(path)?),
            None => builder.with_no_client_auth(),
        };
        Ok(Self { config: Arc::new(builder.with_single_cert(chain, secret).map_err(pair)?) })
    }

    /// The same for connections that speak one of these protocols (ALPN).
    pub(crate) fn speaking(&self, protocols: &[&str]) -> Self {
        let mut config = ServerConfig::clone(&self.config);
        config.alpn_protocols = protocols.iter().map(|protocol| protocol.as_bytes().to_vec()).collect();
        Self { config: Arc::new(config) }
    }
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let file = |source| TlsError::File { path: path.to_owned(), source };
    let all = CertificateDer::pem_file_iter(path).map_err(file)?;
    let all = all.collect::<Result<Vec<_>, _>>().map_err(file)?;
    if all.is_empty() {
        return Err(TlsError::NoCertificate { path: path.to_owned() });
    }
    Ok(all)
}

/// Refuses a certificate that has expired, and warns of one that will soon, or is not valid yet: the clock may be wrong.
fn check_dates(path: &Path, certificate: &CertificateDer<'_>, now: SystemTime) -> Result<(), TlsError> {
    let damaged = |source| TlsError::Damaged { path: path.to_owned(), source };
    let (_, parsed) =
        x509_parser::parse_x509_certificate(certificate).map_err(|error| damaged(error.into()))?;
    let validity = parsed.validity();
    let instant = |time: ASN1Time| {
        let seconds = Duration::from_secs(u64::try_from(time.timestamp()).unwrap_or_default());
        UNIX_EPOCH.checked_add(seconds).unwrap_or(UNIX_EPOCH)
    };
    let (begins, ends) = (instant(validity.not_before), instant(validity.not_after));
    if ends < now {
        return Err(TlsError::Expired { path: path.to_owned(), at: ends });
    }
    let path = path.display();
    if begins > now {
        let begins = date::print(begins);
        tracing::warn!("the certificate {path} is valid from {begins} on; is the clock right?");
    }
    if ends < now + SOON {
        tracing::warn!("the certificate {path} expires on {}; replace it", date::print(ends));
    }
    Ok(())
}

/// The time before its end at which a certificate is warned of.
const SOON: Duration = Duration::from_secs(14 * 24 * 60 * 60);

/// Checks certificates of clients by those of authorities.
fn verifier(path: &Path) -> Result<Arc<dyn rustls::server::danger::ClientCertVerifier>, TlsError> {
    let mut roots = RootCertStore::empty();
    for authority in certificates(path)? {
        roots.add(authority).map_err(|source| TlsError::Authority { path: path.to_owned(), source })?;
    }
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider).build();
    verifier.map_err(|source| TlsError::Clients { path: path.to_owned(), source })
}

/// A connection, encrypted or not.
pub(crate) enum Secured {
    Plain(TcpStream),
    /// The peer has sent nothing yet.
    Silent(TcpStream, TlsAcceptor),
    Shaking(Box<Accept<TcpStream>>),
    Encrypted(Box<TlsStream<TcpStream>>),
    /// The connection is over.
    Closed,
}

/// The first byte of a handshake.
const HANDSHAKE: u8 = 22;

/// The answer to a peer without TLS. It is one of HTTP/1.1, which clients of other protocols at least show.
const WANTS_TLS: &[u8] = b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nConnection: close\r\n\r\n\
    this server speaks TLS: use https://\n";

impl Secured {
    pub(super) fn new(stream: TcpStream, tls: Option<&Tls>) -> Self {
        match tls {
            Some(tls) => Self::Silent(stream, TlsAcceptor::from(Arc::clone(&tls.config))),
            None => Self::Plain(stream),
        }
    }

    /// The stream under it.
    pub(super) fn stream(&self) -> Option<&TcpStream> {
        match self {
            Self::Plain(stream) | Self::Silent(stream, _) => Some(stream),
            Self::Encrypted(stream) => Some(stream.get_ref().0),
            Self::Shaking(accept) => accept.get_ref(),
            Self::Closed => None,
        }
    }

    /// Takes the handshake as far as it goes.
    fn poll_open(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            match self {
                Self::Plain(_) | Self::Encrypted(_) => return Poll::Ready(Ok(())),
                Self::Silent(stream, acceptor) => {
                    let mut first = [0];
                    if ready!(stream.poll_peek(context, &mut ReadBuf::new(&mut first)))? == 1
                        && first[0] != HANDSHAKE
                    {
                        return Poll::Ready(refuse(stream));
                    }
                    let acceptor = acceptor.clone();
                    let Self::Silent(stream, _) = std::mem::replace(self, Self::Closed) else { continue };
                    *self = Self::Shaking(Box::new(acceptor.accept(stream)));
                }
                Self::Shaking(accept) => {
                    let opened = ready!(Pin::new(accept).poll(context));
                    *self = Self::Closed;
                    *self = Self::Encrypted(Box::new(opened.inspect_err(note_failure)?));
                }
                Self::Closed => return Poll::Ready(Err(io::ErrorKind::NotConnected.into())),
            }
        }
    }
}

/// A client that is refused may know no reason, such as that it showed no certificate; the operator does.
fn note_failure(error: &io::Error) {
    static FAILURES: LazyLock<Throttle> = LazyLock::new(Throttle::default);
    // A peer that leaves in the middle of a handshake is not logged.
    if error.kind() == io::ErrorKind::InvalidData
        && let Some(count) = FAILURES.note(Instant::now())
    {
        tracing::warn!(%error, count, "a TLS handshake failed");
    }
}

/// Sends a peer without TLS the answer that TLS is wanted, as far as it takes that at once.
fn refuse(stream: &TcpStream) -> io::Result<()> {
    // Unread bytes would make the end a reset, which may overtake the answer.
    let _ = stream.try_read(&mut [0; 16 << 10]);
    let _ = stream.try_write(WANTS_TLS);
    Err(io::Error::new(io::ErrorKind::InvalidData, "the peer does not use TLS"))
}

impl AsyncRead for Secured {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        ready!(self.poll_open(context))?;
        match &mut *self {
            Self::Plain(stream) => Pin::new(stream).poll_read(context, buffer),
            Self::Encrypted(stream) => Pin::new(stream).poll_read(context, buffer),
            Self::Silent(..) | Self::Shaking(_) | Self::Closed => Poll::Ready(Ok(())),
        }
    }
}

impl AsyncWrite for Secured {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        ready!(self.poll_open(context))?;
        match &mut *self {
            Self::Plain(stream) => Pin::new(stream).poll_write(context, bytes),
            Self::Encrypted(stream) => Pin::new(stream).poll_write(context, bytes),
            Self::Silent(..) | Self::Shaking(_) | Self::Closed => Poll::Ready(Ok(0)),
        }
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        ready!(self.poll_open(context))?;
        match &mut *self {
            Self::Plain(stream) => Pin::new(stream).poll_write_vectored(context, parts),
            Self::Encrypted(stream) => Pin::new(stream).poll_write_vectored(context, parts),
            Self::Silent(..) | Self::Shaking(_) | Self::Closed => Poll::Ready(Ok(0)),
        }
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut *self {
            Self::Plain(stream) => Pin::new(stream).poll_flush(context),
            Self::Encrypted(stream) => Pin::new(stream).poll_flush(context),
            Self::Silent(..) | Self::Shaking(_) | Self::Closed => Poll::Ready(Ok(())),
        }
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut *self {
            Self::Plain(stream) => Pin::new(stream).poll_shutdown(context),
            Self::Encrypted(stream) => Pin::new(stream).poll_shutdown(context),
            Self::Silent(stream, _) => Pin::new(stream).poll_shutdown(context),
            Self::Shaking(_) | Self::Closed => Poll::Ready(Ok(())),
        }
    }
}
