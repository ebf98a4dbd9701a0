//! A name of a pty that one server has, and how the next one finds out that it is free.
//!
//! The link to a pty outlives a server that is killed, and its target may by then be the terminal of another program:
//! the kernel gives out numbers of ptys again. So a link alone does not show whether its server lives. Beside it there
//! is a file `NAME.lock`, which has the link's target and is locked as long as the server lives, however that ends. A
//! link is replaced if its lock is free and its target is the one that stands there; a link of another program is not.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read as _, Seek as _, Write as _};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};

use baudbot_fields::endpoint::Endpoint;
use rustix::fs::OFlags;

use crate::error::PortError;

/// A name that is this server's until it is dropped; then link and lock are gone.
#[derive(Debug)]
pub(crate) struct Claim {
    link: PathBuf,
    lock_path: PathBuf,
    lock: File,
}

/// The number of tries for a lock that is replaced all the time.
const MOST_TRIES: u32 = 100;

/// Longest name of a terminal; a file that is longer is no lock of ours.
const MOST_BYTES: u64 = 64;

impl Claim {
    /// Claims the name of a link.
    ///
    /// # Errors
    /// If another server has it, or something else is there.
    pub(crate) fn new(link: &Path) -> Result<Self, PortError> {
        let failed =
            |source: io::Error| PortError::Open { place: Endpoint::Pty(link.display().to_string()), source };
        let in_the_way = |path: &Path, what| PortError::InTheWay { path: path.to_owned(), what };
        let mut lock_path = OsString::from(link);
        lock_path.push(".lock");
        let lock_path = PathBuf::from(lock_path);
        // The check is made before anything is created. The owner of a link is known by the lock.
        if let Err(what) = is_free(link, None)
            && fs::read_link(link).is_err()
        {
            return Err(in_the_way(link, what));
        }
        let lock = lock(&lock_path).map_err(failed)?;
        let mut lock = lock.ok_or_else(|| in_the_way(link, "the port of another server"))?;
        let last = target(&mut lock).map_err(failed)?.ok_or_else(|| in_the_way(&lock_path, "a file"))?;
        let claim = Self { link: link.to_owned(), lock_path, lock };
        is_free(link, Some(&last)).map_err(|what| in_the_way(link, what))?;
        Ok(claim)
    }

    /// The name of the link.
    pub(crate) fn link(&self) -> &Path {
        &self.link
    }

    /// Makes the link lead to a terminal; it is never missing meanwhile.
    pub(crate) fn point_to(&mut self, slave: &Path) -> io::Result<()> {
        self.lock.rewind()?;
        self.lock.set_len(0)?;
        self.lock.write_all(slave.as_os_str().as_encoded_bytes())?;
        let mut new = OsString::from(&self.link);
        new.push(".new");
        if fs::read_link(&new).is_ok() {
            fs::remove_file(&new)?;
        }
        symlink(slave, &new)?;
        fs::rename(&new, &self.link)
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let ours = target(&mut self.lock).ok().flatten();
        if ours.is_some() && fs::read_link(&self.link).ok() == ours {
            drop(fs::remove_file(&self.link));
        }
        // The lock is held until then, so that no other server can have taken the name.
        drop(fs::remove_file(&self.lock_path));
    }
}

/// The lock, if no other program holds it.
fn lock(path: &Path) -> io::Result<Option<File>> {
    for _ in 0..MOST_TRIES {
        let mut options = fs::OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false).mode(0o600);
        let file = options.custom_flags(OFlags::NOFOLLOW.bits() as i32).open(path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => return Err(error),
        }
        // Another server may have ended in between, and have removed the file that was opened.
        let own = file.metadata()?;
        match fs::symlink_metadata(path) {
            Ok(found) if (found.dev(), found.ino()) == (own.dev(), own.ino()) => return Ok(Some(file)),
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

/// The target of the last server's link, empty if there was none; nothing if the file is not a lock.
fn target(lock: &mut File) -> io::Result<Option<PathBuf>> {
    let mut text = String::new();
    lock.rewind()?;
    match lock.take(MOST_BYTES).read_to_string(&mut text) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::InvalidData => return Ok(None),
        Err(error) => return Err(error),
    }
    let is_ours = text.is_empty() || text.starts_with("/dev/");
    Ok(Some(PathBuf::from(text)).filter(|_| is_ours))
}

/// The obstacle to a link, unless its place is free: nothing is there, or a link that leads nowhere, or one that
/// leads to what the last server's did.
fn is_free(link: &Path, last: Option<&Path>) -> Result<(), &'static str> {
    match fs::symlink_metadata(link) {
        Err(_) => Ok(()),
        Ok(found) if found.is_dir() => Err("a folder"),
        Ok(found) if !found.is_symlink() => Err("a file"),
        Ok(_) if !link.exists() || (last.is_some() && fs::read_link(link).ok().as_deref() == last) => Ok(()),
        Ok(_) => Err("a link to something else"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves the files of a killed server: nothing of it runs, but its files stay.
    fn left_by_a_killed_server(link: &Path, target: &str) {
        symlink(target, link).unwrap();
        fs::write(link.with_extension("tty.lock"), target).unwrap();
    }

    #[test]
    fn a_link_of_a_killed_server_is_replaced_even_if_its_terminal_is_somebody_s_by_now() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        // A file that is there for certain stands for the terminal of another program.
        left_by_a_killed_server(&link, "/dev/null");
        let mut claim = Claim::new(&link).unwrap();
        claim.point_to(Path::new("/dev/zero")).unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("/dev/zero"));
        drop(claim);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    }

    #[test]
    fn a_name_is_one_server_s_until_that_ends() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        let mut first = Claim::new(&link).unwrap();
        first.point_to(Path::new("/dev/null")).unwrap();
        let error = Claim::new(&link).unwrap_err().to_string();
        assert!(error.contains("the port of another server already exists"), "{error}");
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("/dev/null"));
        drop(first);
        Claim::new(&link).unwrap();
    }

    #[test]
    fn what_others_have_made_stays() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        symlink("/dev/null", &link).unwrap();
        let error = Claim::new(&link).unwrap_err().to_string();
        assert!(error.contains("a link to something else already exists"), "{error}");
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("/dev/null"));
        // The lock of a server that had another terminal.
        fs::write(folder.path().join("robot.tty.lock"), "/dev/zero").unwrap();
        Claim::new(&link).unwrap_err();
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("/dev/null"));
        fs::remove_file(&link).unwrap();
        fs::write(folder.path().join("robot.tty.lock"), "precious").unwrap();
        let error = Claim::new(&link).unwrap_err().to_string();
        assert!(error.contains("robot.tty.lock: a file already exists"), "{error}");
        assert_eq!(fs::read_to_string(folder.path().join("robot.tty.lock")).unwrap(), "precious");
    }
}
