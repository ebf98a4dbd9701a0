//! `baudbot locate`: the search for a robot's place by its scan (Section 6.3.1), and the poses that were tried, Fig. 6.18.
//!
//! [`scan_source`] takes a scan in a world, and makes a map of its arena; [`pose_search`] searches by `baudbot_brains::localization`;
//! [`arena`] shows both.

mod pose_search;
mod scan_source;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use baudbot_brains::scan::Scan;
use baudbot_geometry::{Point, Pose, Vector, math};
use baudbot_plot::arena::{self, Attempt, PoseSearch};
use baudbot_plot::quantity::{NOTHING, count, handy};
use clap::ValueEnum;
use serde::Serialize;

use self::pose_search::{SearchResult, Step, error_at, off};
use self::scan_source::ScanSource;
use crate::args::LocateArgs;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text::{self, pairs, tell};

pub(crate) fn locate(args: &LocateArgs) -> anyhow::Result<ExitCode> {
    let source = Source::find(&args.scenario)?;
    let scenario = Arc::new(source.parse(&overrides(&args.changes)?)?);
    let scan_source = ScanSource::find(args, &scenario.robots)?;
    let map = scan_source.map(&scenario.arena)?;
    let (whole, truth) = scan_source.scan(&scenario, args.at)?;
    let scan = whole.thinned(args.rays as usize);
    let search = SearchResult::new(args, &map, &scan, scenario.seed)?;
    let error_at_truth = error_at(&map, &scan, &truth);
    let rays = whole.distances_m.len();
    let told = Told { args, scan_source, search: &search, scan: &scan, rays, truth, error_at_truth };
    let code = if search.error().is_finite() {
        ExitCode::SUCCESS
    } else {
        tell!(
            "error: too few rays could be compared with the map at every pose that was tried: the guess is outside the arena, or too little \
             is within the laser's range"
        );
        ExitCode::FAILURE
    };
    if let Some(path) = &args.svg {
        text::write(path, &arena::draw_pose_search(&scenario, source.label(), &told.search()))?;
        if path == Path::new("-") {
            return Ok(code);
        }
    }
    if args.json {
        text::print_json(&told.found())?;
    } else {
        text::print(&told.words())?;
    }
    Ok(code)
}

/// The result of a search.
struct Told<'a> {
    args: &'a LocateArgs,
    scan_source: ScanSource<'a>,
    search: &'a SearchResult,
    scan: &'a Scan,
    /// The number of rays of the whole scan.
    rays: usize,
    truth: Pose,
    error_at_truth: f64,
}

/// The result, for programs. If an error is null, too few rays could be compared.
#[derive(Serialize)]
struct Found<'a> {
    method: String,
    robot: &'a str,
    laser: &'a str,
    rays: usize,
    rays_of_laser: usize,
    truth: Place,
    error_at_truth: f64,
    guess: Place,
    found: Place,
    error: f64,
    off_m: f64,
    off_rad: f64,
    /// The fraction of the rays that fit; only with refinement.
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<f64>,
    poses_tried: usize,
    poses_accepted: usize,
    starts: usize,
    best_start: usize,
    tried: Vec<TriedPose>,
}

#[derive(Serialize)]
struct Place {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

#[derive(Serialize)]
struct TriedPose {
    #[serde(flatten)]
    place: Place,
    error: f64,
    accepted: bool,
    start: usize,
}

impl From<Pose> for Place {
    fn from(pose: Pose) -> Self {
        Self { x_m: pose.position.x, y_m: pose.position.y, heading_rad: pose.heading }
    }
}

impl<'a> Told<'a> {
    fn method(&self) -> String {
        self.args.method.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    fn accepted(&self) -> usize {
        self.search.steps.iter().filter(|step| step.accepted).count()
    }

    fn found(&self) -> Found<'a> {
        let search = self.search;
        let (off_m, off_rad) = off(&search.found, &self.truth);
        let tried = |step: &Step| {
            let Step { pose, error, accepted, start } = *step;
            TriedPose { place: pose.into(), error, accepted, start }
        };
        Found {
            method: self.method(),
            robot: &self.scan_source.robot.name,
            laser: self.scan_source.sensor(),
            rays: self.scan.distances_m.len(),
            rays_of_laser: self.rays,
            truth: self.truth.into(),
            error_at_truth: self.error_at_truth,
            guess: self.args.guess.into(),
            found: search.found.into(),
            error: search.error(),
            off_m,
            off_rad,
            fit: search.fit,
            poses_tried: search.steps.len(),
            poses_accepted: self.accepted(),
            starts: search.starts(),
            best_start: search.best(),
            tried: search.steps.iter().map(tried).collect(),
        }
    }

