use std::string::String;
use std::vec;
use std::vec::Vec;

use proptest::collection::vec as vec_of;
use proptest::prelude::*;

use super::*;
use crate::codec::{Notice, Sink, Stamp, Terms};
use crate::encoding::Encoding;
use crate::error::LayoutError;
use crate::layout::Layout;
use crate::protocol::{Agreement, Protocol};

/// A robot whose proximity sensors have 0, 100, … 700, and whose wheels have counted 10 and −20 steps.
fn code(name: &str, component: usize) -> Option<i16> {
    if name == "steps" {
        return [10, -20].get(component).copied();
    }
    let number: i16 = name.strip_prefix("ir_")?.parse().ok()?;
    (component == 0).then_some(100 * number)
}

/// What the robot does and says to these bytes; an answer is sent as soon as it is owed.
fn dialogue(machine: &mut Machine, bytes: &[u8]) -> (Vec<Deed>, Vec<u8>) {
    let (mut deeds, mut said) = (Vec::new(), Vec::new());
    for &byte in bytes {
        let Some(deed) = machine.push(byte) else { continue };
        deeds.push(deed);
        match deed {
            Deed::SetSteps(steps) => machine.set_steps(code, steps),
            Deed::Calibrate => machine.calibrate(code),
            Deed::Drive(_) | Deed::Reset | Deed::Answer | Deed::Unknown => {}
        }
        if machine.owes() {
            let mut out = [0; 512];
            let (len, _) = machine.answer(code, &mut out);
            said.extend_from_slice(&out[..len]);
        }
    }
    (deeds, said)
}

fn answer(line: &[u8]) -> String {
    String::from_utf8(dialogue(&mut Machine::new(), line).1).unwrap()
}

/// A binary letter.
const fn minus(letter: u8) -> u8 {
    letter.wrapping_neg()
}

/// The formats are those of Asercom.c.
#[test]
fn each_letter_has_its_answer() {
    for (line, expected) in [
        (&b"A\r"[..], "a,2048,2048,2816\r\n"),
        (b"B,1\r", "b\r\n"),
        (b"b\r", "b,1\r\n"),
        (b"C\r", "c,3\r\n"),
        (b"D,100,-100\r", "d\r\n"),
        (b"E\r", "e,0,0\r\n"),
        (b"F,2\r", "f\r\n"),
        (b"G\r", "g IR check : 0x0, address : 0x0, data : 0x0\r\n"),
        (b"g\r", "g,0,0,0\r\n"),
        (b"I\r", "i,1,40,40,8,3200\r\n"),
        (b"J,0,52,39,8\r", "j\r\n"),
        (
            b"K\r",
            "k, Starting calibration - Remove any object in sensors range\r\nk, Calibration finished\r\n",
        ),
        (b"L,8,1\r", "l\r\n"),
        (b"M\r", "m,0,0,0,0,0\r\n"),
        (b"N\r", "n,0,100,200,300,400,500,600,700\r\n"),
        (b"O\r", "o,4000,4000,4000,4000,4000,4000,4000,4000\r\n"),
        (b"P,5,6\r", "p\r\n"),
        (b"Q\r", "q,10,-20\r\n"),
        (b"S\r", "s\r\n"),
        (b"T,1\r", "t\r\n"),
        (b"U\r", "u,0,0,0\r\n"),
        (b"V\r", "v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n"),
        (b"W,192,1,2\r", "w\r\n"),
        (b"X\r", "z,Command not found\r\n"),
        (b"Y,1,2\r", "z,Command not found\r\n"),
        (b"?\r", "z,Command not found\r\n"),
        (b"\r\n\n", ""),
    ] {
        assert_eq!(answer(line), expected, "{}", line.escape_ascii());
    }
    let reset = answer(b"R\r");
    assert!(reset.starts_with("r\r\n\x0c\x07WELCOME to the SerCom protocol on e-Puck\r\n"), "{reset}");
    let help = answer(b"H\r");
    assert!(help.starts_with("\nA ") && help.ends_with("\r\n") && help.len() < 500, "{help}");
}

#[test]
fn a_line_may_end_in_three_ways_and_have_a_small_letter_but_b_and_g_are_others() {
    for line in [&b"q\r"[..], b"q\n", b"q\r\n", b"\r\nq\r", b"\0q\r"] {
        assert_eq!(answer(line), "q,10,-20\r\n", "{}", line.escape_ascii());
    }
    assert_eq!(answer(b"b\rB\rg\rt,1\r"), "b,1\r\nb\r\ng,0,0,0\r\nt\r\n");
}

