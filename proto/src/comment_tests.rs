//! A test of the contract's comments: they are the documentation of every language.

use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, iter};

/// The words of a unit, by the ending of a field's name.
const UNITS: &[(&str, &[&str])] = &[
    ("_m", &["metre"]),
    ("_m2", &["square metre"]),
    ("_rad", &["radian"]),
    ("_s", &["second"]),
    ("_ns", &["nanosecond"]),
    ("_hz", &["hertz", "per simulated second", "per second"]),
    ("_bytes", &["byte"]),
];

/// A field as it stands in a file.
struct Field {
    place: String,
    line: String,
    comment: String,
}

/// The fields of a file, each with the comment above it.
fn fields(file: &Path) -> Vec<Field> {
    let text = fs::read_to_string(file).unwrap();
    let (mut comment, mut found) = (String::new(), Vec::new());
    for (number, line) in iter::zip(1.., text.lines().map(str::trim)) {
        if let Some(words) = line.strip_prefix("//") {
            comment += words;
        } else {
            // Values of enumerations have no units, and begin with a capital letter.
            let declares = line.ends_with(';') && line.contains(" = ") && !line.starts_with("option ");
            let is_field = declares && line.starts_with(char::is_lowercase) && !line.starts_with("syntax");
            if is_field {
                let place = format!("{}:{number}", file.display());
                found.push(Field { place, line: line.to_owned(), comment: comment.trim().to_owned() });
            }
            comment.clear();
        }
    }
    found
}

/// The complaint about a field's comment, if there is one.
fn complaint(field: &Field) -> Option<String> {
    let Field { line, comment, .. } = field;
    let declared = line.split(" = ").next().unwrap_or_default();
    let name = declared.rsplit(' ').next().unwrap_or_default();
    let units: BTreeMap<_, _> = UNITS.iter().copied().collect();
    let ending = name.rfind('_').map_or("", |place| &name[place..]);
    if let Some(words) = units.get(ending).filter(|words| !words.iter().any(|word| comment.contains(word))) {
        return Some(format!("its unit is not named: {}", words[0]));
    }
    if declared.starts_with("optional ") && !["bsent", "mpty"].iter().any(|word| comment.contains(word)) {
        return Some("what its absence means is not said".to_owned());
    }
    if declared.starts_with("bool ") && !comment.to_lowercase().contains("true") {
        return Some("what `true` means is not said".to_owned());
    }
    (comment.split_whitespace().count() < 3).then(|| "its meaning is not said".to_owned())
}

#[test]
fn each_field_has_a_meaning_a_unit_and_a_word_for_its_absence() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("baudbot/v1");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let fields: Vec<_> = files.flat_map(|file| fields(&file)).collect();
    assert!(fields.len() > 500, "{}", fields.len());
    let bad: Vec<_> = fields
        .iter()
        .filter_map(|field| Some(format!("{} {}: {}", field.place, field.line, complaint(field)?)))
        .collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
