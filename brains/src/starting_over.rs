//! Brains of the catalogue start over when their time does. A brain that remembers the instant of its last action would
//! otherwise wait until that comes again.

use baudbot_brain::{Body, Brain, EachRun};

use crate::catalogue;
use crate::description::Description;
use crate::kinds::KINDS;
use crate::registry::Registry;
use crate::test_body::{body, turn};

/// Whether the brain commands anything in the first 100 ms from this instant on, in which it senses something new every
/// 20 ms.
fn commands(brain: &mut dyn Brain, body: &Body, from_ns: u64) -> bool {
    let values: Vec<_> = body.sensors.iter().map(|sensor| vec![0.1; sensor.values()]).collect();
    let readings: Vec<_> = values.iter().map(|values| Some(values.as_slice())).collect();
    let mut acts =
        |step: u64| brain.step(&turn(body, from_ns + step * 20_000_000, &readings)).signals.is_some();
    (0..5).filter(|&step| acts(step)).count() > 0
}

#[test]
fn a_described_brain_begins_anew_too() {
    let body = body(&[("odometer", "odometer", 0.0)]);
    let toml = "[motor.stroll]\nkind = \"go_to\"\nparameters = { points_m = [[1.0, 0.0]] }\n\
                [cognitive.where]\nkind = \"odometry\"";
    let description = Description::parse(toml).unwrap();
    let make = |body: &Body| description.brain(1, body, &Registry::standard());
    let mut brain = EachRun::new(make(&body).unwrap(), |body| make(body).ok());
    let mut at = |seconds: u64, x_m: f64| {
        let action = brain.step(&turn(&body, seconds * 1_000_000_000, &[Some(&[x_m, 0.0, 0.0])]));
        action.signals.map(|signals| signals.left > 0.0)
    };
    assert_eq!(
        [at(1, 0.0), at(2, 1.0), at(3, 0.0)],
        [Some(true), Some(false), Some(false)],
        "it had arrived"
    );
    assert_eq!(at(0, 0.0), Some(true), "and goes again");
}

#[test]
fn after_a_reset_of_the_world_no_brain_waits_for_what_was() {
    let body = body(&[
        ("odometer", "odometer", 0.0),
        ("eye", "ir", 0.0),
        ("nose", "field", 0.0),
        ("laser", "laser", 0.0),
    ]);
    for name in KINDS.iter().map(|kind| kind.entry.name) {
        let mut brain = catalogue::brain(name, 1, &body).unwrap();
        assert!(commands(&mut brain, &body, 1_000_000_000), "{name}");
        commands(&mut brain, &body, 100_000_000_000);
        assert!(commands(&mut brain, &body, 0), "{name} stands still after a reset");
    }
}
