//! The shapes that every kind of map becomes.

use std::path::Path;

use baudbot_geometry::{Point, math, polygon};
use toml_edit::{Array, Table, Value};

use crate::note::{Note, Weight};

/// A note, whichever scenario refers to the file.
#[derive(Debug)]
pub(crate) struct FileNote {
    pub(crate) weight: Weight,
    /// The field beside the file's name that it is about.
    pub(crate) field: &'static str,
    pub(crate) text: String,
}

impl FileNote {
    /// The note, once it is known which entry refers to the file.
    pub(crate) fn of(self, entry: &str, file: &Path) -> Note {
        let Self { weight, field, text } = self;
        Note { weight, path: format!("{entry}.{field}"), file: file.display().to_string(), text }
    }
}

/// A polygon of the arena that has no name yet.
#[derive(Debug)]
pub(crate) struct Shape {
    /// Corners in order, in metres.
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) solid: bool,
    /// Whether the last corner is joined to the first.
    pub(crate) closed: bool,
}

impl Shape {
    fn chain(&self) -> Vec<Point> {
        self.points.iter().map(|&[x, y]| Point::new(x, y)).collect()
    }

    /// In square metres.
    pub(crate) fn area_m2(&self) -> f64 {
        polygon::area(&self.chain())
    }

    /// Whether all corners of the other one are in it, or on its edge.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        let chain = self.chain();
        let is_on_edge = |point: Point| polygon::edges(&chain).any(|edge| edge.distance(point) < ON_EDGE_M);
        other.chain().into_iter().all(|point| polygon::contains(&chain, point) || is_on_edge(point))
    }

    /// The table of the shape in a scenario.
    pub(crate) fn table(&self, name: &str, height_m: Option<f64>) -> Table {
        let mut table = Table::new();
        let points = self.points.iter().map(|&point| Value::from(Array::from_iter(point)));
        table.insert("name", name.into());
        table.insert("points_m", Value::from(Array::from_iter(points)).into());
        table.insert("solid", self.solid.into());
        if !self.closed {
            table.insert("closed", false.into());
        }
        if let Some(height_m) = height_m {
            table.insert("height_m", height_m.into());
        }
        table
    }
}

/// Corners are rounded to a micrometre.
pub(crate) const ON_EDGE_M: f64 = 1e-5;

/// The most shapes that one map may become.
pub(crate) const MAX_SHAPES: usize = 100_000;

/// Positions in a scenario are not further out, in metres.
pub(crate) const MAX_POSITION: f64 = 1e6;

/// The length to the next micrometre: short in the text, and rid of rounding errors such as 0.30000000000000004.
pub(crate) fn tidy(metres: f64) -> f64 {
    math::round(metres * 1e6) / 1e6 + 0.0 // no -0
}
