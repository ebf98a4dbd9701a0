//! The kinds of processes that this crate has, its brains that are written in Rust among them.

use std::collections::BTreeMap;

use baudbot_brain::Brain;

use crate::behavior::charge::Charge;
use crate::behavior::follow_path::FollowPath;
use crate::behavior::follow_wall::FollowWall;
use crate::behavior::go_to::GoTo;
use crate::behavior::home::Home;
use crate::behavior::taxis::Taxis;
use crate::behavior::turn_away::TurnAway;
use crate::behavior::whole::Whole;
use crate::behavior::{follow_path, go_to, taxis};
use crate::cognition::localization::{self, Localize};
use crate::cognition::odometry::{self, CountWheels};
use crate::cognition::particles::Disperse;
use crate::cognition::proximity::DetectProximity;
use crate::cognition::slam::{self, MakeMap};
use crate::coverage::{self, CoverRows};
use crate::exploration::behavior::ExploreFloor;
use crate::exploration::brain as explore;
use crate::kinds::{KINDS, Kind};
use crate::parameter::ParameterError;
use crate::potential::PotentialField;
use crate::registry::{Kit, Registry};
use crate::vfh::Vfh;

impl Registry {
    /// All kinds of this crate.
    pub fn standard() -> Self {
        let mut registry = Self::new();
        for kind in KINDS {
            registry.motor(kind.name, |settings, kit| whole(kind, &settings, &kit));
        }
        registry
            .motor("charge", |parameters, kit| Charge::new(kit.name, parameters, kit.body))
            .motor("cover_rows", |parameters: coverage::Parameters, kit| {
                CoverRows::new(&parameters, kit.body)
            })
            .motor("explore", |parameters: explore::Parameters, kit| ExploreFloor::new(parameters, kit.body))
            .motor("follow_path", |parameters: follow_path::Parameters, kit| {
                FollowPath::new(&parameters, kit.body)
            })
            .motor("follow_wall", |parameters, kit| FollowWall::new(parameters, kit.body))
            .motor("go_to", |parameters: go_to::Parameters, _| GoTo::new(&parameters))
            .motor("home", |parameters, kit| Home::new(parameters, &kit))
            .motor("potential_field", |parameters, kit| PotentialField::new(parameters, kit.body))
            .motor("taxis", |parameters: taxis::Parameters, kit| Taxis::new(&parameters, kit.body))
            .motor("turn_away", |parameters, kit| TurnAway::new(parameters, kit.body))
            .motor("vfh", |parameters, kit| Vfh::new(parameters, kit.body))
            .cognitive("laser_localization", |parameters: localization::Parameters, kit| {
                Localize::new(&parameters, &kit)
            })
            .cognitive("odometry", |parameters: odometry::Parameters, kit| {
                CountWheels::new(&parameters, kit.body)
            })
            .cognitive("particle_localization", |parameters, kit| Disperse::new(parameters, &kit))
            .cognitive("proximity", |parameters, kit| DetectProximity::new(parameters, &kit))
            .cognitive("slam", |parameters: slam::Parameters, kit| MakeMap::new(&parameters, &kit));
        registry
    }
}

/// A brain as a motor behaviour, with these parameters.
fn whole(
    kind: &'static Kind,
    settings: &BTreeMap<String, f64>,
    kit: &Kit<'_>,
) -> Result<Whole<Box<dyn Brain + Send>>, ParameterError> {
    let settings: Vec<_> = settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let brain = kind.brain(&settings.join(","), kit.seed, kit.body);
    Ok(Whole::new(brain.map_err(|error| ParameterError::Other(error.to_string()))?))
}
