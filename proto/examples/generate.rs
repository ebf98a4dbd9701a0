//! Makes `proto/src/generated` from `proto/baudbot/v1`, and what `bench` needs for its ping-pong: `cargo run -p baudbot-proto
//! --example generate`.
//!
//! The generated code is committed, so that a build of baudbot compiles no compilers. The contract is compiled by protox, which
//! is Rust: no `protoc` is needed. The example is linked with what was generated before: if that does not compile, as after a
//! merge, `git checkout HEAD proto/src/generated` comes first.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use prost::Message;

/// A set of files and the code that is made of them.
struct Contract {
    /// The folder of the files, from the project's root.
    protos: &'static str,
    files: &'static [&'static str],
    /// The folder of the code, from the project's root.
    generated: &'static str,
    /// The names of the files that are written there.
    made: &'static [&'static str],
}

const CONTRACTS: [Contract; 2] = [
    Contract {
        protos: "proto",
        files: &[
            "baudbot/v1/world.proto",
            "baudbot/v1/budget.proto",
            "baudbot/v1/control.proto",
            "baudbot/v1/brain_link.proto",
            "baudbot/v1/observe.proto",
            "baudbot/v1/page.proto",
            "baudbot/v1/recording.proto",
            "baudbot/v1/trainer.proto",
        ],
        generated: "proto/src/generated",
        made: &["baudbot.v1.rs", DESCRIPTORS, TYPES],
    },
    Contract {
        protos: "crates/bench/proto",
        files: &["ping.proto"],
        generated: "crates/bench/src/network/generated",
        made: &["baudbot.bench.rs"],
    },
];

/// All messages and services, serialised: what reflection tells clients.
const DESCRIPTORS: &str = "descriptors.bin";
/// The same without comments and places in the files.
const TYPES: &str = "types.bin";

fn main() -> anyhow::Result<()> {
    CONTRACTS.iter().try_for_each(|contract| contract.generate(&root().join(contract.generated)))
}

/// The project's root.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

impl Contract {
    /// Writes what is made into a folder.
    fn generate(&self, folder: &Path) -> anyhow::Result<()> {
        let descriptors = protox::compile(self.files, [root().join(self.protos)])?;
        fs::create_dir_all(folder)?;
        if self.made.contains(&DESCRIPTORS) {
            fs::write(folder.join(DESCRIPTORS), descriptors.encode_to_vec())?;
            let mut types = descriptors.clone();
            types.file.iter_mut().for_each(|file| file.source_code_info = None);
            fs::write(folder.join(TYPES), types.encode_to_vec())?;
        }
        let services = r#"#[cfg(feature = "services")]"#;
        tonic_prost_build::configure()
            // Channels are made elsewhere; in a browser there are none.
            .build_transport(false)
            .client_mod_attribute("baudbot.v1", services)
            .server_mod_attribute("baudbot.v1", services)
            .out_dir(folder)
            .compile_fds(descriptors)
            .context(self.protos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_committed_is_what_the_contracts_make() {
        for contract in &CONTRACTS {
            let folder = tempfile::tempdir().unwrap();
            contract.generate(folder.path()).unwrap();
            for file in contract.made {
                let [made, committed] =
                    [folder.path(), &root().join(contract.generated)].map(|folder| folder.join(file));
                let is_same = fs::read(&made).unwrap() == fs::read(&committed).unwrap_or_default();
                assert!(
                    is_same,
                    "{} is old: cargo run -p baudbot-proto --example generate",
                    committed.display()
                );
            }
        }
    }
}
