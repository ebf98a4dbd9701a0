//! Journals on the disk and in memory.

use std::cell::RefCell;

use super::contents::Refusal;
use super::*;
use crate::figures::Figures;
use crate::run_record::{Ran, RunError};

fn header() -> Header {
    Header::new("test", "0123456789abcdef".to_owned(), "0.1.0 0".to_owned(), 5)
}

fn seal() -> Seal {
    header().seal()
}

/// The result of a run.
fn row(run: u64) -> Row {
    let mut figures = Figures::default();
    figures.0[2] = Some(0.1 + run as f64);
    let ran = Ran { ending: "time is over".to_owned(), figures, fall: None, hash: 7 + run };
    Row { run, outcome: if run == 3 { Err(RunError::new("robots[0]: is too large")) } else { Ok(ran) } }
}

/// A journal of five runs, line by line.
fn lines() -> Vec<Vec<u8>> {
    let rows = [2, 0, 1, 4, 3].map(|run| seal().line(&Written::from(&row(run))).unwrap());
    std::iter::once(header().line().unwrap()).chain(rows).collect()
}

/// The contents of a journal of these bytes, which is to be resumed.
fn read(bytes: &[u8]) -> Result<Contents, Refusal> {
    let mut contents = Contents::none(Path::new("/x/rows.jsonl"), &header());
    contents.take_all(bytes, &header(), Purpose::Resume).map(|()| contents)
}

/// Every row that is read from a journal must be true, and none may be missing without a report. Returns the reports.
fn honest(bytes: &[u8]) -> Vec<String> {
    let found = match read(bytes) {
        Ok(found) => found,
        Err(Refusal::Foreign) => return vec!["it is refused".to_owned()],
        Err(refusal) => panic!("{refusal:?}"),
    };
    let mut missing = 5;
    for entry in found.rows.iter().chain(&found.failed) {
        let line = bytes[entry.start as usize..].split_inclusive(|byte| *byte == b'\n').next().unwrap();
        assert_eq!(seal().row(line).map(|(row, _)| row), Some(row(entry.run)));
        missing -= 1;
    }
    assert!(found.rows.is_sorted_by(|a, b| a.run < b.run), "{:?}", found.rows);
    let is_whole = bytes.is_empty() || bytes.ends_with(b"\n");
    assert!(missing == 0 || !found.damage.is_empty() || is_whole || found.len == 0, "{missing} are missing");
    assert_eq!(found.is_whole, is_whole);
    found.damage
}

#[test]
fn any_bit_that_flips_is_told_with_its_line_and_changes_no_row() {
    let lines = lines();
    let (mut bytes, mut place) = (lines.concat(), 0);
    assert_eq!(honest(&bytes), [""; 0]);
    for (i, line) in lines.iter().enumerate() {
        for at in place..place + line.len() {
            for bit in 0..8 {
                bytes[at] ^= 1 << bit;
                let damage = honest(&bytes);
                let named = damage.iter().any(|damage| damage.starts_with(&format!("line {} is ", i + 1)));
                assert!(named, "bit {bit} of byte {at}, in line {}: {damage:?}", i + 1);
                bytes[at] ^= 1 << bit;
            }
        }
        place += line.len();
    }
}

#[test]
fn a_journal_that_is_cut_anywhere_has_the_rows_before_the_cut_and_tells_of_the_torn_one() {
    let bytes = lines().concat();
    let first = lines()[0].len();
    for len in 0..bytes.len() {
        let damage = honest(&bytes[..len]);
        let is_torn = len > first && bytes[len - 1] != b'\n';
        assert_eq!(damage.len(), usize::from(is_torn), "{len} bytes: {damage:?}");
        assert!(damage.iter().all(|damage| damage.ends_with(" is incomplete; its run is repeated")));
        // The rest of the bytes has no header.
        let from = read(&bytes[len..]);
        let last = lines()[5].len();
        match from {
            Ok(found) => assert!(len == 0 || found.damage[0] == "line 1 is damaged; it is rewritten"),
            Err(Refusal::Foreign) => assert!(bytes.len() - len < last, "{len}"),
            Err(refusal) => panic!("{refusal:?}"),
        }
    }
}

