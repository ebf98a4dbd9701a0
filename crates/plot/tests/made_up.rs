//! A trace of made-up events as a file, which `xtask/tools/check_trace.py` reads with Perfetto's own schema.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use baudbot_plot::trace::TraceWriter;
use baudbot_sim::SimTime;
use baudbot_sim::timeline::{Event, What};

#[test]
fn a_trace_for_perfettos_own_schema() {
    let scenario = baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/wander.toml")).unwrap();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("made-up.pftrace");
    let out = BufWriter::new(File::create(&path).unwrap());
    let mut writer = TraceWriter::new(out, "made up", &scenario.robots).unwrap();
    for cycle in 0..50 {
        events(20_000 * cycle).iter().for_each(|event| writer.event(0, event).unwrap());
    }
    writer.lost(0, 3).unwrap();
    writer.finish().unwrap();
    assert!(path.metadata().unwrap().len() > 50 * 20 * 20);
}

/// A cycle with all that can happen, from this microsecond on; commands overlap.
fn events(start_us: u64) -> Vec<Event> {
    let spans = [
        (0, 1000, What::Acquire { sensor: 0 }),
        (1000, 2000, What::Acquire { sensor: 1 }),
        (0, 12_000, What::Measure { sensor: 2 }),
        (2000, 2500, What::Frame { bytes: 9 }),
        (2500, 4000, What::Block),
        (2500, 11_500, What::Up { bytes: 9 }),
        (11_500, 12_000, What::Adapter),
        (2000, 30_000, What::Port { sensor: 2, bytes: 99 }),
        (12_000, 15_000, What::Think { informed: cycle_is_even(start_us) }),
        (15_000, 37_000, What::Down { bytes: 6 }),
        (36_900, 37_100, What::Obey),
        (37_100, 37_100, What::Act),
        (37_100, 37_100, What::Late),
        (13_000, 13_000, What::Missed { sensor: 1 }),
        (14_000, 14_000, What::Missed { sensor: u16::MAX }),
        (20_000, 20_000, What::Lost { bytes: 2 }),
        (18_000, 19_000, What::Fault { fault: 0 }),
    ];
    let at = |us: u64| SimTime::from_ns((start_us + us) * 1000);
    spans.map(|(start, end, what)| Event { start: at(start), end: at(end), what }).to_vec()
}

fn cycle_is_even(start_us: u64) -> bool {
    start_us.is_multiple_of(40_000)
}
