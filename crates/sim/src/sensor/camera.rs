//! Line camera: one row of an image, as the walls of a flat world are the same at every height. Each column has
//! the colour of what is there and how far away that is.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;

use baudbot_geometry::Fan;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::style::Style;
use super::{Measurement, Mount, NOTHING};
use crate::random::Stream;
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
    /// Field of view. Range: 0 to 2π.
    opening_rad: f64,
    /// A ray for each. Range: 1 to 4096.
    columns: u64,
    /// How far it sees. Range: 10^−6 to 65.
    range_m: f64,
    /// What it sees where there is nothing. Type: `[red, green, blue]`. Range: each 0 to 255.
    #[serde(default)]
    background: [u8; 3],
    /// Rows of the image on a port, all alike: they cost time on the cable and show nothing more. Range: 1 to
    /// 4096; at most 1,048,576 pixels.
    #[serde(default = "one_row")]
    rows: u64,
}

fn one_row() -> u64 {
    1
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
        let columns = path.whole_within("columns", sheet.columns, 1, 4096)? as usize;
        let opening_rad = path.within("opening_rad", sheet.opening_rad, 0.0, TAU)?;
        let range_m = path.within("range_m", sheet.range_m, 1e-6, 65.0)?;
        let rows = path.whole_within("rows", sheet.rows, 1, 4096)? as u16;
        if columns * usize::from(rows) > MAX_PIXELS {
            let problem = format!("{columns} columns and {rows} rows are more than {MAX_PIXELS} pixels");
            return Err(path.field("rows").error(problem));
        }
        let fan = Fan::new(opening_rad, columns);
        let device = Self { mount: fit.mount, fan, range_m, background: sheet.background, rows };
        let mut encodings = levels(path, fit.bits, 3 * columns, 0.0, 1.0)?;
        encodings.extend(levels(path, fit.bits, columns, -1.0, range_m)?);
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
