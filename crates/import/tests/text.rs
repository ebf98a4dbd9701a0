//! The treatment of the rest of the text.

use std::borrow::Cow;

use crate::common::{Folder, pgm, polygons};
use proptest::prelude::*;

const YAML: &str = "image: map.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n";

fn folder() -> Folder {
    Folder::with(&[("map.yaml", YAML), ("s.csv", "distance_m,reading\n1,1\n2,2\n")])
        .file("map.pgm", &pgm(3, &[0, 255, 0]))
}

#[test]
fn a_text_without_files_comes_back_as_it_is() {
    let texts = [
        "",
        "# nothing\n",
        "arena = 3",
        "robots = 3",
        "robots = [3, { sensors = 4 }]",
        "[arena]\npolygons = []",
        "[[robots]]\n[robots.sensors.a]\nlookup = { distances_m = [1, 2] }",
        "this is = = no TOML",
        include_str!("../../../catalogue/scenarios/khepera.toml"),
    ];
    for text in texts {
        let found = folder().inline(text).unwrap();
        assert!(matches!(found, Cow::Borrowed(found) if found == text), "{text}");
    }
}

#[test]
fn shapes_come_behind_those_that_are_there_and_all_else_stays() {
    let text = r#"# head
name = "x" # a name

[[arena.polygons]]
name = "first"
points_m = [[0, 0], [1, 0], [1, 1]]

[[arena.maps]]
name = "map"
ros = "map.yaml"
height_m = 1.5

# a pillar
[[arena.circles]]
name = "pillar"

[[robots]]
name = "a"
[robots.sensors.z]
lookup = "s.csv" # measured
[robots.sensors.a]
kind = "compass"
"#;
    let expected = r#"# head
name = "x" # a name

[[arena.polygons]]
name = "first"
points_m = [[0, 0], [1, 0], [1, 1]]

[[arena.polygons]]
name = "map-0"
points_m = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
solid = true
height_m = 1.5

[[arena.polygons]]
name = "map-1"
points_m = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0]]
solid = true
height_m = 1.5

# a pillar
[[arena.circles]]
name = "pillar"

[[robots]]
name = "a"
[robots.sensors.z]
lookup = { distances_m = [1.0, 2.0], samples = [[[1.0]], [[2.0]]] } # measured
[robots.sensors.a]
kind = "compass"
"#;
    assert_eq!(folder().inline(text).unwrap(), expected);
}

#[test]
fn shapes_without_others_come_where_the_map_stood() {
    let text = "[arena] # here\n\n# the map\n[[arena.maps]]\nname = \"m\"\nros = \"map.yaml\"\n\n[end]\nafter_s = 3\n";
    let found = folder().inline(text).unwrap().into_owned();
    assert!(
        found.starts_with("[arena] # here\n\n# the map\n[[arena.polygons]]\nname = \"m-0\"\n"),
        "{found}"
    );
    assert!(found.ends_with("\n\n[end]\nafter_s = 3\n"), "{found}");
}

#[test]
fn every_way_to_write_the_lists_is_understood() {
    let map = "{ name = \"m\", ros = \"map.yaml\" }";
    let polygon = "{ name = \"p\", points_m = [[0, 0], [1, 1]] }";
    let texts = [
        format!("arena = {{ maps = [{map}] }}"),
        format!("arena = {{ polygons = [{polygon}], maps = [{map}] }}"),
        format!("arena.maps = [{map}]\narena.polygons = [{polygon}]\n[[robots]]\nname = \"x\""),
        format!("arena.maps = [{map}]\n[[robots]]\nname = \"x\""),
        format!("[arena]\nmaps = [{map}]\n[[arena.polygons]]\nname = \"p\"\npoints_m = [[0, 0], [1, 1]]"),
        format!(
            "[arena]\npolygons = [\n  {polygon}, # one\n]\n[[arena.maps]]\nname = \"m\"\nros = \"map.yaml\""
        ),
        "[[arena.maps]]\nname = \"m\"\nros = \"map.yaml\"\n[[robots]]\nname = \"x\"\n[arena]\n".to_owned(),
    ];
    for text in texts {
        let found = folder().inline(&text).unwrap().into_owned();
        let names: Vec<_> = polygons(&found).into_iter().map(|polygon| polygon.name).collect();
        let expected: &[&str] =
            if text.contains("points_m") { &["p", "m-0", "m-1"] } else { &["m-0", "m-1"] };
        assert_eq!(names, expected, "{text}\n{found}");
        let table: toml::Table = found.parse().unwrap();
        assert!(table["arena"].get("maps").is_none(), "{found}");
        assert!(matches!(folder().inline(&found).unwrap(), Cow::Borrowed(_)), "nothing is left to do");
    }
}

#[test]
fn an_empty_list_of_maps_is_taken_out() {
    assert_eq!(folder().inline("[arena]\nmaps = []\n").unwrap(), "[arena]\n");
}

#[test]
fn a_file_may_have_an_absolute_name() {
    let folder = folder();
    let file = folder.path().join("map.yaml");
    let text = format!("[[arena.maps]]\nname = \"m\"\nros = {:?}\n", file.to_str().unwrap());
    let elsewhere = Folder::new();
    assert_eq!(elsewhere.polygons(&text).len(), 2);
}

proptest! {
    /// Files whose content is nearly right.
    #[test]
    fn nothing_panics(
        yaml in "(image: f\n)?(resolution: [-.0-9a-z]{1,4}\n)?(origin: \\[[-0-9., ]{0,9}\\]\n)?(mode: [a-z]{1,3})?\\PC{0,9}",
        svg in "<svg viewBox='0 0 [0-9]{1,3} 9'>(<path d='[MLHVCQAZmz0-9 .-]{0,40}'/>|<rect width='[0-9e.]{1,4}' height='3'/>|<circle r='[0-9e]{1,3}'/>){0,3}(</svg>)?",
        csv in "(distance_m,reading|angle_rad,distance_m,reading)\n([-0-9e.]{1,4},[0-9a\"]{1,3}(,[0-9.]{1,3})?\n){0,5}",
        image in proptest::collection::vec(any::<u8>(), 0..40),
    ) {
        let folder = Folder::with(&[("a.yaml", &yaml), ("a.svg", &svg), ("a.csv", &csv)]).file("f", &image);
        let _ = folder.inline("[[arena.maps]]\nname = \"m\"\nros = \"a.yaml\"");
        let _ = folder.inline("[[arena.maps]]\nname = \"m\"\nsvg = \"a.svg\"\nm_per_unit = 0.1");
        let _ = folder.inline("[[robots]]\nsensors.x.lookup = \"a.csv\"");
    }
}
