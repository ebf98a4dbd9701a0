//! The files of a world: what is to be written, what is on the disk, and what is done if it cannot be written.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use tokio::sync::OwnedSemaphorePermit;

use super::file_names;
use super::shared::{Shared, write_whole};
use super::storage::{Storage, Stored};
use super::work::Work;
use crate::pool::Waker;
use crate::report::Keeping;

/// Bytes that wait for the disk, at most, beside those of a whole state.
const MOST_WAITING: usize = 16 << 20;

/// The files of a world. Work is carried out in the order in which it came, by whichever thread.
#[derive(Debug)]
pub(crate) struct WorldFiles {
    folder: PathBuf,
    shared: Shared,
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
    /// Wakes the world.
    waker: OnceLock<Waker>,
}

#[derive(Debug, Default)]
struct Queue {
    work: VecDeque<Work>,
    bytes: usize,
}

#[derive(Debug, Default)]
struct Disk {
    /// The journal to which can be written, if there is one.
    journal: Option<JournalFile>,
    /// The number of the last journal.
    number: u64,
    /// Snapshots that are not on the disk for good.
    snapshots: Vec<PathBuf>,
    /// Snapshots that could not be forced onto it: they are written anew, as the system may take them for written.
    doubtful: Vec<PathBuf>,
    /// Journals that go when the present one is on the disk for good.
    former: Vec<PathBuf>,
}

/// A journal to which can be written.
#[derive(Debug)]
struct JournalFile {
    path: PathBuf,
    /// The journal's file, if it is open at the moment.
    open: Option<(Box<dyn Stored>, OwnedSemaphorePermit)>,
    /// Bytes that are whole.
    length: u64,
    /// Bytes that are on the disk for good.
    on_disk: Arc<AtomicU64>,
    /// Whether its name is, too.
    is_named: bool,
}

impl WorldFiles {
    /// The files in this folder. If there are journals of before, the world continues from them at this tick.
    pub(super) fn new(folder: PathBuf, shared: Shared, tick: u64) -> Self {
        let former = file_names::journals(&*shared.storage, &folder).unwrap_or_default();
        let number = former.first().map_or(0, |(number, _)| *number);
        let kept_tick = if former.is_empty() { 0 } else { tick };
        let former = former.into_iter().map(|(_, path)| path).collect();
        // A server that was killed may not have forced them onto the disk.
        let snapshots = file_names::snapshots(&*shared.storage, &folder).unwrap_or_default();
        let snapshots = snapshots.into_iter().map(|(_, path)| path).collect();
        Self::beginning(folder, shared, kept_tick, Disk { number, former, snapshots, ..Disk::default() })
    }

    /// None, as the folder's name is taken by something else.
    pub(super) fn none(folder: PathBuf, shared: Shared) -> Self {
        Self { is_taken: true, ..Self::beginning(folder, shared, 0, Disk::default()) }
    }

    fn beginning(folder: PathBuf, shared: Shared, kept_tick: u64, disk: Disk) -> Self {
        Self {
            folder,
            shared,
            queue: Mutex::default(),
            disk: Mutex::new(disk),
            problem: Mutex::default(),
            is_lost: AtomicBool::new(false),
            is_dirty: AtomicBool::new(false),
            kept_tick: AtomicU64::new(kept_tick),
            is_taken: false,
            waker: OnceLock::new(),
        }
    }

