//! The errors of a map, and the words for them.

use crate::common::{Folder, pgm, png};

const SCENARIO: &str = "[[arena.maps]]\nname = \"map\"\nros = \"map.yaml\"\n";
const YAML: &str = "image: map.pgm\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\n";

fn refused(files: &[(&str, &[u8])]) -> String {
    files.iter().fold(Folder::new(), |folder, (name, bytes)| folder.file(name, bytes)).refused(SCENARIO)
}

fn refused_yaml(yaml: &str) -> String {
    refused(&[("map.yaml", yaml.as_bytes()), ("map.pgm", &pgm(2, &[0, 255]))])
}

fn refused_image(image: &[u8]) -> String {
    refused(&[("map.yaml", YAML.as_bytes()), ("map.pgm", image)])
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn an_entry_that_makes_no_sense() {
    let svg = "name = \"m\"\nsvg = \"p.svg\"\n";
    let cases = [
        ("name = \"m\"", "arena.maps[0]: needs a file"),
        ("name = \"m\"\nros = \"a\"\nsvg = \"b\"", "arena.maps[0]: has both `ros` and `svg`"),
        ("ros = \"a\"", "arena.maps[0]: missing field `name`"),
        ("name = \"a b\"\nros = \"a\"", "arena.maps[0].name: must be 1 to 40 letters"),
        ("name = \"\"\nros = \"a\"", "arena.maps[0].name: must be 1 to 40 letters"),
        (&format!("name = \"{}\"\nros = \"a\"", "x".repeat(41)), "arena.maps[0].name: must be 1 to 40"),
        ("name = \"m\"\nros = \"a\"\nscale = 2", "arena.maps[0].scale: unknown field `scale`"),
        ("name = \"m\"\nros = 3", "arena.maps[0].ros: must be a string, is 3"),
        ("name = \"m\"\nros = \"a\"\nheight_m = inf", "arena.maps[0].height_m: must be finite"),
        (
            "name = \"m\"\nros = \"a\"\nm_per_unit = 1",
            "arena.maps[0].m_per_unit: is for maps with `svg` only",
        ),
        ("name = \"m\"\nros = \"a\"\nunknown = \"wall\"", "arena.maps[0].unknown: must be "),
        (svg, "arena.maps[0].m_per_unit: is missing"),
        (&format!("{svg}m_per_unit = 0"), "arena.maps[0].m_per_unit: must be above 0"),
        (&format!("{svg}m_per_unit = nan"), "arena.maps[0].m_per_unit: must be above 0"),
        (&format!("{svg}m_per_unit = 1\norigin_m = [1]"), "arena.maps[0].origin_m"),
        (&format!("{svg}m_per_unit = 1\norigin_m = [1, inf]"), "arena.maps[0].origin_m: must be within"),
        (&format!("{svg}m_per_unit = 1\ntolerance_m = 0"), "arena.maps[0].tolerance_m: must be from"),
        (&format!("{svg}unknown = \"free\""), "arena.maps[0].unknown: is for maps with `ros` only"),
    ];
    for (entry, expected) in cases {
        assert_says(&Folder::new().refused(&format!("[[arena.maps]]\n{entry}")), &[expected]);
    }
}

#[test]
fn a_list_that_is_none_and_names_that_are_taken() {
    assert_says(&Folder::new().refused("arena.maps = \"x\""), &["arena.maps: must be a list, is \"x\""]);
    assert_says(&Folder::new().refused("arena.maps = [1]"), &["arena.maps[0]: must be a table, is 1"]);
    let twice = format!("{SCENARIO}{SCENARIO}");
    assert_says(
        &Folder::new().refused(&twice),
        &["arena.maps[1].name: arena.maps[0] is also called \"map\""],
    );
    let folder = Folder::with(&[("map.yaml", YAML)]).file("map.pgm", &pgm(1, &[0]));
    let message = folder.refused(&format!("{SCENARIO}[arena.polygons]\nname = \"x\""));
    assert_says(&message, &["arena.polygons: must be a list of tables, is a table"]);
}

#[test]
fn files_that_cannot_be_read() {
    assert_eq!(refused(&[]), "arena.maps[0].ros: map.yaml: there is no such file");
    let message = refused(&[("map.yaml", YAML.as_bytes())]);
    assert_eq!(message, "arena.maps[0].ros: map.pgm: there is no such file");
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("map.yaml")).unwrap();
    assert_says(&folder.refused(SCENARIO), &["map.yaml: is not a file"]);
    assert_says(&refused(&[("map.yaml", b"image: \xff")]), &["map.yaml: is not text in UTF-8"]);
    let message = Folder::new().refused("[[arena.maps]]\nname = \"m\"\nros = \"a\\u0000b\"");
    assert_says(&message, &["arena.maps[0].ros", "cannot be read"]);
}

