//! `baudbot umbmark`: the systematic errors of a robot's odometry by the bidirectional square path of Borenstein & Feng 1996.
//!
//! [`course`] lets the robot drive squares by its odometry; [`analysis`] finds the errors of its wheels by where they ended.

mod analysis;
mod course;
mod told;

use std::path::Path;
use std::process::ExitCode;

use baudbot_brains::odometry::Calibration;
use baudbot_plot::chart::scatter::{self, Scatter};
use baudbot_plot::quantity::handy;
use baudbot_sim::model::RobotSpec;

use self::analysis::{Analysis, Group};
use self::course::{Course, Run};
use self::told::Told;
use crate::args::UmbmarkArgs;
use crate::error::Refused;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text;

pub(crate) fn umbmark(args: &UmbmarkArgs) -> anyhow::Result<ExitCode> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    let robot = robot(args.robot.as_deref(), &scenario.robots)?;
    let course = Course::new(args, &scenario, robot)?;
    let first = measure(args, &course, scenario.seed, Calibration::NONE)?;
    let second = args.check.then(|| {
        let seed = scenario.seed.wrapping_add(2 * u64::from(args.runs));
        measure(args, &course, seed, first.calibration)
    });
    let told = Told { args, robot, course: &course, first: &first, second: second.transpose()? };
    if let Some(path) = &args.svg {
        text::write(path, &picture(&told).draw())?;
        if path == Path::new("-") {
            return Ok(ExitCode::SUCCESS);
        }
    }
    if args.json {
        text::print_json(&told.found())?;
    } else {
        text::print(&told.words())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Runs in both directions, by an odometry with this calibration.
fn measure(
    args: &UmbmarkArgs,
    course: &Course,
    seed: u64,
    calibration: Calibration,
) -> anyhow::Result<Analysis> {
    let runs = u64::from(args.runs);
    let group = |clockwise: bool, seed: u64| -> anyhow::Result<Group> {
        let run = |i| course.drive(Run { clockwise, seed: seed.wrapping_add(i), calibration });
        Ok(Group::new((0..runs).map(run).collect::<anyhow::Result<_>>()?))
    };
    let (cw, ccw) = (group(true, seed)?, group(false, seed.wrapping_add(runs))?);
    Ok(Analysis::new(cw, ccw, args.side_m, course.track_m(), calibration))
}

/// The ends of the runs, in millimetres.
fn picture(told: &Told<'_>) -> Scatter {
    let group = |name: &str, group: &Group| scatter::Group {
        name: name.to_owned(),
        places: group.errors.iter().map(|error| [1e3 * error.x_m, 1e3 * error.y_m]).collect(),
    };
    let mut groups = vec![group("clockwise", &told.first.cw), group("counter-clockwise", &told.first.ccw)];
    if let Some(second) = &told.second {
        groups.push(group("clockwise, corrected", &second.cw));
        groups.push(group("counter-clockwise, corrected", &second.ccw));
    }
    let after = told.second.as_ref().map(|second| format!(", corrected {} mm", mm(second.e_max_syst_m())));
    Scatter {
        title: format!("UMBmark of {}", told.robot.name),
        subtitle: format!(
            "{} runs each way round {} m by `{}`: E_max,syst {} mm{}",
            told.args.runs,
            handy(told.args.side_m),
            told.course.sensor,
            mm(told.first.e_max_syst_m()),
            after.unwrap_or_default()
        ),
        x: "x: truth − odometry, mm".to_owned(),
        y: "y: truth − odometry, mm".to_owned(),
        groups,
    }
}

/// The robot to measure.
fn robot<'a>(name: Option<&str>, robots: &'a [RobotSpec]) -> anyhow::Result<&'a RobotSpec> {
    let named = |robot: &&RobotSpec| name.is_none_or(|name| robot.name == name);
    robots.iter().find(named).ok_or_else(|| {
        let names = robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
        Refused::error(match name {
            Some(name) => format!("--robot: there is no robot `{name}`; there are: {names}"),
            None => "the scenario has no robot to measure; add one".to_owned(),
        })
    })
}

/// A length in millimetres, to a tenth.
fn mm(length_m: f64) -> String {
    // No error is no negative one.
    format!("{:.1}", (1e4 * length_m).round() / 10.0 + 0.0)
}
