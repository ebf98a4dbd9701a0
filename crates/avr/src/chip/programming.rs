//! `LPM` and `SPM`.

use super::Chip;
use crate::clock::periods;
use crate::spm::{Action, PAGE_MICROSECONDS, Reading};

/// OSCCAL of the signature row.
const CALIBRATION: u8 = 0x80;

impl Chip {
    /// Reads a byte of program memory into a register.
    #[inline(always)]
    pub(super) fn load_program(&mut self, d: u8, address: u16) {
        let value = match self.programming.reading(self.cycle) {
            Reading::Flash if self.programming.is_section_busy() && !self.is_boot(address >> 1) => 0xFF,
            Reading::Flash => self.flash.byte(address.into()),
            Reading::Signature => self.signature(address),
            Reading::Fuses => match address & 3 {
                0 => self.fuses.low,
                1 => self.programming.lock_bits,
                2 => self.fuses.extended,
                _ => self.fuses.high,
            },
        };
        self.set_register(d, value);
    }

    /// `SPM`.
    pub(super) fn store_program(&mut self) -> u64 {
        let from = self.pc.wrapping_sub(1) & self.pc_mask;
        let address = self.pair(30);
        let page = u32::from(self.part.properties().page_words);
        let allowed = self.part.properties().boot_words.is_none() || from >= self.fuses.boot_start(self.part);
        if !allowed {
            return 1;
        }
        match self.programming.action(self.cycle) {
            Action::Nothing => {}
            Action::Fill => {
                let word = self.pair(0);
                self.programming.fill(u32::from(address >> 1), word);
            }
            Action::Erase => {
                let start = u32::from(address >> 1) & !(page - 1);
                self.flash.write(start, |_, _| 0xFFFF, page as usize);
                self.wait_for_page(address >> 1);
            }
            Action::Write => {
                let start = u32::from(address >> 1) & !(page - 1);
                let flash = &mut self.flash;
                self.programming.take_buffer(|words| {
                    flash.write(start, |at, old| old & words[at], words.len());
                });
                self.wait_for_page(address >> 1);
            }
            Action::SetLockBits => self.programming.lock_bits &= self.register(0) | 0xC0,
            Action::EnableReading => self.programming.enable_reading(),
        }
        self.schedule();
        self.attend();
        1
    }

    /// A page is erased or written: outside the boot section beside the processor, else instead of it.
    fn wait_for_page(&mut self, word_address: u16) {
        let until = self.now() + periods(self.supply.clock_hz, PAGE_MICROSECONDS);
        let beside = self.part.properties().boot_words.is_some() && !self.is_boot(word_address);
        self.programming.begin(until, beside);
        if !beside {
            self.cycle = self.clock.cycle_from(until);
        }
    }

    fn is_boot(&self, word_address: u16) -> bool {
        u32::from(word_address) & self.pc_mask >= self.fuses.boot_start(self.part)
    }

    fn signature(&self, address: u16) -> u8 {
        let [first, second, third] = self.part.properties().signature;
        match address & 7 {
            0 => first,
            2 => second,
            4 => third,
            1 => CALIBRATION,
            _ => 0xFF,
        }
    }
}