#[test]
fn a_file_of_more_than_256_mib() {
    let folder = Folder::with(&[("map.yaml", YAML)]);
    // The file has no blocks, only a length.
    let file = std::fs::File::create(folder.path().join("map.pgm")).unwrap();
    file.set_len((256 << 20) + 1).unwrap();
    assert_says(&folder.refused(SCENARIO), &["map.pgm", "has 268435457 bytes", "the limit is 268435456"]);
}

#[test]
fn descriptions_that_make_no_sense() {
    let rest = "origin: [0, 0, 0]\n";
    let cases = [
        ("", "image is missing"),
        (": : :", "is not a description of a map"),
        ("- a\n- b", "is not a description of a map"),
        (&format!("resolution: 0.1\n{rest}"), "image is missing"),
        (&format!("image: map.pgm\n{rest}"), "resolution is missing"),
        (&format!("image: map.pgm\nresolution: 0\n{rest}"), "resolution: must be from 0.0001 to 1000"),
        (&format!("image: map.pgm\nresolution: -0.1\n{rest}"), "is -0.1"),
        (&format!("image: map.pgm\nresolution: .nan\n{rest}"), "resolution: must be"),
        (&format!("image: map.pgm\nresolution: .inf\n{rest}"), "resolution: must be"),
        (&format!("image: map.pgm\nresolution: fine\n{rest}"), "resolution: must be a number, is fine"),
        ("image: map.pgm\nresolution: 1\n", "origin is missing"),
        ("image: map.pgm\nresolution: 1\norigin: [0, 0]\n", "origin: must be [x, y, yaw]"),
        ("image: map.pgm\nresolution: 1\norigin: [0, .nan, 0]\n", "origin: must be within"),
        ("image: map.pgm\nresolution: 1\norigin: [-1e6, 0, 2]\n", "the limit is ±1000000 m"),
        (&format!("{YAML}mode: best\n"), "mode: must be one of trinary, scale, raw, is best"),
        (
            &format!("image: map.pgm\nresolution: 1\nnegate: 2\n{rest}"),
            "negate: must be 0, 1, true or false, is 2",
        ),
        (&format!("{YAML}free_thresh: 0.9\n"), "free_thresh and occupied_thresh: must be from 0 to 1"),
        (&format!("{YAML}occupied_thresh: .nan\n"), "free_thresh and occupied_thresh"),
        (&format!("a: {}", "[".repeat(100_000)), "is not a description of a map"),
    ];
    for (yaml, expected) in cases {
        assert_says(&refused_yaml(yaml), &["arena.maps[0].ros: map.yaml: ", expected]);
    }
}

/// Words that only a user of Rust or of a crate would know.
const FOREIGN: [&str; 14] = [
    "untagged",
    "variant",
    "enum",
    "Policy",
    "Options",
    "from_str",
    "serde",
    "struct",
    "scalar",
    "sequence start",
    "weak",
    "buffer",
    "MAXVAL is",
    "Some(",
];

