//! Environments for programs that learn: worlds that are stepped a control cycle at a time, with readings and commands as
//! numbers in arrays.
//!
//! From the scenario outwards:
//!
//! 1. A [`Task`] is a scenario with the robots that a program drives, its agents, and the brains of the others; `vary` draws
//!    fields of it anew for each run.
//! 2. A [`Layout`] says which number of an agent's readings is what, and [`Agent`] keeps them, as a brain has them: what has
//!    come over the cable, how old it is as far as the brain can know, and whether it is new.
//! 3. An [`Env`] is a world of a task that is stepped from one message of its agents' to the next, and [`Tally`] what a trainer may
//!    know of such a step and a brain may not. A [`Reward`] weighs that.
//! 4. A [`Fleet`] is many of them, on some threads.
//!
//! Worlds are those of `baudbot_sim`, to the last bit: a robot that gets the commands of a brain elsewhere does what it
//! does there.

mod agent;
mod env;
mod error;
mod fleet;
mod layout;
mod memory;
mod reward;
mod run;
mod task;
#[cfg(test)]
mod tests;
mod threads;
mod vary;

pub use agent::Agent;
pub use env::{Env, Stepped};
pub use error::LearnError;
pub use fleet::{Arrays, Autoreset, Fleet, Rewards, Seeds};
pub use layout::{Layout, Part};
pub use reward::{Reward, Tally};
pub use run::Info;
pub use task::{Request, Task};
pub use vary::{Draw, Varied};
