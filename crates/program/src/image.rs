//! The memory of a process at its start: a vDSO of ours or none, chosen random bytes, and a place of ours in its memory.

use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::os::clocks::PAGE;
use crate::os::trace::Registers;
use crate::task::{SCRATCH, Task};
use crate::vdso;

/// Entries of the auxiliary vector (linux/auxvec.h).
const AT_NULL: u64 = 0;
const AT_IGNORE: u64 = 1;
const AT_RANDOM: u64 = 25;
const AT_SYSINFO_EHDR: u64 = 33;
/// More words than the kernel lets a program have are no list.
const MOST_WORDS: usize = 1 << 21;

/// The lists that lie at the top of the first stack: words, environment, auxiliary vector.
#[derive(Default)]
struct Lists {
    words: Vec<u64>,
    /// The address of the random bytes.
    random_at: Option<u64>,
    /// The place of the vDSO's entry, and its address.
    vdso: Option<(usize, u64)>,
}

/// Prepares a task that stands just behind an exec; these are its registers.
///
/// The lists move down, which nothing in them minds; the gap above them is ours. The vDSO would tell the machine's time without a call,
/// so it is changed; if that fails, its entry goes.
pub(crate) fn prepare(kernel: &mut Kernel, place: usize, mut registers: Registers) -> Result<(), Error> {
    let Kernel { tasks, random, traps_clocks, report, .. } = kernel;
    let task = &mut tasks[place];
    let failed =
        |task: &Task| task.failure("reading its first stack", std::io::ErrorKind::InvalidData.into());
    let Ok(mut lists) = lists(task, registers.rsp) else { return Err(failed(task)) };
    let end = registers.rsp + 8 * lists.words.len() as u64;
    registers.rsp -= SCRATCH;
    task.scratch = end - SCRATCH;
    task.page = None;
    if let Some((entry, address)) = lists.vdso {
        let page = end - PAGE as u64;
        if !*traps_clocks {
            task.page = vdso::replace(task.tid, address, page).map(|()| page);
            report.trapped += u32::from(task.page.is_none());
        }
        if task.page.is_none() {
            lists.words[entry] = AT_IGNORE;
        }
    }
    let bytes: Vec<u8> = lists.words.iter().flat_map(|word| word.to_ne_bytes()).collect();
    let is_written = task.write(registers.rsp, &bytes).is_ok()
        && lists.random_at.is_none_or(|place| task.write(place, &random.bytes(16)).is_ok());
    if is_written { task.set(&registers) } else { Err(failed(task)) }
}

fn lists(task: &Task, start: u64) -> Result<Lists, Fault> {
    let mut lists = Lists::default();
    let next = |words: &mut Vec<u64>| {
        let word = task.read_u64(start + 8 * words.len() as u64)?;
        words.push(word);
        if words.len() < MOST_WORDS { Ok(word) } else { Err(Fault::Errno(libc::E2BIG)) }
    };
    next(&mut lists.words)?;
    for _ in ["words", "environment"] {
        while next(&mut lists.words)? != 0 {}
    }
    loop {
        let place = lists.words.len();
        let (kind, value) = (next(&mut lists.words)?, next(&mut lists.words)?);
        match kind {
            AT_NULL => return Ok(lists),
            AT_SYSINFO_EHDR => lists.vdso = Some((place, value)),
            AT_RANDOM => lists.random_at = Some(value),
            _ => {}
        }
    }
}
