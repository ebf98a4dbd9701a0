//! The memory of a process at its start: no vDSO, chosen random bytes, and a place of ours in its memory.

use crate::error::Error;
use crate::fault::Fault;
use crate::os::trace::Registers;
use crate::random::Random;
use crate::task::{SCRATCH, Task};

/// Entries of the auxiliary vector (linux/auxvec.h).
const AT_NULL: u64 = 0;
const AT_IGNORE: u64 = 1;
const AT_RANDOM: u64 = 25;
const AT_SYSINFO_EHDR: u64 = 33;
/// More words than the kernel lets a program have are no list.
const MOST_WORDS: usize = 1 << 21;

/// Prepares a task that stands just behind an exec; these are its registers.
///
/// The vDSO would tell the time without a call, so its entry goes. The lists that lie at the top of the stack (words, environment,
/// auxiliary vector) move down, which nothing in them minds; the gap above them is ours.
pub(crate) fn prepare(task: &mut Task, mut registers: Registers, random: &mut Random) -> Result<(), Error> {
    let name = |task: &Task| task.failure("reading its first stack", std::io::ErrorKind::InvalidData.into());
    let Ok((lists, random_at)) = lists(task, registers.rsp) else { return Err(name(task)) };
    let end = registers.rsp + 8 * lists.len() as u64;
    let bytes: Vec<u8> = lists.iter().flat_map(|word| word.to_ne_bytes()).collect();
    registers.rsp -= SCRATCH;
    task.scratch = end - SCRATCH;
    let is_written = task.write(registers.rsp, &bytes).is_ok()
        && random_at.is_none_or(|place| task.write(place, &random.bytes(16)).is_ok());
    if is_written { task.set(&registers) } else { Err(name(task)) }
}

/// The lists, without the vDSO, and the address of the random bytes.
fn lists(task: &Task, start: u64) -> Result<(Vec<u64>, Option<u64>), Fault> {
    let mut lists = Vec::new();
    let next = |lists: &mut Vec<u64>| {
        let word = task.read_u64(start + 8 * lists.len() as u64)?;
        lists.push(word);
        if lists.len() < MOST_WORDS { Ok(word) } else { Err(Fault::Errno(libc::E2BIG)) }
    };
    next(&mut lists)?;
    for _ in ["words", "environment"] {
        while next(&mut lists)? != 0 {}
    }
    let mut random_at = None;
    loop {
        let place = lists.len();
        let (kind, value) = (next(&mut lists)?, next(&mut lists)?);
        match kind {
            AT_NULL => return Ok((lists, random_at)),
            AT_SYSINFO_EHDR => lists[place] = AT_IGNORE,
            AT_RANDOM => random_at = Some(value),
            _ => {}
        }
    }
}
