//! Robots that are alike: one table with several `starts` is as many robots, and the same as if each were written out.

use std::sync::Arc;

use crate::common::{BODY, refusal, run, world};
use baudbot_scenario::Override;
use baudbot_scenario::budget::Budget;
use baudbot_sim::World;

/// The devices of the robots of these tests, with noise and chance of their own.
const PARTS: &str = "\
    link = { kind = \"uart\", baud = 9600 }\n\
    faults = [{ kind = \"byte-errors\", every_s = 0.3, for_s = 0.1, byte_error_rate = 0.2 }]\n\
    [robots.sensors.z]\nkind = \"odometer\"\nsigma_m = 0.01\nbits = 8\nperiod_ms = 50.0\n\
    [robots.sensors.a]\nkind = \"compass\"\nsigma_rad = 0.1\nbits = 8\nperiod_ms = 50.0\n";

const STARTS: &str = "{ x_m = 0.5, y_m = -1.0, heading_rad = 1.0 }, { name = \"bob\", x_m = 2.0 }, \
                      { y_m = 3.0, speed_m_s = 0.1 }";

fn several(starts: &str) -> String {
    format!("[[robots]]\nname = \"ann\"\nstarts = [{starts}]\n{BODY}\n{PARTS}")
}

fn one(name: &str, start: &str) -> String {
    format!("[[robots]]\nname = \"{name}\"\nstart = {{ {start} }}\n{BODY}\n{PARTS}")
}

#[test]
fn several_starts_are_the_world_of_robots_written_out() {
    let written_out = one("ann-1", "x_m = 0.5, y_m = -1.0, heading_rad = 1.0")
        + &one("bob", "x_m = 2.0")
        + &one("ann-3", "y_m = 3.0, speed_m_s = 0.1");
    let (mut short, mut long) = (world(&several(STARTS)), world(&written_out));
    let names: Vec<_> = short.scenario().robots.iter().map(|robot| robot.name.as_str()).collect();
    assert_eq!(names, ["ann-1", "ann-3", "bob"]);
    assert_eq!(short.hash(), long.hash(), "at the start");
    run(&mut short, 100, 0.3, 0.5);
    run(&mut long, 100, 0.3, 0.5);
    assert_eq!(short.hash(), long.hash(), "after a second");
}

#[test]
fn those_that_are_alike_share_what_they_are() {
    let scenario = baudbot_scenario::parse(&several(STARTS).replace("faults", "#faults")).unwrap();
    let [first, second, third] = scenario.robots.as_slice() else { panic!("there are three") };
    assert!(Arc::ptr_eq(&first.model, &second.model) && Arc::ptr_eq(&first.model, &third.model));
    assert_eq!((first.table_name(), third.table_name()), ("ann", "ann"));
}

#[test]
fn a_preset_says_what_starts_leave_out() {
    let text = "[[robots]]\nname = \"ann\"\npreset = \"arsim\"\n\
                starts = [{ x_m = 1.0 }, { x_m = 2.0, wheels_at_rest = false }]";
    let scenario = baudbot_scenario::parse(text).unwrap();
    let at_rest: Vec<_> = scenario.robots.iter().map(|robot| robot.start.wheels_at_rest).collect();
    assert_eq!(at_rest, [true, false]);
}

#[test]
fn starts_may_be_tables_of_their_own() {
    let text = format!("[[robots]]\nname = \"ann\"\n{BODY}\n[[robots.starts]]\n[[robots.starts]]\nx_m = 1.0");
    assert_eq!(baudbot_scenario::parse(&text).unwrap().robots.len(), 2);
}

