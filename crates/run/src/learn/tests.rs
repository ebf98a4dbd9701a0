use std::sync::Arc;

use baudbot_brain::{Action, Brain, Turn};
use baudbot_import::source::Source;

use super::run::episode_seed;
use super::{
    Arrays, Autoreset, Draw, Env, Fleet, LearnError, Request, Reward, Rewards, Seeds, Tally, Task, Varied,
};
use crate::in_process::InProcess;

/// On, more slowly the nearer something is, and to the left before what is too near.
fn steer(nearest: f64) -> [f64; 2] {
    let way = 1.0 - nearest / 0.28;
    if way > 0.0 { [0.15 + 0.35 * way; 2] } else { [-0.5, 0.5] }
}

/// The same as a brain, which acts when it has news.
struct Steer;

impl Brain for Steer {
    fn step(&mut self, turn: &Turn) -> Action {
        let readings: Vec<_> = turn.readings.iter().flatten().collect();
        if !readings.iter().any(|reading| reading.readable) {
            return Action::wait();
        }
        let nearest = readings.iter().map(|reading| reading.values[0]).fold(0.0, f64::max);
        let [left, right] = steer(nearest);
        Action::drive(left, right)
    }
}

fn task(scenario: &str, request: Request) -> Result<Arc<Task>, LearnError> {
    Task::new(Source::find(scenario)?, request).map(Arc::new)
}

fn wander(overrides: &[&str]) -> Arc<Task> {
    let overrides = overrides.iter().map(|&text| text.to_owned()).collect();
    task("wander", Request { overrides, ..Request::default() }).unwrap()
}

fn act(env: &mut Env) {
    let nearest = env.agents()[0].values().iter().copied().fold(0.0, f64::max);
    env.act(0, steer(nearest).into_iter()).unwrap();
}

#[test]
fn a_robot_does_what_it_does_with_a_brain_in_its_process() {
    for change in [
        "seed=1",
        "robots.robot.link.baud=1200",
        "robots.robot.brain.thinking_us=7000.0",
        "robots.robot.brain.thinking_us=35000.0",
    ] {
        let overrides = ["end.after_s=20.0", change];
        let task = wander(&overrides);
        let mut env = Env::new(Arc::clone(&task), 3, &[]).unwrap();
        while !env.is_over() {
            act(&mut env);
            env.step();
        }
        let scenario = task.scenario(3, &[]).unwrap();
        let mut beside = InProcess::with_brain((*scenario).clone(), Steer);
        beside.world.keep_timeline(0);
        beside.run(u64::MAX);
        beside.world.begin();
        assert_eq!(env.world().hash(), beside.world.hash(), "{overrides:?}");
        assert!(env.world().robot(0).counters().distance_m > 1.0);
    }
}

#[test]
fn a_step_is_a_control_cycle_and_ages_are_those_of_the_cable() {
    let mut env = Env::new(wander(&[]), 0, &[]).unwrap();
    for _ in 0..5 {
        let before = env.agents()[0].now();
        act(&mut env);
        env.step();
        let agent = &env.agents()[0];
        assert_eq!(agent.now().since(before), 20_000_000);
        assert_eq!(agent.readable(), [true; 5]);
        // 19 bytes at 9600 baud, and what the reads take.
        assert!(
            agent.ages_s().all(|age_s| (0.0198..0.03).contains(&age_s)),
            "{:?}",
            agent.ages_s().collect::<Vec<_>>()
        );
        assert!((env.tally(0).seconds - 0.02).abs() < 1e-12);
    }
}

#[test]
fn what_does_not_come_is_not_waited_for_for_ever() {
    let mut env = Env::new(wander(&["robots.robot.link.byte_error_rate=1.0"]), 0, &[]).unwrap();
    let before = env.world().time();
    act(&mut env);
    env.step();
    assert_eq!(env.world().time().since(before), 1_000_000_000);
    assert_eq!(env.agents()[0].readable(), [false; 5]);
    assert!(env.agents()[0].ages_s().all(f64::is_infinite));
}

#[test]
fn a_copy_goes_on_as_the_original_does() {
    let mut env = Env::new(wander(&[]), 0, &[]).unwrap();
    for _ in 0..40 {
        act(&mut env);
        env.step();
    }
    let mut copy = env.snapshot().unwrap();
    for env in [&mut env, &mut copy] {
        for _ in 0..40 {
            act(env);
            env.step();
        }
    }
    assert_eq!(env.world().hash(), copy.world().hash());
}

