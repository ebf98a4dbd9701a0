//! Files that are their owner's alone: how they are read, written and locked.

use std::fs::{self, DirBuilder, File, Metadata, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use baudbot_fields::printable::Printable;
use rustix::fs::OFlags;
use tempfile::NamedTempFile;

/// Why a private file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PrivateError {
    /// The system refuses something.
    #[error("cannot {action} {}: {source}", shown(path))]
    Io {
        /// What.
        action: &'static str,
        /// With which file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Others may read it or write to it.
    #[error(
        "{}: others can read or write it (mode {mode:04o}); mend that with: chmod {wanted} {}",
        shown(path),
        quoted(path)
    )]
    Exposed {
        /// The file or folder.
        path: PathBuf,
        /// Its mode.
        mode: u32,
        /// The mode that it should have, as `chmod` takes it.
        wanted: &'static str,
    },
    /// It belongs to another user.
    #[error(
        "{}: belongs to the user with the number {owner}, so that it cannot be trusted; move it away or use another",
        shown(path)
    )]
    Foreign {
        /// The file or folder.
        path: PathBuf,
        /// Its owner.
        owner: u32,
    },
    /// It is no ordinary file, or no folder, where one is needed.
    #[error("{}: is not {wanted}", shown(path))]
    Kind {
        /// It.
        path: PathBuf,
        /// What it should be: `a file` or `a folder`.
        wanted: &'static str,
    },
    /// It is too long to be what it should be.
    #[error("{}: has {bytes} bytes and may have {most}; is it the right file?", shown(path))]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// The greatest length.
        most: u64,
    },
    /// It is no text.
    #[error("{}: is not a text in UTF-8; is it the right file?", shown(path))]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// Another program holds its lock.
    #[error("{}: another program has been changing it for {} s; try again when that has ended", shown(path), LOCK_PATIENCE.as_secs())]
    Locked {
        /// The file.
        path: PathBuf,
    },
}

/// What tells one content of a file from the next without reading it: any change of it, of its mode or its owner, and another
/// file in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    device_and_inode: (u64, u64),
    bytes: u64,
    modified_ns: (i64, i64),
    changed_ns: (i64, i64),
}

/// The lock of a file that is changed by more than one program. It is another file beside it, as the file itself is replaced; and
/// one that is written, as network file systems lock no others. It stays there: whoever removed it could take it away from under
/// a program that waits for it.
pub(crate) struct Lock {
    _file: File,
}

/// How long a program waits for another one that changes the same file.
const LOCK_PATIENCE: Duration = Duration::from_secs(10);

/// Between two attempts.
const LOCK_PAUSE: Duration = Duration::from_millis(20);

/// Reads a text that only its owner, who is this user or root, may read and write.
pub(crate) fn read(path: &Path, most: u64) -> Result<(String, Stamp), PrivateError> {
    let failed = |source| PrivateError::Io { action: "read", path: path.to_owned(), source };
    // Without waiting for somebody to write, if this is a pipe.
    let flags = OFlags::NONBLOCK.bits().cast_signed();
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    check_file(path, &metadata)?;
    let too_long = |bytes| PrivateError::TooLong { path: path.to_owned(), bytes, most };
    if metadata.len() > most {
        return Err(too_long(metadata.len()));
    }
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most {
        return Err(too_long(bytes.len() as u64));
    }
    let text = String::from_utf8(bytes).map_err(|_| PrivateError::NotText { path: path.to_owned() })?;
    Ok((text, Stamp::of(&metadata)))
}

/// Writes a file that only this user may read and write, in place of one that may be there. Whenever this is interrupted, there
/// is the old file or the new one.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), PrivateError> {
    let failed = |source| PrivateError::Io { action: "write", path: path.to_owned(), source };
    // Where a link leads, the link stays.
    let real = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = folder_of(&real);
    // Its mode is 0600.
    let mut file = NamedTempFile::new_in(folder).map_err(failed)?;
    file.write_all(text.as_bytes()).and_then(|()| file.as_file().sync_all()).map_err(failed)?;
    file.persist(&real).map_err(|error| failed(error.error))?;
    // The name is on the disk only with the folder. What cannot do that, as some network file systems, does not know of it.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Makes the folder of a file, for this user only, if it is not there.
