//! Pheromone trails: fields that robots write to (Section 4.4.2).
//!
//! The concentration c, an amount for each square metre, on a grid of square cells:
//!
//! ```text
//! ∂c/∂t = D ∇²c − c / τ + Σ rate(robot) δ(p − p(robot))
//! ```
//!
//! A tick spreads by steps of Euler's method on the five-point stencil, so many that none moves more than a quarter of a cell's content to a neighbour:
//! no cell becomes negative, and a puff's variance grows by exactly 2 D t along each axis. Nothing crosses the grid's border. Then all fades by exp(−Δt / τ), and the robots
//! add what they lay down in the tick, at the places where it ends. Both what is laid and what is read are shared among the four cells around by bilinear weights.
//!
//! Deviations. The notes describe trails and compute nothing. Walls do not hold the scent back, and there is no wind.

use alloc::vec::Vec;

use baudbot_geometry::{Point, math};

/// The grid of a field that robots write to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailGrid {
    /// The corner of least x and y.
    pub corner: Point,
    /// Side of a cell, in metres.
    pub cell_m: f64,
    /// The number of cells along x and along y, each at least 1.
    pub cells: [usize; 2],
    /// Time in which a trail fades to 1/e, in seconds; `None`: it stays.
    pub decay_s: Option<f64>,
    /// Diffusion coefficient, in m²/s.
    pub diffusion_m2_s: f64,
}

impl TrailGrid {
    /// The number of Euler's steps in so many seconds.
    pub fn steps(&self, dt_s: f64) -> f64 {
        math::ceil(4.0 * self.diffusion_m2_s * dt_s / (self.cell_m * self.cell_m))
    }

    pub(crate) fn count(&self) -> usize {
        self.cells[0] * self.cells[1]
    }

    /// The four cells around a point with their weights, which are 1 together; `None` beyond the grid.
    fn around(&self, point: Point) -> Option<[(usize, f64); 4]> {
        let [columns, rows] = self.cells;
        let along = |at: f64, count: usize| {
            let at = at / self.cell_m;
            if !(0.0..=count as f64).contains(&at) {
                return None;
            }
            let from_center = (at - 0.5).clamp(0.0, (count - 1) as f64);
            let low = (from_center as usize).min(count.saturating_sub(2));
            Some((low, (low + 1).min(count - 1), from_center - low as f64))
        };
        let (left, right, x) = along(point.x - self.corner.x, columns)?;
        let (below, above, y) = along(point.y - self.corner.y, rows)?;
        let cell = |column, row: usize| row * columns + column;
        Some([
            (cell(left, below), (1.0 - x) * (1.0 - y)),
            (cell(right, below), x * (1.0 - y)),
            (cell(left, above), (1.0 - x) * y),
            (cell(right, above), x * y),
        ])
    }

    /// The concentration at a point; 0 beyond the grid.
    pub(crate) fn at(&self, cells: &[f64], point: Point) -> f64 {
        let value = |(cell, weight): (usize, f64)| weight * cells.get(cell).copied().unwrap_or(0.0);
        self.around(point).map_or(0.0, |around| around.into_iter().map(value).sum())
    }

    /// Spreads and fades for so many seconds. `rows` is memory that has been used before.
    pub(crate) fn pass(&self, cells: &mut [f64], dt_s: f64, rows: &mut [Vec<f64>; 2]) {
        let steps = self.steps(dt_s);
        if steps > 0.0 {
            let share = self.diffusion_m2_s * dt_s / (steps * self.cell_m * self.cell_m);
            (0..steps as u32).for_each(|_| self.spread(cells, share, rows));
        }
        if let Some(decay_s) = self.decay_s {
            let left = math::exp(-dt_s / decay_s);
            cells.iter_mut().for_each(|cell| *cell *= left);
        }
    }

