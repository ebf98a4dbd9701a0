//! Files that are their owner's alone: how they are read and written.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use baudbot_fields::printable::Printable;
use rustix::fs::OFlags;
use tempfile::{NamedTempFile, TempDir};

/// A reason why a private file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PrivateError {
    /// The system refuses something.
    #[error("cannot {action} {}: {source}", shown(path))]
    Io {
        /// The action that failed.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Others may read it or write to it.
    #[error(
        "{}: others can read or write it (mode {mode:04o}); fix that with: chmod {wanted} {}",
        shown(path),
        quoted(path)
    )]
    Exposed {
        /// The file or folder.
        path: PathBuf,
        /// The mode of the file or folder.
        mode: u32,
        /// The mode that it should have, as `chmod` takes it.
        wanted: &'static str,
    },
    /// The file belongs to another user.
    #[error(
        "{}: belongs to the user with the number {owner}, so that it cannot be trusted; move it away or use another",
        shown(path)
    )]
    Foreign {
        /// The file or folder.
        path: PathBuf,
        /// The file's owner.
        owner: u32,
    },
    /// The folder belongs to another user, and there is no other place for the token of this user's own programs.
    #[error(
        "{}: belongs to the user with the number {owner}, so that it cannot be trusted, and no other place is free; set \
         XDG_RUNTIME_DIR to a folder of your own (mkdir -m 700), for the server and its clients",
        shown(path)
    )]
    NoPlace {
        /// The folder.
        path: PathBuf,
        /// The folder's owner.
        owner: u32,
    },
    /// The path is no ordinary file, or no folder, where one is needed.
    #[error("{}: is not {wanted}", shown(path))]
    Kind {
        /// The path of the file or folder.
        path: PathBuf,
        /// The kind that it should have: `a file` or `a folder`.
        wanted: &'static str,
    },
    /// The file is too long for its purpose.
    #[error("{}: has {bytes} bytes and may have {most}; is it the right file?", shown(path))]
    TooLong {
        /// The file.
        path: PathBuf,
        /// The file's length, in bytes.
        bytes: u64,
        /// The greatest length.
        most: u64,
    },
    /// The file is no text.
    #[error("{}: is not a text in UTF-8; is it the right file?", shown(path))]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// Another program holds its lock.
    #[error(
        "{}: another program has been changing it for {seconds} s; try again when that has ended",
        shown(path)
    )]
    Locked {
        /// The file.
        path: PathBuf,
        /// The time for which this program has waited, in seconds.
        seconds: u64,
    },
}

impl PrivateError {
    /// Whether there is no such file.
    pub fn is_absent(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == io::ErrorKind::NotFound)
    }
}

/// A mark that distinguishes one content of a file from the next without reading it: any change of it, of its mode or
/// its owner, and another file in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    device_and_inode: (u64, u64),
    bytes: u64,
    modified_ns: (i64, i64),
    changed_ns: (i64, i64),
}

/// Reads a text that only its owner, who is this user or root, may read and write; of one that is root's, this program's own group may
/// read it, too.
pub(crate) fn read(path: &Path, most: u64) -> Result<(String, Stamp), PrivateError> {
    let (file, metadata) = open(path)?;
    check_file(path, &metadata)?;
    Ok((text_of(path, file, &metadata, most)?, Stamp::of(&metadata)))
}

/// Writes a file that only this user may read and write, in place of one that may be there; where root has let a service's group read
/// that, it may read the new one. Whenever this is interrupted, there
/// is the old file or the new one.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), PrivateError> {
    let failed = |source| PrivateError::Io { action: "write", path: path.to_owned(), source };
    // A link stays, and the file at its end is replaced.
    let real = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = folder_of(&real);
    // The mode of the temporary file is 0600.
    let mut file = NamedTempFile::new_in(folder).map_err(failed)?;
    file.write_all(text.as_bytes()).and_then(|()| file.as_file().sync_all()).map_err(failed)?;
    if let Ok(before) = fs::metadata(&real)
        && is_for_service(&before)
    {
        let kept = std::os::unix::fs::fchown(file.as_file(), None, Some(before.gid()));
        let kept = kept.and_then(|()| file.as_file().set_permissions(before.permissions()));
        kept.map_err(failed)?;
    }
    file.persist(&real).map_err(|error| failed(error.error))?;
    // The name is on the disk only with the folder. What cannot do that, as some network file systems, does not know of it.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Reads a text that others may read, too.
#[cfg(feature = "certificates")]
pub(crate) fn read_public(path: &Path, most: u64) -> Result<String, PrivateError> {
    let (file, metadata) = open(path)?;
    if !metadata.is_file() {
        return Err(PrivateError::Kind { path: path.to_owned(), wanted: "a file" });
    }
    text_of(path, file, &metadata, most)
}

