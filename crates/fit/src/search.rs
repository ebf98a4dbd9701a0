//! The least cost of a few numbers, and how far each of them can go before the cost has risen.
//!
//! A cost is −log L, the negative logarithm of a likelihood. The interval of a number is the set of its values at which the
//! least cost over all others exceeds the least cost of all by no more than [`REGULAR`]: half of 3.84, the 95 % quantile of
//! χ² with one degree of freedom. The edge of a distribution, such as the width of a uniform one, is no regular number: the
//! cost rises linearly beyond its best value, and twice the rise has a χ² distribution with two degrees of freedom. Where
//! other numbers move the edges, too, there are two more for each of them ([`EDGES`]).
//!
//! The optimiser is Nelder and Mead's, in coordinates from 0 to 1, started again where it stopped.

use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

/// Rise of the cost at the ends of the interval of a regular number.
pub const REGULAR: f64 = 1.920_729;

/// The same for the edge of a distribution that nothing else moves, and where one or two other numbers do: half the 95 %
/// quantiles of χ² with 2, 4 and 6 degrees of freedom.
pub const EDGES: [f64; 3] = [2.995_732, 4.743_865, 6.295_794];

/// The scale on which a number is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// The scale of the logarithm. The least value that is tried stands for 0.
    Log,
    /// The scale of the logarithm, for a number that cannot be 0.
    Positive,
}

/// A number that is searched.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The least value that is tried.
    pub from: f64,
    /// The greatest.
    pub to: f64,
    /// The scale of the search.
    pub scale: Scale,
    /// The rise of the cost at the ends of its interval.
    pub rise: f64,
}

impl Unknown {
    /// A regular number in this range.
    pub fn linear(from: f64, to: f64) -> Self {
        Self { from, to, scale: Scale::Linear, rise: REGULAR }
    }

    /// A regular number in this range, which is searched by its logarithm and may be 0.
    pub fn log(from: f64, to: f64) -> Self {
        Self { from, to, scale: Scale::Log, rise: REGULAR }
    }

    /// A regular number above 0 in this range, which is searched by its logarithm.
    pub fn positive(from: f64, to: f64) -> Self {
        Self { from, to, scale: Scale::Positive, rise: REGULAR }
    }

    /// The same number with another rise.
    pub fn rising(self, rise: f64) -> Self {
        Self { rise, ..self }
    }

    /// The number at a share of the range.
    pub fn at(&self, share: f64) -> f64 {
        let share = share.clamp(0.0, 1.0);
        match self.scale {
            Scale::Linear => self.from + share * (self.to - self.from),
            Scale::Log | Scale::Positive => self.from * (self.to / self.from).powf(share),
        }
    }

    /// The share of the range at which a number is.
    pub fn share(&self, number: f64) -> f64 {
        let share = match self.scale {
            Scale::Linear => (number - self.from) / (self.to - self.from),
            Scale::Log | Scale::Positive => {
                (number.max(self.from) / self.from).ln() / (self.to / self.from).ln()
            }
        };
        share.clamp(0.0, 1.0)
    }
}

/// The numbers of least cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The numbers.
    pub values: Vec<f64>,
    /// The cost of the numbers.
    pub cost: f64,
}

/// The interval of a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// Whether the cost had not risen at the least value that is tried.
    pub open_low: bool,
    /// The same of the greatest.
    pub open_high: bool,
    /// The number that went farthest with it, and how far, as a share of its range.
    pub partner: Option<(usize, f64)>,
}

impl Interval {
    /// The width as a share of the range that is tried.
    pub fn share(&self, unknown: &Unknown) -> f64 {
        unknown.share(self.high) - unknown.share(self.low)
    }
}

/// A search: numbers and their cost.
pub struct Search<'a> {
    /// The numbers.
    pub unknowns: Vec<Unknown>,
    /// −log L of their values; infinite where there is none.
    pub cost: &'a dyn Fn(&[f64]) -> f64,
}

