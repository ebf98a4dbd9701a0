//! The shapes that the elements of an SVG become.

use baudbot_import::Weight;

use crate::common::{Folder, Polygon};

const SCENARIO: &str = "[[arena.maps]]\nname = \"p\"\nsvg = \"p.svg\"\nm_per_unit = 1\n";

fn drawing(elements: &str) -> Folder {
    let svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' \
         viewBox='0 0 10 10'>{elements}</svg>"
    );
    Folder::with(&[("p.svg", &svg)])
}

fn polygons(elements: &str) -> Vec<Polygon> {
    drawing(elements).polygons(SCENARIO)
}

#[track_caller]
fn one(elements: &str) -> Polygon {
    let [one] = <[Polygon; 1]>::try_from(polygons(elements)).unwrap();
    one
}

fn refused(elements: &str) -> String {
    drawing(elements).refused(SCENARIO)
}

#[test]
fn fill_and_ends_decide_what_a_path_is() {
    let cases = [
        ("<path d='M0 0H2V2Z'/>", true, true),
        ("<path d='M0 0H2V2Z' fill='none'/>", false, true),
        ("<path d='M0 0H2V2Z' fill='none' stroke='red'/>", false, true),
        ("<path d='M0 0H2V2Z' style='fill:none;stroke:none'/>", false, true),
        ("<path d='M0 0H2V2Z' fill-opacity='0'/>", false, true),
        ("<g fill='none'><path d='M0 0H2V2Z'/></g>", false, true),
        ("<style>.x{fill:none}</style><path class='x' d='M0 0H2V2Z'/>", false, true),
        ("<path d='M0 0H2V2'/>", false, false),
        ("<path d='M0 0H2V2' fill='none'/>", false, false),
        ("<path d='M0 0H2V2L0 0'/>", true, true),
        ("<polyline points='0,0 2,0 2,2'/>", false, false),
        ("<polygon points='0,0 2,0 2,2'/>", true, true),
        (
            "<polygon points='0,0 2,0 2,2' clip-path='url(#no)' mask='url(#no)' marker-end='url(#no)'/>",
            true,
            true,
        ),
    ];
    for (element, solid, closed) in cases {
        let found = one(element);
        assert_eq!((found.solid, found.closed), (solid, closed), "{element}");
        assert_eq!(found.points, [[0.0, 10.0], [2.0, 10.0], [2.0, 8.0]], "{element}");
    }
    let line = one("<line x1='1' y1='2' x2='3' y2='2'/>");
    assert_eq!((line.points, line.solid, line.closed), (vec![[1.0, 8.0], [3.0, 8.0]], false, false));
}

#[test]
fn hidden_and_unused_shapes_are_left_out() {
    let elements = "<rect width='1' height='1' display='none'/><rect width='1' height='1' visibility='hidden'/>\
        <defs><rect id='r' width='1' height='1'/></defs><text y='3'>x</text><image href='/etc/hostname'/>\
        <path d='M1 1'/><path d='M1 1z'/><rect/>";
    assert_eq!(polygons(&elements.replace("<path d='M1 1z'/>", "")), []);
}

#[test]
fn transforms_and_references_are_followed() {
    let found = polygons(
        "<defs><rect id='r' width='1' height='2'/></defs><use xlink:href='#r' x='3'/>\
         <g transform='translate(5 5) scale(2) rotate(90)'><use href='#r'/></g>",
    );
    assert_eq!(found[0].points, [[3.0, 10.0], [4.0, 10.0], [4.0, 8.0], [3.0, 8.0]]);
    assert_eq!(found[1].points, [[5.0, 5.0], [5.0, 3.0], [1.0, 3.0], [1.0, 5.0]]);
}

