//! Captions: what ran, in the few words for which pictures have room.

use baudbot_sim::Scenario;
use baudbot_sim::link::Link;

/// The description in the scenario's file, as long as it holds: nothing was changed but the seed and the end, which pictures
/// show by themselves. Otherwise the changes, of fields or `by_hand` in the run.
pub fn about(scenario: &Scenario, by_hand: bool) -> String {
    let tells_itself = |change: &&String| {
        let path = change.split('=').next().unwrap_or_default().trim();
        path == "seed" || path == "end.after_s"
    };
    let fields = scenario.source.overrides.iter().filter(|change| !tells_itself(change));
    let changes: Vec<_> = fields.map(String::as_str).chain(by_hand.then_some("something by hand")).collect();
    match changes.as_slice() {
        [] => scenario.description.clone(),
        changes => format!("changed: {}", changes.join(", ")),
    }
}

/// The brains, links and seed of a run, as in `avoid · 9600 baud · seed 1`. Repeated names are written once.
pub fn facts(brains: &[String], links: &[String], seed: u64) -> String {
    let brains = match brains {
        [] => "no brain".to_owned(),
        brains => few(brains, "brains"),
    };
    [brains, few(links, "kinds of links"), format!("seed {seed}")]
        .into_iter()
        .filter(|fact| !fact.is_empty())
        .collect::<Vec<_>>()
        .join(" · ")
}

/// The links of a scenario's robots.
pub fn links(scenario: &Scenario) -> Vec<String> {
    scenario.robots.iter().map(|robot| link(&robot.link)).collect()
}

/// A link in about two words.
pub fn link(link: &Link) -> String {
    match link {
        Link::Ideal => "ideal link".to_owned(),
        Link::Onboard => "brain on board".to_owned(),
        Link::Uart(uart) => format!("{} baud", uart.baud),
        Link::Usb(_) => "USB".to_owned(),
    }
}

/// The different names, or their number if there are too many.
fn few(names: &[String], what: &str) -> String {
    let mut all: Vec<&str> = Vec::new();
    for name in names {
        if !all.contains(&name.as_str()) {
            all.push(name);
        }
    }
    if all.len() > MOST_NAMES { format!("{} {what}", all.len()) } else { all.join(", ") }
}

/// The most names that are written.
const MOST_NAMES: usize = 3;

#[cfg(test)]
mod tests {
    use baudbot_scenario::Override;

    use super::*;

    fn scenario(changes: &[&str]) -> Scenario {
        let changes: Vec<_> = changes.iter().map(|change| Override::parse(change).unwrap()).collect();
        baudbot_scenario::parse_with(include_str!("../../../catalogue/scenarios/wander.toml"), &changes)
            .unwrap()
    }

    #[test]
    fn a_description_is_repeated_only_while_it_holds() {
        let whole = "ARSim's arena, five IR sensors, a brain across 9600 baud 8N1";
        assert_eq!(about(&scenario(&[]), false), whole);
        assert_eq!(about(&scenario(&["seed=7", " end.after_s = 3.0"]), false), whole);
        let slow = scenario(&["seed=7", "robots.robot.link.baud=2400", "noise=false"]);
        assert_eq!(about(&slow, false), "changed: robots.robot.link.baud=2400, noise=false");
        assert_eq!(about(&scenario(&[]), true), "changed: something by hand");
        assert_eq!(links(&slow), ["2400 baud"]);
    }

    #[test]
    fn names_are_told_once_and_many_are_counted() {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let links = names(&["9600 baud", "9600 baud"]);
        assert_eq!(
            facts(&names(&["avoid", "avoid", "wander"]), &links, 3),
            "avoid, wander · 9600 baud · seed 3"
        );
        assert_eq!(facts(&[], &[], 1), "no brain · seed 1");
        assert_eq!(facts(&names(&["a", "b", "c", "d"]), &links, 1), "4 brains · 9600 baud · seed 1");
    }
}
