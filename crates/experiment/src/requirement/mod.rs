//! Requirements: what must hold of a run, instant by instant, and by how much each run keeps to it.

mod demand;
mod judge;
mod observable;

pub use demand::{Demand, DemandError, Demands, Fall};
pub use judge::Judge;
pub(crate) use observable::excess_ns;
pub use observable::{AGE, NameError, Observable, PLAIN, Plain};
