//! A way that was planned: the cells of the map, those that were looked at, and the way over them. Colours are those of
//! Figs. 6.6, 6.8 and 6.10 of the notes, but for what is blocked, which is grey here.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Point};

use super::block::Block;
use super::key;
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
    key::of_marks(&route.notes, entries(route))
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

const BLOCKED: &str = "#d3d7de";
const LOOKED_AT: &str = "#c3e8bd";
const BORDER: &str = "#c9a400";
const WAY: &str = "#126b2e";
const START: &str = "#ffe24a";
const TARGET: &str = "#ffffff";
