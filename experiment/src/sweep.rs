//! A sweep: what is missing is run, and the outputs are made of what there is.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::check::check;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::fingerprint::fingerprint;
use crate::journal::{Header, Journal};
use crate::outputs::{Content, Folder};
use crate::pool::{Place, Workers};
use crate::summary::Summary;
use crate::{chart, csv_table, parquet_table, table};

/// How a sweep is done.
pub struct Options<'a> {
    /// The folder for its outputs.
    pub out: &'a Path,
    /// What is there already is deleted.
    pub fresh: bool,
    /// Where runs are done.
    pub place: Place,
    /// How many at a time.
    pub jobs: usize,
    /// A sweep that takes long is wanted all the same.
    pub confirmed: bool,
    /// Whoever sets it ends the sweep after the present runs.
    pub stop: &'a AtomicBool,
    /// Is told how many runs of how many are done.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// How a sweep went.
#[derive(Debug)]
pub struct Swept {
    /// It was stopped before its end: there is a journal, and nothing else.
    pub interrupted: bool,
    /// Runs that are done, earlier ones too.
    pub done: u64,
    /// Runs that were there at the start.
    pub resumed: u64,
    /// All runs.
    pub total: u64,
    /// What came of them; empty if it was stopped.
    pub summary: Summary,
    /// The files that it wrote.
    pub files: Vec<PathBuf>,
}

/// How long a sweep will take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Runs that are missing.
    pub runs: u64,
    /// By the wall clock.
    pub time: Duration,
}

impl Estimate {
    fn new(missing: u64, pilots: u64, took: Duration, jobs: usize) -> Self {
        let each_s = took.as_secs_f64() / pilots.max(1) as f64;
        let seconds = each_s * missing as f64 / jobs.max(1) as f64;
        Self { runs: missing, time: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX) }
    }

    /// Whether somebody must confirm it.
    fn is_long(self) -> bool {
        self.runs > MOST_RUNS || self.time > LONGEST
    }
}

/// Runs an experiment, or what is missing of it, and writes what came of it.
///
/// # Errors
/// If the experiment makes no sense, the folder is another's, the sweep is long and not confirmed, a file cannot be
/// written or the server fails. What was run is in the journal, and is not run again.
pub fn sweep(experiment: &Experiment, options: &Options<'_>) -> Result<Swept, Error> {
    let total = experiment.runs()?;
    check(experiment)?;
    let folder = Folder::take(options.out)?;
    if options.fresh {
        [JOURNAL, CSV, PARQUET, SUMMARY].iter().try_for_each(|name| folder.remove(name))?;
    }
    let print = fingerprint(experiment);
    let name = world_name(&print, options.out);
    let mut journal = Journal::open(&folder.file(JOURNAL), &Header::new(&experiment.name, print, total))?;
    let resumed = journal.done();
    let mut runner = Runner { experiment, options, journal: &mut journal, total, name };
    if !options.confirmed {
        runner.pilot()?;
    }
    runner.rest()?;
    let done = journal.done();
    let mut swept = Swept {
        interrupted: done < total,
        done,
        resumed,
        total,
        summary: Summary::default(),
        files: Vec::new(),
    };
    if !swept.interrupted {
        write(experiment, &folder, &journal, &mut swept)?;
    }
    Ok(swept)
}

struct Runner<'a> {
    experiment: &'a Experiment,
    options: &'a Options<'a>,
    journal: &'a mut Journal,
    total: u64,
    name: String,
}

impl Runner<'_> {
    /// A run for each worker, to see how long all will take.
    fn pilot(&mut self) -> Result<(), Error> {
        let jobs = self.options.jobs as u64;
        let missing = self.total - self.journal.done();
        if missing <= jobs {
            return Ok(());
        }
        let took = self.work(jobs)?;
        if self.options.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        let missing = self.total - self.journal.done();
        let estimate = Estimate::new(missing, jobs, took, self.options.jobs);
        if !estimate.is_long() {
            return Ok(());
        }
        Err(Error::Refused(format!(
            "{} runs are to be done, which take about {} here; say --yes if that is meant",
            estimate.runs,
            span(estimate.time)
        )))
    }

    fn rest(&mut self) -> Result<(), Error> {
        self.work(u64::MAX).map(|_| ())
    }

    /// At most so many of the missing runs, and the time that they took, one after the other.
    fn work(&mut self, most: u64) -> Result<Duration, Error> {
        let (experiment, options, total) = (self.experiment, self.options, self.total);
        let done = self.journal.runs();
        let missing = (0..total)
            .filter(|run| done.binary_search(run).is_err())
            .take(usize::try_from(most).unwrap_or(usize::MAX));
        let tasks = missing.map(|run| experiment.task(run));
        let mut time = Duration::ZERO;
        (options.progress)(done.len() as u64, total);
        let workers = Workers { place: options.place.clone(), jobs: options.jobs, name: self.name.clone() };
        workers.work(experiment, tasks, options.stop, |row, took| {
            time += took;
            self.journal.append(&row)?;
            (options.progress)(self.journal.done(), total);
            Ok(())
        })?;
        Ok(time)
    }
}

/// All that is made of the journal.
fn write(
    experiment: &Experiment,
    folder: &Folder,
    journal: &Journal,
    swept: &mut Swept,
) -> Result<(), Error> {
    let mut graphs = chart::Graphs::new(experiment);
    for row in journal.rows()? {
        let row = row?;
        swept.summary.add(experiment, &row);
        graphs.add(experiment, &row);
    }
    folder.write(CSV, |out| csv_table::write(out, experiment, journal.rows()?))?;
    folder.write(PARQUET, |out| parquet_table::write(out, experiment, journal.rows()?))?;
    let text = table::text(experiment, &swept.summary, usize::MAX);
    folder.write(SUMMARY, |out| Ok(std::io::Write::write_all(out, text.as_bytes())?))?;
    swept.files = [CSV, PARQUET, SUMMARY].map(|name| folder.file(name)).to_vec();
    // Of an experiment that had other charts there may be some that nothing else would replace.
    chart::Graphs::names().try_for_each(|name| folder.remove(&name))?;
    for (name, picture) in graphs.draw(experiment) {
        let content = |out: &mut std::io::BufWriter<_>| -> Result<(), Content> {
            Ok(std::io::Write::write_all(out, picture.as_bytes())?)
        };
        folder.write(&name, content)?;
        swept.files.push(folder.file(&name));
    }
    Ok(())
}

/// What worlds of a sweep are called on a server: no two sweeps that run at a time have the same names, and one that goes
/// on has those that it had.
fn world_name(fingerprint: &str, out: &Path) -> String {
    let place = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
    let place =
        place.to_string_lossy().bytes().fold(0_u32, |hash, byte| hash.wrapping_mul(31) + u32::from(byte));
    format!("sweep-{}-{place:08x}", &fingerprint[..8])
}

/// A time for people, no more exact than a guess.
pub fn span(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s if s < 48.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s < 700.0 * 86_400.0 => format!("{:.0} days", s / 86_400.0),
        s => format!("{:.0} years", s / (365.25 * 86_400.0)),
    }
}

const JOURNAL: &str = "rows.jsonl";
const CSV: &str = "rows.csv";
const PARQUET: &str = "rows.parquet";
const SUMMARY: &str = "summary.txt";

/// More runs than these must be confirmed.
const MOST_RUNS: u64 = 10_000;
/// A longer sweep must be confirmed.
const LONGEST: Duration = Duration::from_secs(3600);
