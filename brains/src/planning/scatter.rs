//! A graph drawn from free space: nodes by a seed, edges between neighbours that see each other.
//!
//! Nodes are centres of free cells, taken in an order that the seed gives: each that is at least the spacing away from all that
//! were taken before, until no cell is left. Two nodes a and b that see each other have an edge unless both see a node c in the disc whose
//! diameter is ab:
//!
//! ```text
//! (a − c) · (b − c) ≤ 0
//! ```
//!
//! In the open, this is the Gabriel graph, a part of the Delaunay triangulation (Gabriel and Sokal 1969). The paths ac and cb are shorter than ab,
//! so a node can be reached over edges exactly if it can be reached along lines of sight. Lines and discs are computed in
//! whole cells, without rounding.
//!
//! Deviations: Section 6.2.1 leaves open how nodes and edges of the left panel of Fig. 6.5 are chosen.

use baudbot_geometry::Vector;
use baudbot_geometry::grid::Cell;

use super::grid::Grid;
use super::nodes::{NodeGraph, NodeGraphError};
use super::sight::line_of_sight;
use crate::chance::Chance;

impl NodeGraph {
    /// More nodes than this are not drawn: each pair is looked at.
    pub const MOST_DRAWN: usize = 1000;

    /// A graph of a grid's free cells, with nodes at least `spacing_m` apart, in metres. The free ones of `first` are nodes in any case, in this
    /// order.
    ///
    /// # Errors
    /// If there would be too many nodes, or none.
    pub fn scattered(grid: &Grid, first: &[Cell], spacing_m: f64, seed: u64) -> Result<Self, NodeGraphError> {
        let cells = places(grid, first, spacing_m, seed)?;
        let edges = edges(grid, &cells);
        Self::new(cells.iter().map(|&cell| grid.center(cell)).collect(), edges)
    }
}

/// The cells of the nodes.
fn places(grid: &Grid, first: &[Cell], spacing_m: f64, seed: u64) -> Result<Vec<Cell>, NodeGraphError> {
    let most = NodeGraph::MOST_DRAWN;
    let (mut is_near, mut nodes) = (vec![false; grid.len()], Vec::<Cell>::new());
    let distinct = first.iter().enumerate().filter(|(i, cell)| !first[..*i].contains(cell));
    let distinct = distinct.map(|(_, &cell)| (cell, true));
    let rest = shuffled(grid, seed).into_iter().map(|cell| (cell, false));
    for (cell, is_first) in distinct.chain(rest) {
        if !grid.is_free(cell) || (is_near[grid.number(cell)] && !is_first) {
            continue;
        }
        if nodes.len() == most {
            return Err(NodeGraphError::Spacing { spacing_m, most });
        }
        nodes.push(cell);
        let reach = Vector::new(spacing_m, spacing_m);
        for other in grid.within(grid.center(cell) - reach, grid.center(cell) + reach) {
            let offset = [other.column - cell.column, other.row - cell.row].map(f64::from);
            let reach = spacing_m / grid.cell_m();
            is_near[grid.number(other)] |= offset[0] * offset[0] + offset[1] * offset[1] < reach * reach;
        }
        // A spacing of less than a cell still leaves no cell to be taken twice.
        is_near[grid.number(cell)] = true;
    }
    Ok(nodes)
}

/// The free cells in an order that the seed gives.
fn shuffled(grid: &Grid, seed: u64) -> Vec<Cell> {
    let mut cells: Vec<_> = grid.cells().filter(|&cell| grid.is_free(cell)).collect();
    let mut chance = Chance::new(seed, "nodes");
    for last in (1..cells.len()).rev() {
        // A number below 1 times a count is below the count, as a grid has fewer cells than 2⁵³.
        cells.swap(last, (chance.uniform() * (last + 1) as f64) as usize);
    }
    cells
}