#[test]
fn a_circle_is_as_round_as_the_tolerance_says() {
    let folder = drawing("<circle cx='5' cy='5' r='2'/>");
    let mut corners = Vec::new();
    for (text, tolerance) in [("", 0.005), ("tolerance_m = 0.0001", 0.0001), ("tolerance_m = 0.1", 0.1)] {
        let [circle] = <[Polygon; 1]>::try_from(folder.polygons(&format!("{SCENARIO}{text}"))).unwrap();
        assert!(circle.solid && circle.closed);
        let ends = circle.points.iter().cycle().skip(1);
        for (a, b) in circle.points.iter().zip(ends) {
            let from_center = |x: f64, y: f64| (x - 5.0).hypot(y - 5.0);
            // The curves of which the circle is made are not quite circles themselves.
            let most = tolerance + 1e-3;
            assert!((from_center(a[0], a[1]) - 2.0).abs() < most, "{a:?}");
            assert!(
                (from_center((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0) - 2.0).abs() < most,
                "{a:?} {b:?}"
            );
        }
        corners.push(circle.points.len());
    }
    assert!(corners[2] < corners[0] && corners[0] < corners[1], "{corners:?}");
}

#[test]
fn units_are_those_of_the_view_box_and_pixels_without() {
    let size = |root: &str| {
        let svg =
            format!("<svg xmlns='http://www.w3.org/2000/svg' {root}><rect width='2' height='1'/></svg>");
        Folder::with(&[("p.svg", &svg)]).polygons(SCENARIO)[0].points.clone()
    };
    let upper_left = |y: f64| vec![[0.0, y], [2.0, y], [2.0, y - 1.0], [0.0, y - 1.0]];
    assert_eq!(size("viewBox='0 0 30 10' width='210mm' height='5in'"), upper_left(10.0));
    assert_eq!(size("width='100%' preserveAspectRatio='none' viewBox='0 0 30 10'"), upper_left(10.0));
    assert_eq!(size("width='30' height='20px'"), upper_left(20.0));
}

#[test]
fn edges_of_no_length_are_dropped() {
    assert_eq!(one("<path d='M0 0H2H2V2L2 2L0 0Z'/>").points, [[0.0, 10.0], [2.0, 10.0], [2.0, 8.0]]);
    assert_eq!(one("<path d='M0 0H2H2.0000001V2Z'/>").points.len(), 3, "a tenth of a micrometre");
}

#[test]
fn outlines_of_one_path_are_shapes_of_their_own() {
    let found = polygons("<path d='M0 0h1v1zM5 5h1v1zM7 7h1'/>");
    let kinds: Vec<_> = found.iter().map(|p| (p.name.as_str(), p.solid, p.closed)).collect();
    assert_eq!(kinds, [("p-0", true, true), ("p-1", true, true), ("p-2", false, false)]);
    // The inner one runs the same way round: it is no hole, but filled twice.
    assert_eq!(polygons("<path d='M0 0h9v9h-9zM1 1h1v1h-1z'/>").len(), 2);
    assert_eq!(polygons("<path fill='none' d='M0 0h9v9h-9zM1 1v1h1v-1z'/>").len(), 2);
}

#[test]
fn shapes_that_cannot_be_solid() {
    let file = "arena.maps[0].svg: p.svg: ";
    let bow_tie = "<path id='tie' d='M0 0L4 4V0L0 4Z'/>";
    assert!(refused(bow_tie).starts_with(&format!("{file}the shape `tie` crosses or touches itself")));
    let second = refused(&format!("<rect width='1' height='1'/>{}", bow_tie.replace("id='tie'", "")));
    assert!(second.starts_with(&format!("{file}shape 1, counted from 0, crosses")), "{second}");
    let flat = refused("<polygon id='flat' points='0,0 4,0'/>");
    assert_eq!(flat, format!("{file}the shape `flat` is filled and has 2 corners, needs 3 or more"));
}

#[test]
fn shapes_that_are_too_large() {
    let many: String = (0..4097).map(|i| format!("{},{} ", i, (i % 2) * 3)).collect();
    let message = refused(&format!("<polyline id='long' points='{many}'/>"));
    assert!(message.contains("the shape `long` has more than 4096 corners in a row"), "{message}");
    let message = refused("<path d='M0 0L1e7 0'/>");
    assert!(message.contains("shape 0, counted from 0, reaches (10000000, 10)"), "{message}");
    let message = refused("<path d='M0 0C1e30 0 0 1e30 1 1'/>");
    assert!(message.contains("the limit is ±1000000 m"), "{message}");
    let dots = "M0 0h1v1z".repeat(1001);
    let message = refused(&format!("<path d='{dots}'/>"));
    assert!(message.contains("has 1001 closed outlines, the limit is 1000"), "{message}");
}

#[test]
fn files_that_are_no_drawing() {
    let refused = |text: &str| Folder::with(&[("p.svg", text)]).refused(SCENARIO);
    let cases = [
        ("", "is not XML"),
        ("no drawing", "is not XML"),
        ("<svg", "is not XML"),
        ("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1 1'>", "is not XML"),
        ("<html/>", "is not an SVG: its outermost element is `html`"),
        ("<svg/>", "has neither a viewBox nor width and height"),
        ("<svg width='100%' height='100%'/>", "has neither a viewBox nor width and height"),
        ("<svg viewBox='0 0 0 1'/>", "viewBox"),
        ("<svg viewBox='wide'/>", "viewBox"),
        ("<svg xmlns='http://www.w3.org/2000/svg' width='-1' height='1'/>", "is not a valid SVG"),
        ("<svg viewBox='0 0 1 1'>\n<path id='a' d='M0 0L1,x'/></svg>", "line 2, `d`: "),
        ("<svg viewBox='0 0 1 1'>\n\n<g transform='turn(3)'/></svg>", "line 3, `transform`: "),
        ("<svg viewBox='0 0 1 1'><polygon points='0,0 1,0 1,l'/></svg>", "line 1, `points`: "),
    ];
    for (text, expected) in cases {
        let message = refused(text);
        assert!(message.starts_with("arena.maps[0].svg: p.svg: "), "{message}");
        assert!(message.contains(expected), "{expected:?} is not in {message:?}");
    }
}

#[test]
fn deep_nesting_and_references_to_oneself_end() {
    for (name, attribute) in [("g", " transform='scale(1)'"), ("svg", ""), ("pattern", "")] {
        for depth in [100, 1000, 50_000] {
            let (open, close) =
                (format!("<{name}{attribute}>").repeat(depth), format!("</{name}>").repeat(depth));
            let found = drawing(&format!("{open}<rect width='1' height='1'/>{close}")).inline(SCENARIO);
            assert_eq!(found.is_ok(), depth <= 1000, "{depth} times {name}: {found:?}");
        }
    }
    let _ = drawing("<g id='a'><use href='#a'/><rect width='1' height='1'/></g>").inline(SCENARIO);
    let levels: String =
        (1..20).map(|i| format!("<g id='g{i}'><use href='#g{}'/><use href='#g{0}'/></g>", i - 1)).collect();
    let _ = drawing(&format!("<rect id='g0' width='1' height='1'/>{levels}")).inline(SCENARIO);
}

/// The first corner of each polygon, and whether it is solid.
fn kinds(found: &[Polygon]) -> Vec<([f64; 2], bool)> {
    found.iter().map(|polygon| (polygon.points[0], polygon.solid)).collect()
}

#[test]
fn what_has_a_hole_becomes_its_outer_and_its_inner_outline() {
    let expected = [([0.0, 10.0], false), ([1.0, 9.0], false)];
    for ring in
        ["<path d='M0 0h9v9h-9zM1 1v7h7v-7z'/>", "<path fill-rule='evenodd' d='M0 0h9v9h-9zM1 1h7v7h-7z'/>"]
    {
        let found = polygons(ring);
        assert!(found.iter().all(|polygon| polygon.closed), "{ring}");
        assert_eq!(kinds(&found), expected, "{ring}");
    }
    // An island in the hole, and a room beside.
    let islands = "<path fill-rule='evenodd' d='M0 0h9v9h-9zM1 1h7v7h-7zM3 3h1v1h-1z M9.2 9.2h.5v.5h-.5z'/>";
    let solid: Vec<_> = polygons(islands).iter().map(|polygon| polygon.solid).collect();
    assert_eq!(solid, [false, false, true, true]);
}

/// Layers in Inkscape's form, classes, and colours by attributes, styles and style sheets.
const LAYERS: &str = "<style>.door { stroke: rgb(0, 128, 0); fill: none }</style>\
    <g id='layer1' inkscape:groupmode='layer' inkscape:label='Walls 1' xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape'>\
      <path id='north' d='M0 0H9' stroke='black'/><g><path d='M0 9H9' style='stroke:#000'/></g></g>\
    <g id='route' stroke='red' fill='none'><path id='r1' d='M1 1L2 2'/><path class='door big' id='d1' d='M3 3L4 4'/></g>\
    <rect id='zone' x='5' y='5' width='1' height='1' fill='#ff0'/><use href='#zone' id='copy' x='2'/>";

fn chosen(lines: &str) -> Vec<[f64; 2]> {
    let found = drawing(LAYERS).polygons(&format!("{SCENARIO}{lines}"));
    found.iter().map(|polygon| polygon.points[0]).collect()
}

#[test]
fn shapes_are_chosen_by_layer_id_class_and_colour() {
    let [north, south, route, door, zone, copy] =
        [[0.0, 10.0], [0.0, 1.0], [1.0, 9.0], [3.0, 7.0], [5.0, 5.0], [7.0, 5.0]];
    assert_eq!(chosen(""), [north, south, route, door, zone, copy]);
    for (lines, expected) in [
        ("only = [\"layer=Walls 1\"]", vec![north, south]),
        ("only = [\"layer=Walls*\", \"id=zone\"]", vec![north, south, zone, copy]),
        ("only = [\"stroke=black\"]", vec![north, south]),
        ("only = [\"stroke=#f00\"]", vec![route]),
        ("only = [\"stroke=#008000\"]", vec![door]),
        ("only = [\"stroke=none\"]", vec![zone, copy]),
        ("only = [\"fill=yellow\"]", vec![zone, copy]),
        ("only = [\"fill=none\"]", vec![route, door]),
        ("only = [\"class=door\"]", vec![door]),
        ("only = [\"id=route\"]\nwithout = [\"class=big\"]", vec![route]),
        ("without = [\"id=route\", \"fill=#FFFF00\"]", vec![north, south]),
        ("without = [\"id=copy\"]", vec![north, south, route, door, zone]),
    ] {
        assert_eq!(chosen(lines), expected, "{lines}");
    }
    let refused = drawing(LAYERS).refused(&format!("{SCENARIO}only = [\"id=zone\", \"walls\"]"));
    assert!(
        refused.starts_with("arena.maps[0].only[1]: must be layer=NAME, id=NAME, class=NAME"),
        "{refused}"
    );
}

/// The notes of a drawing, without what each begins with; warnings have a mark.
fn notes(elements: &str, lines: &str) -> Vec<String> {
    let mut notes = Vec::new();
    let folder = drawing(elements);
    baudbot_import::inline_with_notes(&format!("{SCENARIO}{lines}"), folder.path(), &mut notes).unwrap();
    let told = notes.into_iter().map(|note| {
        let mark = if note.weight == Weight::Warning { "! " } else { "" };
        format!("{mark}{}: {}", note.path.trim_start_matches("arena.maps[0]."), note.text)
    });
    told.collect()
}

#[test]
fn what_is_left_out_is_told() {
    assert_eq!(
        notes(LAYERS, "only = [\"layer=Walls*\"]"),
        ["svg: left out: 4 shapes by `only` and `without` (`r1`, `d1`, `zone`, `shape 5`)"]
    );
    let [idle] = &notes(LAYERS, "without = [\"layer=Wals\"]")[..] else { panic!("one note") };
    assert_eq!(idle, "! without: `layer=Wals` chooses no shape; their layers are `Walls 1`, `route`");
    assert_eq!(
        notes(
            "<rect width='1' height='1'/><rect opacity='0' width='1' height='1'/><text>a</text><image href='a.png'/>",
            ""
        ),
        ["svg: left out: 1 shape that can be seen through; 1 image; 1 text"]
    );
    assert_eq!(
        notes("<image href='a.png'/>", ""),
        [
            "svg: left out: 1 image",
            "! svg: there is no wall but what is left out: 1 image; draw walls as lines or shapes"
        ]
    );
    assert_eq!(notes("<path d='M0 0H1'/>", ""), [""; 0]);
}

#[test]
fn a_filled_shape_that_covers_everything_is_told_of() {
    let room = "<rect id='room' width='9.9' height='9.9' fill='white' stroke='black'/>";
    let small = room.replace("9.9", "5").replace("/>", " x='1' y='1'/>");
    let table = "<path d='M2 2h1v1h-1z'/>";
    for covering in [room.to_owned(), format!("{room}{table}"), format!("{table}{small}")] {
        let told = notes(&covering, "");
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(
            told[0]
                .starts_with("! svg: the shape `room` is filled and covers everything, so nothing is free"),
            "{told:?}"
        );
    }
    for sound in [room.replace("white", "none"), small, table.repeat(2).replacen("M2 2", "M5 5", 1)] {
        assert_eq!(notes(&sound, ""), [""; 0], "{sound}");
    }
}

#[test]
fn what_can_be_seen_through_is_not_there() {
    for hidden in [
        "<g opacity='0'><g><path d='M0 0H1'/></g></g>",
        "<path style='opacity:0' d='M0 0H1'/>",
        "<path opacity='0%' d='M0 0H1'/>",
    ] {
        assert_eq!(polygons(hidden), [], "{hidden}");
    }
    assert_eq!(polygons("<path opacity='0.1' d='M0 0H1'/>").len(), 1);
}

#[test]
fn clip_paths_keep_what_is_inside_and_refuse_what_they_cut() {
    let clip = "<clipPath id='c'><rect x='2' y='2' width='4' height='4'/></clipPath>";
    let within = |shape: &str| format!("{clip}<g clip-path='url(#c)'>{shape}</g>");
    let count = |shape: &str| polygons(&within(shape)).len();
    assert_eq!(count("<rect x='3' y='3' width='1' height='1'/>"), 1);
    assert_eq!(count("<rect x='2' y='2' width='4' height='4'/>"), 1, "its edge is within");
    assert_eq!(count("<rect x='7' y='7' width='1' height='1'/>"), 0);
    assert_eq!(
        notes(&within("<path d='M7 7h1M3 3h1'/><path d='M8 8h1'/>").replace("M7 7h1", ""), "").len(),
        1
    );
    for cut in ["<rect id='x' x='1' y='3' width='2' height='1'/>", "<path id='x' d='M1 3H7'/>"] {
        let message = refused(&within(cut));
        assert!(message.contains("the shape `x` is cut by its clip path: cut it in the editor"), "{message}");
    }
    // The clip is moved together with its group, and scaled by the shape's own size.
    let moved = format!("{clip}<g transform='translate(3 0)'><path clip-path='url(#c)' d='M3 3h1'/></g>");
    assert_eq!(polygons(&moved).len(), 1);
    let own = "<clipPath id='c' clipPathUnits='objectBoundingBox'><rect width='1' height='1'/></clipPath>\
               <rect clip-path='url(#c)' x='7' y='1' width='2' height='2'/>";
    assert_eq!(polygons(own).len(), 1);
}

const ROBOT: &str = "[[robots]]\nname = \"r\"\nstart.heading_rad = 1.0\n";

#[test]
fn shapes_with_ids_become_places_if_that_is_asked_for() {
    let plan = "<path d='M0 0H9'/><circle id='start' cx='2' cy='3' r='0.2'/>\
                <g id='goal' transform='translate(1 0)'><rect x='6' y='6' width='1' height='2'/><path d='M6 6H7'/></g>";
    let folder = drawing(plan);
    assert_eq!(folder.polygons(SCENARIO).len(), 4, "else they are walls");
    let asked = format!("{SCENARIO}starts = {{ r = \"start\" }}\ngoal = \"goal\"\n{ROBOT}");
    assert_eq!(folder.polygons(&asked).len(), 1);
    let table: toml::Table = folder.inline(&asked).unwrap().parse().unwrap();
    let number = |value: &toml::Value, name: &str| value[name].as_float().unwrap();
    let start = &table["robots"][0]["start"];
    assert_eq!([number(start, "x_m"), number(start, "y_m"), number(start, "heading_rad")], [2.0, 7.0, 1.0]);
    let goal = &table["end"]["goal"];
    assert_eq!([number(goal, "x_m"), number(goal, "y_m"), number(goal, "radius_m")], [7.5, 3.0, 0.5]);
    for (lines, expected) in [
        ("starts = { r = \"home\" }\n", "has no shape with the id `home`, which `starts.r` names"),
        ("starts = { s = \"start\" }\n", "arena.maps[0].starts.s: there is no robot `s`"),
        (
            "goal = \"goal\"\n[end]\ngoal = { x_m = 0.0, y_m = 0.0, radius_m = 1.0 }\n",
            "arena.maps[0].goal: the scenario has an `end.goal`",
        ),
    ] {
        let message = folder.refused(&format!("{SCENARIO}{lines}{ROBOT}"));
        assert!(message.contains(expected), "{message}");
    }
    let twice = folder.refused(&format!("{SCENARIO}starts = {{ r = \"start\" }}\n{ROBOT}start.x_m = 1.0\n"));
    assert!(twice.contains("the robot has a `start` of its own"), "{twice}");
}
