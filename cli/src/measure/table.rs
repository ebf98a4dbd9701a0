//! A table that grows at its end, and whose last step can be taken back: the file is whole after each change.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use baudbot_plot::quantity::count;

use super::header;
use crate::error::Refused;
use crate::text;

/// The rows of a file, by distance.
pub(super) struct Table {
    path: PathBuf,
    /// All lines before the rows.
    head: String,
    /// Rows, of which those with the same first cell that follow each other are a step.
    rows: Vec<String>,
}

impl Table {
    /// A file with these columns. One that is there is continued, if it has the same.
    pub(super) fn open(path: &Path, notes: &[(&str, String)], columns: &str) -> anyhow::Result<Self> {
        let path = path.to_owned();
        match fs::read_to_string(&path) {
            Ok(text) if !text.trim().is_empty() => Self::continued(path, &text, columns),
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(Refused::error(format!("{}: {error}", path.display())))
            }
            Ok(_) | Err(_) => Ok(Self { path, head: header(notes, columns), rows: Vec::new() }),
        }
    }

    fn continued(path: PathBuf, text: &str, columns: &str) -> anyhow::Result<Self> {
        let mut lines = text.lines();
        let mut head = String::new();
        for line in lines.by_ref() {
            head += line;
            head.push('\n');
            if line.starts_with('#') || line.trim().is_empty() {
                continue;
            }
            if line.trim() == columns {
                let rows = lines.filter(|line| !line.trim().is_empty()).map(str::to_owned).collect();
                return Ok(Self { path, head, rows });
            }
            break;
        }
        let problem =
            format!("exists already, and its columns are not {columns}; choose another file with -o");
        Err(Refused::error(format!("{}: {problem}", path.display())))
    }

    /// Adds rows and writes the file.
    pub(super) fn add(&mut self, rows: impl IntoIterator<Item = String>) -> anyhow::Result<()> {
        self.rows.extend(rows);
        self.write()
    }

    /// Takes the last step back: its first cell, and how many rows it had. `None` if there is none.
    pub(super) fn undo(&mut self) -> anyhow::Result<Option<(String, usize)>> {
        let cell = |row: &String| row.split(',').next().unwrap_or_default().to_owned();
        let Some(last) = self.rows.last().map(cell) else { return Ok(None) };
        let same = self.rows.iter().rev().take_while(|row| cell(row) == last).count();
        self.rows.truncate(self.rows.len() - same);
        self.write()?;
        Ok(Some((last, same)))
    }

    /// The amount in words.
    pub(super) fn words(&self) -> String {
        format!("{} in {}", count(self.rows.len(), "row"), self.path.display())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Another file takes its place at once, so that a full disk or a power cut leaves the old one.
    fn write(&self) -> anyhow::Result<()> {
        let lines = self.rows.iter().flat_map(|row| [row.as_str(), "\n"]);
        text::replace(&self.path, &std::iter::once(self.head.as_str()).chain(lines).collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &str = "distance_mm,value_raw";

    fn open(path: &Path) -> anyhow::Result<Table> {
        Table::open(path, &[("experiment", "curve".to_owned())], COLUMNS)
    }

    #[test]
    fn a_table_is_continued_and_its_last_step_taken_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curve.csv");
        open(&path).unwrap().add(["10,900", "10,901", "20,300"].map(str::to_owned)).unwrap();
        let mut table = open(&path).unwrap();
        table.add(["20,310".to_owned()]).unwrap();
        assert_eq!(table.undo().unwrap(), Some(("20".to_owned(), 2)));
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            "# experiment: curve\ndistance_mm,value_raw\n10,900\n10,901\n"
        );
        assert_eq!(table.undo().unwrap(), Some(("10".to_owned(), 2)));
        assert_eq!(table.undo().unwrap(), None);
    }

    #[test]
    fn a_file_of_something_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("echo.csv");
        fs::write(&path, "# experiment: echo\nsent_us,received_us\n1,2\n").unwrap();
        let error = open(&path).err().unwrap().to_string();
        assert!(error.contains("its columns are not distance_mm,value_raw"), "{error}");
        assert!(fs::read_to_string(&path).unwrap().contains("1,2"));
    }
}
