//! The guesses of all presets, and what would settle each.

use baudbot_scenario::presets::{Fact, Preset, Standing, presets};

/// A number of a preset for which there is no published source.
#[derive(Clone, Debug)]
pub struct Guess {
    /// The preset with the number.
    pub preset: &'static Preset,
    /// The number, and why it was chosen.
    pub fact: Fact,
    /// The means to settle it.
    pub settled_by: SettledBy,
}

/// The means to settle a guess.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SettledBy {
    /// A ruler and a scale.
    Ruler,
    /// Readings over distance or angle of several specimens, as `baudbot measure curve` takes them.
    Curve,
    /// Many readings of a sensor at rest, for its noise and its drift.
    Rest,
    /// The response of the wheels to a step of the command, as `baudbot measure step` takes it.
    Step,
    /// Echo times of the port, as `baudbot measure echo` takes them.
    Echo,
    /// A logic analyser or an oscilloscope on the pins.
    Pins,
    /// An ammeter in the supply, and a discharge at a constant current.
    Ammeter,
    /// The maker's manual, or the firmware's source.
    Manual,
    /// Nothing: it is a choice of the simulation, and not a property of the robot.
    Choice,
}

impl SettledBy {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Ruler,
        Self::Curve,
        Self::Rest,
        Self::Step,
        Self::Echo,
        Self::Pins,
        Self::Ammeter,
        Self::Manual,
        Self::Choice,
    ];

    /// A heading and a sentence about it.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Ruler => ("A ruler and a scale", "Measure and weigh the robot."),
            Self::Curve => (
                "Readings over distance or angle",
                "Take them with `baudbot measure curve`, of several specimens, and fit them with `baudbot fit`.",
            ),
            Self::Rest => (
                "Readings at rest",
                "Log the sensor for some minutes where nothing changes; the spread is its noise, the slow part its drift.",
            ),
            Self::Step => (
                "The response to a step",
                "Take it with `baudbot measure step`, and fit it with `baudbot fit`.",
            ),
            Self::Echo => {
                ("Echo times", "Take them with `baudbot measure echo`, and fit them with `baudbot fit`.")
            }
            Self::Pins => {
                ("A logic analyser", "Watch the pins: when is the sensor read, and when does a byte begin?")
            }
            Self::Ammeter => {
                ("An ammeter", "Measure the current, and discharge the battery at a constant one.")
            }
            Self::Manual => {
                ("The manual or the firmware", "Look it up: it is a setting or a format, not a measurement.")
            }
            Self::Choice => (
                "Choices of the simulation",
                "Not listed here: how finely a robot is simulated, or a default that a scenario replaces, is no property of the robot.",
            ),
        }
    }

    /// The means to settle a field, by its name.
    fn of(field: &str) -> Option<Self> {
        let settled_by =
            |(names, settled_by): &(&[&str], Self)| names.contains(&field).then_some(*settled_by);
        BY_FIELD.iter().find_map(settled_by)
    }
}

const BY_FIELD: [(&[&str], SettledBy); 9] = [
    (
        &[
            "mass_kg",
            "height_m",
            "half_track_m",
            "wheel_radius_m",
            "mount",
            "length_m",
            "travel_m",
            "radius_m",
            "inertia_kg_m2",
        ],
        SettledBy::Ruler,
    ),
    (
        &[
            "c1_m2",
            "c2",
            "opening_rad",
            "range_m",
            "lookup",
            "gain_spread",
            "offset_spread",
            "idle_v",
            "detection",
            "hard_iron_rad",
            "soft_iron_rad",
            "curve_m_v",
            "min_m",
            "max_m",
            "near_opening_rad",
        ],
        SettledBy::Curve,
    ),
    (
        &[
            "additive",
            "uniform",
            "multiplicative",
            "sigma_m",
            "drift",
            "wander_sigma_m",
            "short_wander_sigma_m",
            "short_wander_time_s",
            "wander_time_s",
            "bandwidth_hz",
            "drift_time_s",
            "sigma",
        ],
        SettledBy::Rest,
    ),
    (
        &[
            "lag_ms",
            "gain_n_s",
            "dead_time_ms",
            "full_speed_m_s",
            "max_torque_nm",
            "viscous_friction_nm_s",
            "coulomb_friction_nm",
            "gear_efficiency",
            "trim_us",
            "dead_band_us",
            "curve_us_rpm",
            "max_acceleration_steps_s2",
            "max_rate_steps_s",
            "counts_per_turn",
        ],
        SettledBy::Step,
    ),
    (
        &["burst_probability", "burst_ms", "spread_ms", "jitter_us", "down_us", "extra_frames", "gap_ms"],
        SettledBy::Echo,
    ),
    (
        &[
            "period_ms",
            "phase_ms",
            "latency_ms",
            "acquisition_us",
            "holdoff_us",
            "bounce_ms",
            "operations_per_s",
            "framing_us_per_byte",
            "receiving_us_per_byte",
            "obeying_us",
            "bootloader_s",
        ],
        SettledBy::Pins,
    ),
    (
        &[
            "holding_w",
            "idle_w",
            "internal_resistance_ohm",
            "capacity_mah",
            "efficiency",
            "capacity_a_share",
            "curve_share_v",
        ],
        SettledBy::Ammeter,
    ),
    (
        &[
            "bits",
            "converter_bits",
            "full_scale",
            "packet_bytes",
            "signal_bits",
            "baud",
            "characters",
            "first_step",
            "sentences",
            "rows",
            "voltage_v",
            "resistance_ohm",
            "gear_ratio",
            "quadrature",
        ],
        SettledBy::Manual,
    ),
    (&["rays", "bearing_rad", "cross_talk"], SettledBy::Choice),
];

/// All guesses, in the order of the presets.
pub fn guesses() -> Vec<Guess> {
    let of = |preset: &'static Preset| {
        let guesses = preset.facts().into_iter().filter(|fact| fact.standing == Some(Standing::Guess));
        guesses.map(move |fact| Guess { preset, settled_by: settled_by(preset, &fact), fact })
    };
    presets().flat_map(of).collect()
}

fn settled_by(preset: &Preset, fact: &Fact) -> SettledBy {
    // These facts are the wires of the pins.
    if fact.path.contains(".pins.") {
        return SettledBy::Choice;
    }
    let field = fact.path.rsplit('.').next().unwrap_or_default();
    SettledBy::of(field).unwrap_or_else(|| {
        panic!("{}: nobody has said in `guesses.rs` what would settle the guess {}", preset.name, fact.path)
    })
}

#[cfg(test)]
mod tests {
    use super::{BY_FIELD, guesses};

    #[test]
    fn every_guess_can_be_settled_and_no_field_in_two_ways() {
        assert!(guesses().len() > 50);
        let mut names: Vec<_> = BY_FIELD.iter().flat_map(|(names, _)| names.iter()).collect();
        let all = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}
