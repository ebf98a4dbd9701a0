//! Colours by what they mean. Those of sensors, zones and series are from Okabe's and Ito's and from Tol's sets, which
//! colour-blind people can tell apart.
//!
//! SVG pictures and Foxglove's scenes take their colours from here. The page has themes, so that its palette
//! (`viewer/src/arena/palette.ts`) is its own; a test here compares what both have.

#[cfg(test)]
mod tests;
mod zones;

pub use zones::ZoneUses;

use baudbot_sim::arena::Look;
use baudbot_sim::sensor::Style;

/// Levels of red, green and blue.
pub type Rgb = [u8; 3];

/// Text.
pub const INK: &str = "#1d2430";
/// Text of less weight.
pub const PALE_INK: &str = "#3c4656";
/// Axes and frames.
pub const FRAME: &str = "#8a93a3";
/// Grid lines behind everything.
pub const GRID: &str = "#dfe3ea";
/// The background of a picture, which reads on light and on dark pages.
pub const PAPER: &str = "#f7f8fa";
/// Panels, halos and the rims of marks.
pub const WHITE: &str = "#ffffff";

/// Walls without a colour of their own.
pub const WALL: &str = "#8a93a3";
/// The rim of a robot without a colour of its own.
pub const ROBOT: &str = "#1f5fa8";
/// The body of a robot without a colour of its own.
pub const BODY: &str = "#d7e4f7";
/// The path of a thing that moves by itself.
pub const MOVER: &str = "#994455";
/// A thing to push without a colour of its own.
pub const MOVABLE: &str = "#c8a064";
/// The light of a lamp.
pub const LAMP: &str = "#f2b01e";
/// The rim of a lamp.
pub const LAMP_RIM: &str = "#8a6100";
/// Sensors of the robot itself, not of its environment, and its turrets.
pub const INNER: &str = Style::INNER.color;
/// Fields, in turn.
pub const FIELDS: [&str; 4] = ["#cc3311", "#009988", "#aa4499", "#999933"];
/// A negative bell of a field.
pub const HOLLOW: &str = "#0077bb";
/// The colour of a brain's beliefs, and of nothing else.
pub const BELIEF: &str = "#8e3ad1";
/// Dead reckoning.
pub const DEAD_RECKONING: &str = "#666f80";
/// Whatever happens after a deadline.
pub const LATE: &str = "#d0312d";

/// Trails of robots without colours of their own, and lines over time, in turn.
pub const TRAILS: [&str; 12] = [
    "#0072b2", "#d55e00", "#009e73", "#aa4499", "#b58900", "#332288", "#882255", "#56b4e9", "#117733",
    "#cc79a7", "#44aa99", "#6b6b6b",
];
/// Lines of a chart, in turn.
pub const SERIES: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#4d4d4d"];

/// The levels of a colour that is written as `#rrggbb`.
pub const fn rgb(css: &str) -> Rgb {
    let digits = css.as_bytes();
    [level(digits, 1), level(digits, 3), level(digits, 5)]
}

/// A colour as `#rrggbb`.
pub fn css([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A mix of a share of the colour, in [0, 1], with white.
pub fn lighter(color: Rgb, share: f64) -> String {
    css(color.map(|level| (255.0 - share * (255.0 - f64::from(level))) as u8))
}

/// A mix of a share of the colour, in [0, 1], with black.
pub fn darker(color: Rgb, share: f64) -> String {
    css(color.map(|level| (share * f64::from(level)) as u8))
}

/// The colour that a scenario gives to a thing, or the default.
pub fn own_color(color: Rgb, default: Rgb) -> Rgb {
    if color == Look::WALL.color { default } else { color }
}

/// The grey of a floor with this reflectance, in [0, 1]. It is lighter than the floor, since much is drawn on it.
pub fn floor(reflectance: f64) -> String {
    css([(90.0 + 165.0 * reflectance.clamp(0.0, 1.0)) as u8; 3])
}

const fn level(digits: &[u8], at: usize) -> u8 {
    16 * digit(digits[at]) + digit(digits[at + 1])
}

const fn digit(c: u8) -> u8 {
    match c {
        b'0'..=b'9' => c - b'0',
        b'a'..=b'f' => c - b'a' + 10,
        _ => panic!("colours of the palette are `#rrggbb` in small letters"),
    }
}
