//! Brains that are programs of their own, in any language: started with what they need to attach, watched, and ended with all
//! their children.
//!
//! 1. [`Program`] is such a program, as a command line or a file names it: `exec:python3 follow.py`.
//! 2. [`Task`] is what it is started for; it gets that in its environment ([`Task::environment`]).
//! 3. [`Crew`] is the programs of a run: it waits until they hold their robots, tells if one fails, and ends them.
//! 4. [`Process`] is one of them, for those who see to it themselves.
//! 5. [`PortProgram`] is one that knows no server: it opens serial ports, and runs in simulated time
//!    ([`Simulation`](crate::simulation::Simulation)).
//! 6. [`ProcessorClock`] says how much processor time they have used.
//!
//! Only a command line and a file that the user names may start programs. Nothing that comes over a network does.

#[cfg(feature = "programs")]
mod crew;
#[cfg(feature = "programs")]
mod failure;
#[cfg(feature = "programs")]
pub(crate) mod kept;
mod port_program;
#[cfg(feature = "programs")]
mod process;
#[cfg(feature = "programs")]
mod processor_clock;
mod program;
mod task;

#[cfg(feature = "programs")]
pub use crew::{Crew, Held, Idle};
#[cfg(feature = "programs")]
pub use failure::{Failure, Problem};
pub use port_program::{BadPort, PROGRAM, PortProgram, PortTask};
#[cfg(feature = "programs")]
pub use process::Process;
#[cfg(feature = "programs")]
pub use processor_clock::ProcessorClock;
pub use program::{BadProgram, EXEC, Program};
pub use task::{Lifetime, Output, Task};
