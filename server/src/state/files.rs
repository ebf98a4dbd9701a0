//! The files of a world: what is to be written, what is on the disk, and what is done if it cannot be written.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::threads::Threads;
use super::{file_names, private};
use crate::report::Keeping;

/// Bytes that wait for the disk, at most, beside those of a whole state.
const MOST_WAITING: usize = 16 << 20;

/// The files of a world. Work is carried out in the order in which it came, by whichever thread.
#[derive(Debug)]
pub(crate) struct WorldFiles {
    folder: PathBuf,
    threads: Threads,
    queue: Mutex<Queue>,
    disk: Mutex<Disk>,
    problem: Mutex<Option<String>>,
    is_lost: AtomicBool,
    /// Something was written since files were last forced onto the disk.
    is_dirty: AtomicBool,
    /// The last tick that is in a journal.
    kept_tick: AtomicU64,
    /// The folder's name is taken by something else, which is left as it is: nothing is written.
    is_taken: bool,
}

/// What is to be written.
#[derive(Debug)]
pub(super) enum Work {
    /// More of the journal, up to this tick.
    Append(Vec<u8>, u64),
    /// Another journal, up to this tick, and snapshots that may not have been written yet.
    Begin {
        journal: Vec<u8>,
        tick: u64,
        snapshots: Vec<(u64, Vec<u8>)>,
    },
    Snapshot(u64, Vec<u8>),
    /// A snapshot is not kept any more.
    Forget(u64),
}

#[derive(Debug, Default)]
struct Queue {
    work: VecDeque<Work>,
    bytes: usize,
}

#[derive(Debug, Default)]
struct Disk {
    /// The journal; `None` while none can be written.
    file: Option<File>,
    path: PathBuf,
    number: u64,
    /// Bytes of the journal that are whole.
    length: u64,
    /// Journals that go when the present one is on the disk for good.
    former: Vec<PathBuf>,
}

impl WorldFiles {
    /// The files in this folder. If there are journals of before, the world continues from them at this tick.
    pub(super) fn new(folder: PathBuf, threads: Threads, tick: u64) -> Self {
        let former = file_names::journals(&folder).unwrap_or_default();
        let number = former.first().map_or(0, |(number, _)| *number);
        let kept_tick = if former.is_empty() { 0 } else { tick };
        let former = former.into_iter().map(|(_, path)| path).collect();
        Self::beginning(folder, threads, kept_tick, Disk { number, former, ..Disk::default() })
    }

    /// None, as the folder's name is taken by something else.
    pub(super) fn none(folder: PathBuf, threads: Threads) -> Self {
        Self { is_taken: true, ..Self::beginning(folder, threads, 0, Disk::default()) }
    }

    fn beginning(folder: PathBuf, threads: Threads, kept_tick: u64, disk: Disk) -> Self {
        Self {
            folder,
            threads,
            queue: Mutex::default(),
            disk: Mutex::new(disk),
            problem: Mutex::default(),
            is_lost: AtomicBool::new(false),
            is_dirty: AtomicBool::new(false),
            kept_tick: AtomicU64::new(kept_tick),
            is_taken: false,
        }
    }

    /// Takes work, and carries it out on this thread if the caller `waits`.
    pub(super) fn add(self: &Arc<Self>, work: Work, waits: bool) {
        let is_too_much = {
            let mut queue = lock(&self.queue);
            queue.bytes += work.bytes();
            queue.work.push_back(work);
            !waits && queue.bytes > MOST_WAITING + queue.work.iter().map(Work::whole).max().unwrap_or(0)
        };
        if is_too_much {
            self.lose("the disk is slower than the world");
        } else if waits {
            self.write();
        } else {
            self.threads.write(self);
        }
    }

    /// Carries out all work that waits.
    pub(super) fn write(self: &Arc<Self>) {
        self.write_all(&mut lock(&self.disk));
    }

    fn write_all(self: &Arc<Self>, disk: &mut Disk) {
        while let Some(work) = self.next() {
            let written = self.carry_out(disk, work);
            self.note(disk, written);
        }
    }

    /// Adds to the journal, up to this tick, on this thread.
    pub(super) fn append(self: &Arc<Self>, bytes: &[u8], tick: u64) {
        let mut disk = lock(&self.disk);
        self.write_all(&mut disk);
        let written = self.append_to(&mut disk, bytes, tick);
        self.note(&mut disk, written);
    }

    fn note(self: &Arc<Self>, disk: &mut Disk, written: io::Result<()>) {
        if let Err(error) = written {
            disk.give_up();
            self.lose(&error.to_string());
        } else if !self.is_dirty.swap(true, Ordering::Relaxed) {
            self.threads.sync(self);
        }
    }

    fn append_to(&self, disk: &mut Disk, bytes: &[u8], tick: u64) -> io::Result<()> {
        if disk.append(bytes)? {
            self.kept_tick.store(tick, Ordering::Relaxed);
        }
        Ok(())
    }

    fn next(&self) -> Option<Work> {
        let mut queue = lock(&self.queue);
        let work = queue.work.pop_front()?;
        queue.bytes -= work.bytes();
        Some(work)
    }

