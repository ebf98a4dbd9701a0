//! TLS: the certificate of a server, and a connection that may be encrypted by it.
//!
//! The handshake is a part of reading the connection, so that a peer who is slow at it keeps nobody waiting, and has no longer
//! for it than for its first call. Who speaks without TLS where it is wanted is told so, in words.

use std::io::{self, IoSlice};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{self, RootCertStore, ServerConfig};
use tokio_rustls::server::TlsStream;
use tokio_rustls::{Accept, TlsAcceptor};

/// What a server shows who it is with, and by which it encrypts.
#[derive(Clone, Debug)]
pub struct Tls {
    config: Arc<ServerConfig>,
}

/// Why a server has no TLS.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file cannot be read, or is no PEM.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: pem::Error,
    },
    /// A file without certificates.
    #[error("{}: has no certificate (-----BEGIN CERTIFICATE-----)", path.display())]
    NoCertificate {
        /// The file.
        path: PathBuf,
    },
    /// A certificate that cannot be trusted as an authority's.
    #[error("{}: {source}", path.display())]
    Authority {
        /// The file.
        path: PathBuf,
        /// Why.
        source: rustls::Error,
    },
    /// An authority by which no client can be checked.
    #[error("{}: {source}", path.display())]
    Clients {
        /// The file.
        path: PathBuf,
        /// Why.
        source: rustls::server::VerifierBuilderError,
    },
    /// The key is not that of the certificate, or of an unknown kind.
    #[error("{} and {}: {source}", certificate.display(), key.display())]
    Pair {
        /// The certificate's file.
        certificate: PathBuf,
        /// The key's file.
        key: PathBuf,
        /// Why.
        source: rustls::Error,
    },
}

impl Tls {
    /// Reads a chain of certificates, the server's own first, and its key, both in PEM. With `clients`, the certificates of
    /// authorities, only clients connect that show a certificate of one of these.
    ///
    /// # Errors
    /// If a file cannot be read or does not have what it should, or key and certificate do not fit.
    pub fn read(certificate: &Path, key: &Path, clients: Option<&Path>) -> Result<Self, TlsError> {
        let chain = certificates(certificate)?;
        let secret = PrivateKeyDer::from_pem_file(key)
            .map_err(|source| TlsError::File { path: key.to_owned(), source })?;
        let builder = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_safe_default_protocol_versions();
        let pair =
            |source| TlsError::Pair { certificate: certificate.to_owned(), key: key.to_owned(), source };
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
    /// Nothing has come yet.
    Silent(TcpStream, TlsAcceptor),
    Shaking(Box<Accept<TcpStream>>),
    Encrypted(Box<TlsStream<TcpStream>>),
    /// It is over.
    Closed,
}

/// The first byte of a handshake.
const HANDSHAKE: u8 = 22;

/// The answer to whoever speaks without TLS. It is one of HTTP/1.1, which clients of other protocols at least show.
const WANTS_TLS: &[u8] = b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nConnection: close\r\n\r\n\
    this server speaks TLS: use https://\n";

impl Secured {
    pub(super) fn new(stream: TcpStream, tls: Option<&Tls>) -> Self {
        match tls {
            Some(tls) => Self::Silent(stream, TlsAcceptor::from(Arc::clone(&tls.config))),
            None => Self::Plain(stream),
        }
    }

    /// What it goes over.
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
                    *self = Self::Encrypted(Box::new(opened?));
                }
                Self::Closed => return Poll::Ready(Err(io::ErrorKind::NotConnected.into())),
            }
        }
    }
}

/// Tells a peer that speaks without TLS what is wanted, as far as it takes that at once.
fn refuse(stream: &TcpStream) -> io::Result<()> {
    // What is left unread would make the end a reset, which may overtake the answer.
    let _ = stream.try_read(&mut [0; 16 << 10]);
    let _ = stream.try_write(WANTS_TLS);
    Err(io::Error::new(io::ErrorKind::InvalidData, "the peer speaks without TLS"))
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
