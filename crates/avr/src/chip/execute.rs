//! The effect of each instruction, and its duration.
//!
//! Source: *AVR Instruction Set Manual*, columns AVRe of the cycles. A register that is read in a peripheral is read at the
//! beginning of the instruction's last cycle, one that is written is written at its end.

use super::{Chip, Pending};
use crate::alu;
use crate::board::{Board, Warning};
use crate::flash::Code;
use crate::instruction::Op;

/// Low register of the pointer Z.
const Z: u8 = 30;

impl Chip {
    /// Executes an instruction at the program counter.
    #[inline(always)]
    pub(super) fn execute<B: Board>(&mut self, op: Op, code: &Code, board: &mut B) {
        self.pc = (self.pc + 1) & self.pc_mask;
        let cycles = match op {
            Op::Nop => 1,
            Op::Add { d, r } => self.two(d, r, |sreg, a, b| alu::add(sreg, a, b, 0)),
            Op::Adc { d, r } => self.two(d, r, |sreg, a, b| alu::add(sreg, a, b, sreg & alu::C)),
            Op::Sub { d, r } => self.two(d, r, alu::sub),
            Op::Sbc { d, r } => self.two(d, r, alu::sbc),
            Op::And { d, r } => self.two(d, r, |sreg, a, b| (a & b, alu::logic(sreg, a & b))),
            Op::Or { d, r } => self.two(d, r, |sreg, a, b| (a | b, alu::logic(sreg, a | b))),
            Op::Eor { d, r } => self.two(d, r, |sreg, a, b| (a ^ b, alu::logic(sreg, a ^ b))),
            Op::Mov { d, r } => self.two(d, r, |sreg, _, b| (b, sreg)),
            Op::Cp { d, r } => self.two(d, r, |sreg, a, b| (a, alu::sub(sreg, a, b).1)),
            Op::Cpc { d, r } => self.two(d, r, |sreg, a, b| (a, alu::sbc(sreg, a, b).1)),
            Op::Cpse { d, r } => self.skip(self.register(d) == self.register(r), code),
            Op::Subi { d, k } => self.one(d, |sreg, a| alu::sub(sreg, a, k)),
            Op::Sbci { d, k } => self.one(d, |sreg, a| alu::sbc(sreg, a, k)),
            Op::Andi { d, k } => self.one(d, |sreg, a| (a & k, alu::logic(sreg, a & k))),
            Op::Ori { d, k } => self.one(d, |sreg, a| (a | k, alu::logic(sreg, a | k))),
            Op::Cpi { d, k } => self.one(d, |sreg, a| (a, alu::sub(sreg, a, k).1)),
            Op::Ldi { d, k } => self.one(d, |sreg, _| (k, sreg)),
            Op::Com { d } => self.one(d, alu::com),
            Op::Neg { d } => self.one(d, alu::neg),
            Op::Swap { d } => self.one(d, |sreg, a| (a.rotate_left(4), sreg)),
            Op::Inc { d } => self.one(d, alu::inc),
            Op::Dec { d } => self.one(d, alu::dec),
            Op::Asr { d } => self.one(d, |sreg, a| alu::shift_right(sreg, a, a & 0x80)),
            Op::Lsr { d } => self.one(d, |sreg, a| alu::shift_right(sreg, a, 0)),
            Op::Ror { d } => self.one(d, |sreg, a| alu::shift_right(sreg, a, sreg << 7)),
            Op::Adiw { d, k } => self.pair_with(d, |sreg, a| alu::adiw(sreg, a, k)),
            Op::Sbiw { d, k } => self.pair_with(d, |sreg, a| alu::sbiw(sreg, a, k)),
            Op::Movw { d, r } => {
                self.set_pair(d, self.pair(r));
                1
            }
            Op::Mul { d, r } => self.multiply(u16::from(self.register(d)) * u16::from(self.register(r))),
            Op::Muls { d, r } => self.multiply(signed_product(self.register(d), self.register(r))),
            Op::Mulsu { d, r } => self.multiply(mixed_product(self.register(d), self.register(r))),
            Op::Fmul { d, r } => {
                self.multiply_fraction(u16::from(self.register(d)) * u16::from(self.register(r)))
            }
            Op::Fmuls { d, r } => self.multiply_fraction(signed_product(self.register(d), self.register(r))),
            Op::Fmulsu { d, r } => self.multiply_fraction(mixed_product(self.register(d), self.register(r))),
            Op::Rjmp { offset } => {
                let behind = self.pc;
                self.jump_by(offset);
                if offset < 0 { 2 + self.jumped_back(behind, self.cycle + 2, board) } else { 2 }
            }
            Op::Rcall { offset } => {
                self.push_pc(self.pc, board);
                self.jump_by(offset);
                1 + u64::from(self.return_bytes)
            }
            Op::Jmp { high, low } => {
                let behind = self.pc;
                self.pc = far(high, low) & self.pc_mask;
                if self.pc < behind { 3 + self.jumped_back(behind, self.cycle + 3, board) } else { 3 }
            }
            Op::Call { high, low } => {
                self.push_pc(self.pc + 1, board);
                self.pc = far(high, low) & self.pc_mask;
                2 + u64::from(self.return_bytes)
            }
            Op::Ijmp => {
                self.pc = u32::from(self.pair(Z)) & self.pc_mask;
                2
            }
            Op::Icall => {
                self.push_pc(self.pc, board);
                self.pc = u32::from(self.pair(Z)) & self.pc_mask;
                1 + u64::from(self.return_bytes)
            }
            Op::Ret => self.return_from_call(board),
            Op::Reti => {
                self.set_sreg(self.sreg | alu::I);
                self.return_from_call(board)
            }
            Op::Brbs { mask, offset } => self.branch(self.sreg & mask != 0, offset, board),
            Op::Brbc { mask, offset } => self.branch(self.sreg & mask == 0, offset, board),
            Op::Sbrc { r, mask } => self.skip(self.register(r) & mask == 0, code),
            Op::Sbrs { r, mask } => self.skip(self.register(r) & mask != 0, code),
            Op::Sbic { address, mask } => {
                let set = self.read_bit(address, mask, board);
                self.skip(!set, code)
            }
            Op::Sbis { address, mask } => {
                let set = self.read_bit(address, mask, board);
                self.skip(set, code)
            }
            Op::Sbi { address, mask } => self.set_bit(address, mask, true, board),
            Op::Cbi { address, mask } => self.set_bit(address, mask, false, board),
            Op::In { d, address } => {
                let value = self.read_io(address, board);
                self.set_register(d, value);
                self.note_pins(address, d, code, board);
                1
            }
            Op::Out { address, r } => {
                self.cycle += 1;
                self.write_io(address, self.register(r), board);
                0
            }
            Op::Load { d, pointer, offset } => {
                self.load_into(d, self.pair(pointer).wrapping_add(u16::from(offset)), code, board)
            }
            Op::LoadIncrement { d, pointer } => {
                let address = self.pair(pointer);
                self.set_pair(pointer, address.wrapping_add(1));
                self.load_into(d, address, code, board)
            }
            Op::LoadDecrement { d, pointer } => {
                let address = self.pair(pointer).wrapping_sub(1);
                self.set_pair(pointer, address);
                self.load_into(d, address, code, board)
            }
            Op::Store { r, pointer, offset } => {
                self.store_from(r, self.pair(pointer).wrapping_add(u16::from(offset)), board)
            }
            Op::StoreIncrement { r, pointer } => {
                let address = self.pair(pointer);
                let cycles = self.store_from(r, address, board);
                self.set_pair(pointer, address.wrapping_add(1));
                cycles
            }
            Op::StoreDecrement { r, pointer } => {
                let address = self.pair(pointer).wrapping_sub(1);
                let cycles = self.store_from(r, address, board);
                self.set_pair(pointer, address);
                cycles
            }
            Op::Lds { d, address } => {
                self.pc = (self.pc + 1) & self.pc_mask;
                self.load_into(d, address, code, board)
            }
            Op::Sts { r, address } => {
                self.pc = (self.pc + 1) & self.pc_mask;
                self.store_from(r, address, board)
            }
            Op::Push { r } => {
                self.cycle += 2;
                self.push(self.register(r), board);
                0
            }
            Op::Pop { d } => {
                self.cycle += 1;
                let value = self.pop(board);
                self.set_register(d, value);
                1
            }
            Op::Lpm { d } => {
                self.load_program(d, self.pair(Z));
                3
            }
            Op::LpmIncrement { d } => {
                let address = self.pair(Z);
                self.set_pair(Z, address.wrapping_add(1));
                self.load_program(d, address);
                3
            }
            Op::Spm => {
                self.repeat.give_up();
                self.store_program()
            }
            Op::Bset { mask } => {
                self.set_sreg(self.sreg | mask);
                1
            }
            Op::Bclr { mask } => {
                self.set_sreg(self.sreg & !mask);
                1
            }
            Op::Bst { d, bit } => {
                let bit = self.register(d) >> (bit & 7) & 1;
                self.sreg = self.sreg & !alu::T | bit << 6;
                1
            }
            Op::Bld { d, bit } => {
                let mask = 1 << (bit & 7);
                let value = self.register(d) & !mask;
                self.set_register(d, if self.sreg & alu::T == 0 { value } else { value | mask });
                1
            }
            Op::Sleep => {
                self.repeat.give_up();
                self.go_to_sleep(board)
            }
            Op::Wdr => {
                self.repeat.give_up();
                self.restart_watchdog();
                1
            }
            Op::WaitJump { offset, cycles } => {
                let behind = self.pc;
                self.jump_by(offset.into());
                self.wait(behind, cycles, board)
            }
            Op::WaitBranch { flag, offset, cycles } => {
                if self.sreg >> (flag & 7) & 1 == flag >> 3 {
                    let behind = self.pc;
                    self.jump_by(offset.into());
                    self.wait(behind, cycles, board)
                } else {
                    1
                }
            }
            Op::CountTwo { low } => {
                if self.sreg & alu::Z == 0 {
                    self.jump_by(-2);
                    self.count_down([low, low + 1])
                } else {
                    1
                }
            }
            Op::CountThree { low, middle, high } => {
                if self.sreg & alu::Z == 0 {
                    self.jump_by(-4);
                    self.count_down([low, middle, high])
                } else {
                    1
                }
            }
            Op::Break => {
                self.pending = Pending::Break;
                self.limit = 0;
                1
            }
            Op::Illegal { word } => {
                self.repeat.give_up();
                let pc = self.pc.wrapping_sub(1) & self.pc_mask;
                self.warn_often(Warning::IllegalInstruction { pc, word }, board);
                1
            }
        };
        self.cycle += cycles;
    }

