//! A world that goes on before its brains have answered is, once they have, the world that waited for them.

use std::collections::BTreeMap;

use baudbot_sim::{Answer, Input, Scenario, SimTime, World};
use proptest::prelude::*;

fn robot(name: &str, x: f64, link: &str, thinking_us: u64) -> String {
    format!(
        "[[robots]]\nname = \"{name}\"\nstart.x_m = {x:?}\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n\
         brain.thinking_us = {thinking_us}\n\
         microcontroller = {{ framing_us_per_byte = 5.0, receiving_us_per_byte = 5.0, obeying_us = 20.0 }}\n\
         firmware = {{ protocol = \"framed\", mode = \"stream\", period_ms = 20.0 }}\n\
         link = {link}\n\
         [robots.sensors.ir]\nkind = \"ir\"\nbearing_rad = 0.0\nrays = 3\nopening_rad = 0.5\nrange_m = 2.0\n\
         c1_m2 = 0.03\nc2 = 0.1\nsigma = 0.02\nbits = 8\nperiod_ms = 5.0\n"
    )
}

fn links() -> impl Strategy<Value = String> {
    let baud = prop::sample::select(vec![1200, 4800, 9600, 38_400, 115_200]);
    let more = prop::sample::select(vec![
        "",
        ", byte_error_rate = 0.05",
        ", half_duplex = true",
        ", receive_depth = 2",
        ", outages = [{ from_s = 0.05, for_s = 0.02 }]",
        ", adapter = { kind = \"ftdi\" }",
    ]);
    prop_oneof![
        6 => (baud, more).prop_map(|(baud, more)| format!("{{ kind = \"uart\", baud = {baud}{more} }}")),
        1 => Just("{ kind = \"usb\" }".to_owned()),
        1 => Just("{ kind = \"ideal\" }".to_owned()),
    ]
}

/// The brain of a robot at an instant: any function of both will do.
struct Brain(u64);

impl Brain {
    fn draw(&self, robot: usize, at: SimTime, what: u64) -> u64 {
        let mut mixed =
            self.0 ^ at.as_ns().wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (robot as u64 + 10 * what) << 40;
        for _ in 0..3 {
            mixed = (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        }
        mixed >> 16
    }

    /// Commands, nothing, and what is invalid, more than the cable carries.
    fn bytes(&self, spec: &baudbot_sim::model::RobotSpec, robot: usize, at: SimTime) -> Vec<u8> {
        let signal = (self.draw(robot, at, 0) % 200) as f64 / 100.0 - 1.0;
        match self.draw(robot, at, 1) % 60 {
            0 => vec![0x55; (self.draw(robot, at, 2) % 60) as usize],
            1..10 => command(spec, signal),
            // On a cable that is never idle the world never goes ahead.
            _ => Vec::new(),
        }
    }
}

fn command(spec: &baudbot_sim::model::RobotSpec, signal: f64) -> Vec<u8> {
    let (mut payload, mut bytes) = ([0; 255], [0; 300]);
    let n = baudbot_wire::write_command(&spec.firmware.layout(), 0, [signal, -signal], &mut payload);
    let n = baudbot_wire::frame::encode(&payload[..n.unwrap()], &mut bytes).unwrap();
    bytes[..n].to_vec()
}

/// Two worlds side by side.
struct Twins {
    strict: World,
    ahead: World,
    brain: Brain,
    /// The answers that are under way.
    open: BTreeMap<usize, (SimTime, Vec<u8>)>,
    went_ahead: u64,
}

impl Twins {
    fn new(scenario: Scenario, seed: u64) -> Self {
        let strict = World::new(scenario.into());
        Self { ahead: strict.clone(), strict, brain: Brain(seed), open: BTreeMap::new(), went_ahead: 0 }
    }

    fn answers(&self, world: &World) -> BTreeMap<usize, (SimTime, Vec<u8>)> {
        let answer = |turn: &baudbot_sim::Turn| {
            let spec = world.robot(turn.robot).spec();
            (turn.robot, (turn.at + spec.thinking_ns, self.brain.bytes(spec, turn.robot, turn.at)))
        };
        world.turns().iter().map(answer).collect()
    }

