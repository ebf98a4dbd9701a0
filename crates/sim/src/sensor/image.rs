//! Camera: an image of the flat world, extruded to the heights of its things (Wahde 2016, §1.2.2, Fig. 1.9).
//!
//! A pinhole that looks along the floor. With x to the right and y up on a plane at distance 1, a pixel is a square of the side
//! p = 2 tan(opening / 2) / columns, and the pixel in the middle of the image is at (0, 0). The line of sight through (x, y) goes
//! sideways along (1, −x) in the frame of the camera, and rises by y / √(1 + x²) for each metre on the floor. So all pixels of a
//! column look along one ray of the flat world, and of what stands on it each sees the first thing that is as high, or the top of
//! a lower one, or the floor: exactly, without a grid.
//!
//! Deviations. The notes name cameras and give no model. There are no lens, no exposure and no light: colours are those of the
//! scenario, and a pixel is what its centre sees. The floor is of one colour, and ends at the range. Lamps
//! have no body, so that they are not seen. The robot itself is not in its image.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_fields::number::{Number, Whole};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::{Direction, Fan, Pose, Ray, math};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use crate::scene::{Blocks, Pixel};

/// The model of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The place and the direction.
    pub mount: Mount,
    /// The field of view, by a ray for each column, evenly spread: for pictures and for what has been seen.
    pub fan: Fan,
    /// The field of view from left to right, in radians.
    pub opening_rad: f64,
    /// Pixels in a row.
    pub columns: u16,
    /// Pixels in a column.
    pub rows: u16,
    /// The range, in metres.
    pub range_m: f64,
    /// Colour where there is nothing within range: red, green, blue.
    pub background: [u8; 3],
    /// Colour of the floor.
    pub floor: [u8; 3],
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Field of view from left to right. Pixels are square, so that it fixes the field of view from top to bottom, too.
    opening_rad: Number<View>,
    /// Number of columns of the image.
    columns: Number<Whole<1, 4096, u16>>,
    /// Number of rows of the image. Range: at most 131,072 pixels.
    rows: Number<Whole<1, 4096, u16>>,
    /// Maximum range.
    range_m: Number<Sight>,
    /// Colour where nothing is within range. Type: `[red, green, blue]`. Range: each 0 to 255.
    #[serde(default = "sky")]
    background: [u8; 3],
    /// Colour of the floor. Type: `[red, green, blue]`. Range: each 0 to 255.
    #[serde(default = "floor")]
    floor: [u8; 3],
}

baudbot_fields::rules! {
    /// How far a camera sees, in metres.
    Sight: Any, 1e-6, 1e3;
    /// What a flat image can show, in radians.
    View: Any, 1e-3, 3.0;
}

fn sky() -> [u8; 3] {
    [200, 210, 220]
}

fn floor() -> [u8; 3] {
    [90, 80, 70]
}

/// Most pixels of an image.
const MAX_PIXELS: usize = 1 << 17;

/// Red, green and blue.
const CHANNELS: usize = 3;

impl Camera {
    /// Pixels of an image.
    pub fn pixels(&self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }

    /// The side of a pixel on a plane at distance 1.
    fn pitch(&self) -> f64 {
        let (sin, cos) = math::sin_cos(0.5 * self.opening_rad);
        2.0 * sin / cos / f64::from(self.columns)
    }

    /// The place of a pixel's middle on a plane at distance 1, along a row or a column of so many.
    fn offset(pitch: f64, i: usize, count: u16) -> f64 {
        pitch * (i as f64 + 0.5 - 0.5 * f64::from(count))
    }

    /// The colour of a pixel.
    fn color(&self, pixel: Pixel) -> [u8; 3] {
        match pixel {
            Pixel::Thing(look) => look.color,
            Pixel::Floor => self.floor,
            Pixel::Nothing => self.background,
        }
    }

    /// The image from this pose, pixel by pixel: its column, its row, and what it sees.
    fn render(&self, blocks: &Blocks<'_>, pose: &Pose, mut put: impl FnMut(usize, usize, Pixel)) {
        let pitch = self.pitch();
        let ahead = pose.direction();
        for column in 0..usize::from(self.columns) {
            let x = Self::offset(pitch, column, self.columns);
            let length = math::sqrt(1.0 + x * x);
            let direction = Direction {
                cos: (ahead.cos + x * ahead.sin) / length,
                sin: (ahead.sin - x * ahead.cos) / length,
            };
            let view = blocks.along(&Ray { origin: pose.position, direction });
            for row in 0..usize::from(self.rows) {
                let rise = -Self::offset(pitch, row, self.rows) / length;
                put(column, row, view.pixel(rise));
            }
        }
    }
}

impl Sense for Camera {
    const NAME: &str = "camera";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#cc79a7");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let (columns, rows) = (sheet.columns.get(), sheet.rows.get());
        let pixels = usize::from(columns) * usize::from(rows);
        if pixels > MAX_PIXELS {
            let problem = format!("{columns} columns and {rows} rows are more than {MAX_PIXELS} pixels");
            return Err(path.field("rows").error(problem));
        }
        let (opening_rad, range_m) = (sheet.opening_rad.get(), sheet.range_m.get());
        let fan = Fan::new(opening_rad, columns.into());
        let Sheet { background, floor, .. } = sheet;
        let device = Self { mount: fit.mount, fan, opening_rad, columns, rows, range_m, background, floor };
        let encodings = levels(fit.bits, CHANNELS * pixels, 0.0, 1.0);
        Ok(Built::new(device, encodings))
    }

    fn components(&self) -> Vec<Component> {
        let channel = |name| Component { name, unit: "1", count: self.pixels() };
        vec![channel("red"), channel("green"), channel("blue")]
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

    /// First red in [0, 1] of all pixels, row by row from the top, each from left to right; then green, then blue.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, self.range_m);
        let (pixels, columns) = (self.pixels(), usize::from(self.columns));
        self.render(&viewpoint.blocks(), &pose, |column, row, pixel| {
            for (channel, level) in self.color(pixel).into_iter().enumerate() {
                values[channel * pixels + row * columns + column] = f64::from(level) / 255.0;
            }
        });
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values.iter_mut().for_each(|level| *level = level.clamp(0.0, 1.0));
    }
}
