//! The file that grants are kept in.
//!
//! ```toml
//! version = 1
//!
//! [[tokens]]
//! name = "alice"
//! hash = "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae"
//! rights = ["observe", "drive wander/alice"]
//! created_at = 2026-12-01T08:00:00Z
//! expires_at = 2027-02-01T08:00:00Z
//! ```
//!
//! The hash is the SHA-256 of the token's text. `expires_at` can be left out. The tokens themselves are nowhere.

mod edit;
mod parse;

use std::env;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use baudbot_fields::FieldError;

use crate::date;
use crate::grant::{Grant, GrantName, words};
use crate::lock::Lock;
use crate::private::{self, PrivateError, Stamp, shown};
use crate::right::Right;
use crate::token::{NoRandomness, Token};

/// A file of tokens. It is read and written by each method anew.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TokenFile {
    path: PathBuf,
}

/// A grant that is to be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewGrant {
    /// The token's name.
    pub name: GrantName,
    /// The rights that it will give.
    pub rights: Vec<Right>,
    /// Until when; `None` for ever.
    pub expires_at: Option<SystemTime>,
}

/// A reason why a file of tokens cannot be read or changed.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file itself.
    #[error(transparent)]
    File(#[from] PrivateError),
    /// It is no TOML.
    #[error("{}: line {line}: {problem}", shown(path))]
    Toml {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The fault in that place.
        problem: String,
    },
    /// A field of it is wrong.
    #[error("{}: {field}{}", shown(path), of_token(token.as_ref()))]
    Field {
        /// The file.
        path: PathBuf,
        /// The field, the problem and the remedy.
        field: Box<FieldError>,
        /// The token whose field it is, if it has a good name.
        token: Option<GrantName>,
    },
    /// The name is given to another token.
    #[error("{}: has a token `{name}` already; take another name, or revoke that one first", shown(path))]
    Taken {
        /// The file.
        path: PathBuf,
        /// The name.
        name: GrantName,
    },
    /// Logs call others so.
    #[error("a token cannot have the name `{name}`, which logs use for others; choose another")]
    Reserved {
        /// The name.
        name: GrantName,
    },
    /// There is no token of this name.
    #[error("{}: has no token `{name}`; it has {}", shown(path), parse::listed(names))]
    Absent {
        /// The file.
        path: PathBuf,
        /// The name.
        name: GrantName,
        /// The names that there are.
        names: Vec<GrantName>,
    },
    /// No token can be made.
    #[error(transparent)]
    Random(#[from] NoRandomness),
}

impl FileError {
    /// Whether there is no such file.
    pub fn is_absent(&self) -> bool {
        matches!(self, Self::File(error) if error.is_absent())
    }
}

/// A longer file than that of any server, in bytes: it is read as a whole.
const MOST_BYTES: u64 = 16 << 20;

impl TokenFile {
    /// The file at this path, which need not be there yet.
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// The place by default: `$XDG_CONFIG_HOME/baudbot/tokens.toml`, or `~/.config/baudbot/tokens.toml`. `None` for a
    /// user without a home.
    pub fn usual() -> Option<Self> {
        // Relative paths are to be ignored, says the specification of these folders.
        let folder = |name| env::var_os(name).map(PathBuf::from).filter(|folder| folder.is_absolute());
        let config = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")))?;
        Some(Self::at(config.join("baudbot").join("tokens.toml")))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads all grants, in the order of the file.
    ///
    /// # Errors
    /// If the file cannot be read, others can read or write it, or something in it is wrong.
    pub fn read(&self) -> Result<Vec<Grant>, FileError> {
        Ok(self.read_stamped()?.0)
    }

    /// The grants that the file would have with this text.
    ///
    /// # Errors
    /// If something in it is wrong.
    pub fn parse(&self, text: &str) -> Result<Vec<Grant>, FileError> {
        parse::grants(&self.path, text)
    }

    /// The same as [`read`](Self::read), and what tells whether the file is still the one that was read.
    pub(crate) fn read_stamped(&self) -> Result<(Vec<Grant>, Stamp), FileError> {
        let (text, stamp) = private::read(&self.path, MOST_BYTES)?;
        Ok((self.parse(&text)?, stamp))
    }

    /// Makes a token, adds its grant, and gives the token, which is kept nowhere. The file and its folder are made if they are
    /// not there. What else is in the file stays as it is, also its comments.
    ///
    /// # Errors
    /// As [`read`](Self::read), and if the name is taken or reserved or the file cannot be written.
    pub fn add(&self, new: NewGrant, now: SystemTime) -> Result<Token, FileError> {
        if new.name.is_reserved() {
            return Err(FileError::Reserved { name: new.name });
        }
        private::make_folder_of(&self.path)?;
        let _lock = Lock::take(&self.path)?;
        let text = self.text_or_new()?;
        let grants = self.parse(&text)?;
        if grants.iter().any(|grant| grant.name == new.name) {
            return Err(FileError::Taken { path: self.path.clone(), name: new.name });
        }
        let token = Token::random()?;
        let NewGrant { name, rights, expires_at } = new;
        let (created_at, expires_at) = (date::whole(now), expires_at.map(date::whole));
        let grant = Grant { name, hash: token.hash(), rights, created_at, expires_at };
        let edited = edit::with(&text, &grant).map_err(|error| self.not_toml(&text, &error))?;
        self.write(&edited)?;
        Ok(token)
    }

    /// Takes the grant of this name out, and gives it.
    ///
    /// # Errors
    /// As [`read`](Self::read), and if there is no such name or the file cannot be written.
    pub fn revoke(&self, name: &GrantName) -> Result<Grant, FileError> {
        // Without the file there is no lock to be taken beside it.
        self.read()?;
        let _lock = Lock::take(&self.path)?;
        let (text, _) = private::read(&self.path, MOST_BYTES)?;
        let mut grants = self.parse(&text)?;
        let Some(place) = grants.iter().position(|grant| grant.name == *name) else {
            let names = grants.into_iter().map(|grant| grant.name).collect();
            return Err(FileError::Absent { path: self.path.clone(), name: name.clone(), names });
        };
        let edited = edit::without(&text, place).map_err(|error| self.not_toml(&text, &error))?;
        self.write(&edited)?;
        Ok(grants.swap_remove(place))
    }

    fn text_or_new(&self) -> Result<String, FileError> {
        match private::read(&self.path, MOST_BYTES) {
            Ok((text, _)) => Ok(text),
            Err(error) if error.is_absent() => Ok(edit::empty()),
            Err(error) => Err(error.into()),
        }
    }

    fn not_toml(&self, text: &str, error: &toml_edit::TomlError) -> FileError {
        parse::not_toml(&self.path, text, error.span().map_or(0, |span| span.start), error.message())
    }

    /// Writes a text, if it can be read again.
    fn write(&self, text: &str) -> Result<(), FileError> {
        let (path, bytes) = (self.path.clone(), text.len() as u64);
        if bytes > MOST_BYTES {
            return Err(PrivateError::TooLong { path, bytes, most: MOST_BYTES }.into());
        }
        self.parse(text)?;
        Ok(private::write(&self.path, text)?)
    }
}

/// In words: `operate, drive */*, until 2027-01-31T12:00:00Z`.
impl fmt::Display for NewGrant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&words(&self.rights, self.expires_at))
    }
}

fn of_token(name: Option<&GrantName>) -> String {
    name.map(|name| format!(" (token `{name}`)")).unwrap_or_default()
}

#[cfg(test)]
mod tests;
