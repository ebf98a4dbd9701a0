//! The entries of `arena.maps` become entries of `arena.polygons`.

mod clip;
mod description;
mod drawing;
mod entry;
mod mapped;
mod marks;
mod outlines;
mod problem;
mod raster;
mod ros;
mod select;
mod shape;
mod svg;

use std::path::Path;

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

use self::entry::{Entry, Raw, Source};
use self::mapped::Mapped;
use self::marks::Mark;
use crate::error::ImportError;
use crate::note::Note;

/// Replaces the maps of a scenario. Returns whether it has any.
pub(crate) fn inline(
    document: &mut DocumentMut,
    base: &Path,
    notes: &mut Vec<Note>,
) -> Result<bool, ImportError> {
    let Some(arena) = document.get_mut("arena").and_then(Item::as_table_like_mut) else { return Ok(false) };
    let Some(maps) = arena.remove("maps") else { return Ok(false) };
    let first = maps.as_array_of_tables().and_then(|maps| maps.get(0)).cloned();
    let (mut shapes, mut marks) = (Vec::new(), Vec::new());
    for (i, entry) in entries(maps)?.iter().enumerate() {
        shapes.extend(tables(entry, &format!("{PATH}[{i}]"), base, (notes, &mut marks))?);
    }
    append(arena, shapes, first)?;
    marks.iter().try_for_each(|(path, mark)| mark.put(document, path))?;
    Ok(true)
}

/// The checked entries of the list.
fn entries(maps: Item) -> Result<Vec<Entry>, ImportError> {
    let Ok(maps) = maps.into_value() else { return Ok(Vec::new()) };
    // The reader whose errors are in words of TOML reads values without their places in the text.
    let mut table: toml::Table = toml::from_str(&format!("maps = {maps}")).expect("it is TOML");
    let maps = table.remove("maps").expect("it is there");
    let raw: Vec<Raw> = baudbot_fields::read(maps)
        .map_err(|error| ImportError::field(format!("{PATH}{}", error.path), error.problem))?;
    let mut entries: Vec<Entry> = Vec::new();
    for (i, raw) in raw.into_iter().enumerate() {
        let path = format!("{PATH}[{i}]");
        let entry = raw.check(&path)?;
        if let Some(other) = entries.iter().position(|other| other.name == entry.name) {
            let problem = format!("{PATH}[{other}] is also called {:?}: names must differ", entry.name);
            return Err(ImportError::field(format!("{path}.name"), problem));
        }
        entries.push(entry);
    }
    Ok(entries)
}

/// The tables that replace the entry at `path`.
fn tables(
    entry: &Entry,
    path: &str,
    base: &Path,
    (notes, marks): (&mut Vec<Note>, &mut Vec<(String, Mark)>),
) -> Result<Vec<Table>, ImportError> {
    let (file, Mapped { shapes, notes: of_file, marks: of_drawing }) = match &entry.source {
        Source::Ros { file, unknown } => {
            (file, ros::shapes(&base.join(file), *unknown).map_err(|error| error.at(format!("{path}.ros")))?)
        }
        Source::Svg { file, plan } => {
            (file, svg::shapes(&base.join(file), plan).map_err(|error| error.at(format!("{path}.svg")))?)
        }
    };
    notes.extend(of_file.into_iter().map(|note| note.of(path, Path::new(file))));
    marks.extend(of_drawing.into_iter().map(|mark| (path.to_owned(), mark)));
    let named = shapes.iter().enumerate();
    Ok(named.map(|(i, shape)| shape.table(&format!("{}-{i}", entry.name), entry.height_m)).collect())
}

/// Puts the tables behind the polygons that are there, in the form that these have. If there are none, they
/// come where the first map stood, below its comments.
fn append(arena: &mut dyn TableLike, tables: Vec<Table>, first: Option<Table>) -> Result<(), ImportError> {
    if tables.is_empty() {
        return Ok(());
    }
    let entry = arena.entry("polygons");
    let item = entry.or_insert_with(|| match first {
        Some(_) => Item::ArrayOfTables(ArrayOfTables::new()),
        None => Item::Value(Array::new().into()),
    });
    match item {
        Item::ArrayOfTables(polygons) => {
            let is_new = polygons.is_empty();
            polygons.extend(tables);
            if let (true, Some(first), Some(top)) = (is_new, first, polygons.get_mut(0)) {
                top.set_position(first.position());
                *top.decor_mut() = first.decor().clone();
            }
        }
        Item::Value(Value::Array(polygons)) => {
            polygons.extend(tables.into_iter().map(Table::into_inline_table));
        }
        Item::None | Item::Value(_) | Item::Table(_) => {
            let problem = format!("must be a list of tables, is a {}", item.type_name());
            return Err(ImportError::field("arena.polygons", problem));
        }
    }
    Ok(())
}

const PATH: &str = "arena.maps";
