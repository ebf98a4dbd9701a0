//! One cycle as lanes on a time axis: the timing diagram of Fig. 3.2.

use baudbot_sim::budget::{Part, RobotBudget};

/// A line of the diagram.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lane {
    /// What does something there.
    pub(crate) label: &'static str,
    /// What it does, and when.
    pub(crate) bars: Vec<Bar>,
}

/// Something that takes its time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bar {
    /// From the beginning of the cycle, in nanoseconds.
    pub(crate) start_ns: u64,
    pub(crate) end_ns: u64,
    pub(crate) text: String,
    /// `late` beyond Δt, else `busy` or `waits`.
    pub(crate) class: &'static str,
}

/// The typical cycle, part after part; none if no cycle is ever completed. What reaches beyond Δt is a bar of its own.
pub(crate) fn lanes(budget: &RobotBudget) -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    let mut now = 0;
    for row in &budget.cycle.rows {
        let Some(ns) = row.span.typical_ns else { return Vec::new() };
        let end = now + ns;
        let edge = budget.step_ns.clamp(now, end);
        let bar =
            |start_ns, end_ns, class| Bar { start_ns, end_ns, text: row.part.phrase().to_owned(), class };
        let (label, class) = place(row.part);
        let bars = [bar(now, edge, class), bar(edge, end, "late")];
        let bars = bars.into_iter().filter(|bar| bar.end_ns > bar.start_ns);
        match lanes.iter_mut().find(|lane| lane.label == label) {
            Some(lane) => lane.bars.extend(bars),
            None => lanes.push(Lane { label, bars: bars.collect() }),
        }
        now = end;
    }
    lanes
}

/// The lane of a part, and its class.
fn place(part: Part) -> (&'static str, &'static str) {
    match part {
        Part::Acquisition => ("sensors", "busy"),
        Part::Framing | Part::Obeying => ("processor", "busy"),
        Part::WireUp => ("wire up", "busy"),
        Part::WaitUp => ("adapter", "waits"),
        Part::Step => ("brain", "waits"),
        Part::Thinking => ("brain", "busy"),
        Part::Down => ("wire down", "busy"),
        Part::Actuation => ("actuation", "waits"),
    }
}

#[cfg(test)]
mod tests {
    use baudbot_sim::Scenario;
    use baudbot_sim::budget::Budget;

    use super::*;

    #[test]
    fn a_cycle_that_is_too_long_is_late_from_the_step_on() {
        let scenario = Scenario::parse(include_str!("../../../scenarios/wander.toml")).unwrap();
        let robot = Budget::of(&scenario).robots.remove(0);
        let lanes = lanes(&robot);
        let bars: Vec<_> = lanes.iter().flat_map(|lane| &lane.bars).collect();
        let all: u64 = bars.iter().map(|bar| bar.end_ns - bar.start_ns).sum();
        assert_eq!(Some(all), robot.cycle.total.typical_ns);
        assert!(bars.iter().all(|bar| (bar.class == "late") == (bar.start_ns >= robot.step_ns)), "{bars:?}");
        let labels: Vec<_> = lanes.iter().map(|lane| lane.label).collect();
        assert_eq!(labels[..3], ["sensors", "processor", "wire up"]);
    }
}
