//! What an instruction does in all of the coming iterations of a loop. Those not listed end the attempt.

use super::Chip;
use super::counting::Iterations;
use super::lanes::Uses;
use crate::alu::{self, C, H, N, S, T, V, Z};
use crate::instruction::Op;
use crate::spm::Reading;

const NONE: Uses = Uses { reads: 0, writes: 0 };
const SUM: Uses = Uses { reads: 0, writes: H | S | V | N | Z | C };
const SUM_WITH_CARRY: Uses = Uses { reads: C, ..SUM };
const DIFFERENCE_WITH_CARRY: Uses = Uses { reads: C | Z, ..SUM };
const LOGIC: Uses = Uses { reads: 0, writes: S | V | N | Z };
const SHIFT: Uses = Uses { reads: 0, writes: S | V | N | Z | C };
const ROTATION: Uses = Uses { reads: C, ..SHIFT };
const PRODUCT: Uses = Uses { reads: 0, writes: Z | C };
const BIT_COPY: Uses = Uses { reads: 0, writes: T };
const BIT_LOAD: Uses = Uses { reads: T, writes: 0 };
const POINTER_Z: u8 = 30;
const SREG: u8 = 0x5F;

type Answer = Option<u64>;

impl Iterations {
    /// Executes an instruction.
    pub(super) fn step(&mut self, chip: &Chip) -> Option<()> {
        let op = chip.flash.op(self.pc);
        self.pc = (self.pc + 1) & chip.pc_mask;
        let cycles = self
            .with_register(op)
            .or_else(|| self.with_constant(op))
            .or_else(|| self.alone(op))
            .or_else(|| self.jump(chip, op))
            .or_else(|| self.call(chip, op))
            .or_else(|| self.move_data(chip, op))?;
        self.elapsed += cycles;
        Some(())
    }

    /// Results of a byte, in the register `d`.
    fn two(&mut self, d: u8, r: u8, uses: Uses, function: impl Fn(u8, u8, u8) -> (u8, u8)) -> Answer {
        let value = self.register(r).clone();
        self.operation.b.copy(&value);
        self.one(d, uses, function)
    }

    fn immediate(&mut self, d: u8, k: u8, uses: Uses, function: impl Fn(u8, u8, u8) -> (u8, u8)) -> Answer {
        self.operation.b.set(k);
        self.one(d, uses, function)
    }

    fn one(&mut self, d: u8, uses: Uses, function: impl Fn(u8, u8, u8) -> (u8, u8)) -> Answer {
        self.compare(d, uses, function);
        self.keep(d);
        Some(1)
    }

    fn compare(&mut self, d: u8, uses: Uses, function: impl Fn(u8, u8, u8) -> (u8, u8)) {
        self.operand(d);
        self.apply(uses, |sreg, a, b| {
            let (value, sreg) = function(sreg, a, b);
            (value.into(), sreg)
        });
    }

    fn operand(&mut self, d: u8) {
        let value = self.register(d).clone();
        self.operation.a.copy(&value);
    }

    fn apply(&mut self, uses: Uses, function: impl Fn(u8, u8, u8) -> (u16, u8)) {
        self.flags_found |= uses.reads & !self.flags_written;
        self.flags_written |= uses.writes;
        self.operation.apply(self.count, uses, function);
    }

    /// The result is that of the register.
    fn keep(&mut self, d: u8) {
        let low = self.operation.low.clone();
        self.written(d).copy(&low);
    }

    fn keep_pair(&mut self, d: u8) {
        self.keep(d);
        let high = self.operation.high.clone();
        self.written(d + 1).copy(&high);
    }

    fn copy(&mut self, d: u8, r: u8) {
        let value = self.register(r).clone();
        self.written(d).copy(&value);
    }