/// Makes a file that is not there yet, with this mode.
#[cfg(feature = "certificates")]
pub(crate) fn create(path: &Path, text: &str, mode: u32) -> Result<(), PrivateError> {
    let failed = |source| PrivateError::Io { action: "write", path: path.to_owned(), source };
    let mut file = NamedTempFile::new_in(folder_of(path)).map_err(failed)?;
    let written = file.write_all(text.as_bytes()).and_then(|()| file.as_file().sync_all());
    written.map_err(failed)?;
    file.as_file().set_permissions(fs::Permissions::from_mode(mode)).map_err(failed)?;
    file.persist_noclobber(path).map(|_| ()).map_err(|error| failed(error.error))
}

/// Makes a folder that only this user may enter, and that is gone when the result is dropped. For a socket, which other users could reach
/// in a folder that they may enter until it has its own permissions.
///
/// # Errors
/// If the system's folder for temporary files takes none.
pub fn private_folder() -> io::Result<TempDir> {
    let own = fs::Permissions::from_mode(0o700);
    tempfile::Builder::new().prefix("baudbot-").permissions(own).tempdir()
}

/// Makes the folder of a file, for this user only, if it is not there.
#[cfg(feature = "grants")]
pub(crate) fn make_folder_of(path: &Path) -> Result<(), PrivateError> {
    use std::os::unix::fs::DirBuilderExt;

    let folder = folder_of(path);
    let made = fs::DirBuilder::new().recursive(true).mode(0o700).create(folder);
    made.map_err(|source| PrivateError::Io { action: "make the folder", path: folder.to_owned(), source })
}

/// Checks a folder that is to be this user's own, without following a link.
pub(crate) fn check_folder(path: &Path) -> Result<(), PrivateError> {
    let failed = |source| PrivateError::Io { action: "look at", path: path.to_owned(), source };
    let metadata = fs::symlink_metadata(path).map_err(failed)?;
    // A link of others is theirs, too.
    if metadata.uid() != user() {
        return Err(PrivateError::Foreign { path: path.to_owned(), owner: metadata.uid() });
    }
    if !metadata.is_dir() {
        return Err(PrivateError::Kind { path: path.to_owned(), wanted: "a folder" });
    }
    check_mode(path, &metadata, "700")
}

/// This user, in whose name the program acts.
pub(crate) fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

impl Stamp {
    /// The stamp of the file as it is now.
    #[cfg(feature = "grants")]
    pub(crate) fn at(path: &Path) -> Option<Self> {
        fs::metadata(path).ok().map(|metadata| Self::of(&metadata))
    }

    fn of(metadata: &Metadata) -> Self {
        Self {
            device_and_inode: (metadata.dev(), metadata.ino()),
            bytes: metadata.len(),
            modified_ns: (metadata.mtime(), metadata.mtime_nsec()),
            changed_ns: (metadata.ctime(), metadata.ctime_nsec()),
        }
    }
}

fn open(path: &Path) -> Result<(File, Metadata), PrivateError> {
    // The open does not block on a pipe without a writer.
    let flags = OFlags::NONBLOCK.bits().cast_signed();
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path);
    let opened = file.and_then(|file| file.metadata().map(|metadata| (file, metadata)));
    opened.map_err(|source| PrivateError::Io { action: "read", path: path.to_owned(), source })
}

