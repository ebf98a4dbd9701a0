//! `baudbot conform`: holds a brain in any language against the contract.

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Duration;

use baudbot_conform::{Brain, CASES, Case, Finding, NextRun, Verdict, examine};
use baudbot_experiment::grade::junit::escaped;
use baudbot_run::programs::{EXEC, Program};
use serde_json::{Value, json};

use crate::args::ConformArgs;
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text::{self, tell};

pub(crate) async fn conform(args: &ConformArgs) -> anyhow::Result<ExitCode> {
    if args.list {
        list(args.json)?;
        return Ok(ExitCode::SUCCESS);
    }
    let brain = brain(args)?;
    let inputs = Inputs::of(&args.scenario, &args.changes);
    inputs.check(args.junit.iter().map(|path| ("--junit", path.as_path())))?;
    let scenario = Source::find(&args.scenario)?.parse(&overrides(&args.changes)?)?;
    let patience = Duration::from_secs(args.patience.into());
    let mut progress = |next: &NextRun| {
        let NextRun { number, count, provocation, world, robots } = next;
        if let Some(address) = args.external {
            let place = format!("BAUDBOT_CONNECT={address} BAUDBOT_WORLD={world} BAUDBOT_ROBOT={robots}");
            tell!("[{number}/{count}] {provocation}: start the brain with {place}");
        } else if !args.quiet {
            tell!("[{number}/{count}] {provocation}");
        }
    };
    let examined = examine(&brain, &scenario, args.robot.as_deref(), patience, &mut progress).await;
    let findings = examined.map_err(|error| Refused::error(error.to_string()))?;
    report(args, &shown(args), &findings)?;
    let fails = findings.iter().any(|finding| matches!(finding.verdict, Verdict::DoesNot(_)));
    Ok(if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn brain(args: &ConformArgs) -> anyhow::Result<Brain> {
    if let Some(address) = args.external {
        if !address.ip().is_loopback() {
            return Err(Refused::error(format!(
                "--external {address}: must be an address of this machine, such as 127.0.0.1:{}; a brain that you start yourself \
                 is asked for no token",
                address.port()
            )));
        }
        return Ok(Brain::Outside(address));
    }
    let text = args.brain.as_deref().unwrap_or_default();
    match Program::of_brain(text) {
        Some(program) => Ok(Brain::Program(program.map_err(|error| Refused::error(error.to_string()))?)),
        None => Err(Refused::error(format!(
            "`{text}` is no program; write {EXEC} before its command line, as in {EXEC}./follow"
        ))),
    }
}

/// The brain as people know it.
fn shown(args: &ConformArgs) -> String {
    match (&args.brain, args.external) {
        (Some(brain), _) => brain.clone(),
        (None, Some(address)) => format!("the brain at {address}"),
        (None, None) => String::new(),
    }
}

fn list(is_json: bool) -> anyhow::Result<()> {
    if is_json {
        return text::print_json(&CASES.iter().map(case_json).collect::<Value>());
    }
    let mut lines = String::new();
    for case in CASES {
        let _ = writeln!(lines, "{} (in a run with {})\n    {}", case.name, case.provocation, case.sentence);
    }
    text::print(&lines)
}

fn case_json(case: &Case) -> Value {
    json!({ "name": case.name, "run": case.provocation.to_string(), "sentence": case.sentence })
}

fn report(args: &ConformArgs, brain: &str, findings: &[Finding]) -> anyhow::Result<()> {
    if let Some(path) = &args.junit {
        text::write(path, &junit(brain, findings))?;
    }
    if args.json {
        text::print_json(&as_json(brain, findings))
    } else if args.quiet {
        Ok(())
    } else {
        text::print(&as_text(brain, findings))
    }
}

/// The reason of a verdict, if it needs one.
fn why(verdict: &Verdict) -> Option<&str> {
    match verdict {
        Verdict::Does => None,
        Verdict::DoesNot(why) | Verdict::NotUsed(why) => Some(why),
    }
}

/// The cases that it does, does not, and has no use for.
fn counts(findings: &[Finding]) -> [usize; 3] {
    let mut counts = [0; 3];
    for finding in findings {
        counts[match finding.verdict {
            Verdict::Does => 0,
            Verdict::DoesNot(_) => 1,
            Verdict::NotUsed(_) => 2,
        }] += 1;
    }
    counts
}

fn as_text(brain: &str, findings: &[Finding]) -> String {
    let mut text = String::new();
    for finding in findings {
        let Finding { case, verdict, printed } = finding;
        let _ = write!(text, "{:<9} {}", verdict.to_string(), case.name);
        let _ = writeln!(text, "{}", why(verdict).map(|why| format!(": {why}")).unwrap_or_default());
        if matches!(verdict, Verdict::DoesNot(_)) {
            let _ = writeln!(
                text,
                "          in a run with {}\n          contract: {}",
                case.provocation, case.sentence
            );
            printed.iter().for_each(|line| {
                let _ = writeln!(text, "          it printed: {line}");
            });
        }
    }
    let [does, does_not, not_used] = counts(findings);
    text + &format!(
        "{brain}: of {} cases {does} does, {does_not} does not, {not_used} not used\n",
        findings.len()
    )
}

fn as_json(brain: &str, findings: &[Finding]) -> Value {
    let cases = findings.iter().map(|finding| {
        let mut case = case_json(finding.case);
        case["verdict"] = finding.verdict.to_string().into();
        case["why"] = why(&finding.verdict).into();
        if matches!(finding.verdict, Verdict::DoesNot(_)) {
            case["printed"] = finding.printed.clone().into();
        }
        case
    });
    let [does, does_not, not_used] = counts(findings);
    json!({ "brain": brain, "does": does, "does_not": does_not, "not_used": not_used, "cases": cases.collect::<Vec<_>>() })
}

fn junit(brain: &str, findings: &[Finding]) -> String {
    let [_, failures, skipped] = counts(findings);
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"0\" skipped=\"{skipped}\">\n",
        escaped(brain),
        findings.len(),
    );
    for Finding { case, verdict, printed } in findings {
        let _ = write!(xml, "  <testcase classname=\"conform\" name=\"{}\"", case.name);
        let _ = match verdict {
            Verdict::Does => writeln!(xml, "/>"),
            Verdict::NotUsed(why) => writeln!(xml, "><skipped message=\"{}\"/></testcase>", escaped(why)),
            Verdict::DoesNot(why) => {
                let words = escaped(&format!("{}\n{}", case.sentence, printed.join("\n")));
                writeln!(xml, "><failure message=\"{}\">{words}</failure></testcase>", escaped(why))
            }
        };
    }
    xml + "</testsuite>\n"
}
