//! A search, by any of the methods, and all poses that it tried.

use baudbot_brains::Chance;
use baudbot_brains::estimate::Estimate;
use baudbot_brains::localization::{Map, Tried, VirtualLaser, laser, refine};
use baudbot_brains::scan::Scan;
use baudbot_geometry::{Pose, angle};

use crate::args::{LocateArgs, Search};
use crate::error::Refused;

/// The course of a search.
#[derive(Debug)]
pub(super) struct SearchResult {
    /// The last pose.
    pub(super) found: Pose,
    /// All poses in the order in which they were tried, the guess first.
    pub(super) steps: Vec<Step>,
    /// The part of the rays that fit in the end, of refinement.
    pub(super) fit: Option<f64>,
}

/// A pose that was tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) pose: Pose,
    /// ε of (6.8), whatever the method goes by.
    pub(super) error: f64,
    pub(super) accepted: bool,
    /// The start to which it goes back: 0 is the guess.
    pub(super) start: usize,
}

/// The plan of a method's search.
enum Plan {
    Search(laser::Parameters),
    Refine { parameters: refine::Parameters, sd_m: f64, sd_rad: f64 },
}

impl SearchResult {
    /// Searches from the guess of the command line.
    pub(super) fn new(args: &LocateArgs, map: &Map, scan: &Scan, seed: u64) -> anyhow::Result<Self> {
        let plan = Plan::new(args)?;
        let (mut tried, mut chance) = (Vec::new(), Chance::new(seed, "locate"));
        let watch = |pose: &Tried| tried.push(*pose);
        let (found, fit) = match plan {
            Plan::Search(parameters) => {
                let found = laser::localize_watched(map, scan, &args.guess, &parameters, &mut chance, watch);
                (found.world_from_robot, None)
            }
            Plan::Refine { parameters, sd_m, sd_rad } => {
                let guess = Estimate::within(args.guess, sd_m, sd_rad);
                let found = refine::refine_watched(map, scan, &guess, &parameters, &mut chance, watch);
                (found.estimate.world_from_robot, Some(found.fit))
            }
        };
        let step = |Tried { world_from_robot: pose, accepted, start, .. }| Step {
            pose,
            error: error_at(map, scan, &pose),
            accepted,
            start,
        };
        Ok(Self { found, steps: tried.into_iter().map(step).collect(), fit })
    }

    /// The accepted poses of a start, in their order, with their places among all.
    pub(super) fn accepted(&self, start: usize) -> impl Iterator<Item = (usize, &Step)> {
        self.steps.iter().enumerate().filter(move |(_, step)| step.accepted && step.start == start)
    }

    /// The number of starts, the guess included.
    pub(super) fn starts(&self) -> usize {
        self.steps.last().map_or(0, |step| step.start + 1)
    }

    /// The start that led to where it ended.
    pub(super) fn best(&self) -> usize {
        let ended =
            |start: &usize| self.accepted(*start).last().is_some_and(|(_, step)| step.pose == self.found);
        (0..self.starts()).find(ended).unwrap_or_default()
    }

    /// The last matching error.
    pub(super) fn error(&self) -> f64 {
        self.accepted(self.best()).last().map_or(f64::INFINITY, |(_, step)| step.error)
    }
}

impl Plan {
    fn new(args: &LocateArgs) -> anyhow::Result<Self> {
        let strange = match args.method {
            Search::Search => args.refine.given().next().map(|option| (option, "refine")),
            Search::Refine => args.search.given().next().map(|option| (option, "search")),
        };
        if let Some((option, method)) = strange {
            let text = format!("{option}: belongs to --method {method}; leave it out, or use that method");
            return Err(Refused::error(text));
        }
        Ok(match args.method {
            Search::Search => {
                Self::Search(args.search.parameters().map_err(|error| Refused::error(error.to_string()))?)
            }
            Search::Refine => {
                let (sd_m, sd_rad) =
                    args.refine.deviations().map_err(|error| Refused::error(error.to_string()))?;
                Self::Refine { parameters: args.refine.parameters(), sd_m, sd_rad }
            }
        })
    }
}

/// ε of (6.8) at a pose, by the map.
pub(super) fn error_at(map: &Map, scan: &Scan, pose: &Pose) -> f64 {
    let seen = VirtualLaser::like(scan).scan(map, pose);
    laser::matching_error(&scan.distances_m, &seen.distances_m)
}

/// The distance of a pose from another, in metres and radians.
pub(super) fn off(pose: &Pose, truth: &Pose) -> (f64, f64) {
    let m = (pose.position - truth.position).norm();
    (m, angle::difference(pose.heading, truth.heading).abs())
}
