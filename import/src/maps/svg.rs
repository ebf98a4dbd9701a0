//! Plans in SVG.
//!
//! `usvg` resolves styles, transforms, `use` and units; what it gives back are paths. Only outlines and
//! whether they are filled matter here: a style sheet of our own takes strokes, markers, masks and the like
//! out of its hands, so that a shape counts whether it can be seen on paper or not. `display` and
//! `visibility` hide a shape from us, too. Text and images are passed over.

use std::path::Path;
use std::str::FromStr;

use svgtypes::{NumberListParser, PathParser, Transform, ViewBox};
use usvg::roxmltree::{Document, Node, ParsingOptions};
use usvg::{Group, ImageHrefResolver, Options, Tree};

use super::entry::Scale;
use super::outlines::{self, Outline, Placement};
use super::shape::{MAX_SHAPES, Mapped, Shape};
use crate::error::FileError;
use crate::file;

/// The shapes of the drawing, in the order of the file.
pub(crate) fn shapes(path: &Path, scale: &Scale) -> Result<Mapped, FileError> {
    let text = file::text(path)?;
    let shapes = on_a_large_stack(|| drawing(&text, *scale));
    let shapes = shapes.map_err(|problem| FileError::new(path, problem))?;
    Ok(Mapped { shapes, notes: Vec::new() })
}

/// The parser goes down into each element within another, up to 1024 of them, on its thread's stack; those
/// of most threads are too small for that. It is not our code: should it panic, the file is refused.
fn on_a_large_stack<T: Send>(work: impl FnOnce() -> Result<T, String> + Send) -> Result<T, String> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        let thread = thread.map_err(|error| format!("cannot be parsed: no thread for it: {error}"))?;
        thread.join().unwrap_or_else(|_| Err("cannot be parsed: its parser gave up".into()))
    })
}

fn drawing(text: &str, scale: Scale) -> Result<Vec<Shape>, String> {
    let tree = parse(text)?;
    let placement = Placement { scale, height: f64::from(tree.size().height()) };
    let mut paths = Vec::new();
    collect(tree.root(), &mut paths);
    let mut shapes = Vec::new();
    let mut corners = 0;
    for (i, path) in paths.into_iter().enumerate() {
        let of_element = |problem| match path.id() {
            "" => format!("shape {i}, counted from 0, {problem}"),
            id => format!("the shape `{id}` {problem}"),
        };
        let outlines = outlines::of_path(path, &placement).map_err(of_element)?;
        corners += outlines.iter().map(|outline| outline.points.len()).sum::<usize>();
        shapes.extend(self::outlines(path, outlines).map_err(of_element)?);
        if shapes.len() > MAX_SHAPES || corners > MAX_CORNERS {
            return Err(format!(
                "has more than {MAX_SHAPES} shapes or {MAX_CORNERS} corners: raise tolerance_m, or leave details out"
            ));
        }
    }
    Ok(shapes)
}

/// The outlines of a path, solid where it is filled.
fn outlines(path: &usvg::Path, outlines: Vec<Outline>) -> Result<Vec<Shape>, String> {
    let fill = path.fill().filter(|fill| fill.opacity().get() > 0.0);
    if let Some(fill) = fill {
        let closed: Vec<_> = outlines.iter().filter(|outline| outline.closed).collect();
        if let Some(outline) = closed.iter().find(|outline| outline.points.len() < 3) {
            return Err(format!("is filled and has {} corners, needs 3 or more", outline.points.len()));
        }
        if !closed.iter().all(|outline| outline.is_simple()) {
            return Err(
                "crosses or touches itself, so its inside is not defined: break it apart, or do not fill it"
                    .into(),
            );
        }
        if let Some(i) = outlines::hole(&closed, fill.rule())? {
            let [x, y] = closed[i].points[0];
            return Err(format!(
                "has a hole with a corner at ({x}, {y}) m, and a solid polygon has none: break it apart, or do not fill it"
            ));
        }
    }
    let shape = |Outline { points, closed }| Shape { points, solid: closed && fill.is_some(), closed };
    Ok(outlines.into_iter().filter(|outline| outline.points.len() > 1).map(shape).collect())
}

