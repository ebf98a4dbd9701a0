//! What becomes of the elements of an SVG.

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
    let ring = "<path id='ring' d='M0 0h9v9h-9zM1 1v7h7v-7z'/>";
    assert!(
        refused(ring).contains("the shape `ring` has a hole with a corner at (1, 9) m"),
        "{}",
        refused(ring)
    );
    let even_odd = refused("<path fill-rule='evenodd' d='M0 0h9v9h-9zM1 1h1v1h-1z'/>");
    assert!(even_odd.contains("has a hole with a corner at"), "{even_odd}");
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
