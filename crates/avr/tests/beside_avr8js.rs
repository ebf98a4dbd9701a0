//! Ten programs that run here and on avr8js: timers 0, 1 and 2 in all modes (`programs/timer.c`), and the ADC
//! (`programs/conversions.c`). Counters, flags, edges at the outputs and the instants of interrupts agree to the cycle, but for
//! these differences, in each of which the data sheet is on our side:
//!
//! - *Timing diagrams* of the timers: OCF is set, and the pin changes, with the tick that ends the compared value. avr8js does
//!   it with the tick that begins it, one tick earlier. What happens at BOTTOM is at the same cycle.
//! - *Interrupt Response Time*: at least four cycles. With avr8js it takes two.
//! - *Compare Output Mode*: in PWM modes with OCRnA as the top, OCnA is constant unless it toggles. avr8js makes spikes.
//! - OCR1A above the top ICR1 never matches. For avr8js it does, whenever the counter returns to 0.
//! - A conversion begins with the cycle of the ADC's clock after `ADSC` is written, at the end of the instruction. avr8js counts
//!   from the beginning of the instruction, and its ADC has no clock.
//! - avr8js writes what is written to TIFR1 into it, with ICF1; it has no input capture, and no trigger of the ADC. These are
//!   left out here.
//! - A pin changes at the end of `OUT` or `SBI`, of one and two cycles; for avr8js at their beginning.
//!
//! The comparison is called by command:
//!
//! ```text
//! npm install --prefix /tmp/avr8js avr8js@0.21.1
//! BAUDBOT_AVR8JS=/tmp/avr8js cargo test --release -p baudbot-avr --test outside -- --ignored beside_avr8js
//! ```

use std::path::{Path, PathBuf};
use std::process::Command;

use baudbot_avr::{AnalogInput, Board, Chip, Drive, Fuses, Part, Pin, Program, Supply};

const MODES_8: [u8; 6] = [0, 1, 2, 3, 5, 7];
const MODES_16: [u8; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 15];
const CAPTURE: u16 = 0x20;
const MATCH_A: u16 = 2;
/// PB5, which the programs toggle around each part.
const MARK: (char, u8) = ('B', 5);
/// PB4, which interrupts toggle.
const INTERRUPT: (char, u8) = ('B', 4);
/// `OUT` changes PB5 at its end, one cycle after its beginning.
const MARK_CYCLES: u64 = 1;
/// `SBI` changes PB4 at its end, two cycles after its beginning.
const TOGGLE_CYCLES: u64 = 2;
/// Cycles of the interrupt response that avr8js leaves out.
const RESPONSE: u64 = 2;

/// The bytes that a program has put into its buffer, and each edge of each pin.
struct Run {
    results: Vec<u16>,
    edges: Vec<Edge>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edge {
    pin: (char, u8),
    high: bool,
    at: u64,
}

/// The edges between two marks, with their instants behind the first one.
struct Section {
    edges: Vec<Edge>,
    start: u64,
}

impl Run {
    fn new(memory: &[u8], edges: Vec<Edge>) -> Self {
        let words: Vec<u16> = memory.chunks(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
        Self { results: words[1..=usize::from(words[0])].to_vec(), edges }
    }

    /// Each part that begins with a mark.
    fn parts(&self) -> Vec<Section> {
        let mut parts: Vec<Section> = Vec::new();
        for &edge in &self.edges {
            if edge.pin == MARK {
                parts.push(Section { edges: Vec::new(), start: edge.at });
            } else if let Some(part) = parts.last_mut() {
                part.edges.push(Edge { at: edge.at - part.start, ..edge });
            }
        }
        parts
    }
}

impl Section {
    fn of(&self, pin: (char, u8)) -> Vec<(bool, u64)> {
        self.edges.iter().filter(|edge| edge.pin == pin).map(|edge| (edge.high, edge.at)).collect()
    }
}

#[derive(Default)]
struct Recorder(Vec<Edge>);

impl Board for Recorder {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        let (high, port) = (drive == Drive::High, format!("{:?}", pin.port()).remove(0));
        let pin = (port, pin.bit());
        let before = self.0.iter().rev().find(|edge| edge.pin == pin);
        if before.is_some_and(|edge| edge.high) != high {
            self.0.push(Edge { pin, high, at });
        }
    }

