//! A colony of *E. coli* in a dish: Wahde 2016, Fig. 4.2.
//!
//! ```sh
//! cargo run -p baudbot-brains --example colony
//! ```
//!
//! The attractant has a Gaussian peak in the middle of a square, at whose sides cells are held. A cell moves all the
//! time: straight on while it swims, and while it tumbles along headings that are drawn again and again.
//!
//! The notes give 100 cells, a = b = 1, T = 0, 10 s and steps of 0.01 s. Speed, width, dish and tumbling are ours,
//! so the figures that the tests compare with are those of this completion.
//!
//! Deviations: the notes say that tumbling keeps a cell nearly in its place. Here it takes the cell a little way,
//! for if it did not, U would stay 0 after it had become 0, and all cells would stand still for ever. And headings
//! are drawn at a rate and not in each step, so that shorter steps do not change the model; in steps of 0.01 s it
//! is the same.

use std::f64::consts::TAU;

use baudbot_brains::Chance;
use baudbot_brains::animals::ecoli::{Behaviour, EColi, Parameters as CellParameters};
use baudbot_geometry::{Direction, Point, math};

fn main() {
    let mut colony = Colony::new(Parameters::default(), CELLS, Chance::new(1, "colony"));
    println!("time [s]  mean distance to the peak [m]  part that swims");
    for second in 0..=10 {
        let swimming: usize = if second == 0 { 0 } else { (0..100).map(|_| colony.step(0.01)).sum() };
        println!(
            "{second:>8}  {:>29.3}  {:>15.2}",
            colony.mean_distance_m(),
            swimming as f64 / (100 * CELLS) as f64
        );
    }
}

/// The number of cells in the figure.
const CELLS: usize = 100;

/// A dish and its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parameters {
    /// The parameters of each cell.
    cell: CellParameters,
    /// The dish goes from minus this to plus this in x and y.
    half_side_m: f64,
    /// σ of the attractant exp(−r²/2σ²).
    width_m: f64,
    /// The speeds of a cell that swims, and of one that tumbles.
    speed_m_s: f64,
    /// The rate at which a cell that tumbles takes a new heading, per second.
    tumble_hz: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let cell = CellParameters::default();
        Self { cell, half_side_m: 1.0, width_m: 0.5, speed_m_s: 0.5, tumble_hz: 100.0 }
    }
}

/// Cells in a dish.
#[derive(Clone, Debug, PartialEq)]
struct Colony {
    parameters: Parameters,
    cells: Vec<Cell>,
    chance: Chance,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    position: Point,
    heading: Direction,
    brain: EColi,
}

impl Colony {
    /// Cells all over the dish, at random, each of which remembers the concentration where it is.
    fn new(parameters: Parameters, cells: usize, mut chance: Chance) -> Self {
        let cell = |_| {
            let mut coordinate = || parameters.half_side_m * (2.0 * chance.uniform() - 1.0);
            let position = Point::new(coordinate(), coordinate());
            let heading = Direction::from_angle(TAU * chance.uniform());
            let brain = EColi::new(parameters.cell, parameters.concentration(position));
            Cell { position, heading, brain }
        };
        let cells = (0..cells).map(cell).collect();
        Self { parameters, cells, chance }
    }

    /// All cells live on for `dt_s` seconds. Returns how many of them swim.
    fn step(&mut self, dt_s: f64) -> usize {
        self.step_as(dt_s, |brain, concentration, _| brain.step(concentration, dt_s))
    }

    /// The cells' positions.
    fn positions(&self) -> impl ExactSizeIterator<Item = Point> {
        self.cells.iter().map(|cell| cell.position)
    }

    /// The cells' mean distance from the peak, in metres.
    fn mean_distance_m(&self) -> f64 {
        self.positions().map(|position| position.coords.norm()).sum::<f64>() / self.cells.len() as f64
    }

    fn step_as(&mut self, dt_s: f64, choose: impl Fn(&mut EColi, f64, &mut Chance) -> Behaviour) -> usize {
        let p = self.parameters;
        let mut swimming = 0;
        for cell in &mut self.cells {
            match choose(&mut cell.brain, p.concentration(cell.position), &mut self.chance) {
                Behaviour::Swim => swimming += 1,
                Behaviour::Tumble if self.chance.happens(p.tumble_hz * dt_s) => {
                    cell.heading = Direction::from_angle(TAU * self.chance.uniform());
                }
                Behaviour::Tumble => {}
            }
            let position = cell.position + cell.heading.vector() * (p.speed_m_s * dt_s);
            let held = |m: f64| m.clamp(-p.half_side_m, p.half_side_m);
            cell.position = Point::new(held(position.x), held(position.y));
        }
        swimming
    }
}

