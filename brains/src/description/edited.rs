//! The text of a description with other numbers in it.

use baudbot_fields::Cause;
use baudbot_geometry::math;
use toml_edit::{DocumentMut, InlineTable, Item, TableLike, value};

use super::DescriptionError;

/// The same text with numbers set to others, by their paths, which need not stand in it yet: all else of it stays, also what is
/// only for people. If a path is there twice, the last counts.
///
/// # Errors
/// If it is no TOML, or a path leads through something that is no table.
pub(crate) fn edited(toml: &str, settings: &[(String, f64)]) -> Result<String, DescriptionError> {
    let document: Result<DocumentMut, _> = toml.parse();
    let mut document = document.map_err(|error| DescriptionError::new("", error.to_string().trim_end()))?;
    for (path, number) in settings {
        set(document.as_table_mut(), path, *number)?;
    }
    Ok(document.to_string())
}

fn set(table: &mut dyn TableLike, path: &str, number: f64) -> Result<(), DescriptionError> {
    let (steps, last) = path.rsplit_once('.').map_or((None, path), |(steps, last)| (Some(steps), last));
    let mut place = table;
    for step in steps.into_iter().flat_map(|steps| steps.split('.')) {
        let next = place.entry(step).or_insert_with(|| value(InlineTable::new()));
        let no_table =
            || DescriptionError::new(path, format!("`{step}` is not a table")).because(Cause::NoTable);
        place = next.as_table_like_mut().ok_or_else(no_table)?;
    }
    match place.get_mut(last).and_then(Item::as_value_mut) {
        Some(old) => {
            let decor = old.decor().clone();
            *old = written(number);
            *old.decor_mut() = decor;
        }
        None => drop(place.insert(last, Item::Value(written(number)))),
    }
    Ok(())
}

/// Some numbers must be whole, and those that need not be take whole ones.
fn written(number: f64) -> toml_edit::Value {
    let is_whole = math::round(number) == number && number.abs() < 9e15;
    if is_whole { (number as i64).into() } else { number.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_change_and_words_stay() {
        let toml =
            "# A brain.\n[motor.stroll]\nkind = \"wander\"   # blindly\nutility = { bias = 0.5 }  # some\n";
        let set = |path: &str, number| edited(toml, &[(path.to_owned(), number)]);
        let changed = set("motor.stroll.utility.bias", 0.25).unwrap();
        assert_eq!(changed, toml.replace("0.5", "0.25"));
        let added = set("motor.stroll.parameters.forward", 0.4).unwrap();
        assert!(added.starts_with(toml) && added.contains("parameters = { forward = 0.4 }"), "{added}");
        let whole = set("motor.stroll.utility.bias", 2.0).unwrap();
        assert!(whole.contains("bias = 2 }"), "{whole}");
        let error = set("motor.stroll.kind.bias", 1.0).unwrap_err().to_string();
        assert_eq!(error, "motor.stroll.kind.bias: `kind` is not a table");
    }
}
