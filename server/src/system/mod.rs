//! The calls to the operating system: threads, open files, users, files that are opened with care. One file a system.

#[cfg(unix)]
mod descriptors;
#[cfg(unix)]
mod unix;
#[cfg(all(unix, feature = "network"))]
pub(crate) use unix::everybody_can_read;
#[cfg(unix)]
pub use unix::raise_descriptor_limit;
#[cfg(unix)]
pub(crate) use unix::{
    blocking, is_this_user, leaves_room, most_journals, open_plain_file, open_private_log, usual_connections,
};

#[cfg(not(unix))]
mod elsewhere;
#[cfg(not(unix))]
pub use elsewhere::raise_descriptor_limit;
#[cfg(not(unix))]
pub(crate) use elsewhere::{
    blocking, is_this_user, leaves_room, most_journals, open_plain_file, open_private_log, usual_connections,
};
