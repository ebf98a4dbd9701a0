//! Memory as `avr-gdb` addresses it.

use std::ops::Range;

use baudbot_avr::part::SRAM_START;
use baudbot_board::Board;

/// The beginning of the data space.
const DATA: u32 = 0x80_0000;
/// The beginning of the EEPROM.
const EEPROM: u32 = 0x81_0000;
/// Fuses, lock bits and the signature, which are not there, begin here.
const BEYOND: u32 = 0x82_0000;

/// A place in one of the memories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Flash(usize),
    Data(usize),
    Eeprom(usize),
}

impl Place {
    fn of(address: u32) -> Option<Self> {
        Some(match address {
            0..DATA => Self::Flash(address as usize),
            DATA..EEPROM => Self::Data((address - DATA) as usize),
            EEPROM..BEYOND => Self::Eeprom((address - EEPROM) as usize),
            _ => return None,
        })
    }
}

/// Reads what there is from an address on; the answer is how many bytes. Nothing changes, whatever is read.
pub(crate) fn read(board: &Board, address: u32, bytes: &mut [u8]) -> Option<usize> {
    let chip = board.chip();
    let count = match Place::of(address)? {
        Place::Flash(at) => {
            let words = chip.flash().iter().flat_map(|word| word.to_le_bytes());
            fill(bytes, words.skip(at))
        }
        Place::Data(at) => {
            // The copy has the effects that reading has.
            let mut copy = board.clone();
            let places = at.min(data_end(board))..data_end(board);
            fill(bytes, places.map(|place| copy.read_data(place as u16)))
        }
        Place::Eeprom(at) => fill(bytes, chip.eeprom().iter().copied().skip(at)),
    };
    (count > 0 || bytes.is_empty()).then_some(count)
}

fn fill(bytes: &mut [u8], from: impl Iterator<Item = u8>) -> usize {
    bytes.iter_mut().zip(from).map(|(byte, read)| *byte = read).count()
}

/// Writes all the bytes, or returns that they have no place.
pub(crate) fn write(board: &mut Board, address: u32, bytes: &[u8]) -> Option<()> {
    match Place::of(address)? {
        Place::Flash(at) => write_flash(board, at, bytes),
        Place::Data(at) => {
            if at + bytes.len() > data_end(board) {
                return None;
            }
            for (place, &byte) in (at..).zip(bytes) {
                board.write_data(place as u16, byte);
            }
            Some(())
        }
        Place::Eeprom(at) => {
            let memory = board.chip_mut().eeprom_mut().get_mut(at..at + bytes.len())?;
            memory.copy_from_slice(bytes);
            Some(())
        }
    }
}

fn write_flash(board: &mut Board, at: usize, bytes: &[u8]) -> Option<()> {
    if bytes.is_empty() {
        return Some(());
    }
    let words = at / 2..(at + bytes.len()).div_ceil(2);
    let before = board.chip().flash().get(words.clone())?;
    let mut after: Vec<u8> = before.iter().flat_map(|word| word.to_le_bytes()).collect();
    after[at % 2..][..bytes.len()].copy_from_slice(bytes);
    let after: Vec<u16> = after.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    board.chip_mut().write_flash(words.start as u32, &after);
    Some(())
}

/// The end of the chip's data space.
fn data_end(board: &Board) -> usize {
    usize::from(SRAM_START) + board.chip().sram().len()
}

/// The places in the static memory that these addresses are.
pub(crate) fn sram(board: &Board, address: u32, len: u32) -> Option<Range<usize>> {
    let Place::Data(at) = Place::of(address)? else { return None };
    let start = at.checked_sub(usize::from(SRAM_START))?;
    let places = start..start + len as usize;
    (places.end <= board.chip().sram().len()).then_some(places)
}

#[cfg(test)]
mod tests {
    use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
    use baudbot_board::{ChipClock, Physics, Wiring};

    use super::*;

    struct Nothing;

    impl Physics for Nothing {}

    #[test]
    fn reading_has_no_effect() {
        let part = Part::Atmega328P;
        // Timer 1 runs: reading TCNT1L keeps the high byte in the register TEMP.
        // ldi r16, 1; sts TCCR1B, r16; rjmp .-2
        let program = Program::from_words(part, &[0xE001, 0x9300, 0x0081, 0xCFFF]).unwrap();
        let chip = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
        let clock = ChipClock::exact(16_000_000).unwrap();
        let mut board = Board::new(chip, clock, Wiring::builder().build().unwrap()).unwrap();
        board.run_until(100_000_000, &mut Nothing);
        let before = board.clone();
        let mut bytes = [0; 0x900];
        assert_eq!(read(&board, DATA, &mut bytes), Some(0x900));
        assert!(board == before);
        let counter = u16::from_le_bytes([bytes[0x84], bytes[0x85]]);
        assert!(counter > 0xFF, "{counter}");
        board.read_data(0x84);
        assert!(board != before, "an instruction that reads it has an effect");
    }
}
