//! Rounds of main loops, compared with a look at each instruction of a chip, and with the marks that programs set.

use baudbot_avr::{Bare, Board, Chip, Drive, Fuses, Op, Part, Pin, Port, Program, Round, Supply, decode};

const MS: u64 = 16_000;

/// The forms of main loops of `programs/rounds.c`.
const FORMS: [&str; 6] = ["nested", "asleep", "arguments", "far", "forever", "watchdog"];

/// Programs in C that have a main loop, and the cycles of its typical round.
const PROGRAMS: [(&str, u64); 8] = [
    ("crates/avr/tests/programs/adc.hex", 49_920),
    ("crates/avr/tests/programs/compute.hex", 46_221),
    ("crates/avr/tests/programs/blink.hex", 2),
    ("crates/avr/tests/programs/echo_9600.hex", 2),
    ("crates/avr/tests/programs/timer1_interrupts.hex", 2),
    ("crates/avr/tests/programs/watchdog.hex", 2),
    ("crates/sim/tests/programs/tester.hex", 5),
    ("catalogue/scenarios/firmware/wander.hex", 11),
];

fn chip(path: &str) -> Chip {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let program = Program::parse(Part::Atmega328P, &std::fs::read(path).unwrap()).unwrap();
    Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO)
}

fn form(name: &str) -> Chip {
    chip(&format!("crates/avr/tests/programs/rounds_{name}.hex"))
}

fn all() -> impl Iterator<Item = String> {
    let forms = FORMS.map(|name| format!("crates/avr/tests/programs/rounds_{name}.hex"));
    PROGRAMS.into_iter().map(|(path, _)| path.to_owned()).chain(forms)
}

/// Instants at which rounds begin, and at which the program inverts PB5.
#[derive(Default)]
struct Notes {
    begins: Vec<u64>,
    /// The durations of the rounds before these.
    lengths: Vec<u64>,
    marks: Vec<u64>,
}

impl Board for Notes {
    fn round_begins(&mut self, at: u64, last: Round) {
        self.lengths.push(last.cycles);
        self.begins.push(at);
    }

    fn pin_changed(&mut self, pin: Pin, _drive: Drive, at: u64) {
        if Some(pin) == Pin::new(Port::B, 5) {
            self.marks.push(at);
        }
    }
}

/// The chip after so many milliseconds, each a run of its own.
fn watched(mut chip: Chip, ms: u64) -> (Chip, Notes) {
    let mut notes = Notes::default();
    chip.watch_rounds(true);
    for ms in 1..=ms {
        chip.run(ms * MS, &mut notes);
    }
    (chip, notes)
}

/// The instants at which a jump back came to the head of the main loop, by a look at each instruction.
fn arrivals(mut chip: Chip, ms: u64, head: u32) -> Vec<u64> {
    let (mut found, mut before) = (Vec::new(), 0);
    let words = chip.flash().to_vec();
    chip.run_unless(ms * MS, &mut Bare, |chip| {
        let jump = decode(words[before as usize], words[before as usize + 1]);
        let is_jump = matches!(jump, Op::Rjmp { .. } | Op::Jmp { .. } | Op::Brbs { .. } | Op::Brbc { .. });
        if is_jump && before >= head {
            let top = |up: u16| u32::from(chip.sram()[usize::from(chip.stack_pointer() + up) - 0x100]);
            if chip.pc() == head {
                found.push(chip.now());
            } else if (1..VECTORS_END).contains(&chip.pc()) && top(2) | top(1) << 8 == head {
                // An interrupt came in between, which takes four cycles.
                found.push(chip.now() - 4);
            }
        }
        before = chip.pc();
        false
    });
    found
}

/// The word address behind the vectors.
const VECTORS_END: u32 = 52;

#[test]
fn rounds_are_the_times_between_arrivals_at_the_head_of_the_main_loop() {
    for path in all().filter(|path| !path.contains("watchdog")) {
        let (after, notes) = watched(chip(&path), 300);
        let rounds = after.rounds().unwrap_or_else(|| panic!("{path}: no main loop was found"));
        // The programs have all come to their main loops by then. A round that begins with the last cycle is not seen
        // from the next instruction.
        let settled = |at: &&u64| (100 * MS..300 * MS).contains(*at);
        let expected = arrivals(chip(&path), 300, rounds.head());
        let (expected, begins): (Vec<_>, Vec<_>) =
            (expected.iter().filter(settled).collect(), notes.begins.iter().filter(settled).collect());
        assert!(expected.len() > 50, "{path}: {} rounds", expected.len());
        let differ = expected.iter().zip(&begins).position(|(a, b)| a != b);
        assert_eq!(differ, None, "{path}: of {} and {} rounds", expected.len(), begins.len());
        assert_eq!(expected.len(), begins.len(), "{path}");
        let spans = notes.begins.windows(2).zip(&notes.lengths[1..]).filter(|(pair, _)| pair[0] >= 100 * MS);
        for (pair, length) in spans {
            assert_eq!(pair[1] - pair[0], *length, "{path}: the round before {}", pair[1]);
        }
    }
}

#[test]
fn programs_have_the_rounds_that_their_listings_say() {
    for (path, typical) in PROGRAMS {
        let (after, _) = watched(chip(path), 300);
        let rounds = after.rounds().unwrap();
        assert_eq!(rounds.typical(), typical, "{path}: {rounds:?}");
        assert!(
            rounds.least() <= typical && typical <= rounds.most() && rounds.total() <= 300 * MS,
            "{path}"
        );
    }
}

