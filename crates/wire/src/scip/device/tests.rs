use std::string::String;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::scip;

const MS: u64 = 1_000_000;

/// A URG-04LX by its specification C-42-03320B.
const URG: Description = Description {
    model: Model::Urg04lx,
    least_mm: 20,
    most_mm: 5600,
    steps_per_turn: 1024,
    first_step: 44,
    last_step: 725,
    front_step: 384,
    turns_per_minute: 600,
};

const UST: Description = Description {
    model: Model::Ust10lx,
    least_mm: 20,
    most_mm: 30_000,
    steps_per_turn: 1440,
    first_step: 0,
    last_step: 1080,
    front_step: 540,
    turns_per_minute: 2400,
};

fn rate() -> Rate {
    NonZeroU32::new(19_200)
}

/// A metre and as many millimetres as the ray's number.
fn ranges(facts: &Description) -> Vec<f64> {
    (0..=facts.last_step - facts.first_step).map(|i| 1.0 + f64::from(i) * 1e-3).collect()
}

/// The answer to one command at this instant, with a scan that began then.
fn ask(device: &mut Device, facts: &Description, now_ns: u64, command: &str) -> String {
    let (answer, text) = ask_bytes(device, facts, now_ns, command.as_bytes());
    assert!(matches!(answer, Answer::Written(_)), "{command}: {answer:?}");
    text
}

fn ask_bytes(device: &mut Device, facts: &Description, now_ns: u64, command: &[u8]) -> (Answer, String) {
    let mut out = Vec::new();
    let ends: Vec<bool> = command.iter().map(|&byte| device.push(byte)).collect();
    assert!(!ends.is_empty());
    let ranges_m = ranges(facts);
    let newest = Newest { begun_ns: now_ns, ranges_m: &ranges_m };
    let answer = device.answer(facts, rate(), now_ns, Some(newest), &mut out);
    (answer, String::from_utf8(out).unwrap())
}

fn scan(device: &mut Device, facts: &Description, begun_ns: u64) -> Option<String> {
    let (ranges_m, mut out) = (ranges(facts), Vec::new());
    device.wants_scan(begun_ns).then(|| {
        device.send_scan(facts, Newest { begun_ns, ranges_m: &ranges_m }, &mut out);
        String::from_utf8(out).unwrap()
    })
}

#[test]
fn versions_and_parameters_have_the_checksums_of_a_real_urg() {
    let mut device = Device::new();
    let parameters = ask(&mut device, &URG, 0, "PP\n");
    // The text is the real sensor's answer as printed on the page of its makers.
    let real = "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\nAMIN:44;7\n\
                AMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";
    assert_eq!(parameters, real);
    let versions = ask(&mut device, &URG, 0, "VV\n");
    assert!(
        versions
            .starts_with("VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\nFIRM:")
    );
    assert!(versions.contains("PROT:SCIP 2.0;N\nSERI:") && versions.ends_with("\n\n"), "{versions}");
    let information = ask(&mut device, &URG, 0, "II\n");
    assert!(information.contains("LASR:OFF;7\n") && information.contains("MESM:IDLE;:\n"), "{information}");
    assert!(information.contains("STAT:Sensor works well.;8\n") && information.contains("SBPS:19200[bps];"));
    assert_eq!(information.lines().count(), 10, "as many as urg_library counts: {information}");
}

#[test]
fn the_laser_is_lit_once_and_a_scan_needs_it() {
    let mut device = Device::new();
    assert_eq!(ask(&mut device, &URG, 0, "GD0044072501\n"), "GD0044072501\n10Q\n\n");
    assert_eq!(ask(&mut device, &URG, 0, "BM\n"), "BM\n00P\n\n");
    assert_eq!(ask(&mut device, &URG, 0, "BM;again\r\n"), "BM;again\n02R\n\n");
    assert!(ask(&mut device, &URG, 0, "\nGS0044004600\n").starts_with("GS0044004600\n00P\n"));
    assert_eq!(ask(&mut device, &URG, 0, "QT\r"), "QT\n00P\n\n");
    assert_eq!(ask(&mut device, &URG, 0, "GS0044072501\n"), "GS0044072501\n10Q\n\n");
}

