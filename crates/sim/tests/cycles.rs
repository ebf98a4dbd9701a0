//! Control cycles: what they cost, whether they are kept, and what a late brain gets.

use crate::common::{BODY, command, world};
use baudbot_sim::robot::Exceptions;
use baudbot_sim::timeline::{Event, What};
use baudbot_sim::{Ending, Input, SimTime, World};

/// A robot with two sensors that take 0.3 ms each, one frame each tick of 20 ms, over 9600 baud 8N1.
fn robot(brain: &str, more: &str) -> String {
    format!(
        "step_ms = 20.0\nsubsteps = 20\nnoise = false\n[[robots]]\nname = \"r\"\n{BODY}\nbrain = {{ {brain} }}\nmotors = {{ signal_bits = 8 }}\n\
         microcontroller = {{ framing_us_per_byte = 10, receiving_us_per_byte = 5, obeying_us = 20 }}\n\
         firmware = {{ protocol = \"bare\", period_ms = 20.0, phase_ms = 1.0 }}\n\
         link = {{ kind = \"uart\", baud = 9600 }}\n{more}\n\
         [robots.sensors.a]\nkind = \"compass\"\nbits = 8\nacquisition_us = 300\nperiod_ms = 20.0\n\
         [robots.sensors.b]\nkind = \"compass\"\nbits = 8\nacquisition_us = 300\nperiod_ms = 20.0\n"
    )
}

/// Reading 0.6, framing 2 bytes 0.02, up 2 characters 25/12, down 2 characters 25/12, taking the last byte 0.005 and
/// obeying 0.02 ms.
const COST_NS: u64 = 600_000 + 20_000 + 2 * 2_083_334 + 5_000 + 20_000;

fn drive(world: &mut World, ticks: u64, answers: impl Fn(SimTime) -> bool) {
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let turns = turns.iter().filter(|turn| answers(turn.at));
        let answers: Vec<_> = turns.map(|turn| (turn.at, command(world.robot(0).spec(), 1.0, 1.0))).collect();
        let inputs: Vec<_> = answers.iter().map(|(at, bytes)| Input { robot: 0, at: *at, bytes }).collect();
        world.finish(&inputs);
    }
}

fn events(world: &World, wanted: fn(&What) -> bool) -> Vec<Event> {
    world.robot(0).timeline().events().filter(|event| wanted(&event.what)).copied().collect()
}

#[test]
fn a_cycle_costs_the_sum_of_its_boxes() {
    let mut world = world(&robot("", ""));
    drive(&mut world, 100, |_| true);
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late, cycles.unanswered), (100, 0, 0));
    assert_eq!((cycles.durations.min_ns(), cycles.durations.max_ns()), (Some(COST_NS), Some(COST_NS)));
}

#[test]
fn thinking_is_part_of_it_and_a_cycle_longer_than_the_step_is_late() {
    let mut world = world(&robot("thinking_us = 17000", ""));
    for _ in 0..100 {
        let turns = world.begin().to_vec();
        let bytes = command(world.robot(0).spec(), 1.0, 1.0);
        let input = |turn: &baudbot_sim::Turn| Input { robot: 0, at: turn.at + 17_000_000, bytes: &bytes };
        world.finish(&turns.iter().map(input).collect::<Vec<_>>());
    }
    let cycles = world.robot(0).cycles();
    assert!(cycles.kept == 0 && cycles.late >= 98, "{cycles:?}");
    assert_eq!(cycles.durations.quantile_ns(0.5), Some(COST_NS + 17_000_000));
    assert_eq!(cycles.kept_share(), Some(0.0));
}

#[test]
fn what_the_brain_leaves_unanswered_is_neither_kept_nor_late() {
    let mut world = world(&robot("", ""));
    drive(&mut world, 100, |at| at.as_ns() % 40_000_000 < 20_000_000);
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late, cycles.unanswered), (50, 0, 50));
}

