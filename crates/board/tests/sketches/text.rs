//! Text over the serial cable, both ways.

use baudbot_board::{Kind, Voltage, WarningKind, Wiring};

use crate::sketches::bench::{FUSES, MS, bench, chip, with_chip};

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn six_voltages_are_printed_at_9600_baud_with_exact_bits() {
    let mut wiring = Wiring::builder();
    for input in 0..6 {
        let name = format!("v{input}");
        wiring = wiring.part(name.clone(), Kind::Voltage(Voltage::DIRECT)).connect(format!("A{input}"), name);
    }
    let mut bench = bench("analog.hex", wiring);
    bench.world.volts[..6].copy_from_slice(&[0.0, 1.0, 2.5, 3.3, 4.9, 5.0]);
    bench.run(5000);
    let lines = bench.lines();
    assert!(lines.len() > 40, "{}", lines.len());
    assert!(lines.iter().all(|line| line.1 == "0\t204\t512\t675\t1003\t1023"), "{lines:?}");
    let of_line = lines[0].1.len() + 1;
    for line in bench.sent.chunks_exact(of_line) {
        // UBRR 207 with U2X: 10 bits of 8 times 208 periods. The buffer is never empty within a line.
        assert!(line.iter().all(|sent| sent.end_ns - sent.start_ns == 1_040_000), "{line:?}");
        assert!(line[2..].windows(2).all(|two| two[0].end_ns == two[1].start_ns), "{line:?}");
    }
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn lines_at_115200_baud_are_understood_and_answered() {
    let mut bench = bench("echo.hex", Wiring::builder());
    bench.run(200);
    assert_eq!(bench.text(), "ready\r\n");
    for (line, answer) in [
        ("12 7\n", "sum 19 product 84\r\n"),
        ("-12 7\n", "sum -5 product -84\r\n"),
        ("hello, robot\n", "HELLO, ROBOT\r\n"),
        ("65536 -3\n", "sum 65533 product -196608\r\n"),
    ] {
        bench.enter(line, 115_200);
        bench.run(500);
        assert_eq!(bench.text(), answer);
    }
    // More than its buffer of 64 holds, without a pause: it keeps up.
    let long = "a line of more characters than fit into the buffer of the serial port, which are 64, without a pause\n";
    bench.enter(long, 115_200);
    bench.run(500);
    assert_eq!(bench.text(), format!("{}\r\n", long.trim_end().to_uppercase()));
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn a_long_report_fills_the_line_without_gaps() {
    let mut bench = bench("flood.hex", Wiring::builder());
    for _ in 0..100 {
        // Up to 21 ms the board keeps all.
        bench.step(20 * MS);
    }
    let lines = bench.lines();
    assert!(lines.len() > 500, "{}", lines.len());
    for (number, (_, line)) in lines.iter().enumerate() {
        assert_eq!(line, &format!("line {number} of a long report that never ends"));
    }
    // UBRR 16 with U2X: 10 bits of 8 times 17 periods are 85 µs.
    for two in bench.sent[2..].windows(2) {
        assert_eq!((two[1].start_ns - two[0].start_ns, two[0].end_ns), (85_000, two[1].start_ns));
    }
    bench.assert_no_warnings();
    bench.step(40 * MS);
    bench.step(MS);
    let lost = bench.board.warnings();
    assert!(lost.len() == 1 && lost[0].kind == WarningKind::SentLost && lost[0].count > 200, "{lost:?}");
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn numbers_are_printed_as_print_and_string_make_them() {
    let mut bench = bench("print.hex", Wiring::builder());
    bench.run(1000);
    let lines: Vec<String> = bench.lines().into_iter().map(|line| line.1).collect();
    assert_eq!(
        lines,
        [
            "3.1416",
            // The value as a float of 32 bits is a little less than half of the last place.
            "-0.00",
            "inf",
            "nan",
            "ovf",
            "11111111",
            "FFFFFFFF",
            "4294967295",
            "-2147483648",
            "v=-17,2.500,1",
            "5",
            "-17",
            "25.00",
            "-0042|ab    |0000beef|!",
            "    -7.13",
            "841.471",
            "1.41421",
            "1",
        ]
    );
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn the_eeprom_keeps_a_structure_over_starts() {
    let mut bench = bench("eeprom.hex", Wiring::builder());
    bench.run(500);
    let lines = bench.lines();
    assert_eq!(lines[1].1, "1 1.25 -300 left 1024");
    // 14 writes of 3.4 ms, the last of which is not waited for; the first waits for one more.
    let us: u64 = lines[0].1.parse().unwrap();
    assert!(us.abs_diff(14 * 3400) < 600, "{us}");
    bench.assert_no_warnings();
    let kept = bench.board.chip().eeprom().to_vec();
    assert_eq!(kept[..1], [1]);
    assert_eq!(kept[16..30], *b"\x00\x00\xa0\x3f\xd4\xfeleft\0\0\0\0");
    let mut again = chip("eeprom.hex", FUSES).unwrap();
    again.eeprom_mut().copy_from_slice(&kept);
    let mut bench = with_chip(again, Wiring::builder());
    bench.run(500);
    assert_eq!(bench.text(), "2 1.25 -300 left 1024\r\n");
    bench.assert_no_warnings();
}
