//! Whether a robot keeps its step, and what is to blame.

use alloc::format;
use alloc::string::{String, ToString};

use super::report::{Cycle, Load, Part, Row, Verdict};

/// The verdict and the bottleneck: what is overloaded, or takes longest.
pub(super) fn judge(deadline_ns: u64, cycle: &Cycle, loads: &[Load]) -> (Verdict, String) {
    let fullest = loads.iter().filter(|load| load.share > FULL).max_by(|a, b| a.share.total_cmp(&b.share));
    let verdict = match (cycle.total.typical_ns, cycle.total.worst_ns) {
        (Some(typical), _) if typical > deadline_ns => Verdict::Misses,
        (None, _) => Verdict::Misses,
        _ if fullest.is_some() => Verdict::Misses,
        (_, Some(worst)) if worst <= deadline_ns => Verdict::Keeps,
        _ => Verdict::Sometimes,
    };
    let longest = |row: &Row| (row.span.typical_ns, row.span.worst_ns.unwrap_or(u64::MAX));
    let longest = cycle.rows.iter().rev().max_by_key(|row| longest(row));
    let bottleneck = match (fullest, longest) {
        (Some(load), _) => format!("the {}", load.what),
        (None, Some(row)) if matches!(row.part, Part::WireUp | Part::Down) => {
            format!("the {}", row.part.phrase())
        }
        (None, Some(row)) => row.part.phrase().to_string(),
        (None, None) => String::new(),
    };
    (verdict, bottleneck)
}

/// Whether something has more to do than time.
pub(super) fn is_overloaded(loads: &[Load]) -> bool {
    loads.iter().any(|load| load.share > FULL)
}

/// More than this is overloaded; sums of fractions are not exact.
const FULL: f64 = 1.0 + 1e-9;
