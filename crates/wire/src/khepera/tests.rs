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
        Question::Access(access) => panic!("{access:?}"),
    }
}

fn is_in_range(register: Register, value: i32) -> bool {
    let [least, greatest] = register.range();
    (least..=greatest).contains(&value.into())
}

proptest! {
    #[test]
    fn readings_come_back_as_their_encodings_leave_them(
        parts in vec((any_encoding(), any::<f64>()), 0..40),
    ) {
        let (encodings, values): (Vec<_>, Vec<_>) = parts.iter().copied().unzip();
        let counts = vec![1; encodings.len()];
        let layout = Layout { components: &encodings, counts: &counts, ..ROBOT };
        let counters = encodings.iter().filter(|encoding| is_counter(encoding)).count();
        let expected = if counters == 0 { Ok(()) } else { Err(LayoutError::Positions { found: counters }) };
        prop_assert_eq!(check(&layout), expected);
        let bytes = written(|out| write_readings(&layout, values.iter().copied(), out));
        prop_assert!(bytes.len() <= readings_len_max(&layout));
        let lines = all(Lines::of_answers(), &bytes);
        let [Ok(line)] = &lines[..] else { panic!("{lines:?}") };
        let Ok(Answer::Readings(read)) = Answer::parse(line, &layout) else { panic!("{line:?}") };
        let told = parts.iter().filter(|(encoding, _)| !is_counter(encoding));
        prop_assert!(read.eq(told.map(|(encoding, value)| encoding.quantise(*value))));
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
                    if let Ok(access) = Access::parse(line) {
                        prop_assert!(access.settings().all(|(register, value)| is_in_range(register, value)));
                    }
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
    fn answers_of_registers_are_understood_and_fit_into_128_bytes(value: i32, i in 0..Command::ALL.len()) {
        let command = Command::ALL[i];
        let bytes = written(|out| write_answer(command, |_| Some(value), out));
        let lines = all(Lines::of_answers(), &bytes);
        let [Ok(line)] = &lines[..] else { panic!("{lines:?}") };
        let is_position = command == Command::Position;
        let expected = if is_position { Answer::Positions([value; 2]) } else { Answer::Registers(command) };
        prop_assert_eq!(Answer::parse(line, &ROBOT), Ok(expected));
        prop_assert!(bytes.len() <= 128);
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
    let signed = Encoding::Signed { bits: 32, limit: 2_147_483_647.0 };
    let wide = Layout { components: &[signed], counts: &[1], ..ROBOT };
    assert_eq!(written(|out| write_readings(&wide, [-2_147_483_647.0], out)), b"n,-2147483647\r\n");
    let none = Layout { components: &[], counts: &[], ..ROBOT };
    assert_eq!(written(|out| write_readings(&none, [], out)), b"n\r\n");
}

#[test]
fn counters_are_told_by_a_line_of_their_own_and_wrap_as_those_of_the_robot() {
    let wheels = Layout { components: &[IR, WHEEL, WHEEL], counts: &[1, 2], ..ROBOT };
    assert_eq!(check(&wheels), Ok(()));
    assert_eq!(poll(&wheels), b"H\rN\r");
    assert_eq!(poll(&ROBOT), b"N\r");
    assert_eq!(written(|out| write_exchange(&wheels, [0.0; 2], out)), b"D,0,0\rH\rN\r");
    assert_eq!(written(|out| write_readings(&wheels, [5.0, -32768.0, 32767.0], out)), b"n,5\r\n");
    assert_eq!((positions_len(&wheels), positions_len(&ROBOT)), ([7, 17], [0, 0]));
    let told = Answer::parse(b"h,-2147483648,32768", &wheels);
    assert_eq!(told, Ok(Answer::Positions([i32::MIN, 32_768])));
    assert_eq!(counted(&[WHEEL; 2], [i32::MIN, 32_768]), Some([0.0, -32_768.0]));
    assert_eq!(counted(&[IR; 2], [1, 2]), None);
    let mixed = Layout { counts: &[2, 1], ..wheels };
    assert_eq!(check(&mixed), Err(LayoutError::Positions { found: 2 }));
    for (line, error) in [
        (&b"h,1"[..], LineError::Count { expected: 2, found: 1 }),
        (b"h,1,2,3", LineError::Count { expected: 2, found: 3 }),
        (b"h,1,2147483648", LineError::Range { index: 1 }),
        (b"h,x,1", LineError::Number { index: 0 }),
    ] {
        assert_eq!(Answer::parse(line, &wheels), Err(error));
    }
    assert_eq!((input_number("ad_3"), input_number("ad_"), input_number("ir_3")), (Some(3), None, None));
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
        (b"M", LineError::Letter { found: b'M' }),
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
    let signed = Encoding::Signed { bits: 32, limit: 1.0 };
    let many: Vec<_> = iter::repeat_n(signed, 43).collect();
    let long = Layout { components: &many, counts: &[43], ..ROBOT };
    assert_eq!(check(&long), Err(NoRoom { needed: 519, room: 512 }.into()));
    assert_eq!(check(&Layout { components: &many[..42], counts: &[42], ..ROBOT }), Ok(()));
    let error = LineError::TooLong { limit: MAX_LINE, found: 600 }.to_string();
    assert_eq!(error, "a line of 600 characters, but the longest has 511");
}

/// The registers that a line sets, and the answer to it if every register holds 7.
fn exchange(line: &[u8]) -> Result<(Vec<i32>, String), LineError> {
    let access = Access::parse(line)?;
    let answer = written(|out| write_answer(access.command, |_| Some(7), out));
    Ok((access.settings().map(|(_, value)| value).collect(), String::from_utf8(answer).unwrap()))
}

#[test]
fn each_command_sets_its_registers_and_tells_its_own() {
    for (line, set, answer) in [
        (&b"A,3800,800,100"[..], &[3800, 800, 100][..], "a\r\n"),
        (b"B", &[], "b,5.02,5.01\r\n"),
        (b"C,-8388606,8388606", &[-8_388_606, 8_388_606], "c\r\n"),
        (b"E", &[], "e,7,7\r\n"),
        (b"F,3000,20,4000", &[3000, 20, 4000], "f\r\n"),
        (b"G,-2147483648,2147483647", &[i32::MIN, i32::MAX], "g\r\n"),
        (b"H", &[], "h,7,7\r\n"),
        (b"I,5", &[5], "i,7\r\n"),
        (b"J,20,64,127,255", &[20, 64, 127, 255], "j\r\n"),
        (b"K", &[], "k,7,7,7,7,7,7\r\n"),
        (b"L,1,2", &[1, 2], "l\r\n"),
        (b"O", &[], "o,7,7,7,7,7,7,7,7\r\n"),
        (b"P,-255,255", &[-255, 255], "p\r\n"),
        (b"R,63", &[63], "r,7\r\n"),
        (b"T,31,any,thing", &[31], "t\r\n"),
        (b"W,255,0", &[255, 0], "w\r\n"),
    ] {
        assert_eq!(
            exchange(line),
            Ok((set.to_vec(), answer.to_string())),
            "{}",
            String::from_utf8_lossy(line)
        );
        let letter = Command::of(line[0]).unwrap().letter();
        assert_eq!(Question::parse(line, &ROBOT).map(|_| letter), Ok(line[0]));
    }
    let mut letters: Vec<_> = Command::ALL.iter().map(|command| command.letter()).collect();
    letters.extend(b"DN");
    letters.sort_unstable();
    assert_eq!(letters, b"ABCDEFGHIJKLNOPRTW");
}

#[test]
fn lines_of_commands_that_make_no_sense_are_refused_for_what_is_wrong() {
    let range = |index| LineError::Range { index };
    for (line, error) in [
        (&b"A,1,2"[..], LineError::Count { expected: 3, found: 2 }),
        (b"B,1", LineError::Count { expected: 0, found: 1 }),
        (b"C,8388607,0", range(0)),
        (b"E ", LineError::Count { expected: 0, found: 1 }),
        (b"F,-1,0,0", range(0)),
        (b"G,0,2147483648", range(1)),
        (b"H\0", LineError::Count { expected: 0, found: 1 }),
        (b"I,6", range(0)),
        (b"J,20,64", LineError::Count { expected: 4, found: 2 }),
        (b"J,20,0,20,64", range(1)),
        (b"K,", LineError::Count { expected: 0, found: 1 }),
        (b"L,0,3", range(1)),
        (b"O1", LineError::Count { expected: 0, found: 1 }),
        (b"P,0,-256", range(1)),
        (b"R,1x", LineError::Number { index: 0 }),
        (b"T", LineError::Count { expected: 1, found: 0 }),
        (b"T,32,B", range(0)),
        (b"W,256,0", range(0)),
        (b"W,1,2,3", LineError::Count { expected: 2, found: 3 }),
        (b"a", LineError::Letter { found: b'a' }),
        (b"Z", LineError::Letter { found: b'Z' }),
    ] {
        assert_eq!(exchange(line), Err(error), "{}", String::from_utf8_lossy(line));
        assert_eq!(Question::parse(line, &ROBOT), Err(error));
    }
}

#[test]
fn a_register_that_a_robot_lacks_ends_its_answer_or_is_an_error() {
    let three = |register| matches!(register, Register::Ambient(0..3)).then_some(500);
    assert_eq!(written(|out| write_answer(Command::Ambient, three, out)), b"o,500,500,500\r\n");
    assert_eq!(written(|out| write_answer(Command::Position, three, out)), PROTOCOL_ERROR);
    assert_eq!(Answer::parse(b"o,500,500,500", &ROBOT), Ok(Answer::Registers(Command::Ambient)));
    let mut out = [0; 4];
    let no_room = NoRoom { needed: 7, room: 4 }.into();
    assert_eq!(write_answer(Command::Speed, |_| Some(1), &mut out), Err(no_room));
}

#[test]
fn refusals_are_understood_and_answers_of_another_shape_are_not() {
    for said in [NOT_FOUND, PROTOCOL_ERROR] {
        let lines = all(Lines::of_answers(), said);
        let [Ok(line)] = &lines[..] else { panic!("{lines:?}") };
        assert_eq!(Answer::parse(line, &ROBOT), Ok(Answer::Refusal));
    }
    let refused = |line: &str| Answer::parse(line.as_bytes(), &ROBOT).unwrap_err();
    assert_eq!(refused("h,1"), LineError::Count { expected: 2, found: 1 });
    assert_eq!(refused("h,1,x"), LineError::Number { index: 1 });
    assert_eq!(refused("h,1,2;"), LineError::Number { index: 1 });
    assert_eq!(refused("k,1,2,3,4,5,6,7"), LineError::Count { expected: 6, found: 7 });
    assert_eq!(refused("o"), LineError::Count { expected: 8, found: 0 });
    assert_eq!(refused("z"), LineError::Letter { found: b'z' });
    assert_eq!(refused("Command not foun"), LineError::Letter { found: b'C' });
}
