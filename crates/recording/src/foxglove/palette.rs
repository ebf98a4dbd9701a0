//! The colours of scenes: those of pictures, as levels.

use baudbot_plot::palette::{self, Rgb, rgb};
use baudbot_proto::v1::{self, SensorKind};
use baudbot_sim::sensor;

pub(super) const WALL: Rgb = rgb(palette::WALL);
pub(super) const ROBOT: Rgb = rgb(palette::ROBOT);
pub(super) const MOVER: Rgb = rgb(palette::MOVER);
pub(super) const MOVABLE: Rgb = rgb(palette::MOVABLE);
pub(super) const LAMP: Rgb = rgb(palette::LAMP);
pub(super) const BELIEF: Rgb = rgb(palette::BELIEF);
pub(super) const GHOST: Rgb = rgb(palette::DEAD_RECKONING);
/// Reads on light and on dark backgrounds.
pub(super) const TEXT: Rgb = [118, 128, 146];

/// Walls are a little transparent, so that the hits of rays on their faces are seen from above, too.
pub(super) const WALL_ALPHA: f64 = 0.75;

/// The colour that the scenario gives to a thing, or the default.
pub(super) fn own(look: Option<&v1::Look>, default: Rgb) -> Rgb {
    let level = |level: u32| u8::try_from(level).unwrap_or(u8::MAX);
    let own = look.map(|look| [level(look.red), level(look.green), level(look.blue)]);
    own.map_or(default, |own| palette::own_color(own, default))
}

/// The colour of marks on a surface: white on dark ones, nearly black on light ones.
pub(super) fn on(surface: Rgb) -> Rgb {
    let [red, green, blue] = surface.map(f64::from);
    let is_dark = 0.299 * red + 0.587 * green + 0.114 * blue < 150.0;
    rgb(if is_dark { palette::WHITE } else { palette::INK })
}

/// The colour of a kind of sensor. A server of another version may have kinds that are unknown here.
pub(super) fn sensor(kind: SensorKind) -> Rgb {
    let name = kind.scenario_name();
    let known = sensor::SensorKind::ALL.into_iter().find(|known| known.name() == name);
    rgb(known.map_or(palette::INNER, |known| known.style().color))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_scenario_coloured_has_a_colour_of_its_own() {
        let look = |red| v1::Look { red, green: 128, blue: 128, ..v1::Look::default() };
        assert_eq!(own(Some(&look(128)), WALL), WALL);
        assert_eq!(own(None, WALL), WALL);
        assert_eq!(own(Some(&look(200)), WALL), [200, 128, 128]);
        assert_eq!(own(Some(&look(999)), WALL), [255, 128, 128]);
    }
}
