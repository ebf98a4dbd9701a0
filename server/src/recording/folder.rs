//! The server's folder of recordings. No name from the network leads out of it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use baudbot_proto::v1;
use tonic::Status;

use crate::quote::brief;
use crate::system::open_plain_file;

/// A folder of recordings.
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
            let shown = brief(&name.chars().take(80).collect::<String>());
            let text = format!(
                "recording: must be 1 to 64 letters, digits, `_`, `-` or `.`, the first one not `.`, is `{shown}`"
            );
            return Err(Status::invalid_argument(text));
        }
        Ok(self.0.join(format!("{name}.mcap")))
    }

    /// A name for a new recording of this world.
    pub(crate) fn free_name(&self, world: &str) -> String {
        // This leaves room for a number, and for another one after a reset.
        let world: String = world.chars().take(48).collect();
        let mut names = (1..).map(|i| format!("{world}-{i}"));
        // A name is taken by a link that leads nowhere, too.
        let is_free = |name: &String| self.0.join(format!("{name}.mcap")).symlink_metadata().is_err();
        names.find(is_free).expect("numbers do not end")
    }

    /// Opens the recording of this name for reading. Only plain files in this very folder are opened: a link may lead out of it,
    /// and opening a pipe may wait for ever.
    pub(crate) fn open(&self, name: &str) -> Result<File, Status> {
        let no_file = || Status::failed_precondition(format!("recording: `{name}` is not a file"));
        let file = open_plain_file(&self.file(name)?).map_err(|error| unreadable(name, &error))?;
        let file = file.ok_or_else(no_file)?;
        let metadata = file.metadata().map_err(|error| unreadable(name, &error))?;
        if metadata.is_file() { Ok(file) } else { Err(no_file()) }
    }

    /// The recordings in the folder, in the order of their names.
    pub(crate) fn list(&self) -> Result<Vec<v1::RecordingFile>, Status> {
        let unreadable = |error: io::Error| {
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
            // A file whose name cannot be asked for is not a recording of ours.
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

fn unreadable(name: &str, error: &io::Error) -> Status {
    if error.kind() == io::ErrorKind::NotFound {
        return Status::not_found(format!(
            "recording: `{name}`: there is no such file in the server's folder"
        ));
    }
    Status::failed_precondition(format!("recording: `{name}` cannot be read: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_folder_are_opened() {
        let place = std::env::temp_dir().join(format!("baudbot-folder-{}", std::process::id()));
        let _ = fs::remove_dir_all(&place);
        fs::create_dir_all(place.join("runs/folder.mcap")).unwrap();
        fs::write(place.join("outside.mcap"), "secret").unwrap();
        fs::write(place.join("runs/run.mcap"), "run").unwrap();
        std::os::unix::fs::symlink("../outside.mcap", place.join("runs/link.mcap")).unwrap();
        std::os::unix::fs::symlink("nowhere", place.join("runs/w-1.mcap")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(place.join("runs/pipe.mcap")).status().unwrap();
        assert!(made.success());
        std::os::unix::net::UnixListener::bind(place.join("runs/socket.mcap")).unwrap();
        let folder = Folder::new(place.join("runs"));
        assert_eq!(io::read_to_string(folder.open("run").unwrap()).unwrap(), "run");
        for odd in ["link", "pipe", "socket", "folder", "w-1"] {
            let status = folder.open(odd).unwrap_err();
            assert_eq!(status.message(), format!("recording: `{odd}` is not a file"));
        }
        assert_eq!(folder.open("none").unwrap_err().code(), tonic::Code::NotFound);
        let listed: Vec<_> = folder.list().unwrap().into_iter().map(|file| file.recording).collect();
        assert_eq!(listed, ["run"]);
        assert_eq!(folder.free_name("w"), "w-2", "the link is not written through");
        fs::remove_dir_all(&place).unwrap();
    }

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
