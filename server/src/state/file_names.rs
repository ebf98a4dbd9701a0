//! The names of the files of a world.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

const JOURNAL: &str = "journal-";
const SNAPSHOT: &str = "snapshot-";

/// How the name of a file ends that is being written.
pub(super) const UNFINISHED: &str = "new";

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
        let number = entry.file_name().to_str().and_then(|name| name.strip_prefix(prefix)?.parse().ok());
        found.extend(number.map(|number| (number, entry.path())));
    }
    found.sort_unstable();
    Ok(found)
}

/// Removes what a server has left unfinished.
pub(super) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|end| end == UNFINISHED) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

/// A free name like this one.
pub(super) fn free(path: &Path) -> PathBuf {
    let numbered = |number: u64| PathBuf::from(format!("{}-{number}", path.display()));
    let mut names = std::iter::once(path.to_owned()).chain((2..).map(numbered));
    names.find(|name| name.symlink_metadata().is_err()).expect("numbers do not end")
}
