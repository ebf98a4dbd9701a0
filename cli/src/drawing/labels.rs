//! Names where there is room for them. What finds none is left out: all there is has a title, too.

use baudbot_geometry::math;

use super::palette::INK;
use super::view::{Place, drawn, path};
use super::xml::{Canvas, Element};

/// Labels, and what they must not cover.
#[derive(Debug)]
pub(super) struct Labels {
    canvas: Canvas,
    frame: Area,
    taken: Vec<Area>,
    discs: Vec<(Place, f64)>,
    /// How many more labels there may be.
    left: usize,
    /// How many more comparisons the search for places may take.
    effort: usize,
}

/// A rectangle in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub(super) min: Place,
    pub(super) max: Place,
}

/// How a label is written.
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

    /// Writes at the first of these middles where there is room; whether there was.
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

    /// As `put` with a line that leads from `from` to the label; its ways are directions from there.
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

    /// The labels, to be drawn over all else.
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

/// Text with its middle at a place, with a rim of white so that it reads on anything.
pub(super) fn written((x, y): Place, text: &str, style: Style<'_>) -> Element {
    // The baseline is about a third of the size below the middle.
    let at = Element::new("text").number("x", x).number("y", y + 0.35 * style.size);
    let at = at.number("font-size", style.size).set("fill", style.color).set("text-anchor", "middle");
    let at = at.set("stroke", "#ffffff").set("stroke-width", "2.5").set("stroke-linejoin", "round");
    let at = at.set("paint-order", "stroke").set("stroke-opacity", "0.85");
    if style.bold { at.set("font-weight", "600").text(text) } else { at.text(text) }
}

/// About how wide text is, in pixels: fonts differ, and it must do in most of them.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ' ' | '|' | '\'' => 0.36,
        'm' | 'w' | 'M' | 'W' => 0.95,
        c if c.is_ascii_uppercase() => 0.72,
        c if (c as u32) < 0x1100 => 0.61,
        _ => 1.0,
    };
    size * text.chars().map(of).sum::<f64>()
}

/// As much of a text as fits into this width, with a sign that there was more.
pub(crate) fn shortened(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let mut short = String::new();
    for c in text.chars() {
        if width(&short, size) + width("m…", size) > room {
            break;
        }
        short.push(c);
    }
    short + "…"
}

/// A name that fits into this width: its ends tell more than its middle.
pub(crate) fn without_middle(name: &str, size: f64, room: f64) -> String {
    if width(name, size) <= room {
        return name.to_owned();
    }
    let half = shortened(name, size, 0.5 * room);
    let end: String = name.chars().rev().collect();
    let end = shortened(&end, size, 0.5 * room);
    half.trim_end_matches('…').chars().chain(end.chars().rev()).collect()
}

/// A text in lines that fit into this width; at most so many, the last of them shortened.
pub(crate) fn wrapped(text: &str, size: f64, room: f64, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if lines_fit(line, word, size, room) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    if lines.len() > most {
        let rest = lines.split_off(most).join(" ");
        if let Some(last) = lines.last_mut() {
            *last = format!("{last} {rest}");
        }
    }
    lines.iter().map(|line| shortened(line, size, room)).collect()
}

fn lines_fit(line: &str, word: &str, size: f64, room: f64) -> bool {
    width(line, size) + width(" ", size) + width(word, size) <= room
}

/// A name of a thing in the plan.
pub(super) const NAME: Style<'_> = Style { size: 11.0, color: INK, bold: false };

/// More labels than this are no help to anybody, and finding places for them takes time.
const MOST: usize = 250;
/// In a world of many thousands of things a label is a rare luck.
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

    #[test]
    fn long_texts_are_cut_to_the_room_that_there_is() {
        let long = "a description that goes on and on and on and never comes to its end";
        let lines = wrapped(long, 10.0, 100.0, 2);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| width(line, 10.0) <= 100.0) && lines[1].ends_with('…'), "{lines:?}");
        assert_eq!(shortened("short", 10.0, 100.0), "short");
        let name = without_middle("ir_sensor_of_the_left_side_number_7", 10.0, 100.0);
        assert!(name.starts_with("ir_s") && name.contains('…') && name.ends_with("r_7"), "{name}");
    }
}
