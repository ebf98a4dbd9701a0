//! Maps of ROS's map server: a description in YAML and an image.
//!
//! The occupancy of a cell is p = 1 − v, or v if the image is negative, where v is its brightness from 0 to
//! 1. Above `occupied_thresh` it is occupied, below `free_thresh` free, and otherwise unknown.
//!
//! *Deviations*: in mode `trinary` the map server takes the opacity of a pixel for another colour. Here a
//! pixel that is not opaque is unknown in every mode, as it is there in mode `scale`. In mode `raw` the map
//! server leaves the judgement to others; here p is the sample in percent, and above 100 unknown.

use std::path::Path;

use baudbot_geometry::grid::{Growth, Rectangle, cover};
use baudbot_geometry::math;

use super::description::Description;
use super::entry::Unknown;
use super::mapped::Mapped;
use super::problem::DescriptionError;
use super::raster;
use super::shape::{FileNote, MAX_POSITION, MAX_SHAPES, Shape, tidy};
use crate::error::FileError;
use crate::file;
use crate::note::Weight;

/// The rectangles that cover what is occupied in the map that the YAML file describes.
pub(crate) fn shapes(path: &Path, unknown: Unknown) -> Result<Mapped, FileError> {
    let map = map(&file::text(path)?).map_err(|problem| FileError::new(path, problem))?;
    let image = path.parent().unwrap_or_else(|| Path::new("")).join(&map.image);
    let mut seen = Seen::default();
    let mut bitmap = raster::read(&image, |brightness| {
        let state = map.state(brightness);
        seen.count(brightness, state);
        state.is_taken(unknown)
    })?;
    let rectangles = cover(&mut bitmap.cells, bitmap.width, Growth::RowFirst);
    let rectangles: Vec<_> = rectangles.take(MAX_SHAPES + 1).collect();
    if rectangles.len() > MAX_SHAPES {
        let problem = format!(
            "takes more than {MAX_SHAPES} rectangles: remove single dark cells from the map, or use a coarser one"
        );
        return Err(FileError::new(&image, problem));
    }
    let shapes = rectangles.iter().map(|rectangle| map.shape(rectangle, bitmap.height));
    let shapes =
        shapes.collect::<Result<_, DescriptionError>>().map_err(|problem| FileError::new(path, problem))?;
    let note = (unknown == Unknown::Occupied).then(|| seen.without_unknown(&map)).flatten();
    Ok(Mapped { shapes, notes: note.into_iter().collect(), marks: Vec::new() })
}

/// Reads the description, as the map server and its friends understand it.
fn map(text: &str) -> Result<Map, DescriptionError> {
    let description = Description::parse(text)?;
    let Some(image) = description.text("image")?.filter(|image| !image.is_empty()) else {
        return Err(missing("image", "the name of a PGM or PNG file"));
    };
    let Some(resolution) = description.number("resolution")? else {
        return Err(missing("resolution", "metres a cell"));
    };
    if !(MIN_RESOLUTION..=MAX_RESOLUTION).contains(&resolution) {
        return Err(DescriptionError::Resolution(resolution));
    }
    let [x, y, yaw] = origin(&description)?;
    let free = description.number("free_thresh")?.unwrap_or(OLD_FREE_THRESH);
    let occupied = description.number("occupied_thresh")?.unwrap_or(OLD_OCCUPIED_THRESH);
    if !(0.0 <= free && free <= occupied && occupied <= 1.0) {
        return Err(DescriptionError::Thresholds { free, occupied });
    }
    let is_negative = description.flag("negate")?;
    let mode = match description.text("mode")? {
        None => Mode::default(),
        Some(word) => {
            let (name, form) = ("mode".to_owned(), "one of trinary, scale, raw");
            Mode::of(&word).ok_or(DescriptionError::Form { name, form, value: word })?
        }
    };
    let (origin, turn) = ([x, y], math::sin_cos(yaw));
    Ok(Map { image, resolution, origin, turn, is_negative, free, occupied, mode })
}

fn missing(name: &'static str, meaning: &'static str) -> DescriptionError {
    DescriptionError::Missing { name, meaning }
}

fn origin(description: &Description) -> Result<[f64; 3], DescriptionError> {
    let Some(origin) = description.numbers("origin")? else {
        return Err(missing("origin", "[x, y, yaw] of the lower left corner"));
    };
    let Ok([x, y, yaw]) = <[f64; 3]>::try_from(origin.as_slice()) else {
        let (name, form) = ("origin".to_owned(), "[x, y, yaw]");
        return Err(DescriptionError::Form { name, form, value: format!("{origin:?}") });
    };
    if x.abs() <= MAX_POSITION && y.abs() <= MAX_POSITION && yaw.abs() <= MAX_YAW {
        return Ok([x, y, yaw]);
    }
    Err(DescriptionError::Origin(origin))
}

#[derive(Clone, Copy, Default, PartialEq)]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

