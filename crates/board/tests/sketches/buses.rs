//! I²C, SPI, and a serial port made of two pins.

use baudbot_board::{Compass, Kind, Led, LitBy, Pull, RangeFinder, Switch, Wiring};

use crate::sketches::bench::{Bench, MS, bench};

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn wire_talks_to_a_compass_and_a_range_finder() {
    let wiring = Wiring::builder()
        .part("compass", Kind::Compass(Compass))
        .part("range", Kind::RangeFinder(RangeFinder::SRF02))
        .connect("A4", "compass.sda")
        .connect("A5", "compass.scl")
        .connect("A4", "range.sda")
        .connect("A5", "range.scl");
    let mut bench = bench("bus.hex", wiring);
    bench.world.gauss = [0.3, -0.2, 0.4];
    bench.world.echo_ns[1] = Some(50 * 58_000 + 10_000);
    bench.run(300);
    bench.world.gauss = [-0.5, 0.25, -0.1];
    bench.world.echo_ns[1] = Some(231 * 58_000 + 10_000);
    let lines: Vec<String> = bench.lines().into_iter().map(|line| line.1).collect();
    // NACK at the address is 2.
    assert_eq!(lines[..3], ["0x42: 2", "0x1E: 0", "H43"]);
    assert!(lines[3..].iter().all(|line| line == "50 cm 327 -218 436 326.31"), "{lines:?}");
    bench.run(300);
    bench.lines();
    bench.run(3000);
    let lines = bench.lines();
    assert!(lines.len() > 20, "{lines:?}");
    assert!(lines.iter().all(|line| line.1 == "231 cm -545 273 -109 153.39"), "{lines:?}");
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn spi_takes_the_time_of_its_clock() {
    let mut bench = bench("spi.hex", Wiring::builder());
    bench.run(1000);
    let answers: Vec<(String, u64)> = bench
        .lines()
        .into_iter()
        .map(|(_, line)| {
            let (answer, cycles) = line.split_once(' ').unwrap();
            (answer.to_string(), cycles.parse().unwrap())
        })
        .collect();
    assert_eq!(answers.len(), 3);
    // The bus has no slave.
    assert!(answers.iter().all(|answer| answer.0 == "FF"), "{answers:?}");
    // Eight bits of 2, 4 and 128 periods; the program looks every 4 or 5, and has some instructions around.
    for (answer, bits) in answers.iter().zip([16, 32, 1024]) {
        assert!((bits..bits + 20).contains(&answer.1), "{answers:?}");
    }
    bench.assert_no_warnings();
}

/// A bit at 9600 baud is 104 µs and a sixth. The steps are a sixteenth of it.
const BIT_NS: u64 = 104_167;
const SAMPLES: u64 = 16;

/// Runs for a number of bits, which are the levels of pin 10, and takes those of pin 11.
fn run_bits(bench: &mut Bench, levels: impl IntoIterator<Item = bool>, heard: &mut Vec<bool>) {
    for level in levels {
        bench.world.pressed[0] = !level;
        for _ in 0..SAMPLES {
            bench.step(BIT_NS / SAMPLES);
            heard.push(bench.brightness(0) > 0.5);
        }
    }
}

/// The characters of a line that was looked at sixteen times a bit.
fn decode(samples: &[bool]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut at = samples.iter().position(|&level| level).unwrap_or(samples.len());
    while let Some(start) = samples[at..].iter().position(|&level| !level) {
        let middle = at + start + SAMPLES as usize / 2;
        let bit = |bit: usize| samples.get(middle + bit * SAMPLES as usize).copied().unwrap_or(true);
        assert!(!bit(0) && bit(9), "a frame at sample {middle}");
        bytes.push((0..8).map(|place| u8::from(bit(place + 1)) << place).sum());
        at = (middle + 9 * SAMPLES as usize).min(samples.len());
    }
    bytes
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn software_serial_sends_and_receives_at_9600_baud() {
    let line = Kind::Switch(Switch { pull: Pull::External, bounce_us: 0, seed: 0 });
    let wiring = Wiring::builder()
        .part("rx", line)
        .part("tx", Kind::Led(Led { lit_by: LitBy::High }))
        .connect("10", "rx")
        .connect("11", "tx");
    let mut bench = bench("soft_serial.hex", wiring);
    let mut heard = Vec::new();
    run_bits(&mut bench, [true; 1500], &mut heard);
    assert_eq!(decode(&heard), b"hello");
    heard.clear();
    let text = b"The quick brown fox, \x00\xff\x55";
    for &byte in text {
        let bits = (0..8).map(|place| byte >> place & 1 == 1);
        // Room for the answer, in which it cannot listen.
        let frame = [false].into_iter().chain(bits).chain([true; 25]);
        run_bits(&mut bench, frame, &mut heard);
    }
    assert_eq!(bench.bytes(), text);
    assert_eq!(decode(&heard), text.map(|byte| byte.wrapping_add(1)));
    assert!(bench.board.now_ns() > 150 * MS);
    bench.assert_no_warnings();
}
