//! Fields of experiments and exercises, with errors that name them.

use baudbot_run::UnknownName;
use serde::de::DeserializeOwned;
use toml::Table;

use crate::error::Error;

/// The fields of a whole file, which is called `whole` where no field is to blame.
pub(crate) fn fields<T: DeserializeOwned>(toml: &str, whole: &str) -> Result<T, Error> {
    let table: Table = toml.parse().map_err(|error: toml::de::Error| Error::Syntax(error.to_string()))?;
    fields_of(table, |path| if path.is_empty() { whole.to_owned() } else { path.to_owned() })
}

/// The fields of a table; `at` is the path of a field.
pub(crate) fn fields_of<T: DeserializeOwned>(
    table: Table,
    at: impl FnOnce(&str) -> String,
) -> Result<T, Error> {
    baudbot_fields::read(table).map_err(|error| match UnknownName::of(&error.cause) {
        Some(unknown) => Error::field(at(&error.path), unknown),
        None => Error::field(at(&error.path), &error.problem),
    })
}

/// A number above 0 and at most `most`.
pub(crate) fn within(path: &str, value: f64, most: f64) -> Result<f64, Error> {
    if value > 0.0 && value <= most {
        return Ok(value);
    }
    Err(Error::field(path, format!("must be above 0 and at most {most}, is {value}")))
}

/// The length of a run.
pub(crate) fn seconds(seconds: f64) -> Result<f64, Error> {
    if (1e-9..=1e8).contains(&seconds) {
        return Ok(seconds);
    }
    Err(Error::field("seconds", format!("must be from 1e-9 to 1e8, is {seconds}")))
}
