//! A run in this process.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use baudbot_run::{in_process, simulation};
use baudbot_server::world_status;
use baudbot_sim::World;

use crate::experiment::Experiment;
use crate::observer::Sight;
use crate::run_record::{Ran, Row, RunError, Task};
use crate::setup::Setup;

/// Does a run with brains of the catalogue; others need a server ([`Workers`](crate::Workers)). Whatever goes wrong in it, a panic too, is the row's error, and touches no other run: a run shares nothing
/// with others but the experiment, which never changes.
pub fn run(experiment: &Experiment, task: &Task) -> Row {
    let run = || -> Result<Ran, RunError> {
        let Setup { scenario, assigned } = Setup::new(experiment, task).map_err(RunError::new)?;
        if let Some(task) = assigned.programs.first() {
            let problem = format!("`{}` is a program, which needs a server to attach to", task.program);
            return Err(RunError::new(problem));
        }
        let mut sight = Sight::of(experiment);
        let look = |world: &World| {
            if let Some(sight) = &mut sight {
                sight.see(world);
            }
        };
        let world = if assigned.at_ports.is_empty() {
            in_process::run(scenario, &assigned.brains, look).map_err(RunError::new)?
        } else {
            simulation::run(scenario, &assigned, look).map_err(RunError::new)?
        };
        let ran = Ran::of(&world_status(&world));
        match &sight {
            Some(sight) => sight.tell(ran),
            None => Ok(ran),
        }
    };
    let outcome =
        catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| Err(RunError::new(panicked(&*panic))));
    Row { run: task.run, outcome }
}

fn panicked(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    format!("the run panicked, which is a bug in baudbot: {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_the_rows_error() {
        let panic = catch_unwind(|| panic!("at {}", 7)).unwrap_err();
        assert_eq!(panicked(&*panic), "the run panicked, which is a bug in baudbot: at 7");
        let panic = catch_unwind(|| panic!("here")).unwrap_err();
        assert!(panicked(&*panic).ends_with(": here"));
    }
}
