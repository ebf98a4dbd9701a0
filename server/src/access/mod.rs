//! The gate of all calls: each, of whatever service, is checked by the tokens here, and nowhere else.
//!
//! # Need
//!
//! Many people use a server: one of them must not drive the robot of another, see what a brain is not to see, or delete worlds.
//!
//! # Assumptions
//!
//! A program with the rights of the user who runs the server can do anything to it anyway. So this process, through
//! pipes in memory, and this user, over Unix sockets, need no token; all others show one, over TCP also this user, as
//! the system does not say whose a TCP connection is.
//!
//! # Mechanism
//!
//! - [`Access`] finds the [`Caller`] of a call, and checks that it has what the call needs by the table of `baudbot-access`.
//!   The `gate` does that before any service, and leaves the caller in the call's extensions.
//! - A brain says which robots it is for in its first message, and a page asks over a socket: these ask the caller itself
//!   ([`Caller::may_drive`]).
//! - A stream is ended when its token is revoked, has expired or got other rights ([`Guarded`]).

#[cfg(feature = "network")]
mod stream;
#[cfg(feature = "network")]
mod tokens;

use std::sync::Arc;

use baudbot_access::{Grant, Need, Refused};
use tonic::{Request, Status};

#[cfg(feature = "network")]
pub(crate) use stream::Guarded;
#[cfg(feature = "network")]
pub(crate) use tokens::{Access, authorization};

/// The caller of a call.
#[derive(Clone, Debug)]
pub(crate) enum Caller {
    /// A caller who may do everything.
    Trusted,
    /// The holder of a token.
    Holder(Arc<Grant>),
    /// A caller who was not asked for a token, as the call needs none.
    Nobody,
}

impl Caller {
    /// Whether it may drive this robot.
    ///
    /// # Errors
    /// `PERMISSION_DENIED`, whether there is such a robot or not.
    pub(crate) fn may_drive(&self, world: &str, robot: &str) -> Result<(), Status> {
        match self {
            Self::Trusted => Ok(()),
            Self::Holder(grant) => {
                grant.may_drive(world, robot).map_err(|denied| Status::permission_denied(denied.to_string()))
            }
            Self::Nobody => Err(Status::unauthenticated(Refused::Missing.to_string())),
        }
    }

    /// Whether it may see what is there, such as the names of worlds and robots.
    pub(crate) fn may_observe(&self) -> bool {
        match self {
            Self::Trusted => true,
            Self::Holder(grant) => grant.may(Need::Observe).is_ok(),
            Self::Nobody => false,
        }
    }

    /// The name of the caller, for logs.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Trusted => "this process",
            Self::Holder(grant) => grant.name.as_str(),
            Self::Nobody => "nobody",
        }
    }
}

/// The caller of a request that has been checked.
///
/// # Errors
/// `INTERNAL` if it has not been.
pub(crate) fn caller_of<T>(request: &Request<T>) -> Result<Caller, Status> {
    let caller = request.extensions().get().cloned();
    caller
        .ok_or_else(|| Status::internal("the call has come past the check of its caller; please report this"))
}
