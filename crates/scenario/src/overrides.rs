//! Changing fields of a scenario by path: `robots.alice.start.x_m=0.5`.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;

use toml::{Table, Value};

use super::starts::numbered;
use baudbot_fields::{Cause, FieldError};

use crate::ScenarioError;

/// Most parts of a path; tables nested without end would exhaust the stack.
const MAX_PARTS: usize = 16;

/// A change of one field. In the path, an element of a list goes by its name or by its index:
/// `robots.alice.link.baud`, `robots.0.link.baud`, `robots[0].link.baud`. Of a robot that is one of several in a table with
/// `starts`, the start alone goes by the robot's name: `robots.cell-2.start.x_m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    text: String,
    path: Vec<String>,
    value: Value,
}

impl fmt::Display for Override {
    /// The text in the form in which it is parsed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Override {
    /// Parses `PATH=VALUE`. The value is TOML; what is not, is taken as a string, so that
    /// `collision=stop-run` needs no quotes.
    ///
    /// # Errors
    /// If there is no `=` or a part of the path is empty.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        Ok(Self::split(text)?)
    }

    fn split(text: &str) -> Result<Self, FieldError> {
        let (path, value) = text.split_once('=').ok_or_else(|| {
            FieldError::new(
                format!("`{text}`"),
                "an override is PATH=VALUE, such as robots.alice.start.x_m=0.5",
            )
        })?;
        let parts: Vec<String> =
            path.trim().replace('[', ".").replace(']', "").split('.').map(str::to_owned).collect();
        if parts.iter().any(String::is_empty) {
            return Err(FieldError::new(format!("`{path}`"), "the path has an empty part"));
        }
        if parts.len() > MAX_PARTS {
            let problem = format!("the path has {} parts, no field is deeper than {MAX_PARTS}", parts.len());
            return Err(FieldError::new("override", problem));
        }
        let value = value.trim();
        let parsed =
            format!("value = {value}").parse::<Table>().ok().and_then(|mut table| table.remove("value"));
        let digits = value.strip_prefix('-').unwrap_or(value);
        if parsed.is_none() && digits.len() > 18 && digits.bytes().all(|byte| byte.is_ascii_digit()) {
            let problem = format!("must be between {} and {}, is {value}", i64::MIN, i64::MAX);
            return Err(FieldError::new(path, problem));
        }
        let value = parsed.unwrap_or_else(|| Value::String(value.to_string()));
        Ok(Self { text: text.to_owned(), path: parts, value })
    }

    /// Puts the value into the file's table. Whether such a field exists is found out when the whole is
    /// deserialised, with the same errors as for the file.
    pub(super) fn apply(&self, table: &mut Table) -> Result<(), FieldError> {
        let (last, parents) = self.path.split_last().expect("split gives at least one part");
        let mut here = table;
        let mut parts = parents.iter().enumerate();
        while let Some((depth, part)) = parts.next() {
            let path = || self.path[..=depth].join(".");
            let child = here.entry(part.as_str()).or_insert_with(|| Value::Table(Table::new()));
            let kind = child.type_str();
            here = if let Value::Array(list) = child {
                let (_, key) = parts.next().ok_or_else(|| {
                    FieldError::new(
                        path(),
                        "is a list; name an element and a field of it, or give the whole list",
                    )
                    .because(Cause::NoTable)
                })?;
                let is_start = parents.get(depth + 2).is_some_and(|part| part == "start");
                if is_start && index_of(list, key).is_none() && of_several(list, key).is_some() {
                    parts.next();
                    own_start(list, key, &path())?
                } else {
                    element(list, key, &path())?
                }
            } else {
                child.as_table_mut().ok_or_else(|| {
                    let problem = format!("is a {kind}, it has no field `{}`", self.path[depth + 1]);
                    FieldError::new(path(), problem).because(Cause::NoTable)
                })?
            };
        }
        here.insert(last.clone(), self.value.clone());
        Ok(())
    }
}

fn element<'a>(list: &'a mut [Value], key: &str, path: &str) -> Result<&'a mut Table, FieldError> {
    let names: Vec<String> = list.iter().map(|value| name_of(value).unwrap_or("?").to_owned()).collect();
    let index = index_of(list, key);
    let error = |problem| FieldError::new(format!("{path}.{key}"), problem);
    if index.is_none()
        && let Some(OneOf { table, start: i, .. }) = of_several(list, key)
    {
        let problem = format!(
            "is one of several in `{table}`, which are identical: change {path}.{table}.FIELD for all of them, or \
             {path}.{table}.starts[{i}].FIELD for how this one starts"
        );
        return Err(error(problem).because(Cause::NoTable));
    }
    let has_tables = list.iter().all(Value::is_table);
    let tables = index.map(|i| &mut list[i]).and_then(Value::as_table_mut);
    tables.ok_or_else(|| {
        let problem = if has_tables {
            format!("there is no such element; there are: {}", names.join(", "))
        } else {
            "is a list of values, which cannot be changed one by one; give the whole list".to_owned()
        };
        error(problem).because(Cause::UnknownElement { name: key.into(), known: names.into() })
    })
}

/// The place of an element by its name or its index.
fn index_of(list: &[Value], key: &str) -> Option<usize> {
    let by_name = list.iter().position(|value| name_of(value) == Some(key));
    by_name.or_else(|| key.parse().ok().filter(|&i: &usize| i < list.len()))
}

/// The start of a robot that is one of several.
fn own_start<'a>(list: &'a mut [Value], robot: &str, path: &str) -> Result<&'a mut Table, FieldError> {
    let found = of_several(list, robot).map(|one| (one.element, one.start));
    let start = found.and_then(|(element, start)| list[element].get_mut("starts")?.get_mut(start));
    let no_table =
        || FieldError::new(format!("{path}.{robot}.start"), "is not a table").because(Cause::NoTable);
    start.and_then(Value::as_table_mut).ok_or_else(no_table)
}

/// The place of a robot that is one of several.
struct OneOf<'a> {
    /// The place of their table among the robots' tables.
    element: usize,
    table: &'a str,
    /// The place of the robot's own start among `starts`.
    start: usize,
}

/// The place of the robot of this name, if a table with `starts` has it.
fn of_several<'a>(list: &'a [Value], robot: &str) -> Option<OneOf<'a>> {
    list.iter().enumerate().find_map(|(element, value)| {
        let (table, starts) = (name_of(value)?, value.get("starts")?.as_array()?);
        let named = || starts.iter().position(|start| name_of(start) == Some(robot));
        let start = numbered_start(table, starts, robot).or_else(named)?;
        Some(OneOf { element, table, start })
    })
}

/// The start of the robot of this name, if it goes by its number. Crowds are large, so the number is tried as a place.
fn numbered_start(table: &str, starts: &[Value], robot: &str) -> Option<usize> {
    let number: usize = robot.strip_prefix(table)?.strip_prefix('-')?.parse().ok()?;
    let start = number.checked_sub(1)?;
    let is_it = name_of(starts.get(start)?).is_none() && numbered(table, start) == robot;
    is_it.then_some(start)
}

fn name_of(value: &Value) -> Option<&str> {
    value.get("name").and_then(Value::as_str)
}
