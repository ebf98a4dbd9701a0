//! The page of evidence in `docs` is what the program makes.

use std::path::Path;

use baudbot_evidence::page::page;

#[test]
fn docs_evidence_md_and_its_pictures_are_what_the_program_makes() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    for file in page(|_| {}).unwrap() {
        let path = docs.join(&file.path);
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(text == file.text, "{} is not up to date: baudbot evidence --write docs", path.display());
    }
}
