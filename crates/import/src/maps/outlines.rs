//! A path of a drawing as chains of corners.

use baudbot_geometry::{Point, polygon};
use kurbo::PathEl;
use usvg::FillRule;
use usvg::tiny_skia_path::PathSegment;

use super::entry::Scale;
use super::problem::ShapeError;
use super::shape::{MAX_POSITION, tidy};

/// Corners in order, in metres; neighbours differ.
#[derive(Debug, Default)]
pub(crate) struct Outline {
    pub(crate) points: Vec<[f64; 2]>,
    /// Whether the last corner is joined to the first.
    pub(crate) closed: bool,
}

/// The transform from the units of a drawing to metres in the arena.
pub(crate) struct Placement {
    pub(crate) scale: Scale,
    /// The drawing's height, in units: y is down there, and up here.
    pub(crate) height: f64,
}

/// The outlines of a path, its curves as chords. One that ends where it began is closed, with or without a closing
/// command.
pub(crate) fn of_path(path: &usvg::Path, placement: &Placement) -> Result<Vec<Outline>, ShapeError> {
    of_path_at(path, path.abs_transform(), placement)
}

/// The same of a path that lies elsewhere in the drawing.
pub(crate) fn of_path_at(
    path: &usvg::Path,
    transform: usvg::Transform,
    placement: &Placement,
) -> Result<Vec<Outline>, ShapeError> {
    let mut pen = Pen::new(placement.scale.tolerance);
    let place = |point: usvg::tiny_skia_path::Point| placement.place(transform, point);
    for segment in path.data().segments() {
        match segment {
            PathSegment::MoveTo(to) => pen.move_to(place(to)?),
            PathSegment::LineTo(to) => pen.draw(PathEl::LineTo(place(to)?))?,
            PathSegment::QuadTo(a, to) => pen.draw(PathEl::QuadTo(place(a)?, place(to)?))?,
            PathSegment::CubicTo(a, b, to) => pen.draw(PathEl::CurveTo(place(a)?, place(b)?, place(to)?))?,
            PathSegment::Close => pen.close(),
        }
    }
    pen.lift(false);
    Ok(pen.outlines)
}

/// The side of a filled path's outline that is solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rim {
    /// Something filled without a hole: a solid shape.
    Solid,
    /// Something filled on one side only, which has a hole or is one: a wall without thickness. A solid polygon has no holes.
    Hollow,
}

/// The rim that each of the closed outlines of a filled path is.
pub(crate) fn rims(outlines: &[&Outline], rule: FillRule) -> Result<Vec<Rim>, ShapeError> {
    if outlines.len() > MAX_COMPARED {
        return Err(ShapeError::Outlines(outlines.len()));
    }
    let chains: Vec<_> = outlines.iter().map(|outline| outline.chain()).collect();
    let turns: Vec<i32> = chains.iter().map(|chain| turn(chain)).collect();
    let around = |i: usize| {
        let chains = &chains;
        (0..chains.len()).filter(move |&j| j != i && polygon::contains(&chains[j], chains[i][0]))
    };
    let is_filled = |count: usize, winding: i32| match rule {
        FillRule::EvenOdd => count % 2 == 1,
        FillRule::NonZero => winding != 0,
    };
    let mut rims = vec![Rim::Solid; chains.len()];
    for i in 0..chains.len() {
        let outer: Vec<usize> = around(i).collect();
        let winding: i32 = outer.iter().map(|&j| turns[j]).sum();
        let is_hole = is_filled(outer.len(), winding) && !is_filled(outer.len() + 1, winding + turns[i]);
        if is_hole {
            rims[i] = Rim::Hollow;
            // A hole belongs to the innermost outline around it. If that bounds nothing itself, those around it do.
            for j in outer {
                rims[j] = Rim::Hollow;
            }
        }
    }
    Ok(rims)
}

impl Placement {
    /// The place of a point of the drawing, in metres.
    pub(crate) fn of_drawing(&self, [x, y]: [f64; 2]) -> Result<[f64; 2], ShapeError> {
        let point = usvg::tiny_skia_path::Point::from_xy(x as f32, y as f32);
        self.place(usvg::Transform::identity(), point).map(|placed| [tidy(placed.x), tidy(placed.y)])
    }

