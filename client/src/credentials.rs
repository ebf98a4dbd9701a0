//! What a client shows a server, and by what it knows the server.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{env, fs};

use baudbot_access::{Token, local};
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

use crate::error::Error;

/// What a client shows a server, and by what it knows the server.
///
/// [`connect`](crate::connect) takes it from the environment: the token from `BAUDBOT_TOKEN` or, in a file, `BAUDBOT_TOKEN_FILE`;
/// certificates of the authorities that it trusts, in PEM, from `BAUDBOT_CA`, in place of those of the system; a certificate of its
/// own and its key, in PEM, from `BAUDBOT_CERTIFICATE` and `BAUDBOT_KEY`. Without a token it shows the one of the user's own server
/// at that address of this machine, if there is one.
#[derive(Clone, Debug, Default)]
pub struct Credentials {
    token: Option<Arc<Token>>,
    authorities: Option<PathBuf>,
    /// A certificate and its key.
    own: Option<(PathBuf, PathBuf)>,
}

impl Credentials {
    /// Those of the environment.
    ///
    /// # Errors
    /// If a variable is set, and a token or its file is not sound.
    pub fn from_environment() -> Result<Self, Error> {
        let mut credentials = Self::default();
        if let Some(text) = env::var_os(TOKEN) {
            credentials.token = Some(Arc::new(token(TOKEN, &text.to_string_lossy())?));
        } else if let Some(path) = env::var_os(TOKEN_FILE) {
            credentials = credentials.token_file(Path::new(&path))?;
        }
        credentials.authorities = env::var_os(CA).map(PathBuf::from);
        credentials.own = match (env::var_os(CERTIFICATE), env::var_os(KEY)) {
            (Some(certificate), Some(key)) => Some((certificate.into(), key.into())),
            (None, None) => None,
            (Some(_), None) => return Err(bad(CERTIFICATE, format!("needs its key, in {KEY}"))),
            (None, Some(_)) => return Err(bad(KEY, format!("needs its certificate, in {CERTIFICATE}"))),
        };
        Ok(credentials)
    }

    /// Shows this token.
    #[must_use]
    pub fn token(self, token: Token) -> Self {
        Self { token: Some(Arc::new(token)), ..self }
    }

    /// Shows the token in this file.
    ///
    /// # Errors
    /// If the file cannot be read, or has no token in it.
    pub fn token_file(self, path: &Path) -> Result<Self, Error> {
        let place = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|error| bad(&place, error.to_string()))?;
        Ok(self.token(token(&place, &text)?))
    }

    /// Trusts servers whose certificates are of the authorities in this file, in PEM, and no others.
    #[must_use]
    pub fn authorities(self, path: impl Into<PathBuf>) -> Self {
        Self { authorities: Some(path.into()), ..self }
    }

    /// Shows this certificate, whose key is in the other file, both in PEM, to servers that ask for one.
    #[must_use]
    pub fn certificate(self, certificate: impl Into<PathBuf>, key: impl Into<PathBuf>) -> Self {
        Self { own: Some((certificate.into(), key.into())), ..self }
    }

    /// The token for the server at this address.
    pub(crate) fn token_for(&self, address: &str) -> Result<Option<Arc<Token>>, Error> {
        if let Some(token) = &self.token {
            return Ok(Some(Arc::clone(token)));
        }
        let found =
            local::find(address).map_err(|error| bad("the token of your own server", error.to_string()))?;
        Ok(found.map(Arc::new))
    }

    /// What a connection by TLS needs.
    pub(crate) fn tls(&self) -> Result<Arc<ClientConfig>, Error> {
        let builder = ClientConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(|error| bad("TLS", error.to_string()))?
            .with_root_certificates(self.roots()?);
        let mut config = match &self.own {
            None => builder.with_no_client_auth(),
            Some((certificate, key)) => {
                let chain = certificates(certificate)?;
                let place = key.display().to_string();
                let key =
                    PrivateKeyDer::from_pem_file(key).map_err(|error| bad(&place, error.to_string()))?;
                builder.with_client_auth_cert(chain, key).map_err(|error| bad(&place, error.to_string()))?
            }
        };
        config.alpn_protocols = vec![b"h2".to_vec()];
        Ok(Arc::new(config))
    }

    fn roots(&self) -> Result<RootCertStore, Error> {
        let mut roots = RootCertStore::empty();
        let Some(path) = &self.authorities else {
            roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
            return Ok(roots);
        };
        for authority in certificates(path)? {
            roots.add(authority).map_err(|error| bad(&path.display().to_string(), error.to_string()))?;
        }
        Ok(roots)
    }
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, Error> {
    let place = path.display().to_string();
    let all = CertificateDer::pem_file_iter(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let all = all.map_err(|error| bad(&place, error.to_string()))?;
    if all.is_empty() {
        return Err(bad(&place, "has no certificate (-----BEGIN CERTIFICATE-----)".to_owned()));
    }
    Ok(all)
}

fn token(place: &str, text: &str) -> Result<Token, Error> {
    text.trim().parse().map_err(|error: baudbot_access::BadToken| bad(place, error.to_string()))
}

fn bad(place: &str, problem: String) -> Error {
    Error::Credentials { place: place.to_owned(), problem }
}

const TOKEN: &str = "BAUDBOT_TOKEN";
const TOKEN_FILE: &str = "BAUDBOT_TOKEN_FILE";
const CA: &str = "BAUDBOT_CA";
const CERTIFICATE: &str = "BAUDBOT_CERTIFICATE";
const KEY: &str = "BAUDBOT_KEY";
