//! The scene as a camera and rays with an elevation see it (Section 3.2.3): things between two heights, and the floor.
//!
//! A ray rises by tan ε for each metre on the floor. It meets a thing's side where it crosses the outline between the two heights, the top or the underside of a filled
//! one where it comes to that height over the outline's inside, and the floor at z = 0.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Ray, Segment, math, polygon};

use super::Viewpoint;
use crate::arena::Look;

/// The things within a camera's range.
pub(crate) struct Blocks<'a> {
    blocks: Vec<Block<'a>>,
    /// The camera's height, in metres.
    height_m: f64,
    range_m: f64,
    /// The look of what the camera is in or behind: it sees nothing else.
    covered: Option<Look>,
}

/// A thing between two heights.
struct Block<'a> {
    outline: Outline<'a>,
    look: Look,
}

/// The outline of a thing on the floor.
enum Outline<'a> {
    Disc(Circle),
    /// The inside, if it is filled, is under a flat top.
    Corners {
        points: &'a [Point],
        closed: bool,
        filled: bool,
    },
}

/// A view along one ray over the floor.
pub(crate) struct View<'a> {
    blocks: &'a Blocks<'a>,
    ray: Ray,
    /// Where the ray crosses outlines: how far away, and the place of the thing; the nearest first.
    crossings: Vec<(f64, usize)>,
}

/// The thing that is in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pixel {
    Thing(Look),
    Floor,
    /// Nothing within range.
    Nothing,
}

impl Viewpoint<'_> {
    /// All that a camera here may see.
    pub(crate) fn blocks(&self) -> Blocks<'_> {
        self.blocks_within(0.0)
    }

    /// The same for eyes that are at most `stray_m` from here.
    pub(super) fn blocks_within(&self, stray_m: f64) -> Blocks<'_> {
        let around = Circle { radius: self.around.radius + stray_m, ..self.around };
        let what = self.covered;
        let covered = what.map(|what| self.look_of(&super::RayHit { distance_m: 0.0, what }));
        let (arena, frozen) = (self.scene.arena, self.scene.frozen);
        let polygons = arena.polygons().iter().map(|polygon| Block {
            outline: Outline::Corners {
                points: &polygon.points,
                closed: polygon.closed,
                filled: polygon.solid,
            },
            look: polygon.look,
        });
        let pillars = arena.pillars().iter();
        let pillars =
            pillars.map(|pillar| Block { outline: Outline::Disc(pillar.circle), look: pillar.look });
        let others = frozen.bodies.iter().enumerate().filter(|&(i, _)| !frozen.is_of(i, self.scene.own));
        let bodies = others.map(|(_, figure)| Block {
            outline: if figure.outline.is_empty() {
                Outline::Disc(figure.disc)
            } else {
                Outline::Corners { points: &figure.outline, closed: true, filled: true }
            },
            look: figure.look,
        });
        let is_near = |block: &Block<'_>| block.outline.is_near(&around);
        let blocks = polygons.chain(pillars).chain(bodies).filter(is_near).collect();
        Blocks { blocks, height_m: self.height.above_floor_m, range_m: self.around.radius, covered }
    }
}

impl<'a> Blocks<'a> {
    /// The view from the camera along a ray, which starts there.
    pub(crate) fn along(&'a self, ray: &Ray) -> View<'a> {
        let mut crossings = Vec::new();
        for (i, block) in self.blocks.iter().enumerate() {
            if block.outline.is_over(ray.origin) {
                crossings.push((0.0, i));
            }
            block.outline.cross(ray, |distance_m| crossings.push((distance_m, i)));
        }
        crossings.retain(|&(distance_m, _)| distance_m <= self.range_m);
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        View { blocks: self, ray: *ray, crossings }
    }
}

impl Blocks<'_> {
    /// The lengths of these rays, all of which rise by so many metres for each metre on the floor; infinite for one that meets nothing within range.
    pub(crate) fn each(&self, rays: impl Iterator<Item = Ray>, rise: f64, distances_m: &mut [f64]) {
        let slant = math::sqrt(1.0 + rise * rise);
        for (ray, distance_m) in rays.zip(distances_m) {
            *distance_m = match self.along(&ray).meet(rise) {
                (_, Pixel::Nothing) => f64::INFINITY,
                (along_m, Pixel::Thing(_) | Pixel::Floor) => slant * along_m,
            };
        }
    }
}

impl View<'_> {
    /// What a line of sight sees that rises by so many metres for each metre on the floor.
    pub(crate) fn pixel(&self, rise: f64) -> Pixel {
        self.meet(rise).1
    }

    /// The same with its distance along the floor.
    fn meet(&self, rise: f64) -> (f64, Pixel) {
        let Blocks { blocks, height_m, range_m, covered } = self.blocks;
        if let Some(look) = covered {
            return (0.0, Pixel::Thing(*look));
        }
        // How far away the line of sight comes down to this height, or up to it.
        let up_to = |edge_m: f64| if rise > 0.0 { (edge_m - height_m) / rise } else { f64::INFINITY };
        let down_to = |top_m: f64| if rise < 0.0 { (height_m - top_m) / -rise } else { f64::INFINITY };
        let floor_m = down_to(0.0);
        let (mut nearest_m, mut seen) =
            if floor_m <= *range_m { (floor_m, Pixel::Floor) } else { (*range_m, Pixel::Nothing) };
        for &(distance_m, i) in &self.crossings {
            if distance_m > nearest_m {
                break;
            }
            let Block { outline, look } = &blocks[i];
            let at_m = height_m + rise * distance_m;
            if look.is_at(at_m) {
                return (distance_m, Pixel::Thing(*look));
            }
            // Else the line comes from above or below, and may meet the top or the underside of what is filled.
            let face_m = if at_m > look.height_m { down_to(look.height_m) } else { up_to(look.lower_edge_m) };
            if face_m <= nearest_m && outline.is_over(self.ray.at(face_m)) {
                (nearest_m, seen) = (face_m, Pixel::Thing(*look));
            }
        }
        (nearest_m, seen)
    }
}

impl Outline<'_> {
    /// Its sides, if it has corners.
    fn sides(&self) -> impl Iterator<Item = Segment> {
        let (points, closed) = match self {
            Self::Disc(_) => (&[][..], false),
            Self::Corners { points, closed, .. } => (*points, *closed),
        };
        let sides = if closed { points.len() } else { points.len().saturating_sub(1) };
        polygon::edges(points).take(sides)
    }

    /// Visits the places where a ray crosses it.
    fn cross(&self, ray: &Ray, mut visit: impl FnMut(f64)) {
        if let Self::Disc(disc) = self {
            ray.hit_circle(disc).into_iter().for_each(&mut visit);
        }
        self.sides().filter_map(|side| ray.hit_segment(&side)).for_each(visit);
    }

    /// Whether the point is over its flat top.
    fn is_over(&self, point: Point) -> bool {
        match self {
            Self::Disc(disc) => (point - disc.center).norm_squared() <= disc.radius * disc.radius,
            Self::Corners { points, filled, .. } => *filled && polygon::contains(points, point),
        }
    }

    /// Whether any of it is within this disc.
    fn is_near(&self, around: &Circle) -> bool {
        let is_within = |far_m: f64| far_m <= around.radius * around.radius;
        match self {
            Self::Disc(disc) => {
                let reach_m = around.radius + disc.radius;
                (disc.center - around.center).norm_squared() <= reach_m * reach_m
            }
            Self::Corners { .. } => {
                self.is_over(around.center)
                    || self.sides().any(|side| is_within(side.distance_squared(around.center)))
            }
        }
    }
}
