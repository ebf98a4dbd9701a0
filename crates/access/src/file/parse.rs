//! The way from the text of a file to grants.

use std::collections::HashMap;
use std::path::Path as FilePath;

use baudbot_fields::{FieldError, Path};
use serde::Deserialize;
use toml::{Table, Value};

use super::FileError;
use crate::date;
use crate::grant::{Grant, GrantName};

/// The version of files that this program reads and writes.
pub(super) const VERSION: i64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    #[serde(rename = "version")]
    _version: i64,
    #[serde(default)]
    tokens: Vec<Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGrant {
    name: String,
    hash: String,
    rights: Vec<String>,
    created_at: String,
    #[serde(default)]
    expires_at: Option<String>,
}

/// A field of an entry is wrong.
struct Wrong {
    field: FieldError,
    token: Option<GrantName>,
}

/// The grants of a file, in its order.
pub(super) fn grants(path: &FilePath, text: &str) -> Result<Vec<Grant>, FileError> {
    let table: Table = text.parse().map_err(|error: toml::de::Error| {
        let before = error.span().map_or(0, |span| span.start);
        not_toml(path, text, before, error.message())
    })?;
    all(table).map_err(|Wrong { field, token }| {
        let field = Box::new(field);
        FileError::Field { path: path.to_owned(), field, token }
    })
}

/// The error that a text is no TOML, from this byte on.
pub(super) fn not_toml(path: &FilePath, text: &str, at: usize, problem: &str) -> FileError {
    let line = text.bytes().take(at).filter(|byte| *byte == b'\n').count() + 1;
    // On one line, and with nothing in it that a terminal obeys.
    let problem = FieldError::new("", problem.trim().replace('\n', ", ")).problem;
    FileError::Toml { path: path.to_owned(), line, problem }
}

/// Some of these names, for messages.
pub(super) fn listed(names: &[GrantName]) -> String {
    let shown: Vec<_> = names.iter().take(MOST_SHOWN).map(|name| format!("`{name}`")).collect();
    match names.len().checked_sub(MOST_SHOWN) {
        None if names.is_empty() => "none".to_owned(),
        None | Some(0) => shown.join(", "),
        Some(more) => format!("{} and {more} more", shown.join(", ")),
    }
}

const MOST_SHOWN: usize = 20;

fn all(table: Table) -> Result<Vec<Grant>, Wrong> {
    check_version(&table).map_err(|field| Wrong { field, token: None })?;
    let raw: RawFile = read(table, &Path::root()).map_err(|field| Wrong { field, token: None })?;
    let mut grants: Vec<Grant> = Vec::with_capacity(raw.tokens.len());
    let (mut names, mut hashes) = (HashMap::new(), HashMap::new());
    for (i, entry) in raw.tokens.into_iter().enumerate() {
        let path = Path::root().field("tokens").index(i);
        let named = entry.get("name").and_then(Value::as_str).and_then(|name| name.parse().ok());
        let wrong = |field| Wrong { field, token: named.clone() };
        let grant = grant(entry, &path).map_err(wrong)?;
        if let Some(first) = names.insert(grant.name.clone(), i) {
            let problem = format!("is the name of tokens[{first}], too; names must be unique");
            return Err(wrong(path.field("name").error(problem)));
        }
        if let Some(first) = hashes.insert(grant.hash, i) {
            let problem =
                format!("is that of tokens[{first}], too; a token has one entry, with all its rights");
            return Err(wrong(path.field("hash").error(problem)));
        }
        grants.push(grant);
    }
    Ok(grants)
}

/// Checks the version first: in a file of a later one all else may be new.
fn check_version(table: &Table) -> Result<(), FieldError> {
    let path = Path::root().field("version");
    match table.get("version").map(Value::as_integer) {
        Some(Some(VERSION)) => Ok(()),
        Some(Some(other)) if other > VERSION => Err(path.error(format!(
            "is {other}, and this program reads {VERSION}; use the program that wrote the file, or a later one"
        ))),
        Some(Some(_) | None) => Err(path.error(format!("must be {VERSION}"))),
        None => Err(path.error(format!("is missing; write `version = {VERSION}` at the beginning of the file"))),
    }
}

fn grant(entry: Table, path: &Path) -> Result<Grant, FieldError> {
    let raw: RawGrant = read(entry, path)?;
    let name: GrantName = raw.name.parse().map_err(|problem| in_field(path, "name", &problem))?;
    if name.is_reserved() {
        let problem = format!("`{name}` is a name that logs use for others; choose another name");
        return Err(path.field("name").error(problem));
    }
    let hash = raw.hash.parse().map_err(|problem| in_field(path, "hash", &problem))?;
    let created_at =
        date::parse(&raw.created_at).map_err(|problem| in_field(path, "created_at", &problem))?;
    let end = raw.expires_at.as_deref().map(date::parse).transpose();
    let expires_at = end.map_err(|problem| in_field(path, "expires_at", &problem))?;
    let of_rights = path.field("rights");
    if raw.rights.is_empty() {
        let problem = "is empty, so that the token allows nothing; add a right, or remove the token";
        return Err(of_rights.error(problem));
    }
    let mut rights = Vec::with_capacity(raw.rights.len());
    for (i, right) in raw.rights.iter().enumerate() {
        rights.push(
            right
                .parse()
                .map_err(|problem: crate::BadRight| of_rights.index(i).error(problem.to_string()))?,
        );
    }
    Ok(Grant { name, hash, rights, created_at, expires_at })
}

/// The error that the value of a field is not what it should be.
fn in_field(path: &Path, field: &str, problem: &dyn std::error::Error) -> FieldError {
    path.field(field).error(problem.to_string())
}

/// Reads a table; an error has its whole path.
fn read<T: serde::de::DeserializeOwned>(table: Table, path: &Path) -> Result<T, FieldError> {
    baudbot_fields::read(table).map_err(|error| {
        let place = if error.path.is_empty() { path.clone() } else { path.field(&error.path) };
        let place = if place.as_str().is_empty() { Path::root().field("file") } else { place };
        place.error(error.problem).because(error.cause)
    })
}
