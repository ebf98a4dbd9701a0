//! `baudbot fit`: numbers of a robot from a log of a real one.
//!
//! [`subject`] makes the robot of a preset or scenario, [`source`] reads the log or the table of a recording,
//! [`report`] puts the results of `baudbot-fit` into words.

mod report;
mod source;
mod subject;

use std::path::Path;
use std::process::ExitCode;

use baudbot_fit::choice::choose;
use baudbot_fit::estimate::{Fitted, Outcome};
use baudbot_fit::log::Log;
use baudbot_plot::chart::residuals::{self, Panel};

use self::report::Report;
use self::subject::Subject;
use crate::args::FitArgs;
use crate::error::Refused;
use crate::output_files;
use crate::text::{self, tell};

pub(crate) fn fit(args: &FitArgs) -> anyhow::Result<ExitCode> {
    let subject = Subject::find(args)?;
    if args.list {
        text::print(&report::list(&subject))?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(path) = &args.file else {
        return Err(Refused::error("no log is given; name a file, or - for stdin"));
    };
    if let Some(svg) = args.svg.as_deref().filter(|svg| output_files::is_same_file(svg, path)) {
        return Err(Refused::error(format!("--svg {}: would overwrite the log", svg.display())));
    }
    let robot = subject.robot();
    let fields = choose(robot.model, &args.fields, &subject.others());
    let fields = fields.map_err(|error| Refused::error(format!("--fields: {error}")))?;
    let log = source::read(args, path, &subject)?;
    for warning in &log.warnings {
        tell!("warning: {}: {warning}", log.file);
    }
    let fitted = baudbot_fit::fit(robot, &log, &fields);
    let told = fitted.findings.iter().any(|one| one.is_field && matches!(one.outcome, Outcome::Estimate(_)));
    let code = if told { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    if let Some(svg) = &args.svg {
        text::write(svg, &picture(&subject, &log, &fitted))?;
        if svg == Path::new(output_files::STDOUT) {
            return Ok(code);
        }
    }
    let report = Report::new(&subject, &log, &fitted);
    if args.json {
        text::print_json(&report.json())?;
    } else {
        text::print(&report.toml())?;
    }
    Ok(code)
}

/// The difference between log and model.
fn picture(subject: &Subject, log: &Log, fitted: &Fitted) -> String {
    let panel = |residuals: &baudbot_fit::estimate::Residuals| Panel {
        title: residuals.title.clone(),
        axes: (residuals.x.clone(), residuals.unit.clone()),
        points: residuals.points.clone(),
    };
    let panels: Vec<_> = fitted.residuals.iter().map(panel).collect();
    let subtitle =
        if panels.is_empty() { "no model could be fitted" } else { "residuals between log and model" };
    residuals::draw(&format!("{} · {}", log.file, subject.label), subtitle, &panels)
}
