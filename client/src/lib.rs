//! The laptop's end of a robot's serial cable, in Rust: a brain is twenty lines.
//!
//! A brain is a function from what has arrived to what is sent: it implements [`Brain`], knows no clock and
//! no network, and can be tested without a server. The rest of this crate brings it to its robot, from the
//! outside in:
//!
//! 1. [`connect`] finds the server and gives a [`Client`].
//! 2. [`Client::attach`] takes hold of a [`Robot`] of a world, [`Client::attach_many`] of a [`Fleet`] of
//!    them over one stream, [`Client::attach_raw`] of a [`RawRobot`], which speaks the bytes of the wire.
//! 3. The robot's [`Body`] is its data sheet: which sensors, where, how often, in which units.
//! 4. [`Robot::turn`] waits for the next [`Turn`]: each sensor's last [`Reading`], and whether it is new.
//! 5. [`Robot::drive`] answers it with [`Signals`] for the motors; [`run`] does 4 and 5 with a [`Brain`]
//!    until the run is over.
//!
//! [`Robot::publish`] shows people the beliefs and intentions of a brain: a [`Belief`]. An [`Attachment`] is all of
//! this for a program that drives until the run is over; it comes back to a server that it has lost, as other
//! programs [can](come_back()).
//!
//! The types that a brain sees and answers with are the crate `baudbot-brain`, all of which is here, too. A brain
//! that is to run without a server, such as in a browser, needs that crate alone.
//!
//! A raw brain brings its own codec, or takes [`RawReadings`] and [`RawCommands`], with which it sees and
//! does what a brain of messages does.
//!
//! # Example
//!
//! ```no_run
//! use baudbot_client::{Action, Brain, Error, Turn, connect, run};
//!
//! /// Drives on, and turns on the spot while something is near in front.
//! struct Timid;
//!
//! impl Brain for Timid {
//!     fn step(&mut self, turn: &Turn) -> Action {
//!         let action = match turn.value("ir_front") {
//!             None => turn.body.request(),
//!             Some(nearness) if nearness > 0.25 => Action::drive(0.5, -0.5),
//!             Some(_) => Action::drive(0.4, 0.4),
//!         };
//!         // One command for each message, and another if none comes for 0.1 s: the cable may have lost the last.
//!         action.until_message_or(turn.at_ns + 100_000_000)
//!     }
//! }
//!
//! #[tokio::main(flavor = "current_thread")]
//! async fn main() -> Result<(), Error> {
//!     let mut robot = connect("127.0.0.1:7400").await?.attach("wander", "robot").await?;
//!     run(&mut robot, &mut Timid).await?;
//!     Ok(())
//! }
//! ```

#[cfg(feature = "network")]
mod address;
#[cfg(feature = "network")]
mod attachment;
#[cfg(feature = "network")]
mod attempt;
mod channel;
mod client;
#[cfg(feature = "network")]
mod comeback;
#[cfg(feature = "network")]
mod connect;
#[cfg(feature = "network")]
mod credentials;
mod error;
mod fleet;
#[cfg(feature = "network")]
mod line;
#[cfg(feature = "network")]
mod place;
mod protocol;
mod raw;
#[cfg(feature = "network")]
mod reconnect;
mod robot;
mod run;
mod session;
mod stream;

pub use baudbot_brain::{
    Action, Actuator, ActuatorKind, Belief, BelievedPose, Body, Brain, Component, EachRun, Encoding,
    Firmware, GridMap, MotorKind, Mount, Particle, Point, Port, PortFormat, Protocol, RawCommands,
    RawReadings, RawTurn, Reading, Sensor, SensorKind, Signals, Sweep, Turn, Until, Utility, WireLayout,
};

#[cfg(feature = "network")]
pub use attachment::{Attachment, AttachmentError};
pub use baudbot_proto::convert::Breach;
pub use channel::Channel;
pub use client::Client;
#[cfg(feature = "network")]
pub use comeback::come_back;
#[cfg(feature = "network")]
pub use connect::{connect, connect_with};
#[cfg(feature = "network")]
pub use credentials::Credentials;
pub use error::Error;
pub use fleet::Fleet;
pub use raw::RawRobot;
#[cfg(feature = "network")]
pub use reconnect::{BadReconnect, Reconnect};
pub use robot::Robot;
pub use run::{Looks, Summary, run, run_fleet};
