//! The kinds of problems that errors are about.

use alloc::boxed::Box;
use alloc::string::String;

/// The kind of problem with a field, for programs. The words of an error are for people, and nothing reads them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Cause {
    /// The value, by itself or beside others.
    #[default]
    Value,
    /// The table has no such field.
    UnknownField {
        /// The name given.
        name: Box<str>,
        /// The fields that the table has.
        known: Box<[&'static str]>,
    },
    /// A field that must be given is not.
    MissingField,
    /// The list has no such element.
    UnknownElement {
        /// The name given.
        name: Box<str>,
        /// The elements that the list has.
        known: Box<[String]>,
    },
    /// The path continues through a value that has no fields.
    NoTable,
}

impl Cause {
    /// Whether there is no place in the file for what was given, or none was given for a place, whatever the value.
    pub fn is_absence(&self) -> bool {
        match self {
            Self::UnknownField { .. } | Self::MissingField | Self::UnknownElement { .. } | Self::NoTable => {
                true
            }
            Self::Value => false,
        }
    }
}
