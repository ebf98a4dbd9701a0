//! Serial ports that other people's programs open: the laptop's end of a simulated robot's cables. [`debug`] lets their debuggers
//! in at a robot's chip.
//!
//! A program for a real robot opens a serial port, sets its UART, writes and reads bytes. Here that port is a pseudo-terminal or a
//! socket ([`Endpoint`](baudbot_fields::endpoint::Endpoint)); to the world it is a brain in RAW mode ([`RobotPorts`]). Each byte from the robot is given to the program at
//! its own instant: never before the cable has carried it, by the wall clock at the pace of the world. What the program writes
//! is taken as fast as the cable takes it, so that the program blocks as at a real port.
//!
//! [`baudbot_board::far_end`] has what each end reads if the two are set differently.

mod address;
mod cable;
mod claim;
mod clock;
pub mod debug;
mod driver;
mod error;
mod happened;
mod hold;
mod line;
mod medium;
mod program;
mod pty;
mod report;
mod robot;
mod socket;
mod telnet;
mod watch;

pub use address::{BadPort, PortAddress};
pub use baudbot_access::peer::Reach;
pub use cable::Cable as UartCable;
pub use error::PortError;
pub use report::Report;
pub use robot::{News, RobotPorts};
