//! Certificates for servers and clients, from an authority of one's own.
//!
//! A laboratory makes an authority once, and with it a certificate for each server and, if clients are to prove who they are
//! without tokens, for each client. All of them are X.509 with keys on the curve P-256, which browsers accept, too. In a folder they
//! are
//!
//! - `ca.pem`, the authority's certificate, which clients are given: it is no secret;
//! - `ca-key.pem`, its key, of mode 0600: who has it can make a certificate for any name;
//! - `NAME.pem` and `NAME-key.pem` of each server and client, with the key of mode 0600.
//!
//! Nothing is overwritten.

mod error;
mod host;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer,
    KeyPair, KeyUsagePurpose, PublicKeyData, SanType,
};
use x509_parser::prelude::{FromDer, Pem, X509Certificate};

pub use error::{BadCertificate, CertificateError};
pub use host::{BadHost, Host};

use crate::date;
use crate::grant::GrantName;
use crate::lifetime::Lifetime;
use crate::private;

/// A certificate authority with its key.
#[derive(Debug)]
pub struct Authority {
    issuer: Issuer<'static, KeyPair>,
    certificate: String,
    ends_at: SystemTime,
}

/// Whom a certificate is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// A server that is reached by these names.
    Server(Vec<Host>),
    /// A client of this name.
    Client(GrantName),
}

/// A certificate with its key, as PEM.
pub struct Issued {
    /// The certificate, without that of the authority.
    pub certificate: String,
    /// The key, which is secret.
    pub key: String,
    /// The instant at which it ends.
    pub ends_at: SystemTime,
}

/// The paths of a certificate and its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    /// The certificate.
    pub certificate: PathBuf,
    /// The key.
    pub key: PathBuf,
}

/// Clocks of robots and small computers are often wrong. A certificate is valid so much before it is made.
const BEFORE: Duration = Duration::from_secs(24 * 60 * 60);

/// Bytes of the longest file of a certificate or key that is read.
const MOST_BYTES: u64 = 1 << 20;

impl Authority {
    /// A new authority of this name, which people see in their browsers.
    ///
    /// # Errors
    /// If the system gives no random numbers.
    pub fn new(name: &GrantName, validity: Lifetime, now: SystemTime) -> Result<Self, CertificateError> {
        let key = KeyPair::generate()?;
        let (mut params, ends_at) = blank(name.as_str(), validity, now);
        // The authority signs certificates of servers and clients, and no further authorities.
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        let certificate = params.self_signed(&key)?.pem();
        Ok(Self { issuer: Issuer::new(params, key), certificate, ends_at })
    }

    /// Loads the authority of a folder.
    ///
    /// # Errors
    /// If its files cannot be read, others can read its key, the certificate is not that of an authority, or the key is another's.
    pub fn load(folder: &Path) -> Result<Self, CertificateError> {
        let Paths { certificate: path, key: key_path } = Paths::of(folder, "ca");
        let (key, _) = private::read(&key_path, MOST_BYTES)?;
        let key = KeyPair::from_pem(&key).map_err(|_| CertificateError::Key { path: key_path.clone() })?;
        let certificate = private::read_public(&path, MOST_BYTES)?;
        let ends_at = inspect(&certificate, &key).map_err(|problem| CertificateError::Certificate {
            path: path.clone(),
            key: key_path,
            problem,
        })?;
        let issuer = Issuer::from_ca_cert_pem(&certificate, key)?;
        Ok(Self { issuer, certificate, ends_at })
    }

    /// The authority's certificate, as PEM.
    pub fn certificate(&self) -> &str {
        &self.certificate
    }

    /// The instant at which it ends.
    pub fn ends_at(&self) -> SystemTime {
        self.ends_at
    }

