//! The journals of many machines become what one machine would have made of the experiment.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::check::check;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::fingerprint::{build, fingerprint};
use crate::journal::{Contents, Entry, Header, Journal, Purpose};
use crate::outputs::Folder;
use crate::shard::Shard;
use crate::sweep::{self, JOURNAL, Options, Swept};

/// The result of a merge.
#[derive(Debug)]
pub enum Merged {
    /// All runs are there, and so are the outputs.
    Whole(Swept),
    /// Some are not; nothing was written.
    Missing(Missing),
}

/// Runs that no journal has.
#[derive(Debug, PartialEq, Eq)]
pub struct Missing {
    /// The number of runs.
    pub runs: u64,
    /// All runs of the experiment.
    pub total: u64,
    /// The shards of the missing runs; never empty.
    pub shards: Vec<MissingShard>,
}

/// Runs of a shard that no journal has.
#[derive(Debug, PartialEq, Eq)]
pub struct MissingShard {
    /// `None`: no journal is of a shard.
    pub shard: Option<Shard>,
    /// The number of runs.
    pub runs: u64,
    /// The first few.
    pub first: Vec<u64>,
    /// The place of the shard's journal, or the one that it would have beside the others, if that can be computed.
    pub folder: Option<PathBuf>,
}

/// Makes the outputs of an experiment from journals of its shards. Each source is a journal, a folder with one, or a folder of
/// such folders. The journals are only read. Of the options, those about runs do not matter.
///
/// # Errors
/// If a source has no journal, or one of another experiment or build, or two differ about a run; if the folder for the outputs
/// is another's, or a file cannot be read or written.
pub fn merge(experiment: &Experiment, sources: &[PathBuf], options: &Options<'_>) -> Result<Merged, Error> {
    let total = experiment.runs()?;
    check(experiment)?;
    let header = Header::new(&experiment.name, fingerprint(experiment), build(), total);
    match gather(&header, total, sources, options)? {
        Gathered::Missing(missing) => Ok(Merged::Missing(missing)),
        Gathered::Whole { folder, mut journal, resumed } => {
            if options.fresh {
                sweep::replace(&folder, &mut journal)?;
            }
            sweep::finish(experiment, &folder, &journal, resumed, total).map(Merged::Whole)
        }
    }
}

/// The runs of journals, together.
pub(crate) enum Gathered {
    /// All are there, in this journal, which had some before.
    Whole { folder: Folder, journal: Journal, resumed: u64 },
    /// Some are not; nothing was written.
    Missing(Missing),
}

/// Writes the first so many runs of these journals into one; those that are there must be the same.
pub(crate) fn gather(
    header: &Header,
    total: u64,
    sources: &[PathBuf],
    options: &Options<'_>,
) -> Result<Gathered, Error> {
    let warn = |text: &str| options.warn(text);
    let read = |path: &Path| Contents::read(path, header, Purpose::Merge, &warn);
    let mut all = journals(sources)?.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    let chosen = Chosen::new(&all)?;
    if (chosen.runs.partition_point(|run| *run < total) as u64) < total {
        return Ok(Gathered::Missing(chosen.missing(&all, total)));
    }
    let folder = Folder::take(options.out)?;
    let mut journal = sweep::begin_journal(&folder, header, options)?;
    let resumed = journal.done();
    let done = journal.runs();
    if !options.fresh {
        // The results of an earlier merge must not differ either.
        all.push(read(&folder.file(JOURNAL))?);
        Chosen::new(&all)?;
    }
    (options.progress)(resumed, total);
    for (contents, rows) in all.iter().zip(&chosen.rows) {
        let missing = rows.iter().filter(|row| done.binary_search(&row.run).is_err());
        for row in contents.rows_at(missing.map(|row| row.start).collect())? {
            if options.stop.load(Ordering::Relaxed) {
                break;
            }
            journal.append(&row?)?;
            (options.progress)(journal.done(), total);
        }
    }
    journal.sync()?;
    Ok(Gathered::Whole { folder, journal, resumed })
}

/// All journals of the sources, in their order.
fn journals(sources: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for source in sources {
        if source.is_dir() && !source.join(JOURNAL).exists() {
            all.append(&mut journals_in(source)?);
        } else if source.is_dir() {
            all.push(source.join(JOURNAL));
        } else {
            all.push(source.clone());
        }
    }
    Ok(all)
}

/// The journals in the folders of a folder, by their names.
fn journals_in(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries.map_err(Error::file("read", folder))?;
    let mut paths: Vec<_> = entries.iter().map(|entry| entry.path().join(JOURNAL)).collect();
    paths.retain(|path| path.exists());
    paths.sort();
    if paths.is_empty() {
        let place = folder.display();
        return Err(Error::Refused(format!(
            "{place} has no {JOURNAL}, nor has a folder in it; give the folders of the shards, or the one that they are in"
        )));
    }
    Ok(paths)
}

