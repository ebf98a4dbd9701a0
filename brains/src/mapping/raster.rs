//! The cells that a straight line goes through.

use baudbot_geometry::Point;

use super::Cell;

/// All cells that the line between two points, in units of a cell's side, goes through, in order and with both ends'
/// cells. Where it goes through a corner, it goes through one of the cells beside it too, so that neighbours in the
/// list have a side in common.
pub(super) fn line(from: Point, to: Point) -> impl Iterator<Item = Cell> {
    let (first, last) = (Cell::at(from), Cell::at(to));
    let way = to - from;
    let mut across = Axis::new(from.x, way.x, first.column);
    let mut up = Axis::new(from.y, way.y, first.row);
    let steps = first.column.abs_diff(last.column) + first.row.abs_diff(last.row);
    let mut cell = first;
    std::iter::once(first).chain((0..steps).map(move |_| {
        // Near the end rounding may ask for a step beyond it.
        let is_across = cell.row == last.row || (cell.column != last.column && across.next <= up.next);
        if is_across {
            cell.column += across.step();
        } else {
            cell.row += up.step();
        }
        cell
    }))
}

/// How a line meets the borders of columns, or of rows.
struct Axis {
    /// The part of the way at which it meets the next one.
    next: f64,
    /// The part from one to the next.
    gap: f64,
    sign: i32,
}

impl Axis {
    fn new(from: f64, way: f64, cell: i32) -> Self {
        let border = if way > 0.0 { f64::from(cell) + 1.0 } else { f64::from(cell) };
        let next = if way == 0.0 { f64::INFINITY } else { (border - from) / way };
        Self { next, gap: 1.0 / way.abs(), sign: if way > 0.0 { 1 } else { -1 } }
    }

    fn step(&mut self) -> i32 {
        self.next += self.gap;
        self.sign
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(from: (f64, f64), to: (f64, f64)) -> Vec<(i32, i32)> {
        let cells = line(Point::new(from.0, from.1), Point::new(to.0, to.1));
        cells.map(|cell| (cell.column, cell.row)).collect()
    }

    #[test]
    fn a_line_goes_through_all_cells_between_its_ends() {
        assert_eq!(cells((0.5, 0.5), (2.5, 1.5)), [(0, 0), (1, 0), (1, 1), (2, 1)]);
        assert_eq!(cells((0.5, 0.5), (-1.5, 0.6)), [(0, 0), (-1, 0), (-2, 0)]);
        assert_eq!(cells((0.2, 0.2), (0.8, 0.9)), [(0, 0)]);
    }

    #[test]
    fn every_line_arrives_and_its_cells_are_neighbours() {
        let mut chance = crate::Chance::new(1, "lines");
        for i in 0..2000 {
            let mut at = || {
                let place = 20.0 * chance.uniform() - 10.0;
                if i % 2 == 0 { place } else { place.round() }
            };
            let (from, to) = (Point::new(at(), at()), Point::new(at(), at()));
            let cells: Vec<_> = line(from, to).collect();
            assert_eq!(cells.last(), Some(&Cell::at(to)), "{from} to {to}");
            for pair in cells.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                assert_eq!(a.column.abs_diff(b.column) + a.row.abs_diff(b.row), 1, "{from} to {to}");
            }
            for cell in cells {
                let center = Point::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
                let off = baudbot_geometry::Segment { start: from, end: to }.distance(center);
                assert!(off <= 0.5_f64.sqrt() + 1e-9, "{from} to {to} is not in {cell:?}");
            }
        }
    }
}
