//! To a goal along a planned path: what behaviours share that do so.
//!
//! - [`Floor`]: walls as a description has them, and ways between points that keep clear of them.
//! - [`Path`]: straight pieces one after the other, and places on them by their distance from the beginning.
//! - `Goals`: points to be visited in turn.
//! - [`Pursuit`]: the point of a path that a robot drives at.

mod floor;
mod goals;
mod path;
mod pursuit;

pub use floor::{CELLS_A_STEP, Floor, Method};
pub(crate) use goals::Goals;
pub use path::Path;
pub use pursuit::Pursuit;
