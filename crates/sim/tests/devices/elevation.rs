//! Rays with an elevation, and things with a lower edge (§3.2.3): against a ray in three dimensions by other means than the world's.

use baudbot_sim::raycast::RayCaster;
use proptest::prelude::*;

use crate::common::refusal;
use crate::devices::scene::{block, first, near, single, wall, with_sensor};

/// A box or a cylinder with a vertical axis, between two heights.
#[derive(Clone, Debug)]
struct Body {
    shape: Shape,
    heights_m: [f64; 2],
}

#[derive(Clone, Debug)]
enum Shape {
    Box([f64; 4]),
    Disc([f64; 3]),
}

impl Body {
    fn toml(&self, i: usize) -> String {
        let [lower, upper] = self.heights_m;
        let edge = if lower > 0.0 { format!("lower_edge_m = {lower:?}\n") } else { String::new() };
        let more = format!("height_m = {upper:?}\n{edge}");
        match self.shape {
            Shape::Box(sides) => block(&format!("b{i}"), sides, &more),
            Shape::Disc([x, y, r]) => {
                format!(
                    "[[arena.circles]]\nname = \"c{i}\"\nx_m = {x:?}\ny_m = {y:?}\nradius_m = {r:?}\n{more}"
                )
            }
        }
    }

    /// How far along a ray of unit length from (0, 0, z) this is met: the ray is cut by pairs of planes, and by the cylinder's wall.
    fn meets(&self, z: f64, direction: [f64; 3]) -> Option<f64> {
        let slab = |from: f64, along: f64, [low, high]: [f64; 2]| {
            if along == 0.0 {
                return if (low..=high).contains(&from) {
                    [f64::NEG_INFINITY, f64::INFINITY]
                } else {
                    [1.0, 0.0]
                };
            }
            let [a, b] = [(low - from) / along, (high - from) / along];
            [a.min(b), a.max(b)]
        };
        let [dx, dy, dz] = direction;
        let upright = slab(z, dz, self.heights_m);
        let sides = match self.shape {
            Shape::Box([x0, y0, x1, y1]) => {
                let (x, y) = (slab(0.0, dx, [x0, x1]), slab(0.0, dy, [y0, y1]));
                [x[0].max(y[0]), x[1].min(y[1])]
            }
            Shape::Disc([x, y, r]) => {
                let (a, b, c) = (dx * dx + dy * dy, dx * x + dy * y, x * x + y * y - r * r);
                let root = (b * b - a * c).sqrt();
                if root.is_nan() { [1.0, 0.0] } else { [(b - root) / a, (b + root) / a] }
            }
        };
        let (enters, leaves) = (upright[0].max(sides[0]), upright[1].min(sides[1]));
        (enters <= leaves && leaves >= 0.0).then(|| enters.max(0.0))
    }
}

