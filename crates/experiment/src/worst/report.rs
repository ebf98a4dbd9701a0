//! The report of a search, and its files.

use std::fmt::Write;
use std::path::PathBuf;

use baudbot_fields::printable::{Printable, PrintableLines};
use baudbot_plot::text::columns;
use baudbot_scenario::budget::RobotBudget;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use serde_json::{Value, json};

use super::{Likelihood, Trial, Worst};
use crate::error::Error;
use crate::experiment::Experiment;
use crate::outputs::{Content, Folder};
use crate::raw::Strategy;
use crate::requirement::{Demand, Fall};
use crate::run_record::Ran;
use crate::statistics::{clopper_pearson, runs_without_failure};

impl Worst {
    /// Whether a run did not keep to what is required.
    pub fn has_fallen(&self) -> bool {
        self.fallen > 0
    }

    /// The bounds of the probability that a run fails, with a confidence of 95 %, if runs were drawn at random.
    pub fn bounds(&self) -> Option<(f64, f64)> {
        let interval = clopper_pearson(self.fallen, self.runs - self.failed);
        interval.filter(|_| self.strategy == Strategy::Random).map(|(_, low, high)| (low, high))
    }

    /// The report, for people.
    pub fn text(&self, experiment: &Experiment) -> String {
        let mut text = String::new();
        let required: Vec<_> = self.requirements.iter().map(ToString::to_string).collect();
        let method = match self.strategy {
            Strategy::Random => "random",
            Strategy::CmaEs => "cma-es",
            Strategy::Splitting => "splitting",
        };
        let _ = writeln!(text, "{}: {} ({method})", experiment.name, required.join("; "));
        if let Some(likelihood) = &self.likelihood {
            return text + &likely(likelihood);
        }
        let _ = writeln!(text, "{}", self.found());
        let _ = write!(text, "{}", self.table(experiment));
        if let Some(error) = &self.error {
            let _ = writeln!(
                text,
                "{} runs could not be done; the first: {}",
                self.failed,
                error.replace('\n', " ")
            );
            if let Some(command) = &self.command {
                let _ = writeln!(text, "it is done again by {command}");
            }
        }
        if let Some(case) = &self.case {
            let _ = writeln!(text, "{}", case.account);
            let changes =
                if case.changes.is_empty() { "nothing".to_owned() } else { case.changes.join(", ") };
            if let Some(tightness) = case.tightness {
                let _ = writeln!(text, "{tightness}");
            }
            let _ = writeln!(text, "changed in the scenario: {changes} ({})", case.plainness());
        }
        text
    }

    /// How many runs failed, and what follows from that.
    fn found(&self) -> String {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let runs = self.runs;
        let head = match self.fallen {
            0 => format!("not found in {runs} runs"),
            fallen => format!("{fallen} of {runs} runs fail"),
        };
        match self.bounds() {
            Some((_, high)) if self.fallen == 0 => {
                let claim = 10_f64.powf((high / 2.0).log10().floor());
                let needed = runs_without_failure(claim)
                    .map(|needed| format!(" (for fewer than {}: {needed} runs without one)", percent(claim)));
                let needed = needed.unwrap_or_default();
                format!("{head}; with 95 % confidence fewer than {} of such runs do{needed}", percent(high))
            }
            Some((low, high)) => {
                format!("{head}; with 95 % confidence {} to {} of such runs do", percent(low), percent(high))
            }
            None => head,
        }
    }

    fn table(&self, experiment: &Experiment) -> String {
        let labels = experiment.fields.iter().map(|field| field.label.clone());
        let head: Vec<_> = ["run", "robustness", "at_s", "seed"]
            .map(str::to_owned)
            .into_iter()
            .chain(labels)
            .chain(["requirement".to_owned()])
            .collect();
        let row = |tried: &Trial| {
            let mut row = vec![
                tried.task.run.to_string(),
                format!("{:.4}{}", tried.fall.robustness, if tried.fall.holds { "" } else { " fails" }),
                format!("{:.3}", tried.fall.at_s()),
                tried.task.seed.to_string(),
            ];
            row.extend(tried.task.cell.levels.iter().map(|level| level.name.clone()));
            row.push(self.requirements[tried.fall.requirement as usize].to_string());
            row
        };
        let rows: Vec<_> = std::iter::once(head).chain(self.worst.iter().map(row)).collect();
        columns("", &rows, |i| i + 1 == rows[0].len())
    }

    /// The result as an object of JSON.
    pub fn json(&self, experiment: &Experiment) -> Value {
        let tried = |tried: &Trial| {
            let values = experiment.fields.iter().zip(&tried.task.cell.levels);
            let values: serde_json::Map<_, _> =
                values.map(|(field, level)| (field.label.clone(), json!(level.name))).collect();
            json!({
                "run": tried.task.run, "seed": tried.task.seed, "values": values, "robustness": tried.fall.robustness,
                "holds": tried.fall.holds, "at_s": tried.fall.at_s(), "state_hash": format!("{:016x}", tried.hash),
                "requirement": self.requirements[tried.fall.requirement as usize].to_string(),
            })
        };
        json!({
            "requirements": self.requirements.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "likelihood": self.likelihood.as_ref().map(|likelihood| json!({
                "probability": likelihood.probability, "interval": [likelihood.interval.0, likelihood.interval.1],
                "estimates": likelihood.estimates,
            })),
            "runs": self.runs, "fallen": self.fallen, "failed": self.failed, "error": self.error, "command": self.command,
            "bounds": self.bounds().map(|(low, high)| [low, high]),
            "worst": self.worst.iter().map(tried).collect::<Vec<_>>(),
            "case": self.case.as_ref().map(|case| json!({
                "run": case.run, "account": case.account, "changes": case.changes, "robustness": case.fall.robustness,
                "at_s": case.fall.at_s(), "robot": case.robot, "holds": case.fall.holds, "options": case.options(),
                "state_hash": format!("{:016x}", case.hash), "trials": case.trials, "is_plainest": case.is_plainest,
                "cycle": case.tightness.map(|tightness| json!({
                    "longest_ns": tightness.found_ns, "bound_ns": tightness.bound_ns, "share": tightness.share(),
                })),
            })),
        })
    }
}