/// A row for each run that there is.
#[derive(Debug, Default)]
struct Chosen {
    /// The runs, sorted.
    runs: Vec<u64>,
    /// The rows of each journal.
    rows: Vec<Vec<Entry>>,
}

impl Chosen {
    /// A `Chosen` with the first of rows that are the same; refuses those that are not. A run that failed everywhere is
    /// one that did, with the same one of its errors whatever the order of the journals.
    fn new(journals: &[Contents]) -> Result<Self, Error> {
        let mut chosen = Self { runs: Vec::new(), rows: vec![Vec::new(); journals.len()] };
        for of_a_run in sorted(journals, |journal| &journal.rows).chunk_by(|a, b| a.1.run == b.1.run) {
            let (first, row) = of_a_run[0];
            if let Some((other, entry)) = of_a_run.iter().find(|(_, entry)| entry.sum != row.sum) {
                return Err(differ(
                    row.run,
                    (&journals[first].path, row.line),
                    (&journals[*other].path, entry.line),
                ));
            }
            chosen.take(first, row);
        }
        let done = chosen.runs.clone();
        for of_a_run in sorted(journals, |journal| &journal.failed).chunk_by(|a, b| a.1.run == b.1.run) {
            let chance = of_a_run.iter().min_by_key(|(_, row)| row.sum);
            if let Some((journal, row)) = chance.filter(|(_, row)| done.binary_search(&row.run).is_err()) {
                chosen.take(*journal, *row);
            }
        }
        chosen.runs.sort_unstable();
        Ok(chosen)
    }

    fn take(&mut self, journal: usize, row: Entry) {
        self.runs.push(row.run);
        self.rows[journal].push(row);
    }

    /// The missing runs of so many.
    fn missing(&self, journals: &[Contents], total: u64) -> Missing {
        let runs = total - self.runs.len() as u64;
        let shards = match count(journals) {
            None => vec![self.missing_of(None, runs, journals, total)],
            Some(count) => {
                let mut done: BTreeMap<Shard, u64> = BTreeMap::new();
                self.runs.iter().for_each(|run| *done.entry(Shard::of(*run, count)).or_default() += 1);
                let missing = |shard: Shard| shard.len(total) - done.get(&shard).copied().unwrap_or(0);
                let lacking = Shard::all(count).filter(|shard| missing(*shard) > 0);
                lacking.map(|shard| self.missing_of(Some(shard), missing(shard), journals, total)).collect()
            }
        };
        Missing { runs, total, shards }
    }

    fn missing_of(&self, shard: Option<Shard>, runs: u64, journals: &[Contents], total: u64) -> MissingShard {
        let all = shard.unwrap_or(Shard::WHOLE).runs(total);
        let first = all.filter(|run| self.runs.binary_search(run).is_err()).take(FIRST).collect();
        MissingShard { shard, runs, first, folder: folder(shard, journals) }
    }
}

/// The rows of all journals with the numbers of these, by run.
fn sorted(journals: &[Contents], rows: impl Fn(&Contents) -> &Vec<Entry>) -> Vec<(usize, Entry)> {
    let of_one = |(number, journal)| rows(journal).iter().map(move |row| (number, *row));
    let mut all: Vec<_> = journals.iter().enumerate().flat_map(of_one).collect();
    all.sort_by_key(|(number, row)| (row.run, *number));
    all
}

/// The number of shards that most journals state.
fn count(journals: &[Contents]) -> Option<u32> {
    let mut of_count: BTreeMap<u32, usize> = BTreeMap::new();
    let counts = journals.iter().filter_map(Contents::shard).map(Shard::count);
    counts.for_each(|count| *of_count.entry(count).or_default() += 1);
    of_count.into_iter().max_by_key(|(_, journals)| *journals).map(|(count, _)| count)
}

/// The place of a shard's journal, or the one that it would have beside the others.
fn folder(shard: Option<Shard>, journals: &[Contents]) -> Option<PathBuf> {
    let folder = |journal: &Contents| {
        journal.path.parent().filter(|_| journal.path.ends_with(JOURNAL)).map(Path::to_owned)
    };
    let own = journals.iter().find(|journal| journal.shard() == shard).and_then(folder);
    own.or_else(|| {
        let by_name = journals.iter().find_map(|journal| {
            let of = folder(journal)?;
            of.ends_with(journal.shard()?.folder()).then_some(of)
        });
        Some(by_name?.with_file_name(shard?.folder()))
    })
}

fn differ(run: u64, a: (&Path, u64), b: (&Path, u64)) -> Error {
    let place = |(path, line): (&Path, u64)| format!("line {line} of {}", path.display());
    Error::Refused(format!(
        "run {run} has different results in {} and {}; they should be the same on every machine: delete the wrong journal, and do \
         its shard again (if a brain is a program of your own: was it changed, or is it not deterministic?)",
        place(a),
        place(b)
    ))
}

/// The number of missing runs of a shard that are named.
const FIRST: usize = 3;