fn text_of(path: &Path, file: File, metadata: &Metadata, most: u64) -> Result<String, PrivateError> {
    let too_long = |bytes| PrivateError::TooLong { path: path.to_owned(), bytes, most };
    if metadata.len() > most {
        return Err(too_long(metadata.len()));
    }
    let mut bytes = Vec::new();
    let read = file.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|source| PrivateError::Io { action: "read", path: path.to_owned(), source })?;
    if bytes.len() as u64 > most {
        return Err(too_long(bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|_| PrivateError::NotText { path: path.to_owned() })
}

fn check_file(path: &Path, metadata: &Metadata) -> Result<(), PrivateError> {
    if !metadata.is_file() {
        return Err(PrivateError::Kind { path: path.to_owned(), wanted: "a file" });
    }
    // Root may do everything anyway.
    if metadata.uid() != user() && metadata.uid() != 0 {
        return Err(PrivateError::Foreign { path: path.to_owned(), owner: metadata.uid() });
    }
    if is_for_service(metadata) {
        return Ok(());
    }
    check_mode(path, metadata, "600")
}

/// Whether it is root's, who lets a service read it by the service's own group, as systems and orchestrators keep secrets. The
/// service is this program, or root looks after the file for it.
fn is_for_service(metadata: &Metadata) -> bool {
    let group = metadata.gid();
    let is_ours = user() == 0 || group == rustix::process::getegid().as_raw();
    metadata.uid() == 0 && group != 0 && is_ours && metadata.mode() & 0o077 == 0o040
}

fn check_mode(path: &Path, metadata: &Metadata, wanted: &'static str) -> Result<(), PrivateError> {
    let mode = metadata.mode() & 0o7777;
    if mode & 0o077 == 0 {
        return Ok(());
    }
    Err(PrivateError::Exposed { path: path.to_owned(), mode, wanted })
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

/// A path in a message.
pub(crate) fn shown(path: &Path) -> String {
    Printable(path.display()).to_string()
}

/// A path as an argument of a command.
fn quoted(path: &Path) -> String {
    let text = shown(path);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+@:,=".contains(c);
    if text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn what_is_written_is_for_its_owner_only_and_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("secret");
        write(&path, "one").unwrap();
        write(&path, "two").unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert_eq!(read(&path, 3).unwrap().0, "two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left over");
    }

    #[test]
    fn a_file_that_others_can_read_is_refused_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my secret");
        write(&path, "one").unwrap();
        for bad in [0o644, 0o640, 0o620, 0o602, 0o604, 0o610] {
            mode(&path, bad);
            let error = read(&path, 3).unwrap_err();
            assert!(matches!(error, PrivateError::Exposed { mode, .. } if mode == bad), "{bad:o}");
            let expected = format!("(mode {bad:04o}); fix that with: chmod 600 '{}'", path.display());
            assert!(error.to_string().ends_with(&expected), "{error}");
        }
        for good in [0o600, 0o400] {
            mode(&path, good);
            assert_eq!(read(&path, 3).unwrap().0, "one");
        }
    }

    /// The owner and mode are those with which systemd and Kubernetes give a secret to a service.
    #[test]
    fn root_lets_a_service_read_by_its_group() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("secret");
        write(&path, "one").unwrap();
        if user() != 0 {
            return; // only root can give a file to a group
        }
        std::os::unix::fs::chown(&path, Some(0), Some(4321)).unwrap();
        mode(&path, 0o640);
        assert_eq!(read(&path, 3).unwrap().0, "one");
        write(&path, "two").unwrap();
        let metadata = fs::metadata(&path).unwrap();
        assert_eq!((metadata.mode() & 0o777, metadata.gid()), (0o640, 4321), "the service can read it still");
        for bad in [0o660, 0o644, 0o642] {
            mode(&path, bad);
            assert!(matches!(read(&path, 3), Err(PrivateError::Exposed { .. })), "{bad:o}");
        }
        std::os::unix::fs::chown(&path, Some(4321), Some(4321)).unwrap();
        mode(&path, 0o640);
        assert!(matches!(read(&path, 3), Err(PrivateError::Foreign { .. })), "a file of another user");
    }

    #[test]
    fn what_is_no_short_text_is_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write(&path("long"), "four").unwrap();
        assert!(matches!(read(&path("long"), 3), Err(PrivateError::TooLong { bytes: 4, most: 3, .. })));
        fs::write(path("bytes"), [0xff]).unwrap();
        mode(&path("bytes"), 0o600);
        assert!(matches!(read(&path("bytes"), 3), Err(PrivateError::NotText { .. })));
        assert!(matches!(read(folder.path(), 3), Err(PrivateError::Kind { wanted: "a file", .. })));
        let pipe = path("pipe");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR, 0)
            .unwrap();
        assert!(matches!(read(&pipe, 3), Err(PrivateError::Kind { .. })));
        let error = read(&path("none"), 3).unwrap_err().to_string();
        assert!(error.starts_with("cannot read ") && error.contains("none: No such file"), "{error}");
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        write(&real, "one").unwrap();
        symlink(&real, &link).unwrap();
        write(&link, "two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(read(&real, 3).unwrap().0, "two");
    }

    #[test]
    fn a_folder_must_be_this_users_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        make_folder_of(&path("a/b/file")).unwrap();
        check_folder(&path("a/b")).unwrap();
        symlink(path("a/b"), path("link")).unwrap();
        assert!(matches!(check_folder(&path("link")), Err(PrivateError::Kind { wanted: "a folder", .. })));
        mode(&path("a/b"), 0o750);
        let error = check_folder(&path("a/b")).unwrap_err();
        assert!(error.to_string().contains("chmod 700 "), "{error}");
        assert!(matches!(check_folder(&path("none")), Err(PrivateError::Io { .. })));
    }

    #[test]
    fn every_change_has_another_stamp() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        assert_eq!(Stamp::at(&path), None);
        write(&path, "one").unwrap();
        let (_, one) = read(&path, 3).unwrap();
        assert_eq!(Stamp::at(&path), Some(one));
        write(&path, "two").unwrap();
        let two = Stamp::at(&path);
        assert_ne!(two, Some(one), "another file of the same length");
        std::thread::sleep(std::time::Duration::from_millis(20));
        mode(&path, 0o400);
        assert_ne!(Stamp::at(&path), two, "another mode");
    }
}
