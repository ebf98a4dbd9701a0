//! A policy's observations, the instants of its answers, and the errors of some.

use baudbot_brain::{Actuator, ActuatorKind, Until};

use super::*;
use crate::description::Description;
use crate::registry::Registry;
use crate::test_body::{body, turn};

const MS: u64 = 1_000_000;

fn eyes() -> Body {
    body(&[("ir_left", "ir", 0.7), ("ir_right", "ir", -0.7)])
}

fn made(toml: &str, body: &Body) -> Result<Box<dyn Brain + Send>, String> {
    let description = Description::parse(toml).map_err(|error| error.to_string())?;
    description.any_brain(1, body, &Registry::standard()).map_err(|error| error.to_string())
}

fn policy(toml: &str, body: &Body) -> Box<dyn Brain + Send> {
    made(toml, body).unwrap()
}

fn near(found: Option<Signals>, left: f64, right: f64) {
    let found = found.unwrap();
    assert!((found.left - left.tanh()).abs() < 1e-6, "{found:?}, {}", left.tanh());
    assert!((found.right - right.tanh()).abs() < 1e-6, "{found:?}, {}", right.tanh());
}

#[test]
fn readings_are_scaled_and_go_through_the_layers() {
    let toml = "[policy]\noffset = [0.5, 0]\nscale = [2, 1]\nlayers = [[[1, 0, 0], [0, 1, 0.25]], [[1, 2, 0], [0, -1, 0]]]";
    let body = eyes();
    let mut brain = policy(toml, &body);
    let action = brain.step(&turn(&body, 0, &[Some(&[0.75]), Some(&[0.5])]));
    let (first, second) = (0.5_f64.tanh(), 0.75_f64.tanh());
    near(action.signals, first + 2.0 * second, -second);
}

#[test]
fn it_answers_each_message_and_after_a_second_without_one() {
    let body = eyes();
    let mut brain = policy("[policy]\nlayers = [[[1, 1, 0], [1, 0, 0.5]]]", &body);
    let silent = brain.step(&turn(&body, 0, &[None, None]));
    let until = |ms: u64| Some(Until { at_latest_ns: Some(ms * MS) });
    assert_eq!((silent.signals, silent.poll, silent.until), (None, false, until(1000)));
    let heard = brain.step(&turn(&body, 20 * MS, &[Some(&[0.25]), None]));
    near(heard.signals, 0.25, 0.75);
    assert_eq!(heard.until, until(1020));
    let mut old = turn(&body, 30 * MS, &[Some(&[0.25]), None]);
    old.readings[0].as_mut().unwrap().readable = false;
    assert_eq!(brain.step(&old).signals, None);
    old.at_ns = 1020 * MS;
    near(brain.step(&old).signals, 0.25, 0.75);
    old.at_ns = 2019 * MS;
    assert_eq!(brain.step(&old).signals, None);
}

#[test]
fn ages_count_from_the_sample_and_never_above_their_limit() {
    // The left wheel gets the age of the left sensor, the right one whether the right sensor is new.
    let toml =
        "[policy]\nages = true\nmax_age_s = 0.5\nlayers = [[[0, 0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1, 0]]]";
    let body = eyes();
    let mut brain = policy(toml, &body);
    let mut at = |at_ms: u64, sampled: Option<u64>, left: bool, right: bool| {
        let mut turn = turn(&body, at_ms * MS, &[Some(&[0.1]), Some(&[0.1])]);
        for (reading, is_new) in turn.readings.iter_mut().zip([left, right]) {
            let reading = reading.as_mut().unwrap();
            (reading.readable, reading.sampled_at_ns) = (is_new, sampled.map(|ms| ms * MS));
        }
        brain.step(&turn).signals
    };
    near(at(20, Some(5), false, true), 0.5, 1.0);
    near(at(40, Some(15), true, false), 0.025, 0.0);
    near(at(140, Some(0), false, true), 0.125, 1.0);
    near(at(200, None, true, false), 0.0, 0.0);
    near(at(300, None, false, true), 0.1, 1.0);
    near(at(900, None, false, true), 0.5, 1.0);
}

#[test]
fn numbers_are_as_coarse_as_an_environments() {
    let body = eyes();
    let mut brain = policy("[policy]\nlayers = [[[1, 0, 0], [0, 1, 0]]]", &body);
    let signals = brain.step(&turn(&body, 0, &[Some(&[0.1]), Some(&[0.2])])).signals.unwrap();
    assert_eq!(signals.left, coarse(coarse(0.1).tanh()));
    assert_ne!(signals.left, 0.1_f64.tanh());
}