    #[inline(always)]
    pub(super) fn register(&self, register: u8) -> u8 {
        self.registers[usize::from(register & 31)]
    }

    #[inline(always)]
    pub(super) fn set_register(&mut self, register: u8, value: u8) {
        self.registers[usize::from(register & 31)] = value;
    }

    #[inline(always)]
    pub(super) fn pair(&self, low: u8) -> u16 {
        u16::from_le_bytes([self.register(low), self.register(low + 1)])
    }

    #[inline(always)]
    pub(super) fn set_pair(&mut self, low: u8, value: u16) {
        let [first, second] = value.to_le_bytes();
        self.set_register(low, first);
        self.set_register(low + 1, second);
    }

    #[inline(always)]
    fn one(&mut self, d: u8, function: impl FnOnce(u8, u8) -> (u8, u8)) -> u64 {
        let (value, sreg) = function(self.sreg, self.register(d));
        self.set_register(d, value);
        self.sreg = sreg;
        1
    }

    #[inline(always)]
    fn two(&mut self, d: u8, r: u8, function: impl FnOnce(u8, u8, u8) -> (u8, u8)) -> u64 {
        let b = self.register(r);
        self.one(d, |sreg, a| function(sreg, a, b))
    }

    #[inline(always)]
    fn pair_with(&mut self, d: u8, function: impl FnOnce(u8, u16) -> (u16, u8)) -> u64 {
        let (value, sreg) = function(self.sreg, self.pair(d));
        self.set_pair(d, value);
        self.sreg = sreg;
        2
    }

