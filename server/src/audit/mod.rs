//! The audit log: who did what, when, and with what result.
//!
//! # Need
//!
//! When a world is gone, or a robot was driven by another user, its owner wants to know who that was. The log for
//! operators has what happens in worlds; this one has the callers, on lines of JSON that programs read.
//!
//! # What is in it
//!
//! Each call that changes something, drives a robot or trains, and each call that was refused, whatever it asked for. Calls that
//! only look are left out, as a page makes them each second. A call that lasts, such as a brain's, has a line when it begins and one
//! when it ends.
//!
//! # Mechanism
//!
//! The [`gate`](crate::gate) begins a [`Record`] for each call and ends it with the response. The services say which
//! world it is about, by looking the world up ([`call::note_world`]). A [thread](file) writes the lines: a slow disk
//! delays no call.

mod body;
pub(crate) mod call;
mod file;
mod record;

pub use file::AuditLog;

pub(crate) use body::Audited;
pub(crate) use record::Record;