/// The paths that are not hidden.
fn collect<'a>(group: &'a Group, paths: &mut Vec<&'a usvg::Path>) {
    for node in group.children() {
        match node {
            usvg::Node::Group(group) => collect(group, paths),
            usvg::Node::Path(path) if path.is_visible() => paths.push(path),
            usvg::Node::Path(_) | usvg::Node::Image(_) | usvg::Node::Text(_) => {}
        }
    }
}

/// The drawing in its own units, its upper left corner at (0, 0).
fn parse(text: &str) -> Result<Tree, String> {
    let syntax = || ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let parse = |text| Document::parse_with_options(text, syntax());
    let document = parse(text).map_err(|error| format!("is not XML: {error}"))?;
    check(&document)?;
    let unscaled = without_size(text, document.root_element());
    let unscaled = parse(&unscaled).map_err(|error| format!("is not XML: {error}"))?;
    let options = Options {
        style_sheet: Some(STYLE.into()),
        // An image may be any file on this machine.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    Tree::from_xmltree(&unscaled, &options).map_err(|error| format!("is not a valid SVG: {error}"))
}

/// Refuses what the parser would ignore silently.
fn check(document: &Document<'_>) -> Result<(), String> {
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(format!("is not an SVG: its outermost element is `{}`", root.tag_name().name()));
    }
    match root.attribute("viewBox") {
        Some(view_box) => {
            ViewBox::from_str(view_box).map_err(|error| format!("viewBox: {error}"))?;
        }
        None => {
            let is_length =
                |name| root.attribute(name).is_some_and(|length| !length.trim_end().ends_with('%'));
            if !is_length("width") || !is_length("height") {
                return Err(
                    "has neither a viewBox nor width and height: where its lower left corner is, is unknown"
                        .into(),
                );
            }
        }
    }
    for node in document.descendants() {
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if let Err(error) = sound(node.tag_name().name(), attribute.name(), attribute.value()) {
                let line = document.text_pos_at(attribute.range().start).row;
                return Err(format!("line {line}, `{}`: {error}", attribute.name()));
            }
        }
    }
    Ok(())
}

/// Whether the value of an element's attribute can be read to its end.
fn sound(element: &str, attribute: &str, value: &str) -> Result<(), svgtypes::Error> {
    match (element, attribute) {
        ("path", "d") => PathParser::from(value).try_for_each(|segment| segment.map(drop)),
        ("polygon" | "polyline", "points") => {
            NumberListParser::from(value).try_for_each(|number| number.map(drop))
        }
        (_, "transform") if value.trim() != "none" => Transform::from_str(value).map(drop),
        _ => Ok(()),
    }
}

/// The text without the size on paper, if it has a view box: the parser would scale the drawing to it.
fn without_size(text: &str, root: Node<'_, '_>) -> String {
    let mut text = text.to_owned();
    if root.attribute("viewBox").is_some() {
        let is_size = |name| matches!(name, "width" | "height" | "preserveAspectRatio");
        let sizes = root
            .attributes()
            .filter(|attribute| attribute.namespace().is_none() && is_size(attribute.name()));
        let mut ranges: Vec<_> = sizes.map(|attribute| attribute.range()).collect();
        ranges.sort_by_key(|range| std::cmp::Reverse(range.start));
        for range in ranges {
            text.replace_range(range, "");
        }
    }
    text
}

/// Every shape has a stroke, so that none is left out as invisible, and nothing but itself to be drawn.
const STYLE: &str = "* { stroke: black !important; stroke-width: 1 !important; stroke-dasharray: none !important; \
    stroke-opacity: 1 !important; opacity: 1 !important; marker-start: none !important; marker-mid: none !important; \
    marker-end: none !important; clip-path: none !important; mask: none !important; filter: none !important }";

/// Bytes, of which only those that are used are taken from the machine.
const STACK: usize = 256 << 20;

const MAX_NODES: u32 = 4_000_000;

/// Of all shapes of a drawing. Whether one crosses itself takes time in proportion to the square of its corners.
const MAX_CORNERS: usize = 1_000_000;
