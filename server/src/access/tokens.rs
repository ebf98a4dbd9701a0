//! The tokens of a server: the caller of each call, and its rights.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use baudbot_access::{Need, News, Refused, Tokens, Watched, bearer, needs_at};
use tokio::sync::watch;
use tonic::codegen::http;
use tonic::{Code, Status};

use super::Caller;
use crate::clock;

/// The tokens that a server knows. Clones share them.
#[derive(Clone)]
pub(crate) struct Access(Option<Arc<Shared>>);

struct Shared {
    watched: Watched,
    /// The sender of the signal that grants may have changed.
    changes: watch::Sender<()>,
}

impl Access {
    /// Everybody who reaches the server may do everything.
    pub(crate) fn open() -> Self {
        Self(None)
    }

    /// The holders of these tokens.
    pub(crate) fn by(watched: Watched) -> Self {
        Self(Some(Arc::new(Shared { watched, changes: watch::Sender::new(()) })))
    }

    /// Whether everybody may do everything.
    pub(crate) fn is_open(&self) -> bool {
        self.0.is_none()
    }

    /// The caller with this `authorization` header.
    ///
    /// # Errors
    /// If it shows no token, or one that is not valid.
    pub(crate) fn caller(&self, authorization: Option<&str>) -> Result<Caller, Refused> {
        let Some(shared) = &self.0 else { return Ok(Caller::Trusted) };
        let tokens = shared.tokens();
        Ok(Caller::Holder(Arc::clone(tokens.authenticate(bearer(authorization)?, SystemTime::now())?)))
    }

    /// The same caller as it is now: its token may have been revoked, or have other rights.
    ///
    /// # Errors
    /// If it is not valid any more.
    pub(crate) fn still(&self, caller: &Caller) -> Result<Caller, Refused> {
        match (&self.0, caller) {
            (None, _) | (_, Caller::Trusted | Caller::Nobody) => Ok(caller.clone()),
            (Some(shared), Caller::Holder(grant)) => {
                Ok(Caller::Holder(Arc::clone(shared.tokens().still(&grant.hash, SystemTime::now())?)))
            }
        }
    }

    /// Checks a call by its path. `known` is its caller, if that is clear from where it came.
    ///
    /// # Errors
    /// `UNAUTHENTICATED` if the caller is not known, `PERMISSION_DENIED` if it may not do this, `UNIMPLEMENTED` if there is no such
    /// call.
    pub(crate) fn check(
        &self,
        path: &str,
        known: Option<&Caller>,
        headers: &http::HeaderMap,
    ) -> Result<Caller, Status> {
        let Some(need) = needs_at(path) else { return Err(Status::new(Code::Unimplemented, "")) };
        let caller = match (need, known) {
            (Need::Nothing, _) => return Ok(known.cloned().unwrap_or(Caller::Nobody)),
            (_, Some(known)) => self.still(known),
            (_, None) => self.caller(authorization(headers)),
        };
        let caller = caller.map_err(|refused| Status::unauthenticated(refused.to_string()))?;
        if let Caller::Holder(grant) = &caller {
            grant.may(need).map_err(|denied| Status::permission_denied(denied.to_string()))?;
        }
        Ok(caller)
    }

    /// The channel of the signal that grants may have changed.
    pub(super) fn changes(&self) -> Option<watch::Receiver<()>> {
        self.0.as_ref().map(|shared| shared.changes.subscribe())
    }

    /// Reads the tokens' file each second if it has changed, so that streams end whose tokens do.
    pub(crate) async fn renew(self) {
        let Some(shared) = &self.0 else { return };
        let mut generation = shared.tokens().generation();
        loop {
            tokio::time::sleep(EACH).await;
            let tokens = shared.tokens();
            if tokens.generation() != generation {
                generation = tokens.generation();
                shared.changes.send_replace(());
            }
        }
    }
}

impl Shared {
    fn tokens(&self) -> Arc<Tokens> {
        let (tokens, news) = self.watched.current(clock::now());
        if let Some(news) = news {
            match news {
                News::Changed { tokens } => tracing::info!(tokens, "the token file has changed"),
                News::Unreadable(error) => {
                    tracing::warn!(%error, "the token file cannot be read; unless it can be within two seconds, its tokens are refused");
                }
                News::Refused(error) => {
                    tracing::error!(%error, "the token file cannot be read: its tokens are refused until it can be");
                }
            }
        }
        tokens
    }
}

/// The header by which a caller shows its token.
pub(crate) fn authorization(headers: &http::HeaderMap) -> Option<&str> {
    headers.get(http::header::AUTHORIZATION)?.to_str().ok()
}

/// The interval at which the file is looked at. A call with a token that is revoked is refused after so long, and a
/// stream ends after twice as long at most, if a call has just looked.
const EACH: Duration = Duration::from_secs(1);
