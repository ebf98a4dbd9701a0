//! Closed loops over motors and encoders.

use core::f64::consts::TAU;

use baudbot_board::{BridgeKind, Channels, Encoder, Kind, Wiring};

use crate::sketches::bench::bench;

/// The speed of a motor without load at full duty, in radians per second, and how fast it gets there.
const FULL_RAD_S: f64 = 12.0 * TAU;
const TIME_CONSTANT_S: f64 = 0.08;

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn two_wheels_hold_their_speeds_at_two_kinds_of_bridges() {
    let encoder = Kind::Encoder(Encoder { channels: Channels::Single, counts_per_turn: 40 });
    let wiring = Wiring::builder()
        .part("left", Kind::Bridge(BridgeKind::L298N))
        .part("right", Kind::Bridge(BridgeKind::TB6612))
        .part("left_encoder", encoder)
        .part("right_encoder", encoder)
        .connect("7", "left.in1")
        .connect("8", "left.in2")
        .connect("9", "left.enable")
        .connect("12", "right.in1")
        .connect("13", "right.in2")
        .connect("10", "right.pwm")
        .connect("VCC", "right.standby")
        .connect("2", "left_encoder")
        .connect("3", "right_encoder");
    let mut bench = bench("pid.hex", wiring);
    for _ in 0..10_500 {
        bench.run(1);
        for (wheel, duty) in bench.duties().into_iter().enumerate() {
            let rate = &mut bench.world.wheels[2 + wheel].rate_rad_s;
            *rate += (duty * FULL_RAD_S - *rate) * 0.001 / TIME_CONSTANT_S;
        }
    }
    let lines: Vec<[i64; 2]> = bench
        .lines()
        .into_iter()
        .map(|(_, line)| {
            let (left, right) = line.split_once(' ').unwrap();
            [left.parse().unwrap(), right.parse().unwrap()]
        })
        .collect();
    assert!(lines.len() >= 10, "{lines:?}");
    for two in lines[4..].windows(2) {
        assert!((two[1][0] - two[0][0] - 200).abs() <= 2, "{lines:?}");
        assert!((two[1][1] - two[0][1] - 120).abs() <= 2, "{lines:?}");
    }
    let duties = bench.duties();
    // 200 and -120 edges a second are 5 and -3 turns of 12.
    assert!((duties[0] - 5.0 / 12.0).abs() < 0.06 && (duties[1] + 3.0 / 12.0).abs() < 0.06, "{duties:?}");
    bench.assert_no_warnings();
}
