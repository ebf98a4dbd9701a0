//! Figures of real devices, found by a brain that asks for its readings over its link; and Fig. 8.2 of the notes.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

use baudbot_client::{Action, Brain, Turn};
use baudbot_tests::{InProcess, scenario};

/// A brain that is a function, and what it wrote down.
struct Asks<T, F>(Arc<Mutex<Vec<T>>>, F);

impl<T, F: FnMut(&Turn, &mut Vec<T>) -> Action> Brain for Asks<T, F> {
    fn step(&mut self, turn: &Turn) -> Action {
        (self.1)(turn, &mut self.0.lock().unwrap())
    }
}

/// Runs a scenario of one robot with such a brain, and gives back the world and the notes.
fn ask<T, F>(toml: &str, ticks: u64, brain: F) -> (InProcess, Vec<T>)
where
    T: Send + 'static,
    F: FnMut(&Turn, &mut Vec<T>) -> Action + Send + 'static,
{
    let scenario = baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}\n{toml}"));
    let notes = Arc::new(Mutex::new(Vec::new()));
    let mut local = InProcess::with_brain(scenario, Asks(Arc::clone(&notes), brain));
    local.run(ticks);
    let notes = std::mem::take(&mut *notes.lock().unwrap());
    (local, notes)
}

/// A robot of ARSim's size with one sensor, asked over an ideal link so that times are the sensor's own.
fn with_sensor(top: &str, sensor: &str) -> String {
    format!(
        "{top}\n[[robots]]\nname = \"r\"\nfirmware = {{ mode = \"poll\" }}\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n\
         [robots.sensors.s]\n{sensor}\n"
    )
}

/// A wall whose face is `gap_m` before a sensor on the rim of that robot.
fn wall(gap_m: f64) -> String {
    let x = 0.2 + gap_m;
    format!(
        "[[arena.polygons]]\nname = \"wall\"\npoints_m = [[{x}, -9.0], [{}, -9.0], [{}, 9.0], [{x}, 9.0]]\n",
        x + 1.0,
        x + 1.0
    )
}

#[test]
fn each_sensor_of_a_khepera_is_readable_50_times_a_second() {
    let toml = "substeps = 20\n[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\n\
                firmware = { protocol = \"framed\" }\nlink = { baud = 115200 }\n";
    let (_, readable) = ask(toml, 1000, |turn, readable| {
        readable
            .push((0..8).filter(|i| turn.reading(&format!("ir_{i}")).is_some_and(|r| r.readable)).count());
        Action::poll()
    });
    // Eight sensors, 50 times in each of ten seconds; what the first and the last exchange miss is one round.
    let all: usize = readable.iter().sum();
    assert!((8 * 499..=8 * 500).contains(&all), "{all}");
    assert!(readable.iter().all(|&n| n <= 5), "never more than half of them in one step: {readable:?}");
}