    fn carry_out(&self, disk: &mut Disk, work: Work) -> io::Result<()> {
        if self.is_taken {
            return Err(io::Error::other(
                "what was there under the world's name cannot be used and is left as it is",
            ));
        }
        match work {
            Work::Append(bytes, tick) => self.append_to(disk, &bytes, tick),
            Work::Begin { journal, tick, snapshots } => {
                private::make_folder(&self.folder)?;
                for (number, bytes) in snapshots {
                    self.write_snapshot(number, &bytes)?;
                }
                disk.begin(&self.folder, &journal)?;
                self.kept_tick.store(tick, Ordering::Relaxed);
                *lock(&self.problem) = None;
                self.is_lost.store(false, Ordering::Release);
                Ok(())
            }
            // While there is no journal, a new one writes what is missing.
            Work::Snapshot(number, bytes) if disk.file.is_some() => self.write_snapshot(number, &bytes),
            Work::Snapshot(..) => Ok(()),
            Work::Forget(number) => match fs::remove_file(file_names::snapshot(&self.folder, number)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                Ok(()) | Err(_) => Ok(()),
            },
        }
    }

    /// A snapshot never changes: one that is there is left as it is.
    fn write_snapshot(&self, number: u64, bytes: &[u8]) -> io::Result<()> {
        let path = file_names::snapshot(&self.folder, number);
        if path.exists() {
            return Ok(());
        }
        let new = path.with_extension(file_names::UNFINISHED);
        let written = private::write(&new, bytes).and_then(|_| fs::rename(&new, &path));
        if written.is_err() {
            let _ = fs::remove_file(&new);
        }
        written
    }

    /// Nothing of the world is kept from now on, until another journal begins.
    fn lose(&self, problem: &str) {
        let mut queue = lock(&self.queue);
        queue.work.clear();
        queue.bytes = 0;
        lock(&self.problem).get_or_insert_with(|| problem.to_owned());
        self.is_lost.store(true, Ordering::Release);
    }

    pub(super) fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Acquire)
    }

    /// Why nothing is kept.
    pub(super) fn problem(&self) -> String {
        lock(&self.problem).clone().unwrap_or_default()
    }

    pub(super) fn keeping(&self) -> Keeping {
        Keeping { is_lost: self.is_lost(), tick: self.kept_tick.load(Ordering::Relaxed) }
    }

    /// Forces onto the disk what was written, and removes what that has replaced.
    pub(super) fn sync(&self) {
        self.is_dirty.store(false, Ordering::Relaxed);
        let (file, former) = {
            let mut disk = lock(&self.disk);
            let Some(file) = disk.file.as_ref().and_then(|file| file.try_clone().ok()) else { return };
            (file, std::mem::take(&mut disk.former))
        };
        // Nobody waits for this: no lock is held.
        let synced = match former.is_empty() {
            true => file.sync_data(),
            false => file.sync_all().and_then(|()| File::open(&self.folder)?.sync_all()),
        };
        match synced {
            Ok(()) => former.iter().for_each(|path| drop(fs::remove_file(path))),
            Err(error) => {
                let mut disk = lock(&self.disk);
                disk.former.extend(former);
                disk.file = None;
                drop(disk);
                self.lose(&error.to_string());
            }
        }
    }

    /// The world is gone for good: its folder goes with it.
    pub(super) fn remove(&self) -> io::Result<()> {
        let mut disk = lock(&self.disk);
        lock(&self.queue).work.clear();
        disk.file = None;
        if self.is_taken {
            return Ok(());
        }
        // Whole or not at all, should the program be killed meanwhile.
        let gone = file_names::deleted(&self.folder);
        match fs::rename(&self.folder, &gone) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            renamed => renamed.and_then(|()| fs::remove_dir_all(&gone)),
        }
    }
}

impl Disk {
    /// Whether there is a journal.
    fn append(&mut self, bytes: &[u8]) -> io::Result<bool> {
        let Some(file) = &mut self.file else { return Ok(false) };
        file.write_all(bytes)?;
        self.length += bytes.len() as u64;
        Ok(true)
    }

    /// Another journal, which is there whole or not at all, should the program be killed meanwhile.
    fn begin(&mut self, folder: &Path, journal: &[u8]) -> io::Result<()> {
        let mut numbers = (self.number + 1..).map(|number| (number, file_names::journal(folder, number)));
        // Something else may be there, which is not replaced.
        let (number, path) = numbers.find(|(_, path)| file_names::is_free(path)).expect("numbers do not end");
        let new = path.with_extension(file_names::UNFINISHED);
        let written = private::write(&new, journal);
        let file = written.and_then(|file| fs::rename(&new, &path).map(|()| file)).inspect_err(|_| {
            let _ = fs::remove_file(&new);
        })?;
        if self.length > 0 {
            self.former.push(std::mem::take(&mut self.path));
        }
        (self.file, self.path, self.number, self.length) = (Some(file), path, number, journal.len() as u64);
        Ok(())
    }

    /// The journal ends where it is whole.
    fn give_up(&mut self) {
        if let Some(file) = self.file.take() {
            let _ = file.set_len(self.length);
        }
    }
}

impl Work {
    fn bytes(&self) -> usize {
        match self {
            Self::Append(bytes, _) | Self::Snapshot(_, bytes) => bytes.len(),
            Self::Begin { journal, snapshots, .. } => {
                journal.len() + snapshots.iter().map(|(_, bytes)| bytes.len()).sum::<usize>()
            }
            Self::Forget(_) => 0,
        }
    }

    /// Its bytes if they are a whole state, which may be large.
    fn whole(&self) -> usize {
        match self {
            Self::Begin { .. } | Self::Snapshot(..) => self.bytes(),
            Self::Append(..) | Self::Forget(_) => 0,
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What they hold is consistent between any two of its changes.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
