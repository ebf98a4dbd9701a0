//! What `--require` asks of a run.

use std::sync::{Arc, Mutex, PoisonError};

use baudbot_experiment::requirement::Judge;
use baudbot_server::OnTick;
use baudbot_sim::World;

use crate::args::RunArgs;
use crate::error::Refused;
use crate::summary::Summary;

/// Adds how the run keeps to what is required.
pub(super) fn add(summary: &mut Summary, judge: &Mutex<Judge>) -> anyhow::Result<()> {
    let judge = judge.lock().unwrap_or_else(PoisonError::into_inner);
    let falls = judge.falls().map_err(|error| Refused::error(format!("--require: {error}")))?;
    summary.add_requirements(judge.demands(), &falls);
    Ok(())
}

/// The hook with a judge that sees the world first, if anything is required.
pub(super) fn judged(args: &RunArgs, on_tick: Option<OnTick>, judge: &Arc<Mutex<Judge>>) -> Option<OnTick> {
    if args.requirements.is_empty() {
        return on_tick;
    }
    let (judge, mut on_tick) = (Arc::clone(judge), on_tick);
    Some(Box::new(move |world: &World| {
        judge.lock().unwrap_or_else(PoisonError::into_inner).see(world);
        if let Some(on_tick) = &mut on_tick {
            on_tick(world);
        }
    }))
}
