//! The notes on files that are sound.

use baudbot_import::{Note, Weight};

use crate::common::{Folder, pgm};

/// The notes of a scenario's files, in words.
fn notes(folder: &Folder, scenario: &str) -> Vec<Note> {
    let mut notes = Vec::new();
    baudbot_import::inline_with_notes(scenario, folder.path(), &mut notes).unwrap();
    notes
}

/// The warnings of a map with these cells, its description with these lines at the end.
fn of_map(unknown: &str, lines: &str, samples: &[u8]) -> Vec<String> {
    let yaml = format!("image: map.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n{lines}");
    let folder = Folder::with(&[("map.yaml", &yaml)]).file("map.pgm", &pgm(2, samples));
    let scenario = format!("[[arena.maps]]\nname = \"m\"\nros = \"map.yaml\"\n{unknown}");
    let notes = notes(&folder, &scenario);
    assert!(notes.iter().all(|note| note.weight == Weight::Warning), "{notes:?}");
    notes.iter().map(ToString::to_string).collect()
}

const OCCUPIED: &str = "unknown = \"occupied\"\n";

/// The bytes of nav2's map saver: 205 is an unknown cell.
const SAVED: [u8; 6] = [0, 254, 205, 205, 205, 254];

#[test]
fn unknown_cells_that_there_are_not_are_told_of() {
    let by_nav2 = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\nmode: trinary\n";
    let expected = "arena.maps[0].unknown: map.yaml: no cell is unknown: grey 205 (3 cells) is below free_thresh 0.25; \
                    with a lower one these cells are unknown, 0.196 for instance";
    assert_eq!(of_map(OCCUPIED, by_nav2, &SAVED), [expected]);
    // Other greys, and other ends.
    let [other] = &of_map(OCCUPIED, "free_thresh: 0.25\n", &[0, 230, 230, 240])[..] else { panic!() };
    assert!(other.contains("grey 230 (2 cells) is below free_thresh 0.25"), "{other}");
    let [negative] = &of_map(OCCUPIED, "negate: 1\n", &SAVED)[..] else { panic!() };
    assert!(negative.ends_with("grey 205 (3 cells) is above occupied_thresh 0.65"), "{negative}");
    let [none] = &of_map(OCCUPIED, "", &[0, 254, 255, 0])[..] else { panic!() };
    assert!(none.ends_with("all are black or white, and none can be seen through"), "{none}");
}

#[test]
fn a_map_that_has_unknown_cells_or_is_not_asked_for_them_needs_no_word() {
    assert_eq!(of_map(OCCUPIED, "free_thresh: 0.196\n", &SAVED), [""; 0]);
    assert_eq!(of_map("", "free_thresh: 0.25\n", &SAVED), [""; 0]);
    assert_eq!(of_map("unknown = \"free\"\n", "free_thresh: 0.25\n", &SAVED), [""; 0]);
}
