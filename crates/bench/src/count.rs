//! `baudbot-bench --instructions`: counts, printed and compared with those that are known.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::Context;
use baudbot_bench::catalogue::Workload;
use baudbot_bench::instructions::{self, Count, Known, TOLERANCE};
use serde_json::json;

use crate::args::Args;
use crate::{print, this_program, write};

/// Counts, prints and compares.
pub(super) fn run(args: &Args, chosen: &[&'static Workload]) -> anyhow::Result<ExitCode> {
    let known = args.check.as_deref().map(read).transpose()?;
    let here = Here::find();
    if let Some(not_compared) = known.as_ref().and_then(|known| here.differs(known)) {
        print(&format!("{not_compared}\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let program = this_program()?;
    let mut counts = Vec::new();
    for workload in chosen.iter().filter(|workload| !args.workloads.is_empty() || workload.has_ticks()) {
        let count = instructions::count(|| Command::new(&program), workload);
        counts.push(count.with_context(|| workload.name)?);
    }
    if let Some(path) = &args.renew {
        write(path, &file(&here, &counts))?;
    }
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(
            &json!({ "rustc": here.rustc, "arch": here.arch, "counts": counts }),
        )?;
        write(path, &(text + "\n"))?;
    }
    if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
        print(&table(&counts, known.as_ref()))?;
    }
    let more = known.is_some_and(|known| counts.iter().any(|count| is_too_much(known.ratio(count))));
    Ok(if more { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// The compiler and the processor here.
struct Here {
    rustc: String,
    arch: &'static str,
}

impl Here {
    fn find() -> Self {
        let said = Command::new("rustc").arg("--version").output().ok();
        let rustc = said.map(|said| String::from_utf8_lossy(&said.stdout).trim().to_owned());
        Self { rustc: rustc.unwrap_or_default(), arch: std::env::consts::ARCH }
    }

    /// The reason why counts cannot be compared with these.
    fn differs(&self, known: &Known) -> Option<String> {
        let told = |what, known: &str, here: &str| {
            format!("not compared: the known counts are of {what} `{known}`, and here is `{here}`")
        };
        if known.arch != self.arch {
            return Some(told("the architecture", &known.arch, self.arch));
        }
        (known.rustc != self.rustc).then(|| told("the compiler", &known.rustc, &self.rustc))
    }
}

fn read(path: &Path) -> anyhow::Result<Known> {
    let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    toml::from_str(&text).with_context(|| format!("{}", path.display()))
}

/// The file of known counts.
fn file(here: &Here, counts: &[Count]) -> String {
    let mut text = format!("{HEAD}rustc = {:?}\narch = {:?}\n\n[instructions]\n", here.rustc, here.arch);
    for count in counts {
        let _ = writeln!(text, "{:?} = {:.1} # a {}", count.workload, count.instructions, count.unit);
    }
    text
}

fn table(counts: &[Count], known: Option<&Known>) -> String {
    let mut text = String::new();
    let mut ratios = Vec::new();
    for count in counts {
        let ratio = known.map(|known| known.ratio(count));
        let told = ratio.map_or_else(String::new, told);
        let _ = writeln!(
            text,
            "{:<14}{:>12.1} instructions a {}{told}",
            count.workload, count.instructions, count.unit
        );
        ratios.extend(ratio);
    }
    if ratios.iter().any(|&ratio| is_too_much(ratio)) {
        text += "a workload needs more than is known of it; if it has to, ";
    } else if ratios.iter().any(|ratio| ratio.is_none_or(|ratio| ratio < 1.0 - TOLERANCE)) {
        text += "the known counts are to be renewed: ";
    } else {
        return text;
    }
    text + "`baudbot-bench --instructions --renew crates/bench/instructions.toml` renews them\n"
}

fn told(ratio: Option<f64>) -> String {
    match ratio {
        None => "  not known before".to_owned(),
        Some(ratio) if ratio > 1.0 + TOLERANCE => format!("  MORE than is known: × {ratio:.3}"),
        Some(ratio) if ratio < 1.0 - TOLERANCE => format!("  less than is known: × {ratio:.3}"),
        Some(_) => format!("  within {:.0} % of what is known", 100.0 * TOLERANCE),
    }
}

fn is_too_much(ratio: Option<f64>) -> bool {
    ratio.is_some_and(|ratio| ratio > 1.0 + TOLERANCE)
}

const HEAD: &str = "\
# Instructions of the workloads, by callgrind: `baudbot-bench --instructions --renew crates/bench/instructions.toml` writes this.
# `./test instructions` fails when one needs more than 2 % more. Another compiler, or another architecture, is not compared.
";

#[cfg(test)]
mod tests {
    use super::*;

    fn count(instructions: f64) -> Count {
        Count { workload: "W1/onboard", unit: "step", instructions }
    }

    #[test]
    fn what_is_written_is_read() {
        let here = Here { rustc: "rustc 1.95.0 (x)".to_owned(), arch: "x86_64" };
        let known: Known = toml::from_str(&file(&here, &[count(23_350.04)])).unwrap();
        assert_eq!(known.instructions["W1/onboard"], 23_350.0);
        assert_eq!(here.differs(&known), None);
        let newer = Here { rustc: "rustc 1.96.0".to_owned(), ..here };
        let told = newer.differs(&known).unwrap();
        assert!(
            told.starts_with("not compared: the known counts are of the compiler `rustc 1.95.0 (x)`"),
            "{told}"
        );
    }

    #[test]
    fn more_fails_and_less_is_to_be_renewed() {
        let here = Here { rustc: String::new(), arch: "x86_64" };
        let known: Known = toml::from_str(&file(&here, &[count(100.0)])).unwrap();
        let told = |instructions| table(&[count(instructions)], Some(&known));
        assert!(
            told(103.0).contains("MORE than is known: × 1.030\na workload needs more"),
            "{}",
            told(103.0)
        );
        assert!(
            told(90.0).contains("less than is known: × 0.900\nthe known counts are to be renewed"),
            "{}",
            told(90.0)
        );
        assert!(told(101.0).ends_with("within 2 % of what is known\n"), "{}", told(101.0));
    }
}
