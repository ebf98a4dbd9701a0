use std::string::ToString;
use std::vec::Vec;

use super::*;

const BLINK: &[u8] = b":0400000011223344\x35\x32\n:00000001FF\n";

fn hex(text: &str) -> Result<Program, ProgramError> {
    Program::from_hex(Part::Atmega328P, text.as_bytes())
}

#[test]
fn a_hex_file_gives_the_flash() {
    let program = Program::parse(Part::Atmega328P, BLINK).unwrap();
    assert_eq!(program.flash(), [0x11, 0x22, 0x33, 0x44]);
    assert!(program.eeprom().is_empty());
}

#[test]
fn a_gap_between_records_is_erased_flash() {
    let program = hex(":0100000001FE\n:0100030002FA\n:00000001FF\n").unwrap();
    assert_eq!(program.flash(), [1, 0xFF, 0xFF, 2]);
}

#[test]
fn extended_addresses_shift_what_follows() {
    let program = hex(":020000020010EC\n:0100000005FA\n:00000001FF\n").unwrap();
    assert_eq!(program.flash().len(), 0x101);
    assert_eq!(program.flash()[0x100], 5);
}

#[test]
fn a_bad_checksum_names_its_line() {
    let error = hex(":0100000001FE\n:0100030002FB\n:00000001FF\n").unwrap_err();
    assert_eq!(
        error,
        ProgramError::Hex { line: 2, error: HexError::Checksum { expected: 0xFA, found: 0xFB } }
    );
    assert_eq!(error.to_string(), "line 2: the checksum is 0xfb, but the bytes give 0xfa");
}

#[test]
fn records_of_an_odd_or_wrong_length_are_refused() {
    let length =
        |expected, found| Err(ProgramError::Hex { line: 1, error: HexError::Length { expected, found } });
    assert_eq!(hex(":0100000001F\n"), length(12, 11));
    assert_eq!(hex(":0200000001FE\n"), length(14, 12));
    assert_eq!(hex(":\n"), length(10, 0));
    assert_eq!(hex(":0\n"), length(10, 1));
}

#[test]
fn other_faults_of_a_line_are_told() {
    let fault = |text| match hex(text) {
        Err(ProgramError::Hex { error, .. }) => error,
        other => panic!("{other:?}"),
    };
    assert_eq!(fault("0100000001FE\n"), HexError::NoColon);
    assert_eq!(fault(":01000G0001FE\n"), HexError::Digit { column: 7 });
    assert_eq!(fault(":00000007F9\n"), HexError::Kind { kind: 7, count: 0 });
    assert_eq!(fault(":00000001FF\n:00000001FF\n"), HexError::AfterEnd);
    assert_eq!(fault(":0100000001FE\n"), HexError::NoEnd);
}

#[test]
fn an_address_beyond_the_flash_names_the_size_of_the_part() {
    let text = b":02100000010 2EB\n".iter().copied().filter(|&byte| byte != b' ').collect::<Vec<_>>();
    assert_eq!(
        Program::from_hex(Part::Atmega48A, &text).unwrap_err().to_string(),
        "byte 0x1000 is beyond the flash of an atmega48a, which has 4096 bytes"
    );
}

#[test]
fn a_byte_that_is_given_twice_is_refused() {
    assert_eq!(
        hex(":0100000001FE\n:0100000001FE\n:00000001FF\n"),
        Err(ProgramError::Overlap { memory: Memory::Flash, address: 0 })
    );
}

#[test]
fn a_file_without_a_byte_is_empty() {
    assert_eq!(hex(""), Err(ProgramError::Empty));
    assert_eq!(hex(":00000001FF\n"), Err(ProgramError::Empty));
}

#[test]
fn an_application_and_its_boot_loader_make_one_program() {
    let application = Program::from_words(Part::Atmega328P, &[0x1234]).unwrap();
    let loader = hex(":0100030002FA\n:00000001FF\n").unwrap();
    assert_eq!(application.clone().and(&loader).unwrap().flash(), [0x34, 0x12, 0xFF, 2]);
    assert!(matches!(application.clone().and(&application), Err(ProgramError::Overlap { .. })));
}

