//! The names of system calls.

/// The name of a call.
pub(crate) fn call(number: i64) -> &'static str {
    usize::try_from(number)
        .ok()
        .and_then(syscalls::Sysno::new)
        .map_or("an unknown system call", |call| call.name())
}
