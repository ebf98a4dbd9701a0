//! The lock of a file that several programs change.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::private::{PrivateError, folder_of};

/// The lock of a file that is changed by more than one program. It is another file beside it, as the file itself is
/// replaced; and one that is written, as network file systems lock no others. It is never removed, as that could take
/// it away from under a program that waits for it.
pub(crate) struct Lock {
    _file: File,
}

/// The time for which a program waits for another one that changes the same file.
const PATIENCE: Duration = Duration::from_secs(10);

/// The pause between two attempts.
const PAUSE: Duration = Duration::from_millis(20);

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
                Err(TryLockError::WouldBlock) if begin.elapsed() >= PATIENCE => {
                    let path = path.to_owned();
                    return Err(PrivateError::Locked { path, seconds: PATIENCE.as_secs() });
                }
                Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
