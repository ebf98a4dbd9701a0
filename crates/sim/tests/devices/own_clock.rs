//! Devices that measure at their own pace.

use baudbot_sim::World;

use crate::common::statistics::{kolmogorov_smirnov, uniform};
use crate::common::{run, world};
use crate::devices::scene::{block, named, near, scene, singles, view, wall, with_sensor};

/// A GP2D12 whose noise shows each new measurement, read each millisecond.
const SHARP: &str = "kind = \"ir-voltage\"\nbearing_rad = 0.0\nopening_rad = 0.08\nrays = 1\nrange_m = 0.8\n\
                     curve_m_v = [[0.1, 2.3], [0.8, 0.4]]\nidle_v = 0.3\nsupply_v = 5.0\nnoise = { additive = 0.01 }\n\
                     clock = { period_ms = 38.3, spread_ms = 9.6 }";

fn sharp(seed: u32) -> String {
    with_sensor(&format!("seed = {seed}\nstep_ms = 1.0\n{}", wall(0.5)), SHARP)
}

/// The ticks at which a new value is there.
fn changes(values: &[f64]) -> Vec<usize> {
    (1..values.len()).filter(|&i| values[i] != values[i - 1]).collect()
}

#[test]
fn specimens_of_a_gp2d12_differ_in_period_and_phase() {
    let (mut periods, mut phases) = (Vec::new(), Vec::new());
    for seed in 0..500 {
        let values = singles(&sharp(seed), 600);
        let changes = changes(&values);
        let period = (changes[changes.len() - 1] - changes[0]) as f64 / (changes.len() - 1) as f64;
        periods.push(period);
        // The first millisecond whose read finds the first value comes half a one late in the mean.
        let first = values.iter().position(|&value| value != 0.0).unwrap();
        phases.push(((first as f64 - 0.5) / period).clamp(0.0, 1.0));
    }
    let outcome = kolmogorov_smirnov(&mut periods, uniform(38.3 - 9.6, 38.3 + 9.6));
    assert!(outcome.fits(), "periods: {outcome:?}");
    let outcome = kolmogorov_smirnov(&mut phases, uniform(0.0, 1.0));
    assert!(outcome.fits(), "phases: {outcome:?}");
}

#[test]
fn a_specimen_keeps_its_period() {
    let values = singles(&sharp(5), 4000);
    let changes = changes(&values);
    let gaps: Vec<_> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
    assert!(most - least <= 1, "{gaps:?}");
}

#[test]
fn before_its_first_measurement_a_device_reads_0_and_then_holds_each_value() {
    let sensor = SHARP.replace("spread_ms = 9.6", "phase_ms = 7.0, latency_ms = 5.0");
    let values = singles(&with_sensor(&format!("step_ms = 1.0\n{}", wall(0.5)), &sensor), 200);
    assert!(values[..12].iter().all(|&value| value == 0.0), "{values:?}");
    assert!(values[12] > 1.0);
    // 12, 50.3, 88.6, 126.9, 165.2 ms.
    assert_eq!(changes(&values), [12, 51, 89, 127, 166]);
}

#[test]
fn the_truth_knows_how_old_a_held_value_is() {
    let sensor = SHARP.replace("38.3, spread_ms = 9.6", "40.0, phase_ms = 0.0");
    let mut world = world(&scene(&format!("step_ms = 1.0\n{}", wall(0.5)), "", &named("s", &sensor)));
    run(&mut world, 400, 0.0, 0.0);
    let freshness = view(&world, "s").freshness;
    assert_eq!((freshness.readable, freshness.ages.count()), (400, 400));
    assert_eq!(freshness.ages.max_ns().unwrap(), 39_000_000);
    assert_eq!(freshness.ages.sum_ns() / 400, 19_500_000);
}

/// A receiver on an ideal cable of its own: the truth has the instants of its measurements to the nanosecond.
fn instants(clock: &str, ticks: usize) -> Vec<u64> {
    let sensor = format!(
        "kind = \"gps\"\nport = {{ link = {{ kind = \"ideal\" }}, sentences = \"rmc\" }}\nclock = {{ {clock} }}"
    );
    let mut world = world(&with_sensor("step_ms = 1.0", &sensor));
    let mut instants: Vec<u64> = Vec::new();
    for _ in 0..ticks {
        world.begin();
        world.finish(&[]);
        let seen = view(&world, "s");
        if seen.samples as usize > instants.len() {
            instants.push(seen.sampled_at.as_ns());
        }
    }
    instants
}