#[test]
fn lines_in_any_order_and_any_number_are_the_same_rows() {
    let lines = lines();
    let rows = |lines: &[Vec<u8>]| {
        honest(&lines.concat());
        let found = read(&lines.concat()).unwrap();
        let mut runs: Vec<_> = found.rows.iter().chain(&found.failed).map(|row| row.run).collect();
        runs.sort_unstable();
        runs
    };
    for i in 0..lines.len() {
        for j in 0..lines.len() {
            let (mut doubled, mut swapped, mut gone) = (lines.clone(), lines.clone(), lines.clone());
            doubled.insert(j, lines[i].clone());
            swapped.swap(i, j);
            assert_eq!(rows(&doubled), [0, 1, 2, 3, 4], "line {i} is at {j}, too");
            assert_eq!(rows(&swapped), [0, 1, 2, 3, 4], "lines {i} and {j}");
            gone.remove(i);
            assert_eq!(rows(&gone).len(), if i == 0 { 5 } else { 4 });
        }
    }
}

#[test]
fn a_line_of_another_journal_is_no_row_of_this_one() {
    let other = Header { fingerprint: "fedcba9876543210".to_owned(), ..header() };
    let mut lines = lines();
    lines[2] = other.seal().line(&Written::from(&row(0))).unwrap();
    assert_eq!(honest(&lines.concat()), ["line 3 is damaged; its run is repeated"]);
    // Nor is one of a run that there is not.
    lines[2] = seal().line(&Written::from(&row(5))).unwrap();
    assert_eq!(honest(&lines.concat()), ["line 3 is damaged; its run is repeated"]);
}

#[test]
fn of_lines_that_differ_about_a_run_none_is_believed() {
    let mut lines = lines();
    lines.push(seal().line(&Written::from(&Row { run: 1, ..row(2) })).unwrap());
    let found = read(&lines.concat()).unwrap();
    assert_eq!(found.damage, ["lines 4 and 7 disagree about run 1; its run is repeated"]);
    assert_eq!(found.rows.iter().map(|row| row.run).collect::<Vec<_>>(), [0, 2, 4]);
    assert!(!found.is_sound, "it would be told for ever");
}

#[test]
fn a_damaged_journal_is_mended_in_its_place_and_told_of_once() {
    let path = std::env::temp_dir().join(format!("baudbot-journal-{}.jsonl", std::process::id()));
    let mut damaged = lines();
    damaged[0][5] ^= 1;
    damaged[3][9] ^= 1;
    damaged[5].truncate(12);
    fs::write(&path, damaged.concat()).unwrap();
    let told = RefCell::new(Vec::new());
    let open = || Journal::open(&path, &header(), &|text| told.borrow_mut().push(text.to_owned())).unwrap();
    let mut journal = open();
    let expected = ["1 is damaged; it is rewritten", "4 is damaged; its run", "6 is incomplete; its run"];
    let told_now = told.take();
    assert_eq!(told_now.len(), expected.len(), "{told_now:?}");
    for (told, expected) in told_now.iter().zip(expected) {
        assert!(told.contains(&format!("{}: line {expected}", path.display())), "{told}");
    }
    assert_eq!(journal.runs(), [0, 2, 4]);
    [1, 3].iter().for_each(|run| journal.append(&row(*run)).unwrap());
    let mut again = open();
    assert_eq!(told.take(), [""; 0]);
    assert_eq!((again.runs(), again.repeated()), (vec![0, 1, 2, 4], 1));
    again.keep_failed();
    assert_eq!(again.rows().unwrap().map(Result::unwrap).collect::<Vec<_>>(), [0, 1, 2, 3, 4].map(row));
    assert!(!path.with_extension("mended").exists());
    // A line that is damaged after that is no row of a table either.
    let mut bytes = fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() = b' ';
    fs::write(&path, bytes).unwrap();
    let error = again.rows().unwrap().find_map(Result::err).unwrap().to_string();
    assert!(error.contains("a line was damaged while the experiment ran; repeat the command"), "{error}");
    fs::remove_file(path).unwrap();
}

/// A journal of these rows, in the folder of temporary files.
fn journal_of(name: &str, rows: &[Row]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("baudbot-journal-{}-{name}.jsonl", std::process::id()));
    let _ = fs::remove_file(&path);
    let mut journal = Journal::open(&path, &header(), &|_| {}).unwrap();
    rows.iter().for_each(|row| journal.append(row).unwrap());
    path
}

#[test]
fn a_later_line_replaces_that_of_a_run_that_failed_and_the_same_failure_is_not_written_again() {
    let failed = |run, error: &str| Row { run, outcome: Err(RunError::new(error)) };
    let path = journal_of("failed", &[failed(0, "no"), row(1), failed(2, "no"), failed(2, "still no")]);
    let open = || Journal::open(&path, &header(), &|text| panic!("{text}")).unwrap();
    let mut journal = open();
    assert_eq!((journal.runs(), journal.repeated()), (vec![1], 2));
    let len = journal.len;
    journal.append(&failed(2, "still no")).unwrap();
    assert_eq!((journal.len, fs::metadata(&path).unwrap().len()), (len, len), "it is written again");
    journal.append(&row(0)).unwrap();
    let rows = journal.rows().unwrap().map(Result::unwrap).collect::<Vec<_>>();
    assert_eq!(rows, [row(0), row(1), failed(2, "still no")]);
    assert_eq!((open().runs(), open().repeated()), (vec![0, 1], 1));
    fs::remove_file(path).unwrap();
}

