//! One room, drawn in every way there is.

use crate::common::{Folder, Polygon, is_taken, pgm, png, polygons};

/// 4 m by 3 m with walls 0.2 m thick, a table, and a gap in the right wall. The lower left corner is at
/// (-1, 0.5) when nothing is turned.
const BY_HAND: &str = r#"
[arena]
polygons = [
    { name = "left", points_m = [[-1, 0.5], [-0.8, 0.5], [-0.8, 3.5], [-1, 3.5]] },
    { name = "bottom", points_m = [[-0.8, 0.5], [3, 0.5], [3, 0.7], [-0.8, 0.7]] },
    { name = "top", points_m = [[-0.8, 3.3], [3, 3.3], [3, 3.5], [-0.8, 3.5]] },
    { name = "right", points_m = [[2.8, 0.7], [3, 0.7], [3, 1.5], [2.8, 1.5]] },
    { name = "table", points_m = [[0.4, 1.7], [1.2, 1.7], [1.2, 2.7], [0.8, 2.7], [0.8, 2.1], [0.4, 2.1]] },
]
"#;

const PLAN: &str = r#"<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm" viewBox="10 20 400 300">
  <style>.wall { fill: #333 }</style>
  <g transform="translate(10 20)" class="wall">
    <rect width="20" height="300"/>
    <g transform="translate(20 0)">
      <rect y="280" width="380" height="20" stroke="red"/>
      <path d="m 0,0 h 380 v 20 h -380 z"/>
    </g>
    <rect x="380" y="200" width="20" height="80"/>
    <polygon id="table" points="140,180 220,180 220,80 180,80 180,140 140,140"/>
  </g>
</svg>"#;

const CELL: f64 = 0.1;
const COLUMNS: usize = 40;
const ROWS: usize = 30;

/// The image's samples, made from the room as it stands in the text.
fn samples(taken: u8, free: u8) -> Vec<u8> {
    let room = polygons(BY_HAND);
    let cells = (0..ROWS).rev().flat_map(|row| (0..COLUMNS).map(move |column| (column, row)));
    let middle = |i: usize| (i as f64 + 0.5) * CELL;
    cells
        .map(|(column, row)| is_taken(&room, -1.0 + middle(column), 0.5 + middle(row)))
        .map(|is_taken| if is_taken { taken } else { free })
        .collect()
}

fn yaml(image: &str, yaw: f64, negate: u8) -> String {
    format!(
        "image: {image}\nresolution: 0.1\norigin: [-1.0, 0.5, {yaw}]\nnegate: {negate}\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\nfriend: unknown to us\n"
    )
}

fn of_ros(image: &str, bytes: &[u8], yaw: f64, negate: u8) -> Vec<Polygon> {
    let folder = Folder::new().file(image, bytes).file("room.yaml", yaml(image, yaw, negate).as_bytes());
    folder.polygons("[[arena.maps]]\nname = \"room\"\nros = \"room.yaml\"\n")
}

/// Compares the areas at points that are nowhere on an edge. `found` is turned by `yaw` about the lower
/// left corner.
fn assert_is_the_room(found: &[Polygon], yaw: f64) {
    let room = polygons(BY_HAND);
    let mut taken = 0;
    for i in 0..90 {
        for j in 0..70 {
            let (u, v) = (-0.26 + f64::from(i) * 0.0503, -0.27 + f64::from(j) * 0.0507);
            let expected = is_taken(&room, -1.0 + u, 0.5 + v);
            let (x, y) = (u * yaw.cos() - v * yaw.sin() - 1.0, u * yaw.sin() + v * yaw.cos() + 0.5);
            assert_eq!(is_taken(found, x, y), expected, "at ({u}, {v}) from the corner: {found:?}");
            taken += usize::from(expected);
        }
    }
    assert!(taken > 500, "{taken} points in walls prove little");
}

#[test]
fn a_plan_covers_the_room() {
    let folder = Folder::with(&[("plan.svg", PLAN)]);
    let found = folder.polygons(
        "[[arena.maps]]\nname = \"plan\"\nsvg = \"plan.svg\"\nm_per_unit = 0.01\norigin_m = [-1, 0.5]\n",
    );
    assert_eq!(found.len(), 5);
    assert_eq!(
        found[0].points,
        [[-1.0, 3.5], [-0.8, 3.5], [-0.8, 0.5], [-1.0, 0.5]],
        "exact, but for the order"
    );
    assert_is_the_room(&found, 0.0);
}

#[test]
fn maps_of_every_form_of_image_cover_the_room() {
    let plain = samples(0, 254);
    let wide = |samples: &[u8]| samples.iter().flat_map(|&sample| [sample, sample]).collect::<Vec<u8>>();
    let text = |samples: &[u8]| samples.iter().map(|sample| format!("{sample} ")).collect::<String>();
    let colors: Vec<u8> = plain.iter().flat_map(|&sample| [sample, sample, sample, 255]).collect();
    let header = |magic: &str, white: u32| format!("{magic}\n{COLUMNS} {ROWS}\n{white}\n").into_bytes();
    let (grey, rgba) = (png::ColorType::Grayscale, png::ColorType::Rgba);
    let images = [
        ("binary.pgm", pgm(COLUMNS, &plain)),
        ("wide.pgm", [header("P5", 65535), wide(&plain)].concat()),
        ("text.pgm", [header("P2", 255), text(&plain).into_bytes()].concat()),
        ("dim.pgm", [header("P2", 10), text(&samples(0, 10)).into_bytes()].concat()),
        ("grey.png", png(COLUMNS, &plain, grey, png::BitDepth::Eight)),
        ("wide.png", png(COLUMNS, &wide(&plain), grey, png::BitDepth::Sixteen)),
        ("color.png", png(COLUMNS, &colors, rgba, png::BitDepth::Eight)),
    ];
    for (name, bytes) in images {
        for yaw in [0.0, 0.7, -2.5] {
            println!("{name}, yaw {yaw}");
            let found = of_ros(name, &bytes, yaw, 0);
            assert!(found.len() < 10, "{} rectangles are not few", found.len());
            assert_is_the_room(&found, yaw);
        }
    }
}

#[test]
fn a_negative_image_is_the_same_room() {
    assert_is_the_room(&of_ros("n.pgm", &pgm(COLUMNS, &samples(255, 0)), 0.0, 1), 0.0);
}

#[test]
fn a_map_and_a_plan_can_stand_in_one_scenario() {
    let folder = Folder::with(&[("plan.svg", PLAN), ("room.yaml", &yaml("room.pgm", 0.0, 0))])
        .file("room.pgm", &pgm(COLUMNS, &samples(0, 254)));
    let found = folder.polygons(
        "[[arena.maps]]\nname = \"a\"\nros = \"room.yaml\"\nheight_m = 2\n\
         [[arena.maps]]\nname = \"b\"\nsvg = \"plan.svg\"\nm_per_unit = 0.01\norigin_m = [-1, 0.5]\n",
    );
    let (a, b): (Vec<_>, Vec<_>) = found.into_iter().partition(|polygon| polygon.name.starts_with("a-"));
    assert_is_the_room(&a, 0.0);
    assert_is_the_room(&b, 0.0);
    assert!(a.iter().all(|polygon| polygon.height_m == Some(2.0)));
    assert!(b.iter().all(|polygon| polygon.height_m.is_none()));
    assert_eq!(b[4].name, "b-4");
}

#[test]
fn unknown_cells_are_what_the_scenario_says() {
    // Occupied, free, and between the two.
    let folder =
        Folder::with(&[("m.yaml", "image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: false\n")])
            .file("m.pgm", &pgm(3, &[0, 254, 205]));
    let columns = |text: &str| {
        let found = folder.polygons(&format!("[[arena.maps]]\nname = \"m\"\nros = \"m.yaml\"\n{text}"));
        [0.5, 1.5, 2.5].map(|x| is_taken(&found, x, 0.5))
    };
    assert_eq!(columns(""), [true, false, false]);
    assert_eq!(columns("unknown = \"free\""), [true, false, false]);
    assert_eq!(columns("unknown = \"occupied\""), [true, false, true]);
}

#[test]
fn modes_and_clear_pixels_are_judged_as_documented() {
    let judged = |mode: &str, image: &[u8], unknown: &str| {
        let yaml = format!("image: m\nresolution: 1\norigin: [0, 0, 0]\nmode: {mode}\n");
        let folder = Folder::with(&[("m.yaml", &yaml)]).file("m", image);
        let found = folder
            .polygons(&format!("[[arena.maps]]\nname = \"m\"\nros = \"m.yaml\"\nunknown = \"{unknown}\""));
        [0.5, 1.5, 2.5].map(|x| is_taken(&found, x, 0.5))
    };
    let raw = pgm(3, &[100, 0, 255]);
    assert_eq!(judged("raw", &raw, "free"), [true, false, false]);
    assert_eq!(judged("raw", &raw, "occupied"), [true, false, true]);
    let half_clear = png(3, &[0, 255, 255, 255, 0, 0], png::ColorType::GrayscaleAlpha, png::BitDepth::Eight);
    for mode in ["trinary", "scale"] {
        assert_eq!(judged(mode, &half_clear, "free"), [true, false, false]);
        assert_eq!(judged(mode, &half_clear, "occupied"), [true, false, true]);
    }
}
