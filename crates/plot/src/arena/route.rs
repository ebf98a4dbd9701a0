//! A planned path: the cells, nodes or contours of the map, what the search visited, and the path over them. Colours are those of
//! Figs. 6.6, 6.8 and 6.10 of the notes, but for blocked cells, which are grey here.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Point};

use super::block::Block;
use super::contours::Contour;
use super::key;
use super::view::View;
use crate::palette::{INK, PAPER};
use crate::svg::{Canvas, Element, drawn, px, rectangle};

/// A planned path and the search for it.
#[derive(Clone, Debug, Default)]
pub struct Route {
    /// Cells where the robot cannot be.
    pub blocked: Vec<Bounds>,
    /// Cells that the search visited.
    pub looked_at: Vec<Bounds>,
    /// Large convex cells, if the path leads through such.
    pub cells: Vec<Bounds>,
    /// Nodes of an irregular grid.
    pub nodes: Vec<Point>,
    /// Its edges.
    pub edges: Vec<[Point; 2]>,
    /// The nodes that the search visited.
    pub nodes_looked_at: Vec<Point>,
    /// Contours of a potential field, from low to high.
    pub contours: Vec<Contour>,
    /// The start's cell.
    pub start: Option<Bounds>,
    /// The target's cell.
    pub target: Option<Bounds>,
    /// The path.
    pub path: Vec<Point>,
    /// The lines of the key.
    pub notes: Vec<String>,
}

/// Draws the cells on the floor.
pub(super) fn draw_cells(canvas: &mut Canvas, view: &View, route: &Route) {
    canvas.put(drawn(&boxes(view, &route.blocked)).set("fill", BLOCKED).set("class", "blocked"));
    canvas.put(drawn(&boxes(view, &route.looked_at)).set("fill", LOOKED_AT).set("class", "looked-at"));
    let cells = drawn(&boxes(view, &route.cells)).set("fill", "none").set("stroke", BORDER);
    canvas.put(cells.set("stroke-width", "1.6").set("class", "cells"));
    for (i, contour) in route.contours.iter().enumerate() {
        let line: String = contour.iter().map(|piece| view.line(piece.iter().copied())).collect();
        let share = (i + 1) as f64 / route.contours.len() as f64;
        let line = drawn(&line).set("fill", "none").set("stroke", CONTOUR).set("stroke-width", "1");
        canvas.put(line.number("opacity", 0.2 + 0.8 * share).set("class", "contour"));
    }
    draw_nodes(canvas, view, route);
    for (cell, color, title) in [(route.start, START, "start"), (route.target, TARGET, "target")] {
        if let Some(cell) = cell {
            let square = drawn(&boxes(view, &[cell])).set("fill", color).set("stroke", INK);
            canvas.put(square.set("stroke-width", "0.6").titled(title));
        }
    }
}

/// Draws an irregular grid.
fn draw_nodes(canvas: &mut Canvas, view: &View, route: &Route) {
    let edges: String = route.edges.iter().map(|edge| view.line(edge.iter().copied())).collect();
    if !edges.is_empty() {
        let lines = drawn(&edges).set("fill", "none").set("stroke", BORDER).set("stroke-width", "0.8");
        canvas.put(lines.set("class", "edges"));
    }
    for (nodes, color) in [(&route.nodes, PAPER), (&route.nodes_looked_at, LOOKED_AT)] {
        for &node in nodes {
            let (x, y) = view.at(node);
            let dot = Element::new("circle").number("cx", x).number("cy", y).number("r", 3.0);
            canvas.put(dot.set("fill", color).set("stroke", BORDER).set("stroke-width", "0.8"));
        }
    }
}

/// Draws the path, over everything else.
pub(super) fn draw_path(canvas: &mut Canvas, view: &View, route: &Route) {
    let line = drawn(&view.line(route.path.iter().copied())).set("fill", "none").set("stroke", WAY);
    canvas.put(line.set("stroke-width", "2.4").set("stroke-linejoin", "round").set("class", "way"));
    if let [first, .., last] = route.path.as_slice() {
        for (point, color) in [(first, START), (last, TARGET)] {
            let (x, y) = view.at(*point);
            let dot = Element::new("circle").number("cx", x).number("cy", y).number("r", 4.0);
            canvas.put(dot.set("fill", color).set("stroke", WAY).set("stroke-width", "1.4"));
        }
    }
}

/// The key.
pub(super) fn key(route: &Route) -> Block {
    key::of_marks(&route.notes, entries(route))
}

fn entries(route: &Route) -> Vec<(Element, &'static str)> {
    let tile = |fill: &str, stroke: &str| {
        rectangle((0.5, 0.0), (15.0, 10.0)).set("fill", fill).set("stroke", stroke)
    };
    let path = drawn("M0 5H16").set("stroke", WAY).set("stroke-width", "2.4");
    let contour = drawn("M0 5H16").set("stroke", CONTOUR).set("stroke-width", "1");
    let all = [
        (!route.path.is_empty(), path, "the path"),
        (route.start.is_some(), tile(START, INK), "the start"),
        (route.target.is_some(), tile(TARGET, INK), "the target"),
        (!route.looked_at.is_empty(), tile(LOOKED_AT, "none"), "cells that were looked at"),
        (!route.contours.is_empty(), contour, "contours of the field, darker where it is higher"),
        (!route.nodes.is_empty(), tile(PAPER, BORDER), "nodes, with their edges"),
        (!route.nodes_looked_at.is_empty(), tile(LOOKED_AT, BORDER), "nodes that were looked at"),
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
const CONTOUR: &str = "#7a3fa0";
const BORDER: &str = "#c9a400";
const WAY: &str = "#126b2e";
const START: &str = "#ffe24a";
const TARGET: &str = "#ffffff";
