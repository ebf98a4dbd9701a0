//! A program, as a command line or a file names it.

use std::fmt;
use std::path::{Path, PathBuf};

/// The prefix of a program's words in the place of a brain's name.
pub const EXEC: &str = "exec:";

/// A brain that is a program of its own.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Program {
    /// The text of the program, without `exec:`.
    text: String,
    /// The program and its arguments.
    pub(crate) words: Vec<String>,
    /// The folder that it is started in; `None`: the current one.
    pub(crate) folder: Option<PathBuf>,
}

/// A text that names no program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadProgram {
    /// There is nothing behind `exec:`.
    #[error("`{EXEC}` names no program; write it as in {EXEC}python3 follow.py")]
    Empty,
    /// A quote is not closed.
    #[error("`{0}`: a quote is not closed, or a backslash ends the text")]
    Quotes(String),
    /// There is nothing behind `program:`, or only settings.
    #[error("`program:` names no program; write it as in program:python3 driver.py")]
    NoPortProgram,
    /// A word in front of a program in simulated time is no setting.
    #[error(
        "`{0}` in front of a program says nothing; write a port as in /dev/ttyUSB0=robot, once, or a price as in price=5us"
    )]
    Setting(String),
    /// A price is none.
    #[error("`{0}`: a price is a number with its unit, from 1ns to 1000ms, as in price=5us")]
    Price(String),
}

impl Program {
    /// Reads a program and its arguments, split at spaces as a shell does it: quotes hold words together. No shell is
    /// started, so variables and pipes mean nothing.
    ///
    /// # Errors
    /// If there is no word, or a quote is not closed.
    pub fn parse(text: &str) -> Result<Self, BadProgram> {
        let words = shlex::split(text).ok_or_else(|| BadProgram::Quotes(format!("{EXEC}{text}")))?;
        if words.first().is_none_or(String::is_empty) {
            return Err(BadProgram::Empty);
        }
        Ok(Self { text: text.trim().to_owned(), words, folder: None })
    }

    /// The program that the text of a brain names, if it names one: `exec:python3 follow.py`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn of_brain(brain: &str) -> Option<Result<Self, BadProgram>> {
        Some(Self::parse(brain.strip_prefix(EXEC)?))
    }

    /// The same, started in a folder, from which its relative paths go.
    #[must_use]
    pub fn in_folder(self, folder: PathBuf) -> Self {
        Self { folder: Some(folder).filter(|folder| !folder.as_os_str().is_empty()), ..self }
    }

    /// The files that its words name: the program if it is a path, and its arguments. A program that is looked for along `PATH` is
    /// none of them.
    pub fn files(&self) -> Vec<PathBuf> {
        files(&self.words, self.folder.as_deref())
    }
}

/// The files that words name, of which the first is the program.
pub(crate) fn files(words: &[String], folder: Option<&Path>) -> Vec<PathBuf> {
    let folder = folder.unwrap_or_else(|| Path::new(""));
    let (program, arguments) = words.split_at(1.min(words.len()));
    let program = program.iter().filter(|word| word.contains('/'));
    let paths = program.chain(arguments).map(|word| folder.join(word));
    paths.filter(|path| path.is_file()).collect()
}

impl fmt::Display for Program {
    /// The text of the program without `exec:`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_split_as_by_a_shell() {
        let words = |text: &str| Program::parse(text).map(|program| program.words);
        assert_eq!(
            words(" python3  'my follow.py' -x \"a b\" "),
            Ok(["python3", "my follow.py", "-x", "a b"].map(str::to_owned).to_vec())
        );
        assert_eq!(words("./a $HOME|b"), Ok(["./a", "$HOME|b"].map(str::to_owned).to_vec()));
        assert_eq!(words(" "), Err(BadProgram::Empty));
        assert_eq!(words("''"), Err(BadProgram::Empty));
        assert_eq!(words("a 'b"), Err(BadProgram::Quotes("exec:a 'b".to_owned())));
        let files = Program::parse("src/lib.rs -x src").unwrap().in_folder("../run".into()).files();
        assert_eq!(files, [Path::new("../run/src/lib.rs")]);
        assert_eq!(Program::of_brain("avoid"), None);
        assert_eq!(Program::of_brain("exec:a b").unwrap().unwrap().to_string(), "a b");
    }
}
