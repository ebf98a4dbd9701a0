//! A disk that is simulated. It has what programs see, and what would be there if the power failed now.
//!
//! A disk keeps the promises that an operating system makes, and no more: names are on the disk with their folder's
//! sync, bytes with their file's. After a power cut each change of a name is there or not, and blocks that were not
//! forced onto the disk are there or not, each by itself, as zeros or as what another block had. A sync that fails
//! has lost what it should have written: the next one does not write it, as on Linux.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Component, Path};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use baudbot_server::{Listed, Storage, Stored, StoredKind};

use super::power::{Names, Node, Tear};
use super::trace::Trace;
use crate::chance::Chance;

/// The disk. Clones are the same.
#[derive(Clone, Debug)]
pub(crate) struct Disk(Arc<Mutex<State>>);

#[derive(Debug)]
struct State {
    chance: Chance,
    trace: Trace,
    nodes: BTreeMap<u64, Node>,
    last_node: u64,
    /// The number of the program that may write. One that was killed cannot.
    living: u64,
    /// The program dies so many changes from now on, if it does.
    dies_in: Option<u64>,
    /// The time of that death.
    died: Option<Duration>,
    /// A change fails so many changes from now on, if one does.
    fails_in: Option<u64>,
    /// Something has failed since this was asked last.
    has_failed: bool,
    is_full: bool,
    /// Time that changes have taken since the clock went on last.
    stalled: Duration,
    stalls: bool,
}

const ROOT: u64 = 0;

/// The disk as one program sees it, until it is killed.
#[derive(Clone, Debug)]
pub(crate) struct Mounted {
    disk: Disk,
    program: u64,
}

#[derive(Debug)]
struct Open {
    mounted: Mounted,
    node: u64,
    name: String,
}

/// The fate of a change.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Done,
    /// The program dies before it, in the middle of it, or after it.
    Dies,
    /// The operation fails, and a part of it may be done.
    Fails,
    /// The same for want of space.
    Full,
}

impl Disk {
    pub(crate) fn new(seed: u64, trace: Trace) -> Self {
        Self(Arc::new(Mutex::new(State {
            chance: Chance::of(seed, "disk"),
            trace,
            nodes: BTreeMap::from([(ROOT, Node::folder())]),
            last_node: ROOT,
            living: 0,
            dies_in: None,
            died: None,
            fails_in: None,
            has_failed: false,
            is_full: false,
            stalled: Duration::ZERO,
            stalls: false,
        })))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The disk for the next program.
    pub(crate) fn mount(&self) -> Mounted {
        let mut state = self.state();
        state.living += 1;
        (state.dies_in, state.died, state.fails_in) = (None, None, None);
        (state.is_full, state.stalls) = (false, false);
        Mounted { disk: self.clone(), program: state.living }
    }

    /// The program dies so many changes from now on, in the middle of one.
    pub(crate) fn kill_in(&self, changes: u64) {
        self.state().dies_in = Some(changes);
    }

    /// Kills the program now, unless it is dead already. Returns the time of its death.
    pub(crate) fn kill(&self) -> Duration {
        let mut state = self.state();
        state.living += 1;
        let now = state.trace.now();
        *state.died.get_or_insert(now)
    }

    /// A change fails so many changes from now on.
    pub(crate) fn fail_in(&self, changes: u64) {
        self.state().fails_in = Some(changes);
    }

    /// Whether something has failed since this was asked last.
    pub(crate) fn has_failed(&self) -> bool {
        std::mem::take(&mut self.state().has_failed)
    }

    pub(crate) fn set_full(&self, is_full: bool) {
        self.state().is_full = is_full;
    }

    pub(crate) fn set_stalls(&self, stalls: bool) {
        self.state().stalls = stalls;
    }

    /// The time that changes have taken since this was asked last: by so much the runtime's clock has to go on.
    pub(crate) fn stalled(&self) -> Duration {
        std::mem::take(&mut self.state().stalled)
    }

    /// The power fails, and comes back.
    pub(crate) fn lose_power(&self) {
        let how = Tear::of(&mut self.state().chance);
        self.lose_power_so(how);
    }

    /// The same, with this of what was not on the disk.
    pub(crate) fn lose_power_so(&self, how: Tear) {
        let mut state = self.state();
        state.living += 1;
        let State { chance, nodes, trace, .. } = &mut *state;
        trace.note(format!("the power fails; of what is not on the disk there is {how:?}"));
        nodes.values_mut().for_each(|node| node.lose_power(how, chance));
    }
}

impl State {
    fn find(&self, path: &Path) -> io::Result<u64> {
        let mut at = ROOT;
        for part in path.components() {
            let Component::Normal(name) = part else { continue };
            at = *self.names(at)?.get(name.to_str().unwrap()).ok_or(ErrorKind::NotFound)?;
        }
        Ok(at)
    }