#[test]
fn the_events_of_a_cycle_follow_each_other_without_a_gap() {
    let mut world = world(&robot("thinking_us = 1000", ""));
    let turn = world.begin()[0];
    let bytes = command(world.robot(0).spec(), 1.0, 1.0);
    world.finish(&[Input { robot: 0, at: turn.at + 1_000_000, bytes: &bytes }]);
    let mut found = events(&world, |what| !matches!(what, What::Acquire { .. }));
    found.sort_by_key(|event| event.start);
    let ns = |event: &Event| (event.start.as_ns(), event.end.as_ns());
    let wire_ns = 2_083_334;
    let mut at = 1_000_000;
    let mut next = |duration_ns| {
        at += duration_ns;
        (at - duration_ns, at)
    };
    let (frame, up, think, down) = (next(20_000), next(wire_ns), next(1_000_000), next(wire_ns));
    // The microcontroller takes the first byte as it arrives, while the second is on its way.
    let obey = (down.1 - wire_ns / 2, down.1 + 25_000);
    let act = (7_000_000, 7_000_000);
    assert_eq!(found.iter().map(ns).collect::<Vec<_>>(), [frame, up, think, down, obey, act]);
    assert_eq!(found[0].what, What::Frame { bytes: 2 });
    assert_eq!(found[2].what, What::Think { informed: true });
}

#[test]
fn a_world_without_a_timeline_makes_the_same_run() {
    let [mut with, mut without] = [(), ()].map(|()| world(&robot("deadline_ms = 3", "")));
    without.keep_timeline(0);
    drive(&mut with, 50, |_| true);
    drive(&mut without, 50, |_| true);
    assert!(with.robot(0).timeline().events().count() > 300);
    assert_eq!(without.robot(0).timeline().events().count(), 0);
    assert_eq!(with.hash(), without.hash());
}

#[test]
fn a_silent_brain_is_late_where_a_deadline_is_stated_and_its_old_command_is_held() {
    let mut world = world(&robot("deadline_ms = 10", ""));
    drive(&mut world, 50, |at| at.as_ns() < 500_000_000);
    let robot = world.robot(0);
    let cycles = robot.cycles();
    assert_eq!((cycles.kept, cycles.unanswered), (25, 0));
    assert!((24..=25).contains(&cycles.late), "{cycles:?}");
    assert_eq!((robot.signals().left, robot.signals().right), (1.0, 1.0));
    let late = events(&world, |what| *what == What::Late);
    assert_eq!(late[0].start.as_ns(), 500_000_000 + 400_000 + 10_000_000);
}

#[test]
fn motors_stop_at_the_deadline_and_go_on_with_the_next_command() {
    let mut world = world(&robot("deadline_ms = 10, on_late = \"stop\"", ""));
    let silent = |at: SimTime| (500_000_000..700_000_000).contains(&at.as_ns());
    drive(&mut world, 26, |at| !silent(at));
    assert_eq!(world.robot(0).signals().left, 0.0);
    drive(&mut world, 9, |at| !silent(at));
    assert_eq!(world.robot(0).signals().left, 0.0);
    drive(&mut world, 1, |at| !silent(at));
    assert_eq!(world.robot(0).signals().left, 1.0);
}

#[test]
fn a_command_that_comes_after_the_deadline_counts_as_late_once_and_is_obeyed() {
    // The command is there 4.812 ms after the cycle began.
    let mut world = world(&robot("deadline_ms = 3, on_late = \"stop\"", ""));
    drive(&mut world, 10, |_| true);
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late, cycles.durations.count()), (0, 10, 10));
    assert_eq!(events(&world, |what| *what == What::Late).len(), 10);
    assert_eq!(world.robot(0).signals().left, 1.0, "the late command is in force");
}

