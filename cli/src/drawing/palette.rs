//! Colours. Those of sensors and zones are of Okabe's and Ito's and of Tol's sets, which the colour-blind tell apart.

use baudbot_sim::arena::Look;
use baudbot_sim::sensor::Device;
use baudbot_sim::surroundings::Zone;

/// Text.
pub(crate) const INK: &str = "#1d2430";
/// Text of less weight.
pub(crate) const PALE_INK: &str = "#3c4656";
/// Axes and frames.
pub(crate) const FRAME: &str = "#8a93a3";
/// The picture's ground, so that it reads on light and on dark pages.
pub(crate) const PAPER: &str = "#f7f8fa";
/// A robot's rim, if the scenario gives it no colour.
pub(super) const ROBOT: &str = "#1f5fa8";
/// A robot's body, if the scenario gives it no colour.
pub(super) const BODY: &str = "#d7e4f7";
/// The way of a thing that moves by itself.
pub(super) const MOVER: &str = "#994455";
/// A thing to push, if the scenario gives it no colour.
pub(super) const MOVABLE: [u8; 3] = [200, 160, 100];
/// A lamp's light.
pub(super) const LAMP: &str = "#f2b01e";
/// A thing that sensors of the robot itself, not of its surroundings, are drawn in.
pub(super) const INNER: &str = "#5b6678";
/// Fields, in turn.
pub(super) const FIELDS: [&str; 4] = ["#cc3311", "#009988", "#aa4499", "#999933"];
/// A field's bell that goes down.
pub(super) const HOLLOW: &str = "#0077bb";

/// Ways of robots that have no colour of their own, in turn.
pub(crate) const TRAILS: [&str; 12] = [
    "#0072b2", "#d55e00", "#009e73", "#aa4499", "#b58900", "#332288", "#882255", "#56b4e9", "#117733",
    "#cc79a7", "#44aa99", "#6b6b6b",
];

/// A hue for each kind of sensor.
pub(super) fn hue(device: &Device) -> &'static str {
    match device {
        Device::Infrared(_) => "#d55e00",
        Device::VoltageRanger(_) => "#ee8800",
        Device::Sonar(_) => "#0072b2",
        Device::Laser(_) => "#009e73",
        Device::LineCamera(_) => "#cc79a7",
        Device::Whisker(_) => "#882255",
        Device::Bumper(_) => "#332288",
        Device::Photoresistor(_) | Device::Light(_) => "#b58900",
        Device::Field(_) => "#44aa99",
        Device::Microphone(_) => "#aa4499",
        Device::Floor(_) => "#117733",
        Device::Encoders(_)
        | Device::StepCounter(_)
        | Device::Odometer(_)
        | Device::Compass(_)
        | Device::Accelerometer(_)
        | Device::Gyroscope(_)
        | Device::Gps(_)
        | Device::Battery(_) => INNER,
    }
}

/// The hue of a kind of sensor, dark enough for text on its fan.
pub(super) fn text_hue(device: &Device) -> String {
    let level = |at: usize| u8::from_str_radix(&hue(device)[at..at + 2], 16).unwrap_or(0);
    darker([level(1), level(3), level(5)], 0.62)
}

/// What a zone is for, in words, and the hue of its first use.
pub(super) fn uses(zone: &Zone) -> (&'static str, Vec<String>) {
    let all = [
        (zone.goal, "#0072b2", "goal".to_owned()),
        (zone.charger_w > 0.0, "#009e73", format!("charger {} W", zone.charger_w)),
        (zone.slip > 0.0, "#56b4e9", format!("slippery {}", zone.slip)),
        (zone.compass_offset_rad != 0.0, "#cc79a7", format!("compass {:+} rad", zone.compass_offset_rad)),
        (zone.indoors, "#882255", "indoors".to_owned()),
    ];
    let hue = all.iter().find(|(is, ..)| *is).map_or(FRAME, |(_, hue, _)| hue);
    let floor = zone.floor.map(|floor| format!("floor {floor}"));
    (hue, all.into_iter().filter(|(is, ..)| *is).map(|(_, _, text)| text).chain(floor).collect())
}

/// The grey of a floor that throws so much of the light back: lighter than it is, for there is much to read on it.
pub(super) fn floor(reflectance: f64) -> String {
    let level = (90.0 + 165.0 * reflectance.clamp(0.0, 1.0)) as u8;
    css([level; 3])
}

/// The colour that a scenario gives a thing, or else this one.
pub(super) fn own_color(look: &Look, otherwise: [u8; 3]) -> [u8; 3] {
    if look.color == Look::WALL.color { otherwise } else { look.color }
}

/// A share of the colour, the rest being white.
pub(super) fn lighter(color: [u8; 3], share: f64) -> String {
    css(color.map(|level| (255.0 - share * (255.0 - f64::from(level))) as u8))
}

/// A share of the colour, the rest being black.
pub(super) fn darker(color: [u8; 3], share: f64) -> String {
    css(color.map(|level| (share * f64::from(level)) as u8))
}

/// As SVG has it.
pub(super) fn css([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
