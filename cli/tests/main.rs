//! The program from outside, and worlds that outlive their server.

#![allow(clippy::wildcard_enum_match_arm, reason = "what a test does not expect makes it fail")]

// The modules test all that a program can have.
#[cfg(feature = "full")]
mod cli;
mod state;