#[test]
fn a_run_ends_with_the_first_miss_if_the_scenario_says_so() {
    let mut world = world(&robot("deadline_ms = 10, on_late = \"end\"", ""));
    drive(&mut world, 100, |at| at.as_ns() < 300_000_000);
    assert_eq!(world.ending(), Some(&Ending::DeadlineMissed("r".into())));
    assert_eq!(world.tick(), 16);
    assert_eq!(world.ending().unwrap().to_string(), "the brain of `r` missed its deadline");
}

#[test]
fn a_snapshot_goes_back_to_its_cycles() {
    let mut world = world(&robot("", ""));
    drive(&mut world, 10, |_| true);
    let mut copy = world.clone();
    drive(&mut world, 10, |_| true);
    drive(&mut copy, 10, |_| true);
    assert_eq!(world.hash(), copy.hash());
    assert_eq!(copy.robot(0).cycles().kept, 20);
}

/// Counted cycles, and messages that were framed.
fn accounts(world: &World) -> (u64, u64) {
    let cycles = world.robot(0).cycles();
    let framed = events(world, |what| matches!(what, What::Frame { .. })).len() as u64;
    (cycles.kept + cycles.late + cycles.unanswered + cycles.under_way(), framed)
}

#[test]
fn every_message_is_counted_once_however_often_they_come_and_whatever_is_answered() {
    for period_ms in [1, 2, 7, 20, 50] {
        for deadline in ["", "deadline_ms = 3", "deadline_ms = 100, on_late = \"stop\""] {
            for link in ["baud = 9600", "baud = 115200", "baud = 1200, adapter = { kind = \"bluetooth\" }"] {
                let toml = robot(deadline, "")
                    .replace("period_ms = 20.0, phase", &format!("period_ms = {period_ms}, phase"));
                let mut world = world(&toml.replace("baud = 9600", link));
                world.keep_timeline(100_000);
                drive(&mut world, 100, |at| at.as_ns() % 3 != 0);
                let (counted, framed) = accounts(&world);
                assert_eq!(
                    counted,
                    framed,
                    "{period_ms} ms, {deadline}, {link}: {:?}",
                    world.robot(0).cycles()
                );
                let cycles = world.robot(0).cycles();
                assert!(cycles.durations.count() <= cycles.kept + cycles.late, "{cycles:?}");
            }
        }
    }
}

#[test]
fn a_silent_brain_is_late_however_many_messages_are_under_way() {
    let toml = robot("deadline_ms = 100, on_late = \"end\"", "")
        .replace("period_ms = 20.0, phase", "period_ms = 1.0, phase");
    let mut world = world(&toml);
    drive(&mut world, 100, |_| false);
    assert_eq!(world.ending(), Some(&Ending::DeadlineMissed("r".into())));
    assert!((100..=140).contains(&(world.time().as_ns() / 1_000_000)), "{}", world.time());
}

#[test]
fn a_run_does_not_end_before_the_deadline_is_over() {
    let toml =
        robot("deadline_ms = 45, on_late = \"end\"", "").replace("obeying_us = 20", "obeying_us = 60000");
    let mut world = world(&toml);
    drive(&mut world, 100, |_| true);
    assert_eq!(world.ending(), Some(&Ending::DeadlineMissed("r".into())));
    assert!(world.time().as_ns() >= 45_000_000, "{}", world.time());
    assert_eq!(events(&world, |what| *what == What::Late)[0].start.as_ns(), 400_000 + 45_000_000);
}

#[test]
fn an_old_command_does_not_start_motors_that_were_stopped_after_it() {
    // One substep a tick: what was obeyed in the last tick and what was late in it are found at the same time.
    let toml = robot("deadline_ms = 4.7, on_late = \"stop\"", "").replace("substeps = 20", "substeps = 1");
    let mut world = world(&toml.replace("period_ms = 20.0, phase", "period_ms = 10.0, phase"));
    drive(&mut world, 50, |_| true);
    // The second message of a tick finds its brain done with it, and is late.
    let robot = world.robot(0);
    assert!(robot.cycles().late >= 49, "{:?}", robot.cycles());
    assert_eq!(robot.signals().left, 0.0);
}

