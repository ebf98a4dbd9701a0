//! Rounds of `loop()`, with and without an optimiser that puts it into `main`.

use baudbot_avr::{Pin, Port};
use baudbot_board::{Edge, Level, Seen, Wiring};

use crate::sketches::bench::{MS, bench};

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn rounds_of_loop_are_those_that_a_sketch_marks_with_and_without_link_time_optimisation() {
    for file in ["rounds.hex", "rounds_no_lto.hex"] {
        let mut bench = bench(file, Wiring::builder());
        bench.board.keep_edges(Some(0));
        for ms in 1..=3000 {
            bench.board.run_until(ms * MS, &mut bench.world);
        }
        let edges: Vec<Edge> = bench.board.edges().unwrap().since(0).1.copied().collect();
        // `setup` has taken 250 ms.
        let late = |edge: &&Edge| edge.at_ns > 500 * MS;
        let is_mark = |seen| matches!(seen, Seen::Level { pin, level: Level::Low | Level::High, .. } if Some(pin) == Pin::new(Port::B, 5));
        let marks: Vec<u64> =
            edges.iter().filter(late).filter(|edge| is_mark(edge.seen)).map(|edge| edge.at_ns).collect();
        let begins: Vec<u64> = edges
            .iter()
            .filter(late)
            .filter(|edge| matches!(edge.seen, Seen::Round(_)))
            .map(|edge| edge.at_ns)
            .collect();
        assert!(
            marks.len().abs_diff(begins.len()) <= 1 && marks.len() > 1000,
            "{file}: {} {}",
            marks.len(),
            begins.len()
        );
        for pair in begins.windows(2) {
            let within = marks.iter().filter(|mark| (pair[0]..pair[1]).contains(mark)).count();
            assert_eq!(within, 1, "{file}: {} to {}", pair[0], pair[1]);
        }
        // Three conversions of 13 periods of 128 cycles, and in every other round a millisecond.
        let rounds = bench.board.rounds().unwrap();
        assert!((5000..8000).contains(&rounds.least()), "{file}: {rounds:?}");
        assert!((16_000..40_000).contains(&rounds.most()), "{file}: {rounds:?}");
    }
}
