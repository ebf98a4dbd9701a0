//! The points that a search tries, batch by batch: a function of what was found so far, so that a search goes on from its journal alone.
//!
//! Points are in the unit cube: each coordinate is how much of its field's range, or of the list of its values, lies below.

use baudbot_sim::random::Stream;

use crate::error::Error;
use crate::raw::{Method, Strategy};
use crate::tune::course::{Course, suited_population};

/// A search that is under way.
#[derive(Clone, Debug)]
pub(super) struct Search {
    strategy: Strategy,
    seed: u64,
    dimensions: usize,
    /// Points drawn so far.
    drawn: u64,
    stage: Stage,
}

/// The next thing to do.
#[derive(Clone, Debug)]
enum Stage {
    /// To draw points.
    Draw,
    /// To adapt a distribution, from the worst of those that were drawn on.
    Adapt { course: Course, past: Vec<Vec<f64>>, least: f64, since: usize },
}

impl Search {
    pub(super) fn new(strategy: Strategy, seed: u64, dimensions: usize) -> Self {
        Self { strategy, seed, dimensions, drawn: 0, stage: Stage::Draw }
    }

    /// The next points to try.
    ///
    /// # Errors
    /// The optimizer's.
    pub(super) fn next(&mut self) -> Result<Vec<Vec<f64>>, Error> {
        if let Stage::Adapt { course, past, since, .. } = &self.stage
            && *since < STALLED
            && past.len() < LONGEST
            && let Some(points) = course.generation(past)?
        {
            return Ok(points);
        }
        self.stage = Stage::Draw;
        let count = match self.strategy {
            Strategy::Random | Strategy::Splitting => BATCH,
            Strategy::CmaEs => DRAWN * suited_population(self.dimensions) as u64,
        };
        let points = (self.drawn..self.drawn + count).map(|i| self.draw(i)).collect();
        self.drawn += count;
        Ok(points)
    }

    /// Takes in the robustness of the points that were tried last.
    pub(super) fn tell(&mut self, points: &[Vec<f64>], costs: Vec<f64>) {
        match &mut self.stage {
            Stage::Draw if self.strategy == Strategy::CmaEs => {
                let worst = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
                let Some(worst) = worst else { return };
                let course = Course {
                    method: Method::CmaEs,
                    dimensions: self.dimensions,
                    population: suited_population(self.dimensions),
                    // Each descent has random numbers of its own.
                    seed: self.seed.wrapping_add(self.drawn),
                    start: Some(points[worst].clone()),
                };
                self.stage = Stage::Adapt { course, past: Vec::new(), least: costs[worst], since: 0 };
            }
            Stage::Draw => {}
            Stage::Adapt { past, least, since, .. } => {
                let found = costs.iter().copied().fold(f64::INFINITY, f64::min);
                *since = if found < *least { 0 } else { *since + 1 };
                *least = least.min(found);
                past.push(costs);
            }
        }
    }

    /// A point to begin with. Where a descent goes on from it, every second point is drawn towards ends of ranges: what is at its
    /// limit breaks first. Points whose likelihood is counted are drawn evenly.
    fn draw(&self, number: u64) -> Vec<f64> {
        let mut stream = Stream::new(self.seed, &format!("worst/{number}"));
        let is_at_ends = self.strategy == Strategy::CmaEs && number.is_multiple_of(2);
        let coordinate = |_| match stream.uniform() {
            share if !is_at_ends => share,
            share if share < AT_AN_END / 2.0 => 0.0,
            share if share < AT_AN_END => 1.0,
            _ => stream.uniform(),
        };
        (0..self.dimensions).map(coordinate).collect()
    }
}

/// The probability that a coordinate is at one of the two ends of its range, in points that are drawn towards them.
const AT_AN_END: f64 = 0.5;

/// Runs of a batch that depend on no others.
const BATCH: u64 = 64;

/// Points that are drawn before a descent, as a multiple of the runs of a generation.
const DRAWN: u64 = 4;

/// A descent is over after so many generations in which nothing worse was found,
const STALLED: usize = 8;

/// and in any case after so many.
const LONGEST: usize = 60;

#[cfg(test)]
mod tests {
    use super::*;

    fn run(
        strategy: Strategy,
        seed: u64,
        batches: usize,
        cost: impl Fn(&[f64]) -> f64,
    ) -> Vec<(Vec<f64>, f64)> {
        let mut search = Search::new(strategy, seed, 2);
        let mut all = Vec::new();
        for _ in 0..batches {
            let points = search.next().unwrap();
            let costs: Vec<_> = points.iter().map(|point| cost(point)).collect();
            all.extend(points.iter().cloned().zip(costs.iter().copied()));
            search.tell(&points, costs);
        }
        all
    }

    /// A hole of this width about (0.83, 0.21), in a plain that hardly leans.
    fn hole(width: f64) -> impl Fn(&[f64]) -> f64 {
        move |point| {
            let distance = (point[0] - 0.83).hypot(point[1] - 0.21);
            1.0 + 0.1 * distance - 2.0 * (-(distance / width).powi(2)).exp()
        }
    }

    #[test]
    fn points_that_are_drawn_fill_the_cube_and_depend_on_the_seed_alone() {
        let points = |seed, cost: fn(&[f64]) -> f64| {
            run(Strategy::Random, seed, 10, cost).into_iter().map(|(point, _)| point).collect::<Vec<_>>()
        };
        let all = points(1, |_| 0.0);
        assert!(all == points(1, |point| point[0]) && all != points(2, |_| 0.0));
        for quarter in 0..4 {
            let is_in =
                |point: &[f64]| usize::from(point[0] > 0.5) + 2 * usize::from(point[1] > 0.5) == quarter;
            let count = all.iter().filter(|point| is_in(point)).count();
            assert!((120..200).contains(&count), "{quarter}: {count} of {}", all.len());
        }
    }

    #[test]
    fn a_hole_that_leans_is_found_with_fewer_runs_than_by_drawing() {
        let runs = |strategy, seed| {
            let all = run(strategy, seed, 400, hole(0.1));
            all.iter().position(|(_, cost)| *cost < -0.9).map_or(usize::MAX, |place| place + 1)
        };
        let mut adapted: Vec<_> = (1..=9).map(|seed| runs(Strategy::CmaEs, seed)).collect();
        let mut drawn: Vec<_> = (1..=9).map(|seed| runs(Strategy::Random, seed)).collect();
        adapted.sort_unstable();
        drawn.sort_unstable();
        assert!(adapted[8] < usize::MAX && 2 * adapted[4] < drawn[4], "{adapted:?} {drawn:?}");
    }

    #[test]
    fn what_fails_at_the_ends_of_its_ranges_is_found_among_the_first() {
        // One in a hundred points that are drawn evenly.
        let cost = |point: &[f64]| if point[0] > 0.9 && point[1] < 0.1 { -1.0 } else { 1.0 };
        let runs =
            |seed| run(Strategy::CmaEs, seed, 60, cost).iter().position(|(_, cost)| *cost < 0.0).unwrap();
        let mut found: Vec<_> = (1..=9).map(runs).collect();
        found.sort_unstable();
        assert!(found[4] < 30, "{found:?}");
    }

    #[test]
    fn a_descent_that_finds_nothing_is_given_up_and_another_begins_elsewhere() {
        let all = run(Strategy::CmaEs, 1, 200, |_| 1.0);
        let far = all.iter().filter(|(point, _)| point[0] < 0.1).count();
        assert!(far > all.len() / 50, "{far} of {}", all.len());
        assert_eq!(all, run(Strategy::CmaEs, 1, 200, |_| 1.0));
    }
}
