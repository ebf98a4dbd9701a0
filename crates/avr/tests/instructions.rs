//! Each instruction from random states, compared with other simulators in processes of their own.
//!
//! These tests are called by command, as they need what a plain test run should not:
//!
//! ```text
//! apt-get install libsimavr-dev
//! cargo test --release -p baudbot-avr --test outside -- --ignored simavr
//! npm install --prefix /tmp/avr8js avr8js@0.21.1
//! BAUDBOT_AVR8JS=/tmp/avr8js cargo test --release -p baudbot-avr --test outside -- --ignored each_instruction_does_what_avr8js
//! ```
//!
//! `BAUDBOT_AVR_STATES` is the number of states of each instruction, 10,000 if it is not set.

// A few of some seventy instructions are special here.
#![allow(clippy::wildcard_enum_match_arm)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use baudbot_avr::{Bare, Chip, Fuses, Op, Part, Program, Supply, decode};

const RAM: u16 = 0x100;
const RAM_END: u16 = 0x900;
/// GPIOR0 to 2: registers that only hold what is written.
const SHARED: [u8; 3] = [0x3E, 0x4A, 0x4B];
const STACK_LOW: u8 = 0x5D;
const STACK_HIGH: u8 = 0x5E;
const STATUS: u8 = 0x5F;
const HALF_CARRY: u8 = 0x20;
/// One state of `SBIS` in 32 is defined; an instruction that another simulator does otherwise in all states is left
/// out.
const MOST_TRIES: usize = 100;

#[test]
#[ignore = "needs libsimavr-dev"]
fn each_instruction_does_what_simavr_does() {
    let harness = build_harness();
    // The simulator takes some words of ADIW and SBIW for JMP or CALL when it skips them.
    let takes_for_two_words = |word: u16| word & 0xFE0C == 0x960C;
    compare(Command::new(harness), "simavr", 0xFF, |state| {
        is_skip(state) && takes_for_two_words(state.words[1])
    });
}

#[test]
#[ignore = "needs node and avr8js"]
fn each_instruction_does_what_avr8js_does() {
    let folder = std::env::var("BAUDBOT_AVR8JS").expect(
        "BAUDBOT_AVR8JS names the folder in which `npm install --prefix FOLDER avr8js@0.21.1` was done",
    );
    let mut node = Command::new("node");
    node.arg(tests().join("avr8js/step.mjs")).arg(folder);
    // The simulator's half carry is that of the lowest bit, its CBI takes one cycle, its FMULSU sets Z at random, its
    // NEG of -128 does not overflow, and 0 - 255 - 1 is not zero for it.
    let differs = |state: &State| match decode(state.words[0], 0) {
        Op::Cbi { .. } | Op::Fmulsu { .. } => true,
        Op::Neg { d } => state.registers[usize::from(d)] == 0x80,
        Op::Cpc { r, .. } | Op::Sbc { r, .. } => {
            state.registers[usize::from(r)] == 0xFF && state.sreg & 1 == 1
        }
        Op::Sbci { k, .. } => k == 0xFF && state.sreg & 1 == 1,
        _ => false,
    };
    compare(node, "avr8js", !HALF_CARRY, differs);
}

fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn build_harness() -> PathBuf {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("simavr-step");
    let built = Command::new("cc")
        .args(["-O2", "-o"])
        .arg(&program)
        .arg(tests().join("simavr/step.c"))
        .args(["-lsimavr", "-lelf"])
        .status()
        .expect("the C compiler `cc` is needed");
    assert!(
        built.success(),
        "cannot build the harness: is libsimavr-dev installed? (apt-get install libsimavr-dev libelf-dev)"
    );
    program
}

/// A state before an instruction.
#[derive(Clone)]
struct State {
    words: [u16; 3],
    pc: u32,
    sreg: u8,
    sp: u16,
    registers: [u8; 32],
}

impl State {
    fn line(&self) -> String {
        let [w0, w1, w2] = self.words;
        let mut line = format!("{w0:x} {w1:x} {w2:x} {:x} {:x} {:x} ", self.pc, self.sreg, self.sp);
        for register in self.registers {
            write!(line, "{register:02x}").unwrap();
        }
        line
    }
}

