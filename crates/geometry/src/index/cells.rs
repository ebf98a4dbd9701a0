//! The shapes in each cell.

use alloc::vec;
use alloc::vec::Vec;

use super::Shape;
use super::layout::Layout;
use crate::circle::Circle;
use crate::segment::Segment;

/// The lists of all cells, one behind the other in a single vector.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cells {
    /// The start of each cell's list; one more at the end.
    starts: Vec<u32>,
    /// Numbers of shapes, the circles counted on from the segments. In each cell they ascend.
    entries: Vec<u32>,
    /// The number of segments, which is the number of the first circle.
    segments: u32,
}

impl Cells {
    /// The bytes that they have on the heap.
    pub(super) fn heap_bytes(&self) -> usize {
        (self.starts.capacity() + self.entries.capacity()) * size_of::<u32>()
    }

    pub(super) fn new(layout: &Layout, segments: &[Segment], circles: &[Circle]) -> Self {
        let mut starts = vec![0_u32; layout.columns() * layout.rows() + 1];
        each_entry(layout, segments, circles, |cell, _| starts[cell + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; starts[starts.len() - 1] as usize];
        each_entry(layout, segments, circles, |cell, shape| {
            entries[next[cell] as usize] = shape;
            next[cell] += 1;
        });
        Self { starts, entries, segments: segments.len() as u32 }
    }

    /// The shapes of a cell, in their order.
    #[inline]
    pub(super) fn shapes(&self, cell: usize) -> impl Iterator<Item = Shape> {
        let list = self.starts[cell] as usize..self.starts[cell + 1] as usize;
        self.entries[list].iter().map(|&number| match number.checked_sub(self.segments) {
            None => Shape::Segment(number as usize),
            Some(circle) => Shape::Circle(circle as usize),
        })
    }
}

fn each_entry(layout: &Layout, segments: &[Segment], circles: &[Circle], mut visit: impl FnMut(usize, u32)) {
    for (segment, number) in segments.iter().zip(0..) {
        layout.segment_cells(segment, |cell| visit(cell, number));
    }
    for (circle, number) in circles.iter().zip(segments.len() as u32..) {
        layout.box_cells(circle, |cell| visit(cell, number));
    }
}
