//! The way between the contract's messages and what a brain sees and does (`baudbot-brain`), in both directions: the
//! only place that names both. What a server may get wrong is a [`Breach`].

mod belief;
mod body;
mod breach;
mod kind;
mod step;
mod turn;

pub use breach::{Breach, item};
pub use turn::{ports, readings};