/// As `scanf` reads them: a number that is missing is that of the last time.
#[test]
fn numbers_are_read_up_to_what_is_none() {
    for (line, speeds) in [
        (&b"D,100,200\r"[..], [100, 200]),
        (b"D,+5, -6\r", [5, -6]),
        (b"D,7\r", [7, 2]),
        (b"D\r", [1, 2]),
        (b"D,x,9\r", [1, 2]),
        (b"D,8;9\r", [8, 2]),
        (b"D,8,9,10\r", [8, 9]),
        (b"d,3,4 \r", [3, 4]),
        (b"D,65537,-32769\r", [1, 32767]),
    ] {
        let mut machine = Machine::new();
        dialogue(&mut machine, b"D,1,2\r");
        assert_eq!(dialogue(&mut machine, line).0, [Deed::Drive(speeds)], "{}", line.escape_ascii());
    }
}

#[test]
fn the_speeds_that_were_asked_for_are_told_even_beyond_what_the_robot_does_and_when_it_was_stopped() {
    let mut machine = Machine::new();
    let (deeds, said) = dialogue(&mut machine, b"D,2000,-300\rS\rE\r");
    assert_eq!(deeds, [Deed::Drive([2000, -300]), Deed::Drive([0, 0]), Deed::Answer]);
    assert_eq!(said, b"d\r\ns\r\ne,2000,-300\r\n");
}

#[test]
fn steps_are_counted_from_what_they_were_set_to_and_wrap_at_16_bits() {
    let mut machine = Machine::new();
    assert_eq!(dialogue(&mut machine, b"P,32767,-5\rQ\r").1, b"p\r\nq,32767,-5\r\n");
    let later = |name: &str, side| code(name, side).map(|steps| steps + 1);
    machine.push(b'Q');
    machine.push(b'\r');
    let mut out = [0; 40];
    let (len, content) = machine.answer(later, &mut out);
    assert_eq!((&out[..len], content), (&b"q,-32768,-4\r\n"[..], Content { steps: true, proximity: false }));
}

#[test]
fn a_calibration_makes_the_values_of_now_0_and_a_reset_forgets_all() {
    let mut machine = Machine::new();
    dialogue(&mut machine, b"K\rD,1,2\rP,3,4\r");
    assert_eq!(dialogue(&mut machine, b"N\r").1, b"n,0,0,0,0,0,0,0,0\r\n");
    assert_eq!(dialogue(&mut machine, b"R\r").0, [Deed::Reset]);
    assert_eq!(machine, Machine::new());
}

#[test]
fn the_camera_has_parameters_of_which_those_of_too_large_an_image_are_not_taken() {
    let mut machine = Machine::new();
    let said = dialogue(&mut machine, b"J,0,52,39,4,10,10\rI\rJ,1,160,120,1\rI\r").1;
    assert_eq!(said, b"j\r\ni,0,52,39,4,2028\r\nj\r\ni,1,160,120,1,-27136\r\n");
    let said = dialogue(&mut machine, b"J,1,60,60,1\rI\r").1;
    assert_eq!(said, b"j\r\ni,1,40,40,1,3200\r\n");
}

#[test]
fn binary_letters_are_answered_together_the_low_byte_first() {
    let mut machine = Machine::new();
    let asked = [minus(b'N'), minus(b'Q'), 0];
    let (deeds, said) = dialogue(&mut machine, &asked);
    assert_eq!(deeds, [Deed::Answer]);
    assert_eq!(said, [0, 0, 100, 0, 200, 0, 44, 1, 144, 1, 244, 1, 88, 2, 188, 2, 10, 0, 236, 255]);
    // Speeds are obeyed before the end comes, and a 0 among them is none. Nothing is confirmed.
    let (deeds, said) = dialogue(&mut machine, &[minus(b'D'), 0, 1, 156, 255, minus(b'L'), 8, 1, 0]);
    assert_eq!((deeds, said), (vec![Deed::Drive([256, -100])], vec![]));
    let (deeds, said) = dialogue(&mut machine, &[minus(b'P'), 1, 0, 2, 0, minus(b'Q'), minus(b'E'), 0]);
    assert_eq!(deeds, [Deed::SetSteps([1, 2]), Deed::Answer]);
    assert_eq!(said, [1, 0, 2, 0, 0, 1, 156, 255]);
}

