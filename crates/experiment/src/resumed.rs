//! The messages before an experiment continues with the runs of its journal: the runs that are not done again, and
//! whether a program has changed since.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use baudbot_run::assignment;
use baudbot_run::programs::{PortProgram, Program};

use crate::experiment::Experiment;
use crate::journal::Journal;
use crate::told::Told;

/// Reports the runs that are in the journal, of so many if that is known.
pub(crate) fn tell(experiment: &Experiment, journal: &Journal, total: Option<u64>, tell: &dyn Fn(&Told)) {
    if let Some(note) = note(journal, total) {
        tell(&Told::Note(note));
    }
    let Some(begun) = journal.begun().filter(|_| journal.done() > 0) else { return };
    for file in changed(experiment, begun) {
        let file = file.display();
        tell(&Told::Warning(format!(
            "{file} was changed after runs in the journal; --fresh does them again"
        )));
    }
}

/// The note on the runs that exist; `None` if there are none.
fn note(journal: &Journal, total: Option<u64>) -> Option<String> {
    let (done, repeated, place) = (journal.done(), journal.repeated(), journal.path().display());
    let runs = match total {
        Some(total) => format!("{done} of {total} runs"),
        None => format!("{done} runs"),
    };
    match (done, repeated) {
        (0, 0) => None,
        (_, 0) => Some(format!("{place} (the journal) has {runs}; --fresh does them again")),
        (_, _) => Some(format!(
            "{place} (the journal) has {runs}; {repeated} that failed are done again; --fresh does all again"
        )),
    }
}

/// The files that programs of the experiment consist of, as far as they name them, and that are newer than this.
fn changed(experiment: &Experiment, begun: SystemTime) -> Vec<PathBuf> {
    let brains = || experiment.all_brains().map(|brain| assignment::split(brain).1);
    let folder = &experiment.folder;
    let programs = brains().filter_map(Program::of_brain).flatten();
    let files = programs.flat_map(|program| program.in_folder(folder.clone()).files());
    let at_ports = brains().filter_map(PortProgram::of_brain).flatten();
    let files = files.chain(at_ports.flat_map(|program| program.in_folder(folder.clone()).files()));
    let mut changed: Vec<_> = files.filter(|file| is_newer(file, begun)).collect();
    changed.sort();
    changed.dedup();
    changed
}

fn is_newer(file: &Path, begun: SystemTime) -> bool {
    fs::metadata(file).and_then(|metadata| metadata.modified()).is_ok_and(|changed| changed > begun)
}
