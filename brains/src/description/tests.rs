//! Descriptions and their effects, and the errors of some.

use baudbot_brain::{Actuator, ActuatorKind, Body, Brain, Signals};
use serde::Deserialize;

use super::*;
use crate::process::{MotorBehavior, StepContext};
use crate::test_body::{body, turn};

const REPERTOIRE: &str = r#"
[state_variables.near]
of = ["ir_left", "ir_right"]
by = "max"

[motor.stroll]
kind = "constant"
parameters = { left = 0.5, right = 0.5 }
utility = { bias = 0.2 }

[motor.turn]
kind = "turn_away"
parameters = { turn = 0.3 }
utility = { bias = -0.5, weights = { near = 3.0 } }
"#;

fn eyes() -> Body {
    body(&[("ir_left", "ir", 0.7), ("ir_right", "ir", -0.7)])
}

/// The behaviour that is active after 1 s of each of these readings of both sensors, and the signals in force.
fn course(toml: &str, readings: &[[f64; 2]]) -> Vec<(String, Signals)> {
    let body = eyes();
    let mut brain = Description::parse(toml).unwrap().brain(1, &body, &Registry::standard()).unwrap();
    let (mut at_ns, mut signals, mut course) = (0, Signals::default(), Vec::new());
    for [left, right] in readings {
        for _ in 0..100 {
            let action = brain.step(&turn(&body, at_ns, &[Some(&[*left]), Some(&[*right])]));
            signals = action.signals.unwrap_or(signals);
            at_ns += 10_000_000;
        }
        course.push((brain.active().unwrap().to_owned(), signals));
    }
    course
}

fn named(course: &[(String, Signals)]) -> Vec<&str> {
    course.iter().map(|(name, _)| name.as_str()).collect()
}

#[test]
fn the_behaviour_with_the_greatest_utility_has_the_motors() {
    let course = course(REPERTOIRE, &[[0.0, 0.0], [0.1, 0.4], [0.0, 0.0], [0.4, 0.1]]);
    assert_eq!(named(&course), ["stroll", "turn", "stroll", "turn"]);
    assert_eq!(course[0].1, Signals { left: 0.5, right: 0.5 });
    // Away from the nearer side.
    assert_eq!(course[1].1, Signals { left: -0.3, right: 0.3 });
    assert_eq!(course[3].1, Signals { left: 0.3, right: -0.3 });
}

#[test]
fn the_same_repertoire_decides_alike_by_a_machine_by_layers_and_by_a_tree() {
    let machine = r#"
[decision]
method = "machine"
start = "stroll"
transitions = [
    { from = "stroll", to = "turn", when = ["near > 0.2"] },
    { from = "turn", to = "stroll", when = ["near < 0.2"] },
]"#;
    let layers = r#"
[decision]
method = "layers"
layers = [{ behavior = "turn", when = ["near > 0.2"] }]
base = "stroll""#;
    let tree = r#"
[decision]
method = "tree"
start = "stroll"
root = { select = [{ sequence = ["near > 0.2", "turn"] }, "stroll"] }"#;
    let readings = [[0.0, 0.0], [0.1, 0.4], [0.3, 0.0], [0.0, 0.0], [0.4, 0.1]];
    let by_utility = course(REPERTOIRE, &readings);
    for decision in [machine, layers, tree] {
        assert_eq!(course(&format!("{REPERTOIRE}{decision}"), &readings), by_utility, "{decision}");
    }
}

/// A behaviour of a user of this crate, which turns on the spot.
struct Spin(f64);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpinParameters {
    turn: f64,
}

impl MotorBehavior for Spin {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        context.set_gamma("stroll", -9.0);
        Some(Signals { left: -self.0, right: self.0 })
    }
}

#[test]
fn an_own_behaviour_is_named_like_any_other_and_can_set_gammas() {
    let mut registry = Registry::standard();
    registry.motors.add("spin", |parameters: SpinParameters, _| Ok(Spin(parameters.turn)));
    let spin = "[motor.spin]\nkind = \"spin\"\nparameters = { turn = 0.2 }\nutility = { bias = 0.3 }";
    let body = eyes();
    let description = Description::parse(&format!("{REPERTOIRE}{spin}")).unwrap();
    let mut brain = description.brain(1, &body, &registry).unwrap();
    for step in 0..200 {
        brain.step(&turn(&body, step * 10_000_000, &[None, None]));
    }
    assert_eq!(brain.active(), Some("spin"));
    let stroll = brain.utilities().find(|(name, ..)| *name == "stroll").unwrap().1;
    assert!(stroll < -0.99, "{stroll}");
    let belief = brain.belief().unwrap();
    assert_eq!(belief.state, "spin");
    assert_eq!(belief.utilities.iter().filter(|utility| utility.active).count(), 1);
}

