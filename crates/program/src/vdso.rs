//! The vDSO of a process: a small library of the kernel's, by which programs read clocks without a call. It tells the machine's time, so
//! our code takes the place of the functions for clocks, and the others go: for those, programs make the calls.

use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;

use crate::os::{clocks, memory};

/// No vDSO is larger.
const MOST: usize = 1 << 16;
/// Entries of ELF files (elf.h), and the sizes of those of its lists.
const LOADED: u64 = 1;
const DYNAMIC: u64 = 2;
const PROGRAM_HEADER: usize = 56;
const TEXTS: u64 = 5;
const SYMBOLS: u64 = 6;
const SYMBOL: usize = 24;
const FUNCTION: u64 = 2;

/// Puts our code into the vDSO at this address. None: it is unlike those that we know, or the system does not let us write to it; it is
/// unchanged then.
pub(crate) fn replace(tid: i32, address: u64, page: u64) -> Option<()> {
    let mut image = Image(vec![0; 4096]);
    memory::read(tid, address, &mut image.0).ok()?;
    let size = image.segment(LOADED)?.1;
    image.0.resize(Some(size).filter(|size| *size <= MOST)?, 0);
    memory::read(tid, address, &mut image.0).ok()?;
    image.change(&clocks::code(page))?;
    // Its pages are read-only; a tracer writes to them as a debugger does to a program's code.
    OpenOptions::new().write(true).open(format!("/proc/{tid}/mem")).ok()?.write_all_at(&image.0, address).ok()
}

/// The bytes of a vDSO.
struct Image(Vec<u8>);

/// A function of the vDSO.
struct Function {
    /// The place of its symbol.
    symbol: usize,
    /// The place of its code, and its size.
    code: (usize, usize),
    /// The place of its code in ours.
    ours: Option<usize>,
}

impl Image {
    fn number(&self, place: usize, size: usize) -> Option<u64> {
        let bytes = self.0.get(place..place.checked_add(size)?)?;
        Some(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn place(&self, place: usize) -> Option<usize> {
        usize::try_from(self.number(place, 8)?).ok()
    }

    /// The place of a segment, and its size.
    fn segment(&self, kind: u64) -> Option<(usize, usize)> {
        let (table, count) = (self.place(32)?, self.number(56, 2)? as usize);
        let mut headers = (0..count).map(|number| table.saturating_add(number * PROGRAM_HEADER));
        let header = headers.find(|header| self.number(*header, 4) == Some(kind))?;
        Some((self.place(header + 16)?, self.place(header + 40)?))
    }

    /// The value of an entry of the dynamic section.
    fn entry(&self, kind: u64) -> Option<usize> {
        let (start, size) = self.segment(DYNAMIC)?;
        let mut entries = (start..start.checked_add(size)?).step_by(16);
        let entry = entries.find(|entry| self.number(*entry, 8) == Some(kind))?;
        self.place(entry + 8)
    }

    fn functions(&self) -> Option<Vec<Function>> {
        let (symbols, texts) = (self.entry(SYMBOLS)?, self.entry(TEXTS)?);
        self.0.get(symbols..texts)?;
        let functions = (symbols..texts)
            .step_by(SYMBOL)
            .filter(|symbol| self.number(symbol + 4, 1).is_some_and(|kind| kind & 15 == FUNCTION));
        functions
            .map(|symbol| {
                let name = self.0.get(texts + self.number(symbol, 4)? as usize..)?;
                let is_called =
                    |called: &[u8]| name.starts_with(called) && name.get(called.len()) == Some(&0);
                let ours = clocks::functions()
                    .into_iter()
                    .find(|(called, _)| is_called(called) || is_called(&called[b"__vdso_".len()..]));
                let code = (self.place(symbol + 8)?, self.place(symbol + 16)?);
                Some(Function { symbol, code, ours: ours.map(|(_, place)| place) })
            })
            .collect()
    }

    /// Writes our code over that of all functions, and lets the symbols lead to it. Symbols of other functions become undefined.
    fn change(&mut self, ours: &[u8]) -> Option<()> {
        let functions = self.functions()?;
        let start = functions.iter().map(|function| function.code.0).min()?;
        let end = functions.iter().map(|function| function.code.0.saturating_add(function.code.1)).max()?;
        self.0.get_mut(start..end)?.get_mut(..ours.len())?.copy_from_slice(ours);
        for function in functions {
            let value = function.ours.map_or(0, |place| start + place) as u64;
            self.0.get_mut(function.symbol + 8..function.symbol + 16)?.copy_from_slice(&value.to_ne_bytes());
            if function.ours.is_none() {
                self.0.get_mut(function.symbol + 6..function.symbol + 8)?.fill(0);
            }
        }
        Some(())
    }
}