    fn pair(&mut self, d: u8, uses: Uses, function: impl Fn(u8, u16) -> (u16, u8)) -> Answer {
        let value = self.register(d + 1).clone();
        self.operation.b.copy(&value);
        self.operand(d);
        self.apply(uses, |sreg, a, b| function(sreg, u16::from_le_bytes([a, b])));
        self.keep_pair(d);
        Some(2)
    }

    fn with_register(&mut self, op: Op) -> Answer {
        match op {
            Op::Add { d, r } => self.two(d, r, SUM, |sreg, a, b| alu::add(sreg, a, b, 0)),
            Op::Adc { d, r } => self.two(d, r, SUM_WITH_CARRY, |sreg, a, b| alu::add(sreg, a, b, sreg & C)),
            Op::Sub { d, r } => self.two(d, r, SUM, alu::sub),
            Op::Sbc { d, r } => self.two(d, r, DIFFERENCE_WITH_CARRY, alu::sbc),
            Op::And { d, r } => self.two(d, r, LOGIC, |sreg, a, b| (a & b, alu::logic(sreg, a & b))),
            Op::Or { d, r } => self.two(d, r, LOGIC, |sreg, a, b| (a | b, alu::logic(sreg, a | b))),
            Op::Eor { d, r } if d == r => {
                // Zero, whatever was there.
                self.written(d).set(0);
                self.one(d, LOGIC, |sreg, _, _| (0, alu::logic(sreg, 0)))
            }
            Op::Eor { d, r } => self.two(d, r, LOGIC, |sreg, a, b| (a ^ b, alu::logic(sreg, a ^ b))),
            Op::Mov { d, r } => {
                self.copy(d, r);
                Some(1)
            }
            Op::Movw { d, r } => {
                self.copy(d, r);
                self.copy(d + 1, r + 1);
                Some(1)
            }
            Op::Cp { d, r } => self.two_compared(d, r, SUM, alu::sub),
            Op::Cpc { d, r } => self.two_compared(d, r, DIFFERENCE_WITH_CARRY, alu::sbc),
            Op::Mul { d, r } => {
                let value = self.register(r).clone();
                self.operation.b.copy(&value);
                self.operand(d);
                self.apply(PRODUCT, |sreg, a, b| alu::product(sreg, u16::from(a) * u16::from(b)));
                self.keep_pair(0);
                Some(2)
            }
            _ => None,
        }
    }

    fn two_compared(&mut self, d: u8, r: u8, uses: Uses, function: fn(u8, u8, u8) -> (u8, u8)) -> Answer {
        let value = self.register(r).clone();
        self.operation.b.copy(&value);
        self.compare(d, uses, function);
        Some(1)
    }

    fn with_constant(&mut self, op: Op) -> Answer {
        match op {
            Op::Nop => Some(1),
            Op::Subi { d, k } => self.immediate(d, k, SUM, alu::sub),
            Op::Sbci { d, k } => self.immediate(d, k, DIFFERENCE_WITH_CARRY, alu::sbc),
            Op::Andi { d, k } => self.immediate(d, k, LOGIC, |sreg, a, b| (a & b, alu::logic(sreg, a & b))),
            Op::Ori { d, k } => self.immediate(d, k, LOGIC, |sreg, a, b| (a | b, alu::logic(sreg, a | b))),
            Op::Cpi { d, k } => {
                self.operation.b.set(k);
                self.compare(d, SUM, alu::sub);
                Some(1)
            }
            Op::Ldi { d, k } => {
                self.written(d).set(k);
                Some(1)
            }
            Op::Adiw { d, k } => self.pair(d, SHIFT, |sreg, a| alu::adiw(sreg, a, k)),
            Op::Sbiw { d, k } => self.pair(d, SHIFT, |sreg, a| alu::sbiw(sreg, a, k)),
            Op::Bset { mask } => self.set_flags(mask, mask),
            Op::Bclr { mask } => self.set_flags(mask, 0),
            _ => None,
        }
    }