/// Fig. 7.2: what is internal, where it kills, and the tendencies with their slopes.
#[test]
fn a_brain_with_an_internal_state_publishes_its_motivation_and_others_none() {
    let with = |toml: &str| {
        let body = eyes();
        let description = Description::parse(toml).unwrap();
        let mut brain = description.brain(1, &body, &Registry::standard()).unwrap();
        brain.step(&turn(&body, 0, &[Some(&[0.5]), None]));
        brain.belief().unwrap().motivation
    };
    assert_eq!(with(REPERTOIRE), None);
    let internal = "[internal.fear]\ninitial = 0.5\nlethal_above = 0.9\n";
    let flee = "[motor.flee]\nkind = \"constant\"\n\
                utility = { bias = -1.0, slope = 2.0, weights = { fear = 3.0 } }\n";
    let state = with(&format!("{REPERTOIRE}{internal}{flee}")).unwrap();
    let fear = state.variables.iter().position(|variable| variable.name == "fear").unwrap();
    let variable = &state.variables[fear];
    assert_eq!((variable.value, variable.internal, variable.lethal), (0.5, true, [None, Some(0.9)]));
    assert!(state.variables.iter().any(|variable| !variable.internal));
    let flee = state.tendencies.iter().find(|tendency| tendency.name == "flee").unwrap();
    assert_eq!((flee.bias, flee.weights.len()), (-2.0, state.variables.len()));
    assert_eq!(flee.weights[fear], 6.0);
    assert_eq!(flee.weights.iter().filter(|weight| **weight != 0.0).count(), 1);
}

/// Reservoirs (§4.4.4, the hydraulic model) are internal, too.
#[test]
fn a_brain_of_reservoirs_publishes_their_energies() {
    let body = eyes();
    let toml = "[motor.rest]\nkind = \"constant\"\n[motor.show]\nkind = \"constant\"\n\
                [decision]\nmethod = \"hydraulic\"\nbase = \"rest\"\n\
                reservoirs = [{ behavior = \"show\", fill_hz = 0.1, spring = 0.8, energy = 0.25 }]";
    let mut brain = Description::parse(toml).unwrap().brain(1, &body, &Registry::standard()).unwrap();
    brain.step(&turn(&body, 0, &[None, None]));
    let state = brain.belief().unwrap().motivation.unwrap();
    let energies: Vec<_> = state.variables.iter().map(|one| (one.name.as_str(), one.value)).collect();
    assert_eq!((energies, state.tendencies.len()), (vec![("energy of show", 0.25)], 0));
}

#[test]
fn any_brain_is_a_behaviour() {
    let toml = "[motor.stroll]\nkind = \"wander\"\nparameters = { forward = 0.25 }";
    assert_eq!(course(toml, &[[0.0, 0.0]]).len(), 1);
    let brain =
        Description::parse("[motor.stroll]\nkind = \"wander\"\nparameters = { forwards = 0.25 }").unwrap();
    let problem = brain.brain(1, &eyes(), &Registry::standard()).err().unwrap().to_string();
    assert!(
        problem.starts_with(
            "motor.stroll.parameters: brain `wander` has no parameter `forwards`; it has: forward,"
        ),
        "{problem}"
    );
}

#[test]
fn numbers_are_set_from_outside() {
    let settings =
        [("motor.turn.utility.bias".to_owned(), -9.0), ("motor.stroll.parameters.left".to_owned(), 0.1)];
    let description = Description::with_settings(REPERTOIRE, &settings).unwrap();
    let body = eyes();
    let mut brain = description.brain(1, &body, &Registry::standard()).unwrap();
    let action = brain.step(&turn(&body, 0, &[Some(&[1.0]), Some(&[1.0])]));
    assert_eq!(action.signals, Some(Signals { left: 0.1, right: 0.5 }));
    let through = [("motor.turn.kind.x".to_owned(), 1.0)];
    let problem = Description::with_settings(REPERTOIRE, &through).unwrap_err().to_string();
    assert_eq!(problem, "motor.turn.kind.x: `kind` is not a table");
}

