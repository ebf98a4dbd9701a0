//! One processor for a thread that traces and for all that it traces: a stop is then a switch on one processor, which takes a third
//! to a sixth of the time of one between two.

use std::cell::RefCell;
use std::mem::{size_of, zeroed};
use std::rc::{Rc, Weak};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Threads take the processors in turn, so that those of a sweep do not meet on one.
static NEXT: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static PIN: RefCell<Weak<Pin>> = const { RefCell::new(Weak::new()) };
}

/// This thread stays on one processor while this lives. Processes that it starts stay there for good.
#[derive(Debug)]
pub(crate) struct Pin {
    before: libc::cpu_set_t,
}

/// Pins this thread; sessions of one thread share a pin. None if the system does not allow it.
pub(crate) fn pin() -> Option<Rc<Pin>> {
    if let Some(pin) = PIN.with_borrow(Weak::upgrade) {
        return Some(pin);
    }
    // SAFETY: a set is an array of integers, for which zeros are valid; it outlives the calls.
    let before = unsafe {
        let mut before: libc::cpu_set_t = zeroed();
        if libc::sched_getaffinity(0, size_of::<libc::cpu_set_t>(), &raw mut before) != 0 {
            return None;
        }
        let allowed: Vec<usize> =
            (0..libc::CPU_SETSIZE as usize).filter(|cpu| libc::CPU_ISSET(*cpu, &before)).collect();
        let mut one: libc::cpu_set_t = zeroed();
        libc::CPU_SET(allowed[NEXT.fetch_add(1, Ordering::Relaxed) % allowed.len()], &mut one);
        if libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const one) != 0 {
            return None;
        }
        before
    };
    let pin = Rc::new(Pin { before });
    PIN.with_borrow_mut(|weak| *weak = Rc::downgrade(&pin));
    Some(pin)
}

impl Drop for Pin {
    fn drop(&mut self) {
        // SAFETY: the set outlives the call.
        unsafe { libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const self.before) };
    }
}
