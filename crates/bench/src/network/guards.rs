//! A server that asks for a token and encrypts, and what its brains need.

use std::process::Command;
use std::time::SystemTime;

use baudbot_access::certificates::{Authority, Host, Role};
use baudbot_access::{NewGrant, Token, TokenFile};
use baudbot_server::{Builder, Tls};
use tempfile::TempDir;

use super::NetworkError;

/// A token for all robots, and a certificate.
pub(super) struct Guards {
    folder: TempDir,
    tls: Tls,
    file: TokenFile,
    token: Token,
}

impl Guards {
    pub(super) fn new() -> Result<Self, NetworkError> {
        Self::made().map_err(|error| NetworkError::Server(error.to_string()))
    }

    fn made() -> Result<Self, Box<dyn std::error::Error>> {
        let (now, folder) = (SystemTime::now(), tempfile::tempdir()?);
        let authority = Authority::new(&"bench".parse()?, "1d".parse()?, now)?;
        authority.write(folder.path())?;
        let role = Role::Server(vec!["127.0.0.1".parse::<Host>()?]);
        let paths = authority.issue(&role, "12h".parse()?, now)?.write(folder.path(), &role)?;
        let file = TokenFile::at(folder.path().join("tokens.toml"));
        let new = NewGrant { name: "brains".parse()?, rights: vec!["drive */*".parse()?], expires_at: None };
        let token = file.add(new, now)?;
        Ok(Self { tls: Tls::read(&paths.certificate, &paths.key, None)?, folder, file, token })
    }

    /// A server that is guarded so.
    pub(super) fn guard(&self, builder: Builder) -> Builder {
        builder.tls(self.tls.clone()).tokens(self.file.clone())
    }

    /// Gives the process with the brains its credentials.
    pub(super) fn give_to(&self, command: &mut Command) {
        command
            .env("BAUDBOT_CA", self.folder.path().join("ca.pem"))
            .env("BAUDBOT_TOKEN", self.token.reveal());
    }
}
