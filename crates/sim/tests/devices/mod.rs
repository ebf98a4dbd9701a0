//! Every device of a robot, and what moves around it, seen from outside: a scenario goes in, readings, bytes and
//! hashes come out. Expectations are worked out by hand from the equations, or are the distribution that a file asks
//! for.

mod actuators;
mod arena;
mod dialogues;
mod elevation;
mod encoders;
mod hostile;
mod inertial;
mod ir_beacons;
mod noise;
mod optical_flow;
mod own_clock;
mod ports;
mod position;
mod ranging;
mod refusals;
mod scene;
mod strain_gauge;
mod touch_light;
