//! Kinds of parts, as types. A server may be newer than the brain that reads its data sheet: a kind that is not known here
//! is `Unknown`, so that the brain drives on with the parts that it knows.

use core::fmt;

/// An enum of kinds with their names, as scenarios write them, and `Unknown` for the kinds of newer servers.
macro_rules! kinds {
    ($(#[$about:meta])* $Kind:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Kind {
            $($(#[$doc])* $variant,)+
            /// A kind that this version does not know.
            Unknown,
        }

        impl $Kind {
            /// All kinds that this version knows.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The name of the kind in scenarios.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                    Self::Unknown => "unknown",
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
    /// The quantity that a sensor measures, and its principle; `docs/reference/sensors.md` has a section for each.
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
        /// The distance that the sensor moved over the floor since its last read, in counts.
        OpticalFlow = "optical-flow",
        /// The force of contacts on a bar on the rim, in N, or what a bridge of strain gauges tells of it, in mV/V.
        StrainGauge = "strain-gauge",
        /// Pose in the arena, by two spots of infra-red light on the ceiling.
        IrBeacons = "ir-beacons",
        /// An image.
        Camera = "camera",
    }
}

kinds! {
    /// The effect of the signal of an actuator besides the wheels.
    ActuatorKind {
        /// Turns what is mounted on it to an angle.
        Turret = "turret",
        /// Shines; 1 is full strength, and 0 and less is nothing.
        Lamp = "lamp",
        /// Sounds; 1 is full strength, and 0 and less is nothing.
        Speaker = "speaker",
        /// Lays a trail of scent; 1 is the full rate, and 0 and less is nothing.
        Dispenser = "dispenser",
    }
}

kinds! {
    /// The motors of the wheels.
    MotorKind {
        /// DC motors: a signal is a share of the voltage.
        Dc = "dc",
        /// Wheels that have the speed of the signal.
        Velocity = "velocity",
        /// Servos that turn without end.
        Servo = "servo",
        /// Stepper motors.
        Stepper = "stepper",
    }
}

kinds! {
    /// The protocol on a sensor's own cable. The modules of `baudbot-wire` read it.
    PortFormat {
        /// A laser's scans, by SCIP 2.
        Scip2 = "scip2",
        /// Images of a line camera.
        LineImage = "line-image",
        /// A satellite receiver's sentences, by NMEA 0183.
        Nmea = "nmea",
    }
}
