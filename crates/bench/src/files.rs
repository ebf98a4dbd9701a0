//! The measurements in a file for programs.

use anyhow::Context;
use baudbot_bench::catalogue::Workload;
use baudbot_bench::outcome::Outcome;
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
