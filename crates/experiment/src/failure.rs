//! The reasons why a run on a server has no end.

use baudbot_client::Error as ClientError;
use baudbot_run::assignment::AssignmentError;
use baudbot_run::programs::{Failure as Broken, Problem};
use tonic::{Code, Status};

use crate::error::Error;

/// A reason why a run has no end.
pub(crate) enum Failure {
    /// This run could not be; others can.
    Run(String),
    /// The server could not.
    Server(Error),
}

impl From<Broken> for Failure {
    /// A program that fails is the run's own fault. One that does only one run would fail in every other.
    fn from(failure: Broken) -> Self {
        if matches!(failure.problem, Problem::NotReused(_)) {
            return Self::Server(Error::Refused(failure.to_string()));
        }
        Self::Run(failure.to_string())
    }
}

impl Failure {
    /// What is invalid to the server is the run's own fault; all else is the server's, as that it is full.
    pub(crate) fn of(status: &Status) -> Self {
        Self::said(status.code(), status.message())
    }

    fn said(code: Code, message: &str) -> Self {
        if code == Code::InvalidArgument {
            return Self::Run(message.to_owned());
        }
        Self::Server(Error::Server(if code == Code::ResourceExhausted {
            format!("the server is full: {message}; continue when there is room, or on another server")
        } else {
            format!("the server says: {message} ({code:?})")
        }))
    }

    /// A brain that is too much for its robot is the run's own fault, too.
    pub(crate) fn of_attach(error: AssignmentError) -> Self {
        let AssignmentError::Client(error) = error else { return Self::Run(error.to_string()) };
        if let ClientError::Status { code: Code::ResourceExhausted, message } = error {
            return Self::Run(message);
        }
        Self::of_client(error)
    }

    pub(crate) fn of_client(error: ClientError) -> Self {
        if let ClientError::Status { code, message } = error {
            Self::said(code, &message)
        } else {
            Self::Server(Error::Server(error.to_string()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_server_is_no_fault_of_the_run_but_a_brain_that_is_too_large_is() {
        let full = Failure::of(&Status::resource_exhausted("a server has at most 4096 worlds"));
        let Failure::Server(error) = full else { panic!("it is journalled") };
        assert!(
            error.to_string().starts_with("the server is full: a server has at most 4096 worlds; "),
            "{error}"
        );
        let status = |code| ClientError::Status { code, message: "hello: so it is".to_owned() };
        let large = Failure::of_attach(AssignmentError::Client(status(Code::ResourceExhausted)));
        assert!(matches!(large, Failure::Run(message) if message == "hello: so it is"));
        assert!(matches!(Failure::of_client(status(Code::ResourceExhausted)), Failure::Server(_)));
        assert!(matches!(Failure::of_client(status(Code::InvalidArgument)), Failure::Run(_)));
        assert!(matches!(
            Failure::of_attach(AssignmentError::Client(status(Code::Unavailable))),
            Failure::Server(_)
        ));
    }
}
