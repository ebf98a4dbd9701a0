use std::string::ToString;
use std::vec;

use super::*;
use crate::parts::{BridgeKind, Channels, Compass, Decay, Encoder, Pull, RangeFinder, Switch, Voltage};

const IR: Kind = Kind::Voltage(Voltage::DIRECT);
const BUTTON: Kind = Kind::Switch(Switch { pull: Pull::External, bounce_us: 0, seed: 0 });
const MOTOR: Kind = Kind::Bridge(BridgeKind::Directed { decay: Decay::Brake, drop_v: 0.0 });
const ENCODER: Kind = Kind::Encoder(Encoder { channels: Channels::Single, counts_per_turn: 20 });

fn robot() -> Builder {
    Wiring::builder().part("sensors.ir_left", IR).part("motors.left", MOTOR).part("encoders.left", ENCODER)
}

fn error(builder: Builder) -> WiringError {
    builder.build().unwrap_err()
}

#[test]
fn a_table_of_pins_and_terminals_is_a_wiring() {
    let wiring = robot()
        .connect("A0", "sensors.ir_left")
        .connect("9", "motors.left.pwm")
        .connect("PB0", "motors.left.direction")
        .connect("2", "encoders.left.a")
        .build()
        .unwrap();
    let motor = wiring.part("motors.left").unwrap();
    assert_eq!(wiring.net(Terminal { part: motor, role: Role::Direction }), Net::by_name("8"));
    assert_eq!(wiring.voltage_on(0), wiring.part("sensors.ir_left"));
    assert_eq!(wiring.name(motor), "motors.left");
    assert!(wiring.takes_shapes(Pin::new(baudbot_avr::Port::B, 1).unwrap()));
}

#[test]
fn an_unknown_pin_is_named_with_its_terminal() {
    let error = error(robot().connect("A9", "sensors.ir_left"));
    assert_eq!(error, WiringError::UnknownPin { terminal: "sensors.ir_left".into(), pin: "A9".into() });
    assert!(error.to_string().starts_with("`sensors.ir_left` is on `A9`, which is no pin"));
}

#[test]
fn an_unknown_part_is_answered_by_those_there_are() {
    for text in ["sensors.ir_right", "sensors.ir_right.signal", "nothing", ""] {
        let known = vec!["sensors.ir_left".into(), "motors.left".into(), "encoders.left".into()];
        let error = error(robot().connect("A0", text));
        assert_eq!(error, WiringError::UnknownPart { pin: "A0".into(), text: text.into(), known });
    }
}

#[test]
fn an_unknown_terminal_is_answered_by_those_the_part_has() {
    for text in ["motors.left.speed", "motors.left"] {
        let error = error(robot().connect("9", text));
        let said = std::format!("pin 9: `{text}` names no terminal of `motors.left`; it has: pwm, direction");
        assert_eq!(error.to_string(), said);
    }
}

#[test]
fn one_pin_has_one_driver() {
    let builder = Wiring::builder().part("a", BUTTON).part("b", BUTTON).connect("2", "a").connect("PD2", "b");
    assert_eq!(error(builder).to_string(), "`a.signal` and `b.signal` both drive PD2");
    let led = Kind::Led(crate::parts::Led { lit_by: crate::parts::LitBy::High });
    let shared = Wiring::builder().part("a", BUTTON).part("led", led).connect("2", "a").connect("2", "led");
    assert!(shared.build().is_ok(), "a button that also switches a lamp");
}

#[test]
fn a_voltage_needs_the_adc_and_a_digital_signal_a_pin() {
    let at = |pin: &str, kind| error(Wiring::builder().part("part", kind).connect(pin, "part"));
    assert!(matches!(at("9", IR), WiringError::NoAdc { .. }));
    assert!(matches!(at("A6", BUTTON), WiringError::NotDigital { .. }));
    assert!(matches!(at("GND", BUTTON), WiringError::NotDigital { .. }));
    assert!(Wiring::builder().part("part", IR).connect("A7", "part").build().is_ok());
}

#[test]
fn each_terminal_is_connected_once() {
    let open = robot()
        .connect("A0", "sensors.ir_left")
        .connect("2", "encoders.left")
        .connect("9", "motors.left.pwm");
    assert_eq!(error(open), WiringError::Open { part: "motors.left".into(), terminal: Role::Direction });
    let twice = robot().connect("A0", "sensors.ir_left").connect("A1", "sensors.ir_left");
    assert_eq!(error(twice).to_string(), "`sensors.ir_left.signal` is on PC0 and on PC1");
}

#[test]
fn names_and_addresses_are_used_once() {
    assert_eq!(error(robot().part("motors.left", IR)), WiringError::SameName { part: "motors.left".into() });
    let bus = |first, second| {
        let builder = Wiring::builder().part("a", first).part("b", second);
        builder
            .connect("A4", "a.sda")
            .connect("A5", "a.scl")
            .connect("A4", "b.sda")
            .connect("A5", "b.scl")
            .build()
    };
    let finder = Kind::RangeFinder(RangeFinder::SRF02);
    assert!(bus(Kind::Compass(Compass), finder).is_ok());
    assert_eq!(bus(finder, finder).unwrap_err().to_string(), "`a` and `b` both have the address 0x70");
}

#[test]
fn the_bus_is_on_a4_and_a5() {
    let builder = Wiring::builder().part("compass", Kind::Compass(Compass)).connect("A5", "compass.sda");
    assert_eq!(error(builder).to_string(), "`compass.sda` is on PC5, and the chip's is on PC4");
}

#[test]
fn an_input_can_be_tied_to_the_supply_and_pwm_needs_no_timer() {
    let builder = Wiring::builder().part("motor", Kind::Bridge(BridgeKind::L298N));
    let wiring =
        builder.connect("4", "motor.in1").connect("7", "motor.in2").connect("VCC", "motor.enable").build();
    assert!(wiring.is_ok());
}