    /// Wakes the world from now on if something of it cannot be kept.
    pub(super) fn wakes_if_lost(&self, waker: Waker) {
        // The world has one task only.
        let _ = self.waker.set(waker);
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
            self.shared.threads.write(self);
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
            disk.end_journal();
            self.lose(&error.to_string());
        } else if !self.is_dirty.swap(true, Ordering::Relaxed) {
            self.shared.threads.sync(self);
        }
    }

    fn append_to(&self, disk: &mut Disk, bytes: &[u8], tick: u64) -> io::Result<()> {
        if disk.append(&self.shared, bytes)? {
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
                "the files under the world's name cannot be used and are left unchanged",
            ));
        }
        match work {
            Work::Append(bytes, tick) => self.append_to(disk, &bytes, tick),
            Work::Begin { journal, tick, snapshots, on_disk } => {
                self.storage().make_folder(&self.folder)?;
                for (number, bytes) in snapshots {
                    self.write_snapshot(disk, number, &bytes)?;
                }
                disk.begin(&self.shared, &self.folder, &journal, on_disk)?;
                self.kept_tick.store(tick, Ordering::Relaxed);
                *lock(&self.problem) = None;
                self.is_lost.store(false, Ordering::Release);
                Ok(())
            }
            // While there is no journal, a new one writes what is missing.
            Work::Snapshot(number, bytes) if disk.journal.is_some() => {
                self.write_snapshot(disk, number, &bytes)
            }
            Work::Snapshot(..) => Ok(()),
            Work::Forget(number) => {
                let path = file_names::snapshot(&self.folder, number);
                disk.snapshots.retain(|other| *other != path);
                match self.storage().remove_file(&path) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                    Ok(()) | Err(_) => Ok(()),
                }
            }
        }
    }

    /// The present instant, by the clock of what it is kept on.
    pub(super) fn now(&self) -> Instant {
        self.storage().now()
    }

    fn storage(&self) -> &dyn Storage {
        &*self.shared.storage
    }

    /// A snapshot never changes: one that is there is left as it is, unless it may not be on the disk.
    fn write_snapshot(&self, disk: &mut Disk, number: u64, bytes: &[u8]) -> io::Result<()> {
        let path = file_names::snapshot(&self.folder, number);
        if !self.storage().is_free(&path) && !disk.doubtful.contains(&path) {
            return Ok(());
        }
        write_whole(self.storage(), &path, bytes)?;
        disk.doubtful.retain(|other| *other != path);
        disk.snapshots.push(path);
        Ok(())
    }

    /// Nothing of the world is kept from now on, until another journal begins.
    fn lose(&self, problem: &str) {
        {
            let mut queue = lock(&self.queue);
            queue.work.clear();
            queue.bytes = 0;
            lock(&self.problem).get_or_insert_with(|| problem.to_owned());
        }
        if !self.is_lost.swap(true, Ordering::AcqRel) {
            // The world may have nothing to do, and no other reason to run.
            self.waker.get().inspect(|waker| waker.wake(None));
        }
    }

    pub(super) fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Acquire)
    }

    /// The reason why nothing is kept.
    pub(super) fn problem(&self) -> String {
        lock(&self.problem).clone().unwrap_or_default()
    }

    pub(super) fn keeping(&self) -> Keeping {
        Keeping { is_lost: self.is_lost(), tick: self.kept_tick.load(Ordering::Relaxed) }
    }

    /// Forces onto the disk what was written, and removes what that has replaced.
    pub(super) fn sync(&self) {
        self.is_dirty.store(false, Ordering::Relaxed);
        let Some(unsynced) = lock(&self.disk).unsynced() else { return };
        // The lock is not held during the slow calls.
        let synced = self.force(&unsynced);
        let Unsynced { journal, snapshots, former } = unsynced;
        match synced {
            Ok(()) => {
                journal.on_disk.store(journal.length, Ordering::Relaxed);
                former.iter().for_each(|path| drop(self.storage().remove_file(path)));
                if let Some(present) = &mut lock(&self.disk).journal {
                    present.is_named |= present.path == journal.path;
                }
            }
            Err(error) => {
                let mut disk = lock(&self.disk);
                disk.doubtful.extend(snapshots);
                disk.former.extend(former);
                disk.end_journal();
                drop(disk);
                self.lose(&error.to_string());
            }
        }
    }

    fn force(&self, Unsynced { journal, snapshots, former }: &Unsynced) -> io::Result<()> {
        let storage = self.storage();
        for path in snapshots {
            match storage.open(path) {
                // The file is not kept any more.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                opened => opened?.sync()?,
            }
        }
        match &journal.open {
            Some((file, _)) => file.sync()?,
            None => storage.open(&journal.path)?.sync()?,
        }
        // Names are on the disk with their folders only, and so is that of the world's own folder.
        if !journal.is_named || !snapshots.is_empty() || !former.is_empty() {
            storage.sync_folder(&self.folder)?;
            self.folder.parent().map_or(Ok(()), |worlds| storage.sync_folder(worlds))?;
        }
        Ok(())
    }

    /// The world is gone for good: its folder goes with it.
    pub(super) fn remove(&self) -> io::Result<()> {
        let mut disk = lock(&self.disk);
        lock(&self.queue).work.clear();
        disk.journal = None;
        if self.is_taken {
            return Ok(());
        }
        // Whole or not at all, should the program be killed meanwhile.
        let gone = file_names::deleted(self.storage(), &self.folder);
        match self.storage().rename(&self.folder, &gone) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            renamed => renamed.and_then(|()| {
                // The folder is not to be there again after a power cut.
                self.folder.parent().map_or(Ok(()), |worlds| self.storage().sync_folder(worlds))?;
                self.storage().remove_folder(&gone)
            }),
        }
    }
}

