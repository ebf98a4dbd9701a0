//! The server's folder of recordings: names from the network never leave it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use baudbot_proto::v1;
use tonic::Status;

/// A folder. Clones are the same.
#[derive(Clone, Debug)]
pub(crate) struct Folder(Arc<Path>);

impl Folder {
    pub(crate) fn new(path: PathBuf) -> Self {
        Self(path.into())
    }

    /// The file of this name.
    pub(crate) fn file(&self, name: &str) -> Result<PathBuf, Status> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
        if name.is_empty() || name.len() > 64 || name.starts_with('.') || !name.chars().all(fits) {
            let shown: String = name.chars().take(80).collect();
            let text = format!(
                "recording: must be 1 to 64 letters, digits, `_`, `-` or `.`, the first of them no `.`, is `{shown}`"
            );
            return Err(Status::invalid_argument(text));
        }
        Ok(self.0.join(format!("{name}.mcap")))
    }

    /// A name for a new recording of this world.
    pub(crate) fn free_name(&self, world: &str) -> String {
        // With room for a number, and another one after a reset.
        let world: String = world.chars().take(48).collect();
        let mut names = (1..).map(|i| format!("{world}-{i}"));
        let is_free = |name: &String| !self.0.join(format!("{name}.mcap")).exists();
        names.find(is_free).expect("numbers do not end")
    }

    /// What is in it, in the order of names.
    pub(crate) fn list(&self) -> Result<Vec<v1::RecordingFile>, Status> {
        let unreadable = |error: std::io::Error| {
            Status::failed_precondition(format!("cannot read the folder {}: {error}", self.0.display()))
        };
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.0).map_err(unreadable)?.flatten() {
            let path = entry.path();
            let (Some(name), Ok(metadata)) =
                (path.file_stem().and_then(|name| name.to_str()), entry.metadata())
            else {
                continue;
            };
            // What has no name that could be asked for is none of ours.
            if path.extension().is_none_or(|end| end != "mcap")
                || self.file(name).is_err()
                || !metadata.is_file()
            {
                continue;
            }
            let modified = metadata.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
            files.push(v1::RecordingFile {
                recording: name.to_owned(),
                bytes: metadata.len(),
                modified_unix_ns: modified.map_or(0, |at| u64::try_from(at.as_nanos()).unwrap_or(u64::MAX)),
            });
        }
        files.sort_by(|one, other| one.recording.cmp(&other.recording));
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_lead_out_of_the_folder() {
        let folder = Folder::new("/recordings".into());
        assert_eq!(folder.file("run-1.a_b").unwrap(), Path::new("/recordings/run-1.a_b.mcap"));
        for bad in
            ["", ".", "..", "../x", "a/b", "/etc/passwd", ".hidden", "a\\b", "a b", "ä", &"a".repeat(65)]
        {
            assert!(folder.file(bad).unwrap_err().message().starts_with("recording: must be"), "{bad}");
        }
    }
}
