//! Tones and duties.

use baudbot_board::{BridgeKind, Decay, Kind, Piezo, Wiring};

use crate::sketches::bench::bench;

const MOTOR: Kind = Kind::Bridge(BridgeKind::Directed { decay: Decay::Brake, drop_v: 0.0 });

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn tones_have_the_frequencies_that_timer_2_can_make() {
    let mut bench =
        bench("tones.hex", Wiring::builder().part("piezo", Kind::Piezo(Piezo)).connect("8", "piezo"));
    let mut heard = Vec::new();
    for _ in 0..2500 {
        bench.run(1);
        heard.push(bench.board.tones().next().unwrap().hz);
    }
    let start = heard.iter().position(Option::is_some).unwrap();
    // Toggled after so many periods of the clock: by the prescaler and the compare register that `tone` chooses.
    let half_periods = [1024 * 252, 128 * 238, 128 * 142, 32 * 250, 8 * 250, 8 * 50, 64 * 239];
    for (note, half) in half_periods.into_iter().enumerate() {
        let from = start + 250 * note + 70;
        let mut hz: Vec<f64> = heard[from..from + 100].iter().map(|hz| hz.unwrap()).collect();
        hz.sort_by(f64::total_cmp);
        let awaited = 16e6 / (2.0 * f64::from(half));
        // An interrupt waits for the end of an instruction, and for other interrupts.
        let of_a_cycle = awaited / f64::from(2 * half);
        assert!((hz[50] - awaited).abs() <= 4.0 * of_a_cycle, "{} instead of {awaited}", hz[50]);
        assert!(hz[0] > 0.7 * awaited && hz[99] < 1.5 * awaited, "{hz:?}");
    }
    // `noTone` after 300 ms, and 50 ms later it counts as silent.
    let end = start + 250 * 6 + 300;
    assert!(heard[end - 2].is_some() && heard[end + 53..].iter().all(Option::is_none));
    bench.assert_no_warnings();
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn all_six_outputs_have_the_duties_of_analog_write() {
    let mut wiring = Wiring::builder();
    for pin in ["3", "5", "6", "9", "10", "11"] {
        let name = format!("motor{pin}");
        wiring = wiring
            .part(name.clone(), MOTOR)
            .connect(pin, format!("{name}.pwm"))
            .connect("VCC", format!("{name}.direction"));
    }
    let mut bench = bench("pwm.hex", wiring);
    // Timer 0 counts to 255 and starts at 0: 256 counts, one more than asked for is high. The others go up and down: 510
    // counts, twice what was asked for.
    let fast = |value: f64| (value + 1.0) / 256.0;
    let both_ways = |value: f64| value / 255.0;
    bench.run(500);
    let awaited =
        [both_ways(10.0), fast(63.0), fast(191.0), both_ways(85.0), both_ways(200.0), both_ways(254.0)];
    for _ in 0..500 {
        bench.run(1);
        assert_eq!(bench.duties(), awaited);
    }
    bench.run(500);
    let awaited = [0.0, 1.0, 0.0, 1.0, both_ways(1.0), both_ways(128.0)];
    for _ in 0..500 {
        bench.run(1);
        assert_eq!(bench.duties(), awaited);
    }
    bench.assert_no_warnings();
}