    /// Writes it into a folder, which is made if it is not there.
    ///
    /// # Errors
    /// If there is an authority already, or the files cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Paths, CertificateError> {
        let paths = Paths::of(folder, "ca");
        paths.write(&self.certificate, &self.issuer.key().serialize_pem())?;
        Ok(paths)
    }

    /// A certificate with a new key.
    ///
    /// # Errors
    /// If it would last longer than the authority, or has no name.
    pub fn issue(
        &self,
        role: &Role,
        validity: Lifetime,
        now: SystemTime,
    ) -> Result<Issued, CertificateError> {
        let (mut params, ends_at) = blank(&role.stem(), validity, now);
        if ends_at > self.ends_at {
            return Err(CertificateError::Outlives { asked: ends_at, end: self.ends_at });
        }
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.use_authority_key_identifier_extension = true;
        params.extended_key_usages = vec![match role {
            Role::Server(_) => ExtendedKeyUsagePurpose::ServerAuth,
            Role::Client(_) => ExtendedKeyUsagePurpose::ClientAuth,
        }];
        match role {
            Role::Server(hosts) if hosts.is_empty() => return Err(CertificateError::NoName),
            Role::Server(hosts) => {
                params.subject_alt_names = hosts.iter().map(alternative).collect::<Result<_, _>>()?;
            }
            Role::Client(_) => {}
        }
        let key = KeyPair::generate()?;
        let certificate = params.signed_by(&key, &self.issuer)?.pem();
        Ok(Issued { certificate, key: key.serialize_pem(), ends_at })
    }
}

impl Role {
    /// The first name, which is also the name of the files.
    fn stem(&self) -> String {
        match self {
            Self::Server(hosts) => hosts.first().map(Host::stem).unwrap_or_default(),
            Self::Client(name) => name.to_string(),
        }
    }
}

impl Issued {
    /// Writes it into a folder, under its first name.
    ///
    /// # Errors
    /// If there are files of this name already, or they cannot be written.
    pub fn write(&self, folder: &Path, role: &Role) -> Result<Paths, CertificateError> {
        let stem = role.stem();
        if stem == "ca" {
            return Err(CertificateError::Reserved);
        }
        let paths = Paths::of(folder, &stem);
        paths.write(&self.certificate, &self.key)?;
        Ok(paths)
    }
}

impl Paths {
    fn of(folder: &Path, stem: &str) -> Self {
        let path = |end| folder.join(format!("{stem}{end}"));
        Self { certificate: path(".pem"), key: path("-key.pem") }
    }

    fn write(&self, certificate: &str, key: &str) -> Result<(), CertificateError> {
        private::make_folder_of(&self.key)?;
        for path in [&self.key, &self.certificate] {
            if path.symlink_metadata().is_ok() {
                return Err(CertificateError::Exists { path: path.clone() });
            }
        }
        private::create(&self.key, key, 0o600)?;
        Ok(private::create(&self.certificate, certificate, 0o644)?)
    }
}

/// A certificate of this name for this time, of which all else is still open, and when it ends.
fn blank(name: &str, validity: Lifetime, now: SystemTime) -> (CertificateParams, SystemTime) {
    let ends_at = date::whole(validity.after(now).unwrap_or(now));
    let begins_at = now.checked_sub(BEFORE).unwrap_or(UNIX_EPOCH);
    let mut subject = DistinguishedName::new();
    subject.push(DnType::CommonName, name);
    let mut params = CertificateParams::default();
    params.distinguished_name = subject;
    params.not_before = date::of(begins_at);
    params.not_after = date::of(ends_at);
    (params, ends_at)
}

fn alternative(host: &Host) -> Result<SanType, CertificateError> {
    Ok(match host {
        Host::Name(name) => SanType::DnsName(name.as_str().try_into()?),
        Host::Ip(ip) => SanType::IpAddress(*ip),
    })
}

/// The instant at which an authority's certificate ends, if it is one, and this is its key.
fn inspect(certificate: &str, key: &KeyPair) -> Result<SystemTime, BadCertificate> {
    let mut blocks = Pem::iter_from_buffer(certificate.as_bytes());
    let block = blocks.next().and_then(Result::ok).ok_or(BadCertificate::NotPem)?;
    if block.label != "CERTIFICATE" {
        return Err(BadCertificate::NotPem);
    }
    let (_, certificate) = X509Certificate::from_der(&block.contents).map_err(|_| BadCertificate::NotPem)?;
    if !certificate.is_ca() {
        return Err(BadCertificate::NotAuthority);
    }
    if certificate.public_key().raw != key.subject_public_key_info() {
        return Err(BadCertificate::OtherKey);
    }
    let ends_s = u64::try_from(certificate.validity().not_after.timestamp()).unwrap_or(0);
    Ok(date::whole(UNIX_EPOCH.checked_add(Duration::from_secs(ends_s)).unwrap_or(UNIX_EPOCH)))
}

#[cfg(test)]
mod tests;
