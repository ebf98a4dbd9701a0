//! Runs as files: what is recorded is done again, and no file asks for memory that it does not need.

// The hostile files of this module are packed ones.
#[cfg(feature = "lz4")]
mod memory;
mod replay;
