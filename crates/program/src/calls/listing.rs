//! The list of /dev: the ports are in it, and the machine's own serial ports are not, so that programs which look for ports find these.

use std::path::Path;

use super::Outcome;
use super::paths::{FIRST_INODE, HIDDEN};
use crate::cables::Cables;
use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::task::After;

const FOLDER: &str = "/dev";
/// The place of the name in `struct linux_dirent64`, behind inode (8 bytes), offset (8), length (2) and type (1).
const NAME_AT: usize = 19;

pub(super) fn list(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let is_ours =
        kernel.files.name(caller, caller.descriptor(0)).is_some_and(|file| *file == *Path::new(FOLDER));
    Ok(if is_ours { Outcome::Observed(After::Listing) } else { Outcome::Native })
}

pub(super) fn leave(kernel: &mut Kernel, task: usize) -> Result<(), Error> {
    let caller = &mut kernel.tasks[task];
    let length = caller.value()?;
    let mut list = vec![0; usize::try_from(length).unwrap_or(0)];
    if list.is_empty() || caller.read(caller.argument(1), &mut list).is_err() {
        caller.complete();
        return caller.returns(length);
    }
    let (mut kept, mut rest, mut is_first, mut offset) = (Vec::new(), &list[..], false, [0; 8]);
    while rest.len() > NAME_AT {
        let (entry, behind) =
            rest.split_at(usize::from(u16::from_ne_bytes([rest[16], rest[17]])).min(rest.len()));
        let name = entry[NAME_AT..].split(|byte| *byte == 0).next().unwrap_or_default();
        is_first |= name == b".";
        if !HIDDEN.iter().any(|hidden| name.starts_with(&hidden[FOLDER.len() + 1..])) {
            kept.extend_from_slice(entry);
        }
        offset.copy_from_slice(&entry[8..16]);
        rest = behind;
    }
    let names = kernel.ports.iter().enumerate().filter_map(|(port, tty)| {
        let name = tty.path.strip_prefix(FOLDER)?.strip_prefix('/')?;
        (is_first && !name.contains('/')).then(|| entry(FIRST_INODE + port as u64, offset, name))
    });
    for entry in names {
        if kept.len() + entry.len() <= caller.argument(2) as usize {
            kept.extend(entry);
        }
    }
    if kept.is_empty() || caller.write(caller.argument(1), &kept).is_err() {
        return caller.rewind(None);
    }
    caller.complete();
    caller.returns(kept.len() as i64)
}

/// A `struct linux_dirent64` of a character device.
fn entry(inode: u64, offset: [u8; 8], name: &str) -> Vec<u8> {
    let length = (NAME_AT + name.len() + 1).next_multiple_of(8);
    let mut entry = inode.to_ne_bytes().to_vec();
    entry.extend(offset);
    entry.extend((length as u16).to_ne_bytes());
    entry.push(libc::DT_CHR);
    entry.extend(name.as_bytes());
    entry.resize(length, 0);
    entry
}