#[test]
fn a_gp2d12_has_a_new_voltage_every_38_ms_and_0_4_v_at_80_cm() {
    let mut voltages = Vec::new();
    let mut periods = Vec::new();
    for seed in 0..200 {
        let top = format!("seed = {seed}\nstep_ms = 1.0\n{}", wall(0.80));
        let sensor = "preset = \"gp2d12\"\nrange_m = 0.81\nperiod_ms = 1.0\nacquisition_us = 0.0\nbits = 32";
        let (_, seen) = ask(&with_sensor(&top, sensor), 1000, |turn, seen| {
            seen.extend(turn.value("s").map(|volts| (turn.at_ns as f64 * 1e-6, volts)));
            Action::poll()
        });
        let changes: Vec<f64> = seen.windows(2).filter(|w| w[0].1 != w[1].1).map(|w| w[1].0).collect();
        let gaps = changes.len() - 2;
        periods.push((changes[gaps + 1] - changes[1]) / gaps as f64);
        voltages.push(seen.iter().rev().take(800).map(|(_, volts)| volts).sum::<f64>() / 800.0);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!((mean(&periods) - 38.3).abs() < 1.0, "{}", mean(&periods));
    assert!(periods.iter().all(|period| (28.6..48.0).contains(period)), "{periods:?}");
    assert!((mean(&voltages) - 0.40).abs() < 0.01, "{}", mean(&voltages));
    let outside = voltages.iter().filter(|volts| !(0.25..=0.55).contains(*volts)).count();
    // The sheet's limits; measured specimens differ a little more, so that these are 2.7 standard deviations.
    assert!(outside <= 6, "{outside} of 200 outside of 0.25 to 0.55 V");
}

/// The largest age, in milliseconds, at which a brain that asks gets a reading of a PING))) at this distance.
fn age_of_an_echo_ms(gap_m: f64) -> f64 {
    let sensor =
        "preset = \"ping\"\nperiod_ms = 30.0\nacquisition_us = 0.0\nrays = 1\nnoise = { additive = 0.0 }";
    let top = format!("noise = false\nstep_ms = 1.0\n{}", wall(gap_m));
    let (_, ages) = ask(&with_sensor(&top, sensor), 300, |turn, ages| {
        let reading = turn.reading("s").filter(|reading| reading.readable);
        ages.extend(reading.and_then(|r| r.age_ns(turn.at_ns)).map(|ns| ns as f64 * 1e-6));
        Action::poll()
    });
    ages.into_iter().fold(0.0, f64::max)
}

#[test]
fn a_ping_answers_after_115_us_to_18_5_ms_of_echo() {
    // The hold-off of 0.75 ms comes before the echo. The wire has ages in tenths of a millisecond, and a brain that
    // asks once a millisecond waits for up to one more.
    let (near, far) = (age_of_an_echo_ms(0.02), age_of_an_echo_ms(5.0));
    assert!((0.75 + 0.115 - 0.1..0.75 + 0.115 + 1.1).contains(&near), "{near}");
    assert!((0.75 + 18.5 - 0.1..0.75 + 18.5 + 1.1).contains(&far), "{far}");
    let scenario = baudbot_scenario::parse(&with_sensor("", "preset = \"ping\"")).unwrap();
    let baudbot_sim::sensor::Device::Sonar(ping) = &scenario.robots[0].sensors[0].device else { panic!() };
    let shortest_us = ping.echo_ns(0.0) / 1000;
    assert!((115..=117).contains(&shortest_us), "{shortest_us}");
    assert_eq!(ping.timeout_ns, 18_500_000);
}

#[test]
fn a_scan_of_a_urg_04lx_is_2137_bytes_and_a_brain_gets_ten_a_second() {
    let (local, scans) = ask(&with_sensor(&wall(1.0), "preset = \"urg-04lx\""), 1000, |turn, scans| {
        scans
            .extend(turn.reading("s").filter(|reading| reading.readable).map(|reading| reading.values.len()));
        Action::poll()
    });
    assert!((98..=100).contains(&scans.len()), "{}", scans.len());
    assert!(scans.iter().all(|&n| n == 682));
    let port = local.world.robot(0).port(0).unwrap();
    let rest = port.bytes - 2137 * port.messages;
    assert!(rest < 2137, "{port:?}");
}

#[test]
fn an_e_puck_drives_12_88_cm_a_second_at_1000_steps() {
    let toml = "[[robots]]\nname = \"e\"\npreset = \"e-puck\"\n";
    let mut asked_ns = None;
    let (local, steps) = ask(toml, 2000, move |turn, steps| {
        let news = turn.reading("steps").filter(|reading| reading.readable);
        let has_news = news.is_some();
        steps.extend(news.map(|reading| (turn.at_ns, reading.values.clone())));
        // Who asks before the answer has come makes commands wait at the robot, ever longer.
        if has_news || asked_ns.is_none_or(|asked_ns| turn.at_ns - asked_ns > 500_000_000) {
            asked_ns = Some(turn.at_ns);
            return Action::drive(1.0, 1.0);
        }
        Action::wait()
    });
    let speed = local.world.robot(0).motion().speed_m_s;
    assert!((speed - 0.1288).abs() < 5e-5, "{speed}");
    // A line through all of them: each message of the radio takes a time of its own.
    let half = steps.iter().skip(steps.len() / 2);
    let half: Vec<_> = half.map(|(at_ns, counts)| [*at_ns as f64 * 1e-9, counts[0]]).collect();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| half.iter().map(of).sum::<f64>() / half.len() as f64;
    let (mean_s, mean_steps) = (mean(&|point| point[0]), mean(&|point| point[1]));
    let shared = mean(&|point| (point[0] - mean_s) * (point[1] - mean_steps));
    let rate = shared / mean(&|point| (point[0] - mean_s).powi(2));
    assert!((rate - 1000.0).abs() < 15.0, "{rate} steps/s by {} readings", half.len());
}

#[test]
fn a_boe_bots_wheels_turn_as_its_servos_table_says() {
    let table = [
        (1300.0, -48.0),
        (1350.0, -47.0),
        (1400.0, -44.0),
        (1420.0, -41.0),
        (1440.0, -34.0),
        (1460.0, -24.0),
        (1480.0, -12.0),
        (1500.0, 0.0),
        (1520.0, 12.0),
        (1540.0, 24.0),
        (1560.0, 34.0),
        (1600.0, 44.0),
        (1700.0, 48.0),
    ];
    for (pulse_us, rpm) in table {
        let signal = (pulse_us - 1500.0) / 200.0;
        let toml = "[[robots]]\nname = \"b\"\npreset = \"boe-bot\"\nmotors = { noise_sigma = 0.0 }\n";
        let (local, _) = ask::<(), _>(toml, 300, move |_, _| Action::drive(signal, signal));
        let motion = local.world.robot(0).motion();
        let found = motion.wheel_speed_rad_s.left * 60.0 / TAU;
        assert!((found - rpm).abs() < 2.0, "{pulse_us} us: {found} instead of {rpm} turns a minute");
    }
}

#[test]
fn a_velocity_regulated_motor_has_the_time_constant_m_by_2ak() {
    // A is 1/r = 10, M 3 kg and K 1.5: 0.1 s. The brain commands at once and then reads its encoders.
    let toml = "step_ms = 1.0\n[[robots]]\nname = \"v\"\nfirmware = { mode = \"poll\" }\n\
                body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n\
                motors = { kind = \"velocity\", gain_n_s = 1.5, full_speed_m_s = 0.5 }\n\
                link = { kind = \"uart\", baud = 1000000 }\n\
                [robots.sensors.s]\nkind = \"encoders\"\ncounts_per_turn = 100000\nbits = 32\nperiod_ms = 1.0\n";
    let (_, seen) = ask(toml, 1000, |turn, seen| {
        seen.extend(turn.reading("s").map(|reading| (turn.at_ns as f64 * 1e-9, reading.values[0])));
        Action::drive(1.0, 1.0)
    });
    let metres_per_count = TAU * 0.1 / 100_000.0;
    let speed =
        |from: usize, to: usize| metres_per_count * (seen[to].1 - seen[from].1) / (seen[to].0 - seen[from].0);
    let final_speed = speed(seen.len() - 100, seen.len() - 1);
    assert!((final_speed - 0.5).abs() < 1e-3, "{final_speed}");
    let near = |t: f64| seen.iter().position(|(at, _)| *at >= t).unwrap();
    // Between 50 and 150 ms the missing speed falls by e; a mean over 10 ms stands for the middle of it.
    let missing = |t: f64| final_speed - speed(near(t - 0.005), near(t + 0.005));
    let time_constant = 0.1 / (missing(0.05) / missing(0.15)).ln();
    assert!((time_constant - 0.1).abs() < 0.005, "{time_constant}");
}

#[test]
fn a_photoresistor_in_the_dark_blocks_a_bs2_for_131_ms() {
    let toml = |lamp: &str| {
        format!(
            "substeps = 10\n{lamp}[[robots]]\nname = \"b\"\nlink = {{ kind = \"onboard\" }}\nmicrocontroller = {{ preset = \"bs2\" }}\n\
             firmware = {{ mode = \"stream\", period_ms = 20.0 }}\n\
             body = {{ radius_m = 0.06, mass_kg = 0.5, inertia_kg_m2 = 0.001, wheel_radius_m = 0.033 }}\n\
             [robots.sensors.eye]\npreset = \"photoresistor\"\nperiod_ms = 20.0\n\
             [robots.sensors.whisker]\npreset = \"whisker\"\nmount = {{ x_m = 0.06 }}\nperiod_ms = 20.0\n"
        )
    };
    let reads = |toml: &str| {
        let (local, eyes) = ask(toml, 1000, |turn, eyes| {
            eyes.extend(turn.value("eye"));
            Action::wait()
        });
        let samples: Vec<u64> = local.world.robot(0).sensors().map(|sensor| sensor.samples).collect();
        ([samples[0], samples[1]], eyes[eyes.len() - 1])
    };
    let ([eye, whisker], small) = reads(&toml("arena.ambient_lux = 1000.0\n"));
    assert!(
        (499..=500).contains(&eye) && eye == whisker,
        "in the light both every 20 ms: {eye}, {whisker} times"
    );
    assert!(small > 0.0 && small < 20.0, "{small}");
    let ([eye, whisker], none) = reads(&toml("arena.ambient_lux = 0.0\n"));
    assert_eq!(none, 0.0, "the count overflowed");
    assert!((76..=77).contains(&eye), "in 10 s there are 76 times 131.07 ms: {eye}");
    assert!((37..=77).contains(&whisker), "between two of them, or after each other one: {whisker}");
}

/// The utility of waiting before the signal is lost at 5 s, its depth, the number of steps for which it falls, and
/// the distance that the robot drives meanwhile.
fn dip(brain: &str) -> (f64, f64, usize, f64) {
    const PATIENT: &str = include_str!("../../catalogue/scenarios/patient.toml");
    let mut local = InProcess::new(scenario(PATIENT, &["noise=false"]), brain).unwrap();
    let mut course = Vec::new();
    let at_m = |local: &InProcess| local.world.robot(0).motion().pose.position.x;
    let mut from_m = 0.0;
    for tick in 0..700 {
        if tick == 495 {
            from_m = at_m(&local);
        }
        local.tick(|_| {});
        let belief = local.belief(0).unwrap();
        let wait = belief.utilities.iter().find(|utility| utility.name == "wait").unwrap();
        course.push(wait.value);
    }
    let before = course[495];
    let fell = course[495..].windows(2).filter(|local| local[1] < local[0] - 1e-9).count();
    let least = course[495..].iter().copied().fold(f64::INFINITY, f64::min);
    (before, before - least, fell, at_m(&local) - from_m)
}

/// Fig. 8.2 with a robot and a door.
#[test]
fn a_signal_that_is_lost_for_150_ms_makes_a_small_dip_in_a_utility() {
    // tanh(1 + 0.5 z) with z = 1, and tanh(1) below it; 15 of Euler's steps with a time constant of 0.3 s.
    let (before, filtered, steps, drove_m) = dip("patient");
    assert!((before - 0.905148).abs() < 1e-6, "{before}");
    assert!((filtered - 0.057223).abs() < 1e-6, "{filtered}");
    assert_eq!((steps, drove_m < 1e-6), (15, true), "{drove_m}");
    // The robot starts into the door without the filter.
    let (before, unfiltered, _, drove_m) = dip("patient:motor.wait.utility.tau_s=0.01");
    assert!((before - 0.905148).abs() < 1e-6 && drove_m > 0.01, "{before} {drove_m}");
    assert!((unfiltered - 0.143554).abs() < 1e-6, "{unfiltered}");
    assert!((filtered / unfiltered - 0.3986).abs() < 1e-4, "{}", filtered / unfiltered);
}

#[test]
fn who_waits_before_a_door_drives_through_it_once_it_is_open() {
    let mut local =
        InProcess::new(scenario(include_str!("../../catalogue/scenarios/patient.toml"), &[]), "patient")
            .unwrap();
    local.run(850);
    let at = |local: &InProcess| local.world.robot(0).motion().pose.position;
    assert!(at(&local).x < 0.9, "it waits: {}", at(&local));
    local.run(350);
    assert!(at(&local).x > 1.2, "it is through: {}", at(&local));
    assert!(!local.world.robot(0).collided() && local.world.robot(0).counters().collisions == 0);
}
