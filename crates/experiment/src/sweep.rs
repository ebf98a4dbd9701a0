//! A sweep: what is missing is run, and the outputs are made of what there is.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use baudbot_fields::printable::PrintableLines;

use crate::check::check;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::experiment::Experiment;
use crate::fingerprint::{build, fingerprint};
use crate::journal::{Header, Journal};
use crate::outputs::{Content, Folder};
use crate::pool::{Place, Workers};
use crate::shard::Shard;
use crate::summary::Summary;
use crate::told::Told;
use crate::{chart, csv_table, resumed, table};

/// The options of a sweep.
pub struct Options<'a> {
    /// The folder for its outputs.
    pub out: &'a Path,
    /// Deletes the old results, once it is clear that this sweep is done.
    pub fresh: bool,
    /// The part of the runs that is done, and kept in a journal from which nothing else is made; `None`: all, and the
    /// outputs.
    pub shard: Option<Shard>,
    /// The place in which runs are done.
    pub place: Place,
    /// The number of simultaneous runs.
    pub jobs: usize,
    /// The time by the wall clock in which a program has to answer, or its run is given up.
    pub brain_timeout: Duration,
    /// A sweep that takes long is wanted all the same.
    pub confirmed: bool,
    /// Once it is set the sweep ends after the present runs.
    pub stop: &'a AtomicBool,
    /// A function that gets the number of runs that are done, and that of all.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
    /// A function that gets notes on the journal that exists: its content, its faults and repairs.
    pub tell: &'a (dyn Fn(&Told) + Sync),
}

impl Options<'_> {
    /// The workers for worlds of this name.
    pub(crate) fn workers(&self, name: String) -> Workers {
        Workers::new(self.place.clone(), self.jobs, name, self.brain_timeout)
    }

    /// Reports that something may be wrong.
    pub(crate) fn warn(&self, text: &str) {
        (self.tell)(&Told::Warning(text.to_owned()));
    }
}

/// The result of a sweep.
#[derive(Debug)]
pub struct Swept {
    /// The sweep was stopped before its end: there is a journal, and nothing else.
    pub interrupted: bool,
    /// Runs that are done, earlier ones too.
    pub done: u64,
    /// Runs that were there at the start, and are not done again.
    pub resumed: u64,
    /// All runs, of the shard if it is one.
    pub total: u64,
    /// The results of the runs; empty if the sweep was stopped.
    pub summary: Summary,
    /// The files that it wrote beside the journal.
    pub files: Vec<PathBuf>,
}

/// Runs an experiment, or what is missing of it, and writes the results.
///
/// # Errors
/// If the experiment is invalid, the folder is another's, the sweep is long and not confirmed, a file cannot be written
/// or the server fails. What was run is in the journal, and is not run again unless it failed.
pub fn sweep(experiment: &Experiment, options: &Options<'_>) -> Result<Swept, Error> {
    let total = experiment.runs()?;
    check(experiment)?;
    let folder = Folder::take(options.out)?;
    let header =
        Header::new(&experiment.name, fingerprint(experiment), build(), total).of_shard(options.shard);
    let mut journal = begin_journal(&folder, &header, options)?;
    let resumed = journal.done();
    let workers = options.workers(world_name(folder.id(), options.out));
    let shard = options.shard.unwrap_or(Shard::WHOLE);
    resumed::tell(experiment, &journal, Some(shard.len(total)), options.tell);
    let mut runner = Runner { experiment, options, journal: &mut journal, total, shard, workers };
    if !options.confirmed {
        let pilot = runner.pilot();
        if pilot.is_err() {
            forget_journal(&folder, options.fresh)?;
        }
        pilot?;
    }
    if options.fresh {
        replace(&folder, runner.journal)?;
    }
    runner.rest()?;
    match options.shard {
        None => finish(experiment, &folder, &journal, resumed, total),
        Some(shard) => finish_shard(experiment, &journal, resumed, shard.len(total)),
    }
}

/// Writes the outputs if all runs are in the journal.
pub(crate) fn finish(
    experiment: &Experiment,
    folder: &Folder,
    journal: &Journal,
    resumed: u64,
    total: u64,
) -> Result<Swept, Error> {
    let mut swept = Swept::new(journal.done(), resumed, total);
    if !swept.interrupted {
        write(experiment, folder, journal, &mut swept)?;
    }
    Ok(swept)
}

/// Finishes a shard, which has no outputs, as means over some of the seeds would mislead.
fn finish_shard(
    experiment: &Experiment,
    journal: &Journal,
    resumed: u64,
    total: u64,
) -> Result<Swept, Error> {
    let mut swept = Swept::new(journal.done(), resumed, total);
    if !swept.interrupted {
        for row in journal.rows()? {
            swept.summary.add(experiment, &row?);
        }
    }
    Ok(swept)
}

impl Swept {
    fn new(done: u64, resumed: u64, total: u64) -> Self {
        let interrupted = done < total;
        Self { interrupted, done, resumed, total, summary: Summary::default(), files: Vec::new() }
    }
}