#[test]
fn a_copy_by_value_goes_on_as_the_original_does() {
    for scenario in
        ["wander", "khepera", "../../catalogue/scenarios/hall.toml", "../../catalogue/scenarios/sweeper.toml"]
    {
        let randomize = vec![Varied {
            path: "robots.0.start.heading_rad".into(),
            draw: Draw::Uniform { low: -0.2, high: 0.2 },
        }];
        let task = task(scenario, Request { randomize, ..Request::default() }).unwrap();
        let mut env = Env::new(Arc::clone(&task), 7, &["end.after_s=30.0".into()]).unwrap();
        for _ in 0..40 {
            act(&mut env);
            env.step();
        }
        act(&mut env);
        let bytes = env.save().unwrap();
        let mut copy = Env::load(Arc::clone(&task), &bytes).unwrap();
        assert_eq!(env.world().hash(), copy.world().hash());
        assert_eq!(env.agents()[0].values(), copy.agents()[0].values());
        for env in [&mut env, &mut copy] {
            env.step();
            for _ in 0..40 {
                act(env);
                env.step();
            }
        }
        assert_eq!((env.world().hash(), env.tally(0)), (copy.world().hash(), copy.tally(0)), "{scenario}");
        for cut in 0..bytes.len() {
            assert!(Env::load(Arc::clone(&task), &bytes[..cut]).is_err(), "{cut}");
        }
    }
}

#[test]
fn wrong_actions_and_rewards_are_named() {
    let mut env = Env::new(wander(&[]), 0, &[]).unwrap();
    let said = env.act(0, [0.1].into_iter()).unwrap_err().to_string();
    assert_eq!(said, "action: has 1 signals, robot `robot` takes 2: left, right");
    let said = env.act(0, [0.1, f64::NAN].into_iter()).unwrap_err();
    assert_eq!(
        (said.path().unwrap().as_str(), said.to_string().as_str()),
        ("action[1]", "action[1]: the signal for `right` is NaN")
    );
    let said = env.act(0, [f64::INFINITY, 0.1].into_iter()).unwrap_err().to_string();
    assert_eq!(said, "action[0]: the signal for `left` is inf");
    let said = Reward::new([("distance", 1.0)]).unwrap_err().to_string();
    assert!(
        said.starts_with("reward.distance: there is no such part; there are: seconds, distance_m"),
        "{said}"
    );
    let said =
        task("wander", Request { overrides: vec!["robots.robot.link.baud=0".into()], ..Request::default() })
            .unwrap_err();
    assert_eq!(said.path().as_deref(), Some("robots[0].link.baud"), "{said}");
}

/// Arrays of a fleet of `wander`.
struct Buffers {
    values: Vec<f32>,
    ages_s: Vec<f32>,
    readable: Vec<i8>,
    rewards: Vec<f64>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    tallies: Vec<f64>,
}

impl Buffers {
    fn new(count: usize) -> Self {
        Self {
            values: vec![0.0; count * 5],
            ages_s: vec![0.0; count * 5],
            readable: vec![0; count * 5],
            rewards: vec![0.0; count],
            terminated: vec![false; count],
            truncated: vec![false; count],
            tallies: vec![0.0; count * Tally::NAMES.len()],
        }
    }

    fn step(&mut self, fleet: &mut Fleet, reward: &Reward) {
        let nearest = |row: &[f32]| f64::from(row.iter().copied().fold(0.0, f32::max));
        let actions: Vec<_> = self
            .values
            .chunks_exact(5)
            .flat_map(|row| steer(nearest(row)).map(|signal| signal as f32))
            .collect();
        let Self { values, ages_s, readable, rewards, terminated, truncated, tallies } = self;
        let arrays = Arrays { values, ages_s, readable };
        fleet
            .step(&actions, reward, arrays, Rewards { rewards, terminated, truncated, tallies, finals: None })
            .unwrap();
    }
}

/// Fingerprints after so many steps, what all rewards come to, and how many runs ended.
fn ran(threads: usize, autoreset: Autoreset) -> (u64, f64, usize) {
    let task = wander(&["end.after_s=4.0", "robots.robot.start.x_m=1.2"]);
    let mut fleet = Fleet::new(&task, 8, threads, 10, autoreset).unwrap();
    let reward = Reward::new([("distance_m", 1.0), ("collisions", -5.0)]).unwrap();
    let mut buffers = Buffers::new(8);
    let Buffers { values, ages_s, readable, .. } = &mut buffers;
    fleet.reset(Seeds::From(10), None, Arrays { values, ages_s, readable }).unwrap();
    let (mut total, mut ended) = (0.0, 0);
    for _ in 0..300 {
        buffers.step(&mut fleet, &reward);
        total += buffers.rewards.iter().sum::<f64>();
        ended += buffers.truncated.iter().chain(&buffers.terminated).filter(|over| **over).count();
    }
    (fleet.hash(), total, ended)
}

