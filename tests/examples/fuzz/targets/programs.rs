//! Programs for a robot's microcontroller: Intel HEX and ELF.

use std::fs;
use std::path::Path;

use anyhow::Context;
use baudbot_avr::{Bare, Chip, Fuses, Part, Program, ProgramError, Supply};

use super::{Target, outcome};

pub(super) fn targets() -> anyhow::Result<Vec<Target>> {
    Ok(vec![
        Target {
            name: "hex",
            what: "programs as Intel HEX",
            seeds: files("hex")?,
            words: HEX_WORDS,
            run: Box::new(|bytes| run(Program::from_hex, bytes)),
        },
        Target {
            name: "elf",
            what: "programs as ELF",
            seeds: files("elf")?,
            words: ELF_WORDS,
            run: Box::new(|bytes| run(Program::from_elf, bytes)),
        },
    ])
}

/// The files of the tests of the chip that are not long.
fn files(end: &str) -> anyhow::Result<Vec<Vec<u8>>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/avr/tests/programs");
    let entries = fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|own| own == end));
    paths.sort();
    let files: Vec<_> = paths.iter().map(fs::read).collect::<Result<_, _>>()?;
    Ok(files.into_iter().filter(|file| file.len() < 4_000).collect())
}

/// Reads a file for the smallest and for the largest part, and lets what it is run for a moment.
fn run(read: fn(Part, &[u8]) -> Result<Program, ProgramError>, bytes: &[u8]) -> u64 {
    let [small, large] = [Part::Atmega48A, Part::Atmega328P].map(|part| read(part, bytes));
    if let (Ok(small), Ok(large)) = (&small, &large) {
        assert_eq!(small.flash(), large.flash(), "what fits into a small part is the same in a large one");
    }
    match large {
        Ok(program) => 1 + execute(&program),
        Err(error) => outcome(&error.to_string()),
    }
}

/// The state of a chip with a program after some cycles, roughly. The program is the same when it is written and read
/// again.
fn execute(program: &Program) -> u64 {
    let part = program.part();
    let again = Program::from_hex(part, program.flash_hex().as_bytes());
    let extras = |again: Program| {
        let eeprom = program.eeprom_hex();
        again.with_extras(eeprom.as_ref().map(String::as_bytes), program.fuses(), program.data_end())
    };
    let again =
        again.and_then(extras).unwrap_or_else(|error| panic!("what was written is not read: {error}"));
    assert_eq!((again.flash(), again.eeprom()), (program.flash(), program.eeprom()));
    let fuses = program.fuses().map(|[low, high, extended]| Fuses { low, high, extended });
    let fuses = fuses.unwrap_or_else(|| Fuses::external_clock(part));
    let mut chip = Chip::new(program, fuses, Supply::ARDUINO);
    if let Some(end) = program.data_end() {
        chip.watch_stack(end);
    }
    for _ in 0..10 {
        chip.run(chip.now() + CYCLES, &mut Bare);
    }
    u64::from(chip.pc() / 16)
}

const CYCLES: u64 = 200;

const HEX_WORDS: &[&[u8]] = &[
    b":00000001FF\n",
    b":020000040000FA\n",
    b":020000040001F9\n",
    b":020000021000EC\n",
    b":0400000300000000F9\n",
    b":02000000FFCF30\n",
    b":0100000000FF\n",
    b":\n",
    b"\r\n",
    b"FF",
    b"00",
    b"10",
];

const ELF_WORDS: &[&[u8]] = &[
    b"\x7fELF\x01\x01\x01",
    b"\x02\x00\x53\x00",
    b".text\0",
    b".data\0",
    b".bss\0",
    b".eeprom\0",
    b".fuse\0",
    b".note.gnu.avr.deviceinfo\0",
    b"atmega328p\0",
    b"\x00\x00\x80\x00",
    b"\x00\x00\x81\x00",
    b"\x00\x00\x82\x00",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\x00\x00\x00\x00",
];
