//! The page of evidence in `docs` is what the program makes.

use std::path::Path;

use baudbot_experiment::evidence::known;
use baudbot_experiment::evidence::page::page;
use baudbot_scenario::presets::presets;

#[test]
fn docs_evidence_md_and_its_pictures_are_what_the_program_makes() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    for file in page(|_| {}).unwrap() {
        let path = docs.join(&file.path);
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(text == file.text, "{} is not up to date: baudbot evidence --write docs", path.display());
    }
}

#[test]
fn the_list_of_presets_says_of_each_how_well_it_is_known() {
    const DOCS: &str = include_str!("../../../docs/reference/preset-list.md");
    for preset in presets() {
        let row = format!("| `{}` | {} | {} |", preset.name, preset.description, known(preset));
        assert!(DOCS.contains(&row), "docs/reference/preset-list.md has no row `{row}`");
    }
}
