//! Presets: robots, sensors and other parts that scenarios can name, each with the sources of its numbers.
//!
//! A preset is a TOML file in `crates/scenario/presets`. It starts with its kind and a description; then comes one table, named
//! after the kind, with the fields as they stand in a scenario. Each value has a comment that says where it is from:
//! [`Fact`]. `crates/scenario/src/preset.rs` puts presets into a scenario.

mod fact;

use alloc::vec::Vec;

pub use fact::{Fact, Standing};

/// A preset that is part of this crate.
#[derive(Debug)]
pub struct Preset {
    /// The name of the preset in scenarios.
    pub name: &'static str,
    /// The kind of the preset: a robot, or the part of one.
    pub kind: PresetKind,
    /// The description of the preset, in a line.
    pub description: &'static str,
    /// The file as it is.
    pub text: &'static str,
}

/// The kinds of presets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names say it")]
pub enum PresetKind {
    Robot,
    Sensor,
    Motors,
    Actuator,
    Microcontroller,
    Link,
    Adapter,
    Battery,
}

impl PresetKind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Robot,
        Self::Sensor,
        Self::Motors,
        Self::Actuator,
        Self::Microcontroller,
        Self::Link,
        Self::Adapter,
        Self::Battery,
    ];

    /// The word in the file, which is the name of its table, too.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Sensor => "sensor",
            Self::Motors => "motors",
            Self::Actuator => "actuator",
            Self::Microcontroller => "microcontroller",
            Self::Link => "link",
            Self::Adapter => "adapter",
            Self::Battery => "battery",
        }
    }

    /// The word as part of a sentence.
    pub const fn phrase(self) -> &'static str {
        match self {
            Self::Robot => "a robot",
            Self::Sensor => "a sensor",
            Self::Motors => "a pair of motors",
            Self::Actuator => "an actuator",
            Self::Microcontroller => "a microcontroller",
            Self::Link => "a link",
            Self::Adapter => "an adapter",
            Self::Battery => "a battery",
        }
    }
}

/// All presets, kind by kind.
pub fn presets() -> impl Iterator<Item = &'static Preset> {
    PRESETS.iter()
}

/// The preset of this name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    presets().find(|preset| preset.name == name)
}

/// The presets whose names are nearest to one that there is not, of `kind` or of any; none if none is near.
pub fn nearest(name: &str, kind: Option<PresetKind>) -> Vec<&'static Preset> {
    let those = presets().filter(|preset| kind.is_none_or(|kind| kind == preset.kind));
    baudbot_fields::nearest(name, those, |preset| preset.name)
}

impl Preset {
    /// Takes kind and description from the file's first two lines.
    const fn read(name: &'static str, text: &'static str) -> Self {
        let (kind, rest) = quoted(text, "kind = \"");
        let kind = match kind.as_bytes() {
            b"robot" => PresetKind::Robot,
            b"sensor" => PresetKind::Sensor,
            b"motors" => PresetKind::Motors,
            b"actuator" => PresetKind::Actuator,
            b"microcontroller" => PresetKind::Microcontroller,
            b"link" => PresetKind::Link,
            b"adapter" => PresetKind::Adapter,
            b"battery" => PresetKind::Battery,
            _ => panic!("a preset's kind is none that there is"),
        };
        let (description, _) = quoted(rest, "\ndescription = \"");
        Self { name, kind, description, text }
    }
}

/// The text in quotes behind `start`, with which the text begins, and the rest.
const fn quoted(text: &'static str, start: &str) -> (&'static str, &'static str) {
    let (found, rest) = text.split_at(start.len());
    let mut i = 0;
    while i < start.len() {
        assert!(
            found.as_bytes()[i] == start.as_bytes()[i],
            "a preset starts with its kind and its description"
        );
        i += 1;
    }
    let mut end = 0;
    while rest.as_bytes()[end] != b'"' {
        end += 1;
    }
    let (quoted, rest) = rest.split_at(end);
    (quoted, rest.split_at(1).1)
}

macro_rules! presets {
    ($($name:literal)*) => {
        &[$(Preset::read($name, include_str!(concat!("../../presets/", $name, ".toml")))),*]
    };
}

static PRESETS: &[Preset] = presets! {
    "khepera-1" "khepera-2" "e-puck" "thymio-2" "boe-bot" "turtlebot3-burger" "create-1" "create-2" "chalmers-40cm" "uno-rover" "boe-bot-shield" "line-follower" "arsim"
    "khepera-1-ir" "khepera-2-ir" "e-puck-ir" "thymio-2-ir" "gp2d12" "ping" "hc-sr04"
    "urg-04lx" "ust-10lx" "rplidar-a1" "lds-01" "cmucam-1" "webcam" "camera-320x240"
    "mpu-6050-gyro" "mpu-6050-accelerometer" "hmc6352" "hmc5883l" "gps-garmin-15" "adns-3080" "load-cell-10kg"
    "whisker" "photoresistor"
    "parallax-servo" "pololu-37d-30-1" "e-puck-stepper"
    "hs-645mg" "hs-645mg-6v"
    "bs2" "basicx" "zbasic" "atmega328p" "arduino-uno" "m68331" "dspic30f6014a"
    "uart-9600" "uart-38400" "uart-115200" "usb" "bluetooth" "ble" "onboard"
    "ft232r" "ft232r-1ms" "ch340" "atmega16u2"
    "4xaa-nimh"
};

#[cfg(test)]
mod tests {
    use alloc::string::String;
    use alloc::vec::Vec;

    use super::{PresetKind, nearest};

    fn names(name: &str) -> Vec<&'static str> {
        nearest(name, Some(PresetKind::Robot)).iter().map(|preset| preset.name).collect()
    }

    #[test]
    fn names_that_were_mistyped_are_found() {
        assert_eq!(names("kephera"), ["khepera-1", "khepera-2"]);
        assert_eq!(names("khepera"), ["khepera-1", "khepera-2"]);
        assert_eq!(names("epuck"), ["e-puck"]);
        assert_eq!(names("BoeBot"), ["boe-bot"]);
        assert_eq!(names("turtlebot"), ["turtlebot3-burger"]);
    }

    #[test]
    fn nobody_is_told_names_that_are_far_off() {
        assert_eq!(names("xyzzy-plugh"), [""; 0]);
        assert_eq!(names(&"khepera-1".repeat(1000)), [""; 0]);
        let long: String = core::iter::repeat_n('x', 1 << 16).collect();
        assert_eq!(names(&long), [""; 0]);
    }
}
