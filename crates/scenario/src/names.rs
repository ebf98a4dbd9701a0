//! Names of things in a file.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;

use baudbot_fields::{FieldError, Path};

/// Names that were given so far; they must be unique and fit into paths.
#[derive(Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    pub(super) fn take(&mut self, path: &Path, name: &str) -> Result<String, FieldError> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
            let problem = format!("must be 1 to 64 letters, digits, `_` or `-`, is `{}`", shorten(name));
            return Err(path.error(problem));
        }
        if !self.0.insert(name.into()) {
            return Err(path.error(format!("`{name}` is taken; names must be unique")));
        }
        Ok(name.into())
    }
}

fn shorten(name: &str) -> String {
    name.chars().take(80).collect()
}
