//! Plane geometry for baudbot, as pure functions of their arguments.
//!
//! Lengths are in metres, angles in radians, counter-clockwise positive, and all numbers are `f64`. The
//! modules, from the ground up:
//!
//! 1. [`math`] is the only door to functions such as `sin`; behind it is the same code on every machine.
//! 2. [`angle`] keeps angles within half a turn of zero.
//! 3. [`pose`] places one frame in another: [`Point`], [`Vector`], [`Direction`], [`Pose`].
//! 4. [`segment`] and [`circle`] are the two shapes of which an arena is made; [`polygon`] is a closed
//!    chain of segments, and [`bounds`] is the box around shapes.
//! 5. [`ray`] finds how far one ray runs before it meets one shape, and [`fan`] spreads the rays of one
//!    sensor; [`pencil`] has a few rays at once.
//! 6. [`index`] finds what one ray meets first among many shapes; [`grid`] is for what else is done with square cells.
//! 7. [`wheels`] relates the speeds of two wheels to the motion between them.
//!
//! A simulator needs [`Pose`], [`Fan`] and [`Index`]; the rest is what these are made of.
//!
//! Equation numbers refer to Wahde, *Introduction to Autonomous Robots*. Where the code deviates from an
//! equation, the module that does so has a paragraph named *Deviations*.
//!
//! # Determinism
//!
//! Equal arguments give equal bits on every machine. The crate is `no_std`, so that the functions of a
//! platform's own maths library cannot be called by accident. Only `+ - * /`, comparisons and [`math`] are
//! used on numbers; no iteration order depends on an address or on a hash.
//!
//! # Bad numbers
//!
//! Coordinates are expected to be finite and radii to be non-negative; whoever reads them from a file
//! checks them. A NaN in a query is no reason to panic or to run on: casts and overlaps then find nothing,
//! and a nearest point means nothing.

#![no_std]

extern crate alloc;
#[cfg(feature = "simd")]
extern crate std;

pub mod angle;
pub mod bounds;
pub mod carried;
pub mod circle;
pub mod crowd;
pub mod fan;
pub mod grid;
pub mod index;
pub mod math;
pub mod normal;
pub mod pencil;
pub mod polygon;
pub mod pose;
pub mod ray;
pub mod segment;
pub mod sweep;
mod trigonometry;
pub mod vectors;
pub mod wheels;

pub use bounds::Bounds;
pub use carried::{Bundle, Carried};
pub use circle::Circle;
pub use crowd::Crowd;
pub use fan::Fan;
pub use index::{Hit, Index, Shape};
pub use pencil::Pencil;
pub use pose::{Direction, Point, Pose, Vector};
pub use ray::Ray;
pub use segment::Segment;
pub use sweep::Sweep;
pub use wheels::Twist;
