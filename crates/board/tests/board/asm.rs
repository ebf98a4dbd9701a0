//! An assembler of the few instructions that the programs here need.
//!
//! Source of the encodings: Microchip, *AVR Instruction Set Manual*.

/// A program that grows word by word.
#[derive(Default)]
pub(crate) struct Asm {
    pub(crate) words: Vec<u16>,
}

/// I/O addresses.
pub(crate) mod io {
    pub(crate) const PINB: u16 = 0x03;
    pub(crate) const DDRB: u16 = 0x04;
    pub(crate) const PORTB: u16 = 0x05;
    pub(crate) const PINC: u16 = 0x06;
    pub(crate) const DDRC: u16 = 0x07;
    pub(crate) const PORTC: u16 = 0x08;
    pub(crate) const PIND: u16 = 0x09;
    pub(crate) const DDRD: u16 = 0x0A;
    pub(crate) const PORTD: u16 = 0x0B;
    pub(crate) const TIFR1: u16 = 0x16;
    pub(crate) const EIMSK: u16 = 0x1D;
    pub(crate) const SMCR: u16 = 0x33;
}

/// Data addresses.
pub(crate) mod data {
    pub(crate) const MCUSR: u16 = 0x54;
    pub(crate) const PCICR: u16 = 0x68;
    pub(crate) const PCMSK2: u16 = 0x6D;
    pub(crate) const EICRA: u16 = 0x69;
    pub(crate) const ADCL: u16 = 0x78;
    pub(crate) const ADCH: u16 = 0x79;
    pub(crate) const ADCSRA: u16 = 0x7A;
    pub(crate) const ADMUX: u16 = 0x7C;
    pub(crate) const TCCR0A: u16 = 0x44;
    pub(crate) const TCCR0B: u16 = 0x45;
    pub(crate) const OCR0A: u16 = 0x47;
    pub(crate) const TCCR1B: u16 = 0x81;
    pub(crate) const TCNT1L: u16 = 0x84;
    pub(crate) const TCNT1H: u16 = 0x85;
    pub(crate) const ICR1L: u16 = 0x86;
    pub(crate) const ICR1H: u16 = 0x87;
    pub(crate) const WDTCSR: u16 = 0x60;
    pub(crate) const TWBR: u16 = 0xB8;
    pub(crate) const TWSR: u16 = 0xB9;
    pub(crate) const TWDR: u16 = 0xBB;
    pub(crate) const TWCR: u16 = 0xBC;
}

impl Asm {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// The word address of the next instruction.
    pub(crate) fn here(&self) -> usize {
        self.words.len()
    }

    /// `NOP`s up to this word address.
    pub(crate) fn org(&mut self, address: usize) -> &mut Self {
        self.words.resize(address, 0);
        self
    }

    pub(crate) fn word(&mut self, word: u16) -> &mut Self {
        self.words.push(word);
        self
    }

    pub(crate) fn nop(&mut self) -> &mut Self {
        self.word(0)
    }

    pub(crate) fn ldi(&mut self, register: u16, value: u8) -> &mut Self {
        let value = u16::from(value);
        self.word(0xE000 | (value & 0xF0) << 4 | (register - 16) << 4 | value & 0x0F)
    }

    pub(crate) fn out(&mut self, address: u16, register: u16) -> &mut Self {
        self.word(0xB800 | (address & 0x30) << 5 | register << 4 | address & 0x0F)
    }

    fn bit(&mut self, code: u16, address: u16, bit: u16) -> &mut Self {
        self.word(code | address << 3 | bit)
    }

    pub(crate) fn sbi(&mut self, address: u16, bit: u16) -> &mut Self {
        self.bit(0x9A00, address, bit)
    }

    pub(crate) fn cbi(&mut self, address: u16, bit: u16) -> &mut Self {
        self.bit(0x9800, address, bit)
    }

    /// Skips the next instruction if the bit is clear.
    pub(crate) fn sbic(&mut self, address: u16, bit: u16) -> &mut Self {
        self.bit(0x9900, address, bit)
    }

    /// Skips the next instruction if the bit is set.
    pub(crate) fn sbis(&mut self, address: u16, bit: u16) -> &mut Self {
        self.bit(0x9B00, address, bit)
    }

    pub(crate) fn sts(&mut self, address: u16, register: u16) -> &mut Self {
        self.word(0x9200 | register << 4).word(address)
    }

    pub(crate) fn lds(&mut self, register: u16, address: u16) -> &mut Self {
        self.word(0x9000 | register << 4).word(address)
    }

    /// Stores a constant, by register 16.
    pub(crate) fn store(&mut self, address: u16, value: u8) -> &mut Self {
        self.ldi(16, value).sts(address, 16)
    }

    /// Skips the next instruction if the bit of a register is clear.
    pub(crate) fn sbrc(&mut self, register: u16, bit: u16) -> &mut Self {
        self.word(0xFC00 | register << 4 | bit)
    }

    /// Skips the next instruction if the bit of a register is set.
    pub(crate) fn sbrs(&mut self, register: u16, bit: u16) -> &mut Self {
        self.word(0xFE00 | register << 4 | bit)
    }

    pub(crate) fn inc(&mut self, register: u16) -> &mut Self {
        self.word(0x9403 | register << 4)
    }

    /// Adds to the pair of registers 24 and 25.
    pub(crate) fn adiw24(&mut self, value: u16) -> &mut Self {
        self.word(0x9600 | value & 0x0F)
    }

    pub(crate) fn rjmp(&mut self, address: usize) -> &mut Self {
        let offset = address as i32 - self.here() as i32 - 1;
        self.word(0xC000 | offset as u16 & 0x0FFF)
    }

    pub(crate) fn sei(&mut self) -> &mut Self {
        self.word(0x9478)
    }

    pub(crate) fn reti(&mut self) -> &mut Self {
        self.word(0x9518)
    }

    pub(crate) fn sleep(&mut self) -> &mut Self {
        self.word(0x9588)
    }

    /// An endless loop.
    pub(crate) fn stay(&mut self) -> &mut Self {
        self.rjmp(self.here())
    }

    /// Takes 4 `loops` + 1 cycles, in registers 24 and 25.
    pub(crate) fn delay(&mut self, loops: u16) -> &mut Self {
        let [low, high] = loops.to_le_bytes();
        // sbiw r24, 1; brne .-4
        self.ldi(24, low).ldi(25, high).word(0x9701).word(0xF7F1)
    }

    /// A command of the TWI, waited for.
    pub(crate) fn twi(&mut self, control: u8) -> &mut Self {
        self.store(data::TWCR, control);
        let wait = self.here();
        self.lds(17, data::TWCR).sbrs(17, 7).rjmp(wait)
    }

    pub(crate) fn twi_start(&mut self) -> &mut Self {
        self.twi(0xA4)
    }

    pub(crate) fn twi_send(&mut self, byte: u8) -> &mut Self {
        self.store(data::TWDR, byte).twi(0x84)
    }

    pub(crate) fn twi_read(&mut self, register: u16, acknowledge: bool) -> &mut Self {
        self.twi(if acknowledge { 0xC4 } else { 0x84 }).lds(register, data::TWDR)
    }

    pub(crate) fn twi_stop(&mut self) -> &mut Self {
        self.store(data::TWCR, 0x94)
    }
}
