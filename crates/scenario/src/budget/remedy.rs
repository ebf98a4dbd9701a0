//! Remedies for a robot that misses its deadline: each change is made, and the budget computed again, as long as
//! the [`Allowance`] lasts.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use super::change::{Change, Robot};
use super::plan::Plan;
use super::report::{Cost, Remedy, RobotBudget, Verdict};
use super::{Allowance, BRIEF, FULL};
use baudbot_sim::Scenario;

/// Adds the changes that fix it alone; if there is none, as many of the cheapest as it takes together.
pub(super) fn add(scenario: &Scenario, plan: &Plan<'_>, budget: &mut RobotBudget, allowance: &mut Allowance) {
    if budget.verdict != Verdict::Misses {
        return;
    }
    let robot = Robot { spec: plan.spec.clone(), step_ns: plan.step_ns, substeps: scenario.substeps };
    let mut search = Search { plan, allowance, tries: MOST_TRIES, remedies: Vec::new() };
    let is_done = search.look(&robot).is_ok();
    search.remedies.sort_by_key(|remedy| remedy.cost);
    budget.remedies = search.remedies;
    budget.left_out = (!is_done).then(|| NOT_ALL.to_string());
}

/// Most changed robots that are computed for one.
const MOST_TRIES: usize = 200;

const NOT_ALL: &str = "not every possible fix was tried: that would take too long";

/// Nothing more may be tried.
struct UsedUp;

type Result<T> = core::result::Result<T, UsedUp>;

struct Search<'a> {
    plan: &'a Plan<'a>,
    allowance: &'a mut Allowance,
    tries: usize,
    remedies: Vec<Remedy>,
}

impl Search<'_> {
    fn look(&mut self, robot: &Robot) -> Result<()> {
        for changes in robot.changes() {
            self.alone(robot, &changes)?;
        }
        if self.remedies.iter().all(|remedy| remedy.cost >= Cost::LongerStep) {
            self.together(robot)?;
        }
        Ok(())
    }

    /// The smallest change of a kind that is enough.
    fn alone(&mut self, robot: &Robot, changes: &[Change]) -> Result<()> {
        for &change in changes {
            self.count()?;
            let changed = robot.with(change);
            if RobotBudget::keeps(&self.changed(&changed), BRIEF, self.allowance) {
                return self.promise(robot, &[change]);
            }
        }
        Ok(())
    }

    /// One change after the other, the cheapest first, each as far as it helps, until the step is kept. The step
    /// itself stays, and so do the sensors.
    fn together(&mut self, robot: &Robot) -> Result<()> {
        let mut done = Vec::new();
        let mut now = robot.clone();
        let mut worst = self.badness(robot)?;
        let mut kinds = robot.changes();
        kinds.sort_by_key(|changes| changes[0].cost());
        for changes in kinds {
            if matches!(changes[0], Change::Step(_) | Change::Drop(_)) {
                continue;
            }
            let Some((badness, change)) = self.best(&now, &changes, worst)? else { continue };
            (worst, now) = (badness, now.with(change));
            done.push(change);
            if keeps(worst) {
                return if done.len() > 1 { self.promise(robot, &done) } else { Ok(()) };
            }
        }
        Ok(())
    }

    /// The first change that is enough, of those that are better than `worst`, else the best.
    fn best(&mut self, now: &Robot, changes: &[Change], worst: Badness) -> Result<Option<(Badness, Change)>> {
        let mut best: Option<(Badness, Change)> = None;
        for &change in changes {
            let badness = self.badness(&now.with(change))?;
            if badness < best.map_or(worst, |(best, _)| best) {
                best = Some((badness, change));
            }
            if keeps(badness) {
                break;
            }
        }
        Ok(best)
    }

    fn badness(&mut self, robot: &Robot) -> Result<Badness> {
        self.count()?;
        let budget = RobotBudget::computed(&self.changed(robot), BRIEF, self.allowance);
        let over = budget.loads.iter().map(|load| ((load.share - 1.0).max(0.0) * 1e6) as u64).sum();
        Ok((budget.verdict, over, budget.cycle.total.typical_ns.unwrap_or(u64::MAX)))
    }

    fn count(&mut self) -> Result<()> {
        if self.allowance.is_used_up() {
            return Err(UsedUp);
        }
        self.tries = self.tries.checked_sub(1).ok_or(UsedUp)?;
        Ok(())
    }

    fn changed<'a>(&self, robot: &'a Robot) -> Plan<'a> {
        Plan {
            spec: &robot.spec,
            step_ns: robot.step_ns,
            noise: self.plan.noise,
            measured: self.plan.measured,
        }
    }

    /// Promises these changes, one after the other, if they are enough in a longer dry run too.
    fn promise(&mut self, robot: &Robot, changes: &[Change]) -> Result<()> {
        self.count()?;
        let mut now = robot.clone();
        let (mut phrases, mut overrides) = (Vec::new(), Some(Vec::new()));
        for &change in changes {
            phrases.push(now.phrase(change));
            overrides = overrides.zip(now.overrides(change)).map(|(mut all, more): (Vec<String>, _)| {
                all.extend(more);
                all
            });
            now = now.with(change);
        }
        let budget = RobotBudget::computed(&self.changed(&now), FULL, self.allowance);
        self.remedies.extend((budget.verdict != Verdict::Misses).then(|| Remedy {
            what: phrases.join(" and "),
            cost: changes.iter().map(|change| change.cost()).max().unwrap_or(Cost::Setting),
            overrides: overrides.unwrap_or_default(),
            step_ns: now.step_ns,
            total: budget.cycle.total,
            verdict: budget.verdict,
        }));
        Ok(())
    }
}

/// The badness of a budget: the overloaded resources and the excess, and the duration of the cycle.
type Badness = (Verdict, u64, u64);

fn keeps(badness: Badness) -> bool {
    badness.0 != Verdict::Misses
}
