//! A sketch over the serial cable into an Arduino Uno with its boot loader.

use baudbot_avr::Fuses;
use baudbot_board::{Kind, Led, LitBy, Wiring};

use crate::sketches::bench::{Bench, chip, program, with_chip};

const IN_SYNC: [u8; 2] = [0x14, 0x10];
const PAGE: usize = 128;

fn ask(bench: &mut Bench, command: &[u8]) -> Vec<u8> {
    bench.enter([command, b" "].concat(), 115_200);
    bench.run(30);
    bench.bytes()
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn optiboot_takes_a_sketch_and_starts_it() {
    let led = Kind::Led(Led { lit_by: LitBy::High });
    let fuses = Fuses { high: 0xDC, ..Fuses::ARDUINO_UNO };
    let chip = chip("optiboot.hex", fuses).unwrap();
    let mut bench = with_chip(chip, Wiring::builder().part("led", led).connect("13", "led"));
    // The boot loader waits only after a reset by the pin, which the cable gives.
    bench.board.reset();
    // The boot loader flashes the LED three times first.
    bench.run(600);
    assert_eq!(ask(&mut bench, b"0"), IN_SYNC);
    assert_eq!(ask(&mut bench, b"u"), [0x14, 0x1E, 0x95, 0x0F, 0x10], "the signature");
    let sketch = program("blink.hex").unwrap();
    for (page, words) in sketch.flash().chunks(PAGE).enumerate() {
        let [low, high] = ((page * PAGE / 2) as u16).to_le_bytes();
        assert_eq!(ask(&mut bench, &[b'U', low, high]), IN_SYNC);
        let mut bytes = words.to_vec();
        bytes.resize(PAGE, 0xFF);
        let command = [&[b'd', 0, PAGE as u8, b'F'][..], &bytes].concat();
        assert_eq!(ask(&mut bench, &command), IN_SYNC, "page {page}");
        let answer = ask(&mut bench, &[b't', 0, PAGE as u8, b'F']);
        assert!(page > 0 || answer[1..=PAGE] != [0xFF; PAGE], "it is not empty");
    }
    assert_eq!(ask(&mut bench, b"Q"), IN_SYNC);
    // The boot loader lets the watchdog reset the chip, and the sketch is started.
    bench.run(1000);
    let edges = bench.light_edges(5000);
    assert!(edges.len() >= 9, "{edges:?}");
    assert!(edges.windows(2).all(|two| (two[1] - two[0]).abs_diff(500_006_000) < 10_000), "{edges:?}");
    let kinds: Vec<_> = bench.board.warnings().iter().map(|warning| warning.kind).collect();
    assert_eq!(kinds, [baudbot_board::WarningKind::WatchdogReset]);
}
