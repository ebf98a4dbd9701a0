//! The report of a run: its expected duration, and at the end the results of its sections.

use std::io::IsTerminal as _;
use std::process::ExitCode;

use super::{End, Run};
use crate::records::{self, Repeats};
use crate::sections::Section;
use crate::shell::Failure;

/// So many expected seconds must have passed before they tell the pace of a machine.
const LEAST_TELLING_S: u64 = 60;

impl Run<'_> {
    /// The expected duration of sections, in words.
    pub(super) fn expected(&self, sections: &[&'static Section]) -> String {
        let times: Vec<_> = sections
            .iter()
            .filter_map(|section| self.times.get(section.name))
            .map(|time| time.wall_s)
            .collect();
        if times.is_empty() {
            "no time is known".to_owned()
        } else {
            format!("about {}", in_words((times.iter().sum::<u64>() as f64 * self.pace()).round() as u64))
        }
    }

    /// The time that this machine takes, by the sections that have passed so far, for a second on the one where times were
    /// measured.
    pub(super) fn pace(&self) -> f64 {
        let passed = self.ends.iter().filter_map(|(section, end)| match end {
            End::Passed(time) => Some((time.wall_s, self.times.get(section.name)?.wall_s)),
            End::Resumed | End::Failed(_, _) | End::LeftOut(_) => None,
        });
        let (took_s, expected_s) =
            passed.fold((0, 0), |sum, (took_s, expected_s)| (sum.0 + took_s, sum.1 + expected_s));
        // Short ones tell little.
        if expected_s < LEAST_TELLING_S { 1.0 } else { took_s as f64 / expected_s as f64 }
    }

    /// Says where it was interrupted, and how to go on.
    pub(super) fn interrupted(&self) -> ExitCode {
        println!();
        let (passed, failed, _) = self.table();
        let name = self.ends.last().map_or("", |(section, _)| section.name);
        // The section that was interrupted has not failed.
        let failed: Vec<_> = failed.into_iter().filter(|failed| *failed != name).collect();
        let failed =
            if failed.is_empty() { String::new() } else { format!(", {} failed", failed.join(", ")) };
        println!(
            "interrupted in {name} after {} s; {passed} passed{failed}; go on with ./test {}--resume",
            self.begin.elapsed().as_secs(),
            self.plan.call.iter().map(|word| format!("{word} ")).collect::<String>()
        );
        ExitCode::from(130)
    }

    /// Sums up, with so many sections not begun.
    pub(super) fn finish(&self, not_begun: usize) -> Result<ExitCode, Failure> {
        println!();
        let (passed, failed, left_out) = self.table();
        self.write_times()?;
        self.tell_repeats();
        for line in &self.not_checked {
            println!("{line}");
        }
        let what = if self.plan.repeat > 1 { "rounds" } else { "sections" };
        let seconds = self.begin.elapsed().as_secs();
        if let Some(first) = failed.first() {
            let rest = if not_begun > 0 { format!("; {not_begun} not begun") } else { String::new() };
            let words = if self.plan.asked.iter().any(|word| word == "all") { "all " } else { "" };
            println!("FAILED after {seconds} s: {}; {passed} {what} passed{rest}", failed.join(", "));
            println!(
                "when it is mended: ./test {first}, and ./test {words}--from {first} for what comes behind"
            );
        } else if left_out.is_empty() && self.not_checked.is_empty() {
            println!("all {passed} {what} passed in {seconds} s");
        } else {
            let left_out = left_out
                .into_iter()
                .chain((!self.not_checked.is_empty()).then(|| "what is named above".to_owned()));
            println!(
                "{passed} {what} passed in {seconds} s; not run: {}",
                left_out.collect::<Vec<_>>().join(", ")
            );
        }
        // The line that continuous integration reads.
        if !std::io::stdout().is_terminal() {
            println!("{passed} passed, {} failed", failed.len());
        }
        Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Prints what became of each section: how many passed, and which failed or were left out.
    fn table(&self) -> (usize, Vec<&'static str>, Vec<String>) {
        let (mut passed, mut failed, mut left_out) = (0, Vec::new(), Vec::new());
        for (section, end) in &self.ends {
            match end {
                End::Passed(time) => {
                    passed += 1;
                    println!("{:6} s  {:6} processor s  {}", time.wall_s, time.processor_s, section.name);
                }
                End::Resumed => {
                    passed += 1;
                    println!("   passed before            {}", section.name);
                }
                End::Failed(wall_s, failure) => {
                    println!("{wall_s:6} s  FAILED              {}: {failure}", section.name);
                    failed.push(section.name);
                }
                End::LeftOut(why) => left_out.push(format!("{} ({why})", section.name)),
            }
        }
        (passed, failed, left_out)
    }

    /// Keeps how long sections took, if that is asked for.
    fn write_times(&self) -> Result<(), Failure> {
        let passed = self.ends.iter().filter_map(|(section, end)| match end {
            End::Passed(time) => Some((section.name.to_owned(), time.clone())),
            End::Resumed | End::Failed(_, _) | End::LeftOut(_) => None,
        });
        if self.plan.write_times {
            records::write_times(&self.shell.place.root, passed.collect())?;
        }
        Ok(())
    }

    fn tell_repeats(&self) {
        let Some((state, _)) = self.tree.as_ref().filter(|_| self.plan.repeat > 1) else { return };
        let repeats = Repeats::of(&self.shell.place);
        for section in &self.plan.sections {
            let (passed, failed) = repeats.counts(state, section.name);
            println!(
                "{}: on this state of the tree {passed} rounds passed and {failed} failed so far",
                section.name
            );
        }
    }
}

/// A duration as people say it.
pub(crate) fn in_words(seconds: u64) -> String {
    match seconds {
        0..90 => format!("{seconds} s"),
        90..5400 => format!("{} min", (seconds + 30) / 60),
        _ => format!("{:.1} h", seconds as f64 / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn durations_are_said_as_people_say_them() {
        assert_eq!([40, 89, 90, 1800, 7200].map(in_words), ["40 s", "89 s", "2 min", "30 min", "2.0 h"]);
    }
}
