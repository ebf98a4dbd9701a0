//! The rights of a server's callers: tokens, and the files that they are kept in.
//!
//! There is no network here. A server asks, and the command line writes:
//!
//! - [`Token`] is the secret that a client shows, [`TokenHash`] what a server knows of it.
//! - [`Right`] is what a token is good for, [`Need`] what a call asks for; [`needs`] has all calls, in one table.
//! - [`Grant`] is a token's name with its rights and its end; [`Tokens`] are the grants in effect, and find that of a caller.
//! - [`TokenFile`] keeps grants in a file, [`Watched`] reads it anew when it changes.
//! - [`local`] is the token of the user who runs the server, for programs of the same user on the same machine.
//! - [`peer`] says whether a connection on this machine is from a program of the same user, for doors that know no tokens.
//! - `certificates`, with the feature of that name, makes a certificate authority and its certificates.
//!
//! Clients need tokens and [`local`] only; all the rest is the feature `grants`. What is kept in files is the feature `files`. Both are
//! defaults.
//!
//! A server has one [`Watched`], and does this for each call:
//!
//! ```
//! # use std::time::{Instant, SystemTime};
//! # use baudbot_access::{Denied, Grant, Need, Refused, Right, Token, Watched, bearer, needs_at};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let token = Token::random()?;
//! # let own = Grant::local(token.hash(), SystemTime::now());
//! # let header = format!("Bearer {}", token.reveal());
//! # let header = Some(header.as_str());
//! let watched = Watched::open(None, vec![own], Instant::now())?;
//!
//! let need = needs_at("/baudbot.v1.ControlService/ListWorlds").expect("otherwise UNIMPLEMENTED");
//! if need != Need::Nothing {
//!     let (tokens, news) = watched.current(Instant::now()); // news: for the log
//!     let now = SystemTime::now();
//!     let grant = tokens.authenticate(bearer(header)?, now)?; // otherwise UNAUTHENTICATED
//!     grant.may(need)?; // otherwise PERMISSION_DENIED
//!     // Once a brain has said which robot it is for:
//!     grant.may_drive("wander", "alice")?;
//!     // And for as long as a stream is open, whenever `tokens.generation()` is another one, and at `expires_at`:
//!     tokens.still(&grant.hash, now)?.may(need)?;
//! }
//! # Ok(())
//! # }
//! ```

#[cfg(feature = "certificates")]
pub mod certificates;
#[cfg(feature = "grants")]
pub mod date;
#[cfg(all(feature = "files", feature = "grants"))]
mod file;
#[cfg(feature = "grants")]
mod grant;
#[cfg(feature = "grants")]
mod lifetime;
#[cfg(feature = "files")]
pub mod local;
#[cfg(all(feature = "files", feature = "grants"))]
mod lock;
#[cfg(feature = "grants")]
mod need;
#[cfg(feature = "grants")]
mod pattern;
#[cfg(feature = "files")]
pub mod peer;
#[cfg(feature = "files")]
mod private;
#[cfg(feature = "grants")]
mod right;
mod token;
#[cfg(feature = "grants")]
mod tokens;
#[cfg(all(feature = "files", feature = "grants"))]
mod watched;

#[cfg(all(feature = "files", feature = "grants"))]
pub use file::{FileError, NewGrant, TokenFile};
#[cfg(feature = "grants")]
pub use grant::{BadName, Denied, Grant, GrantName};
#[cfg(feature = "grants")]
pub use lifetime::{BadLifetime, Lifetime};
#[cfg(feature = "grants")]
pub use need::{Door, Need, RPCS, Service, needs, needs_at};
#[cfg(feature = "grants")]
pub use pattern::{BadPattern, DrivePattern, Half, PatternProblem};
#[cfg(feature = "files")]
pub use private::{PrivateError, private_folder};
#[cfg(feature = "grants")]
pub use right::{BadRight, Right};
pub use token::{BadHash, BadToken, NoRandomness, PREFIX, Token, TokenHash};
#[cfg(feature = "grants")]
pub use tokens::{Refused, Tokens, bearer};
#[cfg(all(feature = "files", feature = "grants"))]
pub use watched::{News, Watched};
