//! Lines of a table and their cells.

use std::io::BufRead;

use super::error::Problem;

/// Longest line that is read, in bytes.
const LONGEST_LINE: usize = 1 << 20;

/// Reads the next line without its end into `line`; false if there is none.
pub(super) fn next_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> Result<Option<u64>, Problem> {
    line.clear();
    let read = std::io::Read::take(&mut *input, LONGEST_LINE as u64 + 1).read_until(b'\n', line);
    let read = read.map_err(Problem::Io)?;
    if read == 0 {
        return Ok(None);
    }
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if read > LONGEST_LINE {
        return Err(Problem::LongLine { most: LONGEST_LINE });
    }
    if line.last() == Some(&b'\r') {
        line.pop();
    }
    Ok(Some(read as u64))
}

/// The line as text.
pub(super) fn text(line: &[u8]) -> Result<&str, Problem> {
    if let Some(&byte) = line.iter().find(|byte| **byte < 0x20 && **byte != b'\t') {
        return Err(Problem::Binary { byte });
    }
    std::str::from_utf8(line).map_err(|error| Problem::Binary { byte: line[error.valid_up_to()] })
}

/// The separator between the cells of a line of names: a comma, a semicolon or a tab, whichever is there.
pub(super) fn separator(names: &str) -> char {
    [',', ';', '\t'].into_iter().find(|separator| names.contains(*separator)).unwrap_or(',')
}

/// Calls `each` with the cells of a line, without blanks and quotation marks around them.
pub(super) fn split(line: &str, separator: char, cells: &mut Vec<String>) -> Result<(), Problem> {
    cells.clear();
    if !line.contains('"') {
        cells.extend(line.split(separator).map(|cell| cell.trim().to_owned()));
        return Ok(());
    }
    if line.matches('"').count() % 2 == 1 {
        return Err(Problem::Quote);
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator as u8)
        .buffer_capacity(line.len())
        .from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    cells.extend(record.iter().map(|cell| cell.trim().to_owned()));
    Ok(())
}

/// The number in a cell, NaN if it is empty.
pub(super) fn number(cell: &str) -> Result<f64, Problem> {
    if cell.is_empty() {
        return Ok(f64::NAN);
    }
    let quoted = || cell.chars().take(40).collect::<String>();
    match cell.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(Problem::NotFinite { cell: quoted() }),
        Err(_) if cell.matches(',').count() == 1 && cell.replace(',', ".").parse::<f64>().is_ok() => {
            Err(Problem::DecimalComma { cell: quoted() })
        }
        Err(_) => Err(Problem::NotANumber { cell: quoted() }),
    }
}
