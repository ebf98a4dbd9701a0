//! Whether there is memory for many worlds, found by making some of them.
//!
//! The system reports how much this process has, before and after. What was free in the process already is filled first
//! and seems to need nothing, so it is looked at again and again while worlds are made.

use std::fs;

use crate::learn::error::LearnError;

/// The memory that so many worlds will need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Need {
    worlds: usize,
    /// The additional memory of each, in bytes.
    more: u64,
    /// The number of worlds that exist already and have made all that is made only once, and the memory of the process.
    first: usize,
    before: Option<u64>,
}

impl Need {
    pub(crate) fn new(worlds: usize, more: u64, first: usize) -> Self {
        Self { worlds, more, first, before: resident() }
    }

    /// Refuses more worlds than there is memory for, once so many are made that their need is known.
    pub(crate) fn check(&self, made: usize) -> Result<(), LearnError> {
        match (self.before.zip(resident()), free()) {
            (Some((before, now)), Some(free)) => self.fits(made, now.saturating_sub(before), free),
            // This system has no such numbers.
            _ => Ok(()),
        }
    }

    fn fits(&self, made: usize, grown: u64, free: u64) -> Result<(), LearnError> {
        if grown < LEAST {
            return Ok(());
        }
        let each = grown / (made - self.first).max(1) as u64 + self.more;
        let needed = each.saturating_mul((self.worlds - made) as u64).saturating_add(self.more * made as u64);
        if needed <= free {
            return Ok(());
        }
        let [needed, free] = [needed, free].map(|bytes| bytes as f64 / GIB);
        let problem = format!(
            "{} worlds, of about {} kB each, need {needed:.1} GiB more, and {free:.1} GiB are free",
            self.worlds,
            each.div_ceil(1000)
        );
        Err(LearnError::value("num_envs", problem))
    }
}

/// The memory of this process, in bytes.
fn resident() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// The memory that is free without taking it from others, in bytes: in the machine, and in the container if it is one.
fn free() -> Option<u64> {
    let machine = kilobytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    Some(free_in_container().map_or(machine, |free| free.min(machine)))
}

/// The same of a container that has a limit. Of files, what has not been used of late is given back.
fn free_in_container() -> Option<u64> {
    let told = |file: &str| fs::read_to_string(format!("/sys/fs/cgroup/{file}")).ok();
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let (most, now) = (number(&told("memory.max")?)?, number(&told("memory.current")?)?);
    let files = told("memory.stat")?.lines().find_map(|line| number(line.strip_prefix("inactive_file ")?));
    Some(most.saturating_sub(now.saturating_sub(files.unwrap_or(0))))
}

/// A line of a file of the kernel's, such as `VmRSS:     1024 kB`.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The least change from which the need of a world is computed, in bytes.
const LEAST: u64 = 16 << 20;

const GIB: f64 = (1_u64 << 30) as f64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_worlds_than_there_is_room_for_are_refused() {
        let need = Need { worlds: 1000, more: 1000, first: 1, before: None };
        // 100 worlds have taken 100 MB; the others need 899.1 MB and arrays of 1 MB.
        assert!(need.fits(101, 100_000_000, 900_100_000).is_ok());
        let said = need.fits(101, 100_000_000, 899_900_000).unwrap_err().to_string();
        assert_eq!(
            said,
            "num_envs: 1000 worlds, of about 1001 kB each, need 0.8 GiB more, and 0.8 GiB are free"
        );
        assert!(need.fits(1000, 999_000_000, 1_000_000).is_ok());
        // So little may be of anything.
        assert!(need.fits(2, 10_000_000, 0).is_ok());
    }

    #[test]
    fn this_system_tells() {
        assert!(resident().unwrap() > 100_000 && free().unwrap() > 100_000);
        assert_eq!(kilobytes("VmPeak:\t 7 kB\nVmRSS:\t  12 kB\n", "VmRSS:"), Some(12 * 1024));
        assert_eq!(kilobytes("VmRSS: many kB", "VmRSS:"), None);
    }
}