#[test]
fn no_words_of_libraries() {
    let rest = "resolution: 1\norigin: [0, 0, 0]\n";
    let of = |first: &str| format!("{first}\n{rest}");
    let cases = [
        (of("negate: foo"), "image is missing"),
        (format!("{YAML}resolution: 1\n"), "resolution appears twice: remove one of them"),
        (of("image: [1]"), "image: must be a text, is [1]"),
        (of("image: {a: 1}"), "image: must be a text, is a table"),
        ("image: map.pgm\nresolution: 1\norigin: 3\n".into(), "origin: must be a list of numbers, is 3"),
        ("image: map.pgm\nresolution: 1\norigin: [a, b]\n".into(), "must be a list of numbers, is [a, b]"),
        (YAML.replace("negate: 0", "negate: foo"), "negate: must be 0, 1, true or false, is foo"),
        (YAML.replace("negate: 0", "negate: 300"), "negate: must be 0, 1, true or false, is 300"),
        (YAML.replace("negate: 0", "negate: [0]"), "negate: must be 0, 1, true or false, is [0]"),
        (format!("{YAML}mode: 3\n"), "mode: must be one of trinary, scale, raw, is 3"),
        ("foo".into(), "line 1: must be names with values, such as `resolution: 0.05`"),
        ("- 1".into(), "line 1: must be names with values"),
        ("a: [1".into(), "is not a description of a map: line 1: "),
        ("a: &x [*x]".into(), "line 1: refers to itself"),
        ("image: *foo".into(), "line 1: refers to an anchor that does not exist"),
        (format!("{YAML}---\na: 1\n"), "has more than one document: keep only the first"),
        ("<<: 1\n".into(), "is not a description of a map"),
        ("image: !!binary foo\n".into(), "is not a description of a map"),
        ("%YAML 9\n--- a".into(), "is not a description of a map"),
    ];
    for (yaml, expected) in cases {
        let message = refused_yaml(&yaml);
        assert_says(&message, &["arena.maps[0].ros: map.yaml: ", expected]);
        assert!(FOREIGN.iter().all(|word| !message.contains(word)), "{yaml:?}: {message}");
    }
    for image in [&b"P5\n2 2\n255\nab"[..], b"P5\n2 2\n", b"P2\n2 2\n255\n1 2 3 x", b"\x89PNG\r\n", b"P5\nx"]
    {
        let message = refused_image(image);
        assert!(FOREIGN.iter().all(|word| !message.contains(word)), "{message}");
        assert_says(&message, &["map.pgm: cannot be decoded: ", "; save it again as a grey PGM or a PNG"]);
    }
}

#[test]
fn what_nav2_takes_is_taken() {
    let map = |yaml: &str| {
        let folder = Folder::with(&[("map.yaml", yaml)]).file("map.pgm", &pgm(2, &[0, 255]));
        folder.inline(SCENARIO).unwrap_or_else(|error| panic!("{yaml}: {error}")).into_owned()
    };
    let plain = map(YAML);
    for same in [
        "negate: 0.0",
        "negate: false",
        "negate: no",
        "negate: Off",
        "negate: \"0\"",
        "negate: 00",
        "negate:",
        "",
        "negate: 0\nmode: Trinary",
        "negate: 0\nmode: TRINARY",
        "negate: 0\nmode: \"trinary\"",
        "negate: 0\nmode:",
        "negate: 0\nmode: Scale",
        "negate: 0\nfree_thresh: '0.196'\noccupied_thresh: '0.65'",
        "negate: 0\nextra: {a: [1, {b: 2}]}\nmore: &x [1]\nstill: *x",
    ] {
        assert_eq!(map(&YAML.replace("negate: 0", same)), plain, "{same}");
    }
    let negative = map(&YAML.replace("negate: 0", "negate: 1"));
    assert_ne!(negative, plain);
    for same in ["negate: 1.0", "negate: true", "negate: Yes", "negate: \"1\""] {
        assert_eq!(map(&YAML.replace("negate: 0", same)), negative, "{same}");
    }
}

