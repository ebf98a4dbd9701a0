//! Rays with an elevation, and things with a lower edge (§3.2.3): against a ray in three dimensions by other means than the world's.

use proptest::prelude::*;

use crate::common::refusal;
use crate::devices::scene::{block, near, single, wall, with_sensor};

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
