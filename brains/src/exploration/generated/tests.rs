//! Generated arenas, explored by a robot that knows where it is. All that can be seen from where it can get to is to be
//! seen. `tests/tests/exploration/mod.rs` has the same with bodies, cables and a laser that sweeps.

use super::*;
use crate::exploration::arena::{Arena, Run};
use crate::exploration::{Explorer, Frontiers, Nodes, frontiers, nodes};

fn arena(number: u64) -> Arena {
    let Plan { size_m, walls, boxes, .. } = Plan::generate(number);
    Arena::new(size_m, &walls, boxes, vec![])
}

/// Explores arenas from a start each, and returns which ended badly.
fn explore<E: Explorer>(numbers: std::ops::Range<u64>, new: impl Fn() -> E) -> Vec<(u64, Run)> {
    let run = |number| {
        let arena = arena(number);
        let start = arena.starts(1)[0];
        (number, arena.run_for(&mut new(), start, arena.visible_from(start.position), |_| {}))
    };
    let runs: Vec<_> = numbers.map(run).collect();
    let way: f64 = runs.iter().map(|(_, run)| run.path_m).sum();
    let least = runs.iter().map(|(_, run)| run.sensed).fold(1.0, f64::min);
    println!("{} arenas, {way} m, least sensed {least}", runs.len());
    let is_bad = |run: &Run| !run.has_seen_all() || run.sensed < 0.995 || run.least_room_m <= 0.0;
    runs.into_iter().filter(|(_, run)| is_bad(run)).collect()
}

fn by_nodes() -> Nodes {
    Nodes::new(nodes::Parameters::default())
}

fn by_frontiers() -> Frontiers {
    Frontiers::new(frontiers::Parameters::default())
}

#[test]
fn three_generated_arenas_are_seen_by_nodes() {
    let bad = explore(0..3, by_nodes);
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
fn three_generated_arenas_are_seen_by_frontiers() {
    let bad = explore(0..3, by_frontiers);
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
#[ignore = "half a minute; the same with 3 arenas always"]
fn sixty_generated_arenas_are_seen_by_nodes() {
    let bad = explore(0..60, by_nodes);
    assert!(bad.is_empty(), "{}: {bad:?}", bad.len());
}

#[test]
#[ignore = "a minute; the same with 3 arenas always"]
fn sixty_generated_arenas_are_seen_by_frontiers() {
    let bad = explore(0..60, by_frontiers);
    assert!(bad.is_empty(), "{}: {bad:?}", bad.len());
}
