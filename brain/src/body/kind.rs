//! Kinds of parts, as types. A data sheet comes over the network as text, and a server may be newer than the brain that
//! reads it: a name that is not known here is kept as `Other`, so that the brain drives on with the parts that it knows.

use alloc::borrow::ToOwned;
use alloc::string::String;
use core::fmt;

/// An enum of kinds with their names, as scenarios and the contract write them, and `Other` for the names of newer servers.
macro_rules! kinds {
    ($(#[$about:meta])* $Kind:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub enum $Kind {
            $($(#[$doc])* $variant,)+
            /// A kind that this version does not know: its name.
            Other(String),
        }

        impl $Kind {
            /// Its name, as scenarios and the contract write it.
            pub fn name(&self) -> &str {
                match self {
                    $(Self::$variant => $name,)+
                    Self::Other(name) => name,
                }
            }
        }

        impl From<&str> for $Kind {
            fn from(name: &str) -> Self {
                match name {
                    $($name => Self::$variant,)+
                    other => Self::Other(other.to_owned()),
                }
            }
        }

        impl fmt::Display for $Kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

kinds! {
    /// What a sensor measures, and how; `docs/sensors.md` has a section for each.
    SensorKind {
        /// Nearness by infra-red light, in [0, 1].
        Infrared = "ir",
        /// Distance by infra-red light, as the sensor's voltage.
        VoltageRanger = "ir-voltage",
        /// Distance by sound.
        Sonar = "sonar",
        /// A laser range finder's scan.
        Laser = "laser",
        /// A line of an image, with depth.
        LineCamera = "line-camera",
        /// Counts of both wheels.
        Encoders = "encoders",
        /// Steps of both stepper motors.
        StepCounter = "steps",
        /// Pose since the start, by the wheels.
        Odometer = "odometer",
        /// The sensor's own way over the floor since its last read, in counts.
        OpticalFlow = "optical-flow",
        /// Heading.
        Compass = "compass",
        /// Acceleration along two axes.
        Accelerometer = "accelerometer",
        /// Turn rate.
        Gyroscope = "gyroscope",
        /// Position and course by satellites.
        Gps = "gps",
        /// Touch of a wire: 1 or 0.
        Whisker = "whisker",
        /// Touch of a bar on the rim: 1 or 0.
        Bumper = "bumper",
        /// Light, as the time that a capacitor takes, in counts.
        Photoresistor = "photoresistor",
        /// Light, in lux.
        Light = "light",
        /// The strength of a field, such as a scent.
        Field = "field",
        /// Sound.
        Microphone = "microphone",
        /// The floor's brightness, in [0, 1].
        Floor = "floor",
        /// The battery's voltage, and the charge that is left, in [0, 1].
        Battery = "battery",
    }
}

kinds! {
    /// What an actuator besides the wheels does with its signal.
    ActuatorKind {
        /// Turns what is mounted on it to an angle.
        Turret = "turret",
        /// Shines; 1 is full strength, and 0 and less is nothing.
        Lamp = "lamp",
        /// Sounds; 1 is full strength, and 0 and less is nothing.
        Speaker = "speaker",
    }
}

kinds! {
    /// What turns the wheels.
    MotorKind {
        /// DC motors: a signal is a share of the voltage.
        Dc = "dc",
        /// Wheels that have the speed that the signal says.
        Velocity = "velocity",
        /// Servos that turn without end.
        Servo = "servo",
        /// Stepper motors.
        Stepper = "stepper",
    }
}

kinds! {
    /// What is said on a sensor's own cable. The modules of `baudbot-wire` read it.
    PortFormat {
        /// A laser's scans, by SCIP 2.
        Scip2 = "scip2",
        /// Images of a line camera.
        LineImage = "line-image",
        /// A satellite receiver's sentences, by NMEA 0183.
        Nmea = "nmea",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written_and_unknown_ones_are_kept() {
        for name in ["ir", "ir-voltage", "laser", "battery"] {
            assert_ne!(SensorKind::from(name), SensorKind::Other(name.to_owned()));
            assert_eq!(SensorKind::from(name).name(), name);
        }
        assert_eq!(SensorKind::from("nose"), SensorKind::Other("nose".to_owned()));
        assert_eq!(SensorKind::from("nose").name(), "nose");
    }
}
