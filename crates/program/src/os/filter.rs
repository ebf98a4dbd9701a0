//! The seccomp filter: which calls stop a task. All others run as they are, at full speed.

use libc::{BPF_ABS, BPF_JEQ, BPF_JGE, BPF_JMP, BPF_K, BPF_LD, BPF_RET, BPF_W, sock_filter};

/// AUDIT_ARCH_X86_64 of linux/audit.h.
const X86_64: u32 = 0xC000_003E;
/// Calls of the x32 interface have this bit.
const X32: u32 = 0x4000_0000;
/// The places in seccomp_data (linux/seccomp.h).
const NUMBER_AT: u32 = 0;
const ARCHITECTURE_AT: u32 = 4;

/// The program for the kernel: it shows us the calls of `shown`. Those of 32-bit code, whose numbers mean other
/// calls, get the signal SIGSYS.
pub(crate) fn program(shown: &[i64]) -> Vec<sock_filter> {
    let trace = statement(BPF_RET | BPF_K, libc::SECCOMP_RET_TRACE);
    let trap = statement(BPF_RET | BPF_K, libc::SECCOMP_RET_TRAP);
    let mut program = vec![
        statement(BPF_LD | BPF_W | BPF_ABS, ARCHITECTURE_AT),
        jump(BPF_JEQ, X86_64, 1, 0),
        trap,
        statement(BPF_LD | BPF_W | BPF_ABS, NUMBER_AT),
        jump(BPF_JGE, X32, 0, 1),
        trap,
    ];
    for number in shown {
        program.push(jump(BPF_JEQ, *number as u32, 0, 1));
        program.push(trace);
    }
    program.push(statement(BPF_RET | BPF_K, libc::SECCOMP_RET_ALLOW));
    program
}

fn statement(code: u32, k: u32) -> sock_filter {
    sock_filter { code: code as u16, jt: 0, jf: 0, k }
}

/// Goes on `yes` or `no` statements further.
fn jump(comparison: u32, k: u32, yes: u8, no: u8) -> sock_filter {
    sock_filter { code: (BPF_JMP | comparison | BPF_K) as u16, jt: yes, jf: no, k }
}
