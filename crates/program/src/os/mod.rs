//! The glue to the system: the only folder with `unsafe` code, behind functions that are safe to call.

#[allow(unsafe_code)]
pub(crate) mod affinity;
#[allow(unsafe_code)]
pub(crate) mod clocks;
pub(crate) mod filter;
#[allow(unsafe_code)]
pub(crate) mod memory;
#[allow(unsafe_code)]
pub(crate) mod pipe;
pub(crate) mod proc;
#[allow(unsafe_code)]
pub(crate) mod spawn;
#[allow(unsafe_code)]
pub(crate) mod trace;