impl Search<'_> {
    /// The numbers of least cost that are found from any of these.
    pub fn best(&self, starts: &[Vec<f64>]) -> Best {
        let free: Vec<usize> = (0..self.unknowns.len()).collect();
        let sizes = STEPS.map(|step| vec![step; free.len()]);
        let found = starts.iter().map(|start| self.from(&self.shares(start), &free, &sizes));
        let found = found.reduce(|a, b| if b.1 < a.1 { b } else { a });
        let (shares, cost) = found.unwrap_or_else(|| (vec![0.5; self.unknowns.len()], f64::INFINITY));
        Best { values: self.values(&shares), cost }
    }

    /// The interval around the best value of a number. If better numbers are found on the way, they replace the best.
    pub fn interval(&self, best: &mut Best, of: usize) -> Interval {
        for _ in 0..RETRIES {
            match self.walk(best, of, SLACK) {
                Ok(interval) => return interval,
                Err(better) => *best = self.best(&[better.values]),
            }
        }
        // So rugged a likelihood has no best that can be found: what is as good is inside.
        self.walk(best, of, f64::INFINITY).unwrap_or_else(|better| {
            let value = better.values[of];
            Interval { low: value, high: value, open_low: true, open_high: true, partner: None }
        })
    }

    fn walk(&self, best: &Best, of: usize, slack: f64) -> Result<Interval, Best> {
        let low = self.end(best, (of, -1.0), slack)?;
        let high = self.end(best, (of, 1.0), slack)?;
        let unknown = &self.unknowns[of];
        let partner = [&low, &high].into_iter().flat_map(|end| {
            let moved = |i: usize| (end.shares[i] - self.unknowns[i].share(best.values[i])).abs();
            (0..self.unknowns.len()).filter(|i| *i != of).map(move |i| (i, moved(i)))
        });
        let partner = partner.max_by(|a, b| a.1.total_cmp(&b.1));
        let values = (unknown.at(low.shares[of]), unknown.at(high.shares[of]));
        Ok(Interval {
            low: values.0,
            high: values.1,
            open_low: low.is_open,
            open_high: high.is_open,
            partner,
        })
    }

    /// One end of an interval. The rise grows about as the square of the distance, which gives the next guess.
    fn end(&self, best: &Best, (of, sign): (usize, f64), slack: f64) -> Result<End, Best> {
        let start = self.shares(&best.values);
        let limit = if sign < 0.0 { 0.0 } else { 1.0 };
        let rise = self.unknowns[of].rise;
        let room = (limit - start[of]).abs();
        let (mut inside, mut near) = (start.clone(), (0.0, 0.0));
        let mut far: Option<(f64, f64)> = None;
        let mut distance = FIRST_STEP.min(room);
        for _ in 0..MOST_STEPS {
            if room < 1e-12 || near.0 >= room {
                return Ok(End { shares: inside, is_open: true });
            }
            let at = start[of] + sign * distance;
            let from = self.better(ahead(&start, &inside, near.0, distance), inside.clone(), of, at);
            let (shares, cost) = self.constrained(&start, &from, of, at);
            if cost < best.cost - slack {
                return Err(Best { values: self.values(&shares), cost });
            }
            let risen = (cost - best.cost).max(0.0);
            if risen > rise {
                far = Some((distance, risen));
            } else {
                (inside, near) = (shares, (distance, risen));
            }
            if far.is_some_and(|far| far.0 - near.0 < PRECISION * far.0) || (risen - rise).abs() < 0.01 * rise
            {
                break;
            }
            distance = next_distance(near, far, rise).min(room);
        }
        if near.0 < room {
            inside[of] = start[of] + sign * distance;
        }
        Ok(End { shares: inside, is_open: false })
    }

    /// The better of two points with one number held.
    fn better(&self, mut a: Vec<f64>, mut b: Vec<f64>, held: usize, at: f64) -> Vec<f64> {
        (a[held], b[held]) = (at, at);
        let cost = |point: &[f64]| (self.cost)(&self.values(point));
        if cost(&b) < cost(&a) { b } else { a }
    }

    /// The least cost with one number held, from a point near it; how far the others are from `best` sets the first
    /// steps.
    fn constrained(&self, best: &[f64], near: &[f64], held: usize, at: f64) -> (Vec<f64>, f64) {
        let mut start = near.to_vec();
        start[held] = at;
        let free: Vec<usize> = (0..self.unknowns.len()).filter(|i| *i != held).collect();
        let steps: Vec<f64> =
            free.iter().map(|i| (0.5 * (near[*i] - best[*i])).abs().max(SMALL_STEP)).collect();
        self.from(&start, &free, &[steps])
    }

    /// Nelder and Mead from a point, with these numbers free, once for each size of the simplex.
    fn from(&self, start: &[f64], free: &[usize], sizes: &[Vec<f64>]) -> (Vec<f64>, f64) {
        let mut at = start.to_vec();
        let mut cost = (self.cost)(&self.values(&at));
        if free.is_empty() {
            return (at, cost);
        }
        for steps in sizes {
            let problem = Free { search: self, start: at.clone(), free };
            if let Some((point, found)) = nelder_mead(problem, steps)
                && found < cost
            {
                for (&i, share) in free.iter().zip(point) {
                    at[i] = share.clamp(0.0, 1.0);
                }
                cost = (self.cost)(&self.values(&at));
            }
        }
        (at, cost)
    }

    fn values(&self, shares: &[f64]) -> Vec<f64> {
        self.unknowns.iter().zip(shares).map(|(unknown, share)| unknown.at(*share)).collect()
    }

    fn shares(&self, values: &[f64]) -> Vec<f64> {
        self.unknowns.iter().zip(values).map(|(unknown, value)| unknown.share(*value)).collect()
    }
}

/// The probable values of the other numbers at a distance from the best, by those at a smaller one.
fn ahead(best: &[f64], inside: &[f64], near: f64, distance: f64) -> Vec<f64> {
    if near <= 0.0 {
        return best.to_vec();
    }
    let ratio = (distance / near).min(10.0);
    best.iter().zip(inside).map(|(best, inside)| (best + ratio * (inside - best)).clamp(0.0, 1.0)).collect()
}

