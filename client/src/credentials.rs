//! The secrets that a client shows a server, and the certificates by which it knows the server.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{env, fs};

use baudbot_access::{BadToken, Token, local};
use baudbot_fields::printable::Printable;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

use crate::error::Error;

/// The secrets that a client shows a server, and the certificates by which it knows the server.
///
/// [`connect`](crate::connect) takes it from the environment: the token from `BAUDBOT_TOKEN` or, in a file, `BAUDBOT_TOKEN_FILE`;
/// certificates of the authorities that it trusts, in PEM, from `BAUDBOT_CA`, in place of those of the system; a certificate of its
/// own and its key, in PEM, from `BAUDBOT_CERTIFICATE` and `BAUDBOT_KEY`. A variable that is empty is as one that is not set. Without
/// a token it shows the one of the user's own server at that address of this machine, if there is one. No token goes to another
/// machine without TLS.
#[derive(Clone, Debug, Default)]
pub struct Credentials {
    token: Option<Arc<Token>>,
    authorities: Option<Named>,
    /// A certificate and its key.
    own: Option<(Named, Named)>,
}

/// A file.
#[derive(Clone, Debug)]
struct Named {
    /// The option or the variable that names it, as people write it in front of the path.
    by: &'static str,
    path: PathBuf,
}

impl Credentials {
    /// The credentials of the environment.
    ///
    /// # Errors
    /// If a variable is set, and a token or its file is not sound.
    pub fn from_environment() -> Result<Self, Error> {
        Self::from_variables(|name| env::var_os(name))
    }

    fn from_variables(variable: impl Fn(&str) -> Option<OsString>) -> Result<Self, Error> {
        let set = |name| variable(name).filter(|value| !value.is_empty());
        let file = |name, by| set(name).map(|path| Named { by, path: path.into() });
        let token = match (set(TOKEN), file(TOKEN_FILE, "BAUDBOT_TOKEN_FILE=")) {
            (Some(text), _) => Some(Arc::new(token(TOKEN, &text.to_string_lossy())?)),
            (None, Some(file)) => Some(Arc::new(file.token()?)),
            (None, None) => None,
        };
        let own = match (file(CERTIFICATE, "BAUDBOT_CERTIFICATE="), file(KEY, "BAUDBOT_KEY=")) {
            (Some(certificate), Some(key)) => Some((certificate, key)),
            (None, None) => None,
            (Some(_), None) => return Err(bad(CERTIFICATE, format!("needs its key, in {KEY}"))),
            (None, Some(_)) => return Err(bad(KEY, format!("needs its certificate, in {CERTIFICATE}"))),
        };
        Ok(Self { token, authorities: file(CA, "BAUDBOT_CA="), own })
    }

    /// Shows this token.
    #[must_use]
    pub fn token(self, token: Token) -> Self {
        Self { token: Some(Arc::new(token)), ..self }
    }

    /// Shows the token in this file, which programs call `--token-file`.
    ///
    /// # Errors
    /// If the file cannot be read, is longer than a token's can be, or has no token in it.
    pub fn token_file(self, path: &Path) -> Result<Self, Error> {
        let file = Named { by: "--token-file ", path: path.to_owned() };
        Ok(self.token(file.token()?))
    }

    /// Trusts servers whose certificates are of the authorities in this file, in PEM, and no others. Programs call it `--ca`.
    #[must_use]
    pub fn authorities(self, path: impl Into<PathBuf>) -> Self {
        Self { authorities: Some(Named { by: "--ca ", path: path.into() }), ..self }
    }

    /// Shows this certificate, whose key is in the other file, both in PEM, to servers that ask for one.
    #[must_use]
    pub fn certificate(self, certificate: impl Into<PathBuf>, key: impl Into<PathBuf>) -> Self {
        let named = |path| Named { by: "", path };
        Self { own: Some((named(certificate.into()), named(key.into()))), ..self }
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

    /// The file of the authorities that are trusted in place of those of the system, for people.
    pub(crate) fn authorities_file(&self) -> Option<String> {
        self.authorities.as_ref().map(Named::shown)
    }

    /// The file of the certificate that is shown, for people.
    pub(crate) fn certificate_file(&self) -> Option<String> {
        self.own.as_ref().map(|(certificate, _)| certificate.shown())
    }

    /// The configuration of a connection by TLS.
    pub(crate) fn tls(&self) -> Result<Arc<ClientConfig>, Error> {
        let builder = ClientConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(|error| bad("TLS", error.to_string()))?
            .with_root_certificates(self.roots()?);
        let mut config = match &self.own {
            None => builder.with_no_client_auth(),
            Some((certificate, key)) => {
                let chain = certificate.certificates()?;
                let secret = PrivateKeyDer::from_pem_slice(&key.read(MOST_BYTES_OF_PEM)?)
                    .map_err(|error| key.bad(error.to_string()))?;
                builder.with_client_auth_cert(chain, secret).map_err(|error| key.bad(error.to_string()))?
            }
        };
        config.alpn_protocols = vec![b"h2".to_vec()];
        Ok(Arc::new(config))
    }

    fn roots(&self) -> Result<RootCertStore, Error> {
        let mut roots = RootCertStore::empty();
        let Some(file) = &self.authorities else {
            roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
            return Ok(roots);
        };
        for authority in file.certificates()? {
            roots.add(authority).map_err(|error| file.bad(error.to_string()))?;
        }
        Ok(roots)
    }
}

impl Named {
    fn token(&self) -> Result<Token, Error> {
        let bytes = self.read(MOST_BYTES_OF_TOKEN)?;
        let not_text = |_| self.bad("is not a text in UTF-8; is it the right file?".to_owned());
        token(&self.place(), &String::from_utf8(bytes).map_err(not_text)?)
    }

