//! The fields of a robot that a log can determine, by their paths below the robot.

use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::model::RobotModel;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::{Device, InfraredModel, Sensor};

/// A field that can be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// A field of `link.adapter`.
    Adapter(AdapterField),
    /// A field of the sensor at this place among the robot's.
    Sensor(usize, SensorField),
    /// A field of `motors`.
    Motors(MotorField),
    /// A field of `body`.
    Body(BodyField),
}

macro_rules! names {
    ($(#[$doc:meta])* $kind:ident { $($(#[$each:meta])* $variant:ident = $name:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $kind { $($(#[$each])* #[doc = $name] $variant),* }

        impl $kind {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The name in a scenario, below the table.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }
    };
}

names! {
    /// The fields of an adapter.
    AdapterField {
        Latency = "latency_ms",
        ExtraFrames = "extra_frames",
        Jitter = "jitter_us",
        Down = "down_us",
        Spread = "spread_ms",
        BurstProbability = "burst_probability",
        Burst = "burst_ms",
    }
}

names! {
    /// The fields of sensors.
    SensorField {
        C1 = "c1_m2",
        C2 = "c2",
        GainSpread = "noise.gain_spread",
        OffsetSpread = "noise.offset_spread",
        Multiplicative = "noise.multiplicative",
        Additive = "noise.additive",
        Uniform = "noise.uniform",
        HardIron = "hard_iron_rad",
        HardIronPhase = "hard_iron_phase_rad",
        SoftIron = "soft_iron_rad",
        SoftIronPhase = "soft_iron_phase_rad",
        OdometerSigma = "sigma_m",
        Loss = "loss",
    }
}

names! {
    /// The fields of motors.
    MotorField {
        DeadTime = "dead_time_ms",
        Gain = "gain_n_s",
        FullSpeed = "full_speed_m_s",
        Lag = "lag_ms",
        NoiseSigma = "noise_sigma",
        NoiseSpread = "noise_spread",
    }
}

names! {
    /// The fields of the body.
    BodyField {
        WheelRadius = "wheel_radius_m",
        HalfTrack = "half_track_m",
    }
}

/// All fields of a robot that a log can determine.
pub fn catalogue(robot: &RobotModel) -> Vec<Field> {
    let mut fields: Vec<_> = adapter(&robot.link).iter().copied().map(Field::Adapter).collect();
    for (i, sensor) in robot.sensors.iter().enumerate() {
        fields.extend(of_sensor(sensor).iter().map(|field| Field::Sensor(i, *field)));
    }
    let of_motors: &[MotorField] = match &robot.drive.motor {
        Motors::Velocity(_) => &[MotorField::Gain, MotorField::FullSpeed],
        Motors::Servo(_) => &[MotorField::Lag],
        Motors::Dc(_) | Motors::Stepper(_) => &[],
    };
    fields.push(Field::Motors(MotorField::DeadTime));
    fields.extend(of_motors.iter().copied().map(Field::Motors));
    fields.extend([MotorField::NoiseSigma, MotorField::NoiseSpread].map(Field::Motors));
    fields.extend(BodyField::ALL.iter().copied().map(Field::Body));
    fields
}

fn adapter(link: &Link) -> &'static [AdapterField] {
    use AdapterField::{Burst, BurstProbability, Down, ExtraFrames, Jitter, Latency, Spread};
    match link {
        Link::Uart(uart) => match uart.adapter {
            Adapter::Cdc(_) => &[ExtraFrames, Jitter, Down],
            Adapter::Ftdi(_) => &[Latency, ExtraFrames, Jitter, Down],
            Adapter::Bluetooth(_) => &[Latency, Spread, BurstProbability, Burst],
            Adapter::None => &[],
        },
        Link::Ideal | Link::Onboard | Link::Usb(_) => &[],
    }
}

fn of_sensor(sensor: &Sensor) -> &'static [SensorField] {
    use SensorField::{
        Additive, C1, C2, GainSpread, HardIron, HardIronPhase, Loss, Multiplicative, OdometerSigma,
        OffsetSpread, SoftIron, SoftIronPhase, Uniform,
    };
    match &sensor.device {
        Device::Infrared(ir) => match ir.model {
            InfraredModel::Phenomenological { .. } => {
                &[C1, C2, GainSpread, OffsetSpread, Multiplicative, Additive, Uniform]
            }
            InfraredModel::Lookup(_) => &[GainSpread, OffsetSpread, Multiplicative, Additive, Uniform],
            InfraredModel::Ambient { .. } => &[],
        },
        Device::Compass(_) => {
            &[HardIron, HardIronPhase, SoftIron, SoftIronPhase, OffsetSpread, Additive, Uniform]
        }
        Device::Odometer(_) => &[OdometerSigma],
        Device::Encoders(_) => &[Loss],
        Device::VoltageRanger(_) => &[GainSpread, OffsetSpread, Multiplicative, Additive, Uniform],
        Device::Sonar(_)
        | Device::Laser(_)
        | Device::LineCamera(_)
        | Device::Camera(_)
        | Device::StepCounter(_)
        | Device::OpticalFlow(_)
        | Device::Accelerometer(_)
        | Device::Gyroscope(_)
        | Device::Gps(_)
        | Device::Whisker(_)
        | Device::Bumper(_)
        | Device::Photoresistor(_)
        | Device::Light(_)
        | Device::Field(_)
        | Device::Microphone(_)
        | Device::Floor(_)
        | Device::Battery(_)
        | Device::StrainGauge(_)
        | Device::IrBeacons(_) => &[],
    }
}

impl Field {
    /// The path below the robot.
    pub fn path(self, robot: &RobotModel) -> String {
        match self {
            Self::Adapter(field) => format!("link.adapter.{}", field.name()),
            Self::Sensor(i, field) => {
                format!(
                    "sensors.{}.{}",
                    robot.sensors.get(i).map_or("?", |sensor| &sensor.name),
                    field.name()
                )
            }
            Self::Motors(field) => format!("motors.{}", field.name()),
            Self::Body(field) => format!("body.{}", field.name()),
        }
    }
}
