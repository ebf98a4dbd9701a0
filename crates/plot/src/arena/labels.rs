//! Names where there is room for them. Others are left out: everything has a tooltip, too.

use baudbot_geometry::math;

use crate::palette::{INK, WHITE};
use crate::svg::{Canvas, Element, Place, drawn, path};
use crate::text::width;

/// Labels, and what they must not cover.
#[derive(Debug)]
pub(super) struct Labels {
    canvas: Canvas,
    frame: Area,
    taken: Vec<Area>,
    discs: Vec<(Place, f64)>,
    /// The number of labels that may follow.
    left: usize,
    /// The number of comparisons that the search for places may still take.
    effort: usize,
}

/// A rectangle in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub(super) min: Place,
    pub(super) max: Place,
}

/// The look of a label.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style<'a> {
    pub(super) size: f64,
    pub(super) color: &'a str,
    pub(super) bold: bool,
}

impl Labels {
    /// No labels, for a window of the picture.
    pub(super) fn new(min: Place, max: Place) -> Self {
        Self {
            canvas: Canvas::default(),
            frame: Area { min, max },
            taken: Vec::new(),
            discs: Vec::new(),
            left: MOST,
            effort: MOST_EFFORT,
        }
    }

    /// Keeps a rectangle free of labels.
    pub(super) fn keep(&mut self, taken: Area) {
        self.taken.push(taken);
    }

    /// Keeps a disc free of labels.
    pub(super) fn keep_disc(&mut self, center: Place, radius: f64) {
        self.discs.push((center, radius));
    }

    /// Writes a label at the first of these middles where there is room, and returns whether there was any.
    pub(super) fn put(
        &mut self,
        text: &str,
        style: Style<'_>,
        middles: impl IntoIterator<Item = Place>,
    ) -> bool {
        if self.left == 0 || text.is_empty() {
            return false;
        }
        let (half_width, half_height) = (0.5 * width(text, style.size) + 1.0, 0.5 * style.size + 1.0);
        for (x, y) in middles {
            self.effort = self.effort.saturating_sub(self.taken.len() + self.discs.len() + 1);
            if self.effort == 0 {
                return false;
            }
            let place =
                Area { min: (x - half_width, y - half_height), max: (x + half_width, y + half_height) };
            if self.is_free(&place) {
                self.taken.push(place);
                self.left -= 1;
                self.canvas.put(written((x, y), text, style));
                return true;
            }
        }
        false
    }

    /// The same as `put`, with a line from a place to the label, about in a direction and at least so many pixels long.
    pub(super) fn put_off(&mut self, text: &str, style: Style<'_>, from: Place, way_rad: f64, least: f64) {
        let half = (0.5 * width(text, style.size) + 4.0, 0.5 * style.size + 2.0);
        let turns = [0.0, 0.2, -0.2, 0.4, -0.4, 0.7, -0.7, 1.0, -1.0];
        let tries = (0..12).flat_map(|i| turns.map(|turn| (least + 9.0 * f64::from(i), way_rad + turn)));
        for (far, way) in tries {
            let (sin, cos) = math::sin_cos(way);
            let end = (from.0 + far * cos, from.1 - far * sin);
            // The line ends at the label's edge, whichever way it comes.
            let middle = (end.0 + half.0 * cos, end.1 - half.1 * sin);
            if self.put(text, style, [middle]) {
                let line = drawn(&path([from, end])).set("stroke", style.color);
                self.canvas.put(line.set("stroke-width", "0.7").set("fill", "none"));
                return;
            }
        }
    }

    /// The labels, to be drawn over everything else.
    pub(super) fn into_canvas(self) -> Canvas {
        self.canvas
    }

    fn is_free(&self, place: &Area) -> bool {
        let inside = place.min.0 >= self.frame.min.0
            && place.min.1 >= self.frame.min.1
            && place.max.0 <= self.frame.max.0
            && place.max.1 <= self.frame.max.1;
        inside
            && !self.taken.iter().any(|other| other.overlaps(place))
            && !self.discs.iter().any(|&(center, radius)| place.meets(center, radius))
    }
}

impl Area {
    fn overlaps(&self, other: &Self) -> bool {
        self.min.0 < other.max.0
            && other.min.0 < self.max.0
            && self.min.1 < other.max.1
            && other.min.1 < self.max.1
    }

    fn meets(&self, (x, y): Place, radius: f64) -> bool {
        let (dx, dy) = (x - x.clamp(self.min.0, self.max.0), y - y.clamp(self.min.1, self.max.1));
        dx * dx + dy * dy < radius * radius
    }
}

/// Text about a place, with a white rim so that it reads on any ground.
pub(super) fn written((x, y): Place, text: &str, style: Style<'_>) -> Element {
    // The baseline is about a third of the size below the middle.
    let at = Element::new("text").number("x", x).number("y", y + 0.35 * style.size);
    let at = at.number("font-size", style.size).set("fill", style.color).set("text-anchor", "middle");
    let at = at.set("stroke", WHITE).set("stroke-width", "2.5").set("stroke-linejoin", "round");
    let at = at.set("paint-order", "stroke").set("stroke-opacity", "0.85");
    if style.bold { at.set("font-weight", "600").text(text) } else { at.text(text) }
}

/// A name of a thing in the plan.
pub(super) const NAME: Style<'_> = Style { size: 11.0, color: INK, bold: false };

/// The most labels: finding places takes time.
const MOST: usize = 250;
/// The most comparisons: a world may have many thousands of things.
const MOST_EFFORT: usize = 20_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_cover_each_other() {
        let mut labels = Labels::new((0.0, 0.0), (200.0, 100.0));
        labels.keep_disc((100.0, 80.0), 10.0);
        let mut put = |x, y| labels.put("name", NAME, [(x, y)]);
        assert!(put(100.0, 50.0));
        assert_eq!([put(110.0, 52.0), put(100.0, 74.0), put(199.0, 50.0)], [false; 3]);
        assert!(put(100.0, 30.0));
    }
}
