use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;
use std::{format, iter};

use proptest::collection::vec;
use proptest::prelude::*;

use super::*;

const IR: Encoding = Encoding::Level { bits: 10, min: 0.0, max: 1023.0 };
const WHEEL: Encoding = Encoding::Counter { bits: 16 };
const MOTOR: Encoding = Encoding::Signed { bits: 8, limit: 127.0 };
const ROBOT: Layout<'_> = Layout { components: &[IR; 8], counts: &[1; 8], motors: &[MOTOR; 2], ages: false };

fn any_encoding() -> impl Strategy<Value = Encoding> {
    prop_oneof![
        (1..=32u8).prop_map(|bits| Encoding::Level { bits, min: -1.0, max: 3.0 }),
        (2..=32u8).prop_map(|bits| Encoding::Signed { bits, limit: 2.0 }),
        (8..=32u8).prop_map(|bits| Encoding::Counter { bits }),
    ]
}

fn all(mut lines: Lines, bytes: &[u8]) -> Vec<Result<Vec<u8>, LineError>> {
    bytes.iter().filter_map(|&byte| lines.push(byte).map(|line| line.map(<[u8]>::to_vec))).collect()
}

fn written(write: impl FnOnce(&mut [u8]) -> Result<usize, WriteError>) -> Vec<u8> {
    let mut out = vec![0; MAX_PAYLOAD];
    let len = write(&mut out).unwrap();
    out.truncate(len);
    out
}

fn signals(line: &[u8]) -> Result<Vec<f64>, LineError> {
    match Question::parse(line, &ROBOT)? {
        Question::Poll => Ok(Vec::new()),
        Question::Command(signals) => Ok(signals.collect()),
    }
}

proptest! {
    #[test]
    fn readings_come_back_as_their_encodings_leave_them(
        parts in vec((any_encoding(), any::<f64>()), 0..40),
    ) {
        let (encodings, values): (Vec<_>, Vec<_>) = parts.iter().copied().unzip();
        let counts = vec![1; encodings.len()];
        let layout = Layout { components: &encodings, counts: &counts, ..ROBOT };
        prop_assert_eq!(check(&layout), Ok(()));
        let bytes = written(|out| write_readings(&layout, values.iter().copied(), out));
        prop_assert!(bytes.len() <= readings_len_max(&layout));
        let lines = all(Lines::of_answers(), &bytes);
        let [Ok(line)] = &lines[..] else { panic!("{lines:?}") };
        let Ok(Answer::Readings(read)) = Answer::parse(line, &layout) else { panic!("{line:?}") };
        prop_assert!(read.eq(parts.iter().map(|(encoding, value)| encoding.quantise(*value))));
    }

    #[test]
    fn commands_come_back_with_the_poll_behind_them(left: f64, right: f64) {
        let bytes = written(|out| write_exchange(&ROBOT, [left, right], out));
        let lines = all(Lines::of_questions(), &bytes);
        let [Ok(command), Ok(poll)] = &lines[..] else { panic!("{lines:?}") };
        prop_assert_eq!(signals(command), Ok(vec![MOTOR.quantise(left), MOTOR.quantise(right)]));
        prop_assert_eq!(Question::parse(poll, &ROBOT), Ok(Question::Poll));
    }

    #[test]
    fn what_fits_nowhere_is_said_to_need_its_length(room in 0..60usize, value in 0.0..1023.0) {
        let bytes = written(|out| write_readings(&ROBOT, [value; 8], out));
        let mut out = vec![0; room];
        let expected = match room >= bytes.len() {
            true => Ok(bytes.len()),
            false => Err(NoRoom { needed: bytes.len(), room }.into()),
        };
        prop_assert_eq!(write_readings(&ROBOT, [value; 8], &mut out), expected);
    }

    #[test]
    fn any_bytes_do_no_harm_and_the_next_line_is_read(bytes in vec(any::<u8>(), 0..2000)) {
        for mut lines in [Lines::of_questions(), Lines::of_answers()] {
            for &byte in &bytes {
                if let Some(Ok(line)) = lines.push(byte) {
                    prop_assert!(!line.is_empty() && line.len() <= MAX_LINE);
                    let _ = (Question::parse(line, &ROBOT), Answer::parse(line, &ROBOT));
                }
            }
            let _ = lines.push(b'\n');
            prop_assert_eq!(lines.push(b'N'), None);
            prop_assert_eq!(lines.push(b'\n'), Some(Ok(&b"N"[..])));
        }
    }

    #[test]
    fn any_printable_line_gives_as_many_values_as_the_layout_has_or_none(line in "[dnDN][0-9,-]{0,60}") {
        if let Ok(Question::Command(values)) = Question::parse(line.as_bytes(), &ROBOT) {
            prop_assert!(values.clone().count() == 2 && values.clone().all(|value| value.abs() <= 127.0));
        }
        if let Ok(Answer::Readings(values)) = Answer::parse(line.as_bytes(), &ROBOT) {
            prop_assert_eq!(values.count(), 8);
        }
    }

    #[test]
    fn lines_survive_being_saved(bytes in vec(any::<u8>(), 0..1200)) {
        let mut lines = Lines::of_answers();
        for &byte in &bytes {
            let _ = lines.push(byte);
        }
        let saved = postcard::to_allocvec(&lines).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Lines>(&saved).unwrap(), lines);
    }
}

