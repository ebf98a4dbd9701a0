//! Sensors that brains need together, and that a robot's cable brings too far apart. The world knows no brains, and brains no
//! world; here both are known.

use std::collections::BTreeSet;

use baudbot_brains::catalogue::catalogue;
use baudbot_plot::quantity::duration;
use baudbot_scenario::budget::{Budget, RobotBudget};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Sensor;

use crate::robot_groups;

/// The warnings for the robots of a scenario: the name of each with a sentence.
pub(crate) fn all_warnings(scenario: &Scenario) -> Vec<(&str, String)> {
    let robots = robot_groups::first_of_each(&scenario.robots).into_iter().map(|(robot, _)| robot);
    // The bytes of a program of the user's own are not known beforehand.
    let robots = robots.filter(|robot| robot.chip.is_none());
    // A budget takes a while: only of those with sensors that some brain needs together.
    let robots: Vec<_> = robots.filter(|robot| wanted().any(|kinds| has_both(robot, kinds))).collect();
    let budget = Budget::of_some(scenario, robots.iter().copied());
    let mut told = Vec::new();
    for robot in robots {
        let budget = budget.robots.iter().find(|budget| budget.robot == robot.name);
        let warnings = budget.map_or_else(Vec::new, |budget| warnings(robot, budget));
        told.extend(warnings.into_iter().map(|warning| (robot.name.as_str(), warning)));
    }
    told
}

/// The warnings for a robot with this budget, a sentence each.
pub(crate) fn warnings(spec: &RobotSpec, budget: &RobotBudget) -> Vec<String> {
    wanted().filter(|kinds| has_both(spec, *kinds)).filter_map(|kinds| warning(kinds, spec, budget)).collect()
}

/// The kinds of sensors that some brain needs together.
fn wanted() -> impl Iterator<Item = [&'static str; 2]> {
    let all: BTreeSet<_> = catalogue().iter().filter_map(|entry| entry.together).collect();
    all.into_iter()
}

fn of_kind<'a>(spec: &'a RobotSpec, kind: &'a str) -> impl Iterator<Item = &'a Sensor> {
    spec.sensors.iter().filter(move |sensor| sensor.device.kind() == kind)
}

fn has_both(spec: &RobotSpec, kinds: [&str; 2]) -> bool {
    kinds.iter().all(|kind| of_kind(spec, kind).next().is_some())
}

/// A warning that readings of the second kind are older when they come than those of the first, and older than the time
/// from one of these to the next.
fn warning(
    [kind, kind_of_late]: [&'static str; 2],
    spec: &RobotSpec,
    budget: &RobotBudget,
) -> Option<String> {
    let age_ns = |sensor: &Sensor| {
        budget.ages.iter().find(|age| age.sensor == sensor.name).and_then(|age| age.span.typical_ns)
    };
    let late = of_kind(spec, kind_of_late).max_by_key(|sensor| age_ns(sensor))?;
    let late_ns = age_ns(late)?;
    let is_held_up = |sensor: &&Sensor| {
        period_ns(sensor) < late_ns && age_ns(sensor).is_some_and(|age_ns| age_ns < late_ns)
    };
    let held_up = of_kind(spec, kind).find(is_held_up)?;
    let (age, period) = (duration(late_ns as f64), duration(period_ns(held_up) as f64));
    let (late, held_up) = (&late.name, &held_up.name);
    let all = catalogue();
    let brains =
        all.iter().filter(|entry| entry.together == Some([kind, kind_of_late])).map(|entry| entry.name);
    let brains: Vec<_> = brains.collect();
    Some(format!(
        "`{late}` is {age} old when it arrives, and `{held_up}` has new data every {period}: brains that need both \
         together ({}) get both that late, and may drive more slowly",
        brains.join(", "),
    ))
}

/// The time from one measurement to the next, in nanoseconds.
fn period_ns(sensor: &Sensor) -> u64 {
    sensor.own_clock.map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns)
}

#[cfg(test)]
mod tests {
    use baudbot_scenario::Override;

    use super::*;

    const HALL: &str = include_str!("../../catalogue/scenarios/hall.toml");

    fn at_baud(baud: u32, others: &[&str]) -> Vec<String> {
        let baud = format!("robots.robot.link.baud={baud}");
        let changes = [baud.as_str()].into_iter().chain(others.iter().copied());
        let changes: Vec<_> = changes.map(|text| Override::parse(text).unwrap()).collect();
        let scenario = baudbot_scenario::parse_with(HALL, &changes).unwrap();
        all_warnings(&scenario).into_iter().map(|(robot, text)| format!("{robot}: {text}")).collect()
    }

    #[test]
    fn odometry_that_is_older_than_the_lasers_period_is_warned_of() {
        let [warning] = &at_baud(9600, &[])[..] else { panic!("one warning at 9600 baud") };
        let expected = "robot: `odometer` is 107.292 ms old when it arrives, and `laser` has new data every 100 ms: \
                        brains that need both together (errands, explore, hall, mower, tour) get both that late, and \
                        may drive more slowly";
        assert_eq!(warning, expected);
        assert_eq!(at_baud(4800, &[]).len(), 1);
        assert_eq!(at_baud(115_200, &[]), Vec::<String>::new());
        let slower = "robots.robot.sensors.laser.clock={ period_ms = 500.0 }";
        assert_eq!(at_baud(9600, &[slower]), Vec::<String>::new());
    }
}