struct Runner<'a> {
    experiment: &'a Experiment,
    options: &'a Options<'a>,
    journal: &'a mut Journal,
    /// The number of all runs of the experiment.
    total: u64,
    shard: Shard,
    workers: Workers,
}

impl Runner<'_> {
    /// A run for each worker, to see how long all will take.
    fn pilot(&mut self) -> Result<(), Error> {
        let jobs = self.options.jobs as u64;
        let missing = self.missing();
        if missing <= jobs {
            return Ok(());
        }
        let took = self.work(jobs)?;
        if self.options.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        Estimate::new(self.missing(), jobs, took, self.options.jobs).refuse_long("")
    }

    /// The number of missing runs.
    fn missing(&self) -> u64 {
        self.shard.len(self.total).saturating_sub(self.journal.done())
    }

    fn rest(&mut self) -> Result<(), Error> {
        self.work(u64::MAX)?;
        self.workers.finish(self.experiment)
    }

    /// Does the missing runs, so many at most; the time that they took, one after the other.
    fn work(&mut self, most: u64) -> Result<Duration, Error> {
        let (experiment, options, total) = (self.experiment, self.options, self.shard.len(self.total));
        let done = self.journal.runs();
        let missing = self
            .shard
            .runs(self.total)
            .filter(|run| done.binary_search(run).is_err())
            .take(usize::try_from(most).unwrap_or(usize::MAX));
        let tasks = missing.map(|run| experiment.task(run));
        let mut time = Duration::ZERO;
        (options.progress)(done.len() as u64, total);
        let worked = self.workers.work(experiment, tasks, options.stop, |row, took| {
            time += took;
            self.journal.append(&row)?;
            (options.progress)(self.journal.done(), total);
            Ok(())
        });
        let synced = self.journal.sync();
        worked.and(synced).map(|()| time)
    }
}

/// The journal in a folder, or a fresh one beside it: old files are deleted only once nothing can refuse the sweep any more.
pub(crate) fn begin_journal(
    folder: &Folder,
    header: &Header,
    options: &Options<'_>,
) -> Result<Journal, Error> {
    if options.fresh {
        folder.remove(FRESH)?;
    }
    let file = folder.file(if options.fresh { FRESH } else { JOURNAL });
    Journal::open(&file, header, &|text| options.warn(text))
}

/// A fresh journal is not wanted after all.
pub(crate) fn forget_journal(folder: &Folder, fresh: bool) -> Result<(), Error> {
    if fresh { folder.remove(FRESH) } else { Ok(()) }
}

/// A fresh journal takes the place of what is there.
pub(crate) fn keep_journal(folder: &Folder, journal: &mut Journal) -> Result<(), Error> {
    journal.move_to(&folder.file(JOURNAL))
}

/// The same once all that was made of the old one is gone.
pub(crate) fn replace(folder: &Folder, journal: &mut Journal) -> Result<(), Error> {
    remove_outputs(folder)?;
    keep_journal(folder, journal)
}

/// All files that are made of the journal.
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
    #[cfg(feature = "parquet")]
    folder.write(PARQUET, |out| crate::parquet_table::write(out, experiment, journal.rows()?))?;
    // One of before would not be of these rows.
    #[cfg(not(feature = "parquet"))]
    folder.remove(PARQUET)?;
    let text = PrintableLines(table::text(experiment, &swept.summary, usize::MAX)).to_string();
    folder.write(SUMMARY, |out| Ok(std::io::Write::write_all(out, text.as_bytes())?))?;
    let tables = if cfg!(feature = "parquet") { &[CSV, PARQUET, SUMMARY][..] } else { &[CSV, SUMMARY] };
    swept.files = tables.iter().map(|name| folder.file(name)).collect();
    // The folder may have charts of an experiment that had other ones, which nothing else would replace.
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

/// Removes what an earlier sweep made of its journal.
fn remove_outputs(folder: &Folder) -> Result<(), Error> {
    [CSV, PARQUET, SUMMARY].iter().try_for_each(|name| folder.remove(name))?;
    chart::Graphs::names().try_for_each(|name| folder.remove(&name))
}

/// The name of the worlds of a sweep on a server: no other sweep has the same names, not even in a copy of the folder,
/// and one that goes on has those that it had.
pub(crate) fn world_name(id: &str, out: &Path) -> String {
    let place = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
    let place = place
        .to_string_lossy()
        .bytes()
        .fold(0_u32, |hash, byte| hash.wrapping_mul(31).wrapping_add(u32::from(byte)));
    format!("sweep-{id}-{place:08x}")
}

/// The journal in a folder.
pub(crate) const JOURNAL: &str = "rows.jsonl";
/// The journal of a sweep that is to replace another.
const FRESH: &str = ".rows.jsonl.tmp";
const CSV: &str = "rows.csv";
const PARQUET: &str = "rows.parquet";
const SUMMARY: &str = "summary.txt";