#[test]
fn what_is_wrong_is_said_with_its_path() {
    let problem = |from: &str, to: &str| {
        let text = REPERTOIRE.replace(from, to);
        assert_ne!(text, REPERTOIRE);
        match Description::parse(&text) {
            Err(error) => error.to_string(),
            Ok(description) => {
                description.brain(1, &eyes(), &Registry::standard()).err().expect("a problem").to_string()
            }
        }
    };
    let whole = |text: &str| Description::parse(text).unwrap_err().to_string();
    assert_eq!(whole(""), "motor: has no behaviour; a brain needs one, such as [motor.stand]");
    assert!(whole("motor = 1").starts_with("motor: must be a table, is 1"), "{}", whole("motor = 1"));
    assert!(whole("[motor.x").contains("line 1"), "{}", whole("[motor.x"));
    assert_eq!(
        problem("{ near =", "{ nar ="),
        "motor.turn.utility.weights.nar: there is no state variable `nar`; there are: near"
    );
    assert_eq!(
        problem("\"ir_right\"]", "\"ir_rear\"]"),
        "state_variables.near.of[1]: there is no sensor `ir_rear`; there are: ir_left, ir_right"
    );
    assert_eq!(
        problem("by = \"max\"", "by = \"sum\""),
        "state_variables.near.weights: a sum needs a weight for each value"
    );
    assert_eq!(
        problem("by = \"max\"", "by = \"sum\"\nweights = [1.0]"),
        "state_variables.near.weights: there are 1, and the values are 2"
    );
    assert!(problem("\"turn_away\"", "\"turn_off\"").starts_with(
        "motor.turn.kind: there is no kind `turn_off`; there are: ant, avoid, charge, constant"
    ),);
    assert_eq!(
        problem("turn = 0.3", "turm = 0.3"),
        "motor.turn.parameters: turm: unknown field `turm`, expected `turn` or `field_rad`"
    );
    assert_eq!(problem("bias = 0.2", "tau_s = 0.0"), "motor.stroll.utility.tau_s: must be positive, is 0");
    let machine = "[decision]\nmethod = \"layers\"\nbase = \"stroll\"\nlayers = [{ behavior = \"turn\", when = [\"near\"] }]";
    let description = Description::parse(&format!("{REPERTOIRE}{machine}")).unwrap();
    let error = description.brain(1, &eyes(), &Registry::standard()).err().unwrap();
    assert_eq!(
        error.to_string(),
        "decision.layers[0].when[0]: `near` is not a condition such as `near > 0.5`"
    );
}

#[test]
fn numbers_that_make_no_sense_are_refused() {
    let mut body = eyes();
    body.sensors.push(crate::test_body::body(&[("laser", "laser", 0.0)]).sensors.remove(0));
    let problem = |toml: &str| {
        let brain = Description::parse(toml).and_then(|read| read.brain(1, &body, &Registry::standard()));
        brain.err().expect("a problem").to_string()
    };
    assert_eq!(
        problem("[motor.a]\nkind = \"go_to\"\nparameters = { points_m = [[0.0, nan]] }"),
        "motor.a.parameters.points_m[0][1]: must be finite, is NaN"
    );
    let wall = "kind = \"follow_wall\"\nparameters = { sensor = \"ir_left\", limit = -0.3 }";
    assert_eq!(
        problem(&format!("[motor.a]\n{wall}")),
        "motor.a.parameters: limit: must not be negative, is -0.3"
    );
    let find = |more: &str| {
        format!(
            "[motor.a]\nkind = \"constant\"\n[cognitive.find]\nkind = \"laser_localization\"\n\
             [cognitive.find.parameters]\nwalls_m = []\n{more}"
        )
    };
    let refused = |more: &str| problem(&find(more)).replace("cognitive.find.parameters: ", "");
    assert_eq!(refused("stop = \"stand\""), "stop: there is no motor behaviour `stand`; there are: a");
    assert_eq!(
        refused("stop = \"a\"\n[decision]\nmethod = \"layers\"\nbase = \"a\"\nlayers = []"),
        "stop: needs a decision by utilities"
    );
    assert_eq!(refused("every_s = 1e9"), "every_s: must be from 0 to 1000000, is 1000000000");
    // Whole numbers can be set, too.
    let rays = [("cognitive.find.parameters.rays".to_owned(), 85.0)];
    assert!(
        Description::with_settings(&find(""), &rays).unwrap().brain(1, &body, &Registry::standard()).is_ok()
    );
}