#[test]
fn other_actuators_have_signals_too_and_a_silent_robot_is_asked() {
    let mut body = eyes();
    body.firmware.period_ns = None;
    body.actuators.push(Actuator { name: "turret".to_owned(), kind: ActuatorKind::Turret, range_rad: None });
    let mut brain = policy("[policy]\nlayers = [[[0, 0, 0], [0, 0, 0], [1, 0, 0]]]", &body);
    assert!(brain.step(&turn(&body, 0, &[None, None])).poll);
    assert!(!brain.step(&turn(&body, 10 * MS, &[None, None])).poll);
    let others = brain.step(&turn(&body, 20 * MS, &[Some(&[0.5]), None])).others;
    assert!(others.len() == 1 && (others[0] - 0.5_f64.tanh()).abs() < 1e-6, "{others:?}");
}

#[test]
fn what_is_wrong_is_said_with_its_field() {
    let body = eyes();
    let problem = |rest: &str| made(&format!("[policy]\n{rest}"), &body).err().expect("a problem");
    let two = "layers = [[[0, 0, 0], [0, 0, 0]]]";
    assert_eq!(
        problem("layers = [[[0, 0], [0, 0]]]"),
        "policy.layers[0][0]: has 2 numbers, and needs 3: 2 weights and the bias; \
         robot `alice` gives 2 inputs: ir_left, ir_right"
    );
    assert_eq!(
        problem(&format!("{two}\nages = true\nscale = [1, 1]")),
        "policy.scale: has 2 numbers, and robot `alice` gives 6 inputs: ir_left, ir_right, age of ir_left, \
         age of ir_right, ir_left is new, ir_right is new"
    );
    assert_eq!(
        problem("layers = [[[0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0]]]"),
        "policy.layers[1][1]: has 2 numbers, and needs 3: 2 weights and the bias"
    );
    assert_eq!(
        problem("layers = [[[0, 0, 0]]]"),
        "policy.layers[0]: has 1 neurons, and robot `alice` takes 2 signals: left, right"
    );
    assert_eq!(problem("layers = [[[0, nan, 0]]]"), "policy.layers[0][0][1]: must be finite, is NaN");
    assert_eq!(problem("layers = []"), "policy.layers: has no layer");
    assert!(
        problem("ages = true").starts_with("policy: missing field `layers`"),
        "{}",
        problem("ages = true")
    );
    assert_eq!(problem(&format!("{two}\nmax_age_s = 1")), "policy.max_age_s: counts only with ages = true");
    let newer = problem(&format!("{two}\nversion = 2"));
    assert_eq!(newer, "policy.version: is 2; this version of baudbot reads 1");
    assert_eq!(
        problem(&format!("{two}\nages = true\nmax_age_s = 0")),
        "policy.max_age_s: must be above 0 and below 1e9, is 0"
    );
    assert_eq!(
        problem(&format!("{two}\n[motor.stand]\nkind = \"constant\"")),
        "motor: beside a policy there are no processes; leave it out"
    );
    let description = Description::parse(&format!("[policy]\n{two}")).unwrap();
    let error = description.brain(1, &body, &Registry::standard()).err().unwrap();
    assert_eq!(error.to_string(), "policy: is not a brain of processes, which is needed here");
}

#[test]
fn a_policy_drives_only_robots_with_the_sensors_that_it_was_learnt_with() {
    let body = eyes();
    let made = |sensors: &str| {
        made(&format!("[policy]\nsensors = [{sensors}]\nlayers = [[[0, 0, 0], [0, 0, 0]]]"), &body).map(drop)
    };
    let sensor = |name: &str, values: usize| format!("{{ name = \"{name}\", values = {values} }}, ");
    let [left, right] = ["ir_left", "ir_right"].map(|name| sensor(name, 1));
    made(&format!("{left}{right}")).unwrap();
    for (sensors, said) in [
        (
            format!("{left}{}", sensor("laser", 1)),
            "policy.sensors[1]: robot `alice` has no `laser`, with which the policy was learnt; it has: ir_left, ir_right",
        ),
        (
            format!("{}{right}", sensor("ir_left", 5)),
            "policy.sensors[0]: `ir_left` had 5 values where the policy was learnt; that of robot `alice` has 1",
        ),
        (left.clone(), "policy.sensors: robot `alice` has a `ir_right`, without which the policy was learnt"),
        (
            format!("{right}{left}"),
            "policy.sensors: robot `alice` has them in another order: ir_left, ir_right",
        ),
    ] {
        assert_eq!(made(&sensors).unwrap_err(), said);
    }
}

#[test]
fn inputs_have_the_names_of_columns() {
    let mut body = body(&[("odometer", "odometer", 0.0), ("laser", "laser", 0.0)]);
    for (component, name) in body.sensors[0].components.iter_mut().zip(["x_m", "y_m", "heading_rad"]) {
        component.name = name.to_owned();
    }
    let names = ["odometer.x_m", "odometer.y_m", "odometer.heading_rad", "laser.0", "laser.1", "laser.2"];
    assert_eq!(input_names(&body, false), names);
    assert_eq!(
        input_names(&body, true)[6..],
        ["age of odometer", "age of laser", "odometer is new", "laser is new"]
    );
}
