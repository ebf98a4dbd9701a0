//! One typical cycle as the timing diagram of Fig. 3.2: its parts one after the other.

use baudbot_plot::quantity::duration;
use baudbot_plot::timing::{Bar, Class, Diagram, Group, Lane, Mark};
use baudbot_scenario::budget::{Part, RobotBudget, Verdict};

/// The diagram of a robot's typical cycle; `None` if no cycle is ever completed.
pub(crate) fn diagram(world: &str, budget: &RobotBudget) -> Option<Diagram> {
    let total_ns = budget.cycle.total.typical_ns?;
    let deadline_ns = budget.deadline_ns;
    let verdict = match budget.verdict {
        Verdict::Keeps => "meets its deadline",
        Verdict::Sometimes => "mostly meets its deadline",
        Verdict::Misses => "misses its deadline",
    };
    let end_ns = total_ns.max(deadline_ns).max(budget.step_ns);
    let is_late = total_ns > deadline_ns;
    let mut marks = vec![Mark { at_ns: total_ns, label: "obeyed".to_owned() }];
    marks.extend(is_late.then(|| Mark { at_ns: deadline_ns, label: "late".to_owned() }));
    Some(Diagram {
        title: format!("{} in {world}: the budget of a cycle", budget.robot),
        subtitle: format!(
            "Typically {}, from the first read to the command obeyed: it {verdict} of {}. Bottleneck: {}.",
            duration(total_ns as f64),
            duration(deadline_ns as f64),
            budget.bottleneck
        ),
        ran: Vec::new(),
        lanes: lanes(budget)?,
        from_ns: 0,
        // A bit more, so that its end is seen.
        until_ns: end_ns + end_ns / 20 + 1,
        step_ns: budget.step_ns,
        marks,
        late_from_ns: is_late.then_some(deadline_ns),
    })
}

/// The typical cycle, part after part.
fn lanes(budget: &RobotBudget) -> Option<Vec<Lane>> {
    let mut lanes: Vec<Lane> = Vec::new();
    let mut now = 0;
    for row in &budget.cycle.rows {
        let ns = row.span.typical_ns?;
        let (label, group, class) = place(row.part);
        let phrase = row.part.phrase();
        let title = format!("{phrase}: {}", duration(ns as f64));
        let bar = Bar {
            start_ns: now,
            end_ns: now + ns,
            label: duration(ns as f64),
            title,
            class,
            is_aside: false,
        };
        let bars = (ns > 0).then_some(bar);
        match lanes.iter_mut().find(|lane| lane.label == label) {
            Some(lane) => lane.bars.extend(bars),
            None => {
                let bars = bars.into_iter().collect();
                lanes.push(Lane { label: label.to_owned(), group, bars, wave: Vec::new() });
            }
        }
        now += ns;
    }
    Some(lanes)
}

/// The lane of a part, and what its bar stands for.
fn place(part: Part) -> (&'static str, Group, Class) {
    match part {
        Part::Acquisition => ("sensors", Group::Sensors, Class::Acquire),
        Part::Framing => ("microcontroller", Group::Microcontroller, Class::Frame),
        Part::Obeying => ("microcontroller", Group::Microcontroller, Class::Obey),
        Part::WireUp => ("cable up", Group::Up, Class::Up),
        Part::WaitUp => ("adapter, waiting", Group::Up, Class::Adapter),
        Part::Step => ("brain", Group::Brain, Class::Block),
        Part::Thinking => ("brain", Group::Brain, Class::Think),
        Part::Down => ("cable down", Group::Down, Class::Down),
        Part::Actuation => ("motors", Group::Motors, Class::Block),
    }
}

#[cfg(test)]
mod tests {
    use baudbot_scenario::budget::Budget;

    use super::*;

    #[test]
    fn the_parts_follow_each_other_without_a_gap_and_red_begins_at_the_deadline() {
        let scenario =
            baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/wander.toml")).unwrap();
        let robot = Budget::of(&scenario).robots.remove(0);
        let diagram = diagram("wander", &robot).unwrap();
        let mut bars: Vec<_> = diagram.lanes.iter().flat_map(|lane| &lane.bars).collect();
        bars.sort_by_key(|bar| bar.start_ns);
        assert!(bars.windows(2).all(|pair| pair[0].end_ns == pair[1].start_ns), "{bars:?}");
        assert_eq!(bars.last().map(|bar| bar.end_ns), robot.cycle.total.typical_ns);
        assert_eq!(diagram.late_from_ns, Some(10_000_000));
        let labels: Vec<_> = diagram.lanes.iter().map(|lane| lane.label.as_str()).collect();
        assert_eq!(labels[..3], ["sensors", "microcontroller", "cable up"]);
        assert!(diagram.draw().contains("misses its deadline of 10 ms"));
    }
}
