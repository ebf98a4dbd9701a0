//! Potential field navigation: Wahde 2016, Section 6.2.2, Eqs. (6.1) to (6.7).

pub mod behavior;
pub mod field;

mod descent;
mod detour;
mod felt;
mod lock;
mod terrain;

pub use behavior::PotentialField;
pub use descent::Descent;
pub use field::{Field, Potential};
