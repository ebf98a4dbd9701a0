//! Flat shapes and what stands on them, as triangles.

use baudbot_proto::v1;
use foxglove::messages::{Color, CylinderPrimitive, Point3, TriangleListPrimitive};

use super::parts::{point, pose_at, vector};

/// Corners of an outline in metres, in a frame that goes without saying.
pub(super) type Corners = Vec<[f64; 2]>;

/// Corners in order, none twice in a row; none at all if one of them is nowhere.
pub(super) fn corners(points: &[v1::Point]) -> Corners {
    let mut corners: Corners = points.iter().map(|point| [point.x_m, point.y_m]).collect();
    if corners.iter().flatten().any(|value| !value.is_finite()) {
        return Corners::new();
    }
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    corners
}

/// A disc's rim as corners.
pub(super) fn circle(radius_m: f64) -> Corners {
    const SIDES: usize = 48;
    let corner = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / SIDES as f64).sin_cos();
        [radius_m * cos, radius_m * sin]
    };
    (0..SIDES).map(corner).collect()
}

/// Corners at a height, for a line around them.
pub(super) fn raised(corners: &[[f64; 2]], z_m: f64) -> Vec<Point3> {
    corners.iter().map(|&[x, y]| point(x, y, z_m)).collect()
}

/// A column on the floor.
pub(super) fn column(
    [x_m, y_m]: [f64; 2],
    radius_m: f64,
    bottom_m: f64,
    top_m: f64,
    color: Color,
) -> CylinderPrimitive {
    let width_m = 2.0 * radius_m;
    CylinderPrimitive {
        pose: Some(pose_at(x_m, y_m, 0.5 * (bottom_m + top_m))),
        size: Some(vector(width_m, width_m, top_m - bottom_m)),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    }
}

/// An outline pulled up from one height to another: its sides, its roof, and its underside unless that is on the floor.
pub(super) fn prism(corners: &[[f64; 2]], span_m: [f64; 2], color: Color) -> TriangleListPrimitive {
    let corners = counter_clockwise(corners);
    let mut sides = sides(&corners, true, span_m, color);
    let (count, roof) = (corners.len() as u32, triangles(&corners));
    if span_m[0] > 0.0 {
        // Seen from below it runs the other way round.
        sides.indices.extend(roof.iter().rev());
    }
    sides.indices.extend(roof.iter().map(|corner| corner + count));
    sides
}

/// A flat shape at a height.
pub(super) fn plate(corners: &[[f64; 2]], z_m: f64, color: Color) -> TriangleListPrimitive {
    let corners = counter_clockwise(corners);
    list(raised(&corners, z_m), triangles(&corners), color)
}

/// Walls without thickness along a chain of corners, from one height to another.
pub(super) fn sides(
    corners: &[[f64; 2]],
    closed: bool,
    [bottom_m, top_m]: [f64; 2],
    color: Color,
) -> TriangleListPrimitive {
    let count = corners.len() as u32;
    let points = [raised(corners, bottom_m), raised(corners, top_m)].concat();
    let edges = if closed { count } else { count.saturating_sub(1) };
    let side = |i: u32| {
        let next = (i + 1) % count;
        [i, next, next + count, i, next + count, i + count]
    };
    list(points, (0..edges).flat_map(side).collect(), color)
}

fn list(points: Vec<Point3>, indices: Vec<u32>, color: Color) -> TriangleListPrimitive {
    let pose = Some(pose_at(0.0, 0.0, 0.0));
    TriangleListPrimitive { pose, points, color: Some(color), colors: Vec::new(), indices }
}

fn counter_clockwise(corners: &[[f64; 2]]) -> Corners {
    let next = corners.iter().cycle().skip(1);
    let twice_area: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let mut corners = corners.to_vec();
    if twice_area < 0.0 {
        corners.reverse();
    }
    corners
}

/// The inside of an outline that runs counter-clockwise and does not cross itself, as triangles of its corners: ears are
/// cut off until nothing is left. Of what crosses itself, or is beyond all patience, a part stays open.
fn triangles(corners: &[[f64; 2]]) -> Vec<u32> {
    let mut ring = Ring::new(corners);
    let mut triangles = Vec::with_capacity(3 * corners.len().saturating_sub(2));
    let (mut at, mut in_vain, mut patience) = (0, 0, MOST_TESTS);
    while ring.left.len() >= 3 && in_vain < ring.left.len() && patience > 0 {
        at %= ring.left.len();
        patience = patience.saturating_sub(1 + ring.reflex.len());
        let (ear, [a, b, c]) = (ring.ear(at), ring.around(at));
        match ear {
            Ear::None => (at, in_vain) = (at + 1, in_vain + 1),
            Ear::Flat | Ear::Full => {
                if matches!(ear, Ear::Full) {
                    triangles.extend([a as u32, b as u32, c as u32]);
                }
                ring.cut(at);
                in_vain = 0;
            }
        }
    }
    triangles
}

/// Tests of a corner against a triangle: a building's plan must not keep a recorder for seconds.
const MOST_TESTS: usize = 10_000_000;

