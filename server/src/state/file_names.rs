//! The names of the folders and files of worlds.

use std::fs::{self, DirEntry};
use std::io;
use std::path::{Path, PathBuf};

const JOURNAL: &str = "journal-";
const SNAPSHOT: &str = "snapshot-";

/// How the name of a file ends that is being written.
pub(super) const UNFINISHED: &str = "new";

/// How the name of a folder ends whose world was deleted, until it is gone.
const DELETED: &str = "deleted";

/// How that of one ends that was set aside.
const DAMAGED: &str = "damaged";

pub(super) fn journal(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{JOURNAL}{number}"))
}

pub(super) fn snapshot(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{SNAPSHOT}{number}"))
}

/// The journals in a world's folder, with their numbers, the newest first.
pub(super) fn journals(folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut found = numbered(folder, JOURNAL)?;
    found.reverse();
    Ok(found)
}

/// The snapshots, the oldest first.
pub(super) fn snapshots(folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    numbered(folder, SNAPSHOT)
}

fn numbered(folder: &Path, prefix: &str) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        // Whoever opens something else may wait for ever.
        if !entry.file_type()?.is_file() {
            continue;
        }
        let number = entry.file_name().to_str().and_then(|name| number_of(name, prefix));
        found.extend(number.map(|number| (number, entry.path())));
    }
    found.sort_unstable();
    Ok(found)
}

/// The number of a name, as the program writes it; `None` for names that others have made. A server that runs for a hundred years
/// stays below the largest.
fn number_of(name: &str, prefix: &str) -> Option<u64> {
    let digits = name.strip_prefix(prefix)?;
    let number: u32 = digits.parse().ok()?;
    (number.to_string() == digits).then_some(number.into())
}

/// Whether a server that was killed has left this while it wrote it.
fn is_unfinished(entry: &DirEntry) -> io::Result<bool> {
    let name = entry.file_name();
    let number = |name: &str| number_of(name, JOURNAL).or_else(|| number_of(name, SNAPSHOT));
    let is_ours = name
        .to_str()
        .and_then(|name| name.rsplit_once('.'))
        .is_some_and(|(name, end)| end == UNFINISHED && number(name).is_some());
    Ok(is_ours && !entry.file_type()?.is_dir())
}

/// Removes what a server has left unfinished.
pub(super) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_unfinished(&entry)? {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Whether there is nothing in a folder but what a server has left unfinished.
pub(super) fn is_unused(folder: &Path) -> io::Result<bool> {
    for entry in fs::read_dir(folder)? {
        if !is_unfinished(&entry?)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether a world can have this name.
pub(super) fn is_world(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=64).contains(&name.len()) && name.chars().all(fits)
}

/// Where the folder of a world goes that is deleted.
pub(super) fn deleted(folder: &Path) -> PathBuf {
    free(&folder.with_extension(DELETED))
}

/// Whether this is such a name.
pub(super) fn is_deleted(name: &str) -> bool {
    let Some((world, end)) = name.split_once('.') else { return false };
    let number = end.strip_prefix(DELETED).and_then(|end| number_of(end, "-"));
    is_world(world) && (end == DELETED || number.is_some_and(|number| number >= SECOND))
}

/// Where the folder of a world goes that is set aside.
pub(super) fn damaged(folder: &Path) -> PathBuf {
    free(&folder.with_extension(DAMAGED))
}

/// The number in the second of several names that are otherwise the same.
const SECOND: u64 = 2;

/// A free name like this one.
fn free(path: &Path) -> PathBuf {
    let numbered = |number: u64| PathBuf::from(format!("{}-{number}", path.display()));
    let mut names = std::iter::once(path.to_owned()).chain((SECOND..).map(numbered));
    names.find(|name| is_free(name)).expect("numbers do not end")
}

/// Whether nothing has this name.
pub(super) fn is_free(path: &Path) -> bool {
    path.symlink_metadata().is_err()
}
