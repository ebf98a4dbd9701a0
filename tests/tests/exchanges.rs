//! Each brain of the catalogue on all cables: it answers messages as often as `baudbot budget` computes, never less
//! often on a faster cable, and drives as far.

use baudbot_brains::catalogue::catalogue;
use baudbot_scenario::budget::RobotBudget;
use baudbot_sim::Scenario;
use baudbot_tests::{InProcess, scenario};

/// A brain where it is at home.
#[derive(Clone, Copy)]
pub(crate) struct Home {
    pub(crate) brain: &'static str,
    pub(crate) toml: &'static str,
    /// The robot drives on, without a goal at which it stops: the distance counts, too.
    drives_on: bool,
}

macro_rules! home {
    ($brain:literal, $scenario:literal, $drives_on:literal) => {
        Home {
            brain: $brain,
            toml: include_str!(concat!("../../catalogue/scenarios/", $scenario, ".toml")),
            drives_on: $drives_on,
        }
    };
}

pub(crate) const HOMES: &[Home] = &[
    home!("ant", "ant", false),
    home!("avoid", "wander", true),
    home!("constant", "wander", false),
    home!("ecoli", "ecoli-one", true),
    home!("errands", "errands", false),
    home!("explore", "explore-room", false),
    home!("forager", "forager", false),
    home!("four-pillars", "four-pillars", false),
    home!("goose", "nest", false),
    home!("hall", "hall", false),
    home!("lantern", "lantern", true),
    home!("larva", "ecoli-one", true),
    home!("lobby", "lobby", false),
    home!("mower", "mower", false),
    home!("navigate", "arsim", false),
    home!("patient", "patient", false),
    home!("pillar", "pillar", false),
    home!("scratcher", "scratch", false),
    home!("stentor", "stentor", false),
    home!("stickleback", "stickleback", false),
    home!("sweeper", "sweeper", true),
    home!("tour", "tour", false),
    home!("wander", "wander", false),
    home!("waterhole", "waterhole", false),
    home!("wedge", "wedge", false),
    // The woodlouse's distance depends on the place where it finds the damp.
    home!("woodlouse", "ecoli-one", false),
];

/// Brains of the catalogue without a home, each with the reason.
const LEFT_OUT: &[(&str, &str)] = &[
    ("bat", "its robots have different brains, and different bodies"),
    ("moth", "its robots have different brains, and different bodies"),
    ("trail-ant", "its colony drives as far as its crowds let it"),
    ("xanthus", "its robots have different brains, and different bodies"),
];

/// The part of the foretold exchanges that is reached, if it is less than nine tenths.
const FEWER: &[(&str, Mode, &str, f64)] = &[
    // The larva swings its head all the time, and the times of a radio's messages hide when its commands are in their
    // way.
    ("larva", Mode::Streamed, "radio", 0.85),
    // The sweeper's messages are the longest, so the most are damaged, and each costs the time until the answer is
    // overdue.
    ("sweeper", Mode::Polled, "radio", 0.85),
];

/// The cables from the slowest to the fastest.
const LADDER: [(&str, &str); 6] = [
    ("1200", "kind = \"uart\", baud = 1200"),
    ("4800", "kind = \"uart\", baud = 4800"),
    ("9600", "kind = \"uart\", baud = 9600"),
    ("19200", "kind = \"uart\", baud = 19200"),
    ("115200", "kind = \"uart\", baud = 115200"),
    ("ideal", "kind = \"ideal\""),
];

/// Cables that are neither slower nor faster than those.
const OTHERS: [(&str, &str); 4] = [
    ("USB 1 ms", "kind = \"uart\", baud = 115200, adapter = { kind = \"ftdi\", latency_ms = 1 }"),
    ("USB 16 ms", "kind = \"uart\", baud = 115200, adapter = { kind = \"ftdi\", latency_ms = 16 }"),
    ("half duplex", "kind = \"uart\", baud = 19200, half_duplex = true"),
    (
        "radio",
        "kind = \"uart\", baud = 57600, byte_error_rate = 0.001, adapter = { kind = \"bluetooth\", latency_ms = 20, spread_ms = 5 }",
    ),
];

