//! Brains as `--brain` arguments name them.

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_run::AttachedBrains;
use baudbot_run::assignment::{self, AssignmentError};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;

pub(crate) use baudbot_run::assignment::{
    Assigned, Assignment, DEFAULT, NONE, fitting_brain, is_for, named, sees,
};

use crate::error::Refused;

/// Shares the robots out to the brains that `--brain` arguments name. If one is missing, the error suggests those that the comment
/// of the scenario's file shows.
pub(crate) fn assign(arguments: &[String], robots: &[RobotSpec], shown: &[&str]) -> anyhow::Result<Assigned> {
    let assigned = assignment::assign(arguments, robots).map_err(|error| {
        Refused::error(if let AssignmentError::Blind { robot } = error {
            let shown: String = shown.iter().map(|brain| format!(" --brain {brain}")).collect();
            let shown =
                if shown.is_empty() { shown } else { format!("; its file suggests{shown}") };
            format!(
                "robot `{robot}` has no IR sensors, so the default brain `{}` cannot drive it; give it another \
                 with --brain {robot}=NAME (`baudbot brain --list` lists them; `none` is no brain), or give its microcontroller a \
                 program of yours with --firmware {robot}=FILE (`baudbot new firmware` begins one){shown}",
                DEFAULT
            )
        } else {
            format!("--brain: {error}")
        })
    })?;
    // The error for a brain that does not exist, or whose file is wrong, comes before anything is started for it.
    assigned.brains.iter().try_for_each(|assignment| check_name(&assignment.brain))?;
    Ok(assigned)
}

/// Sets the parameters of `--parameter` arguments for all brains that have them.
pub(crate) fn set_parameters(assigned: &mut Assigned, arguments: &[String]) -> anyhow::Result<()> {
    for argument in arguments {
        let Some((name, value)) = argument.split_once('=').filter(|(name, _)| !name.is_empty()) else {
            return Err(Refused::error(format!("--parameter {argument}: write NAME=VALUE")));
        };
        let set = assigned.set_parameter(name, value);
        set.map_err(|error| Refused::error(format!("--parameter {argument}: {error}")))?;
    }
    Ok(())
}

/// States of the scenario's robots when their brains write, unless the scenario does.
pub(crate) fn state_writes(assigned: &Assigned, scenario: &mut Scenario) -> anyhow::Result<()> {
    assigned.state_writes(&mut scenario.robots).map_err(|error| Refused::error(error.to_string()))
}

/// Whether a `--brain` is for all robots that no other one names.
pub(crate) fn is_for_all(brain: &str) -> bool {
    assignment::split(brain).0.is_none()
}

/// Drives until the run is over or the server closes the stream. Brains that the operator restarts are made again.
pub(crate) async fn drive(mut brains: AttachedBrains) -> anyhow::Result<AttachedBrains> {
    let driven = brains.run_with_restarts().await;
    driven.map_err(refused).with_context(|| format!("brain `{}` failed", brains.assignment().brain))?;
    Ok(brains)
}

/// The error of brains that do not attach, in the words for users.
pub(crate) fn refused(error: AssignmentError) -> anyhow::Error {
    if let AssignmentError::Brain(error) = error { Refused::error(error.to_string()) } else { error.into() }
}

/// Refuses a brain that is not there, or whose file is wrong, before anything is started for it.
pub(crate) fn check_name(description: &str) -> anyhow::Result<()> {
    catalogue::check(description).map_err(|error| Refused::error(error.to_string()))
}