    /// The place of the point, in metres. One that is too far out is refused here: along a curve that ends nowhere
    /// there would be no end of chords.
    fn place(
        &self,
        transform: usvg::Transform,
        point: usvg::tiny_skia_path::Point,
    ) -> Result<kurbo::Point, ShapeError> {
        let (x, y) = (f64::from(point.x), f64::from(point.y));
        let [sx, ky, kx, sy, tx, ty] =
            [transform.sx, transform.ky, transform.kx, transform.sy, transform.tx, transform.ty]
                .map(f64::from);
        let right = sx * x + kx * y + tx;
        let down = ky * x + sy * y + ty;
        let [x_m, y_m] = self.scale.origin;
        let placed = kurbo::Point::new(
            x_m + right * self.scale.m_per_unit,
            y_m + (self.height - down) * self.scale.m_per_unit,
        );
        if placed.x.abs() <= MAX_POSITION && placed.y.abs() <= MAX_POSITION {
            return Ok(placed);
        }
        Err(ShapeError::Far { x_m: placed.x, y_m: placed.y })
    }
}

struct Pen {
    outlines: Vec<Outline>,
    current: Outline,
    /// The start of the outline, and the place of the pen: as they were before they were rounded.
    start: kurbo::Point,
    at: kurbo::Point,
    tolerance: f64,
}

impl Pen {
    fn new(tolerance: f64) -> Self {
        let (outlines, current) = (Vec::new(), Outline::default());
        Self { outlines, current, start: kurbo::Point::ZERO, at: kurbo::Point::ZERO, tolerance }
    }

    fn move_to(&mut self, to: kurbo::Point) {
        self.lift(false);
        (self.start, self.at) = (to, to);
    }

    fn draw(&mut self, piece: PathEl) -> Result<(), ShapeError> {
        self.current.reach(self.at);
        kurbo::flatten([PathEl::MoveTo(self.at), piece], self.tolerance, |chord| {
            if let PathEl::LineTo(to) = chord {
                self.current.reach(to);
            }
        });
        self.at = piece.end_point().unwrap_or(self.at);
        if self.current.points.len() <= MAX_POINTS {
            return Ok(());
        }
        Err(ShapeError::Corners)
    }

    fn close(&mut self) {
        self.lift(true);
        self.at = self.start;
    }

    /// Ends the outline, if there is one.
    fn lift(&mut self, is_closed: bool) {
        let Outline { mut points, .. } = std::mem::take(&mut self.current);
        let meets = points.len() > 1 && points.first() == points.last();
        // A line there and back again is closed only by a closing command.
        let closed = is_closed || (meets && points.len() > 3);
        if meets && closed {
            points.pop();
        }
        if points.len() > 1 || (closed && !points.is_empty()) {
            self.outlines.push(Outline { points, closed });
        }
    }
}

impl Outline {
    /// Adds a corner, unless it is where the last one is.
    fn reach(&mut self, to: kurbo::Point) {
        let to = [tidy(to.x), tidy(to.y)];
        if self.points.last() != Some(&to) {
            self.points.push(to);
        }
    }

    pub(crate) fn chain(&self) -> Vec<Point> {
        self.points.iter().map(|&[x, y]| Point::new(x, y)).collect()
    }

    /// Whether the outline bounds one region.
    pub(crate) fn is_simple(&self) -> bool {
        polygon::is_simple(&self.chain())
    }
}

/// 1 for a chain that runs counter-clockwise, −1 for one that runs clockwise.
fn turn(chain: &[Point]) -> i32 {
    let twice_the_area: f64 =
        polygon::edges(chain).map(|edge| edge.start.coords.perp(&edge.end.coords)).sum();
    if twice_the_area < 0.0 { -1 } else { 1 }
}

/// Most corners of one polygon in a scenario.
pub(crate) const MAX_POINTS: usize = 4096;

/// Each outline of a path is compared with all others.
pub(crate) const MAX_COMPARED: usize = 1000;
