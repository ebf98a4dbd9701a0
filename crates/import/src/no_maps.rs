//! Stands in for `maps` in a build without that feature.

use std::path::Path;

use toml_edit::DocumentMut;

use crate::error::ImportError;
use crate::note::Note;

/// Refuses a scenario that has maps.
#[expect(clippy::needless_pass_by_ref_mut, reason = "the signature of `maps::inline`")]
pub(crate) fn inline(document: &mut DocumentMut, _: &Path, _: &mut Vec<Note>) -> Result<bool, ImportError> {
    match document.get("arena").and_then(|arena| arena.get("maps")) {
        Some(_) => Err(ImportError::field("arena.maps", WITHOUT)),
        None => Ok(false),
    }
}

const WITHOUT: &str = "this program was built without maps and plans; cargo build --release --features maps builds one with them";