#[test]
fn a_scan_has_its_time_and_its_distances_in_blocks_with_checksums() {
    let mut device = Device::new();
    ask(&mut device, &URG, 0, "BM\n");
    let three = ask(&mut device, &URG, 0x41 * MS, "GD0044004601;a b\n");
    // 1000, 1001 and 1002 in base 64 are 0-15-40, 0-15-41 and 0-15-42; the time is 1-1.
    assert_eq!(
        three,
        "GD0044004601;a b\n00P\n00112\n0?X0?Y0?Zi\n\n".replace("0?X0?Y0?Zi", &summed("0?X0?Y0?Z"))
    );
    let two = ask(&mut device, &URG, 0, "GS0044004601\n");
    assert!(two.contains(&summed("?X?Y?Z")), "{two}");
    let clusters = ask(&mut device, &URG, 0, "GD0040004703\n");
    // Steps 40 to 42 have no measurement; of the others the nearest counts.
    assert!(clusters.contains(&summed("0000?X0?Z")), "{clusters}");
}

fn summed(line: &str) -> String {
    let sum = line.bytes().fold(0u8, u8::wrapping_add);
    let mut line = String::from(line);
    line.push(char::from(0x30 + (sum & 0x3f)));
    line
}

#[test]
fn scans_come_behind_an_acknowledgement_and_count_down() {
    let mut device = Device::new();
    assert_eq!(ask(&mut device, &URG, 5 * MS, "MD0044072501102\n"), "MD0044072501102\n00P\n\n");
    assert_eq!(scan(&mut device, &URG, 4 * MS), None, "it began before the laser was lit");
    let first = scan(&mut device, &URG, 100 * MS).unwrap();
    let parsed = scip::parse(first.as_bytes()).unwrap();
    assert_eq!((parsed.time_ms, parsed.interval, parsed.remaining), (100, 1, 1));
    assert!(parsed.ranges_mm().enumerate().all(|(i, range_mm)| range_mm == Some(1000 + i as u32)));
    assert_eq!(scan(&mut device, &URG, 200 * MS), None, "the interval leaves one out");
    let last = scan(&mut device, &URG, 300 * MS).unwrap();
    assert_eq!(scip::parse(last.as_bytes()).unwrap().remaining, 0);
    assert_eq!(scan(&mut device, &URG, 400 * MS), None);
    assert!(ask(&mut device, &URG, 400 * MS, "BM\n").contains("02R"), "the laser stays lit");
}

#[test]
fn scans_without_an_end_end_with_qt_and_carry_their_text() {
    let mut device = Device::new();
    ask(&mut device, &URG, 0, "MS0044004700000;k9\n");
    for i in 0..150 {
        let text = scan(&mut device, &URG, i * 100 * MS).unwrap();
        assert!(text.starts_with("MS0044004700000;k9\n99b\n"), "{text}");
    }
    ask(&mut device, &URG, 1, "QT\n");
    assert_eq!(scan(&mut device, &URG, 20_000 * MS), None);
}

#[test]
fn each_error_has_its_status() {
    let cases = [
        ("GDx044072501", "01"),
        ("GD004407x501", "02"),
        ("GD00440725x1", "03"),
        ("GD0044076901", "04"),
        ("GD0045004401", "05"),
        ("MDx044072501000", "01"),
        ("MD0044x72501000", "02"),
        ("MS00440725x1000", "03"),
        ("MD0044076901000", "04"),
        ("MD0045004401000", "05"),
        ("MD0044072501x00", "06"),
        ("MD00440725010x0", "07"),
        ("TM3", "01"),
        ("TM1", "04"),
        ("TM2", "03"),
        ("SS1152x0", "01"),
        ("SS115201", "02"),
        ("SS019200", "03"),
        ("SS", "0C"),
        ("MD0044", "0C"),
        ("BM1", "0D"),
        ("XX", "0E"),
        ("V", "0E"),
        ("GE0044072501", "0E"),
        ("%ST", "0E"),
        ("SCIP2.0", "0E"),
        ("VV;12345678901234567", "0G"),
        ("VV;a#b", "0H"),
    ];
    for (command, status) in cases {
        let expected = [command, "\n", &summed(status), "\n\n"].concat();
        let mut device = Device::new();
        let answer = ask(&mut device, &URG, 0, &[command, "\n"].concat());
        assert_eq!(answer, expected);
        assert!(ask(&mut device, &URG, 0, "BM\n").contains("00P"), "{command} changes nothing");
    }
    let long = "V".repeat(65);
    assert_eq!(
        ask(&mut Device::new(), &URG, 0, &[&long, "\n"].concat()),
        [&long[..64], "\n0Bb\n\n"].concat()
    );
}