#[test]
fn lines_look_as_those_of_the_robot_do() {
    let readings = [0.0, 1.0, 20.0, 300.0, 1023.0, 2000.0, f64::NAN, 5.4];
    let bytes = written(|out| write_readings(&ROBOT, readings, out));
    assert_eq!(bytes, b"n,0,1,20,300,1023,1023,0,5\r\n");
    assert_eq!(written(|out| write_command(&ROBOT, [127.0, -5.0], out)), b"D,127,-5\r");
    assert_eq!(written(|out| write_exchange(&ROBOT, [0.0, -200.0], out)), b"D,0,-127\rN\r");
    let wheels = Layout { components: &[WHEEL; 2], counts: &[2], ..ROBOT };
    assert_eq!(written(|out| write_readings(&wheels, [-32768.0, 32767.0], out)), b"n,-32768,32767\r\n");
    let wide = Layout { components: &[Encoding::Counter { bits: 32 }], counts: &[1], ..ROBOT };
    assert_eq!(written(|out| write_readings(&wide, [-2_147_483_648.0], out)), b"n,-2147483648\r\n");
    let none = Layout { components: &[], counts: &[], ..ROBOT };
    assert_eq!(written(|out| write_readings(&none, [], out)), b"n\r\n");
}

#[test]
fn eight_sensors_of_ten_bits_take_19_to_43_bytes_and_a_command_6_to_12() {
    let len = |value| written(|out| write_readings(&ROBOT, [value; 8], out)).len();
    assert_eq!((len(9.0), len(1000.0), readings_len_max(&ROBOT)), (19, 43, 43));
    let len = |signal| written(|out| write_command(&ROBOT, [signal; 2], out)).len();
    assert_eq!((len(0.0), len(-127.0), command_len_max(&ROBOT)), (6, 12, 12));
}

#[test]
fn a_question_ends_with_a_carriage_return_a_line_feed_or_both() {
    let expected: Vec<_> = [&b"N"[..], b"D,1,2", b"N", b"N"].map(|line| Ok(line.to_vec())).into();
    assert_eq!(all(Lines::of_questions(), b"\r\n\n\rN\rD,1,2\nN\r\nN\n\rN"), expected);
}

#[test]
fn an_answer_ends_with_its_line_feed() {
    let expected: Vec<_> = [&b"d"[..], b"n,1", b"a\rb"].map(|line| Ok(line.to_vec())).into();
    assert_eq!(all(Lines::of_answers(), b"\r\n\nd\r\nn,1\na\rb\r\nn,1\r"), expected);
}

#[test]
fn a_line_that_is_too_long_is_refused_and_forgotten() {
    let mut bytes = vec![b'1'; 2 * MAX_LINE];
    bytes.extend(b"\rN\r");
    let too_long = LineError::TooLong { limit: MAX_LINE, found: 2 * MAX_LINE };
    assert_eq!(all(Lines::of_questions(), &bytes), [Err(too_long), Ok(b"N".to_vec())]);
    let longest = vec![b'1'; MAX_LINE];
    let bytes: Vec<_> = longest.iter().copied().chain(*b"\n").collect();
    assert_eq!(all(Lines::of_answers(), &bytes), [Ok(longest)]);
}

