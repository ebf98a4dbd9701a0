//! `baudbot-bench beside`: another program's workload by turns with ours.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use baudbot_bench::beside::{Other, Pairs};
use baudbot_bench::catalogue::{self, Workload};
use baudbot_bench::measure::Effort;
use baudbot_bench::{Means, worker};
use serde_json::json;

use crate::args::{Args, BesideArgs};
use crate::table::figure;
use crate::{Refused, child_command, print, program, write};

/// A B A B, for each workload.
pub(super) fn run(args: &Args, beside: &BesideArgs) -> anyhow::Result<ExitCode> {
    let chosen = catalogue::select(&beside.workloads).map_err(|error| Refused(error.to_string()))?;
    let other = Other::new(&beside.command, beside.pattern.as_deref());
    let other = other.map_err(|error| Refused(error.to_string()))?;
    let mut all = Vec::new();
    for workload in chosen {
        let pairs = measure(args, beside, workload, &other).with_context(|| workload.name)?;
        if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
            print(&line(&pairs))?;
        }
        all.push(pairs);
    }
    if let Some(path) = &args.json {
        let told = |pairs: &Pairs| {
            let [least, greatest] = pairs.spread();
            json!({ "pairs": pairs, "median_ratio": pairs.median(), "min": least, "max": greatest })
        };
        let all: Vec<_> = all.iter().map(told).collect();
        write(
            path,
            &(serde_json::to_string_pretty(&json!({ "beside": beside.command, "workloads": all }))? + "\n"),
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

fn measure(args: &Args, beside: &BesideArgs, workload: &Workload, other: &Other) -> anyhow::Result<Pairs> {
    let effort = Effort { seconds: args.seconds, repeats: 1 };
    let mut figures = Vec::new();
    for _ in 0..beside.pairs {
        let means = Means { threads: args.threads.into(), program: program(args)? };
        let own = worker::measure(child_command()?, workload, effort, means, |_| {})?.median();
        figures.push([own, other.run(workload.name)?]);
    }
    Ok(Pairs { workload: workload.name.to_owned(), unit: workload.unit.to_owned(), figures })
}

fn line(pairs: &Pairs) -> String {
    let ([own, other], [least, greatest]) = (pairs.medians(), pairs.spread());
    format!(
        "{}: {:.3} × the other ({least:.3} to {greatest:.3}, {} pairs); {} and {} {}\n",
        pairs.workload,
        pairs.median(),
        pairs.figures.len(),
        figure(own),
        figure(other),
        pairs.unit
    )
}
