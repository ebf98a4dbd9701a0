//! Self-programming: SPMCSR, and the buffer for a page.
//!
//! `SPM` must follow the write to SPMCSR within four cycles. Erasing and writing a page take 4 ms; of the data sheet's 3.7 to
//! 4.5 ms. While a page below the boot section is worked on, the boot section runs on, and the rest cannot be read until
//! RWWSRE; while a page of the boot section is, the processor stands.
//!
//! Source: data sheet, chapter *Boot Loader Support – Read-While-Write Self-Programming*, *Self-Programming the Flash,
//! ATmega48A/48PA*.

use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::clock::Window;

pub(crate) const PAGE_MICROSECONDS: u64 = 4000;

const ENABLE: u8 = 1 << 0;
const ERASE: u8 = 1 << 1;
const WRITE: u8 = 1 << 2;
const LOCK_BITS: u8 = 1 << 3;
const READ_WHILE_WRITE_ENABLE: u8 = 1 << 4;
const SIGNATURE: u8 = 1 << 5;
const BUSY_SECTION: u8 = 1 << 6;
const INTERRUPT: u8 = 1 << 7;

/// The effect of an `SPM`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Nothing,
    Fill,
    Erase,
    Write,
    SetLockBits,
    EnableReading,
}

/// The source of the byte that an `LPM` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    Flash,
    Signature,
    Fuses,
}

/// The register and the buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SelfProgramming {
    control: u8,
    window: Window,
    buffer: Vec<u16>,
    /// The instant at which the erase or write is over, in periods of the clock source.
    busy_until: Option<u64>,
    section_busy: bool,
    pub(crate) lock_bits: u8,
}

impl SelfProgramming {
    pub(crate) fn new(page_words: u16) -> Self {
        Self {
            control: 0,
            window: Window::default(),
            buffer: vec![0xFFFF; usize::from(page_words)],
            busy_until: None,
            section_busy: false,
            lock_bits: 0xFF,
        }
    }

    /// Whether the buffer is for pages of so many words.
    pub(crate) fn fits(&self, page_words: u16) -> bool {
        self.buffer.len() == usize::from(page_words)
    }

    pub(crate) fn reset(&mut self) {
        self.control = 0;
        self.window = Window::default();
        self.buffer.fill(0xFFFF);
        self.section_busy = false;
    }

    pub(crate) const fn requests(&self) -> bool {
        self.control & (INTERRUPT | ENABLE) == INTERRUPT
    }

    pub(crate) fn next_event(&self) -> u64 {
        self.busy_until.unwrap_or(u64::MAX)
    }

    pub(crate) fn event(&mut self, period: u64) {
        if self.busy_until.is_some_and(|until| until <= period) {
            self.busy_until = None;
            self.control &= INTERRUPT;
        }
    }

    /// Whether the section below the boot section cannot be read.
    pub(crate) const fn is_section_busy(&self) -> bool {
        self.section_busy
    }

    pub(crate) fn read(&self, now: u64) -> u8 {
        let operation = self.busy_until.is_some() || self.window.is_open(now);
        let busy = if self.section_busy { BUSY_SECTION } else { 0 };
        if operation { self.control | busy } else { self.control & INTERRUPT | busy }
    }

    pub(crate) fn write(&mut self, value: u8, now: u64) {
        if self.busy_until.is_some() {
            self.control = self.control & !INTERRUPT | value & INTERRUPT;
            return;
        }
        self.control = value & !BUSY_SECTION;
        if value & ENABLE != 0 {
            self.window.open(now);
        } else {
            self.window.close();
        }
    }

    /// The effect of an `SPM` that begins at this cycle.
    pub(crate) fn action(&mut self, now: u64) -> Action {
        if !self.window.is_open(now) || self.busy_until.is_some() {
            return Action::Nothing;
        }
        self.window.close();
        let action = match self.control & !(INTERRUPT | ENABLE) {
            0 => Action::Fill,
            ERASE => Action::Erase,
            WRITE => Action::Write,
            LOCK_BITS => Action::SetLockBits,
            READ_WHILE_WRITE_ENABLE => Action::EnableReading,
            _ => Action::Nothing,
        };
        self.control &= INTERRUPT;
        action
    }

    /// The source for an `LPM` at this cycle.
    pub(crate) const fn reading(&self, now: u64) -> Reading {
        if !self.window.is_open(now) || self.busy_until.is_some() {
            return Reading::Flash;
        }
        match self.control & !(INTERRUPT | ENABLE) {
            SIGNATURE => Reading::Signature,
            LOCK_BITS => Reading::Fuses,
            _ => Reading::Flash,
        }
    }

    /// Puts a word into the buffer; a place can be filled once.
    pub(crate) fn fill(&mut self, word_address: u32, word: u16) {
        let place = word_address as usize & (self.buffer.len() - 1);
        self.buffer[place] &= word;
    }

    /// An erase or a write has begun.
    pub(crate) fn begin(&mut self, until: u64, below_boot_section: bool) {
        self.busy_until = Some(until);
        self.control |= ENABLE;
        self.section_busy |= below_boot_section;
    }

    /// The words to be written, which leave the buffer empty.
    pub(crate) fn take_buffer(&mut self, mut write: impl FnMut(&[u16])) {
        write(&self.buffer);
        self.buffer.fill(0xFFFF);
    }

    pub(crate) fn enable_reading(&mut self) {
        self.section_busy = false;
        self.buffer.fill(0xFFFF);
    }
}