#[test]
fn each_environment_of_a_fleet_may_have_a_seed_of_its_own() {
    let mut fleet = Fleet::new(&wander(&[]), 3, 1, 1, Autoreset::NextStep).unwrap();
    let mut buffers = Buffers::new(3);
    let mut begin = |fleet: &mut Fleet, seeds: Seeds<'_>| {
        let Buffers { values, ages_s, readable, .. } = &mut buffers;
        fleet.reset(seeds, None, Arrays { values, ages_s, readable }).unwrap();
        [0, 1, 2].map(|place| fleet.info(place, false).seed)
    };
    let from = begin(&mut fleet, Seeds::From(5));
    assert_eq!(begin(&mut fleet, Seeds::Each(&[Some(5), Some(6), Some(7)])), from);
    let [first, next, last] = begin(&mut fleet, Seeds::Each(&[Some(7), None, Some(5)]));
    assert_eq!((first, last), (from[2], from[0]));
    assert_ne!(next, from[1], "it follows from the one before");
    assert_eq!(begin(&mut fleet, Seeds::From(5)), from);
    assert_ne!(begin(&mut fleet, Seeds::Next), from);
}

#[test]
fn threads_make_no_difference_to_any_bit() {
    let one = ran(1, Autoreset::SameStep);
    assert_eq!(one, ran(2, Autoreset::SameStep));
    assert_eq!(one, ran(3, Autoreset::SameStep));
    assert!(one.2 >= 8 && one.1 > 0.1, "{one:?}");
}

#[test]
fn a_run_begins_again_in_the_step_that_is_asked_for() {
    let [same, next, never] =
        [Autoreset::SameStep, Autoreset::NextStep, Autoreset::Never].map(|when| ran(1, when));
    assert!(next.2 >= 8 && same.2 >= next.2, "{same:?} {next:?}");
    // An environment whose run is over reports it in each step.
    assert!(never.2 > same.2, "{never:?}");
}

#[test]
fn later_runs_have_seeds_of_their_own() {
    assert_eq!(episode_seed(7, 0), 7);
    let seeds: std::collections::BTreeSet<_> =
        (0..100).flat_map(|seed| (0..100).map(move |n| episode_seed(seed, n))).collect();
    assert_eq!(seeds.len(), 10_000);
    assert!(seeds.iter().all(|&seed| seed < 1 << 48));
}

#[test]
fn fields_are_drawn_for_each_run_from_its_seed() {
    let varied = |path: &str, draw| Varied { path: path.into(), draw };
    let randomize = vec![
        varied("robots.robot.start.x_m", Draw::Uniform { low: -0.5, high: 0.5 }),
        varied("robots.robot.link.baud", Draw::Choice(vec!["9600".into(), "19200".into()])),
    ];
    let task = task("wander", Request { randomize, ..Request::default() }).unwrap();
    let scenario = |seed| task.scenario(seed, &[]).unwrap();
    let start = |seed| scenario(seed).robots[0].start.pose.position.x;
    assert_eq!(start(5), start(5));
    let starts: Vec<_> = (0..50).map(start).collect();
    assert!(
        starts.iter().all(|x| (-0.5..0.5).contains(x))
            && starts.iter().any(|x| *x < -0.2)
            && starts.iter().any(|x| *x > 0.2)
    );
    let fast =
        (0..50).filter(|&seed| format!("{:?}", scenario(seed).robots[0].link).contains("19200")).count();
    assert!((10..40).contains(&fast), "{fast}");
    let empty = Varied { path: "seed".into(), draw: Draw::Integer { low: 3, high: 2 } };
    assert_eq!(empty.check().unwrap_err().to_string(), "randomize.seed: [3, 2] is empty");
}

#[test]
fn what_would_change_observations_is_refused() {
    let varied =
        Varied { path: "robots.robot.sensors.ir_left".into(), draw: Draw::Choice(vec!["{}".into()]) };
    assert!(task("wander", Request { randomize: vec![varied], ..Request::default() }).is_err());
    let task = wander(&[]);
    let more = ["robots.0.name=other".to_owned()];
    let said = task.scenario(0, &more).unwrap_err().to_string();
    assert!(said.contains("changes which robots there are"), "{said}");
}
