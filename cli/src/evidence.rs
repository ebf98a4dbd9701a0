//! `baudbot evidence`: presets compared with measurements of real robots, and the page of that.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use baudbot_experiment::evidence::page::{File, page, short};
use baudbot_experiment::evidence::{Compared, Comparison, comparisons};
use serde_json::{Value, json};

use crate::args::EvidenceArgs;
use crate::error::Refused;
use crate::text::{self, print, print_json, table, tell};

pub(crate) fn evidence(args: &EvidenceArgs) -> anyhow::Result<ExitCode> {
    match (&args.write, &args.check) {
        (Some(folder), _) => write(folder, args.quiet),
        (None, Some(folder)) => check(folder, args.quiet),
        (None, None) => compare(args),
    }
}

/// Does experiments, and prints the results. Fails if a point disagrees that is not known to.
fn compare(args: &EvidenceArgs) -> anyhow::Result<ExitCode> {
    let chosen = chosen(&args.names)?;
    let mut told = Vec::new();
    let mut is_as_known = true;
    for comparison in &chosen {
        let points =
            comparison.run().with_context(|| format!("cannot run the experiment `{}`", comparison.name))?;
        is_as_known &= points.iter().all(|point| point.agrees == point.measured.disagrees.is_none());
        if args.json {
            told.push(as_json(comparison, &points));
        } else {
            print(&words(comparison, &points, !args.names.is_empty()))?;
        }
    }
    if args.json {
        print_json(&told)?;
    }
    Ok(if is_as_known { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The comparisons of these names or about these presets; all without any.
fn chosen(names: &[String]) -> anyhow::Result<Vec<Comparison>> {
    let all = comparisons();
    let is_of =
        |comparison: &Comparison, name: &String| comparison.name == name || comparison.presets.contains(name);
    if let Some(unknown) = names.iter().find(|name| !all.iter().any(|comparison| is_of(comparison, name))) {
        let known: Vec<_> = all.iter().map(|comparison| comparison.name).collect();
        return Err(Refused::error(format!(
            "there is no comparison `{unknown}`, and none is about a preset of that name; there are {}",
            known.join(", ")
        )));
    }
    let wanted =
        |comparison: &Comparison| names.is_empty() || names.iter().any(|name| is_of(comparison, name));
    Ok(all.into_iter().filter(wanted).collect())
}

/// A line, or the table of all points.
fn words(comparison: &Comparison, points: &[Compared<'_>], whole: bool) -> String {
    let agree = points.iter().filter(|point| point.agrees).count();
    let line =
        format!("{}: {agree} of {} points agree ({})\n", comparison.name, points.len(), comparison.title);
    if !whole {
        return line;
    }
    let head =
        [comparison.x.clone(), format!("measured: {}", comparison.y), "simulated".into(), String::new()];
    let rows: Vec<_> = std::iter::once(head).chain(points.iter().map(row)).collect();
    format!("{line}{}source: {}\n\n", table("  ", &rows), comparison.source)
}

fn row(point: &Compared<'_>) -> [String; 4] {
    let Compared { measured, simulated, agrees } = point;
    let spread = measured.sd.map(|sd| format!(" ± {}", short(sd))).unwrap_or_default();
    let verdict = match (agrees, &measured.disagrees) {
        (true, _) => "agrees".into(),
        (false, Some(why)) => format!("disagrees: {why}"),
        (false, None) => "disagrees".into(),
    };
    [
        measured.at.to_string(),
        format!("{}{spread}", short(measured.mean)),
        format!("{} ± {}", short(simulated.mean), short(simulated.sd)),
        verdict,
    ]
}

fn as_json(comparison: &Comparison, points: &[Compared<'_>]) -> Value {
    let point = |point: &Compared<'_>| {
        let Compared { measured, simulated, agrees } = point;
        json!({
            "at": measured.at.to_string(),
            "measured": { "n": measured.n, "mean": measured.mean, "sd": measured.sd, "range": measured.range },
            "simulated": { "n": simulated.n, "mean": simulated.mean, "sd": simulated.sd,
                           "range": [simulated.min, simulated.max] },
            "agrees": agrees,
            "why_not": measured.disagrees,
        })
    };
    json!({
        "name": comparison.name,
        "title": comparison.title,
        "presets": comparison.presets,
        "source": comparison.source,
        "x": comparison.x,
        "y": comparison.y,
        "points": points.iter().map(point).collect::<Value>(),
    })
}

fn write(folder: &Path, quiet: bool) -> anyhow::Result<ExitCode> {
    for file in made(quiet)? {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)
                .with_context(|| format!("cannot make the folder {}", parent.display()))?;
        }
        text::write(&path, &file.text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn check(folder: &Path, quiet: bool) -> anyhow::Result<ExitCode> {
    let is_old =
        |file: &File| std::fs::read_to_string(folder.join(&file.path)).ok().as_ref() != Some(&file.text);
    let old: Vec<_> = made(quiet)?.into_iter().filter(is_old).collect();
    for file in &old {
        tell!(
            "{} is not up to date; update it with `baudbot evidence --write {}`",
            folder.join(&file.path).display(),
            folder.display()
        );
    }
    Ok(if old.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn made(quiet: bool) -> anyhow::Result<Vec<File>> {
    let tell = |comparison: &Comparison| {
        if !quiet {
            tell!("{}", comparison.title);
        }
    };
    Ok(page(tell)?)
}
