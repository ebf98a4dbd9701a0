use std::collections::BTreeSet;

use baudbot_brain::Reading;
use proptest::prelude::*;

use super::*;
use crate::estimate::Estimate;
use crate::odometry;
use crate::test_body::{body, turn};
use baudbot_geometry::Pose;

const MS: u64 = 1_000_000;

/// The samples that come over a cable: one a period, each so much later.
#[derive(Clone, Copy, Debug)]
struct Stream {
    period_ms: u64,
    age_ms: u64,
}

impl Stream {
    /// The instants of its samples within so many milliseconds, and when they come.
    fn samples(self, until_ms: u64) -> impl Iterator<Item = (u64, u64)> {
        let samples = (0..until_ms / self.period_ms).map(move |i| i * self.period_ms);
        samples.map(move |sampled_ms| (sampled_ms, sampled_ms + self.age_ms))
    }
}

fn stream() -> impl Strategy<Value = Stream> {
    (10..=500_u64, 0..=2000_u64).prop_map(|(period_ms, age_ms)| Stream { period_ms, age_ms })
}

/// A laser that sweeps for so long, and what takes its scans; and a robot that stands.
struct Bench {
    body: Body,
    scanner: Scanner,
    odometry: Odometry,
}

impl Bench {
    fn new(sweep_ms: u64) -> Self {
        let mut body = body(&[("laser", "laser", 0.0), ("odometer", "odometer", 0.0)]);
        body.sensors[0].sweep = Some(Sweep { duration_ns: sweep_ms * MS, clockwise: false });
        let parameters = odometry::Parameters::of(&body, "odometer").unwrap();
        let start = Estimate::exact(Pose::new(0.0, 0.0, 0.0));
        Self {
            scanner: Scanner::new(&body, "laser", usize::MAX).unwrap(),
            odometry: Odometry::new(parameters, 0, start),
            body,
        }
    }

    /// The instants, in milliseconds, at which the scans began that are taken when these readings come.
    fn step(&mut self, at_ms: u64, laser_ms: Option<u64>, odometer_ms: Option<u64>) -> Vec<u64> {
        let reading = |sampled_ms: u64, values: &[f64]| Reading {
            values: values.to_vec(),
            sampled_at_ns: Some(sampled_ms * MS),
            sequence: 0,
            readable: true,
        };
        let mut turn = turn(&self.body, at_ms * MS, &[None, None]);
        turn.readings = vec![
            laser_ms.map(|ms| reading(ms, &[1.0, 2.0, 3.0])),
            odometer_ms.map(|ms| reading(ms, &[0.0, 0.0, 0.0])),
        ];
        self.odometry.read(&turn, "odometer");
        self.scanner.hear(&turn);
        let sweep_ns = self.body.sensors[0].sweep.unwrap().duration_ns;
        let taken = std::iter::from_fn(|| self.scanner.take(&self.odometry));
        taken.map(|(ended_ns, _)| (ended_ns - sweep_ns) / MS).collect()
    }
}

proptest! {
    /// The odometry's age may be any number of the laser's periods.
    #[test]
    fn each_scan_is_used_as_soon_as_odometry_covers_it(
        laser in stream(),
        odometer in stream(),
        is_lost in proptest::collection::vec(proptest::bool::weighted(0.05), 1000),
    ) {
        let sweep_ms = laser.period_ms.min(67);
        let mut bench = Bench::new(sweep_ms);
        let scans: Vec<_> = laser.samples(6000).map(|(at_ms, come_ms)| (at_ms, come_ms + sweep_ms)).collect();
        // The first reading of an odometer is only its origin.
        let lost = std::iter::once(false).chain(is_lost.iter().copied());
        let heard: Vec<_> =
            odometer.samples(6000).zip(lost).filter(|(_, is_lost)| !is_lost).map(|(sample, _)| sample).collect();
        let steps: BTreeSet<_> = scans.iter().chain(&heard).map(|(_, come_ms)| *come_ms).collect();
        let mut used = Vec::new();
        for step_ms in steps {
            let come = |samples: &[(u64, u64)]| {
                samples.iter().find(|(_, come_ms)| *come_ms == step_ms).map(|(at_ms, _)| *at_ms)
            };
            used.extend(bench.step(step_ms, come(&scans), come(&heard)).into_iter().map(|at_ms| (at_ms, step_ms)));
        }
        let expected: Vec<_> = scans
            .iter()
            .filter_map(|&(at_ms, come_ms)| {
                let (_, covered_ms) = heard.iter().find(|(heard_ms, _)| *heard_ms >= at_ms + sweep_ms)?;
                Some((at_ms, come_ms.max(*covered_ms)))
            })
            .collect();
        // At least one of each so many, is what is promised; and of these none is left out.
        let most = (odometer.age_ms + odometer.period_ms).div_ceil(laser.period_ms) + 1;
        for some in expected.chunks_exact(most as usize) {
            prop_assert!(some.iter().any(|scan| used.contains(scan)), "none of {some:?} in {used:?}");
        }
        prop_assert_eq!(used, expected);
    }
}

#[test]
fn without_odometry_no_more_scans_are_kept_than_are_of_use() {
    let mut bench = Bench::new(10);
    for i in 0..10_000 {
        assert!(bench.step(10 * (i + 1), Some(10 * i), None).is_empty());
    }
    assert_eq!(bench.scanner.waiting.len(), MOST_WAITING);
    // The first reading of an odometer is its pose, the second adds the way since.
    assert_eq!(bench.step(100_000, None, Some(99_999)).len(), 0);
    assert!(!bench.step(100_020, None, Some(100_019)).is_empty(), "those that waited");
    assert_eq!(bench.step(100_030, Some(100_000), None), [100_000], "and then the next");
}

#[test]
fn a_scan_of_before_all_that_is_known_does_not_hold_up_the_next() {
    let mut bench = Bench::new(10);
    bench.odometry = Odometry::new(
        odometry::Parameters::of(&bench.body, "odometer").unwrap(),
        500 * MS,
        Estimate::exact(Pose::new(0.0, 0.0, 0.0)),
    );
    assert!(bench.step(400, Some(300), None).is_empty());
    assert!(bench.step(600, Some(550), None).is_empty());
    assert!(bench.step(610, None, Some(520)).is_empty());
    assert_eq!(bench.step(620, None, Some(600)), [550]);
}

#[test]
fn scans_of_before_an_instant_are_not_of_interest_any_more() {
    let mut bench = Bench::new(10);
    for at_ms in [100, 200, 300] {
        bench.step(at_ms + 20, Some(at_ms), None);
    }
    bench.scanner.forget_before(200 * MS);
    bench.step(330, None, Some(0));
    assert_eq!(bench.step(340, None, Some(330)), [200, 300]);
    bench.step(420, Some(400), None);
    bench.scanner.forget();
    assert!(bench.step(500, None, Some(490)).is_empty());
}
