//! Instructions, decoded once for each program.
//!
//! Source: *AVR Instruction Set Manual*, for the core AVRe+.

mod decode;
mod wait;

pub use decode::decode;
pub(crate) use wait::{LONGEST_LOOP, operation};

/// An instruction with its operands.
///
/// Registers are numbers from 0 to 31, masks are bits of a byte, I/O registers are given by data address (0x20 to 0x5F),
/// offsets are words from the next instruction. An instruction of two words is one operation, and its second word, which
/// can be jumped to, is decoded as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // The mnemonics are those of the manual.
pub enum Op {
    Nop,
    Add {
        d: u8,
        r: u8,
    },
    Adc {
        d: u8,
        r: u8,
    },
    Sub {
        d: u8,
        r: u8,
    },
    Sbc {
        d: u8,
        r: u8,
    },
    And {
        d: u8,
        r: u8,
    },
    Or {
        d: u8,
        r: u8,
    },
    Eor {
        d: u8,
        r: u8,
    },
    Mov {
        d: u8,
        r: u8,
    },
    Cp {
        d: u8,
        r: u8,
    },
    Cpc {
        d: u8,
        r: u8,
    },
    Cpse {
        d: u8,
        r: u8,
    },
    Subi {
        d: u8,
        k: u8,
    },
    Sbci {
        d: u8,
        k: u8,
    },
    Andi {
        d: u8,
        k: u8,
    },
    Ori {
        d: u8,
        k: u8,
    },
    Cpi {
        d: u8,
        k: u8,
    },
    Ldi {
        d: u8,
        k: u8,
    },
    Com {
        d: u8,
    },
    Neg {
        d: u8,
    },
    Swap {
        d: u8,
    },
    Inc {
        d: u8,
    },
    Dec {
        d: u8,
    },
    Asr {
        d: u8,
    },
    Lsr {
        d: u8,
    },
    Ror {
        d: u8,
    },
    Adiw {
        d: u8,
        k: u8,
    },
    Sbiw {
        d: u8,
        k: u8,
    },
    Movw {
        d: u8,
        r: u8,
    },
    Mul {
        d: u8,
        r: u8,
    },
    Muls {
        d: u8,
        r: u8,
    },
    Mulsu {
        d: u8,
        r: u8,
    },
    Fmul {
        d: u8,
        r: u8,
    },
    Fmuls {
        d: u8,
        r: u8,
    },
    Fmulsu {
        d: u8,
        r: u8,
    },
    Rjmp {
        offset: i16,
    },
    Rcall {
        offset: i16,
    },
    Jmp {
        high: u8,
        low: u16,
    },
    Call {
        high: u8,
        low: u16,
    },
    Ijmp,
    Icall,
    Ret,
    Reti,
    Brbs {
        mask: u8,
        offset: i8,
    },
    Brbc {
        mask: u8,
        offset: i8,
    },
    Sbrc {
        r: u8,
        mask: u8,
    },
    Sbrs {
        r: u8,
        mask: u8,
    },
    Sbic {
        address: u8,
        mask: u8,
    },
    Sbis {
        address: u8,
        mask: u8,
    },
    Sbi {
        address: u8,
        mask: u8,
    },
    Cbi {
        address: u8,
        mask: u8,
    },
    In {
        d: u8,
        address: u8,
    },
    Out {
        address: u8,
        r: u8,
    },
    /// `LD Rd, X`, `LDD Rd, Y+q`, `LDD Rd, Z+q`; `pointer` is the low register of the pair.
    Load {
        d: u8,
        pointer: u8,
        offset: u8,
    },
    /// `LD Rd, X+` and so on.
    LoadIncrement {
        d: u8,
        pointer: u8,
    },
    /// `LD Rd, -X` and so on.
    LoadDecrement {
        d: u8,
        pointer: u8,
    },
    Store {
        r: u8,
        pointer: u8,
        offset: u8,
    },
    StoreIncrement {
        r: u8,
        pointer: u8,
    },
    StoreDecrement {
        r: u8,
        pointer: u8,
    },
    Lds {
        d: u8,
        address: u16,
    },
    Sts {
        r: u8,
        address: u16,
    },
    Push {
        r: u8,
    },
    Pop {
        d: u8,
    },
    Lpm {
        d: u8,
    },
    LpmIncrement {
        d: u8,
    },
    Spm,
    Bset {
        mask: u8,
    },
    Bclr {
        mask: u8,
    },
    Bst {
        d: u8,
        bit: u8,
    },
    Bld {
        d: u8,
        bit: u8,
    },
    Sleep,
    Wdr,
    Break,
    /// `RJMP` at the end of a loop that only waits: an iteration takes `cycles`. Not decoded from a word alone.
    WaitJump {
        offset: i8,
        cycles: u8,
    },
    /// `BRBS` or `BRBC` at the end of such a loop; `flag` is the number of the flag, plus 8 if it must be set.
    WaitBranch {
        flag: u8,
        offset: i8,
        cycles: u8,
    },
    /// `BRNE` back to `SBIW low, 1` before it: a delay that counts two registers down. Not decoded from a word alone.
    CountTwo {
        low: u8,
    },
    /// `BRNE` back to `SUBI low, 1`, `SBCI middle, 0`, `SBCI high, 0` before it.
    CountThree {
        low: u8,
        middle: u8,
        high: u8,
    },
    /// A word that is no instruction of these parts. It does nothing for one cycle.
    Illegal {
        word: u16,
    },
}

impl Op {
    /// Words of program memory: what a skip passes over, and a cycle more for each.
    #[inline]
    pub const fn words(self) -> u32 {
        if matches!(self, Self::Jmp { .. } | Self::Call { .. } | Self::Lds { .. } | Self::Sts { .. }) {
            2
        } else {
            1
        }
    }
}