fn compare(mut oracle: Command, name: &str, flags: u8, excused: impl Fn(&State) -> bool) {
    let states = std::env::var("BAUDBOT_AVR_STATES")
        .map_or(10_000, |states| states.parse().expect("a number of states"));
    let mut oracle = Oracle::start(&mut oracle, name);
    let mut ours = Ours::new();
    let mut random = Random(1);
    let mut all = 0;
    for (kind, words) in kinds() {
        let cases: Vec<State> = std::iter::repeat_with(|| random_state(&words, &mut random))
            .take(MOST_TRIES * states)
            .filter(|state| is_defined(state) && !excused(state))
            .take(states)
            .collect();
        for batch in cases.chunks(200) {
            for (state, expected) in batch.iter().zip(oracle.ask(batch)) {
                let (found, expected) = (normalised(&ours.step(state), flags), normalised(&expected, flags));
                let op = decode(state.words[0], state.words[1]);
                assert_eq!(
                    found,
                    expected,
                    "{kind}: {op:?} from {}\n left: ours, right: {name}",
                    state.line()
                );
            }
        }
        println!("{kind}: {} states", cases.len());
        all += cases.len();
    }
    println!("{all} states in all");
}

/// All words of each kind of instruction.
fn kinds() -> BTreeMap<String, Vec<u16>> {
    let mut kinds: BTreeMap<String, Vec<u16>> = BTreeMap::new();
    for word in 0..=u16::MAX {
        let op = decode(word, 0);
        if matches!(op, Op::Illegal { .. } | Op::Sleep | Op::Break | Op::Spm | Op::Wdr) {
            continue;
        }
        let name = format!("{op:?}");
        let name = name.split(' ').next().unwrap_or_default().to_string();
        kinds.entry(name).or_default().push(word);
    }
    kinds
}

fn random_state(words: &[u16], random: &mut Random) -> State {
    let mut registers = [0; 32];
    for register in &mut registers {
        // Corners are more frequent than by chance.
        *register =
            if random.below(4) == 0 { [0, 1, 0x7F, 0x80, 0xFF][random.below(5)] } else { random.byte() };
    }
    for pointer in [26, 28, 30] {
        let address = random.memory_address();
        [registers[pointer], registers[pointer + 1]] = address.to_le_bytes();
    }
    let word = words[random.below(words.len())];
    let second = match decode(word, 0) {
        Op::Lds { .. } | Op::Sts { .. } => match random.below(8) {
            0 => u16::from(SHARED[random.below(3)]),
            1 => random.below(32) as u16,
            _ => random.memory_address(),
        },
        Op::Lpm { .. } | Op::LpmIncrement { .. } => {
            registers[31] |= 0x40;
            registers[31] &= 0x7F;
            0
        }
        _ => random.word(),
    };
    State {
        words: [word, second, random.word()],
        pc: 0x40 + random.below(0x1F00) as u32,
        sreg: random.byte(),
        sp: random.memory_address(),
        registers,
    }
}

/// Whether the manual defines the result, and the registers are none that do more than hold what is written.
fn is_defined(state: &State) -> bool {
    match decode(state.words[0], state.words[1]) {
        Op::LoadIncrement { d, pointer } | Op::LoadDecrement { d, pointer } => d & !1 != pointer,
        Op::StoreIncrement { r, pointer } | Op::StoreDecrement { r, pointer } => r & !1 != pointer,
        Op::LpmIncrement { d } => d & !1 != 30,
        Op::In { address, .. } | Op::Out { address, .. } => {
            SHARED.contains(&address) || matches!(address, STACK_LOW | STACK_HIGH | STATUS)
        }
        Op::Sbi { address, .. }
        | Op::Cbi { address, .. }
        | Op::Sbic { address, .. }
        | Op::Sbis { address, .. } => SHARED.contains(&address),
        _ => true,
    }
}