impl Parameters {
    fn concentration(&self, position: Point) -> f64 {
        math::exp(-0.5 * position.coords.norm_squared() / (self.width_m * self.width_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: usize = 1000;

    /// The state of a colony after 10 s.
    struct Outcome {
        /// Mean distance to the peak, after and before.
        ratio: f64,
        within_sigma: f64,
        swimming: f64,
    }

    fn run(seed: u64, choose: impl Fn(&mut EColi, f64, &mut Chance) -> Behaviour) -> Outcome {
        let mut colony = Colony::new(Parameters::default(), CELLS, Chance::new(seed, "colony"));
        let before = colony.mean_distance_m();
        let swum: usize = (0..STEPS).map(|_| colony.step_as(0.01, &choose)).sum();
        let within = colony.positions().filter(|position| position.coords.norm() < 0.5).count();
        Outcome {
            ratio: colony.mean_distance_m() / before,
            within_sigma: within as f64 / CELLS as f64,
            swimming: swum as f64 / (STEPS * CELLS) as f64,
        }
    }

    fn mean(outcomes: &[Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
        outcomes.iter().map(of).sum::<f64>() / outcomes.len() as f64
    }

    /// The ratio was 0.163 ± 0.011 in 300 colonies that were computed independently, and 0.792 of the time was swum.
    #[test]
    fn cells_gather_at_the_peak_as_in_figure_4_2() {
        let outcomes: Vec<_> = (0..30).map(|seed| run(seed, |brain, x, _| brain.step(x, 0.01))).collect();
        for Outcome { ratio, within_sigma, swimming } in &outcomes {
            assert!((0.13..0.20).contains(ratio), "{ratio}");
            assert!(*within_sigma >= 0.96, "{within_sigma}");
            assert!((0.75..0.83).contains(swimming), "{swimming}");
        }
        let ratio = mean(&outcomes, |outcome| outcome.ratio);
        // Four standard errors.
        assert!((ratio - 0.163).abs() < 4.0 * 0.011 / 30.0_f64.sqrt(), "{ratio}");
        let swimming = mean(&outcomes, |outcome| outcome.swimming);
        assert!((swimming - 0.792).abs() < 0.01, "{swimming}");
    }

    #[test]
    fn cells_that_toss_a_coin_do_not_gather() {
        let coin = |_: &mut EColi, _, chance: &mut Chance| {
            if chance.happens(0.5) { Behaviour::Swim } else { Behaviour::Tumble }
        };
        let outcomes: Vec<_> = (0..10).map(|seed| run(seed, coin)).collect();
        let (ratio, within) = (mean(&outcomes, |o| o.ratio), mean(&outcomes, |o| o.within_sigma));
        assert!((ratio - 1.0).abs() < 0.04 && (within - 0.195).abs() < 0.05, "{ratio} {within}");
    }

    #[test]
    fn cells_that_swim_when_it_gets_worse_disperse() {
        let contrary = |brain: &mut EColi, x, _: &mut Chance| match brain.step(x, 0.01) {
            Behaviour::Swim => Behaviour::Tumble,
            Behaviour::Tumble => Behaviour::Swim,
        };
        let outcomes: Vec<_> = (0..10).map(|seed| run(seed, contrary)).collect();
        let ratio = mean(&outcomes, |outcome| outcome.ratio);
        assert!((ratio - 1.800).abs() < 4.0 * 0.063 / 10.0_f64.sqrt(), "{ratio}");
    }

    #[test]
    fn cells_start_all_over_the_dish() {
        let colony = Colony::new(Parameters::default(), 100_000, Chance::new(1, "colony"));
        let mean = colony.positions().map(|position| position.coords.norm()).sum::<f64>() / 1e5;
        let exact = (2.0_f64.sqrt() + 1.0_f64.asinh()) / 3.0;
        assert!((mean - exact).abs() < 0.005, "{mean} {exact}");
    }
}