    #[inline(always)]
    fn multiply(&mut self, product: u16) -> u64 {
        let (value, sreg) = alu::product(self.sreg, product);
        self.set_pair(0, value);
        self.sreg = sreg;
        2
    }

    #[inline(always)]
    fn multiply_fraction(&mut self, product: u16) -> u64 {
        let (value, sreg) = alu::fractional_product(self.sreg, product);
        self.set_pair(0, value);
        self.sreg = sreg;
        2
    }

    #[inline(always)]
    fn jump_by(&mut self, offset: i16) {
        self.pc = self.pc.wrapping_add_signed(i32::from(offset)) & self.pc_mask;
    }

    #[inline(always)]
    fn branch<B: Board>(&mut self, taken: bool, offset: i8, board: &mut B) -> u64 {
        if taken {
            let behind = self.pc;
            self.jump_by(i16::from(offset));
            if offset < 0 { 2 + self.jumped_back(behind, self.cycle + 2, board) } else { 2 }
        } else {
            1
        }
    }

    #[inline(always)]
    fn skip(&mut self, taken: bool, code: &Code) -> u64 {
        if !taken {
            return 1;
        }
        let words = code.op(self.pc).words();
        self.pc = (self.pc + words) & self.pc_mask;
        1 + u64::from(words)
    }