fn body() -> impl Strategy<Value = Body> {
    // The robot stands in the middle, and is in none of them.
    let place = (0.3..3.0_f64, -std::f64::consts::PI..std::f64::consts::PI, 0.05..0.8_f64, 0.05..0.8_f64);
    let heights = (prop_oneof![Just(0.0), 0.05..1.0_f64], 0.01..1.0_f64);
    (place, heights, any::<bool>()).prop_map(|((far, angle, w, d), (lower, more), is_box)| {
        let reach = if is_box { w.hypot(d) } else { w };
        let far = 0.25 + reach + far;
        let (x, y) = (far * angle.cos(), far * angle.sin());
        let shape = if is_box { Shape::Box([x - w, y - d, x + w, y + d]) } else { Shape::Disc([x, y, w]) };
        Body { shape, heights_m: [lower, lower + more] }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_ray_with_an_elevation_is_as_long_as_a_ray_in_three_dimensions(
        bodies in prop::collection::vec(body(), 1..8),
        z in 0.0..1.5_f64,
        aim in 0..8_usize,
        spread in -0.3..0.3_f64,
        elevation in prop_oneof![-1.4..1.4_f64, -0.4..0.4_f64],
        range in 0.5..6.0_f64,
    ) {
        let arena: String = bodies.iter().enumerate().map(|(i, body)| body.toml(i)).collect();
        // Most rays are aimed at one of them.
        let (x, y) = match bodies[aim % bodies.len()].shape {
            Shape::Box([x0, y0, x1, y1]) => (0.5 * (x0 + x1), 0.5 * (y0 + y1)),
            Shape::Disc([x, y, _]) => (x, y),
        };
        let heading = y.atan2(x) + spread;
        let sensor = format!(
            "kind = \"sonar\"\nmount = {{ heading_rad = {heading:?} }}\nheight_m = {z:?}\nelevation_rad = {elevation:?}\n\
             opening_rad = 0.0\nrays = 1\nmin_m = 0.0\nmax_m = {range:?}"
        );
        let direction = [elevation.cos() * heading.cos(), elevation.cos() * heading.sin(), elevation.sin()];
        let floor = (elevation < 0.0).then(|| z / -direction[2]);
        let met = bodies.iter().filter_map(|body| body.meets(z, direction)).chain(floor).reduce(f64::min);
        let expected = met.filter(|&far| far <= range).unwrap_or(range);
        let read = single(&with_sensor(&arena, &sensor));
        prop_assert!((read - expected).abs() < 1e-6, "{read} should be {expected}");
    }
}

/// A part of a robot's body, in the robot's frame: within a metre of its centre.
fn part() -> impl Strategy<Value = Body> {
    let place = (-0.45..0.45_f64, -0.45..0.45_f64, 0.02..0.2_f64, 0.02..0.2_f64);
    let heights = (prop_oneof![Just(0.0), 0.05..1.0_f64], 0.01..1.0_f64);
    (place, heights, any::<bool>()).prop_map(|((x, y, w, d), (lower, more), is_box)| {
        let shape = if is_box { Shape::Box([x - w, y - d, x + w, y + d]) } else { Shape::Disc([x, y, w]) };
        Body { shape, heights_m: [lower, lower + more] }
    })
}

/// Its corners, or its centre, in the world.
fn placed(shape: &Shape, [x, y, heading]: [f64; 3]) -> Vec<[f64; 2]> {
    let corners = match *shape {
        Shape::Box([x0, y0, x1, y1]) => vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]],
        Shape::Disc([x, y, _]) => vec![[x, y]],
    };
    let (sin, cos) = heading.sin_cos();
    corners.into_iter().map(|[px, py]| [x + cos * px - sin * py, y + sin * px + cos * py]).collect()
}

/// What reaches from which height to which, as fields.
fn heights(body: &Body) -> String {
    let [lower, upper] = body.heights_m;
    let edge = if lower > 0.0 { format!("lower_edge_m = {lower:?}\n") } else { String::new() };
    format!("height_m = {upper:?}\n{edge}")
}

const OTHER: &str =
    "radius_m = 0.5\nheight_m = 0.2\nmass_kg = 3.0\ninertia_kg_m2 = 0.2\nwheel_radius_m = 0.1\n";

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The oracle is a world in which the robot's body and its parts are things of the arena.
    #[test]
    fn parts_of_a_body_are_seen_as_things_of_the_same_shapes(
        parts in prop::collection::vec(part(), 1..6),
        z in 0.0..1.5_f64,
        (far, angle, turn) in (1.3..3.0_f64, -3.1..3.1_f64, -3.1..3.1_f64),
        spread in -0.3..0.3_f64,
        elevation in prop_oneof![Just(None), (-0.6..0.6_f64).prop_map(Some)],
        kind in 0..3_usize,
    ) {
        let pose = [far * angle.cos(), far * angle.sin(), turn];
        let rising = elevation.map_or(String::new(), |elevation| format!("elevation_rad = {elevation:?}\n"));
        let place =
            format!("mount = {{ heading_rad = {:?} }}\nheight_m = {z:?}\n", angle + spread);
        let sensor = match kind {
            0 => format!("kind = \"sonar\"\n{place}{rising}opening_rad = 0.2\nrays = 5\nmin_m = 0.0\nmax_m = 5.0"),
            1 => format!("kind = \"laser\"\n{place}{rising}opening_rad = 0.6\nrays = 31\nrange_m = 5.0"),
            _ => format!("kind = \"camera\"\n{place}opening_rad = 0.6\ncolumns = 24\nrows = 16\nrange_m = 5.0\nperiod_ms = 1000.0\nport = {{ link = {{ kind = \"ideal\" }} }}"),
        };
        let start = format!("start = {{ x_m = {:?}, y_m = {:?}, heading_rad = {turn:?} }}", pose[0], pose[1]);
        let other = format!("[[robots]]\nname = \"s\"\n{start}\n[robots.body]\n{OTHER}");
        let own: String = parts.iter().map(|part| {
            let shape = match part.shape {
                Shape::Disc([x, y, r]) => format!("x_m = {x:?}\ny_m = {y:?}\nradius_m = {r:?}\n"),
                Shape::Box(_) => format!("outline_m = {:?}\n", placed(&part.shape, [0.0; 3])),
            };
            format!("[[robots.body.parts]]\n{shape}{}", heights(part))
        }).collect();
        let things: String = parts.iter().enumerate().map(|(i, part)| {
            let corners = placed(&part.shape, pose);
            let (table, shape) = match part.shape {
                Shape::Disc([_, _, r]) => {
                    let [x, y] = corners[0];
                    ("circles", format!("x_m = {x:?}\ny_m = {y:?}\nradius_m = {r:?}"))
                }
                Shape::Box(_) => ("polygons", format!("points_m = {corners:?}")),
            };
            format!("[[arena.{table}]]\nname = \"p{i}\"\n{shape}\n{}", heights(part))
        }).collect();
        let with_parts = first(&(with_sensor("", &sensor) + &other + &own));
        let body = format!("[[arena.circles]]\nname = \"body\"\nx_m = {:?}\ny_m = {:?}\nradius_m = 0.5\nheight_m = 0.2\n", pose[0], pose[1]);
        let with_things = first(&with_sensor(&(body + &things), &sensor));
        prop_assert_eq!(with_parts.len(), with_things.len());
        for (i, (a, b)) in with_parts.iter().zip(&with_things).enumerate() {
            prop_assert!((a - b).abs() < 1e-9, "value {}: {} and {}", i, a, b);
        }
    }
}

