//! The way from words of program memory to instructions.

use super::Op;

/// Low registers of the pointers.
const X: u8 = 26;
const Y: u8 = 28;
const Z: u8 = 30;

/// The instruction that begins with `word`; `next` is the word behind it.
pub const fn decode(word: u16, next: u16) -> Op {
    match word >> 12 {
        0x0..=0x2 => two_registers(word),
        0x3 => Op::Cpi { d: upper(word), k: constant(word) },
        0x4 => Op::Sbci { d: upper(word), k: constant(word) },
        0x5 => Op::Subi { d: upper(word), k: constant(word) },
        0x6 => Op::Ori { d: upper(word), k: constant(word) },
        0x7 => Op::Andi { d: upper(word), k: constant(word) },
        0x8 | 0xA => displaced(word),
        0x9 => nine(word, next),
        0xB => in_out(word),
        0xC => Op::Rjmp { offset: ((word << 4) as i16) >> 4 },
        0xD => Op::Rcall { offset: ((word << 4) as i16) >> 4 },
        0xE => Op::Ldi { d: upper(word), k: constant(word) },
        _ => branch_or_bit(word),
    }
}

/// Rd of most instructions.
const fn d(word: u16) -> u8 {
    (word >> 4 & 0x1F) as u8
}

/// Rr of most instructions.
const fn r(word: u16) -> u8 {
    ((word >> 5 & 0x10) | (word & 0x0F)) as u8
}

/// Rd of instructions with a constant: 16 to 31.
const fn upper(word: u16) -> u8 {
    0x10 | (word >> 4 & 0x0F) as u8
}

const fn constant(word: u16) -> u8 {
    ((word >> 4 & 0xF0) | (word & 0x0F)) as u8
}

const fn mask(word: u16) -> u8 {
    1 << (word & 7)
}

const fn two_registers(word: u16) -> Op {
    let (d, r) = (d(word), r(word));
    match word >> 10 {
        0x00 => small(word),
        0x01 => Op::Cpc { d, r },
        0x02 => Op::Sbc { d, r },
        0x03 => Op::Add { d, r },
        0x04 => Op::Cpse { d, r },
        0x05 => Op::Cp { d, r },
        0x06 => Op::Sub { d, r },
        0x07 => Op::Adc { d, r },
        0x08 => Op::And { d, r },
        0x09 => Op::Eor { d, r },
        0x0A => Op::Or { d, r },
        _ => Op::Mov { d, r },
    }
}

/// Words from 0x0000 to 0x03FF.
const fn small(word: u16) -> Op {
    let (d, r) = (0x10 | (word >> 4 & 7) as u8, 0x10 | (word & 7) as u8);
    match word >> 8 {
        0 if word == 0 => Op::Nop,
        0 => Op::Illegal { word },
        1 => Op::Movw { d: (word >> 3 & 0x1E) as u8, r: (word << 1 & 0x1E) as u8 },
        2 => Op::Muls { d: upper(word), r: 0x10 | (word & 0x0F) as u8 },
        _ => match word & 0x88 {
            0x00 => Op::Mulsu { d, r },
            0x08 => Op::Fmul { d, r },
            0x80 => Op::Fmuls { d, r },
            _ => Op::Fmulsu { d, r },
        },
    }
}

/// `LDD` and `STD`.
const fn displaced(word: u16) -> Op {
    let pointer = if word & 0x08 == 0 { Z } else { Y };
    let offset = ((word >> 8 & 0x20) | (word >> 7 & 0x18) | (word & 7)) as u8;
    if word & 0x0200 == 0 {
        Op::Load { d: d(word), pointer, offset }
    } else {
        Op::Store { r: d(word), pointer, offset }
    }
}

const fn in_out(word: u16) -> Op {
    let address = 0x20 + ((word >> 5 & 0x30) | (word & 0x0F)) as u8;
    if word & 0x0800 == 0 { Op::In { d: d(word), address } } else { Op::Out { address, r: d(word) } }
}

const fn nine(word: u16, next: u16) -> Op {
    let pair = 24 + (word >> 3 & 6) as u8;
    let six = ((word >> 2 & 0x30) | (word & 0x0F)) as u8;
    let address = 0x20 + (word >> 3 & 0x1F) as u8;
    match word >> 8 & 0x0F {
        0x0 | 0x1 => load(word, next),
        0x2 | 0x3 => store(word, next),
        0x4 | 0x5 => one_register(word, next),
        0x6 => Op::Adiw { d: pair, k: six },
        0x7 => Op::Sbiw { d: pair, k: six },
        0x8 => Op::Cbi { address, mask: mask(word) },
        0x9 => Op::Sbic { address, mask: mask(word) },
        0xA => Op::Sbi { address, mask: mask(word) },
        0xB => Op::Sbis { address, mask: mask(word) },
        _ => Op::Mul { d: d(word), r: r(word) },
    }
}

const fn load(word: u16, next: u16) -> Op {
    let d = d(word);
    match word & 0x0F {
        0x0 => Op::Lds { d, address: next },
        0x1 => Op::LoadIncrement { d, pointer: Z },
        0x2 => Op::LoadDecrement { d, pointer: Z },
        0x4 => Op::Lpm { d },
        0x5 => Op::LpmIncrement { d },
        0x9 => Op::LoadIncrement { d, pointer: Y },
        0xA => Op::LoadDecrement { d, pointer: Y },
        0xC => Op::Load { d, pointer: X, offset: 0 },
        0xD => Op::LoadIncrement { d, pointer: X },
        0xE => Op::LoadDecrement { d, pointer: X },
        0xF => Op::Pop { d },
        _ => Op::Illegal { word },
    }
}

