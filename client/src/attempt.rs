//! The reasons why a connection fails, in words that name the remedy.

use std::error::Error as StdError;
use std::io;
use std::time::Duration;

use tokio_rustls::rustls::{self, AlertDescription, CertificateError};

use crate::credentials::Credentials;
use crate::error::{Error, tls_error};
use crate::place::Place;

/// An attempt to connect.
pub(crate) struct Attempt<'a> {
    /// The address as it was given.
    pub(crate) address: &'a str,
    pub(crate) place: &'a Place,
    pub(crate) credentials: &'a Credentials,
}

impl Attempt<'_> {
    /// The error of a connection that failed so.
    pub(crate) fn error(&self, error: &(dyn StdError + 'static)) -> Error {
        let address = self.address.to_owned();
        let io = error.downcast_ref::<io::Error>();
        let tls = io.and_then(tls_error);
        if let Some(rustls::Error::InvalidCertificate(problem)) = tls {
            return Error::ServerCertificate { address, problem: self.of_server(problem) };
        }
        if let Some(rustls::Error::AlertReceived(alert)) = tls
            && is_of_client(*alert)
        {
            return Error::ClientCertificate { address, problem: self.of_client() };
        }
        if tls == Some(&rustls::Error::InvalidMessage(rustls::InvalidMessage::InvalidContentType)) {
            return Error::Connect { address, cause: NO_TLS.to_owned() };
        }
        // Some servers send nothing about a certificate, but close the connection, or have no better alert for it.
        let is_refused =
            tls == Some(&rustls::Error::AlertReceived(AlertDescription::HandshakeFailure)) || hung_up(io);
        let remedy = if is_refused { self.perhaps() } else { String::new() };
        Error::Connect { address, cause: format!("{error}{remedy}") }
    }

    /// The error of a connection over which nothing has come for so long.
    pub(crate) fn silence(&self, patience: Duration) -> Error {
        let words = "a program accepts connections there, but has not answered for";
        let cause = format!("{words} {patience:?}{}", self.perhaps());
        Error::Connect { address: self.address.to_owned(), cause }
    }

    /// The words for a defect of the server's certificate.
    fn of_server(&self, problem: &CertificateError) -> String {
        // Another authority of the same name has another key.
        if matches!(problem, CertificateError::UnknownIssuer | CertificateError::BadSignature) {
            return match self.credentials.authorities_file() {
                None => "is not trusted: name the authority that signed it with --ca FILE or BAUDBOT_CA"
                    .to_owned(),
                Some(file) => format!(
                    "is not trusted: the authority in {file} has not signed it; name the one that has with --ca FILE or BAUDBOT_CA"
                ),
            };
        }
        if matches!(problem, CertificateError::Expired | CertificateError::ExpiredContext { .. }) {
            return "has expired: the server needs a new one".to_owned();
        }
        if matches!(problem, CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. }) {
            return "is not valid yet: is the clock of this machine right?".to_owned();
        }
        let is_of_another = matches!(
            problem,
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. }
        );
        match self.place {
            Place::Tls(_, name) if is_of_another => format!(
                "is not valid for the name `{}`: connect by a name that it has, or give the server one for this name",
                name.to_str()
            ),
            Place::Tls(..) | Place::Tcp(_) | Place::Unix(_) => format!("cannot be trusted ({problem})"),
        }
    }

    /// The demand of a server that does not take the client certificate which it was shown.
    fn of_client(&self) -> String {
        match self.credentials.certificate_file() {
            None => "asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY".to_owned(),
            Some(file) => format!(
                "does not accept the client certificate in {file}: it may have expired, or the server does not trust the authority that signed it"
            ),
        }
    }

    /// A possible reason for a server's silence.
    fn perhaps(&self) -> String {
        if !self.place.is_encrypted() {
            return String::new();
        }
        match self.credentials.certificate_file() {
            None => {
                "; a server there may ask for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
                    .to_owned()
            }
            Some(file) => {
                format!(
                    "; a server there may not trust the authority that signed the client certificate in {file}"
                )
            }
        }
    }
}

/// Whether a server refuses the client certificate that it was shown, or misses one, by this alert.
fn is_of_client(alert: AlertDescription) -> bool {
    matches!(
        alert,
        AlertDescription::CertificateRequired
            | AlertDescription::NoCertificate
            | AlertDescription::BadCertificate
            | AlertDescription::UnsupportedCertificate
            | AlertDescription::CertificateRevoked
            | AlertDescription::CertificateExpired
            | AlertDescription::CertificateUnknown
            | AlertDescription::UnknownCA
            | AlertDescription::AccessDenied
            | AlertDescription::DecryptError
    )
}

