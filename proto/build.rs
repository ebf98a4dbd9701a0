//! Compiles the contract with protox, which is Rust: a fresh machine needs no `protoc`.

use std::error::Error;
use std::path::PathBuf;

use prost::Message;

const FILES: [&str; 7] = [
    "baudbot/v1/world.proto",
    "baudbot/v1/budget.proto",
    "baudbot/v1/control.proto",
    "baudbot/v1/brain_link.proto",
    "baudbot/v1/observe.proto",
    "baudbot/v1/page.proto",
    "baudbot/v1/recording.proto",
];

fn main() -> Result<(), Box<dyn Error>> {
    let descriptors = protox::compile(FILES, ["."])?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    std::fs::write(out.join("descriptors.bin"), descriptors.encode_to_vec())?;
    tonic_prost_build::configure().compile_fds(descriptors)?;
    for file in FILES {
        println!("cargo:rerun-if-changed={file}");
    }
    Ok(())
}
