//! The reasons why a port cannot be opened, or is open no longer.

use std::io;
use std::path::PathBuf;

use baudbot_fields::endpoint::Endpoint;
use thiserror::Error;

/// A reason why a port cannot be opened, or is open no longer.
#[derive(Debug, Error)]
pub enum PortError {
    /// Something stands where the symbolic link is to be.
    #[error("{}: {what} already exists; remove it, or choose another name", .path.display())]
    InTheWay {
        /// The path.
        path: PathBuf,
        /// The kind of file there.
        what: &'static str,
    },
    /// The operating system has none, or refuses it.
    #[error("{place}: cannot be opened: {source}")]
    Open {
        /// The port's place.
        place: Endpoint,
        /// The system's error.
        source: io::Error,
    },
    /// Other machines could reach it.
    #[error(
        "{place}: other machines could reach this port and drive the robot; use an address of this machine, or `baudbot port open --open`"
    )]
    NotLocal {
        /// The port's place.
        place: Endpoint,
    },
    /// The robot has no such device, or that has no cable of its own.
    #[error("robot `{robot}` has no sensor `{device}` with a port of its own; those with one: {there_are}")]
    NoDevice {
        /// Name of the robot.
        robot: String,
        /// The device that was asked for.
        device: String,
        /// The devices that exist.
        there_are: String,
    },
    /// Simulated time does not follow the wall clock any more.
    #[error(
        "the world does not follow the wall clock any more; serial ports need the pace real-time or scaled"
    )]
    NoClock,
    /// The server refuses, or is gone.
    #[error("{}", .0.message())]
    Server(#[from] Box<tonic::Status>),
    /// The server breaks the contract.
    #[error("the server breaks the contract: {0} has come in place of a Welcome")]
    Contract(&'static str),
}

impl From<tonic::Status> for PortError {
    fn from(status: tonic::Status) -> Self {
        Self::Server(Box::new(status))
    }
}
