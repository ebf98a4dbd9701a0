//! Fields of files: how they are read and checked, and how errors name them.
//!
//! Scenarios, experiments and descriptions of brains are read with this crate, so that their errors have the same form: the path
//! of a field, what is wrong with it in words, and a [`Cause`] for programs. Each method of [`Path`] that takes a field and its value gives the value back if it is in the range that it must be in,
//! and an error with the path of the field if it is not.

#![no_std]

extern crate alloc;

mod cause;
pub mod endpoint;
#[cfg(feature = "toml")]
mod misread;
mod nearest;
pub mod number;
pub mod printable;
#[cfg(feature = "toml")]
mod read;
#[cfg(feature = "toml")]
mod tree;
#[cfg(feature = "toml")]
mod words;
mod writes;

use alloc::format;
use alloc::string::{String, ToString};

use serde::de::DeserializeOwned;
use thiserror::Error;

pub use cause::Cause;
#[cfg(feature = "toml")]
pub use misread::Misread;
pub use nearest::{edits, nearest};
use number::{Rule, to_ns};
use printable::Printable;
#[cfg(feature = "toml")]
pub use read::read;
pub use writes::{Frequency, NoWrites, Writes};

/// An error in a field. Path and problem are [`printable`], whatever they quote.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {problem}")]
pub struct FieldError {
    /// The path of the field, for instance `robots[2].sensors.front.range_m`.
    pub path: String,
    /// The problem and its remedy.
    pub problem: String,
    /// The kind of problem.
    pub cause: Cause,
}

impl FieldError {
    /// An error at a path; the empty path is the file itself.
    pub fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        let path = Some(path.into()).filter(|path| !path.is_empty());
        let path = path.unwrap_or_else(|| "scenario".into());
        let (path, problem) = (Printable(path).to_string(), Printable(problem.into()).to_string());
        Self { path, problem, cause: Cause::Value }
    }

    /// The same error, of this cause.
    pub fn because(self, cause: Cause) -> Self {
        Self { cause, ..self }
    }
}

/// The fields of a table, in whatever format the file has.
pub trait Fields {
    /// Reads the fields; the table stands at `path`.
    ///
    /// # Errors
    /// Names the field that is missing, unknown, or of the wrong type.
    fn read<T: DeserializeOwned>(self, path: &Path) -> Result<T, FieldError>;
}

/// A place in the file, for error messages.
#[derive(Clone, Debug)]
pub struct Path(String);

impl Path {
    /// The path of the file itself.
    pub fn root() -> Self {
        Self(String::new())
    }

    /// The path of a field.
    pub fn field(&self, name: &str) -> Self {
        Self(if self.0.is_empty() { name.into() } else { format!("{}.{name}", self.0) })
    }

    /// The path of an entry of a list.
    pub fn index(&self, i: usize) -> Self {
        Self(format!("{}[{i}]", self.0))
    }

    /// The path as it stands in messages; empty for the file itself.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The error that something is wrong with what stands here.
    pub fn error(&self, problem: impl Into<String>) -> FieldError {
        FieldError::new(self.0.clone(), problem)
    }

    /// An error if a field is given that must not be.
    pub fn refuse(&self, field: &str, is_given: bool, problem: &str) -> Result<(), FieldError> {
        if is_given { Err(self.field(field).error(problem)) } else { Ok(()) }
    }

    /// An error for the first of several fields that is given and must not be.
    pub fn refuse_all(&self, fields: &[(&str, bool)], problem: &str) -> Result<(), FieldError> {
        fields.iter().try_for_each(|(field, is_given)| self.refuse(field, *is_given, problem))
    }

    /// A number that keeps to a rule.
    pub fn number<R: Rule>(&self, field: &str, written: R::Written) -> Result<R::Value, FieldError> {
        number::checked::<R>(written).map_err(|problem| self.field(field).error(problem.to_string()))
    }

    /// A number in a closed interval.
    pub fn within(&self, field: &str, value: f64, min: f64, max: f64) -> Result<f64, FieldError> {
        self.rule(field, value, value >= min && value <= max, &format!("must be between {min} and {max}"))
    }

    /// A whole number in a closed interval.
    pub fn whole_within(&self, field: &str, value: u64, min: u64, max: u64) -> Result<u64, FieldError> {
        if (min..=max).contains(&value) {
            return Ok(value);
        }
        Err(self.field(field).error(format!("must be between {min} and {max}, is {value}")))
    }

    /// Seconds to nanoseconds.
    pub fn s(&self, field: &str, value: f64, min_s: f64, max_s: f64) -> Result<u64, FieldError> {
        Ok(to_ns(self.within(field, value, min_s, max_s)?, 1e9))
    }

    /// Milliseconds to nanoseconds.
    pub fn ms(&self, field: &str, value: f64, min_ms: f64, max_ms: f64) -> Result<u64, FieldError> {
        Ok(to_ns(self.within(field, value, min_ms, max_ms)?, 1e6))
    }

    fn rule(&self, field: &str, value: f64, sound: bool, rule: &str) -> Result<f64, FieldError> {
        if sound { Ok(value) } else { Err(self.field(field).error(format!("{rule}, is {value}"))) }
    }
}