    fn names(&self, folder: u64) -> io::Result<&Names> {
        match &self.nodes[&folder] {
            Node::Folder(folder) => Ok(folder.now()),
            Node::File(_) => Err(ErrorKind::NotADirectory.into()),
        }
    }

    /// The folder that has a name, and the name.
    fn parent(&self, path: &Path) -> io::Result<(u64, String)> {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        Ok((self.find(path.parent().unwrap())?, name))
    }

    fn folder(&mut self, node: u64) -> io::Result<&mut super::power::Folder> {
        match self.nodes.get_mut(&node) {
            Some(Node::Folder(folder)) => Ok(folder),
            Some(Node::File(_)) | None => Err(ErrorKind::NotADirectory.into()),
        }
    }

    fn file(&mut self, node: u64) -> io::Result<&mut super::power::File> {
        match self.nodes.get_mut(&node) {
            Some(Node::File(file)) => Ok(file),
            Some(Node::Folder(_)) | None => Err(ErrorKind::IsADirectory.into()),
        }
    }

    fn add(&mut self, path: &Path, node: Node) -> io::Result<u64> {
        let (folder, name) = self.parent(path)?;
        self.last_node += 1;
        let number = self.last_node;
        self.nodes.insert(number, node);
        self.folder(folder)?.set(name, number);
        Ok(number)
    }

    /// The fate of the next change, which takes its time.
    fn fate(&mut self, what: &str, needs_space: bool) -> Fate {
        if self.stalls {
            self.stalled += self.chance.ms(0, 4000);
        }
        let is_up = |count: &mut Option<u64>| match count {
            Some(0) => true,
            Some(left) => {
                *left -= 1;
                false
            }
            None => false,
        };
        let fate = if is_up(&mut self.dies_in) {
            self.living += 1;
            self.died = Some(self.trace.now());
            Fate::Dies
        } else if is_up(&mut self.fails_in) {
            (self.fails_in, self.has_failed) = (None, true);
            Fate::Fails
        } else if self.is_full && needs_space {
            Fate::Full
        } else {
            Fate::Done
        };
        self.trace.note(format!("    {what}{}", fate.words()));
        fate
    }

    /// A change that is done whole or not at all.
    fn change(&mut self, what: &str, change: impl FnOnce(&mut Self) -> io::Result<()>) -> io::Result<()> {
        let fate = self.fate(what, false);
        if fate == Fate::Done || (fate == Fate::Dies && self.chance.one_in(2)) {
            change(self)?;
        }
        fate.result()
    }

    fn append(&mut self, (node, name): (u64, &str), bytes: &[u8]) -> io::Result<()> {
        let fate = self.fate(&format!("{name}: {} bytes more", bytes.len()), true);
        let part = match fate {
            Fate::Done => bytes.len(),
            Fate::Dies | Fate::Fails | Fate::Full => self.chance.below(bytes.len() as u64 + 1) as usize,
        };
        self.file(node)?.append(&bytes[..part]);
        fate.result()
    }
}

impl Fate {
    fn words(self) -> &'static str {
        match self {
            Self::Done => "",
            Self::Dies => ": THE PROGRAM DIES",
            Self::Fails => ": FAILS",
            Self::Full => ": FULL",
        }
    }

    fn result(self) -> io::Result<()> {
        match self {
            Self::Done => Ok(()),
            Self::Dies => Err(killed()),
            Self::Fails => Err(io::Error::other("the disk has failed")),
            Self::Full => Err(ErrorKind::StorageFull.into()),
        }
    }
}

fn killed() -> io::Error {
    io::Error::other("the program was killed")
}