    fn words(&self) -> String {
        let (found, search) = (self.found(), self.search);
        let error_at_guess = search.steps.first().map_or(f64::INFINITY, |step| step.error);
        let mut facts = vec![
            ("method", found.method),
            (
                "robot",
                format!("{}, {} of {} of {}", found.robot, found.rays, count(self.rays, "ray"), found.laser),
            ),
            ("truth", format!("{}; ε {}", place(&self.truth), epsilon(self.error_at_truth))),
            ("guess", self.told_of(&self.args.guess, error_at_guess)),
            ("found", self.told_of(&search.found, found.error)),
            ("tried", self.effort()),
        ];
        facts.extend(search.fit.map(|fit| ("fit", format!("{} of the rays", text::percent(fit)))));
        if search.starts() > 1 {
            facts.push(("starts", format!("{}, of which {} was the best", search.starts(), search.best())));
        }
        format!("{}\n{}", pairs("", &facts), self.table())
    }

    fn told_of(&self, pose: &Pose, error: f64) -> String {
        let (m, rad) = off(pose, &self.truth);
        format!("{}; {m:.3} m and {rad:.3} rad off; ε {}", place(pose), epsilon(error))
    }

    fn effort(&self) -> String {
        format!("{}, {} accepted", count(self.search.steps.len(), "pose"), self.accepted())
    }

    /// The poses that were accepted on the way to where it ended.
    fn table(&self) -> String {
        let head = ["pose", "ε", "x in m", "y in m", "heading in rad", "off by m", "off by rad"];
        let row = |(number, step): (usize, &Step)| {
            let Pose { position, heading } = step.pose;
            let (m, rad) = off(&step.pose, &self.truth);
            let numbers = [position.x, position.y, heading, m, rad].map(|number| format!("{number:.3}"));
            let [x, y, heading, m, rad] = numbers;
            [number.to_string(), epsilon(step.error), x, y, heading, m, rad]
        };
        let rows = self.search.accepted(self.search.best()).map(row);
        text::table("", &[head.map(str::to_owned)].into_iter().chain(rows).collect::<Vec<_>>())
    }

    /// The picture of it.
    fn search(&self) -> PoseSearch {
        let search = self.search;
        let attempt = |start: usize| Attempt {
            steps: search.accepted(start).map(|(number, step)| (number, step.pose)).collect(),
        };
        let best = search.best();
        let others = (0..search.starts()).filter(|start| *start != best);
        let (m, rad) = off(&search.found, &self.truth);
        PoseSearch {
            robot: self.scan_source.robot.name.clone(),
            truth: self.truth,
            guess: self.args.guess,
            found: search.found,
            rejected: search.steps.iter().filter(|step| !step.accepted).map(|step| step.pose).collect(),
            best: attempt(best),
            others: others.map(attempt).collect(),
            seen_from_guess: seen_from(self.scan, &self.args.guess),
            seen_from_found: seen_from(self.scan, &search.found),
            notes: vec![
                format!(
                    "{}, {} of {}",
                    self.method(),
                    count(self.scan.distances_m.len(), "ray"),
                    self.scan_source.sensor()
                ),
                self.effort(),
                format!("{m:.3} m and {rad:.3} rad off in the end, ε {}", epsilon(search.error())),
                format!("ε {} at the true pose", epsilon(self.error_at_truth)),
            ],
        }
    }
}

/// The measured points as they would be if the robot were there.
fn seen_from(scan: &Scan, world_from_robot: &Pose) -> Vec<Point> {
    let world_from_laser = world_from_robot.compose(&scan.robot_from_laser);
    let hits = scan.distances_m.iter().enumerate().filter(|(_, distance)| distance.is_finite());
    let point = |(i, distance): (usize, &f64)| {
        let (sin, cos) = math::sin_cos(world_from_laser.heading + scan.bearing_rad(i));
        world_from_laser.position + Vector::new(cos, sin) * *distance
    };
    hits.map(point).collect()
}

fn place(pose: &Pose) -> String {
    format!("({}, {}), {} rad", handy(pose.position.x), handy(pose.position.y), handy(pose.heading))
}

/// A matching error; there is none where too few rays could be compared.
fn epsilon(error: f64) -> String {
    if error.is_finite() { format!("{error:.4}") } else { NOTHING.to_owned() }
}