#[test]
fn a_journal_in_which_every_run_failed_is_begun_anew_and_a_damaged_one_keeps_its_failures() {
    let failed = |run| Row { run, outcome: Err(RunError::new("no")) };
    let path = journal_of("all-failed", &[failed(0), failed(1)]);
    let old = fs::metadata(&path).unwrap().len();
    let journal = Journal::open(&path, &header(), &|_| {}).unwrap();
    assert_eq!((journal.done(), journal.repeated()), (0, 2));
    assert!(fs::metadata(&path).unwrap().len() < old, "the failures are there");
    let path = journal_of("all-failed", &[failed(0), row(1), row(2)]);
    let mut bytes = fs::read(&path).unwrap();
    let last = bytes.len() - 40;
    bytes[last] ^= 1;
    fs::write(&path, bytes).unwrap();
    let mut journal = Journal::open(&path, &header(), &|_| {}).unwrap();
    assert_eq!((journal.runs(), journal.repeated()), (vec![1], 1));
    journal.keep_failed();
    let rows = journal.rows().unwrap().map(Result::unwrap).collect::<Vec<_>>();
    assert_eq!(rows, [failed(0), row(1)]);
    fs::remove_file(path).unwrap();
}

/// Has room for so many bytes.
#[derive(Debug, Default)]
struct Full {
    bytes: Vec<u8>,
    room: usize,
    /// The number of bytes at each sync.
    syncs: RefCell<Vec<usize>>,
}

impl Stored for Full {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let fits = bytes.len().min(self.room - self.bytes.len());
        self.bytes.extend(&bytes[..fits]);
        if fits < bytes.len() { Err(ErrorKind::StorageFull.into()) } else { Ok(()) }
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.bytes.truncate(length as usize);
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.syncs.borrow_mut().push(self.bytes.len());
        Ok(())
    }
}

#[test]
fn on_a_full_disk_whole_rows_stay_and_the_error_names_the_file() {
    let row = |run| Row { run, outcome: Err(RunError::new("too short")) };
    let mut journal =
        Journal::new(Path::new("/somewhere/rows.jsonl"), Full { room: 100, ..Full::default() }, seal());
    let mut run = 0;
    let error = loop {
        match journal.append(&row(run)) {
            Ok(()) => run += 1,
            Err(error) => break error.to_string(),
        }
    };
    assert!(error.starts_with("cannot write /somewhere/rows.jsonl: "), "{error}");
    let text = String::from_utf8(journal.file.bytes.clone()).unwrap();
    assert_eq!(text.lines().count() as u64, run);
    assert!(run > 0 && text.ends_with("}\n"), "{text}");
    assert_eq!(journal.runs(), (0..run).collect::<Vec<_>>());
    // The journal goes on where it was once there is room again.
    journal.file.room = 1000;
    journal.append(&row(run)).unwrap();
    assert_eq!(journal.file.bytes.len() as u64, journal.len);
}

#[test]
fn rows_reach_the_disk_soon_but_not_each_by_itself() {
    let row = |run| Row { run, outcome: Err(RunError::new("too short")) };
    let medium = Full { room: 100_000, ..Full::default() };
    let mut journal = Journal::new(Path::new("/somewhere/rows.jsonl"), medium, seal());
    let start = Instant::now();
    (0..100).for_each(|run| journal.append(&row(run)).unwrap());
    let most = 1 + start.elapsed().as_millis() / SYNC_INTERVAL.as_millis();
    assert!((1..=most as usize).contains(&journal.file.syncs.borrow().len()), "{:?}", journal.file.syncs);
    journal.synced = Instant::now().checked_sub(SYNC_INTERVAL);
    journal.append(&row(100)).unwrap();
    assert_eq!(journal.file.syncs.borrow().last(), Some(&journal.file.bytes.len()));
    journal.synced = Some(Instant::now() + SYNC_INTERVAL);
    journal.append(&row(101)).unwrap();
    assert_ne!(journal.file.syncs.borrow().last(), Some(&journal.file.bytes.len()));
    journal.sync().unwrap();
    assert_eq!(journal.file.syncs.borrow().last(), Some(&journal.file.bytes.len()));
}
