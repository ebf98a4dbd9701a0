//! The program of a microcontroller, from Intel HEX or ELF into the scenario.

use std::path::Path;

use baudbot_avr::{Part, Program};
use toml_edit::{Array, DocumentMut, InlineTable, Item, TableLike, Value};

use crate::error::{FileError, ImportError};
use crate::{file, tables};

/// The files that a scenario refers to.
#[derive(Clone, Copy)]
pub(crate) enum Files<'a> {
    /// In this folder.
    In(&'a Path),
    /// In this program.
    Embedded,
}

/// Replaces the names of files with programs. Returns whether there are any.
pub(crate) fn inline(document: &mut DocumentMut, files: Files<'_>) -> Result<bool, ImportError> {
    let mut has_any = false;
    let Some(robots) = document.get_mut("robots") else { return Ok(false) };
    for (i, robot) in tables::of(robots) {
        let microcontroller = robot.get_mut("microcontroller").and_then(Item::as_table_like_mut);
        let Some(program) = microcontroller.and_then(|table: &mut dyn TableLike| table.get_mut("program"))
        else {
            continue;
        };
        let Some(name) = program.as_str() else { continue };
        let found = match files {
            Files::In(folder) => table(&folder.join(name)),
            Files::Embedded => embedded(name),
        };
        let found = found.map_err(|error| error.at(format!("robots[{i}].microcontroller.program")))?;
        let mut table = Value::from(found);
        if let Some(name) = program.as_value() {
            *table.decor_mut() = name.decor().clone(); // a comment behind it
        }
        *program = table.into();
        has_any = true;
    }
    Ok(has_any)
}

/// The program of a file as what a scenario may have in its place: for `robots.NAME.microcontroller.program`.
///
/// # Errors
/// A file that cannot be read, or is no program for an ATmega. Whether it fits the part of the robot is checked by the
/// scenario's parser.
pub fn program(path: &Path) -> Result<String, ImportError> {
    let table = table(path).map_err(|error| error.at("program"))?;
    Ok(Value::from(table).to_string())
}

fn table(path: &Path) -> Result<InlineTable, FileError> {
    table_of(path, &file::bytes(path)?)
}

/// A program that is in this program.
fn embedded(name: &str) -> Result<InlineTable, FileError> {
    let path = Path::new(name);
    let found = crate::embedded::programs().find(|(other, _)| *other == name);
    let (_, bytes) =
        found.ok_or_else(|| FileError::new(path, "is not among the programs that are built in"))?;
    table_of(path, bytes)
}

fn table_of(path: &Path, bytes: &[u8]) -> Result<InlineTable, FileError> {
    // The largest part is taken: the check of a smaller one is where that is known.
    let program = Program::parse(Part::Atmega328P, bytes);
    let program = program.map_err(|error| FileError::new(path, error.to_string()))?;
    let mut table = InlineTable::new();
    table.insert("file", path.file_name().unwrap_or_default().to_string_lossy().into_owned().into());
    table.insert("hex", program.flash_hex().into());
    if let Some(eeprom) = program.eeprom_hex() {
        table.insert("eeprom_hex", eeprom.into());
    }
    if let Some(fuses) = program.fuses() {
        table.insert("fuses", Array::from_iter(fuses.map(i64::from)).into());
    }
    if let Some(device) = program.device() {
        table.insert("device", device.into());
    }
    if let Some(end) = program.data_end() {
        table.insert("data_end", i64::from(end).into());
    }
    Ok(table)
}
