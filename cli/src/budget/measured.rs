//! Thinking times that were measured in a run that was recorded.

use std::collections::BTreeMap;
use std::path::Path;

use baudbot_plot::quantity::{count, duration};
use baudbot_proto::v1;
use baudbot_scenario::budget::Thinking;
use baudbot_sim::model::RobotSpec;

use crate::error::Refused;
use crate::replay;

/// The answering times of the brains of a recording, by their robots.
#[derive(Default)]
pub(super) struct Measured(BTreeMap<String, (v1::Durations, &'static str)>);

impl Measured {
    pub(super) fn of_recording(path: &Path) -> anyhow::Result<Self> {
        let recorded = replay::recorded_run(path).map_err(|error| replay::refused(path, &error))?;
        let of = |robot: &v1::RobotThinking| {
            // Brains that follow the wall clock are measured by that.
            let wall = robot.wall.map(|durations| (durations, "by the wall clock"));
            let processor = || robot.processor.map(|durations| (durations, "by the processor time"));
            Some((robot.robot.clone(), wall.or_else(processor)?))
        };
        let measured: BTreeMap<_, _> = recorded.thinking().iter().filter_map(of).collect();
        if measured.is_empty() {
            return Err(Refused::error(format!(
                "--measured {}: no thinking time was measured in that run. It is measured in real time, and in lockstep for brains that are programs: baudbot run --brain 'exec:…' --record {}",
                path.display(),
                path.display()
            )));
        }
        Ok(Self(measured))
    }

    /// Refuses a recording that has none of these robots.
    pub(super) fn check<'a>(
        &self,
        path: Option<&Path>,
        robots: impl Iterator<Item = &'a RobotSpec>,
    ) -> anyhow::Result<()> {
        let Some(path) = path else { return Ok(()) };
        let mut robots = robots.peekable();
        if robots.peek().is_none() || robots.any(|robot| self.0.contains_key(&robot.name)) {
            return Ok(());
        }
        let known: Vec<_> = self.0.keys().map(|name| format!("`{name}`")).collect();
        Err(Refused::error(format!(
            "--measured {}: it has thinking times of {}, but of none of the robots given",
            path.display(),
            known.join(", ")
        )))
    }

    /// The thinking time of a robot, if it was measured.
    pub(super) fn of(&self, robot: &RobotSpec) -> Option<Thinking> {
        let (durations, _) = self.0.get(&robot.name)?;
        let v1::Durations { min_ns, p50_ns, max_ns, .. } = *durations;
        Some(Thinking { least_ns: min_ns, typical_ns: p50_ns, most_ns: max_ns })
    }

    /// The thinking time of a robot in words, if it was measured.
    pub(super) fn told(&self, robot: &RobotSpec) -> Option<String> {
        let Some((durations, clock)) = self.0.get(&robot.name) else {
            return (!self.0.is_empty())
                .then(|| "  thinking time of the scenario, as none was measured\n".to_owned());
        };
        let [least, median, p95, most] =
            [durations.min_ns, durations.p50_ns, durations.p95_ns, durations.max_ns]
                .map(|ns| duration(ns as f64));
        let turns = count(usize::try_from(durations.count).unwrap_or(usize::MAX), "turn");
        Some(format!(
            "  thinking time measured {clock} in {turns}: {least} to {most}, median {median}, 95th percentile {p95}\n"
        ))
    }
}