/// The estimate, and what it would have cost to draw runs at random.
fn likely(Likelihood { probability, interval: (low, high), estimates, runs }: &Likelihood) -> String {
    let head = format!("{} estimates with {runs} runs in all", estimates.len());
    if *probability == 0.0 {
        return format!("no run failed, in {head}; more particles may come nearer\n");
    }
    let mut text = format!(
        "a run fails with probability {probability:.2e}; with 95 % confidence {low:.2e} to {high:.2e} ({head})\n"
    );
    let none = estimates.iter().filter(|estimate| **estimate == 0.0).count();
    if none > 0 {
        let _ = writeln!(
            text,
            "{none} of the estimates met no failure, so the interval is too narrow: give more particles in [worst]"
        );
    }
    let half = (high - low) / 2.0 / probability;
    if half > 0.0 {
        let plain = (NORMAL / half).powi(2) * (1.0 - probability) / probability;
        let _ = writeln!(text, "to draw runs at random would take {plain:.1e} for as narrow an interval");
    }
    text
}

/// The bound below which 97.5 % of the normal distribution lie.
const NORMAL: f64 = 1.96;

/// What happened, in a sentence: the age of what the brain knew, and how far the robot came in that time.
pub(super) fn account(demand: &Demand, spec: &RobotSpec, ran: &Ran, fall: &Fall) -> String {
    let verdict = if fall.holds { "holds" } else { "fails" };
    let mut text = format!(
        "{}: {demand} {verdict} by {:.4} at {:.3} s",
        Printable(&spec.name),
        fall.robustness.abs(),
        fall.at_s()
    );
    if let Some((sensor, age_ms)) = fall.stalest {
        let name = spec.sensors.get(sensor as usize).map_or("?", |sensor| sensor.name.as_str());
        let way_cm = fall.speed_m_s.abs() * age_ms / 10.0;
        let _ = write!(
            text,
            "; in the second before, the last reading of {} that the brain had was up to {age_ms:.0} ms old, in which the robot comes {way_cm:.1} cm at {:.2} m/s",
            Printable(name),
            fall.speed_m_s
        );
    }
    if !ran.ending.is_empty() {
        let _ = write!(text, " ({})", Printable(&ran.ending));
    }
    text
}

/// The longest control cycle before what decides, beside the bound of the robot's budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tightness {
    /// The longest cycle that was answered, in nanoseconds.
    pub found_ns: u64,
    /// The bound of the budget, in nanoseconds; `None` if it has none.
    pub bound_ns: Option<u64>,
}

impl Tightness {
    pub(super) fn of(scenario: &Scenario, spec: &RobotSpec, fall: &Fall) -> Option<Self> {
        let found_ns = fall.longest_cycle_ns?;
        Some(Self { found_ns, bound_ns: RobotBudget::without_remedies(scenario, spec).cycle.total.worst_ns })
    }

    /// The longest cycle as a share of the bound.
    pub fn share(&self) -> Option<f64> {
        self.bound_ns.map(|bound_ns| self.found_ns as f64 / bound_ns as f64)
    }
}

impl std::fmt::Display for Tightness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |ns: u64| ns as f64 / 1e6;
        write!(f, "longest control cycle until then: {:.1} ms", ms(self.found_ns))?;
        match (self.bound_ns, self.share()) {
            (Some(bound_ns), Some(share)) => {
                write!(f, ", {share:.2} of the {:.1} ms that its budget foretells at most", ms(bound_ns))
            }
            (None, _) | (_, None) => f.write_str(", for which its budget has no bound"),
        }
    }
}

/// Writes the files of a search.
pub(super) fn write(worst: &mut Worst, experiment: &Experiment, folder: &Folder) -> Result<(), Error> {
    let mut texts = vec![(SUMMARY, PrintableLines(worst.text(experiment)).to_string())];
    folder.remove(CASE)?;
    if let Some(case) = &worst.case {
        let file = if case.folder.is_some() { folder.file(CASE) } else { PathBuf::from(CASE) };
        let head = format!("{}\nstate {:016x}: {}\n", case.account, case.hash, case.command(&file));
        let head: String = head.lines().map(|line| format!("# {}\n", Printable(line))).collect();
        texts.push((CASE, format!("{head}\n{}", case.toml)));
    }
    for (name, text) in texts {
        let content = |out: &mut std::io::BufWriter<_>| -> Result<(), Content> {
            Ok(std::io::Write::write_all(out, text.as_bytes())?)
        };
        folder.write(name, content)?;
        worst.files.push(folder.file(name));
    }
    Ok(())
}

/// Removes the files of an earlier search.
pub(super) fn remove(folder: &Folder) -> Result<(), Error> {
    [SUMMARY, CASE].iter().try_for_each(|name| folder.remove(name))
}

const SUMMARY: &str = "summary.txt";

/// The scenario of the worst run.
const CASE: &str = "worst.toml";
