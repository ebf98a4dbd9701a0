//! Kinds of parts, in both directions, by their names: `SENSOR_KIND_LINE_CAMERA` is `line-camera`.

use baudbot_brain::{ActuatorKind, MotorKind, PortFormat, SensorKind};

use crate::v1;

macro_rules! kinds {
    ($($Kind:ident = $prefix:literal),+ $(,)?) => {$(
        impl From<$Kind> for v1::$Kind {
            fn from(kind: $Kind) -> Self {
                let name = kind.name().replace('-', "_").to_uppercase();
                Self::from_str_name(&[$prefix, &name].concat()).unwrap_or(Self::Unspecified)
            }
        }

        impl From<v1::$Kind> for $Kind {
            fn from(kind: v1::$Kind) -> Self {
                let is_it = |known: &&Self| v1::$Kind::from(**known) == kind;
                Self::ALL.iter().find(is_it).copied().unwrap_or(Self::Unknown)
            }
        }
    )+};
}

kinds! {
    SensorKind = "SENSOR_KIND_",
    ActuatorKind = "ACTUATOR_KIND_",
    MotorKind = "MOTOR_KIND_",
    PortFormat = "PORT_FORMAT_",
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails for a kind that only one side has.
    macro_rules! assert_same {
        ($Kind:ident) => {
            let in_contract = (1..).map_while(|i| v1::$Kind::try_from(i).ok());
            let kinds: Vec<_> = in_contract.map($Kind::from).collect();
            assert_eq!(kinds, $Kind::ALL);
            assert_eq!(v1::$Kind::from($Kind::Unknown), v1::$Kind::Unspecified);
            assert_eq!($Kind::from(v1::$Kind::Unspecified), $Kind::Unknown);
        };
    }

    #[test]
    fn the_contract_has_the_kinds_that_brains_know() {
        assert_same!(SensorKind);
        assert_same!(ActuatorKind);
        assert_same!(MotorKind);
        assert_same!(PortFormat);
    }

    #[test]
    fn both_call_a_kind_of_sensor_as_scenarios_do() {
        for &kind in SensorKind::ALL {
            assert_eq!(v1::SensorKind::from(kind).scenario_name(), kind.name());
        }
    }
}