    fn set_flags(&mut self, writes: u8, value: u8) -> Answer {
        self.operation.a.set(0);
        self.operation.b.set(0);
        self.apply(Uses { reads: 0, writes }, |sreg, _, _| (0, sreg & !writes | value));
        Some(1)
    }

    fn alone(&mut self, op: Op) -> Answer {
        self.operation.b.set(0);
        match op {
            Op::Com { d } => self.one(d, SHIFT, |sreg, a, _| alu::com(sreg, a)),
            Op::Neg { d } => self.one(d, SUM, |sreg, a, _| alu::neg(sreg, a)),
            Op::Swap { d } => self.one(d, NONE, |sreg, a, _| (a.rotate_left(4), sreg)),
            Op::Inc { d } => self.one(d, LOGIC, |sreg, a, _| alu::inc(sreg, a)),
            Op::Dec { d } => self.one(d, LOGIC, |sreg, a, _| alu::dec(sreg, a)),
            Op::Asr { d } => self.one(d, SHIFT, |sreg, a, _| alu::shift_right(sreg, a, a & 0x80)),
            Op::Lsr { d } => self.one(d, SHIFT, |sreg, a, _| alu::shift_right(sreg, a, 0)),
            Op::Ror { d } => self.one(d, ROTATION, |sreg, a, _| alu::shift_right(sreg, a, sreg << 7)),
            Op::Bst { d, bit } => {
                self.one(d, BIT_COPY, |sreg, a, _| (a, sreg & !T | (a >> (bit & 7) & 1) << 6))
            }
            Op::Bld { d, bit } => self.one(d, BIT_LOAD, |sreg, a, _| {
                let mask = 1 << (bit & 7);
                (if sreg & T == 0 { a & !mask } else { a | mask }, sreg)
            }),
            _ => None,
        }
    }

    fn go(&mut self, chip: &Chip, taken: bool, offset: i16) -> Answer {
        if !taken {
            return Some(1);
        }
        self.pc = self.pc.wrapping_add_signed(i32::from(offset)) & chip.pc_mask;
        Some(2)
    }

    fn skip(&mut self, chip: &Chip, taken: bool) -> Answer {
        let words = if taken { chip.flash.op(self.pc).words() } else { 0 };
        self.pc = (self.pc + words) & chip.pc_mask;
        Some(1 + u64::from(words))
    }

    fn jump(&mut self, chip: &Chip, op: Op) -> Answer {
        match op {
            Op::Rjmp { offset } => self.go(chip, true, offset),
            Op::WaitJump { offset, .. } => self.go(chip, true, offset.into()),
            Op::Jmp { high, low } => {
                self.pc = super::execute::far(high, low) & chip.pc_mask;
                Some(3)
            }
            Op::Brbs { mask, offset } => {
                let set = self.only_flag(mask);
                self.go(chip, set, offset.into())
            }
            Op::Brbc { mask, offset } => {
                let set = self.only_flag(mask);
                self.go(chip, !set, offset.into())
            }
            Op::WaitBranch { flag, offset, .. } => {
                let set = self.only_flag(1 << (flag & 7));
                self.go(chip, set == (flag >> 3 == 1), offset.into())
            }
            Op::Sbrc { r, mask } => {
                let set = self.only_bit(r, mask);
                self.skip(chip, !set)
            }
            Op::Sbrs { r, mask } => {
                let set = self.only_bit(r, mask);
                self.skip(chip, set)
            }
            Op::Sbic { address, mask } => {
                let set = self.only_io_bit(chip, address, mask)?;
                self.skip(chip, !set)
            }
            Op::Sbis { address, mask } => {
                let set = self.only_io_bit(chip, address, mask)?;
                self.skip(chip, set)
            }
            _ => None,
        }
    }

