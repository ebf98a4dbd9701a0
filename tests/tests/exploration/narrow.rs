//! `explore` with bodies of other sizes, and in passages that are hardly wider than the body: samples of the table that
//! `cargo run -p baudbot-tests --example explore_narrow` runs (docs/architecture/testing.md).

use baudbot_tests::narrow::{Case, Outcome, Shape};

fn run(case: Case) -> Outcome {
    let run = case.run(600.0);
    println!("{}: {run:?}", case.name());
    run
}

fn explore(shape: Shape, body_m: f64, times: f64, by_frontiers: bool) {
    let case = Case { shape, body_m, times, seed: 1, by_frontiers };
    let run = run(case);
    assert_eq!(run.problem(), None, "{}: {run:?}", case.name());
}

/// Near objects followed no body, and so a small one never entered a corridor of less than twice its width.
#[test]
fn a_robot_of_0_2_m_gets_through_corridors_and_doors_of_one_and_a_half_times_its_width() {
    explore(Shape::Straight, 0.2, 1.7, false);
    explore(Shape::Serpentine, 0.2, 1.7, true);
    explore(Shape::Rooms, 0.2, 1.5, true);
}

#[test]
fn a_robot_of_0_1_m_and_one_of_0_6_m_explore_as_one_of_0_4_m_does() {
    explore(Shape::Zigzag, 0.1, 1.7, true);
    explore(Shape::Comb, 0.6, 1.4, true);
}

/// The robot may come askew to a door between two nodes, whose posts it does not touch.
#[test]
fn no_post_of_a_door_is_touched_by_nodes() {
    explore(Shape::Rooms, 0.4, 1.4, false);
    explore(Shape::CornerDoors, 0.4, 1.4, false);
}

/// A zigzag of one and a half times the width, in which it went to and fro for ever.
#[test]
fn who_does_not_get_on_ends_and_says_so() {
    explore(Shape::Zigzag, 0.4, 1.5, false);
    explore(Shape::Zigzag, 0.4, 1.5, true);
}

#[test]
fn nobody_who_walks_is_run_into() {
    explore(Shape::People, 0.4, 1.0, false);
    explore(Shape::People, 0.4, 1.0, true);
}

const ROWS: &str = include_str!("../../data/exploration/rows.toml");
const ZIGZAG: &str = include_str!("../../data/exploration/zigzag.toml");

/// Rooms with doors of 0.55 m, of which one was entered askew.
#[test]
fn doors_are_entered_straight_or_not() {
    super::check_seed(ROWS, super::NODES, 1);
}

/// A zigzag of 0.6 m, in which the robot went to and fro for ever.
#[test]
fn a_zigzag_is_explored_to_its_ends() {
    super::check_seed(ZIGZAG, super::NODES, 1);
    super::check_seed(ZIGZAG, super::FRONTIERS, 2);
}
