//! Colours: those of the page and of the program's drawings (viewer/src/arena/palette.ts).

use baudbot_proto::v1;

pub(super) type Rgb = [u8; 3];

pub(super) const WALL: Rgb = [138, 147, 163];
pub(super) const ROBOT: Rgb = [31, 95, 168];
pub(super) const MOVER: Rgb = [153, 68, 85];
pub(super) const MOVABLE: Rgb = [200, 160, 100];
pub(super) const LAMP: Rgb = [242, 176, 30];
/// What a brain believes, and nothing else, has this colour.
pub(super) const BELIEF: Rgb = [142, 58, 209];
/// Dead reckoning.
pub(super) const GHOST: Rgb = [102, 111, 128];
/// To be read on a light ground and on a dark one.
pub(super) const TEXT: Rgb = [118, 128, 146];

/// Walls are a little transparent: what a sensor saw of their faces shows from above, too.
pub(super) const WALL_ALPHA: f64 = 0.75;

/// Of what the server tells if the scenario gives a thing no colour.
const NO_COLOR: Rgb = [128, 128, 128];

/// The colour of something's own, or another if the scenario gives it none.
pub(super) fn own(look: Option<&v1::Look>, otherwise: Rgb) -> Rgb {
    let level = |level: u32| u8::try_from(level).unwrap_or(u8::MAX);
    match look.map(|look| [level(look.red), level(look.green), level(look.blue)]) {
        None | Some(NO_COLOR) => otherwise,
        Some(own) => own,
    }
}

/// What is seen on a ground of this colour: white on the dark, nearly black on the light.
pub(super) fn on(ground: Rgb) -> Rgb {
    let [red, green, blue] = ground.map(f64::from);
    if 0.299 * red + 0.587 * green + 0.114 * blue < 150.0 { [255; 3] } else { [29, 36, 48] }
}

/// A hue for each kind of sensor.
pub(super) fn hue(kind: &str) -> Rgb {
    match kind {
        "ir" => [213, 94, 0],
        "ir-voltage" => [238, 136, 0],
        "sonar" => [0, 114, 178],
        "laser" => [0, 158, 115],
        "line-camera" => [204, 121, 167],
        "whisker" => [136, 34, 85],
        "bumper" => [51, 34, 136],
        "photoresistor" | "light" => [181, 137, 0],
        "field" => [68, 170, 153],
        "microphone" => [170, 68, 153],
        "floor" => [17, 119, 51],
        _ => [91, 102, 120],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_scenario_coloured_has_a_colour_of_its_own() {
        let look = |red| v1::Look { height_m: None, red, green: 128, blue: 128 };
        assert_eq!(own(Some(&look(128)), WALL), WALL);
        assert_eq!(own(None, WALL), WALL);
        assert_eq!(own(Some(&look(200)), WALL), [200, 128, 128]);
        assert_eq!(own(Some(&look(999)), WALL), [255, 128, 128]);
    }
}
