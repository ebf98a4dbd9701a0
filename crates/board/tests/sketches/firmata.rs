//! StandardFirmata as others have built it, driven by the bytes of its protocol.
//!
//! Source: the Firmata protocol, versions 2.3 and 2.4.

use baudbot_board::{BridgeKind, Compass, Decay, Kind, Led, LitBy, Pull, ServoKind, Switch, Voltage, Wiring};

use crate::sketches::bench::{Bench, MS, US, bench_with_fetched};

const BAUD: u32 = 57_600;
const START: u8 = 0xF0;
const END: u8 = 0xF7;
const REPORT_VERSION: u8 = 0xF9;
const SET_MODE: u8 = 0xF4;
const MODE_INPUT: u8 = 0;
const MODE_OUTPUT: u8 = 1;
const MODE_PWM: u8 = 3;
const MODE_SERVO: u8 = 4;

/// The parts, in the order of the wiring below.
const POTENTIOMETER: usize = 0;
const BUTTON: usize = 1;

fn robot(file: &str) -> Option<Bench> {
    let button = Kind::Switch(Switch { pull: Pull::External, bounce_us: 0, seed: 1 });
    let motor = Kind::Bridge(BridgeKind::Directed { decay: Decay::Coast, drop_v: 0.0 });
    let wiring = Wiring::builder()
        .part("potentiometer", Kind::Voltage(Voltage::DIRECT))
        .part("button", button)
        .part("led", Kind::Led(Led { lit_by: LitBy::High }))
        .part("motor", motor)
        .part("left_servo", Kind::Servo(ServoKind::Standard))
        .part("right_servo", Kind::Servo(ServoKind::Standard))
        .part("compass", Kind::Compass(Compass))
        .connect("A0", "potentiometer")
        .connect("7", "button")
        .connect("13", "led")
        .connect("6", "motor.pwm")
        .connect("VCC", "motor.direction")
        .connect("9", "left_servo")
        .connect("10", "right_servo")
        .connect("A4", "compass.sda")
        .connect("A5", "compass.scl");
    bench_with_fetched(file, wiring)
}

fn send(bench: &mut Bench, bytes: &[u8]) {
    bench.enter(bytes, BAUD);
    bench.run(100);
}

/// The last two bytes with 7 bits each behind a command, and how often it came.
fn reports(bytes: &[u8], command: u8) -> Vec<u16> {
    let found = bytes.windows(3).filter(|three| three[0] == command);
    found.map(|three| u16::from(three[1]) | u16::from(three[2]) << 7).collect()
}

/// The contents of the first answer of a kind.
fn answer(bytes: &[u8], kind: u8) -> Vec<u8> {
    let start = bytes.windows(2).position(|two| two == [START, kind]).expect("an answer") + 2;
    let length = bytes[start..].iter().position(|&byte| byte == END).expect("an end");
    bytes[start..start + length].to_vec()
}

fn in_pairs(text: &[u8]) -> Vec<u8> {
    text.iter().flat_map(|byte| [byte & 0x7F, byte >> 7]).collect()
}

fn assert_greets(bench: &mut Bench, minor: u8) {
    // The firmware shows its version by flashes of the LED first.
    bench.run(4000);
    let greeting = bench.bytes();
    assert_eq!(greeting[..3], [REPORT_VERSION, 2, minor]);
    let firmware = answer(&greeting, 0x79);
    assert_eq!(firmware[..2], [2, minor]);
    let name = String::from_utf8(firmware[2..].chunks(2).map(|two| two[0] | two[1] << 7).collect()).unwrap();
    assert!(name.starts_with("StandardFirmata"), "{name}");
    send(bench, &[REPORT_VERSION]);
    assert_eq!(bench.bytes(), [REPORT_VERSION, 2, minor]);
}

fn assert_has_its_pins(bench: &mut Bench) {
    send(bench, &[START, 0x6B, END]);
    let capabilities = answer(&bench.bytes(), 0x6C);
    let pins: Vec<&[u8]> = capabilities.split(|&byte| byte == 0x7F).collect();
    // Twenty, each of which ends with 0x7F.
    assert_eq!((pins.len(), pins[20]), (21, &[][..]));
    let has = |pin: usize, mode: u8, bits: u8| pins[pin].chunks(2).any(|two| two == [mode, bits]);
    assert!(pins[0].is_empty() && pins[1].is_empty(), "the cable");
    for (pin, modes) in pins[..20].iter().enumerate().skip(2) {
        assert!(has(pin, MODE_OUTPUT, 1) && has(pin, MODE_INPUT, 1), "{pin}: {modes:?} {capabilities:?}");
        assert_eq!(has(pin, MODE_PWM, 8), [3, 5, 6, 9, 10, 11].contains(&pin), "{pin}: {modes:?}");
        assert_eq!(has(pin, 2, 10), pin >= 14, "{pin}: {modes:?}");
    }
    send(bench, &[START, 0x69, END]);
    let channels: Vec<u8> = [0x7F; 14].into_iter().chain(0..6).collect();
    assert_eq!(answer(&bench.bytes(), 0x6A), channels);
}

