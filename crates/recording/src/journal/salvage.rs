//! The rest of a journal that has lost something.

use super::kind;
use super::read::{Bytes, Entry, Journal, JournalError, Reading};
use super::restore::Restored;

/// The world of a damaged journal, at the last instant at which its state is proven.
#[derive(Debug)]
pub struct Salvaged {
    /// The world.
    pub restored: Restored,
    /// The beginnings of damage that was passed over, as a later state has all that was before it.
    pub passed: Vec<usize>,
    /// The end of the sound part of the journal, and the number of bytes behind it.
    pub left_out: (usize, usize),
    /// The recorded inputs lead elsewhere from some tick on: the world is that of the last fingerprint before.
    pub differs: Option<JournalError>,
}

impl Journal {
    /// The world of a journal that may be damaged: from its last sound state on, up to what does not follow from it.
    ///
    /// # Errors
    /// If there is no such state, or its scenario or state cannot be used.
    pub fn salvage(bytes: &[u8]) -> Result<Salvaged, JournalError> {
        let (file, beginning) = Bytes::new(bytes)?;
        let mut reading = Reading::at(beginning);
        let mut passed = Vec::new();
        reading.go_on(&file);
        let mut states = file.behind(reading.at).filter(|(_, found)| found.kind == kind::STATE);
        while let Some((state, _)) = states.find(|(at, _)| *at >= reading.at) {
            passed.push(reading.at);
            reading.skip_to(state);
            reading.go_on(&file);
        }
        let journal = reading.journal(&file)?;
        let left_out = (journal.length(), journal.torn());
        passed.retain(|at| *at < journal.length());
        let (restored, differs) = match journal.restore_first(journal.entries.len()) {
            Ok(restored) => (restored, None),
            Err((entry, error)) => {
                let Some(certain) = journal.certain_before(entry) else { return Err(error) };
                (journal.restore_first(certain).map_err(|(_, error)| error)?, Some(error))
            }
        };
        Ok(Salvaged { restored, passed, left_out, differs })
    }

    /// The number of the entries before this one that lead to a world whose fingerprint was compared.
    fn certain_before(&self, entry: usize) -> Option<usize> {
        let before = &self.entries[..entry];
        let certain = before.iter().rposition(|entry| match entry {
            Entry::State(_) => true,
            Entry::At(at) => at.state_hash.is_some(),
            Entry::Settings(_) | Entry::Inputs(_) | Entry::Ports(_) => false,
        })?;
        // The ports of a state stand behind it.
        let ports = before[certain + 1..].iter().take_while(|entry| matches!(entry, Entry::Ports(_)));
        Some(certain + 1 + ports.count())
    }
}
