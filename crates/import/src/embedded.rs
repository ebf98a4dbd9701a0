//! The scenarios, experiments and exercises that each program has in it, wherever it is installed.

mod list {
    include!(concat!(env!("OUT_DIR"), "/embedded.rs"));
}

use list::{EXERCISES, EXPERIMENTS, PROGRAMS, SCENARIOS};

/// Scenarios, with their texts, in the order of their names: `wander`, `devices/laser`.
pub fn scenarios() -> impl Iterator<Item = (&'static str, &'static str)> {
    SCENARIOS.iter().copied()
}

/// The same of experiments, without those that start programs of the repository.
pub fn experiments() -> impl Iterator<Item = (&'static str, &'static str)> {
    EXPERIMENTS.iter().copied()
}

/// The same of exercises, for `baudbot grade`.
pub fn exercises() -> impl Iterator<Item = (&'static str, &'static str)> {
    EXERCISES.iter().copied()
}

/// Programs of microcontrollers that these scenarios refer to: their paths below the folder of scenarios, and their bytes.
pub fn programs() -> impl Iterator<Item = (&'static str, &'static [u8])> {
    PROGRAMS.iter().copied()
}

/// The text of this scenario, if there is one of this name.
pub fn scenario(name: &str) -> Option<&'static str> {
    found(SCENARIOS, name)
}

/// The text of this experiment, if there is one of this name.
pub fn experiment(name: &str) -> Option<&'static str> {
    found(EXPERIMENTS, name)
}

/// The text of this exercise, if there is one of this name.
pub fn exercise(name: &str) -> Option<&'static str> {
    found(EXERCISES, name)
}

fn found(all: &[(&'static str, &'static str)], name: &str) -> Option<&'static str> {
    all.iter().find(|(other, _)| *other == name).map(|(_, text)| *text)
}

/// The summary in one line, for lists: its description, or else the first sentence of its first comment.
pub fn summary(text: &str) -> String {
    let described = text.lines().find_map(|line| line.strip_prefix("description = \"")?.strip_suffix('"'));
    if let Some(description) = described {
        return description.to_owned();
    }
    let comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    let words: Vec<_> = comment.take_while(|line| !line.is_empty()).collect();
    let whole = words.join(" ");
    let end =
        whole.find(['?', ':']).map_or(whole.len(), |end| end + usize::from(whole[end..].starts_with('?')));
    whole[..end].trim_end_matches('.').to_owned()
}

/// The brains that the first comment of a scenario's text shows: what its first `baudbot run` has after `--brain`.
pub fn shown_brains(text: &str) -> Vec<&str> {
    let mut comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim_start);
    let command = comment.find(|line| line.starts_with("baudbot run "));
    let words: Vec<_> = command.unwrap_or_default().split_whitespace().collect();
    words.windows(2).filter(|pair| pair[0] == "--brain").map(|pair| pair[1]).collect()
}

/// The scenarios that a wrong name may mean, by the last parts of their names. A file of another name is likely, so that a third of
/// it may be wrong at most.
pub fn nearest(wrong: &str) -> Vec<&'static str> {
    near(wrong, SCENARIOS)
}

/// The same of experiments.
pub fn nearest_experiments(wrong: &str) -> Vec<&'static str> {
    near(wrong, EXPERIMENTS)
}

/// The same of exercises.
pub fn nearest_exercises(wrong: &str) -> Vec<&'static str> {
    near(wrong, EXERCISES)
}

fn near(wrong: &str, all: &[(&'static str, &'static str)]) -> Vec<&'static str> {
    let wrong = last(wrong.strip_suffix(".toml").unwrap_or(wrong));
    let letters: Vec<char> = wrong.chars().collect();
    let is_near = |name: &&str| {
        last(name).contains(wrong) || 3 * baudbot_fields::edits(&letters, last(name)) <= letters.len()
    };
    let names = all.iter().map(|(name, _)| *name);
    let near = baudbot_fields::nearest(wrong, names, |name| last(name));
    near.into_iter().filter(is_near).collect()
}

fn last(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_a_summary_of_one_line() {
        for (name, text) in scenarios().chain(experiments()).chain(exercises()) {
            let summary = summary(text);
            assert!((10..=140).contains(&summary.len()), "{name}: {summary}");
        }
    }

    #[test]
    fn experiments_that_need_a_program_of_the_repository_are_not_built_in() {
        assert_eq!((experiment("follow"), experiment("tune-follow")), (None, None));
        for (name, text) in experiments() {
            assert!(!text.contains("exec = ") && !text.contains("exec:"), "{name}");
        }
        assert!(experiment("baud-vs-speed").is_some() && experiment("tune-sweeper").is_some());
    }

    #[test]
    fn a_slip_of_the_pen_is_understood() {
        for (wrong, meant) in
            [("wandr", "wander"), ("lazer", "devices/laser"), ("scenarios/sweper.toml", "sweeper")]
        {
            assert_eq!(nearest(wrong), [meant]);
        }
        assert_eq!(nearest("something-quite-different.toml"), [""; 0]);
        assert_eq!(nearest("nowhere.toml"), [""; 0]);
    }
}
