//! To a goal along a planned way: what behaviours share that do so.
//!
//! - [`Floor`]: walls as a description has them, and ways between points that keep clear of them.
//! - [`Way`]: straight pieces one after the other, and places on them by their distance from the beginning.
//! - `Goals`: points to be visited in turn.
//! - [`Pursuit`]: the point of a way that a robot drives at.

mod floor;
mod goals;
mod pursuit;
mod way;

pub use floor::{CELLS_A_STEP, Floor, Method};
pub(crate) use goals::Goals;
pub use pursuit::Pursuit;
pub use way::Way;
