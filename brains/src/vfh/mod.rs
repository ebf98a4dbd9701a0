//! VFH+: to a goal among obstacles that no map has. Ulrich and Borenstein 1998, *VFH+: Reliable Obstacle Avoidance for Fast
//! Mobile Robots*.
//!
//! The stages of the paper, from readings to the direction of driving:
//!
//! 1. [`Sight`] makes scans of readings, and [`Memory`] keeps what was seen as cells of a grid that moves with the robot.
//! 2. [`Histogram`] has how much is in each direction, every cell as wide as the robot (primary polar histogram, Eqs. (1) to
//!    (6)), and which directions are blocked, with hysteresis (binary polar histogram, (7)). Of those it masks what the
//!    robot cannot turn to.
//! 3. [`candidates`] has the directions that openings offer; the cheapest one is chosen.
//! 4. [`Vfh`] drives there, the more slowly the less room there is ahead, and stops before a walking person can reach it.
//!
//! It is blind to all but what is near: in a dead end it stays. A path through rooms is a list of goals.
//!
//! *Deviations.* A cell holds what a laser or a sonar saw last, and not a count of hits: its certainty is 1, until a ray goes
//! through it or it is forgotten. A cell weighs nothing at the window's edge, as in the VFH of 1991, where (3) has it
//! weigh 1, and a direction has as much as the greatest of its cells, not as their sum (5): a laser that sees a wall in
//! twenty cells is no surer of it than of a post in two. So a threshold is a distance. There is hysteresis in width, too, by
//! the side of a cell. What is farther away than the goal is not in the way. Costs are of angles, and not of sectors.
//! Walking people are not in the paper: an obstacle in front of the robot that has not been in its place for half a second
//! may come nearer at `walker_m_s` for as long as `halt_s`, and the robot's speed leaves room for that.

mod behavior;
pub mod candidates;
mod histogram;
mod memory;
pub(crate) mod sight;

pub use behavior::{Parameters, Vfh};
pub use histogram::{Histogram, Window};
pub use memory::Memory;
pub use sight::{Seen, Sight};
