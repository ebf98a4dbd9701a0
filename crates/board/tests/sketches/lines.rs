//! Arrays of reflectance sensors over a line.

use baudbot_board::{BridgeKind, Builder, Decay, Kind, Led, LitBy, Reflectance, Voltage, Wiring};

use crate::sketches::bench::{US, bench};

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn times_of_discharge_steer_the_motors() {
    let motor = Kind::Bridge(BridgeKind::Directed { decay: Decay::Coast, drop_v: 0.0 });
    let mut wiring = Wiring::builder();
    for sensor in 0..4 {
        let name = format!("s{sensor}");
        wiring =
            wiring.part(name.clone(), Kind::Reflectance(Reflectance)).connect(format!("A{sensor}"), name);
    }
    let wiring = wiring
        .part("left", motor)
        .part("right", motor)
        .connect("5", "left.pwm")
        .connect("4", "left.direction")
        .connect("6", "right.pwm")
        .connect("7", "right.direction");
    let mut bench = bench("line_digital.hex", wiring);
    for dark in 0..4 {
        let awaited: Vec<u64> =
            (0..4).map(|sensor| if sensor == dark { 1800 } else { 310 + 40 * sensor }).collect();
        for (sensor, us) in awaited.iter().enumerate() {
            bench.world.discharge_ns[sensor] = us * US;
        }
        bench.run(200);
        bench.lines();
        bench.run(1000);
        let lines = bench.lines();
        assert!(lines.len() > 60, "{}", lines.len());
        let mut last = 0;
        for (_, line) in &lines {
            let numbers: Vec<u64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            for (&shown, &us) in numbers.iter().zip(&awaited) {
                // The sketch releases the four pins one after the other before it reads its clock, and then reads them
                // in turn.
                assert!((us - 50..us + 40).contains(&shown), "{line} for {awaited:?}");
            }
            let sum: u64 = numbers[..4].iter().sum();
            let weighted: u64 = numbers[..4].iter().zip(0..).map(|(us, place)| 1000 * place * us).sum();
            assert_eq!(numbers[4], weighted / sum);
            last = numbers[4] as i64;
        }
        let turn = (last - 1500) / 20;
        let duty = |value: i64| (value.clamp(0, 255) + 1) as f64 / 256.0;
        let differs = |is: f64, awaited: f64| (is - awaited).abs() > 2.0 / 256.0;
        let duties = bench.duties();
        assert!(!differs(duties[0], duty(150 + turn)) && !differs(duties[1], duty(150 - turn)), "{duties:?}");
    }
    // A sensor over nothing at all never discharges.
    bench.world.discharge_ns = [u64::MAX; 16];
    bench.run(200);
    bench.lines();
    bench.run(500);
    assert!(bench.lines().iter().all(|line| line.1 == "2500 2500 2500 2500 1500"));
    bench.assert_no_warnings();
}

fn analog_array() -> Builder {
    let led = Kind::Led(Led { lit_by: LitBy::High });
    let mut wiring = Wiring::builder();
    for sensor in 0..5 {
        let name = format!("s{sensor}");
        wiring =
            wiring.part(name.clone(), Kind::Voltage(Voltage::DIRECT)).connect(format!("A{sensor}"), name);
    }
    wiring.part("left", led).part("right", led).connect("2", "left").connect("3", "right")
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn voltages_of_an_array_are_a_position() {
    let mut bench = bench("line_analog.hex", analog_array());
    for volts in [
        [0.5, 0.6, 4.2, 0.6, 0.5],
        [4.5, 1.0, 0.5, 0.5, 0.5],
        [0.5, 0.5, 0.5, 2.0, 3.9],
        [0.1, 0.1, 0.1, 0.1, 0.1],
    ] {
        bench.world.volts[..5].copy_from_slice(&volts);
        bench.run(100);
        bench.lines();
        bench.run(1000);
        let values = volts.map(|volts| (((volts / 5.0 * 1024.0) as i64 - 100) * 1000 / 800).clamp(0, 1000));
        let sum: i64 = values.iter().sum();
        let weighted: i64 = values.iter().zip(0..).map(|(value, place)| 1000 * place * value).sum();
        let awaited = if sum == 0 { 0.0 } else { weighted as f32 / sum as f32 - 2000.0 };
        let lines = bench.lines();
        assert!(lines.len() > 40);
        for (_, line) in lines {
            assert!((line.parse::<f32>().unwrap() - awaited).abs() < 0.06, "{line} instead of {awaited}");
        }
        let lit = |is: bool| f64::from(u8::from(is));
        assert_eq!((bench.brightness(0), bench.brightness(1)), (lit(awaited < -100.0), lit(awaited > 100.0)));
    }
    bench.assert_no_warnings();
}
