//! Runs somebody else's unmodified program (C, Python, Go, …) in simulated time, with simulated serial ports: Linux on x86-64.
//!
//! A program is traced (ptrace) from its first instruction on, and a filter (seccomp) stops it at the calls that wait or tell the time.
//! Its vDSO tells our time and the processor's counter is trapped, so that it knows no other. One task (thread or process) runs
//! at a time, in a fixed order, until it waits; time passes only when all of them wait. So the same program with the same bytes at the
//! same instants does the same, on whatever machine, and as fast as that can.
//!
//! The caller has the world: it implements [`Cables`], calls [`Session::run`] for an instant, and advances the world to the instant that
//! it says, or to the next one at which a byte reaches the program.
//!
//! *Limits.* Numbers of processes, folders of /sys and /proc, times of files, and the instructions `rdrand` and `cpuid` are the
//! machine's. Nothing keeps a program from files or signals: the tracer is no sandbox. A program is over when its first process is.

mod cables;
mod error;
mod program;
mod report;

pub use cables::{Cables, LineSettings, ModemInputs, ModemOutputs, Parity};
pub use error::Error;
pub use program::{Output, Patience, Port, Price, Program};
pub use report::{End, Report, Wait};
pub use session::{Session, State};

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod calls;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod endings;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod fault;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod files;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod image;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod interrupts;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod kernel;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod launch;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod looks;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod names;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod os;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod random;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod rings;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod schedule;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod session;
#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
#[path = "elsewhere.rs"]
mod session;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod task;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod timers;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod tty;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod vdso;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod watch;
