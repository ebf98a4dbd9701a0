//! Lists of tables, in either of TOML's forms.

use toml_edit::{Item, TableLike, Value};

/// The tables of a list, and where in the list they are.
pub(crate) fn of(list: &mut Item) -> Vec<(usize, &mut dyn TableLike)> {
    match list {
        Item::ArrayOfTables(list) => {
            list.iter_mut().map(|table| table as &mut dyn TableLike).enumerate().collect()
        }
        Item::Value(Value::Array(list)) => {
            let tables = list.iter_mut().enumerate();
            tables
                .filter_map(|(i, value)| Some((i, value.as_inline_table_mut()? as &mut dyn TableLike)))
                .collect()
        }
        Item::None | Item::Value(_) | Item::Table(_) => Vec::new(),
    }
}
