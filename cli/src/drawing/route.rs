//! A way that was planned: the cells of the map, those that were looked at, and the way over them. Colours are those of
//! Figs. 6.6, 6.8 and 6.10 of the notes, but for what is blocked, which is grey here.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Point};

use super::block::{Block, WIDTH};
use super::labels::wrapped;
use super::palette::{INK, PAPER};
use super::view::{View, drawn, rectangle};
use super::xml::{Canvas, Element, px};

/// What is drawn of a way and of the search for it.
pub(crate) struct Route {
    /// Where the robot cannot be, as boxes.
    pub(crate) blocked: Vec<Bounds>,
    /// Cells that were looked at, as boxes.
    pub(crate) looked_at: Vec<Bounds>,
    /// Large convex cells, if it is these that the way leads through.
    pub(crate) cells: Vec<Bounds>,
    /// The start's cell.
    pub(crate) start: Option<Bounds>,
    /// The target's cell.
    pub(crate) target: Option<Bounds>,
    /// The way.
    pub(crate) way: Vec<Point>,
    /// What the key says of it, line by line.
    pub(crate) notes: Vec<String>,
}

/// What lies on the floor: cells.
pub(super) fn draw_cells(canvas: &mut Canvas, view: &View, route: &Route) {
    canvas.put(drawn(&boxes(view, &route.blocked)).set("fill", BLOCKED).set("class", "blocked"));
    canvas.put(drawn(&boxes(view, &route.looked_at)).set("fill", LOOKED_AT).set("class", "looked-at"));
    let cells = drawn(&boxes(view, &route.cells)).set("fill", "none").set("stroke", BORDER);
    canvas.put(cells.set("stroke-width", "1.6").set("class", "cells"));
    for (cell, color, title) in [(route.start, START, "start"), (route.target, TARGET, "target")] {
        if let Some(cell) = cell {
            let square = drawn(&boxes(view, &[cell])).set("fill", color).set("stroke", INK);
            canvas.put(square.set("stroke-width", "0.6").titled(title));
        }
    }
}

/// The way over all else.
pub(super) fn draw_way(canvas: &mut Canvas, view: &View, route: &Route) {
    let line = drawn(&view.line(route.way.iter().copied())).set("fill", "none").set("stroke", WAY);
    canvas.put(line.set("stroke-width", "2.4").set("stroke-linejoin", "round").set("class", "way"));
    if let [first, .., last] = route.way.as_slice() {
        for (point, color) in [(first, START), (last, TARGET)] {
            let (x, y) = view.at(*point);
            let dot = Element::new("circle").number("cx", x).number("cy", y).number("r", 4.0);
            canvas.put(dot.set("fill", color).set("stroke", WAY).set("stroke-width", "1.4"));
        }
    }
}

/// What it means.
pub(super) fn key(route: &Route) -> Block {
    let mut canvas = Canvas::default();
    let mut y = 12.0;
    for (i, note) in route.notes.iter().enumerate() {
        for line in wrapped(note, SIZE + 1.0, WIDTH, 2) {
            let text = text((0.0, y), &line);
            canvas.put(if i == 0 { text.set("font-weight", "600") } else { text });
            y += LINE + 1.0;
        }
    }
    y += 4.0;
    for (mark, what) in entries(route) {
        canvas.put(mark.set("transform", &format!("translate(0 {})", px(y - 9.0))));
        canvas.put(text((22.0, y), what));
        y += LINE + 2.0;
    }
    Block { canvas, height: y - 8.0 }
}

fn entries(route: &Route) -> Vec<(Element, &'static str)> {
    let tile = |fill: &str, stroke: &str| {
        rectangle((0.5, 0.0), (15.0, 10.0)).set("fill", fill).set("stroke", stroke)
    };
    let way = drawn("M0 5H16").set("stroke", WAY).set("stroke-width", "2.4");
    let all = [
        (!route.way.is_empty(), way, "the way"),
        (route.start.is_some(), tile(START, INK), "the start"),
        (route.target.is_some(), tile(TARGET, INK), "the target"),
        (!route.looked_at.is_empty(), tile(LOOKED_AT, "none"), "cells that were looked at"),
        (!route.cells.is_empty(), tile(PAPER, BORDER), "convex cells"),
        (!route.blocked.is_empty(), tile(BLOCKED, "none"), "too near to a wall for the robot's middle"),
    ];
    all.into_iter().filter(|(is, ..)| *is).map(|(_, mark, what)| (mark, what)).collect()
}

/// Boxes as the data of one path.
fn boxes(view: &View, boxes: &[Bounds]) -> String {
    let mut data = String::new();
    for bounds in boxes {
        let (x, y) = view.at(Point::new(bounds.min.x, bounds.max.y));
        let (width, height) = (px(view.length(bounds.size().x)), px(view.length(bounds.size().y)));
        let _ = write!(data, "M{} {}h{width}v{height}h-{width}z", px(x), px(y));
    }
    data
}

fn text((x, y): (f64, f64), text: &str) -> Element {
    let at = Element::new("text").number("x", x).number("y", y).number("font-size", SIZE);
    at.set("fill", INK).text(text)
}

/// Of letters.
const SIZE: f64 = 11.0;
/// From one line to the next.
const LINE: f64 = 15.0;

const BLOCKED: &str = "#d3d7de";
const LOOKED_AT: &str = "#c3e8bd";
const BORDER: &str = "#c9a400";
const WAY: &str = "#126b2e";
const START: &str = "#ffe24a";
const TARGET: &str = "#ffffff";