    /// Each cell gives this share of its content to each of its neighbours.
    fn spread(&self, cells: &mut [f64], share: f64, [below, here]: &mut [Vec<f64>; 2]) {
        let [columns, rows] = self.cells;
        copy(below, &cells[..columns]);
        for row in 0..rows {
            let first = row * columns;
            copy(here, &cells[first..first + columns]);
            for column in 0..columns {
                let own = here[column];
                let above = if row + 1 < rows { cells[first + columns + column] } else { own };
                let left = here[column.saturating_sub(1)];
                let right = here[(column + 1).min(columns - 1)];
                let differences = (left - own) + (right - own) + (above - own) + (below[column] - own);
                cells[first + column] = own + share * differences;
            }
            core::mem::swap(below, here);
        }
    }

    pub(crate) fn lay(&self, cells: &mut [f64], point: Point, amount: f64) {
        let per_m2 = amount / (self.cell_m * self.cell_m);
        for (cell, weight) in self.around(point).into_iter().flatten() {
            cells[cell] += weight * per_m2;
        }
    }
}

fn copy(row: &mut Vec<f64>, cells: &[f64]) {
    row.clear();
    row.extend_from_slice(cells);
}

/// The trails of a world: the cells of each field, row by row, none for fields without a grid.
pub(crate) type Trails = Vec<Vec<f64>>;

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    const GRID: TrailGrid = TrailGrid {
        corner: Point::new(-1.0, -0.5),
        cell_m: 0.05,
        cells: [40, 20],
        decay_s: None,
        diffusion_m2_s: 0.0,
    };

    fn mass(grid: &TrailGrid, cells: &[f64]) -> f64 {
        cells.iter().sum::<f64>() * grid.cell_m * grid.cell_m
    }

    #[test]
    fn what_is_laid_is_there_and_nothing_beyond_the_grid() {
        let mut cells = vec![0.0; GRID.count()];
        for point in
            [Point::new(0.013, 0.021), Point::new(-1.0, -0.5), Point::new(1.0, 0.5), Point::new(1.01, 0.0)]
        {
            GRID.lay(&mut cells, point, 2.0);
        }
        assert!((mass(&GRID, &cells) - 6.0).abs() < 1e-12);
        assert!(GRID.at(&cells, Point::new(0.013, 0.021)) > 100.0);
        assert_eq!(GRID.at(&cells, Point::new(1.2, 0.0)), 0.0);
    }

    /// ∂c/∂t = D ∇²c from a point: the variance along each axis is 2 D t; and what the border holds back stays.
    #[test]
    fn a_puff_spreads_by_2_d_t_and_loses_nothing_but_by_fading() {
        let grid = TrailGrid { diffusion_m2_s: 0.002, decay_s: Some(20.0), ..GRID };
        let mut cells = vec![0.0; grid.count()];
        let mut rows = Default::default();
        let from = Point::new(0.025, 0.025);
        grid.lay(&mut cells, from, 1.0);
        for tick in 1..=400 {
            grid.pass(&mut cells, 0.01, &mut rows);
            let time_s = f64::from(tick) * 0.01;
            assert!((mass(&grid, &cells) - math::exp(-time_s / 20.0)).abs() < 1e-12);
            assert!(cells.iter().all(|cell| *cell >= 0.0));
        }
        let total: f64 = cells.iter().sum();
        let second = cells.iter().enumerate().map(|(place, cell)| {
            let x = -1.0 + (0.5 + (place % 40) as f64) * 0.05 - from.x;
            cell * x * x
        });
        let variance = second.sum::<f64>() / total;
        assert!((variance - 2.0 * 0.002 * 4.0).abs() < 1e-6, "{variance}");
    }

    #[test]
    fn reading_between_cells_is_linear() {
        let mut cells = vec![0.0; GRID.count()];
        for (place, cell) in cells.iter_mut().enumerate() {
            *cell = 3.0 * ((place % 40) as f64 + 0.5) * 0.05 - 2.0 * ((place / 40) as f64 + 0.5) * 0.05;
        }
        let read = GRID.at(&cells, Point::new(-0.47, 0.11));
        assert!((read - (3.0 * 0.53 - 2.0 * 0.61)).abs() < 1e-12, "{read}");
    }
}
