//! How sensors are drawn: one table, a row for each kind.

use baudbot_sim::sensor::Device;

use super::INNER;

/// How sensors of a kind are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorStyle {
    /// The kind's name, as scenarios have it.
    pub kind: &'static str,
    /// The colour of its rays and marks.
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
    /// A line as long as the sensor reaches, with a disc at its mount.
    Line,
    /// An arc along the robot's rim.
    Arc,
}

/// The style of a sensor.
pub const fn sensor(device: &Device) -> SensorStyle {
    SENSORS[place(device)]
}

/// The style of the sensors of a kind, if there are such.
pub fn sensor_kind(kind: &str) -> Option<SensorStyle> {
    SENSORS.into_iter().find(|style| style.kind == kind)
}

/// Makes [`SENSORS`] and the place of each device in it. A device without a row does not compile.
macro_rules! sensors {
    ($($device:ident $kind:literal $color:tt $symbol:ident;)*) => {
        /// The styles of all kinds of sensors.
        pub const SENSORS: [SensorStyle; [$($kind),*].len()] =
            [$(SensorStyle { kind: $kind, color: $color, symbol: Symbol::$symbol }),*];

        const fn place(device: &Device) -> usize {
            enum Row { $($device),* }
            match device { $(Device::$device(_) => Row::$device as usize),* }
        }
    };
}

sensors! {
    Infrared      "ir"            "#d55e00" Dot;
    VoltageRanger "ir-voltage"    "#ee8800" Dot;
    Sonar         "sonar"         "#0072b2" Dot;
    Laser         "laser"         "#009e73" Dot;
    LineCamera    "line-camera"   "#cc79a7" Dot;
    Encoders      "encoders"      INNER     Dot;
    StepCounter   "steps"         INNER     Dot;
    Odometer      "odometer"      INNER     Dot;
    OpticalFlow   "optical-flow"  "#661100" Square;
    Compass       "compass"       INNER     Dot;
    Accelerometer "accelerometer" INNER     Dot;
    Gyroscope     "gyroscope"     INNER     Dot;
    Gps           "gps"           INNER     Dot;
    Whisker       "whisker"       "#882255" Line;
    Bumper        "bumper"        "#332288" Arc;
    Photoresistor "photoresistor" "#b58900" Dot;
    Light         "light"         "#b58900" Dot;
    Field         "field"         "#44aa99" Dot;
    Microphone    "microphone"    "#aa4499" Ring;
    Floor         "floor"         "#117733" Square;
    Battery       "battery"       INNER     Dot;
}
