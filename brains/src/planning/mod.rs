//! Ways through a known map: Wahde 2016, §6.2.1.
//!
//! A [`Grid`] divides the plane into square cells, free or blocked. On it these find a path from cell to cell:
//!
//! | function | finds | from |
//! |---|---|---|
//! | [`walk`] | some way, or a dead end | Fig. 6.7, as it is printed |
//! | [`greedy`] | a path, quickly | §6.2.1, with an open list |
//! | [`dijkstra`] | a shortest path | Fig. 6.9 |
//! | [`a_star`] | a shortest path, sooner | named in §6.2.1; Hart, Nilsson and Raphael 1968 |
//! | [`theta_star`] | a path that may turn by any angle | Nash, Daniel, Koenig and Felner 2007 |
//!
//! A [`NodeGraph`] has nodes anywhere, and edges between them, for the same searches: Fig. 6.5, left.
//!
//! A [`CellGrid`] covers the free part of a grid with few large convex cells instead, and finds a path that runs
//! straight on through them: Fig. 6.6.
//!
//! ```
//! use baudbot_brains::planning::{Grid, Heuristic, Moves, a_star};
//! let sketch = Grid::from_text("S.#.\n..#.\n...T")?;
//! let plan = a_star(&sketch.grid, sketch.start?, sketch.target?, Moves::EightNoCut, Heuristic::Octile)?;
//! assert_eq!(plan.cells.len(), 5);
//! assert!((plan.length_m - (3.0 + 2.0_f64.sqrt())).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod best_first;
mod cells;
mod crossing;
mod funnel;
mod grid;
mod heuristic;
mod inflate;
mod moves;
mod nodes;
mod plan;
mod rectangles;
mod scatter;
mod search;
mod sight;
mod text;
mod theta;
mod walker;

#[cfg(test)]
mod tests;

pub use baudbot_geometry::grid::Cell;
pub use cells::{CellGrid, Door, Route};
pub use grid::{Grid, GridError};
pub use heuristic::{Heuristic, Penalised, obstacles};
pub use moves::Moves;
pub use nodes::{NodeGraph, NodeGraphError, NodePlan, NodePlanError};
pub use plan::{End, Plan, PlanError};
pub(crate) use search::cheapest;
pub use search::{a_star, dijkstra, greedy};
pub use sight::line_of_sight;
pub use text::Sketch;
pub use theta::{ThetaStar, theta_star};
pub use walker::walk;
