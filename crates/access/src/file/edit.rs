//! Changes of a file's text that leave all else as it is, also comments.

use toml_edit::{ArrayOfTables, Datetime, DocumentMut, Item, Table, TomlError, value};

use super::parse::VERSION;
use crate::date;
use crate::grant::Grant;

/// A file without tokens.
pub(super) fn empty() -> String {
    format!(
        "# Tokens of a baudbot server and their rights (docs/reference/trust.md). `baudbot token` adds tokens and revokes them. The\n\
         # tokens themselves are not in here, only their hashes.\n\
         version = {VERSION}\n"
    )
}

/// The text with one grant more, at the end.
pub(super) fn with(text: &str, grant: &Grant) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    let mut tokens = tables(&mut document);
    tokens.push(entry(grant));
    document.insert("tokens", Item::ArrayOfTables(tokens));
    Ok(document.to_string())
}

/// The text without the grant at this place, and without the comments right above it.
pub(super) fn without(text: &str, place: usize) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    let mut tokens = tables(&mut document);
    if place < tokens.len() {
        tokens.remove(place);
    }
    document.insert("tokens", Item::ArrayOfTables(tokens));
    Ok(document.to_string())
}

/// Takes the list of tokens out of a document. One that is written as a value, `tokens = []`, becomes one of tables.
fn tables(document: &mut DocumentMut) -> ArrayOfTables {
    let list = document.remove("tokens").unwrap_or_default();
    list.into_array_of_tables().unwrap_or_default()
}

fn entry(grant: &Grant) -> Table {
    let mut entry = Table::new();
    entry["name"] = value(grant.name.as_str());
    entry["hash"] = value(grant.hash.to_string());
    entry["rights"] = value(grant.rights.iter().map(ToString::to_string).collect::<toml_edit::Array>());
    entry["created_at"] = value(date(grant.created_at));
    if let Some(end) = grant.expires_at {
        entry["expires_at"] = value(date(end));
    }
    entry
}

fn date(at: std::time::SystemTime) -> Datetime {
    date::print(at).parse().expect("a date of RFC 3339 is one of TOML")
}