#[test]
fn what_is_wrong_is_named() {
    let refused = |starts: &str, error: &str| {
        let message = refusal(&several(starts));
        assert!(message.starts_with(error), "expected `{error}` in: {message}");
    };
    refused("", "robots[0].starts: is empty");
    refused("{}, { x_m = true }", "robots[0].starts[1].x_m: must be a number, is true");
    refused("{}, { x_m = 1e7 }", "robots[0].starts[1].x_m: must be between");
    refused("{}, { x_cm = 1 }", "robots[0].starts[1].x_cm: unknown field");
    refused("{}, { name = \"ann-1\", x_m = 2 }", "robots[0].starts[1].name: `ann-1` is taken");
    refused("{}, { name = \"ann\", x_m = 2 }", "robots[0].starts[1].name: `ann` is taken");
    refused("{}, { name = \"a b\", x_m = 2 }", "robots[0].starts[1].name: must be 1 to 64");
    refused("{}, { x_m = 9 }, { x_m = 0.1 }", "robots[0].starts[2]: stands in robots[0].starts[0] (`ann-1`)");
    let many = format!("{} {{}}", "{},".repeat(10_000));
    refused(&many, "robots: there are 10001, the limit is 10000");
    let message = refusal(&several("{}").replace("starts", "start = { x_m = 1 }\nstarts"));
    assert_eq!(message, "robots[0].start: give either this or `starts`");
    let message = refusal(&one("ann", "name = \"bob\""));
    assert!(message.starts_with("robots[0].start.name: only one of several `starts`"), "{message}");
    let message = refusal(&(several("{}") + &one("ann-1", "x_m = 5")));
    assert!(message.starts_with("robots[1].name: `ann-1` is taken"), "{message}");
}

#[test]
fn an_override_is_for_all_of_them_or_for_one_start() {
    let parse =
        |text: &str| baudbot_scenario::parse_with(&several(STARTS), &[Override::parse(text).unwrap()]);
    let scenario = parse("robots.ann.body.radius_m=0.1").unwrap();
    assert!(scenario.robots.iter().all(|robot| robot.drive.radius_m == 0.1));
    for path in ["robots.ann.starts[2].x_m=7", "robots.ann.starts.2.x_m=7", "robots[0].starts[2].x_m=7"] {
        assert_eq!(parse(path).unwrap().robots[1].start.pose.position.x, 7.0, "{path}");
    }
    assert_eq!(parse("robots.ann.starts.bob.x_m=7").unwrap().robots[2].start.pose.position.x, 7.0);
    for (name, robot) in [("ann-3", 1), ("bob", 2)] {
        let scenario = parse(&format!("robots.{name}.start.x_m=7")).unwrap();
        let moved: Vec<_> = scenario.robots.iter().map(|robot| robot.start.pose.position.x == 7.0).collect();
        assert_eq!(moved, (0..3).map(|i| i == robot).collect::<Vec<_>>(), "{name}");
    }
    for (name, i) in [("ann-3", 2), ("bob", 1)] {
        let message = parse(&format!("robots.{name}.link.baud=7")).unwrap_err().to_string();
        assert_eq!(
            message,
            format!(
                "robots.{name}: is one of several in `ann`, which are identical: change robots.ann.FIELD for all of \
                 them, or robots.ann.starts[{i}].FIELD for how this one starts"
            )
        );
    }
    let message = parse("robots.ann-2.start.x_m=7").unwrap_err().to_string();
    assert_eq!(message, "robots.ann-2: there is no such element; there are: ann");
}

#[test]
fn what_would_mend_one_is_said_of_their_table() {
    let scenario = baudbot_scenario::parse(&several(STARTS)).unwrap();
    let slow = Override::parse("robots.ann.link.baud=300").unwrap();
    let slow = baudbot_scenario::parse_with(&several(STARTS), &[slow]).unwrap();
    let budget = Budget::of(&slow);
    let overrides: Vec<_> = budget.robots[2].remedies.iter().flat_map(|remedy| &remedy.overrides).collect();
    assert!(overrides.iter().any(|text| text.starts_with("robots.ann.")), "{overrides:?}");
    for text in overrides {
        baudbot_scenario::parse_with(&several(STARTS), &[Override::parse(text).unwrap()]).unwrap();
    }
    assert_eq!(World::new(scenario.into()).robots().count(), 3);
}

#[test]
fn thousands_that_stand_free_are_soon_checked() {
    let starts: String =
        (0..10_000).map(|i| format!("{{ x_m = {}, y_m = {} }},", i % 100, i / 100)).collect();
    let text = format!("[[robots]]\nname = \"ann\"\nstarts = [{starts}]\n{BODY}");
    assert_eq!(baudbot_scenario::parse(&text).unwrap().robots.len(), 10_000);
}
