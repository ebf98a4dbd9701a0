//! Whether a brain keeps to the contract. A brain is a program in any language; all that is known of it is what it sends.
//!
//! 1. A [`Provocation`] is a run in which one thing happens to the brain: its sensors come in another order, its stream is lost, its world
//!    is reset. The world is a real one, on a server in this process.
//! 2. A `Relay` stands between the brain and that server. It lets pass what is said, makes the thing happen, and notes everything in a
//!    `Record`. What would end the stream, such as a second answer to a Turn, is noted and kept from the server, so that a run tells of
//!    one mistake and not of its consequences.
//! 3. A [`Case`] judges records: it has the sentence of the contract that it tests, and says that the brain does it, does not, or has no
//!    use for it.

mod aftermath;
mod case;
mod error;
mod evidence;
mod judge;
mod kit;
mod provocation;
mod record;
mod relay;
mod scene;
mod service;
mod spy;

pub use case::{CASES, Case};
pub use error::KitError;
pub use evidence::Verdict;
pub use kit::{Brain, Finding, NextRun, Progress, examine};
pub use provocation::Provocation;
