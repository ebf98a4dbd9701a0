//! Measured readings.

use crate::common::Folder;

const SCENARIO: &str = "\
[[robots]]
name = \"a\"

[[robots]]
name = \"b\"
[robots.sensors.front]
kind = \"ir\"
lookup = \"s.csv\" # measured in May
rays = 5
";

fn lookup(csv: &str) -> toml::Value {
    let folder = Folder::with(&[("s.csv", csv)]);
    let table: toml::Table = folder.inline(SCENARIO).unwrap().parse().unwrap();
    table["robots"][1]["sensors"]["front"]["lookup"].clone()
}

fn refused(csv: &str) -> String {
    Folder::with(&[("s.csv", csv)]).refused(SCENARIO)
}

#[test]
fn samples_are_sorted_by_distance_and_angle() {
    let found = lookup(
        "reading, distance_m, angle_rad\n0.5,0.2,0.1\n0.4,0.2,-0.1\n\n1,0.1,-0.1\n0.9,0.1,0.1\n0.8,1e-1,0.1\n",
    );
    let expected = "distances_m = [0.1, 0.2]\nangles_rad = [-0.1, 0.1]\n\
        samples = [[[1.0], [0.9, 0.8]], [[0.4], [0.5]]]";
    assert_eq!(found.as_table().unwrap(), &expected.parse::<toml::Table>().unwrap());
}

#[test]
fn without_angles_a_distance_has_one_list() {
    let found = lookup("\u{feff}distance_m,reading\r\n0,3\r\n-0,4\r\n2,5\r\n");
    let expected = "distances_m = [0.0, 2.0]\nsamples = [[[3.0, 4.0]], [[5.0]]]";
    assert_eq!(found.as_table().unwrap(), &expected.parse::<toml::Table>().unwrap());
}

#[test]
fn robots_and_sensors_may_be_written_inline() {
    let folder = Folder::with(&[("s.csv", "distance_m,reading\n1,1\n2,2\n")]);
    let text = "robots = [ 3, { name = \"x\", sensors = { f = { kind = \"ir\", lookup = \"s.csv\" } } } ]";
    let expected = "robots = [ 3, { name = \"x\", sensors = { f = { kind = \"ir\", lookup = \
        { distances_m = [1.0, 2.0], samples = [[[1.0]], [[2.0]]] } } } } ]";
    let found: toml::Table = folder.inline(text).unwrap().parse().unwrap();
    assert_eq!(found, expected.parse::<toml::Table>().unwrap());
    std::fs::remove_file(folder.path().join("s.csv")).unwrap();
    let message = folder.refused(text);
    assert_eq!(message, "robots[1].sensors.f.lookup: s.csv: there is no such file");
}

#[test]
fn what_is_wrong_is_named() {
    let cases = [
        ("", "is empty: the first line names the columns"),
        ("distance_m,reading\n", "has samples at 0 distances, needs 2 or more"),
        ("distance_m,reading\n1,2\n1,3\n", "has samples at 1 distances, needs 2 or more"),
        ("distance_m,angle_rad\n1,2\n", "column reading is missing; there are distance_m, angle_rad"),
        ("reading\n1\n", "column distance_m is missing; there are reading"),
        ("distance_m,reading,angle\n1,2,3\n", "column `angle` is none of distance_m, angle_rad, reading"),
        ("distance_m,reading,reading\n1,2,3\n", "column reading appears more than once"),
        ("distance_m,reading\n1,2\n\n2,far\n", "line 4, column reading: `far` is not a finite number"),
        ("distance_m,reading\n1,2\n,2\n", "line 3, column distance_m: `` is not a finite number"),
        ("distance_m,reading\nnan,2\n", "line 2, column distance_m: `nan` is not a finite number"),
        ("distance_m,angle_rad,reading\n1,inf,2\n", "line 2, column angle_rad: `inf` is not"),
        ("distance_m,reading\n1,2\n1,2,3\n", "line 3: has 3 columns, the header has 2"),
        (
            "distance_m,angle_rad,reading\n1,0,1\n1,0.5,1\n2,0,1\n",
            "has no sample at distance_m = 2, angle_rad = 0.5",
        ),
    ];
    for (csv, expected) in cases {
        let message = refused(csv);
        let start = "robots[1].sensors.front.lookup: s.csv: ";
        assert!(message.starts_with(&format!("{start}{expected}")), "{expected:?} is not in {message:?}");
    }
    let message = Folder::new().file("s.csv", b"distance_m,reading\n1,\xff\n").refused(SCENARIO);
    assert!(message.ends_with("s.csv: line 2: is not text in UTF-8"), "{message}");
}
