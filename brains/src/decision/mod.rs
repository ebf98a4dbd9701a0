//! The choice of the behaviour that has the motors: decision-making, Wahde 2016, Chapter 8.
//!
//! All methods here but [`cooperative`] are of arbitration (Section 8.1.1): exactly one motor behaviour is active.
//!
//! | method | decides | from |
//! |---|---|---|
//! | [`utility`] | by the greatest of utilities that follow the state variables | Section 8.2 |
//! | [`machine`] | by transitions between behaviours | a finite-state machine, as in Section 5.3 |
//! | [`layers`] | the first layer whose condition holds | Brooks's subsumption, at its simplest |
//! | [`tree`] | by a behaviour tree | the field's today, by the crate `bonsai-bt` |
//! | [`hydraulic`] | by the energy of reservoirs and what releases it | Lorenz' model, Section 4.4.4 |
//! | [`cooperative`] | nobody alone: the command is a weighted mean | cooperative methods, Section 8.1.1 |

pub mod condition;
pub mod cooperative;
pub mod hydraulic;
pub mod layers;
pub mod machine;
pub mod quadratic;
pub mod tree;
pub mod utility;

pub use condition::{Condition, ConditionError};
pub use cooperative::{Cooperative, Weight};
pub use hydraulic::{Hydraulic, Reservoir};
pub use layers::Layers;
pub use machine::{Machine, Transition};
pub use tree::{Node, Tree};
pub use utility::{Utility, UtilityFunction};
