//! The score: what was counted of a run, and whether it has been enough.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Pose, Ray};
use serde::{Deserialize, Serialize};

use super::{Ending, World};
use crate::coverage::{Coverage, Floor};
use crate::model::{OnLate, RobotSpec};
use crate::rules::Rules;
use crate::scenario::Scenario;
use crate::scene::Scene;

/// The referee's counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    coverage: Option<Coverage>,
    /// Whether any robot has been in each zone.
    visited: Vec<bool>,
    /// The time of each robot in each zone, in nanoseconds.
    in_zone_ns: Vec<Vec<u64>>,
}

impl Score {
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let zones = scenario.surroundings.zones.len();
        Self {
            coverage: scenario.rules.floor.as_ref().map(Coverage::new),
            visited: alloc::vec![false; zones],
            in_zone_ns: alloc::vec![alloc::vec![0; zones]; scenario.robots.len()],
        }
    }

    /// Whether this score may have become what `other` is: it counts the same things, and no cells that are none.
    pub(crate) fn may_become(&self, other: &Self, floor: Option<&Floor>) -> bool {
        let zones = |score: &Self| score.in_zone_ns.iter().map(Vec::len).collect::<Vec<_>>();
        let coverage = match (floor, &other.coverage) {
            (Some(floor), Some(coverage)) => coverage.is_of(floor),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        self.visited.len() == other.visited.len()
            && zones(self) == zones(other)
            && other.in_zone_ns.iter().flatten().all(|&ns| crate::sound::count(ns))
            && coverage
    }

    /// The covered and the sensed cells of the floor, if they are counted.
    pub fn coverage(&self) -> Option<&Coverage> {
        self.coverage.as_ref()
    }

    /// Share of the free floor that bodies have covered, if that is counted.
    pub fn covered(&self, rules: &Rules) -> Option<f64> {
        Some(self.coverage.as_ref()?.floor_fraction(rules.floor.as_ref()?))
    }

    /// Share of the free floor that the rays of the chosen sensor have reached, if that is counted.
    pub fn sensed(&self, rules: &Rules) -> Option<f64> {
        let coverage = self.coverage.as_ref().filter(|_| rules.count_sensed())?;
        Some(coverage.sensed_fraction(rules.floor.as_ref()?))
    }

    /// Whether any robot has been in each zone, in the scenario's order.
    pub fn visited(&self) -> &[bool] {
        &self.visited
    }

    /// Time of a robot in each zone, in nanoseconds.
    pub fn in_zone_ns(&self, robot: usize) -> &[u64] {
        &self.in_zone_ns[robot]
    }
}

impl World {
    /// Counts what happened in the tick that began with the robots at `before`.
    pub(crate) fn keep_score(&mut self, before: &[Pose]) {
        let scenario = alloc::sync::Arc::clone(self.scenario());
        for own in 0..before.len() {
            self.count_zones(&scenario, own);
        }
        let Some(floor) = &scenario.rules.floor else { return };
        let Some(mut coverage) = self.state_mut().score.coverage.take() else { return };
        for (own, (before, spec)) in before.iter().zip(&scenario.robots).enumerate() {
            let disc = |pose: &Pose| Circle { center: pose.position, radius: spec.covers_m() };
            coverage.cover_swept(floor, &disc(before), &disc(&self.robot(own).motion().pose));
        }
        let sense_ns = scenario.rules.sense_ns.max(1);
        if self.time().as_ns() % sense_ns < scenario.step_ns {
            self.sense(&scenario, floor, &mut coverage);
        }
        self.state_mut().score.coverage = Some(coverage);
    }

    fn count_zones(&mut self, scenario: &Scenario, own: usize) {
        let position = self.robot(own).motion().pose.position;
        let step_ns = scenario.step_ns;
        let score = &mut self.state_mut().score;
        for (i, zone) in scenario.surroundings.zones.iter().enumerate() {
            if zone.region.contains(position) {
                score.visited[i] = true;
                score.in_zone_ns[own][i] += step_ns;
            }
        }
    }

