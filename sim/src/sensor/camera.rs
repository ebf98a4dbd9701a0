//! Line camera: one row of an image, as the walls of a flat world are the same at every height. Each column has
//! the colour of what is there and how far away that is.

use baudbot_geometry::Fan;

use super::{Measurement, Mount};

/// What a line camera is.
#[derive(Clone, Debug, PartialEq)]
pub struct LineCamera {
    /// Where it sits.
    pub mount: Mount,
    /// A ray for each column, from right to left.
    pub fan: Fan,
    /// How far it sees, in metres.
    pub range_m: f64,
    /// Colour where there is nothing within range: red, green, blue.
    pub background: [u8; 3],
    /// Rows of the image, all alike: they are paid for on the cable.
    pub rows: u16,
}

impl LineCamera {
    /// How many columns an image has.
    pub fn columns(&self) -> usize {
        self.fan.len()
    }

    /// First all columns' red in [0, 1], from left to right as in a picture, then green, blue, and the depth in
    /// metres, −1 for nothing.
    pub(super) fn read(&self, at: &Measurement<'_>, values: &mut [f64]) {
        let n = self.columns();
        let pose = self.mount.world_from_sensor(at);
        let eye = self.mount.look(at, &pose, self.range_m);
        for (i, ray) in self.fan.rays(pose.position, pose.direction()).enumerate() {
            let column = n - 1 - i;
            let sight = eye.see(&ray);
            let color = sight.map_or(self.background, |sight| eye.look_of(&sight).color);
            for (channel, &level) in color.iter().enumerate() {
                values[channel * n + column] = f64::from(level) / 255.0;
            }
            values[3 * n + column] = sight.map_or(super::laser::NOTHING, |sight| sight.distance_m);
        }
    }

    /// Colours stay in [0, 1]; noise sees nothing where there is nothing.
    pub(super) fn bound(&self, values: &mut [f64]) {
        let (colors, depths) = values.split_at_mut(3 * self.columns());
        colors.iter_mut().for_each(|level| *level = level.clamp(0.0, 1.0));
        for depth in depths {
            if *depth != super::laser::NOTHING {
                *depth = depth.clamp(0.0, self.range_m);
            }
        }
    }
}
