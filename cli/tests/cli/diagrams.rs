//! `baudbot diagram`.

use crate::baudbot;

/// What a diagram that cannot be says on stderr; nothing else may be said.
fn refusal(args: &[&str]) -> String {
    let (code, out, err) = baudbot(&[&["diagram"], args].concat());
    assert_eq!((code, out.as_str()), (2, ""), "{err}");
    err
}

#[test]
fn what_is_not_there_cannot_be_shown() {
    let robot = refusal(&["wander", "--robot", "alice"]);
    assert_eq!(robot, "error: --robot: there is no robot `alice`; there are: robot\n");
    let brain = refusal(&["wander", "--brain", "genius"]);
    assert!(brain.contains("genius") && brain.lines().count() == 1, "{brain}");
    let sensors = refusal(&["wander", "--set", "robots.robot.body.mass_kg=0"]);
    assert_eq!(sensors, "error: wander: robots[0].body.mass_kg: must be positive, is 0\n");
}

#[test]
fn a_time_that_makes_no_sense_is_refused_with_its_range() {
    assert!(refusal(&["wander", "--at", "-1"]).contains("must be from 0 to 1000000, is -1"));
    assert!(refusal(&["wander", "--span", "0"]).contains("must be above 0 and at most 1000000, is 0"));
    for wrong in [["--at", "nan"], ["--at", "1e9"], ["--span", "inf"], ["--cycle", "0"], ["--cycle", "1.5"]] {
        assert!(refusal(&["wander", wrong[0], wrong[1]]).starts_with("error: invalid value"), "{wrong:?}");
    }
    assert!(refusal(&["wander", "--at", "1", "--cycle", "2"]).contains("cannot be used with"));
}