/// The time from which on exchanges are counted, in seconds: on the slowest cable the first takes half a second.
const BEGUN_S: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Polled,
    Streamed,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Run {
    exchanges_per_s: f64,
    distance_m: f64,
    foretold_per_s: f64,
    /// A sensor has a cable of its own.
    has_ports: bool,
    /// The robot's receiver was full.
    overran: bool,
}

impl Home {
    fn on(&self, mode: Mode, link: &str, seed: u64) -> Scenario {
        let robot = scenario(self.toml, &[]).robots[0].name.clone();
        let base = scenario(self.toml, &[]);
        let period_ms = match base.robots[0].firmware.mode {
            baudbot_sim::firmware::Mode::Stream(schedule) => schedule.period_ns() as f64 * 1e-6,
            baudbot_sim::firmware::Mode::Poll => 20.0,
        };
        let how = match mode {
            Mode::Polled => "mode = \"poll\"".to_owned(),
            Mode::Streamed => format!("mode = \"stream\", period_ms = {period_ms:?}"),
        };
        let firmware = format!("robots.{robot}.firmware={{ protocol = \"framed\", {how} }}");
        let link = format!("robots.{robot}.link={{ {link} }}");
        scenario(self.toml, &[&firmware, &link, &format!("seed={seed}")])
    }

    fn run(&self, mode: Mode, link: &str, seed: u64, seconds: f64) -> Run {
        let scenario = self.on(mode, link, seed);
        let budget = RobotBudget::without_remedies(&scenario, &scenario.robots[0]);
        let ticks = |seconds: f64| (seconds * 1e9 / scenario.step_ns as f64) as u64;
        let (begun, ticks) = (ticks(BEGUN_S), ticks(seconds));
        let mut local = InProcess::new(scenario, self.brain).unwrap();
        local.world.keep_timeline(0);
        let mut state = || {
            let (cycles, ns) = (local.world.robot(0).cycles().durations.count(), local.world.time().as_ns());
            local.run(if ns == 0 { begun } else { ticks });
            (cycles, ns)
        };
        let (_, (before, before_ns)) = (state(), state());
        let robot = local.world.robot(0);
        let ran_s = (local.world.time().as_ns() - before_ns) as f64 * 1e-9;
        Run {
            exchanges_per_s: (robot.cycles().durations.count() - before) as f64 / ran_s,
            distance_m: robot.counters().distance_m,
            has_ports: robot.spec().sensors.iter().any(|sensor| sensor.port.is_some()),
            overran: robot.downlink().overrun_bytes > 0,
            foretold_per_s: budget.rates[0].typical_per_s.unwrap_or_default(),
        }
    }