#[test]
fn there_are_no_more_processes_than_a_brain_may_speak_of() {
    let stand = |i: usize| format!("[motor.stand_{i}]\nkind = \"constant\"\nutility = {{ bias = 0.1 }}\n");
    let parse = |count: usize| Description::parse(&(0..count).map(stand).collect::<String>());
    assert!(parse(256).is_ok());
    let error = parse(257).unwrap_err().to_string();
    assert_eq!(error, "motor: has 257 processes with `cognitive`; there may be 256");
}

#[test]
fn a_cognitive_process_of_which_nothing_is_said_is_always_active() {
    let mut body = eyes();
    body.sensors.push(crate::test_body::body(&[("odometer", "odometer", 0.0)]).sensors.remove(0));
    let toml = "[motor.a]\nkind = \"constant\"\n[cognitive.where]\nkind = \"odometry\"";
    let mut brain = Description::parse(toml).unwrap().brain(1, &body, &Registry::standard()).unwrap();
    brain.step(&turn(&body, 0, &[None, None, Some(&[1.0, 2.0, 0.5])]));
    let pose = brain.beliefs().pose.expect("a pose").world_from_robot;
    assert_eq!((pose.position.x, pose.position.y, pose.heading), (1.0, 2.0, 0.5));
}

/// `docs/reference/brains.md` as people copy it.
mod docs {
    use super::*;
    use crate::catalogue::catalogue;

    const DOCS: &str = include_str!("../../../docs/reference/brains.md");

    fn blocks() -> impl Iterator<Item = &'static str> {
        let blocks = DOCS.split("```toml\n").skip(1);
        blocks.map(|rest| rest.split("```").next().unwrap())
    }

    #[test]
    fn its_descriptions_make_brains_and_its_decisions_fit_the_first() {
        let eyes = ["ir_left", "ir_front_left", "ir_front", "ir_front_right", "ir_right"];
        let headings = [1.0, 0.5, 0.0, -0.5, -1.0];
        let sensors: Vec<_> =
            eyes.iter().zip(headings).map(|(name, heading)| (*name, "ir", heading)).collect();
        let body = body(&sensors);
        let mut registry = Registry::standard();
        #[derive(Deserialize)]
        struct Forward {
            forward: f64,
        }
        registry.motors.add("weave", |parameters: Forward, _| Ok(Spin(parameters.forward)));
        let first = blocks().find(|block| block.contains("[motor.")).unwrap();
        let mut decisions = 0;
        for block in blocks().filter(|block| !block.contains("[dependencies]")) {
            let is_part = block.starts_with("[decision]") || block.starts_with("[internal.");
            decisions += u32::from(block.starts_with("[decision]"));
            let toml = if is_part { format!("{first}\n{block}") } else { block.to_owned() };
            let brain =
                Description::parse(&toml).and_then(|description| description.any_brain(1, &body, &registry));
            assert!(brain.is_ok(), "{toml}\n{:?}", brain.err());
        }
        assert_eq!(decisions, 5);
    }

    #[test]
    fn it_names_every_brain_and_every_kind_of_process() {
        let registry = Registry::standard();
        let names = catalogue().into_iter().map(|entry| entry.name).collect::<Vec<_>>();
        for name in names.into_iter().chain(registry.motors.names()).chain(registry.cognitives.names()) {
            assert!(DOCS.contains(&format!("| `{name}` |")), "{name}");
        }
    }
}

/// Stands while nothing is near, and rolls for 2 s when something was.
const GOOSE: &str = r#"
[state_variables.near]
of = ["ir_left", "ir_right"]
by = "max"

[motor.brood]
kind = "constant"
parameters = { left = 0.0, right = 0.0 }

[motor.roll]
kind = "fixed_action"
parameters = { motions = [[0.3, 0.3, 1.0], [-0.2, -0.2, 1.0]] }

[decision]
method = "layers"
layers = [{ behavior = "roll", when = ["near > 0.3"] }]
base = "brood"
"#;

#[test]
fn a_fixed_action_pattern_runs_to_its_end_though_its_releaser_is_taken_away() {
    let (out, back) = (Signals { left: 0.3, right: 0.3 }, Signals { left: -0.2, right: -0.2 });
    // Signals at the end of each second.
    let found = course(GOOSE, &[[0.0, 0.0], [0.4, 0.0], [0.0, 0.0], [0.0, 0.0]]);
    let signals = found.iter().map(|(_, signals)| *signals).collect::<Vec<_>>();
    assert_eq!(signals, [Signals::default(), out, back, Signals::default()]);
    // A releaser that stays releases it once.
    let found = course(GOOSE, &[[0.4, 0.0]; 5]);
    let signals = found.iter().map(|(_, signals)| *signals).collect::<Vec<_>>();
    assert_eq!(signals[..2], [out, back]);
    assert_eq!(signals[2..], [Signals::default(); 3]);
}

