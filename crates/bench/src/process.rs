//! The operating system's numbers of this process.

use std::fmt;
use std::fs;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

/// The resources that a process has used so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Usage {
    /// Seconds of processors.
    pub cpu_s: f64,
    /// The most memory, in bytes; `None` where the system does not report it.
    pub peak_memory_bytes: Option<u64>,
}

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1} s of a processor", self.cpu_s)?;
        self.peak_memory_bytes.map_or(Ok(()), |bytes| write!(f, ", {:.1} MB", bytes as f64 / 1e6))
    }
}

/// The resources that this process has used so far.
pub fn usage() -> Usage {
    Usage { cpu_s: cpu_time().as_secs_f64(), peak_memory_bytes: peak_memory_bytes() }
}

/// The most memory that this process has had so far, in bytes; `None` where the system does not report it.
pub fn peak_memory_bytes() -> Option<u64> {
    of_status("VmHWM:")
}

/// The memory that this process has now, in bytes; `None` where the system does not report it.
pub fn memory_bytes() -> Option<u64> {
    of_status("VmRSS:")
}

fn of_status(field: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// The clock by which durations are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The one on the wall.
    Wall,
    /// The processor time of this process: for work in one thread, which others on the machine then do not make
    /// longer than it is by taking turns with it. On a quiet machine it is the wall's.
    Processor,
}

impl Clock {
    /// Seconds since some instant.
    pub fn now_s(self) -> f64 {
        match self {
            Self::Wall => {
                let time = clock_gettime(ClockId::Monotonic);
                time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
            }
            Self::Processor => cpu_time().as_secs_f64(),
        }
    }
}

/// Time of all processors that this process has used so far.
pub fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.max(0) as u64, time.tv_nsec as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_that_of_a_process() {
        let Some(bytes) = peak_memory_bytes() else { return };
        assert!((1 << 20..1 << 34).contains(&bytes), "{bytes}");
        assert!(memory_bytes().is_some_and(|now| (1 << 20..=peak_memory_bytes().unwrap()).contains(&now)));
        assert!(cpu_time() > Duration::ZERO);
    }
}