/// The distance at which the rise is probably reached, by the values on this side of it, and beyond it.
fn next_distance(near: (f64, f64), far: Option<(f64, f64)>, rise: f64) -> f64 {
    match far {
        None => near.0 * (rise / near.1.max(1e-9)).sqrt().clamp(1.3, 30.0),
        Some(far) if far.1.is_finite() => {
            let roots = (near.1.sqrt(), rise.sqrt(), far.1.sqrt());
            let share = ((roots.1 - roots.0) / (roots.2 - roots.0)).clamp(0.05, 0.95);
            near.0 + share * (far.0 - near.0)
        }
        Some(far) => 0.5 * (near.0 + far.0),
    }
}

struct End {
    shares: Vec<f64>,
    is_open: bool,
}

/// The numbers that are free, as the optimiser sees them.
struct Free<'a, 'b> {
    search: &'a Search<'b>,
    start: Vec<f64>,
    free: &'a [usize],
}

impl CostFunction for Free<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Beyond the range the cost is that at its edge and more.
    fn cost(&self, point: &Vec<f64>) -> Result<f64, Error> {
        let mut shares = self.start.clone();
        let mut excess = 0.0;
        for (&i, &share) in self.free.iter().zip(point) {
            shares[i] = share.clamp(0.0, 1.0);
            excess += (share - shares[i]).abs();
        }
        let cost = (self.search.cost)(&self.search.values(&shares));
        Ok(if cost.is_nan() { f64::MAX } else { cost.min(f64::MAX / 2.0) + BEYOND * excess })
    }
}

fn nelder_mead(problem: Free<'_, '_>, steps: &[f64]) -> Option<(Vec<f64>, f64)> {
    let start: Vec<f64> = problem.free.iter().map(|i| problem.start[*i]).collect();
    let mut simplex = vec![start.clone()];
    for (i, (share, step)) in start.iter().zip(steps).enumerate() {
        let mut corner = start.clone();
        corner[i] = if share + step > 1.0 { share - step } else { share + step };
        simplex.push(corner);
    }
    let solver = NelderMead::new(simplex).with_sd_tolerance(TOLERANCE).ok()?;
    let most = 60 * start.len() as u64;
    let result =
        Executor::new(problem, solver).configure(|state| state.max_iters(most)).timer(false).run().ok()?;
    let state = result.state();
    Some((state.get_best_param()?.clone(), state.get_best_cost()))
}

/// Sizes of the simplices that a search starts with, one after the other.
const STEPS: [f64; 3] = [0.08, 0.02, 0.003];

/// The least size of a simplex along the way of a number.
const SMALL_STEP: f64 = 0.001;

/// First step of a walk, as a share of the range.
const FIRST_STEP: f64 = 1e-5;

/// The difference to the best cost below which a cost does not count as better.
const SLACK: f64 = 0.01;

/// The number of times that a better best is taken.
const RETRIES: usize = 12;

const MOST_STEPS: usize = 40;

/// The difference of two distances below which the end is known.
const PRECISION: f64 = 0.01;

/// The spread of a simplex's costs at which it stops.
const TOLERANCE: f64 = 1e-3;

/// Cost for each range's length beyond the range.
const BEYOND: f64 = 1e3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_has_its_interval_at_1_96_standard_deviations() {
        let cost = |x: &[f64]| 0.5 * ((x[0] - 3.0) / 0.1).powi(2) + 0.5 * ((x[1] + x[0] - 1.0) / 0.2).powi(2);
        let search = Search {
            unknowns: vec![Unknown::linear(-10.0, 10.0), Unknown::linear(-50.0, 50.0)],
            cost: &cost,
        };
        let mut best = search.best(&[vec![0.0, 0.0]]);
        assert!((best.values[0] - 3.0).abs() < 5e-3 && (best.values[1] + 2.0).abs() < 2e-2, "{best:?}");
        let interval = search.interval(&mut best, 0);
        assert!((interval.low - 2.804).abs() < 6e-3 && (interval.high - 3.196).abs() < 6e-3, "{interval:?}");
        let other = search.interval(&mut best, 1);
        assert!((other.high - other.low - 2.0 * 1.96 * 0.05_f64.sqrt()).abs() < 3e-2, "{other:?}");
    }

    #[test]
    fn numbers_of_which_only_the_product_matters_take_each_other_to_the_ends() {
        let cost = |x: &[f64]| 0.5 * ((x[0] * x[1] - 1.0) / 0.01).powi(2);
        let search = Search { unknowns: vec![Unknown::log(0.1, 10.0), Unknown::log(0.1, 10.0)], cost: &cost };
        let mut best = search.best(&[vec![0.5, 0.5]]);
        let interval = search.interval(&mut best, 0);
        assert!(interval.open_low && interval.open_high, "{interval:?}");
        assert!(interval.partner.is_some_and(|(i, moved)| i == 1 && moved > 0.3), "{interval:?}");
    }
}
