//! Makes `proto/src/generated` from `proto/baudbot/v1`: `cargo run -p baudbot-proto --example generate`.
//!
//! The generated code is committed, so that a build of baudbot compiles no compilers. The contract is compiled by protox, which
//! is Rust: no `protoc` is needed. The example is linked with what was generated before: if that does not compile, as after a
//! merge, `git checkout HEAD proto/src/generated` comes first.

use std::fs;
use std::path::Path;

use prost::Message;

const FILES: [&str; 8] = [
    "baudbot/v1/world.proto",
    "baudbot/v1/budget.proto",
    "baudbot/v1/control.proto",
    "baudbot/v1/brain_link.proto",
    "baudbot/v1/observe.proto",
    "baudbot/v1/page.proto",
    "baudbot/v1/recording.proto",
    "baudbot/v1/trainer.proto",
];

/// The folder of the generated code, from the package's folder.
const GENERATED: &str = "src/generated";
/// All messages and services, serialised: what reflection tells clients.
const DESCRIPTORS: &str = "descriptors.bin";
/// The same without comments and places in the files.
const TYPES: &str = "types.bin";

fn main() -> anyhow::Result<()> {
    generate(&package().join(GENERATED))
}

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Writes the code and the descriptors into a folder that is there.
fn generate(folder: &Path) -> anyhow::Result<()> {
    let descriptors = protox::compile(FILES, [package()])?;
    fs::write(folder.join(DESCRIPTORS), descriptors.encode_to_vec())?;
    let mut types = descriptors.clone();
    types.file.iter_mut().for_each(|file| file.source_code_info = None);
    fs::write(folder.join(TYPES), types.encode_to_vec())?;
    let services = r#"#[cfg(feature = "services")]"#;
    tonic_prost_build::configure()
        // Channels are made elsewhere; in a browser there are none.
        .build_transport(false)
        .client_mod_attribute("baudbot.v1", services)
        .server_mod_attribute("baudbot.v1", services)
        .out_dir(folder)
        .compile_fds(descriptors)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_committed_is_what_the_contract_makes() {
        let folder = tempfile::tempdir().unwrap();
        generate(folder.path()).unwrap();
        for file in ["baudbot.v1.rs", DESCRIPTORS, TYPES] {
            let [made, committed] =
                [folder.path(), &package().join(GENERATED)].map(|folder| folder.join(file));
            let is_same = fs::read(&made).unwrap() == fs::read(&committed).unwrap_or_default();
            assert!(is_same, "{} is old: cargo run -p baudbot-proto --example generate", committed.display());
        }
    }
}
