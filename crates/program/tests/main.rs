//! Programs in simulated time, against the arithmetic of the toy world `wire`.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

mod harness;
mod instants;
mod limits;
mod looks;
// The example `simulated` has more machines.
#[allow(dead_code)]
mod wire;
