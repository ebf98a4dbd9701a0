//! `baudbot grade`: holds a brain against the criteria of an exercise.

use std::env;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_client::Body;
use baudbot_experiment::Seeds;
use baudbot_experiment::grade::junit::junit;
use baudbot_experiment::grade::{Exercise, Grading, Options, Verdict, all, grade as grade_all};
use baudbot_import::embedded;
use baudbot_run::assignment as run;
use baudbot_run::programs::{Output, Problem};
use baudbot_sim::Scenario;
use serde_json::{Value, json};

use crate::args::GradeArgs;
use crate::assignment::{self, Assigned, NONE};
use crate::class::{self, Class, NOT_PASSED};
use crate::error::Refused;
use crate::output_files::{self, EXERCISE, Inputs};
use crate::signals::INTERRUPTED;
use crate::text::{pairs, print, print_json, tell};
use crate::{text, work};

pub(crate) async fn grade(args: GradeArgs) -> anyhow::Result<ExitCode> {
    let Some(name) = args.exercise.clone().filter(|_| !args.list) else {
        refuse_brains(&args)?;
        return list(args.json);
    };
    if args.toml {
        return print_file(&name);
    }
    let exercise = read(&name, &args)?;
    if args.show {
        return show(&exercise, args.json);
    }
    if !args.class.is_empty() {
        let class = Class::find(&args)?;
        let inputs = Inputs::default().file(EXERCISE, &name);
        let outputs = [("--junit", &args.junit), ("--csv", &args.csv)];
        let outputs: Vec<_> =
            outputs.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?))).collect();
        output_files::check_apart(outputs.iter().copied())?;
        inputs.check(outputs.into_iter())?;
        return work::until_stopped(move |stop| {
            let assign = |brains: &[String]| assigned(&name, &exercise, &args, brains);
            class::run(&exercise, &args, (class, &assign), stop)
        })
        .await;
    }
    if args.brains.is_empty() {
        return Err(Refused::error(format!(
            "no brain is given; add --brain NAME, --brain FILE.toml or --brain 'exec:PROGRAM'; `baudbot grade {name} --show` \
             shows the task"
        )));
    }
    let inputs = Inputs::default().file(EXERCISE, &name).brains(&args.brains).brains(&exercise.brains);
    inputs.check(args.junit.iter().map(|path| ("--junit", path.as_path())))?;
    let assigned = assigned(&name, &exercise, &args, &args.brains)?;
    work::until_stopped(move |stop| run(&exercise, &args, &assigned, stop)).await
}

/// A brain has nothing to do without an exercise.
fn refuse_brains(args: &GradeArgs) -> anyhow::Result<()> {
    if args.brains.is_empty() && args.class.is_empty() && args.junit.is_none() {
        return Ok(());
    }
    Err(Refused::error(
        "no exercise is given; `baudbot grade` lists them; then baudbot grade EXERCISE --brain BRAIN",
    ))
}

