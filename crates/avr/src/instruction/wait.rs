//! Loops that only wait or count down.
//!
//! A loop that reads a register or a variable, looks at it and jumps back to the beginning does the same again and
//! again, until an event or an interrupt changes what it reads. Its last instruction is decoded as one that waits, so
//! that its execution can pass over iterations. So is that of a loop that counts two or three registers down and does
//! nothing else, which is what delays are compiled to. Registers that change without an event, as counters do, are none
//! that such a loop may read.

use super::{Op, decode};

/// UCSR0A, ADCSRA, TWCR and SPSR: they change with events only.
const STATUS: [u16; 4] = [0xC0, 0x7A, 0xBC, 0x4D];
/// PINB, PINC and PIND.
const PINS: [u16; 3] = [0x23, 0x26, 0x29];
const EEPROM_CONTROL: u8 = 0x3F;
/// EEPE. The other bits of EECR change by themselves.
const EEPROM_WRITES: u8 = 1 << 1;
const SRAM_START: u16 = 0x100;

/// Words of the longest of these loops.
pub(crate) const LONGEST_LOOP: usize = 4;

/// The operation at a place in a program memory whose size is a power of two.
#[expect(clippy::wildcard_enum_match_arm, reason = "of all instructions only jumps end a loop")]
pub(crate) fn operation(words: &[u16], at: usize) -> Op {
    let word = |at: usize| words[at & (words.len() - 1)];
    let op = |at: usize| decode(word(at), word(at + 1));
    let last = op(at);
    let (offset, flag) = match last {
        Op::Rjmp { offset } => (offset, None),
        Op::Brbs { mask, offset } => (offset.into(), Some(mask.trailing_zeros() as u8 | 8)),
        Op::Brbc { mask, offset } => (offset.into(), Some(mask.trailing_zeros() as u8)),
        _ => return last,
    };
    if offset >= 0 || usize::from(offset.unsigned_abs()) > LONGEST_LOOP {
        return last;
    }
    // One that goes round the end of the memory is left alone.
    let Some(start) = at.checked_add_signed(1 + isize::from(offset)) else { return last };
    if flag == Some(ZERO)
        && let Some(count) = count_down(&op, start, at)
    {
        return count;
    }
    let Some(body) = body_cycles(&op, start, at) else { return last };
    let (offset, cycles) = (offset as i8, body + 2);
    match flag {
        None => Op::WaitJump { offset, cycles },
        Some(flag) => Op::WaitBranch { flag, offset, cycles },
    }
}

/// Z, for a branch that is taken if it is clear.
const ZERO: u8 = 1;

/// The branch of a loop that counts registers down by one.
fn count_down(op: &impl Fn(usize) -> Op, start: usize, end: usize) -> Option<Op> {
    if let Op::Sbiw { d, k: 1 } = op(start) {
        return (start + 1 == end).then_some(Op::CountTwo { low: d });
    }
    let Op::Subi { d: low, k: 1 } = op(start) else { return None };
    let (Op::Sbci { d: middle, k: 0 }, Op::Sbci { d: high, k: 0 }) = (op(start + 1), op(start + 2)) else {
        return None;
    };
    let differ = low != middle && middle != high && low != high;
    (differ && start + 3 == end).then_some(Op::CountThree { low, middle, high })
}

/// Cycles of what is between the start of a loop and its last instruction, if all that only waits.
#[expect(clippy::wildcard_enum_match_arm, reason = "of all instructions only a few read and look")]
fn body_cycles(op: &impl Fn(usize) -> Op, start: usize, end: usize) -> Option<u8> {
    if start == end {
        return Some(0);
    }
    let (loaded, at, cycles) = match op(start) {
        Op::Sbis { address, mask } | Op::Sbic { address, mask } => {
            let steady = PINS.contains(&address.into()) || (address, mask) == (EEPROM_CONTROL, EEPROM_WRITES);
            return (steady && start + 1 == end).then_some(1);
        }
        Op::In { d, address } if is_steady(address.into()) => (d, start + 1, 1),
        Op::Lds { d, address } if is_steady(address) => (d, start + 2, 2),
        _ => return None,
    };
    if at == end {
        return Some(cycles);
    }
    let looks = match op(at) {
        Op::And { d, r } => d == loaded && r == loaded,
        Op::Andi { d, .. } | Op::Cpi { d, .. } | Op::Sbrs { r: d, .. } | Op::Sbrc { r: d, .. } => d == loaded,
        _ => false,
    };
    (looks && at + 1 == end).then_some(cycles + 1)
}

fn is_steady(address: u16) -> bool {
    address >= SRAM_START || STATUS.contains(&address) || PINS.contains(&address)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last(words: &[u16]) -> Op {
        let mut memory = [0; 8];
        memory[..words.len()].copy_from_slice(words);
        operation(&memory, words.len() - 1)
    }

    #[test]
    fn loops_that_wait_for_a_bit_are_recognised_with_their_cycles() {
        // rjmp .-2
        assert_eq!(last(&[0xCFFF]), Op::WaitJump { offset: -1, cycles: 2 });
        // sbis PINB, 0; rjmp .-4
        assert_eq!(last(&[0x9B18, 0xCFFE]), Op::WaitJump { offset: -2, cycles: 3 });
        // lds r24, UCSR0A; sbrs r24, 5; rjmp .-8
        assert_eq!(last(&[0x9180, 0x00C0, 0xFF85, 0xCFFC]), Op::WaitJump { offset: -4, cycles: 5 });
        // lds r24, 0x0100; and r24, r24; breq .-8
        assert_eq!(
            last(&[0x9180, 0x0100, 0x2388, 0xF3E1]),
            Op::WaitBranch { flag: 9, offset: -4, cycles: 5 }
        );
    }

    #[test]
    fn loops_that_count_down_are_recognised_with_their_registers() {
        // sbiw r24, 1; brne .-4
        assert_eq!(last(&[0x9701, 0xF7F1]), Op::CountTwo { low: 24 });
        // subi r18, 1; sbci r24, 0; sbci r25, 0; brne .-8
        assert_eq!(last(&[0x5021, 0x4080, 0x4090, 0xF7E1]), Op::CountThree { low: 18, middle: 24, high: 25 });
        for other in [
            // sbiw r24, 2; sbiw r24, 1 and breq; three registers, one of them twice
            &[0x9702, 0xF7F1][..],
            &[0x9701, 0xF3F1],
            &[0x5021, 0x4080, 0x4080, 0xF7E1],
            // subi r18, 1; brne .-4
            &[0x5021, 0xF7F1],
        ] {
            assert!(matches!(last(other), Op::Brbs { .. } | Op::Brbc { .. }), "{other:?}");
        }
    }

    #[test]
    fn loops_that_read_what_changes_by_itself_or_do_more_are_not() {
        // lds r24, TCNT1L; sbrs r24, 5; rjmp .-8
        assert_eq!(last(&[0x9180, 0x0084, 0xFF85, 0xCFFC]), Op::Rjmp { offset: -4 });
        // sbis TIFR1, 0; rjmp .-4
        assert_eq!(last(&[0x9BB0, 0xCFFE]), Op::Rjmp { offset: -2 });
        // dec r24; brne .-4
        assert_eq!(last(&[0x958A, 0xF7F1]), Op::Brbc { mask: 2, offset: -2 });
        // lds r24, UCSR0A; sbrs r25, 5; rjmp .-8
        assert_eq!(last(&[0x9180, 0x00C0, 0xFF95, 0xCFFC]), Op::Rjmp { offset: -4 });
    }
}