#[test]
fn in_time_mode_the_time_is_told_and_others_are_refused() {
    let mut device = Device::new();
    assert_eq!(ask(&mut device, &URG, 0, "TM0\n"), "TM0\n00P\n\n");
    assert_eq!(ask(&mut device, &URG, 0, "TM0\n"), "TM0\n02R\n\n");
    let time = ask(&mut device, &URG, ((1 << 24) + 0x41) * MS, "TM1\n");
    assert_eq!(time, "TM1\n00P\n00112\n\n", "24 bits");
    assert_eq!(ask(&mut device, &URG, 0, "QT\n"), "QT\n0Ee\n\n", "urg_library leaves time mode by this");
    assert_eq!(ask(&mut device, &URG, 0, "TM2\n"), "TM2\n00P\n\n");
    assert_eq!(ask(&mut device, &URG, 0, "QT\n"), "QT\n00P\n\n");
}

#[test]
fn a_rate_is_set_and_reset_behind_the_answer() {
    let mut device = Device::new();
    let (answer, text) = ask_bytes(&mut device, &URG, 0, b"SS115200\n");
    assert_eq!((answer, text.as_str()), (Answer::Written(Effect::Rate(115_200)), "SS115200\n00P\n\n"));
    ask(&mut device, &URG, 0, "BM\n");
    let (answer, text) = ask_bytes(&mut device, &URG, 7 * MS, b"RS\n");
    assert_eq!((answer, text.as_str()), (Answer::Written(Effect::FirstRate), "RS\n00P\n\n"));
    ask(&mut device, &URG, 7 * MS, "TM0\n");
    assert!(ask(&mut device, &URG, 8 * MS, "TM1\n").contains(&summed("0001")), "its clock began again");
    let mut out = Vec::new();
    for &byte in b"SS115200\n" {
        device.push(byte);
    }
    let answer = device.answer(&UST, None, 0, None, &mut out);
    assert_eq!(
        (answer, &out[9..11]),
        (Answer::Written(Effect::None), b"0F".as_slice()),
        "a network has no rate"
    );
}

/// The bytes that hokuyolx 0.9.0 sends when it connects and measures, and what its code looks for in the answers.
#[test]
fn hokuyolx_finds_what_it_looks_for() {
    let mut device = Device::new();
    let mut ask = |command| ask(&mut device, &UST, 0, command);
    assert_eq!(ask("%ST\n"), "%ST\n00P\n000@\n\n");
    assert_eq!(ask("TM0\n"), "TM0\n00P\n\n");
    assert_eq!(ask("TM1\n"), "TM1\n00P\n00000\n\n");
    assert_eq!(ask("%ST\n"), "%ST\n00P\n002B\n\n");
    assert_eq!(ask("TM2\n"), "TM2\n00P\n\n");
    assert!(ask("PP\n").contains("\nAMAX:1080;"));
    assert_eq!(ask("BM\n"), "BM\n00P\n\n");
    assert_eq!(ask("%ST\n"), "%ST\n00P\n003C\n\n");
    let pairs = ask("GE0000000100\n");
    let expected = ["GE0000000100\n00P\n00000\n", &summed("0?X0O@0?Y0O@"), "\n\n"].concat();
    assert_eq!(pairs, expected, "a distance and 2000 for each step");
    assert_eq!(ask("ME0000108000001\n"), "ME0000108000001\n00P\n\n");
    assert_eq!(ask("%ST\n"), "%ST\n00P\n004D\n\n");
    assert_eq!(ask("GD0000108000\n"), "GD0000108000\n10Q\n\n");
    assert_eq!(ask("QT\n"), "QT\n00P\n\n");
    assert_eq!(ask("%SL\n"), "%SL\n00P\n\n");
    assert_eq!(ask("%ST\n"), "%ST\n00P\n005E\n\n");
    assert_eq!(ask("BM\n"), "BM\n10Q\n\n");
    assert_eq!(ask("RT\n"), "RT\n00P\n\n");
    assert_eq!(ask("RB\n"), "RB\n01Q\n\n");
    assert_eq!(ask("RB\n"), "RB\n00P\n\n");
    assert_eq!(ask("VV;12345678901234567\n"), "VV;12345678901234567\n0Gg\n\n");
    assert_eq!(ask("TM\n"), "TM\n0Hh\n\n");
}