/// The writes to be forced onto the disk.
struct Unsynced {
    journal: JournalFile,
    snapshots: Vec<PathBuf>,
    former: Vec<PathBuf>,
}

impl Disk {
    /// Whether there is a journal.
    fn append(&mut self, shared: &Shared, bytes: &[u8]) -> io::Result<bool> {
        self.journal.as_mut().map_or(Ok(false), |journal| journal.append(shared, bytes).map(|()| true))
    }

    /// Another journal, which is there whole or not at all, should the program be killed meanwhile.
    fn begin(
        &mut self,
        shared: &Shared,
        folder: &Path,
        journal: &[u8],
        on_disk: Arc<AtomicU64>,
    ) -> io::Result<()> {
        let storage = &*shared.storage;
        let mut numbers = (self.number + 1..).map(|number| (number, file_names::journal(folder, number)));
        // Something else may be there, which is not replaced.
        let (number, path) = numbers.find(|(_, path)| storage.is_free(path)).expect("numbers do not end");
        let file = write_whole(storage, &path, journal)?;
        // The end of the old journal frees its place for the new one.
        self.end_journal();
        let open = shared.place().map(|place| (file, place));
        let length = journal.len() as u64;
        (self.number, self.journal) =
            (number, Some(JournalFile { path, open, length, on_disk, is_named: false }));
        Ok(())
    }

    /// Nothing is written to the journal any more.
    fn end_journal(&mut self) {
        self.former.extend(self.journal.take().map(|journal| journal.path));
    }

    /// The files to be forced onto the disk, if there is a journal. It is closed, and opened again when something is to
    /// be written.
    fn unsynced(&mut self) -> Option<Unsynced> {
        let journal = self.journal.as_mut()?;
        let (path, on_disk, open) = (journal.path.clone(), Arc::clone(&journal.on_disk), journal.open.take());
        let journal = JournalFile { path, open, on_disk, ..*journal };
        let (snapshots, former) = (std::mem::take(&mut self.snapshots), std::mem::take(&mut self.former));
        Some(Unsynced { journal, snapshots, former })
    }
}

impl JournalFile {
    fn append(&mut self, shared: &Shared, bytes: &[u8]) -> io::Result<()> {
        let (mut file, place) = match self.open.take() {
            Some((file, place)) => (file, Some(place)),
            None => (shared.storage.open(&self.path)?, shared.place()),
        };
        file.append_whole(&mut self.length, bytes)?;
        self.open = place.map(|place| (file, place));
        Ok(())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // The content is consistent between any two of its changes.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
