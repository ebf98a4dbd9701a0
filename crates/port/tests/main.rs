//! What other people's programs see of a robot, from outside.

mod debug;