    /// The median of runs with these seeds, by exchanges and by distance.
    fn median(&self, mode: Mode, link: &str, seeds: u64, seconds: f64) -> Run {
        let runs: Vec<_> = (1..=seeds).map(|seed| self.run(mode, link, seed, seconds)).collect();
        let middle = |value: fn(&Run) -> f64| {
            let mut values: Vec<_> = runs.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        Run {
            exchanges_per_s: middle(|run| run.exchanges_per_s),
            distance_m: middle(|run| run.distance_m),
            ..runs[0]
        }
    }
}

#[test]
fn each_brain_of_the_catalogue_has_a_home_or_a_reason() {
    let mut known: Vec<_> = HOMES.iter().map(|home| home.brain).collect();
    known.extend(LEFT_OUT.iter().map(|(brain, _)| *brain));
    known.sort_unstable();
    let all: Vec<_> = catalogue().iter().map(|entry| entry.name).collect();
    assert_eq!(known, all);
}

/// The faults of these runs, which are in the order of their cables.
fn faults(home: &Home, mode: Mode, runs: &[(&str, Run)], is_ladder: bool) -> Vec<String> {
    let mut faults = Vec::new();
    for (cable, run) in runs {
        let share = run.exchanges_per_s / run.foretold_per_s;
        // The budget's brain answers each message of a sensor's own cable with a command, too, which is another question for a polled
        // firmware, and brings what a radio has put together. Ours do not. Nor does the budget know how many commands are lost by a
        // microcontroller that takes none while it sends.
        let is_foretold = !(run.overran || (run.has_ports && (mode == Mode::Polled || *cable == "radio")));
        let is_fewer =
            |&&(brain, when, on, _): &&(_, _, _, _)| (brain, when, on) == (home.brain, mode, *cable);
        let least = FEWER.iter().find(is_fewer).map_or(0.9, |fewer| fewer.3);
        if share.is_nan() || share > 1.1 || (share < least && is_foretold) {
            faults.push(format!("{} {mode:?} {cable}: {share:.3} of what is foretold: {run:?}", home.brain));
        }
    }
    for [(_, slow), (cable, fast)] in runs.array_windows().filter(|_| is_ladder) {
        if fast.exchanges_per_s < 0.99 * slow.exchanges_per_s {
            faults.push(format!(
                "{} {mode:?} {cable}: less often than on a slower cable: {fast:?}, {slow:?}",
                home.brain
            ));
        }
        if home.drives_on && fast.distance_m < 0.9 * slow.distance_m {
            faults.push(format!(
                "{} {mode:?} {cable}: less far than on a slower cable: {fast:?}, {slow:?}",
                home.brain
            ));
        }
    }
    faults
}

/// Runs of a few seconds with each brain on a slow cable and two fast ones; that each drives as far is in the test
/// below.
#[test]
fn each_brain_answers_as_often_as_its_budget_foretells() {
    let mut all = Vec::new();
    for home in HOMES {
        for mode in [Mode::Streamed, Mode::Polled] {
            let runs = [1, 2, 4].map(|i| (LADDER[i].0, home.run(mode, LADDER[i].1, 1, 4.0)));
            let home = Home { drives_on: false, ..*home };
            all.extend(faults(&home, mode, &runs, true));
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn the_default_brain_drives_no_less_far_on_a_faster_cable_that_is_polled() {
    let home = HOMES.iter().find(|home| home.brain == "avoid").unwrap();
    let runs = [2, 3, 4, 5].map(|i| (LADDER[i].0, home.median(Mode::Polled, LADDER[i].1, 9, 60.0)));
    let found = faults(home, Mode::Polled, &runs, true);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// All brains on all cables: `cargo test --release -p baudbot-tests --test system -- --ignored --nocapture
/// all_brains_on_all_cables`; `ONLY=avoid,wander` are some of them.
#[test]
#[ignore = "thousands of runs; the sharpest ones always"]
fn all_brains_on_all_cables() {
    let only = std::env::var("ONLY").unwrap_or_default();
    let mut all = Vec::new();
    for home in HOMES.iter().filter(|home| only.is_empty() || only.split(',').any(|name| name == home.brain))
    {
        for mode in [Mode::Streamed, Mode::Polled] {
            for (cables, is_ladder) in [(&LADDER[..], true), (&OTHERS[..], false)] {
                let seeds = |cable: &str| if home.drives_on || cable == "radio" { 20 } else { 1 };
                let run = |&(cable, link)| {
                    (cable, home.median(mode, link, seeds(cable), if home.drives_on { 60.0 } else { 20.0 }))
                };
                let runs: Vec<_> = cables.iter().map(run).collect();
                for (cable, run) in &runs {
                    let share = run.exchanges_per_s / run.foretold_per_s;
                    println!(
                        "{:10} {mode:?} {cable:12} {:6.1}/s of {:6.1}/s ({share:.3}), {:.2} m",
                        home.brain, run.exchanges_per_s, run.foretold_per_s, run.distance_m
                    );
                }
                all.extend(faults(home, mode, &runs, is_ladder));
            }
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
