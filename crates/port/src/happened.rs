//! The events at the program's end of a port, besides data.

/// An event at the program's end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Happened {
    /// A program has opened the port, or has set DTR on it.
    Opened,
    Closed,
    /// The program sends a break, or ends it.
    Break(bool),
    PurgeReceived,
    PurgeSent,
    /// A program was disconnected, as that of another port holds the cable.
    Refused,
}
