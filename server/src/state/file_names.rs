//! The names of the folders and files of worlds.

use std::io;
use std::path::{Path, PathBuf};

use super::storage::{Kind, Listed, Storage};

const JOURNAL: &str = "journal-";
const SNAPSHOT: &str = "snapshot-";

/// The ending of a file's name that is being written.
pub(super) const UNFINISHED: &str = "new";

/// The ending of a folder's name whose world was deleted, until it is gone.
const DELETED: &str = "deleted";

/// The ending of the name of one that was set aside.
const DAMAGED: &str = "damaged";

pub(super) fn journal(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{JOURNAL}{number}"))
}

pub(super) fn snapshot(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{SNAPSHOT}{number}"))
}

/// The journals in a world's folder, with their numbers, the newest first.
pub(super) fn journals(storage: &dyn Storage, folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut found = numbered(storage, folder, JOURNAL)?;
    found.reverse();
    Ok(found)
}

/// The snapshots, the oldest first.
pub(super) fn snapshots(storage: &dyn Storage, folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    numbered(storage, folder, SNAPSHOT)
}

fn numbered(storage: &dyn Storage, folder: &Path, prefix: &str) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut found = Vec::new();
    for Listed { name, kind } in storage.list(folder)? {
        // Only plain files are opened: the open of anything else may wait for ever.
        if kind == Kind::File {
            found.extend(number_of(&name, prefix).map(|number| (number, folder.join(&name))));
        }
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
fn is_unfinished(Listed { name, kind }: &Listed) -> bool {
    let number = |name: &str| number_of(name, JOURNAL).or_else(|| number_of(name, SNAPSHOT));
    let is_ours =
        name.rsplit_once('.').is_some_and(|(name, end)| end == UNFINISHED && number(name).is_some());
    is_ours && *kind != Kind::Folder
}

/// Removes what a server has left unfinished.
pub(super) fn remove_unfinished(storage: &dyn Storage, folder: &Path) -> io::Result<()> {
    for listed in storage.list(folder)?.iter().filter(|listed| is_unfinished(listed)) {
        storage.remove_file(&folder.join(&listed.name))?;
    }
    Ok(())
}

/// Whether there is nothing in a folder but what a server has left unfinished.
pub(super) fn is_unused(storage: &dyn Storage, folder: &Path) -> io::Result<bool> {
    Ok(storage.list(folder)?.iter().all(is_unfinished))
}

/// Whether a world can have this name.
pub(super) fn is_world(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=64).contains(&name.len()) && name.chars().all(fits)
}

/// The place of the folder of a deleted world.
pub(super) fn deleted(storage: &dyn Storage, folder: &Path) -> PathBuf {
    free(storage, &folder.with_extension(DELETED))
}

/// Whether this is such a name.
pub(super) fn is_deleted(name: &str) -> bool {
    is_numbered(name, DELETED)
}

/// Whether a name is that of a world with this ending, which may have a number.
fn is_numbered(name: &str, ending: &str) -> bool {
    let Some((world, end)) = name.split_once('.') else { return false };
    let number = end.strip_prefix(ending).and_then(|end| number_of(end, "-"));
    is_world(world) && (end == ending || number.is_some_and(|number| number >= SECOND))
}

/// Whether this is the name of one that was set aside.
pub(super) fn is_damaged(name: &str) -> bool {
    is_numbered(name, DAMAGED)
}

/// The last one that was set aside of the world in this folder.
pub(super) fn last_damaged(storage: &dyn Storage, folder: &Path) -> Option<PathBuf> {
    let first = folder.with_extension(DAMAGED);
    let numbered = (SECOND..).map(|number| PathBuf::from(format!("{}-{number}", first.display())));
    let all = std::iter::once(first.clone()).chain(numbered);
    all.take_while(|path| !storage.is_free(path)).last()
}

/// The place of the folder of a world, or a snapshot, that is set aside.
pub(super) fn damaged(storage: &dyn Storage, path: &Path) -> PathBuf {
    free(storage, &path.with_extension(DAMAGED))
}

/// The number in the second of several names that are otherwise the same.
const SECOND: u64 = 2;

/// A free name like this one.
fn free(storage: &dyn Storage, path: &Path) -> PathBuf {
    let numbered = |number: u64| PathBuf::from(format!("{}-{number}", path.display()));
    let mut names = std::iter::once(path.to_owned()).chain((SECOND..).map(numbered));
    names.find(|name| storage.is_free(name)).expect("numbers do not end")
}
