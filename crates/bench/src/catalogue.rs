//! The workloads by name.

use crate::child::Streams;
use crate::gallery::Gallery;
use crate::in_process::{InProcess, Unfit};
use crate::learner::Learner;
use crate::network::{Network, Worlds};
use crate::scale::Scale;
use crate::scenario::{Cable, Laser, Program};

/// A workload: a row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workload {
    /// Such as `W2` or `W3/100`; the part before `/` names all of a kind.
    pub name: &'static str,
    /// The description, in some words.
    pub summary: &'static str,
    /// Unit of its figure.
    pub unit: &'static str,
    pub(crate) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    InProcess(InProcess),
    Learner(Learner),
    Gallery(Gallery),
    Network(Network),
    Worlds(Worlds),
}

impl Workload {
    /// Runs it for exactly so many ticks and measures nothing, for a profiler; the world's fingerprint after them.
    ///
    /// # Errors
    /// If it cannot be run.
    pub fn run_ticks(&self, ticks: u64, threads: usize) -> Result<u64, Unfit> {
        match self.kind {
            Kind::InProcess(world) => world.run_ticks(ticks, threads),
            Kind::Learner(learner) => learner.run_ticks(ticks),
            Kind::Gallery(_) | Kind::Network(_) | Kind::Worlds(_) => Err(Unfit::NotInProcess(self.name)),
        }
    }
}

impl Workload {
    /// Whether it is a world or worlds in one process, whose ticks can be run by number.
    pub fn has_ticks(&self) -> bool {
        self.scale().is_some()
    }

    /// The scale by which instructions are counted; `None` if they are those of several processes.
    pub(crate) fn scale(&self) -> Option<Scale> {
        match self.kind {
            Kind::InProcess(world) => Some(world.scale()),
            Kind::Learner(learner) => Some(learner.scale()),
            Kind::Gallery(_) | Kind::Network(_) | Kind::Worlds(_) => None,
        }
    }
}

/// There is no such workload.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no workload `{name}`; there are: {}", known.join(", "))]
pub struct NoWorkload {
    name: String,
    known: Vec<&'static str>,
}

/// The workloads of these names, in the order of the catalogue; a name without `/` takes all of its kind, and no name
/// takes all that there are.
///
/// # Errors
/// If there is none of a name.
pub fn select(names: &[String]) -> Result<Vec<&'static Workload>, NoWorkload> {
    let is = |workload: &Workload, name: &str| {
        let kind = workload.name.split('/').next();
        workload.name.eq_ignore_ascii_case(name) || kind.is_some_and(|kind| kind.eq_ignore_ascii_case(name))
    };
    if let Some(name) = names.iter().find(|name| !WORKLOADS.iter().any(|workload| is(workload, name))) {
        let known = WORKLOADS.iter().map(|workload| workload.name).collect();
        return Err(NoWorkload { name: name.clone(), known });
    }
    let wanted = |workload: &&Workload| names.is_empty() || names.iter().any(|name| is(workload, name));
    Ok(WORKLOADS.iter().filter(wanted).collect())
}

