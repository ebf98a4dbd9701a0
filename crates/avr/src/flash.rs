//! The program memory: words, and the instructions that they are.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::instruction::{LONGEST_LOOP, Op, operation};

/// Program memory. Clones share it until one of them writes.
#[derive(Clone, Debug)]
pub(crate) struct Flash {
    code: Arc<Code>,
}

/// Words with their instructions.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    words: Box<[u16]>,
    ops: Box<[Op]>,
}

impl Flash {
    /// Memory of so many words, a power of two, that begins with these bytes; the rest is erased.
    pub(crate) fn new(words: u32, bytes: &[u8]) -> Self {
        let mut memory = vec![0xFFFF; words as usize].into_boxed_slice();
        for (word, bytes) in memory.iter_mut().zip(bytes.chunks(2)) {
            *word = u16::from_le_bytes([bytes[0], bytes.get(1).copied().unwrap_or(0xFF)]);
        }
        Self::of(memory)
    }

    fn of(words: Box<[u16]>) -> Self {
        let ops = (0..words.len()).map(|at| operation(&words, at)).collect();
        Self { code: Arc::new(Code { words, ops }) }
    }

    /// The bytes of the words and of the instructions that they are.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.code.words) + size_of_val(&*self.code.ops)
    }

    /// All words.
    pub(crate) fn words(&self) -> &[u16] {
        &self.code.words
    }

    /// The instructions, for a loop that does not write.
    pub(crate) fn code(&self) -> Arc<Code> {
        Arc::clone(&self.code)
    }

    /// Whether this is what is executed.
    pub(crate) fn is(&self, code: &Arc<Code>) -> bool {
        Arc::ptr_eq(&self.code, code)
    }

    /// A byte at a byte address, which is taken modulo the size.
    #[inline]
    pub(crate) fn byte(&self, address: u32) -> u8 {
        let words = self.words();
        words[(address >> 1) as usize & (words.len() - 1)].to_le_bytes()[address as usize & 1]
    }

    /// Changes words from this address on.
    pub(crate) fn write(&mut self, address: u32, change: impl Fn(usize, u16) -> u16, count: usize) {
        let code = Arc::make_mut(&mut self.code);
        let len = code.words.len();
        for at in 0..count {
            let place = (address as usize + at) & (len - 1);
            code.words[place] = change(at, code.words[place]);
        }
        // The word before may be the first of two, and those behind may end a loop that begins here.
        for at in 0..=count + LONGEST_LOOP {
            let place = (address as usize + len + at - 1) & (len - 1);
            code.ops[place] = operation(&code.words, place);
        }
    }
}

impl Code {
    /// The instruction at a word address; beyond the memory there are none.
    #[inline(always)]
    pub(crate) fn op(&self, pc: u32) -> Op {
        match self.ops.get(pc as usize) {
            Some(&op) => op,
            None => Op::Illegal { word: 0xFFFF },
        }
    }
}

impl PartialEq for Flash {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.code, &other.code) || self.code.words == other.code.words
    }
}

impl Serialize for Flash {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let words = self.words();
        let used = words.iter().rposition(|&word| word != 0xFFFF).map_or(0, |last| last + 1);
        let content = (u32::try_from(words.len()).unwrap_or(u32::MAX), &words[..used]);
        serializer.serialize_newtype_struct(NO_MEMORY, &content)
    }
}

/// The name under which a program memory is serialised. Clones share it: who counts their memory leaves out what has this name.
pub const NO_MEMORY: &str = "NoMemoryOfItsOwn";

impl<'de> Deserialize<'de> for Flash {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (len, mut words) = <(u32, Vec<u16>)>::deserialize(deserializer)?;
        let len = len as usize;
        if !len.is_power_of_two() || len > LARGEST || words.len() > len {
            return Err(serde::de::Error::custom("no program memory has this size"));
        }
        words.resize(len, 0xFFFF);
        Ok(Self::of(words.into_boxed_slice()))
    }
}

/// Words of the largest program memory that a program counter of 22 bits reaches.
const LARGEST: usize = 1 << 22;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_does_not_change_a_clone() {
        let mut flash = Flash::new(64, &[0x0C, 0x94, 0x34, 0x12]);
        let before = flash.clone();
        flash.write(1, |_, _| 0x0001, 1);
        assert_eq!(before.code().op(0), Op::Jmp { high: 0, low: 0x1234 });
        assert_eq!(flash.code().op(0), Op::Jmp { high: 0, low: 1 });
        assert_ne!(flash, before);
    }

    #[test]
    fn what_was_saved_is_loaded_again() {
        let flash = Flash::new(2048, &[1, 2, 3]);
        let bytes = postcard::to_allocvec(&flash).unwrap();
        assert!(bytes.len() < 20, "erased words are not saved: {} bytes", bytes.len());
        assert_eq!(postcard::from_bytes::<Flash>(&bytes).unwrap(), flash);
        assert_eq!(flash.byte(2), 3);
        assert_eq!(flash.byte(3), 0xFF);
    }
}
