//! Arithmetic, and what it leaves in the status register.
//!
//! Each function takes the status register and returns the result and the new status register. Bits that an instruction
//! does not mention stay as they are.
//!
//! Source: *AVR Instruction Set Manual*, the Boolean formulas of each instruction.

/// Carry.
pub(crate) const C: u8 = 1 << 0;
/// Zero.
pub(crate) const Z: u8 = 1 << 1;
/// Negative.
pub(crate) const N: u8 = 1 << 2;
/// Two's complement overflow.
pub(crate) const V: u8 = 1 << 3;
/// Sign: N exclusive-or V.
pub(crate) const S: u8 = 1 << 4;
/// Half carry.
pub(crate) const H: u8 = 1 << 5;
/// Bit copy storage.
pub(crate) const T: u8 = 1 << 6;
/// Global interrupt enable.
pub(crate) const I: u8 = 1 << 7;

/// `ADD` and `ADC`: the carry comes in by `carry`, 0 or 1.
#[inline]
pub(crate) const fn add(sreg: u8, a: u8, b: u8, carry: u8) -> (u8, u8) {
    let sum = a as u16 + b as u16 + carry as u16;
    (sum as u8, sreg & (I | T) | flags_of(a, b, sum))
}

/// `SUB`, `SUBI`, `CP`, `CPI`: `a - b`.
#[inline]
pub(crate) const fn sub(sreg: u8, a: u8, b: u8) -> (u8, u8) {
    let difference = (a as u16).wrapping_sub(b as u16);
    (difference as u8, sreg & (I | T) | flags_of(a, b, difference))
}

/// `SBC`, `SBCI`, `CPC`: `a - b - C`. Z is never set, only kept.
#[inline]
pub(crate) const fn sbc(sreg: u8, a: u8, b: u8) -> (u8, u8) {
    let difference = (a as u16).wrapping_sub(b as u16).wrapping_sub((sreg & C) as u16);
    (difference as u8, sreg & (I | T) | (flags_of(a, b, difference) & (sreg | !Z)))
}

/// The flags of `AND`, `OR` and `EOR`.
#[inline]
pub(crate) const fn logic(sreg: u8, result: u8) -> u8 {
    sreg & (I | T | H | C) | RESULT[result as usize]
}

/// `COM`.
#[inline]
pub(crate) const fn com(sreg: u8, a: u8) -> (u8, u8) {
    (!a, logic(sreg, !a) | C)
}

/// `NEG`.
#[inline]
pub(crate) const fn neg(sreg: u8, a: u8) -> (u8, u8) {
    sub(sreg, 0, a)
}

/// `INC`.
#[inline]
pub(crate) const fn inc(sreg: u8, a: u8) -> (u8, u8) {
    let result = a.wrapping_add(1);
    let overflow = if result == 0x80 { V | S } else { 0 };
    (result, logic(sreg, result) ^ overflow)
}

/// `DEC`.
#[inline]
pub(crate) const fn dec(sreg: u8, a: u8) -> (u8, u8) {
    let result = a.wrapping_sub(1);
    let overflow = if result == 0x7F { V | S } else { 0 };
    (result, logic(sreg, result) ^ overflow)
}

/// `ASR`, `LSR` and `ROR`: `top` is the bit that comes in, 0 or 0x80.
#[inline]
pub(crate) const fn shift_right(sreg: u8, a: u8, top: u8) -> (u8, u8) {
    let result = a >> 1 | top;
    let carry = a & C;
    // V is N exclusive-or C, so S is C.
    let overflow = (result >> 7) ^ carry;
    let overflow = overflow << 3 | overflow << 4;
    (result, sreg & (I | T | H) | carry | (RESULT[result as usize] ^ overflow))
}

/// `ADIW`.
#[inline]
pub(crate) const fn adiw(sreg: u8, a: u16, k: u8) -> (u16, u8) {
    let result = a.wrapping_add(k as u16);
    let overflow = ((!a & result) >> 8) as u8 & 0x80;
    let carry = ((a & !result) >> 15) as u8;
    (result, sreg & (I | T | H) | carry | word_flags(result, overflow))
}

/// `SBIW`.
#[inline]
pub(crate) const fn sbiw(sreg: u8, a: u16, k: u8) -> (u16, u8) {
    let result = a.wrapping_sub(k as u16);
    let overflow = ((a & !result) >> 8) as u8 & 0x80;
    let carry = ((!a & result) >> 15) as u8;
    (result, sreg & (I | T | H) | carry | word_flags(result, overflow))
}

/// `MUL`, `MULS`, `MULSU`: C is the product's highest bit.
#[inline]
pub(crate) const fn product(sreg: u8, product: u16) -> (u16, u8) {
    let zero = if product == 0 { Z } else { 0 };
    (product, sreg & !(Z | C) | (product >> 15) as u8 | zero)
}

/// `FMUL`, `FMULS`, `FMULSU`: the product shifted left by one, C its highest bit before that.
#[inline]
pub(crate) const fn fractional_product(sreg: u8, product: u16) -> (u16, u8) {
    let shifted = product << 1;
    let zero = if shifted == 0 { Z } else { 0 };
    (shifted, sreg & !(Z | C) | (product >> 15) as u8 | zero)
}

#[inline]
const fn word_flags(result: u16, overflow: u8) -> u8 {
    let zero = if result == 0 { Z } else { 0 };
    let sign = (result >> 8) as u8 & 0x80;
    overflow >> 4 | zero | sign >> 5 | (sign ^ overflow) >> 3
}

/// The flags of a sum or difference of nine bits. Where it differs from `a ^ b` a carry or borrow has come into the bit.
#[inline]
const fn flags_of(a: u8, b: u8, result: u16) -> u8 {
    CARRIES[((a as u16 ^ b as u16 ^ result) & 0x1FF) as usize] ^ RESULT[(result & 0xFF) as usize]
}

/// Z, N and, without an overflow, S of a result.
static RESULT: [u8; 256] = {
    let mut table = [0; 256];
    let mut result = 0;
    while result < 256 {
        table[result] = if result == 0 { Z } else { 0 } | if result >= 0x80 { N | S } else { 0 };
        result += 1;
    }
    table
};

/// H, C, V, and how V turns S round, by the bits into which a carry came: H is that into bit 4, C that into bit 8, and V is set
/// if only one of those into bits 7 and 8 came.
static CARRIES: [u8; 512] = {
    let mut table = [0; 512];
    let mut carries = 0;
    while carries < 512 {
        let half = if carries & 0x10 != 0 { H } else { 0 };
        let carry = if carries & 0x100 != 0 { C } else { 0 };
        let overflow = if (carries >> 1 ^ carries) & 0x80 != 0 { V | S } else { 0 };
        table[carries] = half | carry | overflow;
        carries += 1;
    }
    table
};