impl Mode {
    /// The map server does not care about capitals.
    fn of(word: &str) -> Option<Self> {
        match &*word.to_ascii_lowercase() {
            "trinary" => Some(Self::Trinary),
            "scale" => Some(Self::Scale),
            "raw" => Some(Self::Raw),
            _ => None,
        }
    }
}

/// The contents of a valid description.
struct Map {
    image: String,
    /// Metres a cell.
    resolution: f64,
    /// The lower left corner, in metres.
    origin: [f64; 2],
    /// Sine and cosine of the yaw.
    turn: (f64, f64),
    is_negative: bool,
    free: f64,
    occupied: f64,
    mode: Mode,
}

impl Map {
    fn state(&self, brightness: Option<f64>) -> State {
        let Some(brightness) = brightness else { return State::Unknown };
        let p = match (self.mode, self.is_negative) {
            (Mode::Raw, false) => brightness * 2.55,
            (Mode::Raw, true) => (1.0 - brightness) * 2.55,
            (Mode::Trinary | Mode::Scale, false) => 1.0 - brightness,
            (Mode::Trinary | Mode::Scale, true) => brightness,
        };
        if p > 1.0 || (self.free..=self.occupied).contains(&p) {
            State::Unknown
        } else if p > self.occupied {
            State::Occupied
        } else {
            State::Free
        }
    }

    /// A rectangle of cells as a polygon. Rows are counted from the top of an image with so many.
    fn shape(&self, rectangle: &Rectangle, rows: usize) -> Result<Shape, DescriptionError> {
        let [x, y] = self.origin;
        let (sin, cos) = self.turn;
        let (left, right) = (rectangle.first.column, rectangle.first.column + rectangle.columns);
        let top = rows as i32 - rectangle.first.row;
        let bottom = top - rectangle.rows;
        let points = [[left, bottom], [right, bottom], [right, top], [left, top]].map(|[column, row]| {
            let (along, up) = (f64::from(column) * self.resolution, f64::from(row) * self.resolution);
            [tidy(x + (along * cos - up * sin)), tidy(y + (along * sin + up * cos))]
        });
        if let Some(far) = points.iter().find(|point| point.iter().any(|x| x.abs() > MAX_POSITION)) {
            return Err(DescriptionError::Far(*far));
        }
        Ok(Shape { points: points.to_vec(), solid: true, closed: true })
    }
}

/// The state of a cell.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Free,
    Occupied,
    Unknown,
}

impl State {
    fn is_taken(self, unknown: Unknown) -> bool {
        match self {
            Self::Free => false,
            Self::Occupied => true,
            Self::Unknown => unknown == Unknown::Occupied,
        }
    }
}

/// The cells of an image, by their brightness.
struct Seen {
    /// The number of cells of each grey, from black to white.
    greys: [u64; 256],
    has_unknown: bool,
}

impl Default for Seen {
    fn default() -> Self {
        Self { greys: [0; 256], has_unknown: false }
    }
}

impl Seen {
    fn count(&mut self, brightness: Option<f64>, state: State) {
        self.has_unknown |= state == State::Unknown;
        if let Some(brightness) = brightness {
            self.greys[math::round(brightness * 255.0) as usize] += 1;
        }
    }

    /// The note that no cell is unknown, if so, with the grey that probably should be.
    fn without_unknown(&self, map: &Map) -> Option<FileNote> {
        if self.has_unknown {
            return None;
        }
        let greys = (1..=LIGHTEST_GREY).filter(|&grey| self.greys[grey] > 0);
        // The savers of maps write unknown cells in this grey.
        let grey = greys.max_by_key(|&grey| (grey == UNKNOWN_GREY, self.greys[grey]));
        let text = match grey.map(|grey| (grey, self.greys[grey], map.state(Some(grey as f64 / 255.0)))) {
            Some((grey, cells, State::Free)) => format!(
                "no cell is unknown: grey {grey} ({cells} cells) is below free_thresh {}; with a lower one these cells are \
                 unknown, {} for instance",
                map.free, OLD_FREE_THRESH
            ),
            Some((grey, cells, State::Occupied)) => format!(
                "no cell is unknown: grey {grey} ({cells} cells) is above occupied_thresh {}",
                map.occupied
            ),
            Some((_, _, State::Unknown)) | None => {
                "no cell is unknown: all are black or white, and none can be seen through".to_owned()
            }
        };
        Some(FileNote { weight: Weight::Warning, field: "unknown", text })
    }
}

/// The grey of the map savers of ROS for cells that are unknown.
const UNKNOWN_GREY: usize = 205;

/// Free cells are 254 or 255.
const LIGHTEST_GREY: usize = 253;

/// In metres a cell. Corners are rounded to a micrometre, which must be little beside a cell.
pub(crate) const MIN_RESOLUTION: f64 = 1e-4;
pub(crate) const MAX_RESOLUTION: f64 = 1e3;

/// The map server's own values of old, for files that have none. A map saver's unknown cells are a little above the first.
const OLD_FREE_THRESH: f64 = 0.196;
const OLD_OCCUPIED_THRESH: f64 = 0.65;

/// In radians.
pub(crate) const MAX_YAW: f64 = 1e3;
