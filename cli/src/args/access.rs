//! The callers that may reach the server of a command, and their tokens.

use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Context;
use baudbot_access::{Token, TokenFile};
use baudbot_server::{AuditLog, Builder, Tls, TlsError};
use clap::Args;

use super::value::ValueError;
use crate::error::Refused;

#[derive(Debug, Args)]
#[command(next_help_heading = super::ACCESS)]
pub(crate) struct AccessArgs {
    /// Give every user of this machine all rights, without a token
    ///
    /// By default, the token for your own programs is in a file that only you can read, and that baudbot's clients read automatically.
    /// Other users need --tokens (docs/reference/trust.md).
    #[arg(long)]
    pub(crate) open: bool,
    /// Admit clients with a token from this file, with the token's rights (`baudbot token`)
    #[arg(long, value_name = "FILE", conflicts_with = "open")]
    pub(crate) tokens: Option<PathBuf>,
    /// Encrypt connections with this certificate and its key, both in PEM (`baudbot cert`)
    #[arg(long, value_name = "CERTIFICATE,KEY")]
    pub(crate) tls: Option<TlsFiles>,
    /// Admit only clients with a certificate from one of these authorities, in PEM
    #[arg(long, value_name = "FILE", requires = "tls")]
    pub(crate) client_ca: Option<PathBuf>,
    /// Accept connections without TLS from other machines, because a proxy in front of the server encrypts
    #[arg(long, requires = "tokens")]
    pub(crate) behind_proxy: bool,
    /// Append an audit log to this file, in JSON lines: calls that change something, drive a robot or train, and refused calls
    #[arg(long, value_name = "FILE")]
    pub(crate) audit: Option<PathBuf>,
    /// A host name by which browsers reach the page, besides localhost and the page's address
    #[arg(long, value_name = "NAME")]
    pub(crate) host: Vec<HostName>,
}

/// A name, or an address without a port, under which browsers reach a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct HostName(String);

impl FromStr for HostName {
    type Err = ValueError;

    fn from_str(text: &str) -> Result<Self, ValueError> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
        let is_name = (1..=253).contains(&text.len()) && text.chars().all(fits);
        if is_name || text.parse::<IpAddr>().is_ok() {
            return Ok(Self(text.to_owned()));
        }
        Err(ValueError::Form(
            "must be a name such as robots.lab, or an address, without https:// and without a port",
        ))
    }
}

/// A certificate and its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TlsFiles {
    certificate: PathBuf,
    key: PathBuf,
}

impl FromStr for TlsFiles {
    type Err = ValueError;

    fn from_str(text: &str) -> Result<Self, ValueError> {
        match text.split_once(',') {
            Some((certificate, key)) if !certificate.is_empty() && !key.is_empty() => {
                Ok(Self { certificate: certificate.into(), key: key.into() })
            }
            Some(_) | None => Err(ValueError::Form("must be two files, as in server.pem,server.key")),
        }
    }
}

impl AccessArgs {
    /// An option that was given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let options = [
            (self.open, "--open"),
            (self.tokens.is_some(), "--tokens"),
            (self.tls.is_some(), "--tls"),
            (self.audit.is_some(), "--audit"),
            (!self.host.is_empty(), "--host"),
        ];
        options.into_iter().find(|(is_given, _)| *is_given).map(|(_, option)| option)
    }

    /// A server that lets these connect.
    ///
    /// # Errors
    /// If a certificate or a key cannot be used.
    pub(crate) fn guard(&self, mut builder: Builder) -> anyhow::Result<Builder> {
        if let Some(TlsFiles { certificate, key }) = &self.tls {
            let tls = Tls::read(certificate, key, self.client_ca.as_deref());
            let refused = |error: TlsError| {
                let of_clients = self.client_ca.as_deref().is_some_and(|file| error.concerns(file));
                let option = if of_clients { "--client-ca" } else { "--tls" };
                Refused::error(format!("{option}: {error}"))
            };
            builder = builder.tls(tls.map_err(refused)?);
        }
        if let Some(file) = &self.tokens {
            builder = builder.tokens(TokenFile::at(file));
        }
        if !self.open {
            builder = builder.local_token(Token::random().context("no token can be made")?);
        }
        if let Some(file) = &self.audit {
            let log = AuditLog::open(file);
            let refused = |error| Refused::error(format!("--audit {}: {error}", file.display()));
            builder = builder.audit(log.map_err(refused)?);
        }
        builder = builder.behind_proxy(self.behind_proxy);
        Ok(self.host.iter().fold(builder, |builder, HostName(name)| builder.host(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::HostName;

    #[test]
    fn hosts_are_names_and_addresses() {
        for host in ["robots.lab", "localhost", "192.0.2.7", "2001:db8::1"] {
            assert!(host.parse::<HostName>().is_ok(), "{host}");
        }
        for bad in ["", "*", "a b", "robots.lab:7401", "https://robots.lab/", "[::1]:80"] {
            assert!(bad.parse::<HostName>().unwrap_err().to_string().contains("without a port"), "{bad}");
        }
    }
}
