//! Problems of the files of maps, in the words that follow the file's name.

use super::entry::Purpose;
use super::outlines::{MAX_COMPARED, MAX_POINTS};
use super::ros::{MAX_RESOLUTION, MAX_YAW, MIN_RESOLUTION};
use super::shape::{MAX_POSITION, MAX_SHAPES};
use super::svg::MAX_CORNERS;

/// A reason why a description in YAML is none of a map.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DescriptionError {
    #[error("is not a description of a map: {0}")]
    Yaml(String),
    #[error("{0} appears twice: remove one of them")]
    Twice(String),
    #[error("{name}: must be {form}, is {value}")]
    Form { name: String, form: &'static str, value: String },
    #[error("{name} is missing: {meaning}")]
    Missing { name: &'static str, meaning: &'static str },
    #[error("resolution: must be from {MIN_RESOLUTION} to {MAX_RESOLUTION} metres a cell, is {0}")]
    Resolution(f64),
    #[error(
        "free_thresh and occupied_thresh: must be from 0 to 1, the first not above the second; they are {free} and {occupied}"
    )]
    Thresholds { free: f64, occupied: f64 },
    #[error("origin: must be within ±{MAX_POSITION} metres and ±{MAX_YAW} radians, is {0:?}")]
    Origin(Vec<f64>),
    #[error("the map reaches ({}, {}), the limit is ±{MAX_POSITION} m: fix resolution or origin", .0[0], .0[1])]
    Far([f64; 2]),
}

/// A reason why an SVG is no plan.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DrawingError {
    #[error("cannot be parsed: no thread for it: {0}")]
    NoThread(std::io::Error),
    #[error("cannot be parsed: its parser gave up")]
    ParserGaveUp,
    #[error("is not XML: {0}")]
    Xml(usvg::roxmltree::Error),
    #[error("is not a valid SVG: {0}")]
    Svg(usvg::Error),
    #[error("is not an SVG: its outermost element is `{0}`")]
    Root(String),
    #[error("viewBox: {0}")]
    ViewBox(svgtypes::ViewBoxError),
    #[error("has neither a viewBox nor width and height: the place of its lower left corner is unknown")]
    NoSize,
    #[error("line {line}, `{attribute}`: {error}")]
    Attribute { line: u32, attribute: String, error: svgtypes::Error },
    #[error(
        "has more than {MAX_SHAPES} shapes or {MAX_CORNERS} corners: raise tolerance_m, or leave details out"
    )]
    Size,
    #[error("has no shape with the id `{id}`, which {purpose} names")]
    NoPlace { id: String, purpose: Purpose },
    #[error("the shape `{0}` has no area, and a goal is a disc")]
    NoArea(String),
    #[error("{shape} {problem}")]
    Shape { shape: String, problem: ShapeError },
}

/// A reason why a shape of a drawing cannot be a wall or a place.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ShapeError {
    #[error("reaches ({x_m}, {y_m}), the limit is ±{MAX_POSITION} m: fix m_per_unit or origin_m")]
    Far { x_m: f64, y_m: f64 },
    #[error("has more than {MAX_POINTS} corners in a row: raise tolerance_m, or break it apart")]
    Corners,
    #[error("has {0} closed outlines, the limit is {MAX_COMPARED}: break it apart")]
    Outlines(usize),
    #[error("is filled and has {0} corners, needs 3 or more")]
    TooFewCorners(usize),
    #[error("crosses or touches itself, so its inside is not defined: break it apart, or do not fill it")]
    CrossesItself,
    #[error(
        "is cut by its clip path: cut it in the editor (as Path > Intersection does), or leave it out by `without`"
    )]
    Cut,
    #[error("has a clip path that {0}")]
    ClipPath(Box<Self>),
}

/// A reason why a text chooses no shapes.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SelectorError {
    #[error("must be layer=NAME, id=NAME, class=NAME, fill=COLOR or stroke=COLOR, is {0:?}")]
    Form(String),
    #[error("must be none or a colour, such as black or #1a2b3c, is {0:?}")]
    Paint(String),
}