/// Pairs of nodes that see each other and have none between them.
fn edges(grid: &Grid, nodes: &[Cell]) -> Vec<[usize; 2]> {
    let count = nodes.len();
    let mut sees = vec![false; count * count];
    for (a, b) in pairs(count).filter(|&(a, b)| line_of_sight(grid, nodes[a], nodes[b])) {
        (sees[a * count + b], sees[b * count + a]) = (true, true);
    }
    let is_between = |a: usize, b: usize, c: usize| {
        let offset = |from: Cell, to: Cell| {
            [i64::from(from.column) - i64::from(to.column), i64::from(from.row) - i64::from(to.row)]
        };
        let (to_a, to_b) = (offset(nodes[a], nodes[c]), offset(nodes[b], nodes[c]));
        sees[a * count + c] && sees[b * count + c] && to_a[0] * to_b[0] + to_a[1] * to_b[1] <= 0
    };
    let is_edge = |&(a, b): &(usize, usize)| {
        sees[a * count + b] && !(0..count).any(|c| c != a && c != b && is_between(a, b, c))
    };
    pairs(count).filter(is_edge).map(|(a, b)| [a, b]).collect()
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::planning::{Heuristic, Sketch};

    const TRAP: &str = include_str!("../../tests/data/grid-trap.txt");

    #[test]
    fn nodes_keep_their_distance_and_leave_no_cell_alone() {
        let grid = Grid::from_text(TRAP).unwrap().grid;
        for (seed, spacing_m) in [(1, 2.0), (2, 3.5), (3, 1.0)] {
            let graph = NodeGraph::scattered(&grid, &[], spacing_m, seed).unwrap();
            let nodes = graph.nodes();
            let apart = pairs(nodes.len()).all(|(a, b)| (nodes[a] - nodes[b]).norm() >= spacing_m - 1e-9);
            assert!(apart, "{nodes:?}");
            for cell in grid.cells().filter(|&cell| grid.is_free(cell)) {
                let nearest = nodes[graph.nearest(grid.center(cell))];
                assert!((nearest - grid.center(cell)).norm() < spacing_m + 1e-9 || spacing_m <= 1.0);
            }
        }
        let cells = |seed| NodeGraph::scattered(&grid, &[], 3.0, seed).unwrap();
        assert_eq!(cells(7), cells(7));
        assert_ne!(cells(7), cells(8));
        let error = NodeGraph::scattered(&Grid::new(40, 40, 0.1, grid.origin()).unwrap(), &[], 0.05, 1);
        let text = "a spacing of 0.05 m makes more than 1000 nodes; choose a greater one";
        assert_eq!(error.unwrap_err().to_string(), text);
    }

    #[test]
    fn in_the_open_no_two_edges_cross() {
        let grid = Grid::new(60, 60, 0.1, baudbot_geometry::Point::origin()).unwrap();
        let graph = NodeGraph::scattered(&grid, &[], 0.6, 4).unwrap();
        let at = |node: usize| graph.nodes()[node];
        let side = |[a, b]: [usize; 2], c: usize| {
            let (to_b, to_c) = (at(b) - at(a), at(c) - at(a));
            to_b.x * to_c.y - to_b.y * to_c.x
        };
        let cross = |e: [usize; 2], f: [usize; 2]| {
            side(e, f[0]) * side(e, f[1]) < -1e-9 && side(f, e[0]) * side(f, e[1]) < -1e-9
        };
        let edges = graph.edges();
        let crossings = pairs(edges.len()).filter(|&(e, f)| cross(edges[e], edges[f])).count();
        // Euler: a triangulation of n nodes has fewer than 3n edges, and a tree n − 1.
        let nodes = graph.nodes().len();
        assert!(
            crossings == 0 && (nodes - 1..3 * nodes).contains(&edges.len()),
            "{crossings} {}",
            edges.len()
        );
    }

    proptest! {
        /// Whether a node can be reached is told by flooding along lines of sight, which knows nothing of discs.
        #[test]
        fn edges_lead_wherever_lines_of_sight_do(seed in 0..200_u64, walls in 5..60_usize) {
            let mut chance = Chance::new(seed, "walls");
            let mut grid = Grid::new(16, 16, 1.0, baudbot_geometry::Point::origin()).unwrap();
            for _ in 0..walls {
                let [column, row] = [(); 2].map(|()| (chance.uniform() * 16.0) as i32);
                grid.block(Cell { column, row });
            }
            let cells = places(&grid, &[], 2.5, seed).unwrap();
            let graph = NodeGraph::scattered(&grid, &[], 2.5, seed).unwrap();
            let mut reached = vec![0];
            let mut i = 0;
            while let Some(&from) = reached.get(i) {
                for to in 0..cells.len() {
                    if !reached.contains(&to) && line_of_sight(&grid, cells[from], cells[to]) {
                        reached.push(to);
                    }
                }
                i += 1;
            }
            for to in 0..cells.len() {
                prop_assert_eq!(graph.dijkstra(0, to).is_ok(), reached.contains(&to));
            }
        }
    }

    /// A path over few nodes is not shorter than the straight line, nor much longer than the grid's.
    #[test]
    fn paths_over_nodes_lead_round_walls() {
        let Sketch { grid, start, target } = Grid::from_text(TRAP).unwrap();
        let ends = [start.unwrap(), target.unwrap()];
        for seed in 1..=20 {
            let graph = NodeGraph::scattered(&grid, &ends, 2.0, seed).unwrap();
            let shortest = graph.dijkstra(0, 1).unwrap();
            let sooner = graph.a_star(0, 1, Heuristic::Euclidean).unwrap();
            assert!((shortest.length_m - sooner.length_m).abs() < 1e-9);
            assert!(sooner.expanded.len() <= shortest.expanded.len());
            // Theta* finds 20.2341 m on cells.
            assert!((20.2..27.0).contains(&shortest.length_m), "{seed}: {}", shortest.length_m);
        }
    }
}
