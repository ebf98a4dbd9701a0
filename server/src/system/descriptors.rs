//! The budget of open files: a process may have so many, and connections, journals and recordings all take of them.

/// The division of a process's open files. Whatever takes files stays within its part, so that there is always one
/// for the file of tokens, and for who comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Descriptors {
    /// Most connections with a place.
    pub(super) connections: usize,
    /// Journals that stay open between two writes.
    pub(super) journals: usize,
    /// Files beyond which no recording begins: what is above is for journals, the file of tokens, and what is open for a moment.
    pub(super) recordings_below: usize,
}

impl Descriptors {
    /// The parts of so many files: three quarters are for connections, but so that 32 are left, and not more than 16,384; then come those that
    /// are let in only to be refused; of the rest a third each is for journals, for recordings, and for the listeners, the log, the file
    /// of tokens and what is open for a moment.
    pub(super) fn of(files: u64) -> Self {
        let files = usize::try_from(files).unwrap_or(usize::MAX);
        let connections = files.saturating_sub((files / 4).max(LEAST_OTHERS)).clamp(1, MOST_CONNECTIONS);
        let refused = (connections / 8).clamp(8, 64);
        let part = files.saturating_sub(connections).saturating_sub(refused) / 3;
        let journals = part.min(MOST_JOURNALS);
        Self { connections, journals, recordings_below: files.saturating_sub(2 * part.min(MOST_JOURNALS)) }
    }
}

/// Files that a server with a few worlds needs besides its connections: an idle one has sixteen.
const LEAST_OTHERS: usize = 32;

/// Each takes some tens of kilobytes while it is open.
const MOST_CONNECTIONS: usize = 16_384;

/// More need not stay open: to open one takes some microseconds.
const MOST_JOURNALS: usize = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_all_files_are_no_more_than_all() {
        for files in [40, 64, 100, 256, 1000, 1024, 4096, 65_536, 1 << 20] {
            let Descriptors { connections, journals, recordings_below } = Descriptors::of(files);
            let refused = (connections / 8).clamp(8, 64);
            let files = files as usize;
            assert!(connections + refused <= recordings_below, "{files}: recordings may begin");
            assert!(recordings_below + 2 * journals <= files, "{files}: journals, and as many others");
            assert!(journals >= 1 || files < 64, "{files}");
        }
        let usual = Descriptors { connections: 768, journals: 64, recordings_below: 896 };
        assert_eq!(Descriptors::of(1024), usual);
        assert_eq!(Descriptors::of(u64::MAX).connections, MOST_CONNECTIONS);
    }
}