/// Corners of which triangles have not been made yet.
struct Ring<'a> {
    corners: &'a [[f64; 2]],
    left: Vec<usize>,
    /// The corners at which the outline turned inwards: only they can be in an ear's way.
    reflex: Vec<usize>,
}

enum Ear {
    None,
    /// A corner that is none.
    Flat,
    Full,
}

impl<'a> Ring<'a> {
    fn new(corners: &'a [[f64; 2]]) -> Self {
        let mut ring = Self { corners, left: (0..corners.len()).collect(), reflex: Vec::new() };
        ring.reflex = (0..corners.len()).filter(|&i| ring.bend(ring.around(i)) <= 0.0).collect();
        ring
    }

    /// The corner at a place, between its neighbours.
    fn around(&self, at: usize) -> [usize; 3] {
        let count = self.left.len();
        [self.left[(at + count - 1) % count], self.left[at], self.left[(at + 1) % count]]
    }

    /// Twice the area of a triangle, positive if it runs counter-clockwise.
    fn bend(&self, [a, b, c]: [usize; 3]) -> f64 {
        cross(self.corners[a], self.corners[b], self.corners[c])
    }

    fn ear(&self, at: usize) -> Ear {
        let triangle = self.around(at);
        let bend = self.bend(triangle);
        if bend == 0.0 {
            return Ear::Flat;
        }
        let [a, b, c] = triangle.map(|i| self.corners[i]);
        let is_in_the_way = |&i: &usize| {
            let p = self.corners[i];
            p != a
                && p != b
                && p != c
                && [cross(a, b, p), cross(b, c, p), cross(c, a, p)].iter().all(|&s| s >= 0.0)
        };
        if bend < 0.0 || self.reflex.iter().any(is_in_the_way) { Ear::None } else { Ear::Full }
    }

    fn cut(&mut self, at: usize) {
        let gone = self.left.remove(at);
        self.reflex.retain(|&i| i != gone);
    }
}

fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area that triangles cover, which must all run counter-clockwise.
    fn area(corners: &[[f64; 2]]) -> f64 {
        let found = triangles(corners);
        let areas = found.chunks_exact(3).map(|t| {
            let area = 0.5 * cross(corners[t[0] as usize], corners[t[1] as usize], corners[t[2] as usize]);
            assert!(area > 0.0, "{t:?} runs clockwise");
            area
        });
        areas.sum()
    }

    #[test]
    fn triangles_cover_an_outline_with_hooks_and_corners_that_are_none() {
        let hook = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [3.0, 1.0], [0.0, 1.0]];
        assert!((area(&hook) - 7.0).abs() < 1e-12);
        let star: Corners = (0..200)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 200.0).sin_cos();
                let reach = if i % 2 == 0 { 1.0 } else { 0.3 };
                [reach * cos, reach * sin]
            })
            .collect();
        let expected = 100.0 * 0.3 * (std::f64::consts::TAU / 200.0).sin();
        assert!((area(&star) - expected).abs() < 1e-9, "{}, {expected}", area(&star));
    }

    #[test]
    fn what_crosses_itself_or_is_flat_ends_too() {
        triangles(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]);
        assert!(triangles(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).is_empty());
        assert!(triangles(&[]).is_empty());
        assert!(triangles(&[[1.0, 1.0]]).is_empty());
    }

    #[test]
    fn a_prism_has_sides_and_a_roof_whichever_way_its_corners_run() {
        let clockwise = [[0.0, 0.0], [0.0, 1.0], [2.0, 1.0], [2.0, 0.0]];
        let prism = prism(&clockwise, [0.0, 0.5], Color::default());
        assert_eq!(prism.points.len(), 8);
        assert_eq!(prism.indices.len(), 3 * (2 * 4 + 2));
        assert!(prism.indices.iter().all(|&i| i < 8));
        let roof = &prism.indices[24..];
        assert!(roof.iter().all(|&i| prism.points[i as usize].z == 0.5), "{roof:?}");
        // Normals of the sides point outwards: away from the middle.
        for t in prism.indices[..24].chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| &prism.points[i as usize]);
            let (u, v) = ([b.x - a.x, b.y - a.y, b.z - a.z], [c.x - a.x, c.y - a.y, c.z - a.z]);
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2]];
            let outwards = [(a.x + b.x + c.x) / 3.0 - 1.0, (a.y + b.y + c.y) / 3.0 - 0.5];
            assert!(normal[0] * outwards[0] + normal[1] * outwards[1] > 0.0, "{t:?}");
        }
    }

    #[test]
    fn an_open_wall_does_not_close() {
        let wall = sides(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], false, [0.0, 1.0], Color::default());
        assert_eq!(wall.indices.len(), 2 * 6);
    }

    #[test]
    fn corners_that_are_nowhere_are_none() {
        let at = |x_m, y_m| v1::Point { x_m, y_m };
        assert!(corners(&[at(0.0, 0.0), at(f64::NAN, 1.0), at(1.0, 1.0)]).is_empty());
        let ring = [at(0.0, 0.0), at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 0.0)];
        assert_eq!(corners(&ring), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    }
}
