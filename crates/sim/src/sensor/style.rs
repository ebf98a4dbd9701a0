//! The drawing of a kind's sensors. The world draws nothing; pictures take this from the file that describes the sensor.

/// A colour and a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// The colour of its rays and marks, as `#rrggbb`.
    pub color: &'static str,
    /// The mark at its mount.
    pub symbol: Symbol,
}

/// The mark of a sensor on its robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    /// A disc.
    Dot,
    /// A square: the sensor looks down.
    Square,
    /// A ring at the back of the robot: the sensor has no mount.
    Ring,
    /// A line as long as the sensor reaches, with a disc at its mount: the sensor touches.
    Line,
    /// An arc along the robot's rim, which touches.
    Arc,
}

impl Style {
    /// Sensors of the robot itself, not of its environment.
    pub const INNER: Self = Self::dot("#5b6678");

    pub(super) const fn dot(color: &'static str) -> Self {
        Self { color, symbol: Symbol::Dot }
    }
}
