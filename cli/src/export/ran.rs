//! The title of a recorded run in pictures: taken from the run itself, and not from the scenario's file.

use std::collections::BTreeSet;

use baudbot_plot::caption;
use baudbot_proto::v1::ReplayEventKind;
use baudbot_recording::RecordedRun;
use baudbot_sim::{Scenario, World};

/// The data of a run, known beforehand or collected while it is simulated again.
pub(super) struct Ran {
    about: String,
    brains: Vec<String>,
    links: Vec<String>,
    seed: u64,
    /// Ticks before which a manual change was made.
    changed: BTreeSet<u64>,
}

impl Ran {
    pub(super) fn of(recorded: &RecordedRun) -> Self {
        let of_kind = |kind| recorded.events().iter().filter(move |event| event.kind() == kind);
        let changed: BTreeSet<_> = of_kind(ReplayEventKind::Change).map(|event| event.tick).collect();
        let mut brains: Vec<_> = of_kind(ReplayEventKind::Brain)
            .filter_map(|event| brain(&event.text))
            .map(str::to_owned)
            .collect();
        if brains.is_empty() && recorded.inputs() > 0 {
            brains.push("a brain from before the recording".to_owned());
        }
        let scenario: &Scenario = recorded.scenario();
        let about = caption::about(scenario, !changed.is_empty());
        Self { about, brains, links: Vec::new(), seed: scenario.seed, changed }
    }

    /// Whether a manual change was made before this tick.
    pub(super) fn is_changed(&self, tick: u64) -> bool {
        self.changed.contains(&tick)
    }

    /// Sees what the run's cables are; they may be changed by hand.
    pub(super) fn see(&mut self, world: &World) {
        if self.links.is_empty() || self.is_changed(world.tick()) {
            self.links.extend(world.robots().map(|robot| caption::link(&robot.spec().link)));
            self.links.sort_unstable();
            self.links.dedup();
        }
    }

    /// The scenario's description, or its changes.
    pub(super) fn about(&self) -> &str {
        &self.about
    }

    /// The brains that drove, their links, and the seed.
    pub(super) fn facts(&self) -> String {
        caption::facts(&self.brains, &self.links, self.seed)
    }
}

/// The brain that came, if the event is about that: names of robots have no backticks.
fn brain(event: &str) -> Option<&str> {
    event.strip_prefix('`')?.rsplit_once("` drives `").map(|(brain, _)| brain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brain_is_what_drives() {
        assert_eq!(brain("`avoid:forward=0.3` drives `alice`, `bob`"), Some("avoid:forward=0.3"));
        assert_eq!(brain("`a` drives `b` drives `alice`"), Some("a` drives `b"));
        assert_eq!(brain("the brain of `alice` is gone: its stream ended"), None);
    }
}