/// Two needs that grow; each is satisfied while its behaviour drives.
const NEEDS: &str = r#"
[internal.hunger]
rate_hz = 0.1
during = { eat = -0.3 }

[internal.thirst]
initial = 0.05
rate_hz = 0.1
during = { drink = -0.3 }

[motor.eat]
kind = "constant"
parameters = { left = 0.1, right = 0.0 }
utility = { weights = { hunger = 1.0 }, tau_s = 0.01 }

[motor.drink]
kind = "constant"
parameters = { left = 0.0, right = 0.1 }
utility = { weights = { thirst = 1.0 }, tau_s = 0.01 }
"#;

/// The number of changes between behaviours in twenty seconds.
fn changes(toml: &str) -> usize {
    let body = eyes();
    let mut brain = Description::parse(toml).unwrap().brain(1, &body, &Registry::standard()).unwrap();
    let active = |step: u64| {
        brain.step(&turn(&body, step * 10_000_000, &[Some(&[0.0]), Some(&[0.0])]));
        brain.active().unwrap().to_owned()
    };
    let active: Vec<_> = (0..2000).map(active).collect();
    active.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// The cost of changing (§7.2.1).
#[test]
fn two_needs_make_it_dither_unless_a_change_costs() {
    let free = changes(NEEDS);
    assert!(free > 300, "{free}");
    for (cost, most) in [(0.05, 100), (0.2, 30)] {
        let changes = changes(&format!("{NEEDS}[decision]\nmethod = \"utility\"\nchange_cost = {cost}"));
        assert!((2..most).contains(&changes), "{cost}: {changes}");
    }
}

#[test]
fn a_hormone_makes_a_brain_hungry_and_hunger_kills() {
    let toml = r#"
[state_variables.smell]
of = ["ir_left"]
by = "max"

[internal.hunger]
rate_hz = 0.2
lethal_above = 1.0
gain = { smell = 4.0 }

[motor.rest]
kind = "constant"
utility = { bias = 0.5 }

[motor.forage]
kind = "constant"
parameters = { left = 0.5, right = 0.5 }
utility = { weights = { smell = 1.0 } }
"#;
    // The same smell means little to who has eaten: 0.2 (1 + 4 h) exceeds 0.5 from h = 0.375 on.
    let found = course(toml, &[[0.2, 0.0]; 6]);
    assert_eq!(named(&found), ["rest", "forage", "forage", "forage", "forage", "forage"]);
    let go = Signals { left: 0.5, right: 0.5 };
    assert_eq!(found[3].1, go);
    assert_eq!(found[5].1, Signals::default(), "it starved after five seconds");
}

#[test]
fn a_display_bursts_out_where_its_energy_is_not_released() {
    let toml = format!(
        "{REPERTOIRE}\n[decision]\nmethod = \"hydraulic\"\nbase = \"stroll\"\n\
         reservoirs = [{{ behavior = \"turn\", releaser = \"near\", fill_hz = 0.2, spring = 0.6 }}]"
    );
    let found = course(&toml, &[[0.0, 0.0], [0.3, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]);
    assert_eq!(named(&found), ["stroll", "turn", "stroll", "turn", "turn"]);
}

#[test]
fn behaviours_that_cooperate_drive_together_by_their_weights() {
    let toml = format!("{REPERTOIRE}\n[decision]\nmethod = \"cooperative\"\nweights = {{ turn = 2.0 }}");
    let toml = toml.replace("utility = { bias = 0.2 }\n", "");
    // tanh(3 × 0.4 − 0.5) twice, beside 1 of the stroll.
    let weight = 2.0 * (0.7_f64).tanh();
    let found = course(&toml, &[[0.0, 0.0], [0.4, 0.0]]);
    assert_eq!(found[0].1, Signals { left: 0.5, right: 0.5 });
    let expected = [0.5 + weight * 0.3, 0.5 - weight * 0.3].map(|sum| sum / (1.0 + weight));
    let Signals { left, right } = found[1].1;
    assert!((left - expected[0]).abs() < 1e-3 && (right - expected[1]).abs() < 1e-3, "{found:?}");
}

/// A pattern that was left before its end held the decision for ever.
#[test]
fn a_fixed_action_drives_alone_where_others_cooperate_and_holds_up_nothing() {
    let toml = r#"
[state_variables.near]
of = ["ir_left", "ir_right"]
by = "max"

[motor.a]
kind = "fixed_action"
parameters = { motions = [[0.3, 0.3, 1.5]] }
utility = { bias = -0.1, weights = { near = 1.0 }, tau_s = 0.01 }

[motor.b]
kind = "constant"
parameters = { left = 0.1, right = -0.1 }
utility = { bias = -0.1, weights = { near = 3.0 }, tau_s = 0.01 }

[decision]
method = "cooperative"
"#;
    let found = course(toml, &[[0.5, 0.0], [0.0, 0.0], [0.0, 0.0], [0.5, 0.0], [0.5, 0.0], [0.5, 0.0]]);
    let alone = Signals { left: 0.3, right: 0.3 };
    // It runs for 1.5 s, then nothing weighs anything; and again.
    assert_eq!([found[0].1, found[2].1, found[3].1], [alone, Signals::default(), alone]);
    let Signals { left, right } = found[5].1;
    assert!(left > 0.0 && right < 0.0, "{found:?}");
}

#[test]
fn errors_of_the_internal_state_name_the_field_and_the_fix() {
    let error = |change: (&str, &str)| {
        let toml = NEEDS.replacen(change.0, change.1, 1);
        match Description::parse(&toml) {
            Err(error) => error.to_string(),
            Ok(description) => match description.brain(1, &eyes(), &Registry::standard()) {
                Err(error) => error.to_string(),
                Ok(_) => panic!("{change:?} is taken"),
            },
        }
    };
    assert_eq!(
        error(("{ eat =", "{ eats =")),
        "internal.hunger.during.eats: there is no `eats`; there are: drink, eat"
    );
    assert_eq!(
        error(("initial = 0.05", "initial = 2.0")),
        "internal.thirst.initial: must be from `least`, 0, to `most`, 1, is 2"
    );
    assert_eq!(
        error(("rate_hz", "decay_s = 0.0\nrate_hz")),
        "internal.hunger.decay_s: must be positive, is 0"
    );
    let with =
        |decision: &str| error(("[internal.hunger]", &format!("[decision]\n{decision}\n[internal.hunger]")));
    assert_eq!(
        with("method = \"utility\"\nchange_cost = -1.0"),
        "decision.change_cost: must be from 0 to 1000000, is -1"
    );
    assert_eq!(
        with("method = \"cooperative\"\nweights = { sleep = 1.0 }"),
        "decision.weights.sleep: there is no `sleep`; there are: drink, eat"
    );
    assert_eq!(
        with(
            "method = \"hydraulic\"\nbase = \"eat\"\nreservoirs = [{ behavior = \"drink\", releaser = \"red\", fill_hz = 1.0, spring = 1.0 }]"
        ),
        "decision.reservoirs[0].releaser: there is no state variable `red`; there are: hunger, thirst"
    );
}

#[test]
fn actuators_besides_the_wheels_get_a_bias_and_a_weighted_sum_within_one() {
    let toml = "[state_variables.near]\nof = [\"ir_left\", \"ir_right\"]\nby = \"max\"\n[motor.stand]\nkind = \"constant\"\n\
                [actuators.horn]\nbias = -0.25\nweights = { near = 2.0 }\n";
    let mut robot = eyes();
    robot.actuators = ["lamp", "horn"]
        .map(|name| Actuator { name: name.to_owned(), kind: ActuatorKind::Speaker, range_rad: None })
        .to_vec();
    let built = |toml: &str| {
        Description::parse(toml).and_then(|parsed| parsed.brain(1, &robot, &Registry::standard()))
    };
    for (near, horn) in [(0.0, -0.25), (0.5, 0.75), (1.0, 1.0)] {
        let action = built(toml).unwrap().step(&turn(&robot, 0, &[Some(&[near]), Some(&[0.0])]));
        assert_eq!(action.others, [0.0, horn], "{near}");
    }
    let error = |from: &str, to: &str| built(&toml.replace(from, to)).map(drop).unwrap_err().to_string();
    assert_eq!(
        error("actuators.horn", "actuators.bell"),
        "actuators.bell: the robot has no actuator `bell`; there are: lamp, horn"
    );
    assert_eq!(
        error("{ near = 2", "{ far = 2"),
        "actuators.horn.weights.far: there is no `far`; there are: near"
    );
    assert_eq!(error("bias = -0.25", "bias = nan"), "actuators.horn.bias: must be finite, is NaN");
}
