//! The storage of state, and its clock: the system's, or simulated ones.
//!
//! A simulated one tears writes, loses what was not forced onto the disk, is full, stalls, and turns the time, as a seed wants it
//! (`tests/tests/network/`).

use std::fmt::Debug;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use super::private;
use crate::clock;

/// Folders and files, and a clock.
pub trait Storage: Debug + Send + Sync {
    /// The present instant.
    fn now(&self) -> Instant;

    /// Makes a folder, and those above it, if it is not there.
    ///
    /// # Errors
    /// As the system's.
    fn make_folder(&self, path: &Path) -> io::Result<()>;

    /// The content of a folder, in any order.
    ///
    /// # Errors
    /// As the system's.
    fn list(&self, folder: &Path) -> io::Result<Vec<Listed>>;

    /// The kind of file at this path, links followed.
    ///
    /// # Errors
    /// As the system's.
    fn kind(&self, path: &Path) -> io::Result<Kind>;

    /// Whether nothing has this name, not even a link.
    fn is_free(&self, path: &Path) -> bool;

    /// All that is in a file.
    ///
    /// # Errors
    /// As the system's.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// Writes a file, to which more can be added, in place of what an earlier attempt may have left.
    ///
    /// # Errors
    /// As the system's.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<Box<dyn Stored>>;

    /// Opens a file that is there, to add to it.
    ///
    /// # Errors
    /// As the system's.
    fn open(&self, path: &Path) -> io::Result<Box<dyn Stored>>;

    /// Gives a file or a folder another name.
    ///
    /// # Errors
    /// As the system's.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// As the system's.
    fn remove_file(&self, path: &Path) -> io::Result<()>;

    /// Removes a folder with all that is in it.
    ///
    /// # Errors
    /// As the system's.
    fn remove_folder(&self, path: &Path) -> io::Result<()>;

    /// Forces the names in a folder onto the disk.
    ///
    /// # Errors
    /// As the system's.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
}

/// A file to which is written.
pub trait Stored: Debug + Send {
    /// Adds to its end.
    ///
    /// # Errors
    /// As the system's: a part may have been written.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Adds to its end, which is so far away, all of this or nothing. If not even what was written of it can be cut off, the file
    /// has a torn end, which its readers leave out.
    ///
    /// # Errors
    /// As the system's.
    fn append_whole(&mut self, length: &mut u64, bytes: &[u8]) -> io::Result<()> {
        self.append(bytes).inspect_err(|_| drop(self.cut(*length)))?;
        *length += bytes.len() as u64;
        Ok(())
    }

    /// Cuts it off.
    ///
    /// # Errors
    /// As the system's.
    fn cut(&mut self, length: u64) -> io::Result<()>;

    /// Forces onto the disk what was written.
    ///
    /// # Errors
    /// As the system's: what was written may not be there, and may be lost.
    fn sync(&self) -> io::Result<()>;
}

/// Something in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// The entry's name.
    pub name: String,
    /// The kind; a link is none of both.
    pub kind: Kind,
}

/// The kind of file under a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The entry is a file.
    File,
    /// The entry is a folder.
    Folder,
    /// Something else, which may hold up who opens it.
    Other,
}

/// The disk and the clock of the system.
#[derive(Clone, Copy, Debug)]
pub(super) struct System;

impl Storage for System {
    fn now(&self) -> Instant {
        clock::now()
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        private::make_folder(path)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<Listed>> {
        let listed = |entry: io::Result<fs::DirEntry>| {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            Ok(Listed { name, kind: kind_of(entry.file_type()?) })
        };
        fs::read_dir(folder)?.map(listed).collect()
    }

    fn kind(&self, path: &Path) -> io::Result<Kind> {
        Ok(kind_of(fs::metadata(path)?.file_type()))
    }

    fn is_free(&self, path: &Path) -> bool {
        path.symlink_metadata().is_err()
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        fs::read(path)
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<Box<dyn Stored>> {
        Ok(Box::new(private::write(path, bytes)?))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn Stored>> {
        Ok(Box::new(fs::OpenOptions::new().append(true).open(path)?))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn remove_file(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        fs::remove_dir_all(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }
}

fn kind_of(found: fs::FileType) -> Kind {
    match (found.is_file(), found.is_dir()) {
        (true, _) => Kind::File,
        (_, true) => Kind::Folder,
        (false, false) => Kind::Other,
    }
}

impl Stored for File {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }

    fn sync(&self) -> io::Result<()> {
        // The length of the file is part of its data.
        self.sync_data()
    }
}