    fn analog_microvolts(&mut self, _input: AnalogInput, _at: u64) -> u32 {
        2_500_000
    }
}

fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn file(name: &str) -> PathBuf {
    tests().join("programs").join(format!("{name}.hex"))
}

fn ours(name: &str) -> Run {
    const DONE: u8 = 0xA5;
    let program = Program::parse(Part::Atmega328P, &std::fs::read(file(name)).unwrap()).unwrap();
    let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let mut recorder = Recorder::default();
    let start = chip.next_event().unwrap();
    chip.run(start, &mut recorder);
    for _ in 0..1000 {
        chip.run(chip.now() + 10_000, &mut recorder);
        if chip.read_data(0x3E, &mut recorder) == DONE {
            break;
        }
    }
    assert_eq!(chip.read_data(0x3E, &mut recorder), DONE, "{name}");
    let edges = recorder.0.into_iter().map(|edge| Edge { at: edge.at - start, ..edge }).collect();
    Run::new(chip.sram(), edges)
}

fn theirs(name: &str) -> Run {
    let folder = std::env::var("BAUDBOT_AVR8JS").expect(
        "BAUDBOT_AVR8JS names the folder in which `npm install --prefix FOLDER avr8js@0.21.1` was done",
    );
    let output = Command::new("node")
        .arg(tests().join("avr8js/program.mjs"))
        .arg(folder)
        .arg(file(name))
        .output()
        .expect("node is needed");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    let digits = lines.next().expect("avr8js has run the program");
    let byte = |two: &[u8]| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap();
    let memory: Vec<u8> = digits.as_bytes().chunks(2).map(byte).collect();
    Run::new(&memory, lines.map(edge).collect())
}

/// A line of avr8js: port, bit, level, cycle.
fn edge(line: &str) -> Edge {
    let fields: Vec<&str> = line.split(' ').collect();
    let pin = (fields[0].chars().next().unwrap(), fields[1].parse().unwrap());
    Edge { pin, high: fields[2] == "1", at: fields[3].parse().unwrap() }
}

fn modes(timer: u8) -> &'static [u8] {
    if timer == 1 { &MODES_16 } else { &MODES_8 }
}

/// The modes by what the counter does, and whether OCRnA is the top.
fn is_fast(timer: u8, mode: u8) -> bool {
    if timer == 1 { matches!(mode, 5 | 6 | 7 | 14 | 15) } else { matches!(mode, 3 | 7) }
}

fn is_pwm_up_to_a(timer: u8, mode: u8) -> bool {
    if timer == 1 { matches!(mode, 9 | 11 | 15) } else { matches!(mode, 5 | 7) }
}

/// OCR1A is above ICR1 in the programs.
fn never_matches_a(timer: u8, mode: u8) -> bool {
    timer == 1 && matches!(mode, 12 | 14)
}

#[test]
#[ignore = "needs node and avr8js"]
fn avr8js_shows_the_same_counters_and_flags_in_all_modes_with_all_divisions() {
    for (timer, clocks) in [(0, 5), (1, 5), (2, 7)] {
        let name = format!("timer{timer}_counters");
        let (ours, theirs) = (ours(&name), theirs(&name));
        assert_eq!(ours.results.len(), modes(timer).len() * clocks * 8);
        assert_eq!(theirs.results.len(), ours.results.len());
        for (at, (&our, &their)) in ours.results.iter().zip(&theirs.results).enumerate() {
            let (section, mode) = (at / 8, modes(timer)[at / 8 / clocks]);
            let flags = at % 2 == 1;
            let mut ignored = if flags { CAPTURE } else { 0 };
            if flags && never_matches_a(timer, mode) {
                assert_eq!(our & MATCH_A, 0, "{name}, mode {mode}");
                ignored |= MATCH_A;
            }
            assert_eq!(
                our & !ignored,
                their & !ignored,
                "{name}, mode {mode}, section {section}, result {at}"
            );
        }
        // The programs reach each instant in the same number of cycles.
        for (our, their) in ours.edges.iter().zip(&theirs.edges) {
            assert_eq!(Edge { at: our.at - MARK_CYCLES, ..*our }, *their, "{name}");
        }
    }
}

#[test]
#[ignore = "needs node and avr8js"]
fn avr8js_shows_the_same_edges_at_the_outputs() {
    for (timer, pins) in [(0, [('D', 6), ('D', 5)]), (1, [('B', 1), ('B', 2)]), (2, [('B', 3), ('D', 3)])] {
        let name = format!("timer{timer}_outputs");
        let (ours, theirs) = (ours(&name).parts(), theirs(&name).parts());
        assert_eq!((ours.len(), theirs.len()), (6 * modes(timer).len(), 6 * modes(timer).len()));
        let mut compared = 0;
        // Between the parts the program sets the timer up.
        for at in (0..ours.len()).step_by(2) {
            let mode = modes(timer)[at / 6];
            // The rising edges of fast PWM are at BOTTOM, or the falling ones, or none.
            let (division, at_bottom) = [(1, Some(true)), (8, Some(false)), (1, None)][at / 2 % 3];
            for (channel, pin) in pins.into_iter().enumerate() {
                let (our, their) = (ours[at].of(pin), theirs[at].of(pin));
                let constant = is_pwm_up_to_a(timer, mode) && at_bottom.is_some();
                if channel == 0 && (constant || never_matches_a(timer, mode)) {
                    assert!(our.len() <= 1, "{name}, mode {mode}, OCnA: {our:?}");
                    continue;
                }
                let expected: Vec<(bool, u64)> = their
                    .into_iter()
                    .map(|(high, at)| {
                        let bottom = is_fast(timer, mode) && at_bottom == Some(high);
                        (high, at + if bottom { 0 } else { division } - MARK_CYCLES)
                    })
                    .collect();
                assert_eq!(our, expected, "{name}, mode {mode}, part {at}, channel {channel}");
                compared += our.len();
            }
        }
        println!("{name}: {compared} edges");
        assert!(compared > 90, "{name}: {compared}");
    }
}