/// All of them.
pub const WORKLOADS: &[Workload] = &[
    Workload {
        name: "W1/onboard",
        summary: "one small robot, 8 IR sensors of 3 rays, brain on board",
        unit: "steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 1, cable: Cable::Onboard }),
    },
    Workload {
        name: "W1/ideal",
        summary: "the same behind an ideal cable",
        unit: "steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 1, cable: Cable::Ideal }),
    },
    Workload {
        name: "W2",
        summary: "office, one robot, a scan of 683 rays in every step",
        unit: "rays/s",
        kind: Kind::InProcess(InProcess::Office { robots: 1, laser: Laser::Still { period_ms: 10 } }),
    },
    Workload {
        name: "W2s/onboard",
        summary: "the same with a URG-04LX as its preset sweeps, ten scans of 682 rays a second",
        unit: "rays/s",
        kind: Kind::InProcess(InProcess::Office { robots: 1, laser: Laser::Swept { cable: false } }),
    },
    Workload {
        name: "W2s/cable",
        summary: "the same, each scan over the preset's cable, 2,137 bytes",
        unit: "rays/s",
        kind: Kind::InProcess(InProcess::Office { robots: 1, laser: Laser::Swept { cable: true } }),
    },
    Workload {
        name: "W3/10",
        summary: "10 of W1's robots",
        unit: "robot-steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 10, cable: Cable::Onboard }),
    },
    Workload {
        name: "W3/100",
        summary: "100 of W1's robots",
        unit: "robot-steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 100, cable: Cable::Onboard }),
    },
    Workload {
        name: "W3/1000",
        summary: "1,000 of W1's robots",
        unit: "robot-steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 1000, cable: Cable::Onboard }),
    },
    Workload {
        name: "W4",
        summary: "office, 100 robots, each with 10 scans of 683 rays a second",
        unit: "× real time",
        kind: Kind::InProcess(InProcess::Office { robots: 100, laser: Laser::Still { period_ms: 100 } }),
    },
    Workload {
        name: "W4s/onboard",
        summary: "the same, each with a URG-04LX as its preset sweeps",
        unit: "× real time",
        kind: Kind::InProcess(InProcess::Office { robots: 100, laser: Laser::Swept { cable: false } }),
    },
    Workload {
        name: "W4s/cable",
        summary: "the same, each scan over the preset's cable, 2,137 bytes",
        unit: "× real time",
        kind: Kind::InProcess(InProcess::Office { robots: 100, laser: Laser::Swept { cable: true } }),
    },
    Workload {
        name: "G",
        summary: "10,000 of W1's robots, W3/100's floor a hundred times, beside 100 of them",
        unit: "robot-steps/s",
        kind: Kind::InProcess(InProcess::Infrared { robots: 10_000, cable: Cable::Onboard }),
    },
    Workload {
        name: "F/spinning",
        summary: "10 robots whose microcontrollers work out numbers all the time",
        unit: "robots in real time",
        kind: Kind::InProcess(InProcess::Chips { robots: 10, program: Program::Spinning }),
    },
    Workload {
        name: "F/sleeping",
        summary: "100 robots whose microcontrollers wake up each 10 ms",
        unit: "robots in real time",
        kind: Kind::InProcess(InProcess::Chips { robots: 100, program: Program::Sleeping }),
    },
    Workload {
        name: "V/1",
        summary: "a learner steps a world of the scenario `wander`, 27 bytes a cycle at 9600 baud",
        unit: "control cycles/s",
        kind: Kind::Learner(Learner::Cycles { worlds: 1 }),
    },
    Workload {
        name: "V/64",
        summary: "the same with 64 worlds, one after the other in one thread",
        unit: "control cycles/s",
        kind: Kind::Learner(Learner::Cycles { worlds: 64 }),
    },
    Workload {
        name: "V/1024",
        summary: "the same with 1,024 worlds",
        unit: "control cycles/s",
        kind: Kind::Learner(Learner::Cycles { worlds: 1024 }),
    },
    Workload {
        name: "V/reset",
        summary: "a learner takes one of those worlds back to its start, with another seed",
        unit: "resets/s",
        kind: Kind::Learner(Learner::Resets),
    },
    Workload {
        name: "R/wander",
        summary: "`baudbot run`: one robot across 9600 baud",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "avoid",
            ticks: 60_000,
            scenario: include_str!("../../../catalogue/scenarios/wander.toml"),
        }),
    },
    Workload {
        name: "R/khepera",
        summary: "the same: one robot, eight IR sensors",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "avoid",
            ticks: 60_000,
            scenario: include_str!("../../../catalogue/scenarios/khepera.toml"),
        }),
    },
    Workload {
        name: "R/sweeper",
        summary: "the same: a brain of behaviours that sweeps a room",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "sweeper",
            ticks: 60_000,
            scenario: include_str!("../../../catalogue/scenarios/sweeper.toml"),
        }),
    },
    Workload {
        name: "R/explore-office",
        summary: "the same: an office explored by laser, until it is known",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "explore",
            ticks: 90_000,
            scenario: include_str!("../../../catalogue/scenarios/explore-office.toml"),
        }),
    },
    Workload {
        name: "R/tour",
        summary: "the same: a robot that localizes itself by laser",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "tour",
            ticks: 24_000,
            scenario: include_str!("../../../catalogue/scenarios/tour.toml"),
        }),
    },
    Workload {
        name: "R/mower",
        summary: "the same: a mower with a laser",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "mower",
            ticks: 60_000,
            scenario: include_str!("../../../catalogue/scenarios/mower.toml"),
        }),
    },
    Workload {
        name: "R/ecoli",
        summary: "the same: 100 bacteria",
        unit: "× real time",
        kind: Kind::Gallery(Gallery {
            brain: "ecoli",
            ticks: 3_000,
            scenario: include_str!("../../../catalogue/scenarios/ecoli.toml"),
        }),
    },
    Workload {
        name: "N1",
        summary: "one brain in lockstep over TCP, a reading and a command in every step of 1 ms",
        unit: "ticks/s",
        kind: Kind::Network(Network::Alone { guarded: false }),
    },
    Workload {
        name: "N1/tls",
        summary: "the same over TLS, with a token",
        unit: "ticks/s",
        kind: Kind::Network(Network::Alone { guarded: true }),
    },
    Workload {
        name: "N2/off",
        summary: "the same at 9600 baud, the world waits in every step",
        unit: "ticks/s",
        kind: Kind::Network(Network::Serial { lookahead: false }),
    },
    Workload {
        name: "N2/on",
        summary: "the same with lookahead",
        unit: "ticks/s",
        kind: Kind::Network(Network::Serial { lookahead: true }),
    },
    Workload {
        name: "N3/connections",
        summary: "22 brains in lockstep, 8 IR sensors and encoders each, a connection each",
        unit: "ticks/s",
        kind: Kind::Network(Network::Team(Streams::Connections)),
    },
    Workload {
        name: "N3/streams",
        summary: "the same, 22 streams on one connection",
        unit: "ticks/s",
        kind: Kind::Network(Network::Team(Streams::OneConnection)),
    },
    Workload {
        name: "N3/fleet",
        summary: "the same, all on one stream",
        unit: "ticks/s",
        kind: Kind::Network(Network::Team(Streams::OneStream)),
    },
    Workload {
        name: "N4",
        summary: "1,000 robots with 8 IR sensors in real time, steps of 10 ms, brains on 10 streams",
        unit: "% of ticks on time",
        kind: Kind::Network(Network::Crowd),
    },
    Workload {
        name: "M/free",
        summary: "200 worlds of the scenario `khepera` in one server, as fast as they can, nobody attached",
        unit: "ticks/s",
        kind: Kind::Worlds(Worlds::Free),
    },
    Workload {
        name: "M/stepped",
        summary: "the same, stepped by eight clients, a tick a call",
        unit: "ticks/s",
        kind: Kind::Worlds(Worlds::Stepped),
    },
    Workload {
        name: "M/real-time",
        summary: "1,000 of them in real time",
        unit: "% of ticks on time",
        kind: Kind::Worlds(Worlds::RealTime),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    fn names(wanted: &[&str]) -> Result<Vec<&'static str>, NoWorkload> {
        let wanted: Vec<_> = wanted.iter().map(|&name| name.to_owned()).collect();
        Ok(select(&wanted)?.iter().map(|workload| workload.name).collect())
    }

    #[test]
    fn a_name_takes_one_or_all_of_a_kind() {
        assert_eq!(names(&["W3/10"]).unwrap(), ["W3/10"]);
        assert_eq!(names(&["w3"]).unwrap(), ["W3/10", "W3/100", "W3/1000"]);
        assert_eq!(names(&["W4", "W1"]).unwrap(), ["W1/onboard", "W1/ideal", "W4"]);
        assert_eq!(names(&[]).unwrap().len(), WORKLOADS.len());
    }

    #[test]
    fn an_unknown_name_is_told_with_those_that_there_are() {
        let error = names(&["W1", "W9"]).unwrap_err().to_string();
        assert!(error.starts_with("no workload `W9`; there are: W1/onboard, W1/ideal, W2,"), "{error}");
    }
}