    #[inline(always)]
    fn load_into<B: Board>(&mut self, d: u8, address: u16, code: &Code, board: &mut B) -> u64 {
        self.cycle += 1;
        match self.in_sram(address) {
            Some(byte) => self.set_register(d, byte),
            None => self.load_other_into(d, address, code, board),
        }
        1
    }

    #[inline(always)]
    fn store_from<B: Board>(&mut self, r: u8, address: u16, board: &mut B) -> u64 {
        self.cycle += 2;
        self.store(address, self.register(r), board);
        0
    }

    #[inline(always)]
    fn return_from_call<B: Board>(&mut self, board: &mut B) -> u64 {
        self.pc = self.pop_pc(board);
        2 + u64::from(self.return_bytes)
    }

    /// `SBI` and `CBI`. A flag that a one clears is written alone; other bits are written back.
    fn set_bit<B: Board>(&mut self, address: u8, mask: u8, set: bool, board: &mut B) -> u64 {
        self.cycle += 1;
        let alone = crate::address::Place::at(address).takes_ones();
        let old = if alone { 0 } else { self.read_io(address, board) };
        self.cycle += 1;
        self.write_io(address, if set { old | mask } else { old & !mask }, board);
        0
    }

    /// Interrupts that are enabled now wait for one more instruction.
    #[inline]
    pub(super) fn set_sreg(&mut self, sreg: u8) {
        if !self.sreg & sreg & alu::I != 0 {
            self.inhibited = true;
            self.limit = 0;
        }
        self.sreg = sreg;
    }
}

const fn far(high: u8, low: u16) -> u32 {
    (high as u32) << 16 | low as u32
}

const fn signed_product(a: u8, b: u8) -> u16 {
    (a.cast_signed() as i16 * b.cast_signed() as i16).cast_unsigned()
}

const fn mixed_product(a: u8, b: u8) -> u16 {
    (a.cast_signed() as i16).wrapping_mul(b as i16).cast_unsigned()
}
