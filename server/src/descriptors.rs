//! File descriptors: how many files and connections the process may have open at a time.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Raises the process' limit of open files, connections included, to the highest that the system allows. A server that is to
/// have many should do this first.
pub fn raise_descriptor_limit() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current != maximum {
        // If that is not allowed, the limit stays, and the server has fewer connections.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    }
}

/// The limit of connections of a server that is not told a number: three quarters of the process' open files, but so that 32
/// files are left, and not more than 16,384. Worlds, recordings and the listeners themselves need the rest.
pub(crate) fn usual_connections() -> usize {
    let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
    let connections = files.saturating_sub((files / 4).max(LEAST_OTHERS));
    usize::try_from(connections).unwrap_or(usize::MAX).clamp(1, MOST_CONNECTIONS)
}

/// Files that a server with a few worlds needs besides its connections: an idle one has sixteen.
const LEAST_OTHERS: u64 = 32;

/// Each takes some tens of kilobytes while it is open.
const MOST_CONNECTIONS: usize = 16_384;