    fn call(&mut self, chip: &Chip, op: Op) -> Answer {
        match op {
            Op::Rcall { offset } => {
                self.push_pc(chip, self.pc)?;
                self.go(chip, true, offset)?;
                Some(1 + u64::from(chip.return_bytes))
            }
            Op::Call { high, low } => {
                self.push_pc(chip, self.pc + 1)?;
                self.pc = super::execute::far(high, low) & chip.pc_mask;
                Some(2 + u64::from(chip.return_bytes))
            }
            Op::Ret => {
                let mut bytes = [0; 4];
                for byte in bytes.iter_mut().take(chip.return_bytes.into()).rev() {
                    chip.in_sram(self.sp.wrapping_add(1))?;
                    self.pop(chip)?;
                    *byte = self.only_result(0xFF);
                }
                self.pc = u32::from_le_bytes(bytes) & chip.pc_mask;
                Some(2 + u64::from(chip.return_bytes))
            }
            _ => None,
        }
    }

    fn push_pc(&mut self, chip: &Chip, pc: u32) -> Option<()> {
        for byte in (pc & chip.pc_mask).to_le_bytes().into_iter().take(chip.return_bytes.into()) {
            self.operation.low.set(byte);
            self.push(chip)?;
        }
        Some(())
    }

    fn move_data(&mut self, chip: &Chip, op: Op) -> Answer {
        match op {
            Op::In { d, address: SREG } => {
                self.flags_found |= !self.flags_written;
                let sreg = self.operation.sreg.clone();
                self.written(d).copy(&sreg);
                return Some(1);
            }
            Op::Out { address: SREG, r } => {
                let value = self.register(r).clone();
                self.operation.sreg.copy(&value);
                self.flags_written = 0xFF;
                return Some(1);
            }
            Op::In { d, address } => {
                self.load(chip, address.into(), 0)?;
                self.keep(d);
                return Some(1);
            }
            Op::Lds { d, address } => {
                self.pc = (self.pc + 1) & chip.pc_mask;
                self.load(chip, address, 1)?;
                self.keep(d);
            }
            Op::Sts { r, address } => {
                self.pc = (self.pc + 1) & chip.pc_mask;
                self.give(r);
                self.store(chip, address)?;
            }
            Op::Load { d, pointer, offset } => {
                let address = self.only_pair(pointer).wrapping_add(offset.into());
                self.load(chip, address, 1)?;
                self.keep(d);
            }
            Op::Store { r, pointer, offset } => {
                let address = self.only_pair(pointer).wrapping_add(offset.into());
                self.give(r);
                self.store(chip, address)?;
            }
            Op::Push { r } => {
                self.give(r);
                self.push(chip)?;
            }
            Op::Pop { d } => {
                self.pop(chip)?;
                self.keep(d);
            }
            _ => return self.load_program(chip, op),
        }
        Some(2)
    }

    fn load_program(&mut self, chip: &Chip, op: Op) -> Answer {
        let (d, step) = match op {
            Op::Lpm { d } => (d, 0),
            Op::LpmIncrement { d } => (d, 1),
            _ => return None,
        };
        if chip.programming.is_section_busy() || chip.programming.reading(chip.cycle) != Reading::Flash {
            return None;
        }
        let address = self.only_pair(POINTER_Z);
        let [low, high] = address.wrapping_add(step).to_le_bytes();
        self.written(POINTER_Z).set(low);
        self.written(POINTER_Z + 1).set(high);
        self.written(d).set(chip.flash.byte(address.into()));
        Some(3)
    }

    fn give(&mut self, r: u8) {
        let value = self.register(r).clone();
        self.operation.low.copy(&value);
    }

    fn only_pair(&mut self, low: u8) -> u16 {
        u16::from_le_bytes([self.only(low, 0xFF), self.only(low + 1, 0xFF)])
    }

    fn only_bit(&mut self, r: u8, mask: u8) -> bool {
        self.only(r, mask) & mask != 0
    }

    fn only_io_bit(&mut self, chip: &Chip, address: u8, mask: u8) -> Option<bool> {
        self.load(chip, address.into(), 0)?;
        if chip.floats(address, mask) {
            return None;
        }
        Some(self.only_result(mask) & mask != 0)
    }
}