#[test]
fn an_image_without_a_pixel_is_no_map() {
    for image in [&b"P5\n0 0\n255\n"[..], b"P5\n0 5\n255\n", b"P2\n4 0\n255\n"] {
        assert_says(&refused_image(image), &["map.pgm: has ", " pixels, and no cell: save the map again"]);
    }
}

#[test]
fn images_that_are_cut_short_or_none() {
    let whole = pgm(20, &[0; 200]);
    for length in [3, 12, 30, whole.len() - 1] {
        let message = refused_image(&whole[..length]);
        assert_says(&message, &["arena.maps[0].ros: map.pgm: cannot be decoded: "]);
    }
    assert_says(&refused_image(b"P2\n2 2\n255\n0 0 0"), &["cannot be decoded"]);
    assert_says(&refused_image(b"P2\n2 2\n255\n0 0 0 x"), &["cannot be decoded"]);
    assert_says(&refused_image(b"P5\n2 2\n0\nabcd"), &["cannot be decoded"]);
    let noise: Vec<u8> = (0..200_u8).map(|i| i.wrapping_mul(151) ^ (i >> 2)).collect();
    let whole = png(20, &noise, png::ColorType::Grayscale, png::BitDepth::Eight);
    for length in [8, 20, 40, 80, whole.len() - 30] {
        assert_says(&refused_image(&whole[..length]), &["map.pgm: cannot be decoded: "]);
    }
    for other in [&b""[..], b"GIF89a", b"P6\n1 1\n255\nabc"] {
        assert_says(&refused_image(other), &["map.pgm: is neither a grey PGM (P2 or P5) nor a PNG"]);
    }
}

#[test]
fn no_part_of_an_image_panics() {
    let noise: Vec<u8> = (0..200_u8).map(|i| i.wrapping_mul(151) ^ (i >> 2)).collect();
    let png = png(20, &noise, png::ColorType::Grayscale, png::BitDepth::Eight);
    let folder = Folder::with(&[("map.yaml", YAML)]);
    for image in [pgm(20, &noise), png] {
        for length in 0..image.len() {
            std::fs::write(folder.path().join("map.pgm"), &image[..length]).unwrap();
            let _ = folder.inline(SCENARIO);
        }
    }
}

#[test]
fn huge_images_are_refused_by_their_header() {
    let limits = "the limit is 16384 a side and 67108864 in all";
    assert_says(&refused_image(b"P5\n100000 1\n255\n"), &["has 100000 × 1 pixels", limits]);
    assert_says(&refused_image(b"P2\n1 100000\n255\n"), &["has 1 × 100000 pixels", limits]);
    assert_says(&refused_image(b"P5\n16384 16384\n255\n"), &["has 16384 × 16384 pixels", limits]);
    let mut wide = png(100_000, &[0; 100_000], png::ColorType::Grayscale, png::BitDepth::Eight);
    wide.truncate(wide.len() / 2);
    assert_says(&refused_image(&wide), &["has 100000 × 1 pixels", limits]);
}

#[test]
fn a_map_of_too_many_rectangles() {
    let (width, height) = (640, 320);
    let board: Vec<u8> =
        (0..width * height).map(|i| if (i % width + i / width) % 2 == 0 { 0 } else { 255 }).collect();
    assert_says(&refused_image(&pgm(width, &board)), &["map.pgm", "takes more than 100000 rectangles"]);
}

#[test]
fn maps_that_together_make_too_long_a_text() {
    // A good 80,000 rectangles each.
    let (width, height) = (400, 400);
    let board: Vec<u8> =
        (0..width * height).map(|i| if (i % width + i / width) % 2 == 0 { 0 } else { 255 }).collect();
    let folder = Folder::with(&[("map.yaml", YAML)]).file("map.pgm", &pgm(width, &board));
    let text: String =
        (0..3).map(|i| format!("[[arena.maps]]\nname = \"map{i}\"\nros = \"map.yaml\"\n")).collect();
    assert_says(&folder.refused(&text), &["scenario: with all files in it the text has", "16777216"]);
}