#[test]
fn each_round_of_a_main_loop_has_one_mark_whatever_its_form() {
    for name in FORMS {
        let (after, notes) = watched(form(name), 300);
        let rounds = after.rounds().unwrap_or_else(|| panic!("{name}: no main loop was found"));
        // After each start the pin is driven, the first round has not come from the loop's end, and the last one does not end.
        let resets = u64::from(after.watchdog_resets());
        let (marks, others) = (notes.marks.len() as u64, 4 * (resets + 1));
        assert!((marks - others..marks).contains(&rounds.count()), "{name}: {} of {marks}", rounds.count());
        if name == "watchdog" {
            assert!(resets > 1, "{resets} resets");
            continue;
        }
        let begins: Vec<_> = notes.begins.iter().filter(|at| **at > 50 * MS).collect();
        assert!(begins.len() > 40, "{name}: {}", begins.len());
        for pair in begins.windows(2) {
            let within = notes.marks.iter().filter(|mark| (*pair[0]..*pair[1]).contains(mark)).count();
            assert_eq!(within, 1, "{name}: between {} and {}", pair[0], pair[1]);
        }
    }
}

#[test]
fn loops_that_are_passed_over_have_the_rounds_of_those_that_are_not() {
    for path in all() {
        let (passing, notes) = watched(chip(&path), 60);
        let mut slow = chip(&path);
        let mut slow_notes = Notes::default();
        slow.watch_rounds(true);
        slow.run_unless(60 * MS, &mut slow_notes, |_| false);
        assert_eq!(passing.rounds(), slow.rounds(), "{path}");
        assert_eq!(passing.share_asleep(), slow.share_asleep(), "{path}");
        assert!(notes.begins == slow_notes.begins, "{path}");
        // One that repeats with several rounds at a time, and with none.
        for ms in [7, 33] {
            let mut other = chip(&path);
            other.watch_rounds(true);
            (1..=60 / ms).for_each(|n| _ = other.run(n * ms * MS, &mut Bare));
            other.run(60 * MS, &mut Bare);
            assert_eq!(passing.rounds(), other.rounds(), "{path}: in runs of {ms} ms");
        }
    }
}

#[test]
fn a_repeated_loop_that_has_several_rounds_counts_each() {
    // The main loop inverts a bit of a variable in one round and does without in the next: ldi, com, sbrs, rjmp over, 4 nop, rjmp.
    let source = [0xE000, 0x9500, 0xFF00, 0xC004, 0x0000, 0x0000, 0x0000, 0x0000, 0xCFF8];
    let program = Program::from_words(Part::Atmega328P, &source).unwrap();
    let start = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let (passing, notes) = watched(start.clone(), 10);
    let mut slow = start;
    slow.watch_rounds(true);
    let mut slow_notes = Notes::default();
    slow.run_unless(10 * MS, &mut slow_notes, |_| false);
    assert_eq!(passing.rounds(), slow.rounds());
    assert!(notes.begins == slow_notes.begins);
    let rounds = passing.rounds().unwrap();
    assert_eq!((rounds.least(), rounds.most()), (6, 9), "{rounds:?}");
    assert!(rounds.count().abs_diff(10 * MS / 15 * 2) < 10, "{}", rounds.count());
}

#[test]
fn watching_rounds_changes_nothing_else() {
    for path in all() {
        let (after, _) = watched(chip(&path), 60);
        let mut other = chip(&path);
        (1..=60).for_each(|ms| _ = other.run(ms * MS, &mut Bare));
        assert!(after == other, "{path}");
        let bytes = postcard::to_allocvec(&after).unwrap();
        assert!(bytes == postcard::to_allocvec(&other).unwrap(), "{path}");
        assert_eq!(other.rounds(), None);
        let mut loaded: Chip = postcard::from_bytes(&bytes).unwrap();
        assert_eq!((loaded.rounds(), loaded.share_asleep()), (None, None));
        loaded.run(70 * MS, &mut Bare);
        other.run(70 * MS, &mut Bare);
        assert!(loaded == other, "{path}");
    }
}

#[test]
fn a_main_loop_that_sleeps_has_its_sleep_in_its_rounds() {
    let (after, _) = watched(form("asleep"), 300);
    let rounds = after.rounds().unwrap();
    // The timer wakes it each millisecond.
    assert_eq!((rounds.least(), rounds.typical(), rounds.most()), (MS, MS, MS));
    let share = after.share_asleep().unwrap();
    // The program comes to its main loop after 36 ms.
    assert!((0.8..0.9).contains(&share), "{share}");
}

#[test]
fn rounds_are_counted_on_after_a_reset() {
    let (after, _) = watched(form("watchdog"), 400);
    let rounds = after.rounds().unwrap().clone();
    assert!(after.watchdog_resets() > 3, "{}", after.watchdog_resets());
    let mut again = after;
    again.reset_now(baudbot_avr::ResetCause::External, &mut Bare);
    assert_eq!(again.rounds(), Some(&rounds), "what was counted is still there");
    again.run(460 * MS, &mut Bare);
    let more = again.rounds().unwrap();
    assert!(
        more.head() == rounds.head() && more.count() > rounds.count() + 50,
        "{}",
        more.count() - rounds.count()
    );
    assert_eq!(
        (more.least(), more.typical(), more.most()),
        (rounds.least(), rounds.typical(), rounds.most())
    );
}

#[test]
fn a_program_without_a_loop_has_no_rounds() {
    // sleep; nop…
    let program = Program::from_words(Part::Atmega328P, &[0x9588]).unwrap();
    let (after, notes) =
        watched(Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO), 0);
    assert_eq!((after.rounds(), notes.begins.len()), (None, 0));
    let (mut after, _) = watched(after, 1);
    assert_eq!(after.rounds(), None);
    after.watch_rounds(false);
    assert_eq!(after.rounds(), None);
}