impl Mounted {
    /// Whether the program lives.
    pub(crate) fn is_alive(&self) -> bool {
        self.disk.state().living == self.program
    }

    fn state(&self) -> io::Result<MutexGuard<'_, State>> {
        let state = self.disk.state();
        if state.living == self.program { Ok(state) } else { Err(killed()) }
    }

    fn opened(&self, path: &Path, node: u64) -> Box<dyn Stored> {
        Box::new(Open { mounted: self.clone(), node, name: path.display().to_string() })
    }
}

impl Storage for Mounted {
    fn now(&self) -> Instant {
        tokio::time::Instant::now().into_std() + self.disk.state().stalled
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state()?;
        let mut folders: Vec<_> = path.ancestors().filter(|path| path.file_name().is_some()).collect();
        folders.reverse();
        for path in folders {
            if state.find(path).is_err() {
                let fate = state.fate(&format!("make {}", path.display()), true);
                if fate == Fate::Done {
                    state.add(path, Node::folder())?;
                }
                fate.result()?;
            }
        }
        Ok(())
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<Listed>> {
        let state = self.state()?;
        let kind = |node| match &state.nodes[node] {
            Node::File { .. } => StoredKind::File,
            Node::Folder { .. } => StoredKind::Folder,
        };
        let names = state.names(state.find(folder)?)?.iter();
        Ok(names.map(|(name, node)| Listed { name: name.clone(), kind: kind(node) }).collect())
    }

    fn kind(&self, path: &Path) -> io::Result<StoredKind> {
        let state = self.state()?;
        match &state.nodes[&state.find(path)?] {
            Node::File { .. } => Ok(StoredKind::File),
            Node::Folder { .. } => Ok(StoredKind::Folder),
        }
    }

    fn is_free(&self, path: &Path) -> bool {
        self.disk.state().find(path).is_err()
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let mut state = self.state()?;
        let node = state.find(path)?;
        Ok(state.file(node)?.now().to_vec())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<Box<dyn Stored>> {
        let mut state = self.state()?;
        let node = match state.find(path) {
            Ok(node) => node,
            Err(_) => state.add(path, Node::file())?,
        };
        state.file(node)?.cut(0);
        state.append((node, &path.display().to_string()), bytes)?;
        Ok(self.opened(path, node))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn Stored>> {
        let node = self.state()?.find(path)?;
        Ok(self.opened(path, node))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let mut state = self.state()?;
        let what = format!("{} becomes {}", from.display(), to.display());
        let ((folder, from), (other, to)) = (state.parent(from)?, state.parent(to)?);
        assert_eq!(folder, other, "nothing moves between folders");
        if !state.names(folder)?.contains_key(&from) {
            return Err(ErrorKind::NotFound.into());
        }
        state.change(&what, |state| {
            state.folder(folder)?.rename(from, to);
            Ok(())
        })
    }

    fn remove_file(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state()?;
        state.find(path)?;
        let (folder, name) = state.parent(path)?;
        state.change(&format!("remove {}", path.display()), |state| {
            state.folder(folder)?.remove(name);
            Ok(())
        })
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        for Listed { name, .. } in self.list(path)? {
            self.remove_file(&path.join(name))?;
        }
        self.remove_file(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state()?;
        let folder = state.find(path)?;
        state.change(&format!("sync names of {}", path.display()), |state| {
            state.folder(folder)?.sync();
            Ok(())
        })
    }
}

impl Stored for Open {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.mounted.state()?.append((self.node, &self.name), bytes)
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        let mut state = self.mounted.state()?;
        let node = self.node;
        state.change(&format!("{}: cut to {length}", self.name), |state| {
            state.file(node)?.cut(length as usize);
            Ok(())
        })
    }

    fn sync(&self) -> io::Result<()> {
        let mut state = self.mounted.state()?;
        let is_longer = state.file(self.node)?.is_longer();
        // A full disk may fail to force what it had taken.
        let fate = state.fate(&format!("sync {}", self.name), is_longer);
        match fate {
            Fate::Done => state.file(self.node)?.sync(),
            Fate::Fails | Fate::Full => state.file(self.node)?.fail_to_sync(),
            Fate::Dies => {}
        }
        fate.result()
    }
}