#[test]
fn jitter_is_uniform_and_does_not_add_up() {
    let mut late: Vec<_> = instants("period_ms = 2.0, phase_ms = 0.0, jitter_ms = 1.0", 20_000)
        .iter()
        .enumerate()
        .skip(1)
        .map(|(i, &at)| at as f64 * 1e-6 - 2.0 * i as f64)
        .collect();
    assert!(late.len() > 9_900);
    let outcome = kolmogorov_smirnov(&mut late, uniform(0.0, 1.0));
    assert!(outcome.fits(), "{outcome:?}");
}

#[test]
fn without_jitter_a_clock_is_exact_for_ever() {
    let instants = instants("period_ms = 7.3, phase_ms = 1.7", 8000);
    assert!(instants.len() > 1000);
    assert!(
        instants.iter().enumerate().all(|(i, &at)| at == 1_700_000 + 7_300_000 * i as u64),
        "{instants:?}"
    );
}

/// The poses of the robot at each tick, and the scans that it took meanwhile.
struct Trace {
    world: World,
    ticks: Vec<[f64; 5]>,
}

/// Rays of a scan that starts at 5 ms and takes 80 ms, over ticks of 10 ms.
fn bent_scan(more: &str) -> Trace {
    let laser = format!(
        "kind = \"laser\"\nmount = {{}}\nopening_rad = 2.0\nrays = 41\nrange_m = 10.0\nsweep_ms = 80.0\nbits = 32\n\
         clock = {{ period_ms = 200.0, phase_ms = 5.0 }}\n{more}"
    );
    let start = "start = { speed_m_s = 0.4, turn_rate_rad_s = 2.0 }";
    let walls = block("wall", [3.0, 0.0, 3.1, 60.0], "") + &block("far", [4.0, -60.0, 4.1, 90.0], "");
    let mut world = world(&scene(&walls, start, &named("s", &laser)));
    let mut ticks = Vec::new();
    for i in 0..15 {
        world.begin();
        let motion = world.robot(0).motion();
        let position = motion.pose.position;
        ticks.push([position.x, position.y, motion.pose.heading, motion.speed_m_s, motion.turn_rate_rad_s]);
        crate::common::tick(&mut world, -0.1, if i < 5 { 0.3 } else { 0.1 });
    }
    Trace { world, ticks }
}

/// The distance of the two walls from the robot `at_s`, looking `kappa` to the left.
fn expected(ticks: &[[f64; 5]], at_s: f64, kappa: f64) -> f64 {
    let tick = (at_s / 0.01 + 1e-9) as usize;
    let [x, y, heading, speed, rate] = ticks[tick];
    let dt = at_s - 0.01 * tick as f64;
    let heading = heading + rate * dt;
    let (x, y) = (x + speed * dt * heading.cos(), y + speed * dt * heading.sin());
    let direction = heading + kappa;
    let near = (3.0 - x) / direction.cos();
    let height = y + near * direction.sin();
    if height >= 0.0 { near } else { (4.0 - x) / direction.cos() }
}

#[test]
fn the_rays_of_a_scan_are_taken_while_the_robot_turns() {
    for clockwise in [false, true] {
        let trace = bent_scan(&format!("clockwise = {clockwise}"));
        let scan = view(&trace.world, "s").sample;
        let mut corner = None;
        for (i, &found) in scan.iter().enumerate() {
            let kappa = -1.0 + 0.05 * if clockwise { 40 - i } else { i } as f64;
            near(found, expected(&trace.ticks, 0.005 + 0.002 * i as f64, kappa));
            if i > 0 && kappa.abs() < 0.5 && (found - scan[i - 1]).abs() > 0.8 {
                corner = Some((i, kappa));
            }
        }
        // A scan taken at once would see the corner straight ahead of where the robot looked first.
        let (i, kappa) = corner.expect("a corner");
        assert!(kappa < -0.04, "the corner is at ray {i}, {kappa} rad");
    }
}

#[test]
fn a_scan_is_there_when_its_last_ray_is() {
    let laser = "kind = \"laser\"\nmount = {}\nopening_rad = 2.0\nrays = 3\nrange_m = 10.0\nsweep_ms = 80.0\nperiod_ms = 10.0\n\
                 clock = { period_ms = 200.0, phase_ms = 5.0, latency_ms = 10.0 }";
    let readings = singles(&with_sensor(&wall(2.0), laser), 30);
    let first = readings.iter().position(|&d| d != -1.0).unwrap();
    // 5 + 80 + 10 = 95 ms: the read at 100 ms finds it.
    assert_eq!(first, 10, "{readings:?}");
}