    fn supply(&mut self, which: impl Fn(&World, usize, SimTime) -> bool) {
        let due: Vec<_> = self
            .open
            .iter()
            .filter(|(robot, (done, _))| which(&self.ahead, **robot, *done))
            .map(|(r, _)| *r)
            .collect();
        for robot in due {
            let (done, bytes) = self.open.remove(&robot).unwrap();
            self.ahead.supply(robot, Some((done, &bytes)));
        }
    }

    fn tick(&mut self, chance: u64) {
        self.strict.begin();
        let answers = self.answers(&self.strict);
        finish(&mut self.strict, &answers);

        let end = self.ahead.time() + self.ahead.scenario().step_ns;
        let near = move |world: &World, robot, done| world.reach(robot, done).is_none_or(|reach| reach < end);
        self.supply(near);
        self.ahead.begin();
        let mut answers = self.answers(&self.ahead);
        self.supply(|world, robot, done| answers.contains_key(&robot) || near(world, robot, done));
        let mut left = Vec::new();
        let robots: Vec<_> = answers.keys().copied().collect();
        for robot in robots {
            let (done, _) = answers[&robot];
            if !near(&self.ahead, robot, done) && (chance >> robot) & 1 == 0 {
                left.push((robot, done));
                self.open.insert(robot, answers.remove(&robot).unwrap());
            }
        }
        self.went_ahead += left.len() as u64;
        let answers: Vec<_> = inputs(&answers).into_iter().map(Answer::from).collect();
        self.ahead.finish_ahead(&answers, &left);
        if (chance >> 8).is_multiple_of(3) {
            self.supply(|_, robot, _| (chance >> (12 + robot)) & 1 == 0);
        }
    }
}

fn inputs(answers: &BTreeMap<usize, (SimTime, Vec<u8>)>) -> Vec<Input<'_>> {
    answers.iter().map(|(&robot, (at, bytes))| Input { robot, at: *at, bytes }).collect()
}

fn finish(world: &mut World, answers: &BTreeMap<usize, (SimTime, Vec<u8>)>) {
    world.finish(&inputs(answers));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn what_is_supplied_later_makes_the_same_bits(
        links in prop::collection::vec((links(), prop::sample::select(vec![0, 500, 3_000, 25_000])), 1..4),
        step_ms in prop::sample::select(vec![0.5, 1.0, 3.0, 10.0]),
        deadline in prop::sample::select(vec!["", "brain.deadline_ms = 30.0\nbrain.on_late = \"stop\"\n"]),
        seed: u64,
    ) {
        let mut toml = format!("step_ms = {step_ms:?}\nsubsteps = 5\ncollision = \"stop-robot\"\n");
        for (i, (link, thinking_us)) in links.iter().enumerate() {
            let robot = robot(&format!("r{i}"), i as f64 * 0.7, link, *thinking_us);
            toml += &robot.replacen("brain.", &format!("{deadline}brain."), 1);
        }
        let mut twins = Twins::new(baudbot_scenario::parse(&toml).map_err(|e| TestCaseError::fail(e.to_string()))?, seed);
        for tick in 0..150 {
            let chance = twins.brain.draw(7, SimTime::from_ns(tick), 5);
            twins.tick(chance);
            if chance.is_multiple_of(5) || tick == 149 {
                twins.supply(|_, _, _| true);
                prop_assert_eq!(twins.ahead.hash(), twins.strict.hash(), "tick {}, {} ahead", tick, twins.went_ahead);
            }
        }
    }
}

#[test]
fn a_slow_cable_lets_the_world_go_ahead_and_an_ideal_one_does_not() {
    for (link, ahead) in [("{ kind = \"uart\", baud = 9600 }", true), ("{ kind = \"ideal\" }", false)] {
        let toml = format!("step_ms = 1.0\nsubsteps = 5\n{}", robot("r", 0.0, link, 3_000));
        let went_ahead = |seed| {
            let mut twins = Twins::new(baudbot_scenario::parse(&toml).unwrap(), seed);
            (0..1_000).for_each(|_| twins.tick(0));
            twins.went_ahead
        };
        let went_ahead: u64 = (0..20).map(went_ahead).sum();
        assert_eq!(went_ahead > 100, ahead, "{link}: {went_ahead}");
    }
}
