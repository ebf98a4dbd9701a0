//! The measurements as the table of a page of the manual: all of it from one run, with the commit and the processor.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread;

use anyhow::Context;
use baudbot_bench::catalogue::Workload;
use baudbot_bench::outcome::Outcome;

use crate::table::figure;

/// The lines before the table, and behind it.
const BEGIN: &str = "<!-- figures: made by baudbot-bench --page -->";
const END: &str = "<!-- end -->";

/// Puts the table of a run in the place of the page's.
pub(super) fn write(path: &Path, measured: &[(&Workload, Outcome)]) -> anyhow::Result<()> {
    let name = path.display();
    let page = fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
    let (head, rest) = page.split_once(BEGIN).with_context(|| format!("{name} has no line `{BEGIN}`"))?;
    let (_, tail) =
        rest.split_once(END).with_context(|| format!("{name} has no line `{END}` behind that"))?;
    let page = format!("{head}{BEGIN}\n\n{}\n{END}{tail}", table(&commit(path)?, measured));
    fs::write(path, page).with_context(|| format!("cannot write {name}"))
}

fn table(commit: &str, measured: &[(&Workload, Outcome)]) -> String {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let processor = processor().map_or_else(String::new, |name| format!(" of an {name}"));
    let mut text = format!(
        "One run of `baudbot-bench` at commit {commit}, on {threads} logical processors{processor}:\n\n\
         | workload | median | min | max | unit |\n|---|---|---|---|---|\n"
    );
    for (_, outcome) in measured {
        let [least, greatest] = outcome.spread();
        let [median, least, greatest] = [outcome.median(), least, greatest].map(figure);
        let _ =
            writeln!(text, "| {} | {median} | {least} | {greatest} | {} |", outcome.workload, outcome.unit);
    }
    text
}

/// The commit that the page is part of; what was built from other files is of none.
fn commit(page: &Path) -> anyhow::Result<String> {
    let folder = page.parent().filter(|folder| folder.is_dir()).unwrap_or_else(|| Path::new("."));
    let git = |arguments: &[&str]| -> anyhow::Result<String> {
        let done =
            Command::new("git").arg("-C").arg(folder).args(arguments).output().context("cannot run git")?;
        anyhow::ensure!(done.status.success(), "git {} failed", arguments.join(" "));
        Ok(String::from_utf8_lossy(&done.stdout).trim().to_owned())
    };
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    anyhow::ensure!(
        changed.is_empty(),
        "--page: there are changes without a commit; commit them, build, and measure again"
    );
    git(&["rev-parse", "--short=10", "HEAD"])
}

fn processor() -> Option<String> {
    let all = fs::read_to_string("/proc/cpuinfo").ok()?;
    let name = all.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'))?.1;
    Some(name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use baudbot_bench::catalogue;
    use regex::Regex;

    use super::*;

    const PAGE: &str = include_str!("../../../docs/explanation/performance.md");

    /// Figures that are written by hand stay when the program changes.
    #[test]
    fn the_manual_has_no_speed_that_a_run_did_not_write_there() {
        let (head, rest) = PAGE.split_once(BEGIN).unwrap();
        let (made, tail) = rest.split_once(END).unwrap();
        let speed = Regex::new(
            r"\d[\d.,]*( to [\d.,]+)? ?(M|k)?\s*(steps?|robot-steps?|rays?|turns?|ticks?|control cycles?|times|×|µs|ms|%|MB)(\W|$)",
        )
        .unwrap();
        let by_hand: Vec<_> = head
            .lines()
            .chain(tail.lines())
            .filter(|line| speed.is_match(line) || line.starts_with("| W"))
            .collect();
        assert!(by_hand.is_empty(), "{by_hand:#?}");
        let known = catalogue::select(&[]).unwrap();
        for row in made.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| workload")) {
            let name = row.trim_start_matches("| ").split(" |").next().unwrap();
            assert!(known.iter().any(|workload| workload.name == name), "{name}");
        }
        assert_eq!(made.matches("at commit").count(), usize::from(made.contains("| workload")), "{made}");
    }

    #[test]
    fn a_table_names_its_commit_once() {
        let text = table("0123456789", &[]);
        assert!(text.starts_with("One run of `baudbot-bench` at commit 0123456789, on "), "{text}");
    }
}
