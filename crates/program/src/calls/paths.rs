//! Paths: those of the ports lead to the ports, and those of the machine's own serial ports to nothing.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Component, Path, PathBuf};

use super::Outcome;
use crate::cables::{Cables, ModemOutputs};
use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::{EPOCH_NS, Kernel};
use crate::os::proc;
use crate::task::{After, Task};

/// The machine's own serial ports. They are in real time, so the program sees none.
pub(super) const HIDDEN: [&[u8]; 4] = [b"/dev/ttyS", b"/dev/ttyUSB", b"/dev/ttyACM", b"/dev/ttyAMA"];
/// Paths by which programs make pseudo-terminals. The kernel moves their bytes in its own time.
const TERMINALS: [&[u8]; 2] = [b"/dev/ptmx", b"/dev/pts/ptmx"];
const TERMINALS_REMEDY: &str = "a pseudo-terminal works in real time; use pipes, or give the program a port as its terminal, as in `< /dev/ttyUSB1`";
/// Flags of `open` that matter for a port.
const KEPT_FLAGS: u64 =
    (libc::O_ACCMODE | libc::O_NONBLOCK | libc::O_CLOEXEC | libc::O_APPEND | libc::O_NOCTTY) as u64;
/// Links that lead on to links, at most.
const MOST_LINKS: usize = 8;
/// The device numbers of USB serial adapters, and those of a port's file.
const MAJOR: u32 = 188;
const MODE: u32 = libc::S_IFCHR | 0o660;
const GROUP: u32 = 20;
pub(super) const FIRST_INODE: u64 = 900;

/// The thing that a path leads to.
enum Place {
    Port(usize),
    /// As if it were absent.
    Nothing,
    /// The system's maker of pseudo-terminals.
    Terminals,
    Other,
}

/// The thing that the path of a call leads to: `folder` and `path` are the places of its arguments.
fn place(
    kernel: &Kernel,
    task: &Task,
    folder: Option<usize>,
    path: usize,
    follows: bool,
) -> Result<Place, Fault> {
    if task.argument(path) == 0 {
        return Ok(Place::Other);
    }
    let text = task.text(task.argument(path))?;
    let mut path = absolute(task, folder, Path::new(OsStr::from_bytes(&text)));
    for _ in 0..MOST_LINKS {
        let name = path.as_os_str().as_bytes();
        if let Some(port) = kernel.ports.iter().position(|port| port.path.as_bytes() == name) {
            return Ok(Place::Port(port));
        }
        if TERMINALS.contains(&name) {
            return Ok(Place::Terminals);
        }
        if HIDDEN.iter().any(|start| name.starts_with(start)) {
            return Ok(Place::Nothing);
        }
        match std::fs::read_link(&path) {
            // Links of /proc are no paths.
            Ok(target) if follows && !path.starts_with("/proc") => {
                path = normal(&path.parent().map_or_else(|| target.clone(), |folder| folder.join(&target)));
            }
            _ => return Ok(Place::Other),
        }
    }
    Ok(Place::Other)
}

fn absolute(task: &Task, folder: Option<usize>, path: &Path) -> PathBuf {
    if path.is_absolute() {
        return normal(path);
    }
    let base = match folder.map(|place| task.descriptor(place)) {
        Some(folder) if folder != libc::AT_FDCWD => proc::descriptor(task.tid, folder),
        _ => std::fs::read_link(format!("/proc/{}/cwd", task.tid)).ok(),
    };
    normal(&base.unwrap_or_default().join(path))
}

/// A path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            Component::Prefix(_) | Component::RootDir | Component::Normal(_) => normal.push(component),
        }
    }
    normal
}

pub(super) fn open(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let (folder, path, flags) = match caller.number_of_call() {
        libc::SYS_open => (None, 0, caller.argument(1)),
        libc::SYS_creat => (None, 0, libc::O_WRONLY as u64),
        _ => (Some(0), 1, caller.argument(2)),
    };
    let port = match place(kernel, caller, folder, path, true)? {
        Place::Port(port) => port,
        Place::Nothing => return Err(Fault::Errno(libc::ENOENT)),
        Place::Terminals => return Err(caller.refuse("open(/dev/ptmx)", TERMINALS_REMEDY).into()),
        Place::Other => return Ok(Outcome::Native),
    };
    if kernel.ports[port].is_exclusive {
        return Err(Fault::Errno(libc::EBUSY));
    }
    caller.open_instead(&kernel.ports[port].flag.path(), flags & KEPT_FLAGS)?;
    Ok(Outcome::Observed(After::Opening { port: Some(port) }))
}

pub(super) fn leave_opening(
    kernel: &mut Kernel,
    task: usize,
    port: Option<usize>,
    cables: &mut dyn Cables,
) -> Result<(), Error> {
    let caller = &mut kernel.tasks[task];
    let descriptor = caller.value()?;
    caller.complete();
    caller.returns(descriptor)?;
    let Some(port) = port else { return Ok(()) };
    let tty = &mut kernel.ports[port];
    if descriptor >= 0 && !tty.is_open {
        tty.is_open = true;
        if let Some(settings) = tty.termios.line_settings() {
            cables.configure(port, settings);
            tty.outputs = ModemOutputs { dtr: true, rts: true };
            cables.set_outputs(port, tty.outputs);
        }
    }
    Ok(())
}

