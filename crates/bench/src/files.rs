//! What was measured, for programs.

use anyhow::Context;
use baudbot_bench::catalogue::Workload;
use baudbot_bench::outcome::Outcome;
use serde::Serialize;
use serde_json::json;

/// All of it, each repeat with its calibration.
pub(super) fn json(measured: &[(&Workload, Outcome)]) -> anyhow::Result<String> {
    let workload = |(workload, outcome): &(&Workload, Outcome)| {
        let [min, max] = outcome.spread();
        json!({
            "workload": outcome.workload,
            "summary": workload.summary,
            "unit": outcome.unit,
            "median": outcome.median(),
            "min": min,
            "max": max,
            "median_per_million_rounds": outcome.median_per_million_rounds(),
            "samples": outcome.samples,
            "peak_memory_bytes": outcome.peak_memory_bytes,
            "threads": outcome.threads,
            "state_hash": outcome.hash,
            "state_hash_ticks": outcome.hash_ticks,
            "beside": outcome.beside,
            "median_ratio_to_beside": outcome.beside.as_ref().map(|beside| beside.median_ratio(outcome)),
            "notes": outcome.notes,
        })
    };
    let all = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "debug_build": cfg!(debug_assertions),
        "workloads": measured.iter().map(workload).collect::<Vec<_>>(),
    });
    let text = serde_json::to_string_pretty(&all).context("cannot write what was measured")?;
    Ok(text + "\n")
}

/// A line of the table in CSV.
#[derive(Serialize)]
struct Line<'a> {
    workload: &'a str,
    unit: &'a str,
    median: f64,
    min: f64,
    max: f64,
    median_per_million_rounds: f64,
    peak_memory_bytes: Option<u64>,
    threads: usize,
    state_hash: Option<&'a str>,
}

/// A line a workload.
pub(super) fn csv(measured: &[(&Workload, Outcome)]) -> anyhow::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (_, outcome) in measured {
        let [min, max] = outcome.spread();
        let line = Line {
            workload: &outcome.workload,
            unit: &outcome.unit,
            median: outcome.median(),
            min,
            max,
            median_per_million_rounds: outcome.median_per_million_rounds(),
            peak_memory_bytes: outcome.peak_memory_bytes,
            threads: outcome.threads,
            state_hash: outcome.hash.as_deref(),
        };
        writer.serialize(line).context("cannot write what was measured")?;
    }
    let bytes = writer.into_inner().context("cannot write what was measured")?;
    String::from_utf8(bytes).context("cannot write what was measured")
}