#[test]
fn every_binary_letter_has_an_answer_of_its_length_or_none() {
    for letter in 1..=128 {
        let mut machine = Machine::new();
        // Data, if it has any, and the end.
        let said = dialogue(&mut machine, &[&[minus(letter)][..], &[0; 40]].concat()).1;
        assert_eq!(said.len(), answer_len(letter), "{}", letter.escape_ascii());
        assert_eq!(dialogue(&mut machine, b"C\r").1, b"c,3\r\n", "{}", letter.escape_ascii());
    }
    // 1 g, upright.
    let spherical = dialogue(&mut Machine::new(), &[minus(b'A'), 0]).1;
    assert_eq!(spherical, [768.0_f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
}

/// The firmware skips ends of lines before a line, and takes what follows for text.
#[test]
fn a_binary_letter_behind_both_ends_of_a_line_is_text() {
    let mut machine = Machine::new();
    assert_eq!(dialogue(&mut machine, b"C\r").1, b"c,3\r\n");
    assert_eq!(dialogue(&mut machine, &[minus(b't'), 0]).1, [0]);
    assert_eq!(dialogue(&mut machine, b"C\r\n").1, b"c,3\r\n");
    assert_eq!(dialogue(&mut machine, &[minus(b't'), 0]), (vec![], vec![]));
    assert_eq!(dialogue(&mut machine, b"\r"), (vec![Deed::Unknown], NOT_FOUND.to_vec()));
}

const IR: Encoding = Encoding::Level { bits: 12, min: 0.0, max: 1.0 };
const COUNT: Encoding = Encoding::Counter { bits: 16 };
const PLACES: [Option<u8>; 4] = [Some(1), None, Some(8), Some(9)];

fn agreement(components: &'static [Encoding]) -> Agreement<'static> {
    let layout = Layout { components, counts: &[1, 1, 2], motors: &[SPEED; 2], ages: false };
    Agreement { protocol: Protocol::Asercom, terms: Terms { layout, places: &PLACES } }
}

#[derive(Default)]
struct Readings(Vec<(usize, Vec<f64>)>);

impl Sink for Readings {
    fn take(&mut self, sensor: usize, _: Option<Stamp>, values: impl Iterator<Item = f64>) {
        self.0.push((sensor, values.collect()));
    }
}

#[test]
fn a_program_of_messages_drives_in_steps_a_second_and_reads_what_has_a_place() {
    let robot = agreement(&[IR, IR, COUNT, COUNT]);
    assert_eq!(robot.check(), Ok(()));
    let mut out = [0; 64];
    let len = robot.write_command(0, [1.0, -0.5], &mut out).unwrap();
    assert_eq!(&out[..len], b"D,1000,-500\rQ\rN\r");
    let mut taken = Readings::default();
    assert_eq!(robot.read(b"d", 0, &mut taken), Notice::Acknowledgement);
    assert_eq!(robot.read(b"q,7,-8", 0, &mut taken), Notice::Positions([7, -8]));
    assert_eq!(robot.read(b"n,1,4095,3,4,5,6,7,8", 0, &mut taken), Notice::Readings);
    robot.read_positions([7, -8], &mut taken);
    assert_eq!(taken.0, [(0, vec![1.0]), (2, vec![7.0, -8.0])]);
    let mut none = Readings::default();
    for (line, notice) in [
        (&b"n,1,2,3"[..], Notice::Nonsense),
        (b"n,1,2,3,4,5,6,7,8,9", Notice::Nonsense),
        (b"n,1,9999,3,4,5,6,7,8", Notice::Readings),
        (b"q,1", Notice::Nonsense),
        (b"q,1,99999", Notice::Nonsense),
        (b"c,3", Notice::Answer),
        (b"\x0c\x07WELCOME", Notice::Answer),
        (b"\x90", Notice::Nonsense),
    ] {
        assert_eq!(robot.read(line, 0, &mut none), notice, "{}", line.escape_ascii());
    }
    assert_eq!(none.0, []);
    let bare = agreement(&[IR, IR, Encoding::Float64, COUNT]);
    assert_eq!(bare.check(), Err(LayoutError::NoCode));
}

#[test]
fn the_lengths_are_those_of_the_lines() {
    let robot = agreement(&[IR, IR, COUNT, COUNT]);
    let none = "n,0,0,0,0,0,0,0,0\r\n".len();
    assert_eq!(robot.readings_len(), [none, none + 3]);
    assert_eq!(robot.command_len(), ["D,0,0\r".len(), "D,-1023,-1023\r".len()]);
    let preface = robot.preface();
    assert_eq!((preface.acknowledgement, preface.positions), (3, [7, "q,-32768,-32768\r\n".len()]));
}

proptest! {
    #[test]
    fn any_bytes_do_no_harm_and_no_answer_is_too_long(bytes in vec_of(any::<u8>(), 0..400)) {
        let mut machine = Machine::new();
        for &byte in &bytes {
            machine.push(byte);
            if machine.owes() {
                let mut out = [0; 512];
                let (len, _) = machine.answer(code, &mut out);
                prop_assert!(len <= 512);
                prop_assert!(!machine.owes());
            }
            prop_assert!(machine.asked.len() <= MOST_ASKED);
        }
        let saved = postcard::to_allocvec(&machine).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Machine>(&saved).unwrap(), machine);
    }

    #[test]
    fn an_answer_for_which_there_is_no_room_is_cut(room in 0..60_usize) {
        let mut machine = Machine::new();
        b"N\r".iter().for_each(|&byte| _ = machine.push(byte));
        let mut out = vec![0; room];
        let (len, _) = machine.answer(code, &mut out);
        prop_assert_eq!(len, room.min(33));
    }
}