pub(super) fn stat(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let number = caller.number_of_call();
    let (folder, path, flags, into) = match number {
        libc::SYS_stat => (None, Some(0), 0, 1),
        libc::SYS_lstat => (None, Some(0), libc::AT_SYMLINK_NOFOLLOW, 1),
        libc::SYS_fstat => (None, None, 0, 1),
        libc::SYS_newfstatat => (Some(0), Some(1), caller.argument(3) as i32, 2),
        _ => (Some(0), Some(1), caller.argument(2) as i32, 4),
    };
    let is_empty = |path: usize| {
        caller.argument(path) == 0 || caller.text(caller.argument(path)).is_ok_and(|text| text.is_empty())
    };
    let place = match path {
        Some(path) if flags & libc::AT_EMPTY_PATH == 0 || !is_empty(path) => {
            place(kernel, caller, folder, path, flags & libc::AT_SYMLINK_NOFOLLOW == 0)?
        }
        _ => kernel.port(task, caller.descriptor(0)).map_or(Place::Other, Place::Port),
    };
    let facts = match place {
        Place::Port(port) if number == libc::SYS_statx => statx_facts(port).to_vec(),
        Place::Port(port) => stat_facts(port).to_vec(),
        Place::Nothing => return Err(Fault::Errno(libc::ENOENT)),
        Place::Terminals | Place::Other => return Ok(Outcome::Native),
    };
    caller.write(caller.argument(into), &facts)?;
    Ok(Outcome::Look(0))
}

fn device_minor(port: usize) -> u32 {
    (port as u32) & 0xff
}

/// `struct stat` of x86-64.
fn stat_facts(port: usize) -> [u8; 144] {
    let mut facts = [0; 144];
    let device = u64::from(MAJOR << 8 | device_minor(port));
    for (place, value) in [(0, 5), (8, FIRST_INODE + port as u64), (16, 1), (40, device), (56, 4096)] {
        facts[place..place + 8].copy_from_slice(&u64::to_ne_bytes(value));
    }
    for time in [72, 88, 104] {
        facts[time..time + 8].copy_from_slice(&(EPOCH_NS / 1_000_000_000).to_ne_bytes());
    }
    facts[24..28].copy_from_slice(&MODE.to_ne_bytes());
    facts[32..36].copy_from_slice(&GROUP.to_ne_bytes());
    facts
}

/// `struct statx`.
fn statx_facts(port: usize) -> [u8; 256] {
    let mut facts = [0; 256];
    let fields = [
        (0, 0x7ff),
        (4, 4096),
        (16, 1),
        (24, GROUP),
        (28, MODE),
        (128, MAJOR),
        (132, device_minor(port)),
        (140, 5),
    ];
    for (place, value) in fields {
        facts[place..place + 4].copy_from_slice(&value.to_ne_bytes());
    }
    facts[32..40].copy_from_slice(&(FIRST_INODE + port as u64).to_ne_bytes());
    for time in [64, 96, 112] {
        facts[time..time + 8].copy_from_slice(&(EPOCH_NS / 1_000_000_000).to_ne_bytes());
    }
    facts
}

pub(super) fn access(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let (folder, path) = if caller.number_of_call() == libc::SYS_access { (None, 0) } else { (Some(0), 1) };
    let mode = caller.argument(path + 1) as i32;
    match place(kernel, caller, folder, path, true)? {
        Place::Port(_) if mode & libc::X_OK != 0 => Err(Fault::Errno(libc::EACCES)),
        Place::Port(_) => Ok(Outcome::Look(0)),
        Place::Nothing => Err(Fault::Errno(libc::ENOENT)),
        Place::Terminals | Place::Other => Ok(Outcome::Native),
    }
}

/// A port is no link; but /proc has links to what is open, by which `ttyname` finds the path.
pub(super) fn read_link(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let (folder, path) = if caller.number_of_call() == libc::SYS_readlink { (None, 0) } else { (Some(0), 1) };
    match place(kernel, caller, folder, path, false)? {
        Place::Port(_) => return Err(Fault::Errno(libc::EINVAL)),
        Place::Nothing => return Err(Fault::Errno(libc::ENOENT)),
        Place::Terminals | Place::Other => {}
    }
    let text = String::from_utf8(caller.text(caller.argument(path))?).unwrap_or_default();
    let own = ["/proc/self/fd/", "/dev/fd/", "/proc/thread-self/fd/"];
    let descriptor = own.iter().find_map(|start| text.strip_prefix(start)?.parse().ok());
    let Some(port) = descriptor.and_then(|descriptor| kernel.port(task, descriptor)) else {
        return Ok(Outcome::Native);
    };
    let told = kernel.ports[port].path.as_bytes();
    let told = &told[..told.len().min(caller.argument(path + 2) as usize)];
    caller.write(caller.argument(path + 1), told)?;
    Ok(Outcome::Answer(told.len() as i64))
}
