//! Runs in batches, for searches whose next runs depend on those before: they go into the journal, and those that it has are not done again.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::error::Error;
use crate::experiment::Experiment;
use crate::journal::Journal;
use crate::outputs::Folder;
use crate::pool::Workers;
use crate::run_record::{Row, Task};
use crate::sweep::{self, Options};

/// All rows of a search, with the journal that they are in.
pub(crate) struct Batches<'a> {
    experiment: &'a Experiment,
    options: &'a Options<'a>,
    pub(crate) journal: &'a mut Journal,
    pub(crate) rows: BTreeMap<u64, Row>,
    pub(crate) workers: Workers,
}

impl<'a> Batches<'a> {
    /// The batches of a search that goes on with what its journal has.
    pub(crate) fn new(
        experiment: &'a Experiment,
        options: &'a Options<'a>,
        folder: &Folder,
        journal: &'a mut Journal,
    ) -> Result<Self, Error> {
        let rows = journal.rows()?.map(|row| row.map(|row| (row.run, row))).collect::<Result<_, _>>()?;
        let workers = options.workers(sweep::world_name(folder.id(), options.out));
        Ok(Self { experiment, options, journal, rows, workers })
    }

    /// Does those runs of a batch that are missing, of so many that there may be. Returns how long they took, one after the other, and
    /// how many they were.
    pub(crate) fn run(&mut self, tasks: Vec<Task>, most: u64) -> Result<(Duration, u64), Error> {
        self.run_while(tasks, most, |_| {}, || true)
    }

    /// There are no more runs.
    pub(crate) fn finish(&self) -> Result<(), Error> {
        self.workers.finish(self.experiment)
    }

    /// The same with a look at each row as it comes, and as long as others are to begin. Runs begin in their order, and those that have
    /// begun are done to their end: so those that are done are the first of the batch.
    pub(crate) fn run_while(
        &mut self,
        tasks: Vec<Task>,
        most: u64,
        look: impl Fn(&Row),
        goes_on: impl Fn() -> bool + Send + Sync,
    ) -> Result<(Duration, u64), Error> {
        let missing: Vec<_> = tasks.into_iter().filter(|task| !self.rows.contains_key(&task.run)).collect();
        let (mut time, mut count) = (Duration::ZERO, 0);
        let options = self.options;
        (options.progress)(self.rows.len() as u64, most);
        let (journal, rows) = (&mut *self.journal, &mut self.rows);
        let worked = self.workers.work(
            self.experiment,
            missing.into_iter().take_while(|_| goes_on()),
            options.stop,
            |row, took| {
                time += took;
                count += 1;
                look(&row);
                journal.append(&row)?;
                rows.insert(row.run, row);
                (options.progress)(rows.len() as u64, most);
                Ok(())
            },
        );
        let synced = self.journal.sync();
        worked.and(synced).map(|()| (time, count))
    }
}
