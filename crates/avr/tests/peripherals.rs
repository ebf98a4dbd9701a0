//! Timer 1 and the ADC as a program sees them (`programs/peripherals.c`), and what avr8js shows the same program.

use std::path::Path;
use std::process::Command;

use baudbot_avr::{AnalogInput, Board, Chip, Fuses, Part, Program, Supply};

struct HalfOfTheReference;

impl Board for HalfOfTheReference {
    fn analog_microvolts(&mut self, _input: AnalogInput, _at: u64) -> u32 {
        2_500_000
    }
}

/// The bytes that the program has put into its buffer: five modes of timer 1, with four pairs of TCNT1 and TIFR1
/// each, and three conversions with their duration and result.
fn ours() -> Vec<u16> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs/peripherals.hex");
    let program = Program::parse(Part::Atmega328P, &std::fs::read(file).unwrap()).unwrap();
    let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    chip.run(1_000_000, &mut HalfOfTheReference);
    results(chip.sram())
}

/// The number of results comes first.
fn results(memory: &[u8]) -> Vec<u16> {
    let count = usize::from(memory[0]);
    memory[1..=2 * count].chunks(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect()
}

/// The modes one after another: normal, CTC, fast PWM, phase-correct PWM, phase- and frequency-correct PWM.
const TIMER: [[(u16, u16); 4]; 5] = [
    [(229, 0x00), (511, 0x00), (793, 0x00), (1075, 0x00)],
    [(229, 0x06), (210, 0x26), (191, 0x26), (172, 0x26)],
    [(29, 0x27), (111, 0x27), (193, 0x27), (75, 0x27)],
    [(71, 0x26), (89, 0x27), (107, 0x27), (125, 0x27)],
    [(71, 0x26), (89, 0x27), (107, 0x27), (125, 0x27)],
];

#[test]
fn a_program_reads_the_counter_and_the_flags_of_each_mode_to_the_cycle() {
    let found = ours();
    let pairs: Vec<(u16, u16)> = found[..40].chunks(2).map(|two| (two[0], two[1])).collect();
    assert_eq!(pairs, TIMER.concat());
    let durations: Vec<u16> = found[40..].iter().copied().step_by(2).collect();
    // 25 and 13 cycles of 16, with what the program itself takes: it polls every 7 cycles, and the later conversions wait for
    // their clock.
    assert_eq!(durations[0], 413);
    assert!(durations[1..].iter().all(|&duration| (208..208 + 16 + 20).contains(&duration)), "{durations:?}");
}

#[test]
#[ignore = "needs node and avr8js"]
fn avr8js_shows_the_same_program_the_same_counters() {
    let folder = std::env::var("BAUDBOT_AVR8JS").expect(
        "BAUDBOT_AVR8JS names the folder in which `npm install --prefix FOLDER avr8js@0.21.1` was done",
    );
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let output = Command::new("node")
        .arg(tests.join("avr8js/program.mjs"))
        .arg(folder)
        .arg(tests.join("programs/peripherals.hex"))
        .output()
        .expect("node is needed");
    let output = String::from_utf8(output.stdout).unwrap();
    let digits = output.lines().next().expect("avr8js has run the program");
    let bytes: Vec<u8> = digits
        .trim()
        .as_bytes()
        .chunks(2)
        .map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap())
        .collect();
    let (theirs, ours) = (results(&bytes), ours());
    // The simulator sets ICF1 where ICR1 is not the top, or has not been reached.
    let no_capture = |at: usize, value: u16| if at % 2 == 1 { value & !0x20 } else { value };
    for at in 0..40 {
        assert_eq!(no_capture(at, ours[at]), no_capture(at, theirs[at]), "result {at}");
    }
    assert_eq!(ours[40..42], theirs[40..42]);
    for at in [42, 44] {
        // The simulator does not wait for the next cycle of the ADC's clock, of 16 cycles.
        let wait = ours[at].checked_sub(theirs[at]);
        assert!(wait.is_some_and(|wait| wait < 16), "result {at}: {} and {}", ours[at], theirs[at]);
        assert_eq!(ours[at + 1], theirs[at + 1]);
    }
}
