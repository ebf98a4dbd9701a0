//! The kinds of processes that this crate has, its brains that are written in Rust among them.

use std::collections::BTreeMap;

use baudbot_brain::Brain;
use baudbot_fields::{Cause, Misread};

use crate::behavior::brain_behavior::BrainBehavior;
use crate::behavior::charge::Charge;
use crate::behavior::fixed_action::FixedAction;
use crate::behavior::follow_path::FollowPath;
use crate::behavior::follow_wall::FollowWall;
use crate::behavior::go_to::GoTo;
use crate::behavior::home::Home;
use crate::behavior::square::Square;
use crate::behavior::taxis::Taxis;
use crate::behavior::turn_away::TurnAway;
use crate::behavior::{follow_path, go_to, square, taxis};
use crate::cognition::localization::{self, Localize};
use crate::cognition::odometry::{self, CountWheels};
use crate::cognition::particles::Disperse;
use crate::cognition::proximity::DetectProximity;
use crate::cognition::slam::{self, MakeMap};
use crate::coverage::{self, CoverRows};
use crate::exploration::behavior::ExploreFloor;
use crate::exploration::brain as explore;
use crate::kinds::{CatalogueError, KINDS, Kind};
use crate::parameter::ParameterError;
use crate::potential::PotentialField;
use crate::registry::{BuildContext, Registry};
use crate::vfh::Vfh;

impl Registry {
    /// All kinds of this crate.
    pub fn standard() -> Self {
        let mut registry = Self::default();
        for kind in KINDS.iter() {
            registry.motors.add(kind.entry.name, |settings, context| whole(kind, &settings, &context));
        }
        registry
            .motors
            .add("charge", |parameters, context| Charge::new(context.name, parameters, context.body))
            .add("cover_rows", |parameters: coverage::Parameters, context| {
                CoverRows::new(&parameters, context.body)
            })
            .add("explore", |parameters: explore::Parameters, context| {
                ExploreFloor::new(parameters, context.body)
            })
            .add("fixed_action", |parameters, _| FixedAction::new(parameters))
            .add("follow_path", |parameters: follow_path::Parameters, context| {
                FollowPath::new(&parameters, context.body)
            })
            .add("follow_wall", |parameters, context| FollowWall::new(parameters, context.body))
            .add("go_to", |parameters: go_to::Parameters, _| GoTo::new(&parameters))
            .add("home", |parameters, context| Home::new(parameters, &context))
            .add("potential_field", |parameters, context| PotentialField::new(parameters, context.body))
            .add("square", |parameters: square::Parameters, context| Square::new(&parameters, context.body))
            .add("taxis", |parameters: taxis::Parameters, context| Taxis::new(&parameters, context.body))
            .add("turn_away", |parameters, context| TurnAway::new(parameters, context.body))
            .add("vfh", |parameters, context| Vfh::new(parameters, context.body));
        registry
            .cognitives
            .add("laser_localization", |parameters: localization::Parameters, context| {
                Localize::new(&parameters, &context)
            })
            .add("odometry", |parameters: odometry::Parameters, context| {
                CountWheels::new(&parameters, context.body)
            })
            .add("particle_localization", |parameters, context| Disperse::new(parameters, &context))
            .add("proximity", |parameters, context| DetectProximity::new(parameters, &context))
            .add("slam", |parameters: slam::Parameters, context| MakeMap::new(&parameters, &context));
        registry
    }
}

/// A brain as a motor behaviour, with these parameters.
fn whole(
    kind: &'static Kind,
    settings: &BTreeMap<String, f64>,
    context: &BuildContext<'_>,
) -> Result<BrainBehavior<Box<dyn Brain + Send>>, ParameterError> {
    let settings: Vec<_> = settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let brain = kind.brain(&settings.join(","), context.seed, context.body).map_err(|error| {
        let problem = error.to_string();
        let CatalogueError::Parameter { name, known, .. } = error else {
            return ParameterError::Other(problem);
        };
        ParameterError::Misread(Misread {
            path: String::new(),
            problem,
            cause: Cause::UnknownField { name: name.into(), known: known.into() },
        })
    })?;
    Ok(BrainBehavior::new(brain))
}