#[test]
fn a_whole_scan_with_intensities_splits_pairs_at_blocks() {
    let mut device = Device::new();
    ask(&mut device, &UST, 0, "ME0000108000001\n");
    let text = scan(&mut device, &UST, 25 * MS).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "ME0000108000000");
    let data = lines[3..lines.len() - 1].iter().map(|line| {
        let (block, sum) = line.split_at(line.len() - 1);
        assert_eq!(summed(block), [block, sum].concat());
        block
    });
    let data: String = data.collect();
    assert_eq!(data.len(), 1081 * 6);
    assert!(lines[3..lines.len() - 2].iter().all(|line| line.len() == 65));
}

#[test]
fn a_scan_that_is_not_there_yet_is_waited_for() {
    let mut device = Device::new();
    ask(&mut device, &URG, 50 * MS, "BM\n");
    for &byte in b"GD0044004400\n" {
        device.push(byte);
    }
    let (mut out, ranges_m) = (Vec::new(), ranges(&URG));
    let early = Newest { begun_ns: 49 * MS, ranges_m: &ranges_m };
    assert_eq!(device.answer(&URG, None, 60 * MS, Some(early), &mut out), Answer::Later);
    assert_eq!(out, b"");
    let newest = Newest { begun_ns: 100 * MS, ranges_m: &ranges_m };
    assert_eq!(device.answer(&URG, None, 170 * MS, Some(newest), &mut out), Answer::Written(Effect::None));
    assert!(out.starts_with(b"GD0044004400\n00P\n001T"));
    assert_eq!(device.answer(&URG, None, 170 * MS, Some(newest), &mut out), Answer::Nothing);
}

#[test]
fn a_million_random_bytes_leave_a_device_that_answers() {
    let (mut device, mut state, mut answers) = (Device::new(), 1u64, 0);
    let alphabet = b"VPIBQTRSMGDE%L0123456789;\r\n\n\n";
    let mut out = Vec::new();
    for i in 0..1_000_000u64 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let draw = (state >> 33) as usize;
        let byte = if i % 2 == 0 { draw as u8 } else { alphabet[draw % alphabet.len()] };
        if device.push(byte) {
            out.clear();
            let newest = Newest { begun_ns: i, ranges_m: &[1.0; 682] };
            let facts = if i % 3 == 0 { &UST } else { &URG };
            assert!(matches!(device.answer(facts, rate(), i, Some(newest), &mut out), Answer::Written(_)));
            assert!(out.len() < 10_000 && out.ends_with(b"\n\n"));
            answers += 1;
        }
    }
    assert!(answers > 10_000 && device.is_sound(1_000_000), "{answers}");
    device.push(b'\n');
    device.answer(&UST, None, 1_000_000, None, &mut out);
    assert!(ask(&mut device, &UST, 1_000_000, "RS\n").contains("00P"));
    assert!(postcard::to_allocvec(&device).is_ok_and(|bytes| bytes.len() < 200));
}

proptest! {
    /// A device that is saved and read again within a command goes on as the other.
    #[test]
    fn a_saved_device_goes_on(cut in 0usize..40) {
        let bytes = b"BM\nMD0044072501105;text\nMD00440725";
        let (before, behind) = bytes.split_at(cut.min(bytes.len()));
        let mut device = Device::new();
        let feed = |device: &mut Device, bytes: &[u8]| {
            let mut out = Vec::new();
            for &byte in bytes {
                if device.push(byte) {
                    device.answer(&URG, None, 0, None, &mut out);
                }
            }
            out
        };
        feed(&mut device, before);
        let mut again: Device = postcard::from_bytes(&postcard::to_allocvec(&device).unwrap()).unwrap();
        prop_assert_eq!(&again, &device);
        let rest = [behind, b"01000\nII\n".as_slice()].concat();
        prop_assert_eq!(feed(&mut again, &rest), feed(&mut device, &rest));
        prop_assert_eq!(again, device);
    }
}
