//! Optimizers, each as a function of what was found so far: two of well-kept crates, and the one of `genetic`.
//!
//! An optimizer with a seed does the same for the same costs. So it needs no state of its own here: to go on it is run
//! from its beginning. That makes a tuning that was killed go on where it was, from its journal alone, and lets the
//! candidates of a generation be run side by side in any order.
//!
//! Points are in the unit cube: each coordinate is how much of its field's range lies below. Costs are to be made small.

use std::fmt::Display;

use argmin::core::{CostFunction, PopulationState, Problem, Solver, State};
use argmin::solver::particleswarm::ParticleSwarm;
use cmaes::{CMAESOptions, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::course::Course;
use super::genetic;
use super::ledger::Ledger;
use crate::error::Error;
use crate::raw::Method;

/// Whether there are optimizers in this program.
#[expect(clippy::unnecessary_wraps, reason = "it is as the one of a program without")]
pub(crate) fn check() -> Result<(), Error> {
    Ok(())
}

impl Course {
    /// The points of the generation after those whose costs are given; `None` if the optimizer has found what it can.
    ///
    /// # Errors
    /// The optimizer's error.
    pub(crate) fn generation(&self, past: &[Vec<f64>]) -> Result<Option<Vec<Vec<f64>>>, Error> {
        let ledger = Ledger::new(past);
        let goes_on = match self.method {
            Method::CmaEs => self.sample(past.len(), &ledger)?,
            Method::Swarm => self.swarm(past.len(), &ledger)?,
            Method::Genetic => return Ok(Some(genetic::generation(self, past))),
        };
        Ok(goes_on.then(|| ledger.into_asked()))
    }

    fn sample(&self, past: usize, ledger: &Ledger) -> Result<bool, Error> {
        let folded = |point: &DVector<f64>| point.iter().map(|x| fold(*x)).collect::<Vec<_>>();
        let start = self.start.clone().unwrap_or_else(|| vec![0.5; self.dimensions]);
        let options = CMAESOptions::new(start, FIRST_STEP).tol_x(LEAST_STEP);
        let options = options.population_size(self.population).seed(self.seed);
        let cost = |point: &DVector<f64>| ledger.cost(&folded(point));
        let mut optimizer = options.build(cost).map_err(|error| failed(format!("{error:?}")))?;
        let is_over = (0..past).any(|_| optimizer.next().is_some());
        if !is_over {
            let _ = optimizer.next();
        }
        Ok(!is_over)
    }

    fn swarm(&self, past: usize, ledger: &Ledger) -> Result<bool, Error> {
        let bounds = (vec![0.0; self.dimensions], vec![1.0; self.dimensions]);
        let random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut swarm: ParticleSwarm<_, f64, _> =
            ParticleSwarm::new(bounds, self.population).with_rng_generator(random);
        let mut problem = Problem::new(Told(ledger.clone()));
        let (mut state, _) = swarm.init(&mut problem, PopulationState::new()).map_err(failed)?;
        for _ in 0..past {
            (state, _) = swarm.next_iter(&mut problem, state).map_err(failed)?;
        }
        Ok(true)
    }
}

/// The failure of an optimizer.
fn failed(problem: impl Display) -> Error {
    Error::field("tune", format!("the optimizer reports: {problem}"))
}

/// The costs for the optimizers of a crate.
#[derive(Clone, Debug)]
struct Told(Ledger);

impl CostFunction for Told {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok(self.0.cost(point))
    }
}

/// Into the range from 0 to 1, as in a mirror at either end.
pub(super) fn fold(x: f64) -> f64 {
    let once = x.rem_euclid(2.0);
    if once > 1.0 { 2.0 - once } else { once }
}

/// Step of the first generation, as a share of the ranges: most of each is within two of them.
const FIRST_STEP: f64 = 0.25;

/// Steps below this share of the ranges are over.
const LEAST_STEP: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    const METHODS: [Method; 3] = [Method::CmaEs, Method::Swarm, Method::Genetic];

    /// An ellipse that leans, with its least at (0.7, 0.3, 0.3, …).
    fn bowl(point: &[f64]) -> f64 {
        let from = |i: usize| point[i] - if i == 0 { 0.7 } else { 0.3 };
        let aside: f64 = (1..point.len()).map(|i| (from(i) - 0.5 * from(0)).powi(2)).sum();
        from(0).powi(2) + 10.0 * aside
    }

    fn course(method: Method, dimensions: usize) -> Course {
        Course { method, dimensions, population: 12, seed: 3, start: None }
    }

    /// All points, generation by generation.
    fn run(course: &Course, generations: usize) -> Vec<Vec<Vec<f64>>> {
        let (mut past, mut points) = (Vec::new(), Vec::new());
        while points.len() < generations {
            let Some(next) = course.generation(&past).unwrap() else { break };
            past.push(next.iter().map(|point| bowl(point)).collect());
            points.push(next);
        }
        points
    }

    #[test]
    fn each_method_finds_the_bottom_of_a_bowl_and_stays_in_the_ranges() {
        for method in METHODS {
            let mut bests = [1, 2, 3, 4, 5].map(|seed| {
                let points = run(&Course { seed, ..course(method, 3) }, 40);
                let all = || points.iter().flatten();
                assert!(all().flatten().all(|x| (0.0..=1.0).contains(x)), "{method:?}");
                assert!(points.iter().all(|generation| generation.len() <= 12), "{method:?}");
                let best = all().map(|point| bowl(point)).fold(f64::INFINITY, f64::min);
                let first = points[0].iter().map(|point| bowl(point)).fold(f64::INFINITY, f64::min);
                (best, best / first)
            });
            bests.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (best, share) = bests[2];
            assert!(best < 2e-3 && share < 0.1, "{method:?}: {bests:?}");
        }
    }

    #[test]
    fn a_search_that_goes_on_asks_for_the_same_as_one_that_never_stopped() {
        for method in METHODS {
            let course = course(method, 2);
            let points = run(&course, 6);
            assert_eq!(points, run(&course, 6), "{method:?}");
            let past: Vec<Vec<f64>> =
                points[..4].iter().map(|all| all.iter().map(|point| bowl(point)).collect()).collect();
            assert_eq!(course.generation(&past).unwrap().as_ref(), Some(&points[4]), "{method:?}");
            let other = Course { seed: 4, ..course };
            assert_ne!(points, run(&other, 6), "{method:?}");
        }
    }

    #[test]
    fn a_single_number_can_be_looked_for() {
        for method in METHODS {
            let points = run(&course(method, 1), 20);
            let best = points.iter().flatten().map(|point| bowl(point)).fold(f64::INFINITY, f64::min);
            assert!(best < 1e-3, "{method:?}: {best}");
        }
    }

    #[test]
    fn one_that_has_converged_is_over() {
        let points = run(&course(Method::CmaEs, 2), 1000);
        assert!(points.len() < 200, "{}", points.len());
    }

    #[test]
    fn what_is_beyond_an_end_is_folded_back() {
        for (x, expected) in [(0.25, 0.25), (1.25, 0.75), (-0.25, 0.25), (2.5, 0.5), (-1.5, 0.5)] {
            assert!((fold(x) - expected).abs() < 1e-12, "{x}");
        }
    }
}
