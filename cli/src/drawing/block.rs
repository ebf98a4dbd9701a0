//! What stands beside the plan or below it, in columns.

use super::view::Place;
use super::xml::{Canvas, Element, px};

/// A part of the picture with its upper left corner at the origin.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) canvas: Canvas,
    pub(super) height: f64,
}

/// Width of each.
pub(super) const WIDTH: f64 = 320.0;
/// Between two.
pub(super) const GAP: f64 = 22.0;

/// Puts blocks into columns, each into the one that is shortest so far; how high the highest gets.
pub(super) fn columns(canvas: &mut Canvas, blocks: &[Block], (left, top): Place, columns: usize) -> f64 {
    let mut heights = vec![0.0; columns.max(1)];
    for block in blocks {
        let shortest = (0..heights.len()).reduce(|a, b| if heights[b] < heights[a] { b } else { a });
        let i = shortest.unwrap_or(0);
        let (x, y) = (left + i as f64 * (WIDTH + GAP), top + heights[i]);
        canvas.open(Element::group().set("transform", &format!("translate({} {})", px(x), px(y))));
        canvas.append(&block.canvas);
        canvas.close("g");
        heights[i] += block.height + GAP;
    }
    heights.into_iter().fold(0.0, f64::max)
}