#[test]
#[ignore = "needs node and avr8js"]
fn avr8js_shows_the_same_interrupts() {
    for timer in 0..3 {
        let name = format!("timer{timer}_interrupts");
        let (ours, theirs) = (ours(&name).parts(), theirs(&name).parts());
        assert_eq!((ours.len(), theirs.len()), (6 * modes(timer).len(), 6 * modes(timer).len()));
        let mut compared = 0;
        for at in (0..ours.len()).step_by(2) {
            let mode = modes(timer)[at / 6];
            // Overflow, match A with the division by 8, match B.
            let tick = [0, 8, 1][at / 2 % 3];
            let instants = |part: &Section| part.of(INTERRUPT).into_iter().map(|(_, at)| at).collect();
            let (mut our, their): (Vec<u64>, Vec<u64>) = (instants(&ours[at]), instants(&theirs[at]));
            if at / 2 % 3 == 1 && never_matches_a(timer, mode) {
                assert_eq!(our, [], "{name}, mode {mode}");
                continue;
            }
            // Our part is longer, by the response to each interrupt: one more may have come.
            our.truncate(their.len());
            let expected: Vec<u64> =
                their.iter().map(|at| at + tick + RESPONSE + TOGGLE_CYCLES - MARK_CYCLES).collect();
            assert_eq!(our, expected, "{name}, mode {mode}, part {at}");
            compared += our.len();
        }
        println!("{name}: {compared} interrupts");
        assert!(compared > 50, "{name}: {compared}");
    }
}

#[test]
#[ignore = "needs node and avr8js"]
fn avr8js_shows_the_same_conversions() {
    let (ours, theirs) = (ours("conversions"), theirs("conversions"));
    assert_eq!(ours.results.len(), 35);
    assert_eq!(ours.results, theirs.results);
    let (ours, theirs) = (ours.parts(), theirs.parts());
    let mut waited = 0;
    for (at, (our, their)) in ours.iter().zip(&theirs).enumerate() {
        let clock = 2 << (at / 5);
        // The ADC was enabled with the first conversion of five.
        let wait = (clock - (our.start - ours[at - at % 5].start) % clock) % clock;
        let (_, our) = our.of(INTERRUPT)[0];
        let (_, their) = their.of(INTERRUPT)[0];
        waited += u64::from(wait > 0);
        // `STS` has two cycles.
        assert_eq!(our, their + wait + 2 + RESPONSE + TOGGLE_CYCLES - MARK_CYCLES, "conversion {at}");
    }
    println!("{} conversions, {waited} of them with a wait", ours.len());
    assert!(waited > 3, "{waited}");
}

/// The programs' results, as they were when they agreed with avr8js.
#[test]
fn the_ten_programs_do_what_they_did_when_they_were_compared() {
    let names = ["counters", "outputs", "interrupts"]
        .into_iter()
        .flat_map(|program| (0..3).map(move |timer| format!("timer{timer}_{program}")));
    let found: Vec<u64> = names.chain(["conversions".to_string()]).map(|name| hash(&ours(&name))).collect();
    assert_eq!(found, HASHES, "{found:#x?}");
}

const HASHES: [u64; 10] = [
    0xF1A8_B2D5_3A04_407A,
    0xBD12_1119_C5D3_1680,
    0x0BBB_002E_28B5_EF22,
    0x6976_2CF0_60B6_9218,
    0xA309_7ED5_7586_C9CF,
    0x0A80_8047_A457_C6EC,
    0x4B4D_8B3B_4428_F312,
    0xDC1A_FB27_0033_F512,
    0x81DE_11BA_6583_6B9D,
    0x072D_C043_3BAA_F280,
];

/// FNV-1a.
fn hash(run: &Run) -> u64 {
    let mut text = format!("{:?}", run.results);
    for edge in &run.edges {
        text += &format!("{edge:?}");
    }
    text.bytes()
        .fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}
