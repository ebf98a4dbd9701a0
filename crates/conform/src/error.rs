//! The reasons why a brain cannot be examined.

use baudbot_run::programs::Failure;

/// The kit cannot examine a brain.
#[derive(Debug, thiserror::Error)]
pub enum KitError {
    /// The scenario has no such robot.
    #[error("there is no robot `{robot}`; there are: {}", robots.join(", "))]
    NoRobot {
        /// The name that was given; empty if none was.
        robot: String,
        /// The robots of the scenario.
        robots: Vec<String>,
    },
    /// There is no place for a second robot.
    #[error("the arena has no room for a second robot of this size; choose another scenario")]
    NoRoom,
    /// The program cannot be started.
    #[error(transparent)]
    Program(#[from] Failure),
    /// The world cannot be made.
    #[error("the world cannot be made: {0}")]
    Server(#[from] baudbot_server::ServerError),
    /// The world does not answer.
    #[error("the world does not answer: {}", .0.message())]
    World(Box<tonic::Status>),
    /// An address cannot be listened on, or a folder not be made.
    #[error("{place}: {source}")]
    Place {
        /// The address or the folder.
        place: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// There is no randomness for a token.
    #[error(transparent)]
    Token(#[from] baudbot_access::NoRandomness),
}