    fn certificates(&self) -> Result<Vec<CertificateDer<'static>>, Error> {
        let bytes = self.read(MOST_BYTES_OF_PEM)?;
        let all = CertificateDer::pem_slice_iter(&bytes).collect::<Result<Vec<_>, _>>();
        let all = all.map_err(|error| self.bad(error.to_string()))?;
        if all.is_empty() {
            return Err(self.bad("has no certificate (-----BEGIN CERTIFICATE-----)".to_owned()));
        }
        Ok(all)
    }

    /// The content of the file, unless that is more than `most` bytes.
    fn read(&self, most: u64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let read = fs::File::open(&self.path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes));
        read.map_err(|error| self.bad(error.to_string()))?;
        if bytes.len() as u64 > most {
            return Err(self.bad(format!("has more than {most} bytes; is it the right file?")));
        }
        Ok(bytes)
    }

    fn bad(&self, problem: String) -> Error {
        bad(&self.place(), problem)
    }

    /// The credential's place, with what names it.
    fn place(&self) -> String {
        format!("{}{}", self.by, self.shown())
    }

    fn shown(&self) -> String {
        Printable(self.path.display()).to_string()
    }
}

fn token(place: &str, text: &str) -> Result<Token, Error> {
    text.trim().parse().map_err(|error: BadToken| bad(place, error.to_string()))
}

fn bad(place: &str, problem: String) -> Error {
    Error::Credentials { place: place.to_owned(), problem }
}

const TOKEN: &str = "BAUDBOT_TOKEN";
const TOKEN_FILE: &str = "BAUDBOT_TOKEN_FILE";
const CA: &str = "BAUDBOT_CA";
const CERTIFICATE: &str = "BAUDBOT_CERTIFICATE";
const KEY: &str = "BAUDBOT_KEY";

/// The longest file with a token that is read. A token has 51 bytes.
const MOST_BYTES_OF_TOKEN: u64 = 4096;

/// The longest file with certificates or a key that is read.
const MOST_BYTES_OF_PEM: u64 = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    fn from(variables: &[(&str, &str)]) -> Result<Credentials, Error> {
        let value = |name: &str| variables.iter().find(|(other, _)| *other == name).map(|(_, value)| value);
        Credentials::from_variables(|name| value(name).map(OsString::from))
    }

    #[test]
    fn a_variable_that_is_empty_is_as_one_that_is_not_set() {
        let none = from(&[(TOKEN, ""), (TOKEN_FILE, ""), (CA, ""), (CERTIFICATE, ""), (KEY, "")]).unwrap();
        assert!(none.token.is_none() && none.authorities.is_none() && none.own.is_none(), "{none:?}");
        let error = from(&[(TOKEN, ""), (TOKEN_FILE, "/none/token")]).unwrap_err().to_string();
        assert!(error.starts_with("BAUDBOT_TOKEN_FILE=/none/token: No such file"), "{error}");
        let error = from(&[(CERTIFICATE, "a.pem"), (KEY, "")]).unwrap_err().to_string();
        assert_eq!(error, "BAUDBOT_CERTIFICATE: needs its key, in BAUDBOT_KEY");
    }

    #[test]
    fn a_file_is_named_with_its_option_or_its_variable() {
        let error = Credentials::default().token_file(Path::new("/none/token")).unwrap_err().to_string();
        assert!(error.starts_with("--token-file /none/token: No such file"), "{error}");
        let error = Credentials::default().authorities("/none/ca.pem").tls().unwrap_err().to_string();
        assert!(error.starts_with("--ca /none/ca.pem: No such file"), "{error}");
        let error = from(&[(CA, "/none/ca.pem")]).unwrap().tls().unwrap_err().to_string();
        assert!(error.starts_with("BAUDBOT_CA=/none/ca.pem: No such file"), "{error}");
    }

    #[test]
    fn a_file_that_does_not_end_is_not_read_to_its_end() {
        let endless = Path::new("/dev/zero");
        let error = Credentials::default().token_file(endless).unwrap_err().to_string();
        assert_eq!(error, "--token-file /dev/zero: has more than 4096 bytes; is it the right file?");
        let error = Credentials::default().authorities(endless).tls().unwrap_err().to_string();
        assert_eq!(error, "--ca /dev/zero: has more than 1048576 bytes; is it the right file?");
    }
}
