//! The content of files and folders, and the part of it that a power cut leaves.

use std::collections::BTreeMap;

use crate::chance::Chance;

/// A file or a folder.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    File(File),
    Folder(Folder),
}

/// A file.
#[derive(Clone, Debug, Default)]
pub(crate) struct File {
    now: Vec<u8>,
    on_disk: Vec<u8>,
    /// The range for which a sync has failed: its bytes are not written any more.
    lost: (usize, usize),
}

pub(crate) type Names = BTreeMap<String, u64>;

/// A folder.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folder {
    now: Names,
    on_disk: Names,
    pending: Vec<Change>,
}

/// A change of a folder's names, which is there whole or not at all.
#[derive(Clone, Debug)]
enum Change {
    Set(String, u64),
    Gone(String),
    Renamed(String, String),
}

const BLOCK: usize = 512;

/// A power cut's choice of the blocks that were not forced onto the disk.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tear {
    Nothing,
    All,
    /// The names and bytes that were given first.
    Beginning,
    /// Any names, and any blocks.
    Any,
}

impl Tear {
    pub(crate) fn of(chance: &mut Chance) -> Self {
        *chance.one(&[Self::Nothing, Self::All, Self::Beginning, Self::Any, Self::Any])
    }
}

impl Node {
    pub(crate) fn file() -> Self {
        Self::File(File::default())
    }

    pub(crate) fn folder() -> Self {
        Self::Folder(Folder::default())
    }

    pub(crate) fn lose_power(&mut self, how: Tear, chance: &mut Chance) {
        match self {
            Self::File(file) => {
                file.now = file.torn(how, chance);
                file.on_disk.clone_from(&file.now);
                file.lost = (0, 0);
            }
            Self::Folder(folder) => {
                folder.tear(how, chance);
                folder.now.clone_from(&folder.on_disk);
            }
        }
    }
}

impl File {
    pub(crate) fn now(&self) -> &[u8] {
        &self.now
    }

    pub(crate) fn append(&mut self, bytes: &[u8]) {
        self.now.extend(bytes);
    }

    pub(crate) fn cut(&mut self, length: usize) {
        self.now.truncate(length);
        self.lost = (self.lost.0.min(length), self.lost.1.min(length));
    }

    pub(crate) fn is_longer(&self) -> bool {
        self.now.len() > self.on_disk.len()
    }

    pub(crate) fn sync(&mut self) {
        self.on_disk = self.written();
    }

    pub(crate) fn fail_to_sync(&mut self) {
        let from = self.same();
        if from < self.now.len() {
            self.lost =
                (if self.lost.0 < self.lost.1 { self.lost.0.min(from) } else { from }, self.now.len());
        }
    }

    /// Bytes at the beginning that are on the disk.
    fn same(&self) -> usize {
        self.now.iter().zip(&self.on_disk).take_while(|(a, b)| a == b).count()
    }

    /// The content of the disk if all that still can be there is there.
    fn written(&self) -> Vec<u8> {
        let mut written = self.now.clone();
        written[self.lost.0..self.lost.1].fill(0);
        written
    }

    fn torn(&self, how: Tear, chance: &mut Chance) -> Vec<u8> {
        let (same, mut torn) = (self.same(), self.written());
        let unsure = torn.len() - same;
        match how {
            Tear::Nothing => return self.on_disk.clone(),
            Tear::All => {}
            Tear::Beginning => torn.truncate(same + chance.below(unsure as u64 + 1) as usize),
            Tear::Any => {
                torn.truncate(same + chance.below(unsure as u64 + 1) as usize);
                tear_blocks(&mut torn, same, chance);
            }
        }
        torn
    }
}

fn tear_blocks(torn: &mut [u8], same: usize, chance: &mut Chance) {
    let mut from = same;
    while from < torn.len() {
        let end = ((from / BLOCK + 1) * BLOCK).min(torn.len());
        match chance.below(6) {
            0 => torn[from..end].fill(0),
            1 => torn[from..end].fill_with(|| chance.next() as u8),
            2 if from >= BLOCK => torn.copy_within(from - BLOCK..end - BLOCK, from),
            _ => {}
        }
        from = end;
    }
}

impl Folder {
    pub(crate) fn now(&self) -> &Names {
        &self.now
    }

    pub(crate) fn set(&mut self, name: String, node: u64) {
        self.change(Change::Set(name, node));
    }

    pub(crate) fn remove(&mut self, name: String) {
        self.change(Change::Gone(name));
    }

    pub(crate) fn rename(&mut self, from: String, to: String) {
        self.change(Change::Renamed(from, to));
    }

    pub(crate) fn sync(&mut self) {
        self.on_disk.clone_from(&self.now);
        self.pending.clear();
    }

    fn change(&mut self, change: Change) {
        change.clone().apply(&mut self.now);
        self.pending.push(change);
    }

    fn tear(&mut self, how: Tear, chance: &mut Chance) {
        let all = self.pending.len();
        let first = match how {
            Tear::Nothing => 0,
            Tear::Beginning => chance.below(all as u64 + 1) as usize,
            Tear::All | Tear::Any => all,
        };
        let changes = self.pending.drain(..).take(first);
        let kept = changes.filter(|_| !matches!(how, Tear::Any) || chance.one_in(2));
        kept.for_each(|change| change.apply(&mut self.on_disk));
    }
}

impl Change {
    fn apply(self, names: &mut Names) {
        match self {
            Self::Set(name, node) => drop(names.insert(name, node)),
            Self::Gone(name) => drop(names.remove(&name)),
            Self::Renamed(from, to) => {
                if let Some(node) = names.remove(&from) {
                    names.insert(to, node);
                }
            }
        }
    }
}
