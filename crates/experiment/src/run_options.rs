//! A run of an experiment in the form of options of `baudbot run`.

use std::fmt::Write;

use baudbot_brains::catalogue;
use baudbot_run::assignment;

use crate::experiment::Experiment;
use crate::factor::{Level, Setting};
use crate::run_record::Task;

/// The options that do a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RunOptions {
    /// Arguments of `--brain`.
    pub(crate) brains: Vec<String>,
    /// Arguments of `--parameter`, for programs.
    pub(crate) parameters: Vec<String>,
    /// Arguments of `--set`.
    pub(crate) sets: Vec<String>,
}

impl RunOptions {
    /// The options for these levels of an experiment's fields.
    pub(crate) fn new(experiment: &Experiment, levels: &[Level]) -> Self {
        let mut options = Self { brains: experiment.brains.clone(), ..Self::default() };
        let settings = || levels.iter().flat_map(|level| &level.settings);
        for setting in settings() {
            if let Setting::Brain(brain) = setting {
                options.brains.retain(|text| assignment::split(text).0.is_some());
                options.brains.push(brain.clone());
            }
        }
        for setting in settings() {
            match setting {
                Setting::Parameter { name, value } if experiment.has_programs() => {
                    options.parameters.push(format!("{name}={value}"));
                }
                Setting::Parameter { name, value } => {
                    let takes = |brain: &&mut String| catalogue::takes(assignment::split(brain).1, name);
                    for brain in options.brains.iter_mut().filter(takes) {
                        let and = if brain.contains(':') { ',' } else { ':' };
                        let _ = write!(brain, "{and}{name}={value}");
                    }
                }
                Setting::Scenario { .. } => options.sets.extend(setting.as_override()),
                Setting::Brain(_) => {}
            }
        }
        options
    }

    /// The command that does a run of an experiment, in the experiment's folder.
    pub(crate) fn command(experiment: &Experiment, task: &Task) -> String {
        let mut options = Self::new(experiment, &task.cell.levels);
        options.sets.extend(experiment.seconds.map(|seconds| format!("end.after_s={seconds:?}")));
        options.sets.push(format!("seed={}", task.seed));
        format!("baudbot run {} {}", experiment.scenario, options.options())
    }

    /// The options as words of a shell.
    pub(crate) fn options(&self) -> String {
        let option = |name: &'static str| move |text: &String| format!("{name} {}", quoted(text));
        let brains = self.brains.iter().map(option("--brain"));
        let all = brains.chain(self.parameters.iter().map(option("--parameter")));
        all.chain(self.sets.iter().map(option("--set"))).collect::<Vec<_>>().join(" ")
    }
}

/// The text as a word of a shell, in quotes.
pub(crate) fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}
