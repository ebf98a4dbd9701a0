//! The places of things: the root of the repository, the results of cargo.

use std::path::{Path, PathBuf};

/// The folders that sections work in. All paths are absolute.
pub(crate) struct Place {
    /// The root of the repository.
    pub(crate) root: PathBuf,
    /// Cargo's target folder.
    pub(crate) target: PathBuf,
    /// Nothing may be left out: it is a run of continuous integration.
    pub(crate) ci: bool,
}

impl Place {
    /// That of this checkout.
    pub(crate) fn new() -> Self {
        // A clone that was moved keeps what was built in it, so the folder is that of `cargo run`, and that of the build without it.
        let manifest = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
        let root = manifest.parent().unwrap_or(&manifest).to_owned();
        // This program lies in the target folder, wherever a user has that.
        let program = std::env::current_exe().unwrap_or_default();
        let debug = program.ancestors().find(|folder| folder.ends_with("debug")).and_then(Path::parent);
        let target = debug.map_or_else(|| root.join("target"), Path::to_owned);
        Self { root, target, ci: std::env::var_os("CI").is_some_and(|value| !value.is_empty()) }
    }

    /// The program of the profile in which tests are built, with all features.
    pub(crate) fn program(&self) -> PathBuf {
        self.target.join("debug/baudbot")
    }

    /// A folder for a section's own files, which is there and empty.
    ///
    /// # Errors
    ///
    /// The file system says no.
    pub(crate) fn scratch(&self, name: &str) -> std::io::Result<PathBuf> {
        let folder = self.target.join("tmp").join(name);
        match std::fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
            Ok(()) | Err(_) => {}
        }
        std::fs::create_dir_all(&folder)?;
        Ok(folder)
    }
}