/// A robot with these parts, and the sonar `s` half a metre above the floor.
fn with_parts(parts: &str, top: &str) -> String {
    with_sensor(top, &sonar(0.5, "")).replacen("body = {", &format!("body = {{ parts = [{parts}],"), 1)
}

/// A mast is seen above the body, by others only, and is run into by nobody.
#[test]
fn a_mast_is_seen_above_its_body_and_hinders_nobody() {
    let mast = |x_m: f64| {
        format!("[[robots.body.parts]]\nx_m = {x_m:?}\nradius_m = 0.05\nlower_edge_m = 0.2\nheight_m = 0.8\n")
    };
    let other = |parts: &str| {
        format!("[[robots]]\nname = \"s\"\nstart = {{ x_m = 1.0 }}\n[robots.body]\n{OTHER}{parts}")
    };
    let read =
        |height_m, parts: &str| single(&(with_sensor(&wall(3.0), &sonar(height_m, "")) + &other(parts)));
    near(read(0.5, ""), 3.0);
    near(read(0.5, &mast(0.0)), 0.95);
    near(read(0.1, &mast(0.0)), 0.5);
    near(read(0.9, &mast(0.0)), 3.0);
    // Its own mast, before its eye, hides nothing from a robot.
    near(single(&with_parts("{ x_m = 0.1, radius_m = 0.05 }", &wall(3.0))), 3.0);
    // An arm that reaches through the other robot.
    let arm = "[[robots.body.parts]]\noutline_m = [[-0.95, -0.02], [0.0, -0.02], [0.0, 0.02], [-0.95, 0.02]]\nlower_edge_m = 0.1\n";
    let mut world = crate::common::world(&(with_sensor("", &sonar(0.5, "")) + &other(arm)));
    world.begin();
    world.finish(&[]);
    assert!(world.robots().all(|robot| !robot.collided()));
}

/// A table of 0.7 m whose plate is 0.05 m thick, one metre ahead.
fn table() -> String {
    block("table", [1.0, -0.5, 2.0, 0.5], "height_m = 0.7\nlower_edge_m = 0.65")
}

fn sonar(height_m: f64, elevation: &str) -> String {
    format!(
        "kind = \"sonar\"\nmount = {{}}\nheight_m = {height_m:?}\n{elevation}opening_rad = 0.0\nrays = 1\nmin_m = 0.0\nmax_m = 4.0"
    )
}

/// §3.2.3, elevation: level rays see under a table and over it, and those that rise meet its underside.
#[test]
fn a_sonar_sees_under_a_table() {
    let read = |height_m, elevation: &str| {
        single(&with_sensor(&(table() + &wall(3.0)), &sonar(height_m, elevation)))
    };
    near(read(0.3, ""), 3.0);
    near(read(0.67, ""), 1.0);
    near(read(0.8, ""), 3.0);
    let up = 0.35_f64.atan2(1.5);
    near(read(0.3, &format!("elevation_rad = {up:?}\n")), 0.35_f64.hypot(1.5));
    let down = -0.1_f64.atan2(1.2);
    near(read(0.8, &format!("elevation_rad = {down:?}\n")), 0.1_f64.hypot(1.2));
}

