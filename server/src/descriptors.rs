//! How many files and connections the process may have open at a time.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Raises the process' limit of open files to the highest that the system lets it have. Connections count as open files.
/// A server that is to have many should do this first.
pub fn raise_descriptor_limit() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current != maximum {
        // Where that is not allowed the limit stays, and with it what follows from it.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    }
}

/// Most connections of a server that is not told a number: three quarters of the process' open files, but so many that 32
/// files are left, and not more than 16,384. Worlds, recordings and the listeners themselves need the rest.
pub(crate) fn usual_connections() -> usize {
    let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
    let connections = files.saturating_sub((files / 4).max(LEAST_OTHERS));
    usize::try_from(connections).unwrap_or(usize::MAX).clamp(1, MOST_CONNECTIONS)
}

/// So many files a server with a few worlds needs besides its connections: without any work it has sixteen.
const LEAST_OTHERS: u64 = 32;

/// Each takes some tens of kilobytes while it is open.
const MOST_CONNECTIONS: usize = 16_384;
