//! Arithmetic, and what it leaves in the status register.
//!
//! Each function takes the status register and returns the result and the new status register. Bits that an instruction
//! does not mention stay as they are.
//!
//! Source: *AVR Instruction Set Manual*, the Boolean formulas of each instruction.

/// Carry.
pub const C: u8 = 1 << 0;
/// Zero.
pub const Z: u8 = 1 << 1;
/// Negative.
pub const N: u8 = 1 << 2;
/// Two's complement overflow.
pub const V: u8 = 1 << 3;
/// Sign: N exclusive-or V.
pub const S: u8 = 1 << 4;
/// Half carry.
pub const H: u8 = 1 << 5;
/// Bit copy storage.
pub const T: u8 = 1 << 6;
/// Global interrupt enable.
pub const I: u8 = 1 << 7;

/// `ADD` and `ADC`: the carry comes in by `carry`, 0 or 1.
#[inline]
pub const fn add(sreg: u8, a: u8, b: u8, carry: u8) -> (u8, u8) {
    let sum = a.wrapping_add(b).wrapping_add(carry);
    let carries = (a & b) | ((a | b) & !sum);
    let overflow = (a ^ sum) & (b ^ sum);
    (sum, sreg & (I | T) | carries >> 7 | (carries & 0x08) << 2 | overflow >> 7 << 3 | zero(sum) | sign(sum, overflow))
}

/// `SUB`, `SUBI`, `CP`, `CPI`: `a - b`.
#[inline]
pub const fn sub(sreg: u8, a: u8, b: u8) -> (u8, u8) {
    let difference = a.wrapping_sub(b);
    (difference, sreg & (I | T) | borrow_flags(a, b, difference) | zero(difference))
}

/// `SBC`, `SBCI`, `CPC`: `a - b - C`. Z is never set, only kept.
#[inline]
pub const fn sbc(sreg: u8, a: u8, b: u8) -> (u8, u8) {
    let difference = a.wrapping_sub(b).wrapping_sub(sreg & C);
    (difference, sreg & (I | T) | borrow_flags(a, b, difference) | (zero(difference) & sreg))
}

/// The flags of `AND`, `OR`, `EOR` and `DEC`-like results without overflow.
#[inline]
pub const fn logic(sreg: u8, result: u8) -> u8 {
    sreg & (I | T | H | C) | zero(result) | sign(result, 0)
}

/// `COM`.
#[inline]
pub const fn com(sreg: u8, a: u8) -> (u8, u8) {
    (!a, logic(sreg, !a) | C)
}

/// `NEG`.
#[inline]
pub const fn neg(sreg: u8, a: u8) -> (u8, u8) {
    sub(sreg, 0, a)
}

/// `INC`.
#[inline]
pub const fn inc(sreg: u8, a: u8) -> (u8, u8) {
    let result = a.wrapping_add(1);
    let overflow = if result == 0x80 { 0x80 } else { 0 };
    (result, sreg & (I | T | H | C) | overflow >> 7 << 3 | zero(result) | sign(result, overflow))
}

/// `DEC`.
#[inline]
pub const fn dec(sreg: u8, a: u8) -> (u8, u8) {
    let result = a.wrapping_sub(1);
    let overflow = if result == 0x7F { 0x80 } else { 0 };
    (result, sreg & (I | T | H | C) | overflow >> 7 << 3 | zero(result) | sign(result, overflow))
}

/// `ASR`, `LSR` and `ROR`: `top` is the bit that comes in, 0 or 0x80.
#[inline]
pub const fn shift_right(sreg: u8, a: u8, top: u8) -> (u8, u8) {
    let result = a >> 1 | top;
    let carry = a & 1;
    // V is N exclusive-or C.
    let overflow = (result & 0x80) ^ (carry << 7);
    (result, sreg & (I | T | H) | carry | overflow >> 7 << 3 | zero(result) | sign(result, overflow))
}

/// `ADIW`.
#[inline]
pub const fn adiw(sreg: u8, a: u16, k: u8) -> (u16, u8) {
    let result = a.wrapping_add(k as u16);
    let overflow = ((!a & result) >> 8) as u8 & 0x80;
    let carry = ((a & !result) >> 15) as u8;
    (result, sreg & (I | T | H) | carry | word_flags(result, overflow))
}

/// `SBIW`.
#[inline]
pub const fn sbiw(sreg: u8, a: u16, k: u8) -> (u16, u8) {
    let result = a.wrapping_sub(k as u16);
    let overflow = ((a & !result) >> 8) as u8 & 0x80;
    let carry = ((!a & result) >> 15) as u8;
    (result, sreg & (I | T | H) | carry | word_flags(result, overflow))
}

/// `MUL`, `MULS`, `MULSU`: C is the product's highest bit.
#[inline]
pub const fn product(sreg: u8, product: u16) -> (u16, u8) {
    let zero = if product == 0 { Z } else { 0 };
    (product, sreg & !(Z | C) | (product >> 15) as u8 | zero)
}

/// `FMUL`, `FMULS`, `FMULSU`: the product shifted left by one, C its highest bit before that.
#[inline]
pub const fn fractional_product(sreg: u8, product: u16) -> (u16, u8) {
    let shifted = product << 1;
    let zero = if shifted == 0 { Z } else { 0 };
    (shifted, sreg & !(Z | C) | (product >> 15) as u8 | zero)
}

#[inline]
const fn zero(result: u8) -> u8 {
    if result == 0 { Z } else { 0 }
}

/// N and S of a result; `overflow` has V in bit 7.
#[inline]
const fn sign(result: u8, overflow: u8) -> u8 {
    (result & 0x80) >> 5 | ((result ^ overflow) & 0x80) >> 3
}

#[inline]
const fn borrow_flags(a: u8, b: u8, difference: u8) -> u8 {
    let borrows = (!a & b) | ((!a | b) & difference);
    let overflow = (a ^ b) & (a ^ difference);
    borrows >> 7 | (borrows & 0x08) << 2 | overflow >> 7 << 3 | sign(difference, overflow)
}

#[inline]
const fn word_flags(result: u16, overflow: u8) -> u8 {
    let zero = if result == 0 { Z } else { 0 };
    overflow >> 7 << 3 | zero | sign((result >> 8) as u8, overflow)
}
