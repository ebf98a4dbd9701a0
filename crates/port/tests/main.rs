//! The view of a robot from outside, by programs of others.

mod debug;
