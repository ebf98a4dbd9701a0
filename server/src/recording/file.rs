//! The file of a recording.

use std::path::Path;

use baudbot_recording::RecordingFile;
use tonic::Status;

use crate::system::leaves_room;

/// Makes the file, if the budget of open files has room for it.
///
/// # Errors
/// If it cannot be made, is there, or too many files are open.
pub(super) fn create(path: &Path) -> Result<RecordingFile, Status> {
    let file = RecordingFile::create(path).map_err(|error| cannot_write(path, &error))?;
    if leaves_room(file.file()) {
        return Ok(file);
    }
    let _ = std::fs::remove_file(path);
    let text = "recording: the server has reached its limit of open files for recordings and connections; close some, or raise the \
                limit (ulimit -n)";
    Err(Status::resource_exhausted(text))
}

/// The status for a file that cannot be written.
fn cannot_write(path: &Path, error: &std::io::Error) -> Status {
    let text = format!("recording: cannot write {}: {error}", path.display());
    if error.kind() == std::io::ErrorKind::AlreadyExists {
        let path = path.display();
        return Status::already_exists(format!(
            "recording: {path} already exists, and no file is overwritten; choose another name, or delete it"
        ));
    }
    Status::failed_precondition(text)
}