/// Whether a connection that was accepted was closed.
fn hung_up(error: Option<&io::Error>) -> bool {
    error.is_some_and(|error| {
        matches!(
            error.kind(),
            io::ErrorKind::UnexpectedEof
                | io::ErrorKind::ConnectionReset
                | io::ErrorKind::ConnectionAborted
                | io::ErrorKind::BrokenPipe
        )
    })
}

/// The remedy for `https://` in front of an address without TLS.
const NO_TLS: &str = "the program that listens there does not use TLS; write the address without https://";

#[cfg(test)]
mod tests {
    use super::*;

    fn text(address: &str, credentials: &Credentials, told: impl Fn(&Attempt<'_>) -> Error) -> String {
        let place = Place::of(address).unwrap();
        told(&Attempt { address, place: &place, credentials }).to_string()
    }

    fn tls(error: rustls::Error) -> io::Error {
        io::Error::new(io::ErrorKind::InvalidData, error)
    }

    #[test]
    fn what_is_wrong_with_a_servers_certificate_is_told_with_the_remedy() {
        let ours = Credentials::default().authorities("lab/ca.pem");
        for (problem, credentials, expected) in [
            (
                CertificateError::UnknownIssuer,
                &Credentials::default(),
                "is not trusted: name the authority that signed it with --ca FILE or BAUDBOT_CA",
            ),
            (
                CertificateError::BadSignature,
                &ours,
                "is not trusted: the authority in lab/ca.pem has not signed it; name the one that has with --ca FILE or BAUDBOT_CA",
            ),
            (CertificateError::Expired, &ours, "has expired: the server needs a new one"),
            (CertificateError::NotValidYet, &ours, "is not valid yet: is the clock of this machine right?"),
            (
                CertificateError::NotValidForName,
                &ours,
                "is not valid for the name `robots.lab`: connect by a name that it has, or give the server one for this name",
            ),
            (CertificateError::Revoked, &ours, "cannot be trusted (Revoked)"),
        ] {
            let error = tls(rustls::Error::InvalidCertificate(problem.clone()));
            let told = text("https://robots.lab:7400", credentials, |attempt| attempt.error(&error));
            let start = "the certificate of the server at https://robots.lab:7400 ";
            assert_eq!(told.strip_prefix(start), Some(expected), "{told}");
        }
    }

    #[test]
    fn a_client_certificate_that_is_wanted_is_named() {
        let (none, own) = (Credentials::default(), Credentials::default().certificate("a.pem", "b.pem"));
        let address = "https://robots.lab:7400";
        for alert in [AlertDescription::CertificateRequired, AlertDescription::UnknownCA] {
            let error = tls(rustls::Error::AlertReceived(alert));
            let told = text(address, &none, |attempt| attempt.error(&error));
            let wanted = "asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY";
            assert_eq!(told, format!("the server at {address} {wanted}"));
            let told = text(address, &own, |attempt| attempt.error(&error));
            assert!(
                told.contains("does not accept the client certificate in a.pem: it may have expired"),
                "{told}"
            );
        }
        for error in [
            tls(rustls::Error::AlertReceived(AlertDescription::HandshakeFailure)),
            io::ErrorKind::ConnectionReset.into(),
            io::ErrorKind::UnexpectedEof.into(),
        ] {
            let told = text(address, &none, |attempt| attempt.error(&error));
            assert!(told.contains("; a server there may ask for a client certificate: set"), "{told}");
            let told = text("robots.lab:7400", &none, |attempt| attempt.error(&error));
            assert!(!told.contains("client certificate"), "{told}");
        }
        let refused = io::Error::from(io::ErrorKind::ConnectionRefused);
        let told = text(address, &none, |attempt| attempt.error(&refused));
        assert!(!told.contains("client certificate"), "{told}");
    }

    #[test]
    fn silence_may_be_for_want_of_a_certificate() {
        let told = |address, credentials| {
            text(address, credentials, |attempt| attempt.silence(Duration::from_secs(5)))
        };
        let words = "a program accepts connections there, but has not answered for 5s";
        let (none, own) = (Credentials::default(), Credentials::default().certificate("a.pem", "b.pem"));
        assert!(told("robots.lab:7400", &none).contains(&format!("({words})")));
        let wanted =
            "a server there may ask for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY";
        assert!(told("https://robots.lab:7400", &none).contains(&format!("({words}; {wanted})")));
        let unknown =
            "a server there may not trust the authority that signed the client certificate in a.pem";
        assert!(told("https://robots.lab:7400", &own).contains(&format!("({words}; {unknown})")));
    }
}