fn is_skip(state: &State) -> bool {
    let op = decode(state.words[0], state.words[1]);
    matches!(op, Op::Cpse { .. } | Op::Sbrc { .. } | Op::Sbrs { .. } | Op::Sbic { .. } | Op::Sbis { .. })
}

struct Ours {
    chip: Chip,
}

impl Ours {
    fn new() -> Self {
        let part = Part::Atmega328P;
        let bytes: Vec<u8> =
            (0..0x8000u32).map(|at| if at < 0x4000 { 0 } else { (at * 29 + 7) as u8 }).collect();
        let words: Vec<u16> = bytes.chunks(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
        let program = Program::from_words(part, &words).unwrap();
        let mut chip = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
        let start = chip.next_event().unwrap();
        chip.run(start, &mut Bare);
        Self { chip }
    }

    fn step(&mut self, state: &State) -> String {
        let chip = &mut self.chip;
        for (at, byte) in chip.sram_mut().iter_mut().enumerate() {
            *byte = pattern(RAM + at as u16);
        }
        for address in SHARED {
            chip.write_data(address.into(), 0, &mut Bare);
        }
        chip.write_flash(state.pc, &state.words);
        *chip.general_registers_mut() = state.registers;
        chip.set_status_register(state.sreg);
        chip.set_stack_pointer(state.sp);
        chip.set_pc(state.pc);
        let before = chip.cycles();
        chip.run(chip.now() + 1, &mut Bare);
        let mut line = format!(
            "{:x} {:x} {:x} {:x} ",
            chip.cycles() - before,
            chip.pc(),
            chip.status_register(),
            chip.stack_pointer()
        );
        for register in chip.general_registers() {
            write!(line, "{register:02x}").unwrap();
        }
        for address in SHARED {
            let byte = chip.read_data(address.into(), &mut Bare);
            if byte != 0 {
                write!(line, " {address:x}={byte:02x}").unwrap();
            }
        }
        for (address, &byte) in (RAM..).zip(chip.sram()) {
            if byte != pattern(address) {
                write!(line, " {address:x}={byte:02x}").unwrap();
            }
        }
        chip.write_flash(state.pc, &[0; 3]);
        line
    }
}

fn pattern(address: u16) -> u8 {
    (address.wrapping_mul(37).wrapping_add(11)) as u8
}

/// Another simulator, as a process.
struct Oracle {
    child: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Oracle {
    fn start(command: &mut Command, name: &str) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("cannot start {name} ({command:?}): {error}"));
        let answers = BufReader::new(child.stdout.take().unwrap());
        Self { child, answers }
    }

    fn ask(&mut self, states: &[State]) -> Vec<String> {
        let lines: String = states.iter().map(|state| state.line() + "\n").collect();
        let input = self.child.stdin.as_mut().unwrap();
        // More lines than a pipe holds would wait for each other: the other side reads and answers line by line.
        for lines in lines.as_bytes().chunks(1 << 15) {
            input.write_all(lines).unwrap();
        }
        input.flush().unwrap();
        states.iter().map(|_| self.answer()).collect()
    }

    fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        line
    }
}

/// An answer with its program counter within the flash, and with these flags only.
fn normalised(line: &str, flags: u8) -> String {
    let mut fields: Vec<String> = line.split_whitespace().map(String::from).collect();
    assert!(fields.len() >= 5, "the other simulator has ended or says {line:?}");
    let number = |text: &str| u32::from_str_radix(text, 16).unwrap();
    fields[1] = format!("{:x}", number(&fields[1]) & 0x3FFF);
    fields[2] = format!("{:x}", number(&fields[2]) & u32::from(flags));
    fields.join(" ")
}

impl Drop for Oracle {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A linear congruential generator; the upper bits are good enough here.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u16 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 48) as u16
    }

    fn byte(&mut self) -> u8 {
        (self.word() >> 8) as u8
    }

    fn below(&mut self, end: usize) -> usize {
        (usize::from(self.word()) * end) >> 16
    }

    /// An address with room on both sides for displacements and return addresses.
    fn memory_address(&mut self) -> u16 {
        RAM + 0x10 + self.below(usize::from(RAM_END - RAM - 0x60)) as u16
    }
}
