//! The source of a diagram's events: a scenario's run, or a recorded one.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use baudbot_plot::caption;
use baudbot_recording::RecordedRun;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;

use super::ticks::{Tick, View, recorded_ticks, ticks};
use crate::args::DiagramArgs;
use crate::assignment::{self, Assigned};
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::replay::{recorded_run, refused};
use crate::run::overrides;
use crate::scenarios::{self, Source};

/// A run that is shown.
pub(super) struct Run {
    pub(super) scenario: Scenario,
    /// The name of its world.
    pub(super) name: String,
    way: Way,
}

enum Way {
    /// The run is made now, with these brains.
    Now(Assigned),
    Recorded(Arc<RecordedRun>),
}

impl Run {
    /// The one that the arguments name.
    pub(super) fn find(args: &DiagramArgs) -> anyhow::Result<Self> {
        let path = Path::new(&args.scenario);
        if is_recording(path) {
            return Self::recorded(args, path);
        }
        let source = Source::find(&args.scenario)?;
        let scenario = source.parse(&overrides(&args.changes)?)?;
        scenarios::warn(&source, &scenario);
        let mut assigned = assignment::assign(&args.brains, &scenario.robots, &source.shown_brains())?;
        assignment::set_parameters(&mut assigned, &args.parameters)?;
        let name = source.world_name(&scenario);
        Ok(Self { scenario, name, way: Way::Now(assigned) })
    }

    fn recorded(args: &DiagramArgs, path: &Path) -> anyhow::Result<Self> {
        let changes = &args.changes;
        let given = [
            ("--brain", !args.brains.is_empty()),
            ("--parameter", !args.parameters.is_empty()),
            ("--set", !changes.sets.is_empty()),
            ("--firmware", !changes.firmware.is_empty()),
            ("--seed", changes.seed.is_some()),
            ("--no-noise", changes.no_noise),
        ];
        if let Some((option, _)) = given.iter().find(|(_, is_given)| *is_given) {
            return Err(Refused::error(format!(
                "{option}: {} is a recorded run, and shown as it was; give the scenario for another run",
                path.display()
            )));
        }
        let recorded = Arc::new(recorded_run(path).map_err(|error| refused(path, &error))?);
        let (scenario, name) = (Scenario::clone(recorded.scenario()), recorded.header().world.clone());
        Ok(Self { scenario, name, way: Way::Recorded(recorded) })
    }

    /// The ticks of the run, with what is new of the robot in this place.
    pub(super) fn ticks<'a>(
        &'a self,
        place: usize,
        view: View,
        stop: &'a AtomicBool,
    ) -> anyhow::Result<Tick<'a>> {
        match &self.way {
            Way::Now(assigned) => ticks(self.scenario.clone(), assigned, (place, view), stop),
            Way::Recorded(recorded) => recorded_ticks(Arc::clone(recorded), (place, view), stop),
        }
    }

    /// The robot's brain, its link and the seed, and the changes of the scenario.
    pub(super) fn facts(&self, robot: &RobotSpec) -> Vec<String> {
        let brains = match &self.way {
            Way::Now(assigned) => assigned.brain_of(&robot.name),
            Way::Recorded(_) => Some("recorded".to_owned()),
        };
        let own = robot.chip.as_ref().map(|_| "a program of its own".to_owned());
        let who: Vec<_> = brains.into_iter().chain(own).collect();
        let facts = caption::facts(&who, &[caption::link(&robot.link)], self.scenario.seed);
        let about = caption::about(&self.scenario, false);
        let changed = (about != self.scenario.description).then_some(about);
        [Some(facts), changed].into_iter().flatten().collect()
    }
}

/// The files that are read for a diagram.
pub(super) fn inputs(args: &DiagramArgs) -> Inputs {
    if is_recording(Path::new(&args.scenario)) {
        return Inputs::default().file("recording", &args.scenario);
    }
    Inputs::of(&args.scenario, &args.changes).brains(&args.brains)
}

fn is_recording(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}
