//! Facts about tasks that /proc tells.

use std::fs;
use std::path::PathBuf;

/// The signals of a task, as masks: see `mask`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Signals {
    /// Sent to the task and not delivered yet.
    pub(crate) pending: u64,
    /// Sent to its process and not delivered yet.
    pub(crate) shared: u64,
    /// Not delivered now.
    pub(crate) blocked: u64,
    /// The process does not want them.
    pub(crate) ignored: u64,
    /// The process has a handler for them.
    pub(crate) caught: u64,
}

/// The bit of a signal in a mask.
pub(crate) fn mask(signal: i32) -> u64 {
    1 << (signal - 1)
}

impl Signals {
    /// Signals that do nothing: all others that nobody catches end the process.
    pub(crate) fn harmless(&self) -> u64 {
        let harmless = [libc::SIGCHLD, libc::SIGCONT, libc::SIGURG, libc::SIGWINCH];
        harmless.iter().fold(self.ignored, |all, signal| all | mask(*signal)) & !self.caught
    }

    /// Whether the task has to act on one of the `sent` signals, while it blocks these. Those that it unblocks for that are awaited.
    pub(crate) fn is_due(&self, blocked: u64, sent: u64) -> bool {
        sent & !blocked & (!self.harmless() | (self.blocked & !blocked)) != 0
    }
}

/// The signals of a task.
pub(crate) fn signals(tid: i32) -> Signals {
    let mut signals = Signals::default();
    for line in fs::read_to_string(format!("/proc/{tid}/status")).unwrap_or_default().lines() {
        let Some((name, value)) = line.split_once(":\t") else { continue };
        let place = match name {
            "SigPnd" => &mut signals.pending,
            "ShdPnd" => &mut signals.shared,
            "SigBlk" => &mut signals.blocked,
            "SigIgn" => &mut signals.ignored,
            "SigCgt" => &mut signals.caught,
            _ => continue,
        };
        *place = u64::from_str_radix(value, 16).unwrap_or(0);
    }
    signals
}

/// The name of a task's program, as in `ps`.
pub(crate) fn name(tid: i32) -> Option<String> {
    Some(fs::read_to_string(format!("/proc/{tid}/comm")).ok()?.trim_end().to_owned())
}

/// The process that a task belongs to.
pub(crate) fn process(tid: i32) -> Option<i32> {
    let status = fs::read_to_string(format!("/proc/{tid}/status")).ok()?;
    status.lines().find_map(|line| line.strip_prefix("Tgid:\t"))?.parse().ok()
}

/// Whether a program's memory is at other addresses in each run.
pub(crate) fn has_random_addresses(process: i32) -> bool {
    let text = |file: &str| fs::read_to_string(file).unwrap_or_default();
    let personality =
        i32::from_str_radix(text(&format!("/proc/{process}/personality")).trim(), 16).unwrap_or(0);
    personality & libc::ADDR_NO_RANDOMIZE == 0 && text("/proc/sys/kernel/randomize_va_space").trim() != "0"
}

/// The file that a descriptor stands for: a path, or a text such as `pipe:[4711]`.
pub(crate) fn descriptor(tid: i32, descriptor: i32) -> Option<PathBuf> {
    fs::read_link(format!("/proc/{tid}/fd/{descriptor}")).ok()
}

/// Whether a descriptor is one of those that do not wait.
pub(crate) fn is_nonblocking(tid: i32, descriptor: i32) -> bool {
    let info = fs::read_to_string(format!("/proc/{tid}/fdinfo/{descriptor}")).unwrap_or_default();
    let flags = info.lines().find_map(|line| line.strip_prefix("flags:\t"));
    flags.and_then(|flags| i32::from_str_radix(flags.trim(), 8).ok()).unwrap_or(0) & libc::O_NONBLOCK != 0
}

/// The files that a process has open.
pub(crate) fn descriptors(process: i32) -> Vec<PathBuf> {
    let Ok(folder) = fs::read_dir(format!("/proc/{process}/fd")) else { return Vec::new() };
    folder.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok()).collect()
}

/// The state of a task as a letter (proc(5)), and the processor time that it has had, in nanoseconds.
pub(crate) fn activity(tid: i32) -> Option<(char, u64)> {
    let stat = fs::read_to_string(format!("/proc/{tid}/stat")).ok()?;
    let state = stat.rsplit_once(") ")?.1.chars().next()?;
    let times = fs::read_to_string(format!("/proc/{tid}/schedstat")).ok()?;
    Some((state, times.split(' ').next()?.parse().ok()?))
}

/// The call that a task is in, or none while it computes.
pub(crate) fn call(tid: i32) -> Option<i64> {
    fs::read_to_string(format!("/proc/{tid}/syscall")).ok()?.split(' ').next()?.parse().ok()
}

/// The file behind an address of memory that processes share, and the place in it.
pub(crate) fn shared_memory(tid: i32, address: u64) -> Option<(u64, u64)> {
    let maps = fs::read_to_string(format!("/proc/{tid}/maps")).ok()?;
    maps.lines().find_map(|line| {
        let mut words = line.split_ascii_whitespace();
        let (start, end) = words.next()?.split_once('-')?;
        let start = u64::from_str_radix(start, 16).ok()?;
        let is_here = (start..u64::from_str_radix(end, 16).ok()?).contains(&address);
        let is_shared = words.next()?.ends_with('s');
        let offset = u64::from_str_radix(words.next()?, 16).ok()?;
        let file = words.nth(1)?.parse().ok()?;
        (is_here && is_shared).then(|| (file, offset + (address - start)))
    })
}
