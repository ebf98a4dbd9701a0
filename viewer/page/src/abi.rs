//! What the page's scripts call. A message comes in by [`baudbot_room`], its bytes, and [`baudbot_take`]; those that go out come one after
//! another by [`baudbot_next`].

use std::cell::RefCell;
use std::time::Duration;

use bytes::Bytes;

use crate::page::Page;

/// All that there is.
struct All {
    page: Page,
    /// The message that comes in.
    inbox: Vec<u8>,
    /// The one that goes out, with its port.
    outgoing: (u32, Bytes),
}

thread_local! {
    static ALL: RefCell<Option<All>> = const { RefCell::new(None) };
}

/// Makes the server. Its recordings are in the folder `/recordings`, which must be there. Gives whether it could.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_begin() -> bool {
    let page = Page::new("/recordings".into());
    page.is_ok_and(|page| {
        ALL.set(Some(All { page, inbox: Vec::new(), outgoing: (0, Bytes::new()) }));
        true
    })
}

/// Makes room for a message of so many bytes. Gives where they are to be written.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_room(bytes: usize) -> *mut u8 {
    with(std::ptr::null_mut(), |all| {
        all.inbox = vec![0; bytes];
        all.inbox.as_mut_ptr()
    })
}

/// Takes the message that was written, from this port.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_take(port: u32) {
    with((), |all| all.page.take(port, std::mem::take(&mut all.inbox).into()));
}

/// A client is gone.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_close(port: u32) {
    with((), |all| all.page.close(port));
}

/// Works for so many milliseconds at most. Gives whether there is more to do at once.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_turn(at_most_ms: u32) -> bool {
    with(false, |all| all.page.turn(Duration::from_millis(at_most_ms.into())))
}

/// Goes on to the next message that goes out. Gives its length in bytes, 0 if there is none.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_next() -> usize {
    with(0, |all| {
        all.outgoing = all.page.next_message().unwrap_or_default();
        all.outgoing.1.len()
    })
}

/// Where the bytes of that message are, until the next one.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_bytes() -> *const u8 {
    with(std::ptr::null(), |all| all.outgoing.1.as_ptr())
}

/// Its port.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn baudbot_port() -> u32 {
    with(0, |all| all.outgoing.0)
}

/// Does something, or nothing before the beginning.
fn with<T>(otherwise: T, does: impl FnOnce(&mut All) -> T) -> T {
    ALL.with_borrow_mut(|all| all.as_mut().map_or(otherwise, does))
}
