//! Errors as Python's exceptions, and panics that never cross.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, TryLockError};

use baudbot_run::learn::LearnError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

static INVALID: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static BUSY: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static FAILED: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// `baudbot.Invalid`, with the path of the field that is wrong if it is one.
pub(crate) fn invalid(py: Python<'_>, text: &str, path: Option<String>) -> PyErr {
    match INVALID.import(py, "baudbot._errors", "Invalid").and_then(|class| class.call1((text, path))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// `baudbot.Error`: what was asked for makes sense, and cannot be done.
pub(crate) fn failed(py: Python<'_>, text: &str) -> PyErr {
    match FAILED.import(py, "baudbot.errors", "Error").and_then(|class| class.call1((text,))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// The value behind a world's lock. Another thread that is in it meanwhile is `baudbot.Busy`.
pub(crate) fn locked<'a, T>(py: Python<'_>, lock: &'a Mutex<T>) -> PyResult<MutexGuard<'a, T>> {
    match lock.try_lock() {
        Ok(guard) => Ok(guard),
        // The thread that panicked has said so.
        Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => {
            let text = "another thread is stepping this world; a world is for one thread at a time, make one for each";
            Err(match BUSY.import(py, "baudbot._errors", "Busy").and_then(|class| class.call1((text,))) {
                Ok(error) => PyErr::from_value(error),
                Err(error) => error,
            })
        }
    }
}

pub(crate) fn of_learning(py: Python<'_>, error: &LearnError) -> PyErr {
    invalid(py, &error.to_string(), error.path())
}

/// Does this with the interpreter free for other threads. A panic becomes an exception.
pub(crate) fn apart<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let outcome = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    outcome.map_err(|panic| panicked(py, &*panic))
}

/// The same with a world that nobody else has meanwhile.
pub(crate) fn apart_with<S: Send, T: Send>(
    py: Python<'_>,
    world: &mut S,
    work: impl FnOnce(&mut S) -> T + Send,
) -> PyResult<T> {
    apart(py, move || work(world))
}

/// The same for what is so short that other threads can wait.
pub(crate) fn at_once<T>(py: Python<'_>, work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| panicked(py, &*panic))
}

fn panicked(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    failed(py, &format!("baudbot panicked, which is a bug in it: {text}"))
}
