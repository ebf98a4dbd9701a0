//! The callers that may reach a server, by its builder's settings.

use std::time::SystemTime;

use baudbot_access::{Grant, Token, TokenFile, Watched};

use super::ServerError;
use crate::access::Access;
use crate::address::Address;
use crate::clock;
use crate::gate::Tls;

/// The callers that may reach a server.
#[derive(Default)]
pub(super) struct AccessConfig {
    pub(super) tokens: Option<TokenFile>,
    /// The token of the user's own programs.
    pub(super) local: Option<Token>,
    pub(super) tls: Option<Tls>,
    pub(super) behind_proxy: bool,
    pub(super) hosts: Vec<String>,
}

impl AccessConfig {
    /// The tokens in effect.
    ///
    /// # Errors
    /// If their file cannot be read.
    pub(super) fn start(&self) -> Result<Access, ServerError> {
        if self.tokens.is_none() && self.local.is_none() {
            return Ok(Access::open());
        }
        let own = self.local.iter().map(|token| Grant::local(token.hash(), SystemTime::now())).collect();
        Ok(Access::by(Watched::open(self.tokens.clone(), own, clock::now())?))
    }

    /// Whether this address may be listened on.
    ///
    /// # Errors
    /// If other machines can reach it, and there are no tokens, or nothing that encrypts them.
    pub(super) fn allows(&self, address: &Address) -> Result<(), ServerError> {
        if address.is_local() || (self.tokens.is_some() && (self.tls.is_some() || self.behind_proxy)) {
            return Ok(());
        }
        Err(ServerError::NotLoopback { address: address.clone() })
    }
}
