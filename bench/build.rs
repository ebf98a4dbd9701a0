//! Compiles the ping-pong's contract with protox, as `proto/build.rs` does that of baudbot.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    tonic_prost_build::configure().compile_fds(protox::compile(["ping.proto"], ["proto"])?)?;
    println!("cargo:rerun-if-changed=proto/ping.proto");
    Ok(())
}