/// Pictures and pages show rays from above.
#[test]
fn a_ray_that_is_cast_runs_along_the_floor() {
    let up_rad = 0.35_f64.atan2(1.5);
    let sensor = sonar(0.3, &format!("elevation_rad = {up_rad:?}\n"));
    let cast = |top: &str| {
        let world = crate::common::world(&with_sensor(top, &sensor));
        let spec = world.robot(0).spec().clone();
        RayCaster::new(&world).sees(0, &spec.sensors[0])[0]
    };
    near(cast(&table()).distance_m.unwrap(), 1.5);
    near(cast(&table()).length_m(), 1.5);
    let free = cast("");
    assert_eq!(free.distance_m, None);
    near(free.length_m(), 4.0 * up_rad.cos());
    near(free.end().x, 4.0 * up_rad.cos());
}

/// §3.2.3, elevation: an IR sensor that looks down tells the floor from an edge, by (3.13) with the length of its rays.
#[test]
fn other_ray_sensors_look_down_to_the_floor() {
    let down = -std::f64::consts::FRAC_PI_4;
    let place = format!(
        "mount = {{}}\nheight_m = 0.05\nelevation_rad = {down:?}\nopening_rad = 0.0\nrays = 1\nrange_m = 1.0\n"
    );
    let length_m = 0.05 * 2.0_f64.sqrt();
    near(single(&with_sensor("", &format!("kind = \"laser\"\n{place}"))), length_m);
    let ir = format!("kind = \"ir\"\n{place}c1_m2 = 0.001\nc2 = 0.1\n");
    near(single(&with_sensor("", &ir)), 0.001 / (length_m * length_m) + 0.1);
}

#[test]
fn a_wrong_elevation_is_refused() {
    let refused = |text: &str, problem: &str| {
        let found = refusal(text);
        assert!(found.contains(problem), "{found}");
    };
    refused(
        &with_sensor("", &sonar(0.3, "elevation_rad = 1.6\n")),
        "elevation_rad: must be between -1.5 and 1.5, is 1.6",
    );
    let part = |part: &str| with_parts(part, "");
    refused(&part("{ height_m = 0.5 }"), "robots[0].body.parts[0]: needs either `outline_m`, or `radius_m`");
    refused(
        &part("{ radius_m = 0.3, x_m = 0.2 }"),
        "robots[0].body.parts[0]: reaches 0.5 m from the robot's centre, and may reach 0.4 m",
    );
    refused(
        &part("{ radius_m = 0.1, height_m = 0.1, lower_edge_m = 0.2 }"),
        "robots[0].body.parts[0].lower_edge_m: must be at most `height_m`, 0.1, is 0.2",
    );
    refused(&part(&"{ radius_m = 0.1 }, ".repeat(65)), "robots[0].body.parts: there are 65, the limit is 64");
    let round: Vec<_> =
        (0..2100).map(|i| 0.00299 * f64::from(i)).map(|a| [0.1 * a.cos(), 0.1 * a.sin()]).collect();
    refused(
        &part(&format!("{{ outline_m = {round:?} }}, ").repeat(2)),
        "robots[0].body.parts: have 4200 corners together, the limit is 4096",
    );
    refused(
        &with_sensor("", &format!("{}\nwall_range_m = 5.0", sonar(0.3, "elevation_rad = 0.1\n"))),
        "elevation_rad: not with `wall_range_m`",
    );
    refused(
        &with_sensor("", &format!("{}\ncross_talk = true", sonar(0.3, "elevation_rad = 0.1\n"))),
        "elevation_rad: not with `cross_talk`",
    );
    let sensed = "[metrics]\ncell_m = 0.1\nsensed_by = \"s\"\n[[arena.polygons]]\nname = \"room\"\nsolid = false\n\
                  points_m = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]\n";
    refused(
        &with_sensor(sensed, &sonar(0.3, "elevation_rad = 0.1\n")),
        "metrics.sensed_by: the rays of `s` have an elevation",
    );
    refused(
        &with_sensor("", "kind = \"light\"\nbearing_rad = 0.0\nrange_lux = 100.0\nelevation_rad = 0.1"),
        "elevation_rad: a sensor of kind `light` has none",
    );
    refused(
        &with_sensor(
            &block("shelf", [1.0, -0.5, 2.0, 0.5], "height_m = 0.5\nlower_edge_m = 0.6"),
            &sonar(0.3, ""),
        ),
        "arena.polygons[0].lower_edge_m: must be at most `height_m`, 0.5, is 0.6",
    );
}