#[test]
fn questions_that_make_no_sense_are_refused_for_what_is_wrong() {
    let count = |found| LineError::Count { expected: 2, found };
    let number = |index| LineError::Number { index };
    for (line, error) in [
        (&b"D"[..], count(0)),
        (b"D,", number(0)),
        (b"D,1", count(1)),
        (b"D,1,", number(1)),
        (b"D,1,2,", count(3)),
        (b"D,1,2,3", count(3)),
        (b"D1,2", count(0)),
        (b"D,1;2", number(0)),
        (b"D, 1,2", number(0)),
        (b"D,+1,2", number(0)),
        (b"D,1.5,2", number(0)),
        (b"D,--1,2", number(0)),
        (b"D,-,2", number(0)),
        (b"D,1\0,2", number(0)),
        (b"D,1,00000000001", number(1)),
        (b"D,1,99999999999999999999", number(1)),
        (b"D,128,0", LineError::Range { index: 0 }),
        (b"D,0,-128", LineError::Range { index: 1 }),
        (b"N,1", LineError::Count { expected: 0, found: 1 }),
        (b"N\0", LineError::Count { expected: 0, found: 1 }),
        (b"\0N", LineError::Letter { found: 0 }),
        (b"H", LineError::Letter { found: b'H' }),
        (b"n,1", LineError::Letter { found: b'n' }),
        (b"", LineError::Empty),
    ] {
        assert_eq!(signals(line), Err(error), "{}", String::from_utf8_lossy(line));
    }
    assert_eq!(signals(b"D,-0,0000000007"), Ok(vec![0.0, 7.0]));
}

#[test]
fn answers_that_make_no_sense_are_refused_for_what_is_wrong() {
    let values = |last: &str| format!("n{},{last}", ",9".repeat(7));
    let refused = |line: &str| Answer::parse(line.as_bytes(), &ROBOT).unwrap_err();
    assert_eq!(refused(&values("1024")), LineError::Range { index: 7 });
    assert_eq!(refused(&values("-1")), LineError::Range { index: 7 });
    assert_eq!(refused(&values("1x")), LineError::Number { index: 7 });
    assert_eq!(refused("n,1,2"), LineError::Count { expected: 8, found: 2 });
    assert_eq!(refused(&values("1,1")), LineError::Count { expected: 8, found: 9 });
    assert_eq!(refused("d,1"), LineError::Count { expected: 0, found: 1 });
    assert_eq!(refused("N"), LineError::Letter { found: b'N' });
    assert_eq!(Answer::parse(b"d", &ROBOT), Ok(Answer::Acknowledgement));
    assert!(Answer::parse(values("1023").as_bytes(), &ROBOT).is_ok());
}

#[test]
fn a_wrong_number_of_values_and_values_without_a_code_are_not_written() {
    let mut out = [0; MAX_PAYLOAD];
    let count = |found| Err(WriteError::Count { expected: 2, found });
    assert_eq!(write_command(&ROBOT, [0.0], &mut out), count(1));
    assert_eq!(write_command(&ROBOT, [0.0; 5], &mut out), count(3));
    let exact = Layout { motors: &[MOTOR, Encoding::Float64], ..ROBOT };
    assert_eq!(write_command(&exact, [0.0; 2], &mut out), Err(WriteError::NoCode { index: 1 }));
}

#[test]
fn a_layout_that_lines_cannot_say_is_named() {
    assert_eq!(check(&ROBOT), Ok(()));
    let exact = Layout { components: &[Encoding::Float64], counts: &[1], ..ROBOT };
    assert_eq!(check(&exact), Err(LayoutError::NoCode));
    let three = Layout { motors: &[MOTOR; 3], ..ROBOT };
    assert_eq!(check(&three), Err(LayoutError::Motors { found: 3 }));
    let many: Vec<_> = iter::repeat_n(Encoding::Counter { bits: 32 }, 43).collect();
    let long = Layout { components: &many, counts: &[43], ..ROBOT };
    assert_eq!(check(&long), Err(NoRoom { needed: 519, room: 512 }.into()));
    assert_eq!(check(&Layout { components: &many[..42], counts: &[42], ..ROBOT }), Ok(()));
    let error = LineError::TooLong { limit: MAX_LINE, found: 600 }.to_string();
    assert_eq!(error, "a line of 600 characters, but the longest has 511");
}