pub(crate) fn make_folder_of(path: &Path) -> Result<(), PrivateError> {
    let folder = folder_of(path);
    let made = DirBuilder::new().recursive(true).mode(0o700).create(folder);
    made.map_err(|source| PrivateError::Io { action: "make the folder", path: folder.to_owned(), source })
}

/// Checks a folder that is to be this user's own, without following a link.
pub(crate) fn check_folder(path: &Path) -> Result<(), PrivateError> {
    let failed = |source| PrivateError::Io { action: "look at", path: path.to_owned(), source };
    let metadata = fs::symlink_metadata(path).map_err(failed)?;
    if !metadata.is_dir() {
        return Err(PrivateError::Kind { path: path.to_owned(), wanted: "a folder" });
    }
    if metadata.uid() != user() {
        return Err(PrivateError::Foreign { path: path.to_owned(), owner: metadata.uid() });
    }
    check_mode(path, &metadata, "700")
}

/// This user, in whose name the program acts.
pub(crate) fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

impl Stamp {
    /// That of the file as it is now.
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

impl Lock {
    /// Waits for the lock of a file, which need not be there. It is released when this is dropped, or the program ends.
    pub(crate) fn take(path: &Path) -> Result<Self, PrivateError> {
        let real = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let name = real.file_name().unwrap_or_default().to_string_lossy();
        let beside = folder_of(&real).join(format!(".{name}.lock"));
        let failed = |source| PrivateError::Io { action: "lock", path: beside.clone(), source };
        let mut options = OpenOptions::new();
        let file =
            options.write(true).create(true).truncate(false).mode(0o600).open(&beside).map_err(failed)?;
        let begin = Instant::now();
        loop {
            match file.try_lock() {
                Ok(()) => return Ok(Self { _file: file }),
                Err(TryLockError::Error(source)) => return Err(failed(source)),
                Err(TryLockError::WouldBlock) if begin.elapsed() >= LOCK_PATIENCE => {
                    return Err(PrivateError::Locked { path: path.to_owned() });
                }
                Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_PAUSE),
            }
        }
    }
}

fn check_file(path: &Path, metadata: &Metadata) -> Result<(), PrivateError> {
    if !metadata.is_file() {
        return Err(PrivateError::Kind { path: path.to_owned(), wanted: "a file" });
    }
    // Root may do everything anyway.
    if metadata.uid() != user() && metadata.uid() != 0 {
        return Err(PrivateError::Foreign { path: path.to_owned(), owner: metadata.uid() });
    }
    check_mode(path, metadata, "600")
}

fn check_mode(path: &Path, metadata: &Metadata, wanted: &'static str) -> Result<(), PrivateError> {
    let mode = metadata.mode() & 0o7777;
    if mode & 0o077 == 0 {
        return Ok(());
    }
    Err(PrivateError::Exposed { path: path.to_owned(), mode, wanted })
}

fn folder_of(path: &Path) -> &Path {
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
    use std::os::unix::fs::{PermissionsExt, symlink};

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
            let expected = format!("(mode {bad:04o}); mend that with: chmod 600 '{}'", path.display());
            assert!(error.to_string().ends_with(&expected), "{error}");
        }
        for good in [0o600, 0o400] {
            mode(&path, good);
            assert_eq!(read(&path, 3).unwrap().0, "one");
        }
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
        std::thread::sleep(Duration::from_millis(20));
        mode(&path, 0o400);
        assert_ne!(Stamp::at(&path), two, "another mode");
    }

    #[test]
    fn a_lock_is_held_by_one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let counted = folder.path().join("count");
        fs::write(&counted, "0").unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..10 {
                        let _lock = Lock::take(&path).unwrap();
                        let count: u32 = fs::read_to_string(&counted).unwrap().parse().unwrap();
                        fs::write(&counted, (count + 1).to_string()).unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read_to_string(&counted).unwrap(), "40");
    }
}
