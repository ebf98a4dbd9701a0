//! A scenario's text with some of its fields changed: comments, and the order of sensors, which is that on the wire, stay.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use crate::error::Error;

/// Puts a change of the form `PATH=VALUE`, as of `--set`, into a document.
pub(super) fn set(document: &mut DocumentMut, text: &str) -> Result<(), Error> {
    let no_place = || Error::Refused(format!("`{text}` has no place in the scenario's file"));
    let (path, value) = text.split_once('=').ok_or_else(no_place)?;
    let path = path.trim().replace('[', ".").replace(']', "");
    let parts: Vec<_> = path.split('.').collect();
    let (last, parents) = parts.split_last().ok_or_else(no_place)?;
    let value: Value = value.trim().parse().unwrap_or_else(|_| Value::from(value.trim()));
    let table = table_at(document.as_table_mut(), parents).ok_or_else(no_place)?;
    match table.get_mut(last) {
        // The decoration of the old one, a comment for instance, stays.
        Some(Item::Value(old)) => {
            let decor = old.decor().clone();
            *old = value;
            *old.decor_mut() = decor;
        }
        _ => drop(table.insert(last, Item::Value(value))),
    }
    Ok(())
}

/// The table that a path leads to; one that is not there is made.
fn table_at<'a>(table: &'a mut dyn TableLike, path: &[&str]) -> Option<&'a mut dyn TableLike> {
    let Some((first, rest)) = path.split_first() else { return Some(table) };
    let is_new = !table.contains_key(first);
    if is_new {
        table.insert(first, Item::Value(Value::InlineTable(InlineTable::new())));
    }
    let child = table.get_mut(first)?;
    if child.is_array_of_tables() || child.is_array() {
        let (key, rest) = rest.split_first()?;
        let place = place_of(child, key)?;
        let (element, rest) = match place {
            Place::Element(i) => (element_mut(child, i)?, rest),
            // A robot that is one of several has no more of its own than its start.
            Place::Start(i, start) => {
                let starts = element_mut(child, i)?.get_mut("starts")?;
                (element_mut(starts, start)?, rest.strip_prefix(&["start"])?)
            }
        };
        return table_at(element, rest);
    }
    table_at(child.as_table_like_mut()?, rest)
}

/// The place of an element that goes by its name or by its index.
enum Place {
    Element(usize),
    /// A start of an element.
    Start(usize, usize),
}

fn place_of(list: &Item, key: &str) -> Option<Place> {
    let names = names(list);
    let by_name = names.iter().position(|name| name.as_deref() == Some(key));
    if let Some(i) = by_name.or_else(|| key.parse().ok().filter(|i| *i < names.len())) {
        return Some(Place::Element(i));
    }
    let (table, number) = key.rsplit_once('-')?;
    let element = names.iter().position(|name| name.as_deref() == Some(table))?;
    Some(Place::Start(element, number.parse::<usize>().ok()?.checked_sub(1)?))
}

fn names(list: &Item) -> Vec<Option<String>> {
    let name = |item: Option<&Item>| item.and_then(Item::as_str).map(str::to_owned);
    match list {
        Item::ArrayOfTables(tables) => tables.iter().map(|table| name(table.get("name"))).collect(),
        Item::Value(Value::Array(array)) => {
            let value = |value: &Value| value.as_inline_table()?.get("name")?.as_str().map(str::to_owned);
            array.iter().map(value).collect()
        }
        Item::None | Item::Value(_) | Item::Table(_) => Vec::new(),
    }
}

fn element_mut(list: &mut Item, place: usize) -> Option<&mut dyn TableLike> {
    match list {
        Item::ArrayOfTables(tables) => tables.get_mut(place).map(|table| table as &mut dyn TableLike),
        Item::Value(Value::Array(array)) => {
            array.get_mut(place).and_then(Value::as_inline_table_mut).map(|table| table as &mut dyn TableLike)
        }
        Item::None | Item::Value(_) | Item::Table(_) => None,
    }
}

/// The number of faults of each robot's table.
pub(super) fn faults(document: &DocumentMut) -> Vec<usize> {
    let robots = document.get("robots");
    let count = |table: &Table| table.get("faults").map_or(0, |faults| names(faults).len());
    robots
        .and_then(Item::as_array_of_tables)
        .map_or_else(Vec::new, |robots| robots.iter().map(count).collect())
}

/// Takes a fault of a robot's table out.
pub(super) fn remove_fault(document: &mut DocumentMut, robot: usize, fault: usize) {
    let robots = document.get_mut("robots").and_then(Item::as_array_of_tables_mut);
    let faults = robots.and_then(|robots| robots.get_mut(robot)).and_then(|table| table.get_mut("faults"));
    match faults {
        Some(Item::ArrayOfTables(tables)) => drop(ArrayOfTables::remove(tables, fault)),
        Some(Item::Value(Value::Array(array))) => drop(Array::remove(array, fault)),
        Some(Item::None | Item::Value(_) | Item::Table(_)) | None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# a room\nseed = 1 # any\n[[robots]]\nname = \"a\"\nlink = { kind = \"uart\", baud = 9600 }\n\
                        [robots.sensors.z]\nkind = \"infrared\"\n[robots.sensors.b]\nkind = \"infrared\"\n\
                        [[robots.faults]]\nkind = \"brain\"\n[[robots.faults]]\nkind = \"cable\"\n\
                        [[robots]]\nname = \"cell\"\nstarts = [{ x_m = 1.0 }, { x_m = 2.0 }]\n";

    #[test]
    fn a_change_touches_nothing_else() {
        let mut document: DocumentMut = TEXT.parse().unwrap();
        for text in [
            "seed=7",
            "robots.a.link.baud=4800",
            "robots[0].start.x_m=0.5",
            "robots.cell-2.start.x_m=3.5",
            "end.after_s=2.0",
        ] {
            set(&mut document, text).unwrap();
        }
        let expected =
            TEXT.replace("seed = 1", "seed = 7").replace("9600", "4800").replace("x_m = 2.0", "x_m = 3.5");
        let found = document.to_string();
        let plain = |text: &str| {
            text.lines()
                .filter(|line| !line.starts_with("start =") && !line.starts_with("end ="))
                .collect::<Vec<_>>()
                .join("\n")
        };
        assert_eq!(plain(&found), plain(&expected));
        assert!(
            found.contains("start = { x_m = 0.5 }") && found.contains("end = { after_s = 2.0 }"),
            "{found}"
        );
        assert!(set(&mut document, "robots.nobody.link.baud=1").is_err());
    }

    #[test]
    fn faults_are_taken_out_one_by_one() {
        let mut document: DocumentMut = TEXT.parse().unwrap();
        assert_eq!(faults(&document), [2, 0]);
        remove_fault(&mut document, 0, 0);
        assert_eq!(faults(&document), [1, 0]);
        assert!(document.to_string().contains("cable") && !document.to_string().contains("brain"));
    }
}