/// An ELF file with one segment of four bytes in the flash, one of two in the EEPROM, and a section of fuses and of `.bss`.
fn elf() -> Vec<u8> {
    let mut file = [0u8; 52].to_vec();
    file[..4].copy_from_slice(&MAGIC);
    (file[4], file[5], file[18]) = (1, 1, 83);
    file[28] = 52; // program headers
    (file[42], file[44]) = (32, 2);
    file[32] = 116; // section headers
    (file[46], file[48]) = (40, 2);
    for (offset, address, len) in [(196u32, 0u32, 4u32), (200, 0x81_0000, 2)] {
        for word in [1, offset, address, address, len, len, 5, 1] {
            file.extend(word.to_le_bytes());
        }
    }
    for (kind, address, offset, len) in [(1u32, 0x82_0000u32, 202u32, 3u32), (8, 0x80_0100, 0, 0x20)] {
        for word in [0, kind, 2, address, offset, len, 0, 0, 1, 0] {
            file.extend(word.to_le_bytes());
        }
    }
    file.extend([0x0C, 0x94, 0x34, 0x12, 0xAA, 0x55, 0xE2, 0xD9, 0xFF]);
    file
}

use super::elf::MAGIC;

#[test]
fn an_elf_file_gives_flash_eeprom_fuses_and_the_end_of_the_variables() {
    let program = Program::parse(Part::Atmega328P, &elf()).unwrap();
    assert_eq!(program.flash(), [0x0C, 0x94, 0x34, 0x12]);
    assert_eq!(program.eeprom(), [0xAA, 0x55]);
    assert_eq!(program.fuses(), Some([0xE2, 0xD9, 0xFF]));
    assert_eq!(program.data_end(), Some(0x120));
}

#[test]
fn an_elf_file_for_another_machine_is_refused() {
    let mut file = elf();
    file[18] = 62;
    assert_eq!(Program::parse(Part::Atmega328P, &file), Err(ElfError::Machine { found: 62 }.into()));
    file[4] = 2;
    assert_eq!(Program::parse(Part::Atmega328P, &file), Err(ElfError::Class.into()));
}

#[test]
fn an_elf_file_that_is_cut_off_anywhere_is_refused() {
    let file = elf();
    for len in 4..file.len() {
        let found = Program::parse(Part::Atmega328P, &file[..len]);
        assert!(matches!(found, Err(ProgramError::Elf(ElfError::Truncated { .. }))), "{len}: {found:?}");
    }
}

#[test]
fn an_object_file_is_not_linked() {
    let mut file = elf();
    file[44] = 0;
    assert_eq!(Program::parse(Part::Atmega328P, &file), Err(ElfError::NotLinked.into()));
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_readers_panic(mut bytes: Vec<u8>, at in 0usize..205, value: u8) {
        let _ = Program::parse(Part::Atmega328P, &bytes);
        bytes.insert(0, b':');
        let _ = Program::parse(Part::Atmega328P, &bytes);
        let mut file = elf();
        file[at] = value;
        let _ = Program::parse(Part::Atmega328P, &file);
    }
}

#[test]
fn what_is_written_as_hex_is_read_again() {
    for len in [1, 15, 16, 17, 1000, 32 << 10] {
        let flash: Vec<u8> = (0..len).map(|at| (at * 7 + at / 256) as u8).collect();
        let words: Vec<u16> =
            flash.chunks(2).map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0)])).collect();
        let program = Program::from_words(Part::Atmega328P, &words).unwrap();
        let again = Program::from_hex(Part::Atmega328P, program.flash_hex().as_bytes()).unwrap();
        assert_eq!(again, program);
        assert_eq!(program.eeprom_hex(), None);
        let extras =
            again.with_extras(Some(b":0200000001FFFE\n:00000001FF\n"), Some([1, 2, 3]), Some(0x200)).unwrap();
        assert_eq!(
            (extras.eeprom(), extras.fuses(), extras.data_end()),
            (&[1, 0xFF][..], Some([1, 2, 3]), Some(0x200))
        );
        assert_eq!(extras.eeprom_hex().unwrap(), ":0200000001FFFE\n:00000001FF\n");
    }
}

#[test]
fn an_elf_file_for_another_avr_is_refused() {
    let elf = include_bytes!("../../tests/programs/eeprom.elf");
    assert_eq!(Program::from_elf(Part::Atmega328P, elf).unwrap().device(), Some("atmega328p"));
    let mut mega = elf.to_vec();
    mega[36] = mega[36] & 0x80 | 6;
    assert_eq!(Program::from_elf(Part::Atmega328P, &mega), Err(ElfError::Family { found: 6 }.into()));
    let name = elf.windows(10).position(|name| name == b"atmega328p").unwrap();
    for other in ["atmega32u4", "attiny841a", "atmega3290"] {
        let mut leonardo = elf.to_vec();
        leonardo[name..name + 10].copy_from_slice(other.as_bytes());
        let error = ElfError::Device { name: other.into() };
        assert_eq!(Program::from_elf(Part::Atmega328P, &leonardo), Err(error.into()));
    }
    let mut older = elf.to_vec();
    older[name..name + 10].copy_from_slice(b"atmega168p");
    assert_eq!(Program::from_elf(Part::Atmega328P, &older).unwrap().device(), Some("atmega168p"));
}