const fn store(word: u16, next: u16) -> Op {
    let r = d(word);
    match word & 0x0F {
        0x0 => Op::Sts { r, address: next },
        0x1 => Op::StoreIncrement { r, pointer: Z },
        0x2 => Op::StoreDecrement { r, pointer: Z },
        0x9 => Op::StoreIncrement { r, pointer: Y },
        0xA => Op::StoreDecrement { r, pointer: Y },
        0xC => Op::Store { r, pointer: X, offset: 0 },
        0xD => Op::StoreIncrement { r, pointer: X },
        0xE => Op::StoreDecrement { r, pointer: X },
        0xF => Op::Push { r },
        _ => Op::Illegal { word },
    }
}

/// Words from 0x9400 to 0x95FF.
const fn one_register(word: u16, next: u16) -> Op {
    let d = d(word);
    let high = ((word >> 3 & 0x3E) | (word & 1)) as u8;
    match word & 0x0F {
        0x0 => Op::Com { d },
        0x1 => Op::Neg { d },
        0x2 => Op::Swap { d },
        0x3 => Op::Inc { d },
        0x5 => Op::Asr { d },
        0x6 => Op::Lsr { d },
        0x7 => Op::Ror { d },
        0x8 => no_register(word),
        0x9 => match word {
            0x9409 => Op::Ijmp,
            0x9509 => Op::Icall,
            _ => Op::Illegal { word },
        },
        0xA => Op::Dec { d },
        0xC | 0xD => Op::Jmp { high, low: next },
        0xE | 0xF => Op::Call { high, low: next },
        _ => Op::Illegal { word },
    }
}

const fn no_register(word: u16) -> Op {
    let mask = 1 << (word >> 4 & 7);
    match word {
        0x9408..=0x947F => Op::Bset { mask },
        0x9480..=0x94FF => Op::Bclr { mask },
        0x9508 => Op::Ret,
        0x9518 => Op::Reti,
        0x9588 => Op::Sleep,
        0x9598 => Op::Break,
        0x95A8 => Op::Wdr,
        0x95C8 => Op::Lpm { d: 0 },
        0x95E8 => Op::Spm,
        _ => Op::Illegal { word },
    }
}

/// Words from 0xF000 on.
const fn branch_or_bit(word: u16) -> Op {
    let offset = ((word >> 2) as i8) >> 1;
    let bit = (word & 7) as u8;
    match word >> 9 & 7 {
        0 | 1 => Op::Brbs { mask: mask(word), offset },
        2 | 3 => Op::Brbc { mask: mask(word), offset },
        _ if word & 0x08 != 0 => Op::Illegal { word },
        4 => Op::Bld { d: d(word), bit },
        5 => Op::Bst { d: d(word), bit },
        6 => Op::Sbrc { r: d(word), mask: mask(word) },
        _ => Op::Sbrs { r: d(word), mask: mask(word) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_each_group_are_decoded_as_the_manual_writes_them() {
        let cases = [
            (0x0000, Op::Nop),
            (0x0FFF, Op::Add { d: 31, r: 31 }),
            (0x2E1F, Op::Mov { d: 1, r: 31 }),
            (0x01FE, Op::Movw { d: 30, r: 28 }),
            (0x02F1, Op::Muls { d: 31, r: 17 }),
            (0x0378, Op::Fmul { d: 23, r: 16 }),
            (0xE5A0, Op::Ldi { d: 26, k: 0x50 }),
            (0x9631, Op::Adiw { d: 30, k: 1 }),
            (0x97FF, Op::Sbiw { d: 30, k: 63 }),
            (0xCFFF, Op::Rjmp { offset: -1 }),
            (0xC7FF, Op::Rjmp { offset: 0x7FF }),
            (0x940C, Op::Jmp { high: 0, low: 0x1234 }),
            (0x95FF, Op::Call { high: 0x3F, low: 0x1234 }),
            (0xF7F1, Op::Brbc { mask: 2, offset: -2 }),
            (0xF1F8, Op::Brbs { mask: 1, offset: 63 }),
            (0xB9AF, Op::Out { address: 0x2F, r: 26 }),
            (0xB7FF, Op::In { d: 31, address: 0x5F }),
            (0x9A2D, Op::Sbi { address: 0x25, mask: 0x20 }),
            (0x9000, Op::Lds { d: 0, address: 0x1234 }),
            (0xAD8F, Op::Load { d: 24, pointer: Y, offset: 0x3F }),
            (0x8200, Op::Store { r: 0, pointer: Z, offset: 0 }),
            (0x94F8, Op::Bclr { mask: 0x80 }),
            (0x9478, Op::Bset { mask: 0x80 }),
            (0xFF87, Op::Sbrs { r: 24, mask: 0x80 }),
            (0xFFFF, Op::Illegal { word: 0xFFFF }),
            (0x9004, Op::Lpm { d: 0 }),
            (0x95C8, Op::Lpm { d: 0 }),
            (0x95F8, Op::Illegal { word: 0x95F8 }),
        ];
        for (word, op) in cases {
            assert_eq!(decode(word, 0x1234), op, "{word:#06x}");
        }
    }

    #[test]
    fn an_operation_is_as_small_as_its_instruction() {
        assert_eq!(size_of::<Op>(), 4);
    }
}
