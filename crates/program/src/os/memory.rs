//! The memory of other processes.

use std::io;

fn result(moved: isize, wanted: usize) -> io::Result<()> {
    match usize::try_from(moved) {
        Ok(moved) if moved == wanted => Ok(()),
        Ok(_) => Err(io::ErrorKind::UnexpectedEof.into()),
        Err(_) => Err(io::Error::last_os_error()),
    }
}

/// Reads all of `into` from `address`.
pub(crate) fn read(tid: i32, address: u64, into: &mut [u8]) -> io::Result<()> {
    if into.is_empty() {
        return Ok(());
    }
    let here = libc::iovec { iov_base: into.as_mut_ptr().cast(), iov_len: into.len() };
    let there = libc::iovec { iov_base: address as *mut libc::c_void, iov_len: into.len() };
    // SAFETY: `here` is the slice, and the kernel checks `there`.
    result(unsafe { libc::process_vm_readv(tid, &raw const here, 1, &raw const there, 1, 0) }, into.len())
}

/// Writes all of `from` to `address`.
pub(crate) fn write(tid: i32, address: u64, from: &[u8]) -> io::Result<()> {
    if from.is_empty() {
        return Ok(());
    }
    let here = libc::iovec { iov_base: from.as_ptr().cast_mut().cast(), iov_len: from.len() };
    let there = libc::iovec { iov_base: address as *mut libc::c_void, iov_len: from.len() };
    // SAFETY: `here` is the slice, which is only read, and the kernel checks `there`.
    result(unsafe { libc::process_vm_writev(tid, &raw const here, 1, &raw const there, 1, 0) }, from.len())
}

/// The bytes before the next zero, at most 4,096.
pub(crate) fn text(tid: i32, address: u64) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    let mut address = address;
    while text.len() < 4096 {
        // A piece never leaves its page: the next one may not be there.
        let mut piece = [0; 256];
        let size = 256 - (address % 256) as usize;
        read(tid, address, &mut piece[..size])?;
        if let Some(end) = piece[..size].iter().position(|byte| *byte == 0) {
            text.extend_from_slice(&piece[..end]);
            return Ok(text);
        }
        text.extend_from_slice(&piece[..size]);
        address += size as u64;
    }
    Err(io::ErrorKind::InvalidInput.into())
}
