//! Blocks of keys and enlargements beside the plan or below it, in columns.

use crate::svg::{Canvas, Element, Place, px};

/// A part of the picture with its upper left corner at the origin.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) canvas: Canvas,
    pub(super) height: f64,
}

/// Width of a block, in pixels.
pub(super) const WIDTH: f64 = 320.0;
/// Space between two blocks, in pixels.
pub(super) const GAP: f64 = 22.0;

/// Puts each block into the column that ends highest so far, and returns the right and the lower end of all of them. A column
/// begins at a place.
pub(super) fn columns(canvas: &mut Canvas, blocks: &[Block], mut columns: Vec<Place>) -> Place {
    let mut size: Place = (0.0, 0.0);
    for block in blocks {
        let Some((x, y)) = columns.iter_mut().reduce(|a, b| if b.1 < a.1 { b } else { a }) else { break };
        canvas.open(Element::group().set("transform", &format!("translate({} {})", px(*x), px(*y))));
        canvas.append(&block.canvas);
        canvas.close("g");
        *y += block.height + GAP;
        size = (size.0.max(*x + WIDTH), size.1.max(*y));
    }
    size
}
