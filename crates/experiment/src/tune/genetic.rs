//! A genetic algorithm on points of the unit cube.
//!
//! The first generation is anywhere. Each later one is bred from the one before it and the best point of all, which lives on:
//! for each child two parents are selected by tournament, each coordinate is a blend of theirs (BLX-α of Eshelman and
//! Schaffer, 1993), and some coordinates then mutate by creeping: mostly a little, never by more than [`CREEP`].

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

use super::course::Course;
use super::optimizers::fold;

/// The points of the generation after those whose costs are given. The first has as many as the population, all others one
/// less, as the best is kept.
pub(super) fn generation(course: &Course, past: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut chance = Chance(Xoshiro256PlusPlus::seed_from_u64(course.seed));
    let mut points: Vec<Vec<f64>> =
        (0..course.population).map(|_| (0..course.dimensions).map(|_| chance.share()).collect()).collect();
    let mut best: Option<Individual> = None;
    for costs in past {
        let born = points.into_iter().zip(costs).map(|(genes, &cost)| Individual { genes, cost });
        let parents: Vec<_> = best.into_iter().chain(born).collect();
        points = (1..course.population).map(|_| chance.child(&parents)).collect();
        best = parents.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    }
    points
}

/// A point and what it costs.
struct Individual {
    genes: Vec<f64>,
    cost: f64,
}

struct Chance(Xoshiro256PlusPlus);

impl Chance {
    /// A number from 0 to 1, and never 1.
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn child(&mut self, parents: &[Individual]) -> Vec<f64> {
        let (mother, father) = (self.selected(parents), self.selected(parents));
        let mutates = MUTATIONS / mother.genes.len() as f64;
        let gene = |(a, b): (&f64, &f64)| {
            let blended = a + (b - a) * (self.share() * (1.0 + 2.0 * BLEND) - BLEND);
            if self.share() >= mutates {
                return fold(blended);
            }
            let far = 2.0 * self.share() - 1.0;
            fold(blended + CREEP * far * far.abs())
        };
        mother.genes.iter().zip(&father.genes).map(gene).collect()
    }

    /// Tournament selection: of some at random, from the best to the worst, each wins with a probability, and the last always.
    fn selected<'a>(&mut self, all: &'a [Individual]) -> &'a Individual {
        let mut asked: [_; TOURNAMENT] =
            std::array::from_fn(|_| &all[(self.share() * all.len() as f64) as usize]);
        asked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let winner = (0..TOURNAMENT - 1).find(|_| self.share() < WINS);
        asked[winner.unwrap_or(TOURNAMENT - 1)]
    }
}

/// Individuals of a tournament.
const TOURNAMENT: usize = 3;

/// The probability with which the best of those that are left wins.
const WINS: f64 = 0.8;

/// The distance beyond its parents at which a child may be, as a fraction of theirs.
const BLEND: f64 = 0.25;

/// Mutations of a child, on average; of a single coordinate each child's.
const MUTATIONS: f64 = 2.0;

/// Largest mutation, as a share of the range.
const CREEP: f64 = 0.125;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raw::Method;

    const COURSE: Course =
        Course { method: Method::Genetic, dimensions: 2, population: 12, seed: 3, start: None };

    #[test]
    fn the_best_is_never_lost_and_never_asked_for_again() {
        let cost = |point: &[f64]| (point[0] - 0.2).hypot(point[1] - 0.9);
        let mut past: Vec<Vec<f64>> = Vec::new();
        let mut seen: Vec<Vec<f64>> = Vec::new();
        for number in 0..30 {
            let points = generation(&COURSE, &past);
            assert_eq!(points.len(), if number == 0 { 12 } else { 11 });
            assert!(points.iter().all(|point| !seen.contains(point)), "{points:?}");
            past.push(points.iter().map(|point| cost(point)).collect());
            seen.extend(points);
        }
        let least = past.concat().into_iter().fold(f64::INFINITY, f64::min);
        assert!(least < 0.01, "{least}");
        // Equal costs pull nowhere: children are all over the place.
        let same: Vec<_> = past.iter().map(|costs| vec![1.0; costs.len()]).collect();
        let last = generation(&COURSE, &same);
        assert!(last.iter().any(|point| cost(point) > 0.1), "{last:?}");
    }

    #[test]
    fn a_tournament_prefers_the_better_and_gives_the_worst_a_chance() {
        let all: Vec<_> =
            (0..10).map(|i| Individual { genes: vec![f64::from(i)], cost: f64::from(i) }).collect();
        let mut chance = Chance(Xoshiro256PlusPlus::seed_from_u64(1));
        let mut won = [0_u32; 10];
        (0..10_000).for_each(|_| won[chance.selected(&all).cost as usize] += 1);
        assert!(won[..6].is_sorted_by(|a, b| a > b) && won[9] > 0, "{won:?}");
        // The best is among three of ten with 1 - 0.9³, and then wins with 0.8; else it is asked for again.
        assert!((2100..2400).contains(&won[0]), "{won:?}");
    }
}
