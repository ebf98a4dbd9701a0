//! The processor time of a step of each brain, in the runs for which it is made: `cargo bench -p baudbot-tests
//! --bench brain_steps`.
//!
//! Each brain drives through its scenario for two simulated minutes, or for as many as are given behind `--`. What counts is the
//! time that the processor spends on a step, so that a machine may do other things, too. A step that only waits is counted as
//! well; so the table has the mean, what 99 of 100 and 999 of 1000 steps do not exceed, and the longest. Laser matches and plans
//! are rare: they are among the last two. Where a brain does both, there is a second line without the matches.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use baudbot_brains::catalogue;
use baudbot_client::{Action, Brain, SensorKind, Turn};
use baudbot_tests::{InProcess, scenario};
use rustix::time::{ClockId, clock_gettime};

const COURSES: &[(&str, &str)] = &[
    ("avoid", include_str!("../../catalogue/scenarios/wander.toml")),
    ("wander", include_str!("../../catalogue/scenarios/wander.toml")),
    ("constant", include_str!("../../catalogue/scenarios/wander.toml")),
    ("ant", include_str!("../../catalogue/scenarios/ant.toml")),
    ("ecoli", include_str!("../../catalogue/scenarios/ecoli-one.toml")),
    ("errands", include_str!("../../catalogue/scenarios/errands.toml")),
    (
        "errands:cognitive.localization.utility.bias=-1",
        include_str!("../../catalogue/scenarios/errands.toml"),
    ),
    ("explore", include_str!("../../catalogue/scenarios/explore-office.toml")),
    ("explore:method=1", include_str!("../../catalogue/scenarios/explore-office.toml")),
    ("explore:slam=1", include_str!("../../catalogue/scenarios/explore-office.toml")),
    ("forager", include_str!("../../catalogue/scenarios/forager.toml")),
    ("hall", include_str!("../../catalogue/scenarios/hall.toml")),
    ("larva", include_str!("../../catalogue/scenarios/ecoli-one.toml")),
    ("mower", include_str!("../../catalogue/scenarios/mower.toml")),
    ("mower:cognitive.localization.utility.bias=-1", include_str!("../../catalogue/scenarios/mower.toml")),
    ("navigate", include_str!("../../catalogue/scenarios/arsim.toml")),
    ("patient", include_str!("../../catalogue/scenarios/patient.toml")),
    ("stentor", include_str!("../../catalogue/scenarios/stentor.toml")),
    ("sweeper", include_str!("../../catalogue/scenarios/sweeper.toml")),
    ("tour", include_str!("../../catalogue/scenarios/tour.toml")),
    ("wedge", include_str!("../../catalogue/scenarios/wedge.toml")),
    ("woodlouse", include_str!("../../catalogue/scenarios/ecoli-one.toml")),
];

/// A brain whose steps are timed.
struct Timed {
    brain: Box<dyn Brain + Send>,
    took: Arc<Mutex<Vec<Duration>>>,
}

impl Brain for Timed {
    fn step(&mut self, turn: &Turn) -> Action {
        let start = processor_time();
        let action = self.brain.step(turn);
        self.took.lock().unwrap().push(processor_time() - start);
        action
    }
}

/// Time that the processor has spent on this thread.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

fn main() {
    let minutes = std::env::args().skip(1).find_map(|text| text.parse::<f64>().ok()).unwrap_or(2.0);
    println!(
        "{:<47} {:>5} {:>8} {:>10} {:>10} {:>10} {:>10}",
        "brain", "rays", "steps", "mean", "99 %", "99.9 %", "longest"
    );
    for (name, toml) in COURSES {
        let scenario = scenario(toml, &[]);
        let body = baudbot_client::Body::from(&scenario.robots[0]);
        let rays = body
            .sensors
            .iter()
            .filter(|sensor| sensor.kind == SensorKind::Laser)
            .map(|laser| laser.values())
            .max();
        let took = Arc::new(Mutex::new(Vec::new()));
        let brain = catalogue::brain(name, 1, &body).unwrap_or_else(|error| panic!("{name}: {error}"));
        let ticks = (minutes * 60.0 / (scenario.step_ns as f64 / 1e9)) as u64;
        let mut local = InProcess::with_brain(scenario, Timed { brain, took: Arc::clone(&took) });
        local.run(ticks);
        let mut took = took.lock().unwrap().clone();
        took.sort_unstable();
        let mean = took.iter().sum::<Duration>() / took.len().max(1) as u32;
        let of = |share: f64| took.get(((took.len() as f64 * share) as usize).min(took.len() - 1));
        let words =
            |time: Option<&Duration>| format!("{:.1} µs", time.map_or(0.0, |t| t.as_secs_f64() * 1e6));
        println!(
            "{name:<47} {:>5} {:>8} {:>10} {:>10} {:>10} {:>10}",
            rays.unwrap_or(0),
            took.len(),
            words(Some(&mean)),
            words(of(0.99)),
            words(of(0.999)),
            words(took.last())
        );
    }
}
