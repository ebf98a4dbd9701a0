//! Line camera: one row of an image, as the walls of a flat world are the same at every height. Each column has
//! the colour of what is there and how far away that is.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::Fan;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::style::Style;
use super::{Measurement, Mount, NOTHING};
use crate::random::Stream;
use baudbot_fields::number::{Number, Opening, Whole};
use baudbot_fields::{FieldError, Path};

/// The model of a line camera.
#[derive(Clone, Debug, PartialEq)]
pub struct LineCamera {
    /// The place and the direction.
    pub mount: Mount,
    /// A ray for each column, from right to left.
    pub fan: Fan,
    /// The range, in metres.
    pub range_m: f64,
    /// Colour where there is nothing within range: red, green, blue.
    pub background: [u8; 3],
    /// Rows of the image, all alike: they are paid for on the cable.
    pub rows: u16,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Field of view.
    opening_rad: Number<Opening>,
    /// Number of columns, each with one ray.
    columns: Pixels,
    /// Maximum range.
    range_m: Number<Sight>,
    /// Colour where nothing is within range. Type: `[red, green, blue]`. Range: each 0 to 255.
    #[serde(default)]
    background: [u8; 3],
    /// Number of rows of the image on a port, all identical: they cost time on the cable and add no information.
    /// Range: at most 1,048,576 pixels.
    #[serde(default = "Pixels::constant::<1>")]
    rows: Pixels,
}

/// A side of an image.
type Pixels = Number<Whole<1, 4096, u16>>;

baudbot_fields::rules! {
    /// How far a camera sees, in metres: depths are sent in millimetres.
    Sight: Any, 1e-6, 65.0;
}

/// Most pixels of an image.
const MAX_PIXELS: usize = 1 << 20;

impl LineCamera {
    /// The number of an image's columns.
    pub fn columns(&self) -> usize {
        self.fan.len()
    }
}

impl Sense for LineCamera {
    const NAME: &str = "line-camera";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#cc79a7");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let (columns, rows) = (usize::from(sheet.columns.get()), sheet.rows.get());
        if columns * usize::from(rows) > MAX_PIXELS {
            let problem = format!("{columns} columns and {rows} rows are more than {MAX_PIXELS} pixels");
            return Err(path.field("rows").error(problem));
        }
        let (fan, range_m) = (Fan::new(sheet.opening_rad.get(), columns), sheet.range_m.get());
        let device = Self { mount: fit.mount, fan, range_m, background: sheet.background, rows };
        let mut encodings = levels(fit.bits, 3 * columns, 0.0, 1.0);
        encodings.extend(levels(fit.bits, columns, -1.0, range_m));
        Ok(Built::new(device, encodings))
    }

    fn components(&self) -> Vec<Component> {
        let many = |name, unit| Component { name, unit, count: self.columns() };
        vec![many("red", "1"), many("green", "1"), many("blue", "1"), many("depth_m", "m")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn range_m(&self) -> Option<f64> {
        Some(self.range_m)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    /// First all columns' red in [0, 1], from left to right as in a picture, then green, blue, and the depth in
    /// metres, −1 for nothing.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let n = self.columns();
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, self.range_m);
        for (i, ray) in self.fan.rays(pose.position, pose.direction()).enumerate() {
            let column = n - 1 - i;
            let hit = viewpoint.see(&ray);
            let color = hit.map_or(self.background, |hit| viewpoint.look_of(&hit).color);
            for (channel, &level) in color.iter().enumerate() {
                values[channel * n + column] = f64::from(level) / 255.0;
            }
            values[3 * n + column] = hit.map_or(NOTHING, |hit| hit.distance_m);
        }
        Effect::NONE
    }

    /// Colours stay in [0, 1]; noise sees nothing where there is nothing.
    fn bound(&self, values: &mut [f64]) {
        let (colors, depths) = values.split_at_mut(3 * self.columns());
        colors.iter_mut().for_each(|level| *level = level.clamp(0.0, 1.0));
        for depth in depths {
            if *depth != NOTHING {
                *depth = depth.clamp(0.0, self.range_m);
            }
        }
    }

    fn nothing(&self) -> Option<f64> {
        Some(NOTHING)
    }

    fn unmeasured(&self, values: &mut [f64]) {
        let (colors, depths) = values.split_at_mut(3 * self.columns());
        colors.fill(0.0);
        depths.fill(NOTHING);
    }
}
