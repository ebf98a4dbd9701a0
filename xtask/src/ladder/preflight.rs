//! Before anything runs: what is missing on this machine, and which release checks are due.

use super::{End, Run};
use crate::needs::Missing;
use crate::records;
use crate::sections::{self, Section};
use crate::shell::Failure;

impl Run<'_> {
    /// The sections that can run here; `None` if something is missing that they must have.
    pub(super) fn preflight(
        &mut self,
        sections: &[&'static Section],
    ) -> Result<Option<Vec<&'static Section>>, Failure> {
        let root = self.shell.place.root.clone();
        let needs = || sections.iter().flat_map(|section| section.needs);
        let mut missing = Missing::of(needs(), &root);
        if self.plan.install && missing.can_be_installed() {
            println!("installing {}", missing.words());
            missing.install(&self.shell)?;
            missing = Missing::of(needs(), &root);
        }
        if missing.is_empty() {
            return Ok(Some(sections.to_vec()));
        }
        let mut kept = Vec::new();
        let mut refused = Vec::new();
        for &section in sections {
            let lacks = Missing::of(section.needs, &root);
            if lacks.is_empty() {
                kept.push(section);
            } else if self.passes_over(section) {
                self.ends.push((section, End::LeftOut(format!("{} is missing", lacks.words()))));
            } else {
                refused.push((section.name, lacks.words()));
            }
        }
        if refused.is_empty() {
            return Ok(Some(kept));
        }
        eprintln!("nothing has been run: some tools are missing");
        for (name, words) in refused {
            eprintln!("  {name}: {words}");
        }
        eprintln!("{}", missing.remedy());
        Ok(None)
    }

    /// A release check that has not been green for too long is a failure.
    pub(super) fn judge_release_checks(&self) -> Result<(), Failure> {
        let root = &self.shell.place.root;
        if !records::has_its_past(root) {
            let words = "the ages of release checks are not known: this is no clone with all of its past";
            if self.shell.place.ci {
                return Err(Failure::Wrong(format!("{words} (git fetch --unshallow)")));
            }
            println!("{words}");
            return Ok(());
        }
        let due = sections::overdue(&records::greens(root)?, |commit| records::commits_since(root, commit));
        if due.is_empty() {
            return Ok(());
        }
        let names: Vec<_> = due.iter().map(|(name, age)| format!("{name} ({age})")).collect();
        Err(Failure::Wrong(format!(
            "these release checks were last green more than {} commits ago: {}; run ./test {} and commit \
             xtask/release-checks.toml",
            sections::OLDEST,
            names.join(", "),
            due.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
        )))
    }

    /// Under continuous integration the release check whose turn it is, if there is one that is short enough; `None` if its
    /// tools are missing.
    pub(super) fn release_check_of_this_run(&mut self) -> Result<Option<Vec<&'static Section>>, Failure> {
        if !self.shell.place.ci {
            return Ok(Some(Vec::new()));
        }
        let root = &self.shell.place.root;
        let turn = records::commits(root);
        let next = sections::next_release_check(&records::greens(root)?, &self.times, turn, |commit| {
            records::commits_since(root, commit)
        });
        let Some(section) = next else {
            println!("no release check is known to be short enough to come along");
            return Ok(Some(Vec::new()));
        };
        println!("the release check whose turn it is: {}", section.name);
        self.preflight(&[section])
    }
}
