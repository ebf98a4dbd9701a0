//! The graph on which a path through a cell grid is found: points of its doors, joined within cells.

use baudbot_geometry::Point;

use super::best_first::{Graph, Search};
use super::cells::{CellGrid, Door, middle};

/// The graph of a cell grid between two points. Of each door the ends and the middle are nodes, once for each way
/// through it: a node lies in the cell *behind* its door. The start and the target are the last two nodes.
pub(super) struct Crossing {
    /// The cells of the start and of the target, and where in them they are.
    ends: [(usize, Point); 2],
    /// The node of each cell's first door; behind the last cell the node of the start.
    first_nodes: Vec<usize>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    cell: usize,
    point: Point,
}

impl Crossing {
    /// The graph between a start and a target, each in its cell.
    pub(super) fn new(grid: &CellGrid, ends: [(usize, Point); 2]) -> Self {
        let (mut first_nodes, mut nodes) = (Vec::new(), Vec::new());
        for cell in 0..grid.cells().len() {
            first_nodes.push(nodes.len());
            nodes.extend(grid.doors(cell).iter().flat_map(points));
        }
        first_nodes.push(nodes.len());
        nodes.extend(ends.map(|(cell, point)| Node { cell, point }));
        Self { ends, first_nodes, nodes }
    }

    /// The cells of the shortest path in the graph; `None` if there is no path.
    pub(super) fn cells(&self) -> Option<Vec<usize>> {
        let target = self.nodes.len() - 1;
        let mut search = Search::default();
        search.begin(self, self.nodes.len(), target - 1, target);
        let found = search.finish(self)?;
        let mut cells: Vec<usize> = Vec::new();
        for cell in found.path.into_iter().map(|node| self.nodes[node].cell) {
            // A path that is equally short may touch a corner twice, and so come back to a cell: that loop is left
            // out.
            if let Some(before) = cells.iter().position(|&earlier| earlier == cell) {
                cells.truncate(before);
            }
            cells.push(cell);
        }
        Some(cells)
    }
}

/// The nodes of a door.
fn points(door: &Door) -> [Node; 3] {
    [door.side.start, middle(&door.side), door.side.end].map(|point| Node { cell: door.to, point })
}

impl Graph for Crossing {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        let Node { cell, point } = self.nodes[node];
        let target = self.nodes.len() - 1;
        let is_there = self.ends[1].0 == cell;
        let doors = self.first_nodes[cell]..self.first_nodes[cell + 1];
        let nodes = doors.chain(is_there.then_some(target));
        nodes.map(move |next| (next, (self.nodes[next].point - point).norm()))
    }

    fn estimate(&self, _: usize) -> f64 {
        0.0
    }
}