fn list(is_json: bool) -> anyhow::Result<ExitCode> {
    let exercises = all()?;
    if is_json {
        print_json(&exercises.iter().map(Exercise::json).collect::<Value>())?;
        return Ok(ExitCode::SUCCESS);
    }
    let line =
        |exercise: &Exercise| (exercise.name.clone(), format!("{:<6} {}", exercise.section, exercise.title));
    let lines: Vec<_> = exercises.iter().map(line).collect();
    let lines: Vec<_> = lines.iter().map(|(name, title)| (name.as_str(), title.clone())).collect();
    print(&format!(
        "exercises, by section of the notes: baudbot grade NAME --show\n{}",
        pairs("  ", &lines)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The file as it is in the program.
fn print_file(name: &str) -> anyhow::Result<ExitCode> {
    let unknown =
        || Refused::error(format!("{name}: there is no exercise of this name; `baudbot grade` lists them"));
    print(embedded::exercise(name).ok_or_else(unknown)?)?;
    Ok(ExitCode::SUCCESS)
}

fn show(exercise: &Exercise, is_json: bool) -> anyhow::Result<ExitCode> {
    if is_json {
        print_json(&exercise.json())?;
    } else {
        print(&exercise.described())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn read(name: &str, args: &GradeArgs) -> anyhow::Result<Exercise> {
    let mut exercise = Exercise::read(name).map_err(|error| Refused::error(error.to_string()))?;
    if let Some(seeds) = &args.seeds {
        exercise.seeds = Seeds::parse(seeds).map_err(|error| Refused::error(format!("--{error}")))?;
    }
    Ok(exercise)
}

/// The brain that is graded, and those that the exercise has for other robots.
fn assigned(
    name: &str,
    exercise: &Exercise,
    args: &GradeArgs,
    brains: &[String],
) -> anyhow::Result<Assigned> {
    let scenario = exercise.scenario_with(exercise.seeds.get(0))?;
    for (i, brain) in exercise.brains.iter().enumerate() {
        // A fault of the file is not one of the command line.
        let own = [brain.clone(), NONE.to_owned()];
        let checked = run::assign(&own, &scenario.robots)
            .map_err(anyhow::Error::from)
            .and_then(|own| check(&own, &scenario));
        checked.map_err(|error| Refused::error(format!("{name}: brains[{i}]: {error}")))?;
    }
    let brains: Vec<_> = brains.iter().chain(&exercise.brains).cloned().collect();
    let mut assigned = assignment::assign(&brains, &scenario.robots, &[])?;
    assignment::set_parameters(&mut assigned, &args.parameters)?;
    check(&assigned, &scenario).map_err(|error| Refused::error(error.to_string()))?;
    if args.show_output {
        assigned.programs.iter_mut().for_each(|task| task.output = Output::Shown);
        assigned.at_ports.iter_mut().for_each(|task| task.output = Output::Shown);
    }
    Ok(assigned)
}

/// Whether each brain can be made, and each program is there, before anything is started for them.
fn check(assigned: &Assigned, scenario: &Scenario) -> anyhow::Result<()> {
    for assignment in &assigned.brains {
        for spec in scenario.robots.iter().filter(|spec| assignment.robots.contains(&spec.name)) {
            catalogue::brain(&assignment.brain, 1, &Body::from(spec))?;
        }
    }
    for task in &assigned.programs {
        // The words have been parsed before, so there is a first one.
        let words = shlex::split(&task.program.to_string()).unwrap_or_default();
        if let Some(program) = words.into_iter().next().filter(|program| !is_there(program)) {
            anyhow::bail!(Problem::Missing(program));
        }
    }
    Ok(())
}

/// Whether there is such a program: at its path, or in a folder of `PATH`.
fn is_there(program: &str) -> bool {
    if program.contains('/') {
        return Path::new(program).exists();
    }
    let Some(folders) = env::var_os("PATH") else { return true };
    env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}

fn run(
    exercise: &Exercise,
    args: &GradeArgs,
    assigned: &Assigned,
    stop: &AtomicBool,
) -> anyhow::Result<ExitCode> {
    let bar = work::progress(args.quiet);
    let progress = |done| work::advance(&bar, done, exercise.seeds.count());
    progress(0);
    let grading =
        grade_all(exercise, assigned, &Options { jobs: work::jobs_of(args.jobs), stop, progress: &progress });
    bar.finish_and_clear();
    let Some(grading) = grading.context("could not be graded")? else {
        tell!("stopped; nothing was graded");
        return Ok(ExitCode::from(INTERRUPTED));
    };
    report(exercise, args, &grading)?;
    Ok(match grading.verdict {
        Verdict::Passed => ExitCode::SUCCESS,
        Verdict::NotGraded => ExitCode::FAILURE,
        Verdict::Failed => ExitCode::from(NOT_PASSED),
    })
}

fn report(exercise: &Exercise, args: &GradeArgs, grading: &Grading) -> anyhow::Result<()> {
    if let Some(file) = &args.junit {
        text::write(file, &junit(exercise, grading))?;
    }
    if args.json {
        let mut json = grading.json(exercise);
        json["brains"] = json!(args.brains);
        return print_json(&json);
    }
    if args.quiet { Ok(()) } else { print(&grading.text(exercise)) }
}
