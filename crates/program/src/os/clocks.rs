//! Code that tells simulated time in the process that asks, without a call. It takes the place of the vDSO's, see `vdso`.
//!
//! It may be used only so often before the tracer has to know, which counts looks: then, and for what it does not know, it makes the
//! call itself. A signal's handler may come between any two instructions and look, too, so counting down is one instruction.

use std::arch::global_asm;

// The page: looks that are left (0), the wall clock's seconds (8) and nanoseconds (16), the other clock's (24, 32), and the
// microseconds of the wall clock (40). The masks have the clocks of linux/time.h that follow the one and the other.
global_asm!(
    ".pushsection .rodata.baudbot_clocks, \"a\", @progbits",
    ".balign 8",
    ".hidden baudbot_clocks_begin, baudbot_clocks_timeofday, baudbot_clocks_time, baudbot_clocks_end",
    ".globl baudbot_clocks_begin, baudbot_clocks_timeofday, baudbot_clocks_time, baudbot_clocks_end",
    "baudbot_clocks_begin:",
    ".quad 0",
    // int clock_gettime(clockid_t edi, struct timespec *rsi)
    "cmp edi, 11",
    "ja 3f",
    "test rsi, rsi",
    "jz 3f",
    "mov rdx, [rip + baudbot_clocks_begin]",
    "lea rcx, [rdx + 8]",
    "mov eax, 0x921",
    "bt eax, edi",
    "jc 1f",
    "lea rcx, [rdx + 24]",
    "mov eax, 0x2d2",
    "bt eax, edi",
    "jnc 3f",
    "1: dec qword ptr [rdx]",
    "js 2f",
    "mov rax, [rcx]",
    "mov [rsi], rax",
    "mov rax, [rcx + 8]",
    "mov [rsi + 8], rax",
    "xor eax, eax",
    "ret",
    "2: inc qword ptr [rdx]",
    "3: mov eax, 228",
    "syscall",
    "ret",
    // int gettimeofday(struct timeval *rdi, struct timezone *rsi)
    "baudbot_clocks_timeofday:",
    "test rdi, rdi",
    "jz 3f",
    "test rsi, rsi",
    "jnz 3f",
    "mov rdx, [rip + baudbot_clocks_begin]",
    "dec qword ptr [rdx]",
    "js 2f",
    "mov rax, [rdx + 8]",
    "mov [rdi], rax",
    "mov rax, [rdx + 40]",
    "mov [rdi + 8], rax",
    "xor eax, eax",
    "ret",
    "2: inc qword ptr [rdx]",
    "3: mov eax, 96",
    "syscall",
    "ret",
    // time_t time(time_t *rdi)
    "baudbot_clocks_time:",
    "mov rdx, [rip + baudbot_clocks_begin]",
    "dec qword ptr [rdx]",
    "js 2f",
    "mov rax, [rdx + 8]",
    "test rdi, rdi",
    "jz 1f",
    "mov [rdi], rax",
    "1: ret",
    "2: inc qword ptr [rdx]",
    "mov eax, 201",
    "syscall",
    "ret",
    "baudbot_clocks_end:",
    ".popsection",
);

unsafe extern "C" {
    safe static baudbot_clocks_begin: u8;
    safe static baudbot_clocks_timeofday: u8;
    safe static baudbot_clocks_time: u8;
    safe static baudbot_clocks_end: u8;
}

/// Bytes of the page.
pub(crate) const PAGE: usize = 48;

/// The code for a process whose page is at this address.
pub(crate) fn code(page: u64) -> Vec<u8> {
    // SAFETY: the symbols are the ends of one piece of constant bytes.
    let code =
        unsafe { std::slice::from_raw_parts(&raw const baudbot_clocks_begin, place(&baudbot_clocks_end)) };
    [&page.to_ne_bytes(), &code[8..]].concat()
}

/// The places of its functions in it, by the names that the kernel's vDSO gives them.
pub(crate) fn functions() -> [(&'static [u8], usize); 3] {
    [
        (b"__vdso_clock_gettime", 8),
        (b"__vdso_gettimeofday", place(&baudbot_clocks_timeofday)),
        (b"__vdso_time", place(&baudbot_clocks_time)),
    ]
}

fn place(symbol: &'static u8) -> usize {
    std::ptr::from_ref(symbol).addr() - (&raw const baudbot_clocks_begin).addr()
}

/// The page of an instant.
pub(crate) fn page(looks_left: i64, wall_ns: u64, other_ns: u64) -> [u8; PAGE] {
    const SECOND_NS: u64 = 1_000_000_000;
    let words = [
        looks_left.cast_unsigned(),
        wall_ns / SECOND_NS,
        wall_ns % SECOND_NS,
        other_ns / SECOND_NS,
        other_ns % SECOND_NS,
        wall_ns % SECOND_NS / 1000,
    ];
    let mut page = [0; PAGE];
    for (place, word) in page.chunks_exact_mut(8).zip(words) {
        place.copy_from_slice(&word.to_ne_bytes());
    }
    page
}