    /// Marks what the rays of the chosen sensors reach, as they truly are: noise is no matter of coverage.
    fn sense(&self, scenario: &Scenario, floor: &Floor, coverage: &mut Coverage) {
        let frozen = self.frozen();
        for (own, sensor) in scenario.rules.sensed_by.iter().enumerate() {
            let Some(sensor) = sensor else { continue };
            let scene = scenario.scene(&frozen, self.trails(), own);
            let device = &scenario.robots[own].sensors[*sensor].device;
            let (Some(mount), Some(range_m), Some(fan)) = (device.mount(), device.range_m(), device.fan())
            else {
                continue;
            };
            let robot = self.robot(own);
            let pose = mount.place(&robot.motion().pose, robot.actuators());
            let viewpoint = Scene::look(&scene, pose.position, mount.height, range_m);
            let forward = pose.direction();
            viewpoint.each(&pose, fan, |i, distance_m| {
                let ray = Ray { origin: pose.position, direction: forward.rotate(fan.relative()[i]) };
                coverage.sense_ray(floor, pose.position, ray.at(distance_m.min(range_m)));
            });
        }
    }

    /// Whether the run ends by the rules.
    pub(crate) fn judge(&self) -> Option<Ending> {
        let (scenario, rules) = (self.scenario(), &self.scenario().rules);
        let collisions = || self.robots().map(|robot| robot.counters().collisions).sum::<u64>();
        if let Some(limit) = rules.collisions.filter(|&limit| collisions() >= limit) {
            return Some(Ending::Collisions(limit));
        }
        let goals =
            || scenario.surroundings.zones.iter().zip(self.score().visited()).filter(|(zone, _)| zone.goal);
        if rules.all_goals && goals().all(|(_, visited)| *visited) {
            return Some(Ending::AllGoals);
        }
        let reached =
            |share: Option<f64>, wanted: Option<f64>| matches!((share, wanted), (Some(a), Some(b)) if a >= b);
        if reached(self.score().covered(rules), rules.covered) {
            return Some(Ending::Covered);
        }
        if reached(self.score().sensed(rules), rules.sensed) {
            return Some(Ending::Sensed);
        }
        let empty = |robot: &crate::RobotView<'_>| {
            robot.battery().is_some_and(|(battery, state)| state.is_empty(battery))
        };
        if rules.battery_empty
            && let Some(robot) = self.robots().find(empty)
        {
            return Some(Ending::BatteryEmpty(String::clone(&robot.spec().name)));
        }
        let too_late = |robot: &crate::RobotView<'_>| {
            robot.spec().deadline.on_late == Some(OnLate::End) && robot.cycles().late > 0
        };
        let late = rules.missed_deadline.then(|| self.robots().find(too_late)).flatten();
        late.map(|robot| Ending::DeadlineMissed(String::clone(&robot.spec().name)))
    }
}

impl RobotSpec {
    /// Radius of the disc that counts as covered, in metres: of a body with corners, one that lies inside of it.
    fn covers_m(&self) -> f64 {
        self.form().thickness_m().max(if self.outline.is_empty() { self.drive.radius_m } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_score_becomes_only_one_that_counts_the_same() {
        let score = Score {
            coverage: None,
            visited: alloc::vec![false; 2],
            in_zone_ns: alloc::vec![alloc::vec![0; 2]],
        };
        let with = |change: fn(&mut Score)| {
            let mut other = score.clone();
            change(&mut other);
            other
        };
        let later = with(|score| (score.visited[1], score.in_zone_ns[0][1]) = (true, 5));
        assert!(score.may_become(&later, None));
        for other in [
            with(|score| score.visited.push(false)),
            with(|score| score.in_zone_ns.push(Vec::new())),
            with(|score| score.in_zone_ns[0].push(0)),
            with(|score| score.in_zone_ns[0][0] = u64::MAX),
        ] {
            assert!(!score.may_become(&other, None), "{other:?}");
        }
    }
}