fn assert_reports_voltages(bench: &mut Bench) {
    bench.world.volts[POTENTIOMETER] = 2.5;
    send(bench, &[0xC0, 1]);
    bench.bytes();
    for (volts, count) in [(2.5, 512), (0.0, 0), (5.0, 1023), (3.3, 675)] {
        bench.world.volts[POTENTIOMETER] = volts;
        bench.run(50);
        bench.bytes();
        bench.run(1900);
        let values = reports(&bench.bytes(), 0xE0);
        // Every 19 ms, its own rounding of the clock included.
        assert!((94..=101).contains(&values.len()), "{}", values.len());
        assert!(values.iter().all(|&value| value == count), "{values:?}");
    }
    // Every 50 ms.
    send(bench, &[START, 0x7A, 50, 0, END]);
    bench.bytes();
    bench.run(2000);
    let values = reports(&bench.bytes(), 0xE0);
    assert!((38..=41).contains(&values.len()), "{}", values.len());
    send(bench, &[0xC0, 0]);
    bench.bytes();
    bench.run(500);
    assert!(bench.bytes().is_empty());
}

fn assert_switches_the_led_and_reads_the_button(bench: &mut Bench) {
    send(bench, &[SET_MODE, 13, MODE_OUTPUT, 0x91, 0x20, 0]);
    bench.run(2);
    assert_eq!(bench.brightness(0), 1.0);
    send(bench, &[0x91, 0, 0]);
    assert_eq!(bench.brightness(0), 0.0);
    send(bench, &[SET_MODE, 7, MODE_INPUT, 0xD0, 1]);
    assert_eq!(reports(&bench.bytes(), 0x90).last(), Some(&0x80));
    for pressed in [true, false, true, false] {
        bench.world.pressed[BUTTON] = pressed;
        bench.run(20);
        assert_eq!(reports(&bench.bytes(), 0x90), [if pressed { 0 } else { 0x80 }]);
    }
    send(bench, &[0xD0, 0]);
    bench.bytes();
}

fn assert_drives_a_motor_and_servos(bench: &mut Bench) {
    send(bench, &[SET_MODE, 6, MODE_PWM, 0xE6, 0x7F, 0x01]);
    bench.run(2);
    assert_eq!(bench.duties(), [1.0]);
    send(bench, &[0xE6, 0x3F, 0]);
    bench.run(2);
    assert_eq!(bench.duties(), [64.0 / 256.0]);
    // The left servo goes between 1000 µs and 2000 µs, the right one between the library's defaults: 544 µs to 2400 µs.
    let [least, most] = [1000u16, 2000].map(|us| [us as u8 & 0x7F, (us >> 7) as u8]);
    send(bench, &[START, 0x70, 9, least[0], least[1], most[0], most[1], END]);
    send(bench, &[SET_MODE, 9, MODE_SERVO, SET_MODE, 10, MODE_SERVO]);
    for angle in [0u16, 90, 180, 37] {
        send(
            bench,
            &[0xE9, angle as u8 & 0x7F, (angle >> 7) as u8, 0xEA, angle as u8 & 0x7F, (angle >> 7) as u8],
        );
        let wanted = [(1000, 2000), (544, 2400)]
            .map(|(least, most)| (least + u64::from(angle) * (most - least) / 180) * 1000);
        assert_pulses(bench, wanted);
    }
}

/// The library lets its timer end 2 µs early, and needs about so long to end the pulse. Other interrupts delay an edge.
fn assert_pulses(bench: &mut Bench, wanted: [u64; 2]) {
    let mut widths = [const { Vec::new() }; 2];
    for _ in 0..51 {
        bench.run(20);
        for (servo, widths) in bench.board.servos().zip(&mut widths) {
            let pulse = servo.pulse.unwrap();
            assert!(bench.board.now_ns() - pulse.at_ns < 24 * MS);
            widths.push(pulse.width_ns);
        }
    }
    for (mut widths, wanted) in widths.into_iter().zip(wanted) {
        widths.sort_unstable();
        assert!(widths[25].abs_diff(wanted) <= US, "{} instead of {wanted}", widths[25]);
        assert!(widths[0] > wanted - 7 * US && widths[50] < wanted + 7 * US, "{widths:?}");
    }
}

fn assert_reads_the_bus(bench: &mut Bench) {
    send(bench, &[START, 0x78, 0, 0, END]);
    // Three bytes from register 10, once.
    let read = [&[START, 0x76, 0x1E, 0x08][..], &in_pairs(&[10, 3]), &[END]].concat();
    send(bench, &read);
    let awaited = [in_pairs(&[0x1E, 10]), in_pairs(b"H43")].concat();
    assert_eq!(answer(&bench.bytes(), 0x77), awaited);
}

fn drive(file: &str, minor: u8) {
    let Some(mut bench) = robot(file) else { return };
    assert_greets(&mut bench, minor);
    assert_has_its_pins(&mut bench);
    assert_reports_voltages(&mut bench);
    assert_switches_the_led_and_reads_the_button(&mut bench);
    assert_drives_a_motor_and_servos(&mut bench);
    assert_reads_the_bus(&mut bench);
    // At first it makes all pins outputs that are low, the button's among them, which has a resistor.
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn standard_firmata_2_4_is_driven_by_its_protocol() {
    drive("firmata_2_4.hex", 4);
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn standard_firmata_2_3_of_arduino_1_0_6_is_driven_by_its_protocol() {
    drive("firmata_2_3.hex", 3);
}
