//! The files that descriptors stand for, as /proc shows them. A descriptor that is open changes only by calls that we see (close, dup2,
//! exec), and an empty pipe fills only by others, so /proc is asked once.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;

use crate::os::{pipe, proc};
use crate::task::Task;

/// What is known of descriptors, by the numbers of tasks and their own.
#[derive(Debug, Default)]
pub(crate) struct Files {
    names: RefCell<BTreeMap<(u32, i32), Rc<Path>>>,
    quiet: RefCell<BTreeSet<(u32, i32)>>,
}

impl Files {
    /// The file that a descriptor stands for: a path, or a text such as `pipe:[4711]`.
    pub(crate) fn name(&self, task: &Task, descriptor: i32) -> Option<Rc<Path>> {
        let key = (task.number, descriptor);
        if let Some(name) = self.names.borrow().get(&key) {
            return Some(Rc::clone(name));
        }
        let name: Rc<Path> = proc::descriptor(task.tid, descriptor)?.into();
        self.names.borrow_mut().insert(key, Rc::clone(&name));
        Some(name)
    }

    /// Whether a task's end of a pipe has nothing to read, and nobody has closed the other one.
    pub(crate) fn is_quiet(&self, task: &Task, descriptor: i32) -> bool {
        let key = (task.number, descriptor);
        if self.quiet.borrow().contains(&key) {
            return true;
        }
        let is_quiet = pipe::is_quiet(task.tid, descriptor);
        if is_quiet {
            self.quiet.borrow_mut().insert(key);
        }
        is_quiet
    }

    /// Bytes may enter a pipe.
    pub(crate) fn stir(&self) {
        self.quiet.borrow_mut().clear();
    }

    /// A task closes a descriptor. Others may have the same table of them.
    pub(crate) fn forget(&self, descriptor: i32) {
        self.names.borrow_mut().retain(|(_, other), _| *other != descriptor);
        self.stir();
    }

    /// Many descriptors are closed, or a task is no more.
    pub(crate) fn forget_all(&self) {
        self.names.borrow_mut().clear();
        self.stir();
    }
}
