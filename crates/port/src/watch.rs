//! Notices programs that open a terminal, however soon they close it again (inotify(7)).

use std::io;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use rustix::fs::inotify::{CreateFlags, ReadFlags, Reader, WatchFlags, add_watch, init};

/// A watch on a terminal.
#[derive(Debug)]
pub(crate) struct Watch(OwnedFd);

/// The events since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// The number of times that it was opened; several times in a row may count as one.
    pub(crate) opened: u32,
    /// Whether a program that could write to it has closed it.
    pub(crate) writer_gone: bool,
}

impl Watch {
    /// Watches a terminal from now on.
    pub(crate) fn new(terminal: &Path) -> io::Result<Self> {
        let inotify = init(CreateFlags::CLOEXEC | CreateFlags::NONBLOCK)?;
        add_watch(&inotify, terminal, WatchFlags::OPEN | WatchFlags::CLOSE_WRITE)?;
        Ok(Self(inotify))
    }

    /// The descriptor to wait at until a program opens the port.
    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }

    /// The events since the last look.
    pub(crate) fn look(&self) -> Seen {
        let (mut seen, mut buffer) = (Seen::default(), [MaybeUninit::uninit(); 1024]);
        let mut events = Reader::new(self.fd(), &mut buffer);
        // An error means that there are no more.
        while let Ok(event) = events.next() {
            seen.opened += u32::from(event.events().contains(ReadFlags::OPEN));
            seen.writer_gone |= event.events().contains(ReadFlags::CLOSE_WRITE);
        }
        seen
    }
}
