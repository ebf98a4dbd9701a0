//! The resources of a process, over time.

use std::fs;
use std::time::Duration;

use super::clients::Counts;

/// The server's resources at an instant, and the deeds of its clients by then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    at: Duration,
    megabytes: f64,
    descriptors: f64,
    threads: f64,
    counts: Counts,
}

impl Sample {
    pub(crate) const HEAD: &str =
        "minute  memory MB  descriptors  threads  attaches     frames  worlds  recordings  failures";

    pub(crate) fn take(process: u32, at: Duration, counts: Counts) -> Self {
        let entries =
            |folder: &str| fs::read_dir(format!("/proc/{process}/{folder}")).map_or(0, Iterator::count);
        let pages = fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
        let resident = pages.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok());
        Self {
            at,
            megabytes: resident.expect("the server runs") * 4096.0 / 1e6,
            descriptors: entries("fd") as f64,
            threads: entries("task") as f64,
            counts,
        }
    }

    fn print(&self) {
        let Self {
            at,
            megabytes,
            descriptors,
            threads,
            counts: [attaches, frames, worlds, recordings, failures],
        } = self;
        let minute = at.as_secs_f64() / 60.0;
        println!(
            "{minute:6.1} {megabytes:10.1} {descriptors:12} {threads:8} {attaches:9} {frames:10} {worlds:7} {recordings:11} {failures:9}"
        );
    }
}

/// A figure of a sample.
type Value = fn(&Sample) -> f64;

/// All samples of a run.
#[derive(Default)]
pub(crate) struct Samples(Vec<Sample>);

impl Samples {
    pub(crate) fn add(&mut self, sample: Sample) {
        // Thirty lines, or one a minute.
        let is_due = |before: &Sample| (sample.at.as_secs() / 30) != (before.at.as_secs() / 30);
        if self.0.last().is_none_or(is_due) {
            sample.print();
        }
        self.0.push(sample);
    }

    /// Whether all is flat after the first third.
    pub(crate) fn judge(&self) -> bool {
        let (_, rest) = self.0.split_at(self.0.len() / 3);
        println!("\nafter the first third     mean    change   allowed");
        // The limits hold for a run of any length: an unbounded growth exceeds them in hours.
        let of: [(&str, Value, f64, f64); 3] = [
            ("memory, MB", |sample| sample.megabytes, 0.05, 6.0),
            ("descriptors", |sample| sample.descriptors, 0.1, 12.0),
            ("threads", |sample| sample.threads, 0.1, 4.0),
        ];
        let mut is_good = true;
        for (name, value, share, least) in of {
            let points: Vec<_> = rest.iter().map(|sample| (sample.at.as_secs_f64(), value(sample))).collect();
            let (mean, slope) = line(&points);
            let time = points.last().map_or(0.0, |last| last.0) - points.first().map_or(0.0, |first| first.0);
            let (change, allowed) = (slope * time, f64::max(share * mean, least));
            let is_flat = change <= allowed;
            println!(
                "{name:20} {mean:10.1} {change:9.1} {allowed:9.1}{}",
                if is_flat { "" } else { "   GROWS" }
            );
            is_good &= is_flat;
        }
        is_good
    }
}

/// The mean, and the slope of the line with the least squares.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let over: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let under: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    (y, if under > 0.0 { over / under } else { 0.0 })
}
