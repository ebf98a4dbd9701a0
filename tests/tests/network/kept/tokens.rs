//! Tokens of a run: one stays, and one is revoked. Their file is a real one, which the server watches by the simulated clock.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use baudbot_access::{Token, TokenFile};

/// The file, and the two tokens that it began with.
pub(crate) struct Tokens {
    _folder: tempfile::TempDir,
    pub(crate) file: TokenFile,
    pub(crate) stays: String,
    pub(crate) goes: String,
    pub(crate) is_revoked: bool,
}

impl Tokens {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.toml");
        // The same ones each time: random ones have requests of other lengths.
        let [stays, goes] = ['s', 'g'].map(|letter| format!("baudbot_{}A", letter.to_string().repeat(42)));
        let entry = |name: &str, token: &str| {
            let hash = token.parse::<Token>().unwrap().hash();
            format!(
                "\n[[tokens]]\nname = \"{name}\"\nhash = \"{hash}\"\nrights = [\"operate\"]\ncreated_at = 2026-01-01T00:00:00Z\n"
            )
        };
        fs::write(&path, format!("version = 1\n{}{}", entry("stays", &stays), entry("goes", &goes))).unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        Self { _folder: folder, file: TokenFile::at(path), stays, goes, is_revoked: false }
    }

    pub(crate) fn path(&self) -> &Path {
        self.file.path()
    }

    pub(crate) fn revoke(&mut self) {
        self.file.revoke(&"goes".parse().unwrap()).unwrap();
        self.is_revoked = true;
    }
}