#[test]
fn a_command_in_two_pieces_answers_the_same_message() {
    let mut world = world(&robot("", ""));
    for _ in 0..50 {
        let turns = world.begin().to_vec();
        let bytes = command(world.robot(0).spec(), 1.0, 1.0);
        let (first, second) = bytes.split_at(1);
        let input = |bytes| Input { robot: 0, at: turns[0].at, bytes };
        world.finish(&[input(first), input(second)]);
    }
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late, cycles.unanswered), (50, 0, 0));
}

#[test]
fn two_commands_in_one_write_answer_one_message() {
    let mut world = world(&robot("", ""));
    for _ in 0..50 {
        let turns = world.begin().to_vec();
        let bytes =
            [command(world.robot(0).spec(), 1.0, 1.0), command(world.robot(0).spec(), 0.0, 0.0)].concat();
        world.finish(&[Input { robot: 0, at: turns[0].at, bytes: &bytes }]);
    }
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late, cycles.unanswered), (50, 0, 0));
    assert_eq!(cycles.durations.max_ns(), Some(COST_NS));
}

#[test]
fn an_answer_that_comes_a_tick_late_is_late() {
    let mut world = world(&robot("", ""));
    let mut last = None;
    for tick in 0..50 {
        let turns = world.begin().to_vec();
        let bytes = command(world.robot(0).spec(), 1.0, 1.0);
        // As a server in real time does: what comes now answers the last Turn, and is handed over now.
        if let Some(answered) = last.replace(tick) {
            world.answers(0, answered);
        }
        let bytes: &[u8] = if tick == 0 { &[] } else { &bytes };
        world.finish(&[Input { robot: 0, at: turns[0].at, bytes }]);
    }
    let cycles = world.robot(0).cycles();
    assert_eq!((cycles.kept, cycles.late), (0, 49));
    assert_eq!(cycles.durations.min_ns(), Some(COST_NS + 20_000_000));
}

/// A brain that writes twice in a turn, or in turns without a message, writes as `writes` states, or is counted.
#[test]
fn writes_that_nobody_stated_are_counted_with_the_cycles_that_they_disturb() {
    // Two ticks for a message: every other step has none.
    let toml = |writes: &str| robot(writes, "").replace("step_ms = 20.0", "step_ms = 10.0");
    let run = |writes: &str, commands: usize, on_message: bool| {
        let mut world = world(&toml(writes));
        for _ in 0..100 {
            let turn = world.begin()[0];
            let bytes = command(world.robot(0).spec(), 1.0, 1.0).repeat(commands);
            let is_silent = on_message && !world.robot(0).readings()[0].readable;
            let bytes = if is_silent { &[][..] } else { &bytes[..] };
            world.finish(&[Input { robot: 0, at: turn.at, bytes }]);
        }
        let cycles = world.robot(0).cycles();
        (cycles.exceptions, cycles.durations.count())
    };
    let none = Exceptions::default();
    assert_eq!(run("", 1, true), (none, 50));
    assert_eq!(run("writes = \"every-tick\"", 1, false), (none, 50));
    assert_eq!(run("writes = \"when-free\"", 1, false), (none, 50));
    assert_eq!(run("writes = \"200-per-s\"", 2, false), (none, 50));
    // Each second step has no message, and what is written in it is gone when the next is answered.
    let (unasked, cycles) = run("", 1, false);
    assert_eq!((unasked.writes, cycles), (50, 50));
    assert!(unasked.cycles >= 49, "{unasked:?}");
    assert_eq!(run("writes = \"every-tick\"", 2, true), (Exceptions { writes: 50, cycles: 50 }, 50));
    // Ten times too often: only the first is as stated, and it answers the first message.
    assert_eq!(run("writes = \"10-per-s\"", 1, false), (Exceptions { writes: 99, cycles: 49 }, 50));
}
