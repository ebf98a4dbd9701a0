//! The reasons why there is no certificate.

use std::path::PathBuf;
use std::time::SystemTime;

use crate::date;
use crate::private::{PrivateError, shown};

/// A reason why there is no certificate, or no authority.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] PrivateError),
    /// Something is there already.
    #[error("{}: already exists; move it away, or choose another folder or name", shown(path))]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The file is no key.
    #[error("{}: is not a private key in PEM", shown(path))]
    Key {
        /// The file.
        path: PathBuf,
    },
    /// The file is not the certificate of an authority.
    #[error("{}: {problem} (the key is {})", shown(path), shown(key))]
    Certificate {
        /// The file.
        path: PathBuf,
        /// The file with the key.
        key: PathBuf,
        /// The defect of the certificate.
        problem: BadCertificate,
    },
    /// The certificate would be valid longer than the authority.
    #[error(
        "the certificate would be valid until {}, and its authority ends before, on {}; choose a shorter --expires, or make a new authority",
        date::print(*asked), date::print(*end)
    )]
    Outlives {
        /// The instant at which the certificate would end.
        asked: SystemTime,
        /// The instant at which the authority does.
        end: SystemTime,
    },
    /// A server has no name.
    #[error("a server needs a name or an address by which it is reached")]
    NoName,
    /// The files would be taken for those of the authority.
    #[error("`ca` is the name of the authority's files; choose another name")]
    Reserved,
    /// The certificate cannot be made.
    #[error("cannot make the certificate: {0}")]
    Make(#[from] rcgen::Error),
}

/// A defect of an authority's certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadCertificate {
    /// The text is no certificate.
    #[error("is not a certificate in PEM")]
    NotPem,
    /// The certificate is that of a server or client.
    #[error(
        "is not the certificate of an authority, so that it cannot sign others; make one with `baudbot cert ca`"
    )]
    NotAuthority,
    /// The certificate does not belong to the key.
    #[error("is not the certificate of this key; both must come from the same `baudbot cert ca`")]
    OtherKey,
}
