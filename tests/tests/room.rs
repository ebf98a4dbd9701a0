//! One room three times: as polygons in the scenario, as a ROS map, as an SVG floor plan. A laser sees the same.

use std::fs;
use std::path::PathBuf;

use baudbot_sim::World;

/// Solid rectangles of the room, in metres: x and y of the lower left corner, width and height. All lie on the grid of
/// the map, 2 cm.
const RECTANGLES: [[f64; 4]; 6] = [
    [-0.1, -0.1, 4.2, 0.1],
    [-0.1, 3.0, 4.2, 0.1],
    [-0.1, 0.0, 0.1, 3.0],
    [4.0, 0.0, 0.1, 3.0],
    [1.0, 1.0, 0.5, 0.3],
    [2.6, 1.9, 0.2, 0.8],
];

const CELL_M: f64 = 0.02;

/// The robot, whose laser looks all around with 720 rays.
const ROBOT: &str = r#"
[[robots]]
name = "scout"
start = { x_m = 2.03, y_m = 0.91, heading_rad = 0.37 }
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }

[robots.sensors.laser]
kind = "laser"
mount = { x_m = 0.0 }
opening_rad = 6.27
rays = 720
range_m = 10.0
port = { link = { kind = "ideal" } }
"#;

#[test]
fn a_ros_map_a_floor_plan_and_polygons_of_a_room_give_the_same_scan_to_1_cm() {
    let folder = folder("room");
    fs::write(folder.join("room.yaml"), "image: room.pgm\nresolution: 0.02\norigin: [-0.1, -0.1, 0.0]\n")
        .unwrap();
    fs::write(folder.join("room.pgm"), pgm()).unwrap();
    fs::write(folder.join("plan.svg"), svg()).unwrap();
    let polygons: String = RECTANGLES.iter().enumerate().map(|(i, r)| polygon(i, r)).collect();
    let drawn = scan(&polygons, &folder);
    let ros = scan("[[arena.maps]]\nname = \"map\"\nros = \"room.yaml\"\n", &folder);
    let plan =
        "[[arena.maps]]\nname = \"plan\"\nsvg = \"plan.svg\"\nm_per_unit = 0.01\norigin_m = [-0.1, -0.1]\n";
    let plan = scan(plan, &folder);
    assert_eq!(drawn.len(), 720);
    assert!(drawn.iter().all(|d| (0.2..4.5).contains(d)), "in a closed room every ray comes back");
    for (i, expected) in drawn.iter().enumerate() {
        assert!((ros[i] - expected).abs() < 0.01, "ray {i}: {} in the map, {expected} drawn", ros[i]);
        assert!((plan[i] - expected).abs() < 0.01, "ray {i}: {} in the plan, {expected} drawn", plan[i]);
    }
}

fn scan(arena: &str, folder: &std::path::Path) -> Vec<f64> {
    let text = format!("{arena}{ROBOT}");
    let text = baudbot_import::inline(&text, folder).unwrap_or_else(|error| panic!("{error}"));
    let mut world =
        World::new(baudbot_scenario::parse(&text).unwrap_or_else(|error| panic!("{error}")).into());
    world.begin();
    world.finish(&[]);
    world.robot(0).sensors().next().unwrap().sample.to_vec()
}

fn polygon(i: usize, [x, y, width, height]: &[f64; 4]) -> String {
    let (right, top) = (x + width, y + height);
    format!(
        "[[arena.polygons]]\nname = \"p{i}\"\npoints_m = [[{x}, {y}], [{right}, {y}], [{right}, {top}], [{x}, {top}]]\n"
    )
}

/// The room from above, 210 by 160 cells, the first row at the top.
fn pgm() -> Vec<u8> {
    let (columns, rows) = (210, 160);
    let mut bytes = format!("P5\n{columns} {rows}\n255\n").into_bytes();
    for row in (0..rows).rev() {
        for column in 0..columns {
            let x = -0.1 + (f64::from(column) + 0.5) * CELL_M;
            let y = -0.1 + (f64::from(row) + 0.5) * CELL_M;
            let inside = |r: &[f64; 4]| x > r[0] && x < r[0] + r[2] && y > r[1] && y < r[1] + r[3];
            bytes.push(if RECTANGLES.iter().any(inside) { 0 } else { 254 });
        }
    }
    bytes
}

/// The room in centimetres, y downwards.
fn svg() -> String {
    let rect = |[x, y, width, height]: &[f64; 4]| {
        let (left, top) = (100.0 * (x + 0.1), 320.0 - 100.0 * (y + 0.1 + height));
        format!("<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\"/>", 100.0 * width, 100.0 * height)
    };
    let rects: String = RECTANGLES.iter().map(rect).collect();
    format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 420 320\">{rects}</svg>")
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}
